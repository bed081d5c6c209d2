//! The shell's paint: two-tone lacquer, crown stripe, panel joints, rivets, lettering, wear and dirt.

use crate::bake::{Paint, Texel};
use crate::form::{CREST, visor_extent};
use crate::marks::{Ink, shell_marks, slots};
use crate::noise::{fbm, mix, perlin, smoothstep, worley};
use glam::Vec3;

/// The lacquers, linear.
const WHITE: Vec3 = Vec3::new(0.74, 0.715, 0.66);
const RED: Vec3 = Vec3::new(0.60, 0.055, 0.012);
const GRAPHITE: Vec3 = Vec3::new(0.044, 0.048, 0.055);
const PRIMER: Vec3 = Vec3::new(0.20, 0.185, 0.15);
const STEEL: Vec3 = Vec3::new(0.52, 0.51, 0.49);

/// Distances (metres) of a place to the shell's lines; signed where a side matters.
struct Lines {
    /// Above the line that parts white from graphite.
    jaw: f32,
    /// Outside the crown stripe's foot.
    crest: f32,
    /// Outside the visor's frame.
    frame: f32,
    /// To the nearest panel joint.
    joint: f32,
    /// To the nearest rivet's centre.
    rivet: f32,
    /// To the nearest air slot; negative inside.
    slot: f32,
}

/// Distance to the nearest of rivets every `pitch` metres along a line, `off` metres beside it.
fn rivets(along: f32, across: f32, pitch: f32, off: f32) -> f32 {
    let a = along - (along / pitch).round() * pitch;
    (a * a + (across - off) * (across - off)).sqrt()
}

fn lines(p: Vec3) -> Lines {
    let r = p.length();
    let d = p / r;
    let jaw = (p.y + 0.047 - 0.16 * (-p.z - 0.02).max(0.0)) / 1.05;
    // The stripe belongs to the crown and the nape: not to the chin.
    let chin = p.z > 0.0 && p.y < 0.0;
    let crest = if chin { 1.0 } else { d.x.abs() * r - CREST[1] * r };
    let frame = (visor_extent(d) - 1.0) * 0.070 - 0.0165;
    // The crown's joint: a plane behind the ears, down to the jaw line; the temple's joint: a slanting plane.
    let crown = p.z + 0.052;
    let temple = (p.y - 0.055 + 0.25 * p.z) / 1.03;
    let above = jaw > 0.0 && crest > 0.0;
    let mut joint = jaw.abs();
    let mut rivet = 1.0f32;
    if above {
        joint = joint.min(crown.abs());
        rivet = rivet.min(rivets(p.y.atan2(p.x.abs()) * 0.13, crown, 0.0185, -0.0065));
        if crown < 0.0 {
            joint = joint.min(temple.abs());
            rivet = rivet.min(rivets(p.z, temple, 0.0185, -0.0065));
        }
    }
    let back = p.z < 0.02;
    if back && crest > -0.002 {
        rivet = rivet.min(rivets(p.x.abs().atan2(-p.z) * 0.135, jaw, 0.020, -0.0075));
    }
    Lines { jaw, crest, frame, joint, rivet, slot: slots(p) }
}

/// Paints a place of the shell.
pub fn shell_paint(t: &Texel) -> Paint {
    let p = t.pos;
    let l = lines(p);
    let broad = fbm(p * 22.0, 4, 11);
    let fine = fbm(p * 160.0, 3, 12);
    let grain = perlin(p * 900.0, 13);

    // Lacquer.
    let on_crest = smoothstep(0.0006, -0.0006, l.crest + 0.0045);
    let pin = smoothstep(0.0014, 0.0008, (l.crest - 0.0035).abs());
    let below = smoothstep(0.0004, -0.0004, l.jaw);
    let mut base = WHITE * (1.0 + 0.035 * broad);
    base = base.lerp(GRAPHITE, pin * (1.0 - below));
    base = base.lerp(RED * (1.0 + 0.06 * broad), on_crest);
    base = base.lerp(GRAPHITE * (1.0 + 0.15 * broad), below * (1.0 - on_crest));
    let stripe = smoothstep(0.0019, 0.0013, (l.jaw - 0.0065).abs()) * (1.0 - on_crest);
    base = base.lerp(RED, stripe);
    let mut rough = mix(0.24, 0.42, below * (1.0 - on_crest)) + 0.04 * broad + 0.02 * fine;
    let mut metallic = 0.0;
    // A breath of orange peel under the gloss.
    let mut height = 1.2e-5 * perlin(p * 420.0, 14);

    // Lettering and insignia, sprayed through stencils: slightly worn.
    for (ink, cover) in shell_marks(p) {
        let cover = cover * smoothstep(-0.75, -0.45, fine + 0.4 * grain);
        let colour = match ink {
            Ink::Dark => GRAPHITE,
            Ink::Light => WHITE * 0.95,
            Ink::Signal => RED,
        };
        base = base.lerp(colour, cover);
        rough = mix(rough, 0.46, cover);
        height += 1.5e-5 * cover;
    }

    // Joints and rivets.
    let groove = smoothstep(0.0011, 0.0005, l.joint);
    height -= 4.5e-4 * groove;
    let dome = (1.0 - (l.rivet / 0.0024).powi(2)).max(0.0).sqrt();
    let moat = smoothstep(0.0034, 0.0026, l.rivet) * (1.0 - smoothstep(0.0026, 0.0022, l.rivet));
    height += 5.0e-4 * dome - 1.2e-4 * moat;

    // Air slots: pressed in, black inside.
    let pressed = smoothstep(0.0014, -0.0012, l.slot);
    height -= 1.1e-3 * pressed;
    let hole = smoothstep(-0.0006, -0.0010, l.slot);
    base = base.lerp(Vec3::splat(0.006), hole);
    rough = mix(rough, 0.8, hole);

    // Wear: paint goes where things rub: edges of joints, the crest, the frame, rivets, ridges of the form.
    let rub = 0.85 * smoothstep(0.0045, 0.0008, (l.joint - 0.0009).abs())
        + 0.80 * smoothstep(0.0040, 0.0002, (l.crest + 0.0046).abs())
        + 0.55 * smoothstep(0.0040, 0.0004, l.slot.max(0.0))
        + 0.70 * smoothstep(0.010, 0.0, l.frame)
        + 0.60 * smoothstep(0.0034, 0.0016, l.rivet)
        + 0.25 * smoothstep(-0.2, 0.8, broad);
    let chips = 0.55 * fbm(p * 95.0, 5, 21) + 0.45 * fbm(p * 330.0, 3, 22);
    let patchy = smoothstep(-0.35, 0.45, fbm(p * 14.0, 3, 23));
    let worn = rub * (0.45 + 0.75 * patchy) + 0.95 * chips;
    let to_primer = smoothstep(0.84, 0.89, worn);
    let to_metal = smoothstep(0.95, 1.00, worn);
    // Stone chips: few, small, anywhere.
    let (w1, _, id) = worley(p * 75.0, 31);
    let size = if id % 11 == 0 { 0.05 + 0.10 * crate::noise::unit(crate::noise::hash(id)) } else { 0.0 };
    let chip = smoothstep(size, size * 0.6, w1 + 0.06 * fine) * (size > 0.0) as u32 as f32;
    let to_primer = to_primer.max(chip) * (1.0 - hole);
    let to_metal = to_metal * (1.0 - hole);
    base = base.lerp(PRIMER * (1.0 + 0.2 * fine), to_primer);
    rough = mix(rough, 0.62, to_primer);
    height -= 5.0e-5 * to_primer;
    let steel = STEEL * (1.0 + 0.10 * fine);
    base = base.lerp(steel, to_metal);
    metallic = mix(metallic, 1.0, to_metal);
    rough = mix(rough, 0.34 + 0.10 * fine, to_metal);
    height -= 2.0e-5 * to_metal;

    // Scratches: long thin lines in the clear coat, seen in the gloss.
    let mut scratch = 0.0f32;
    for k in 0..3u32 {
        let turn = [Vec3::new(0.2, 1.0, 0.35), Vec3::new(1.0, 0.4, -0.3), Vec3::new(-0.5, 0.6, 1.0)]
            [k as usize]
            .normalize();
        let (a, b) = turn.any_orthonormal_pair();
        let warp = 0.004 * perlin(p * 18.0, 40 + k);
        let u = p.dot(a) + warp;
        let q = Vec3::new(u * 420.0, p.dot(b) * 9.0, p.dot(turn) * 9.0);
        let line = perlin(q, 50 + k).abs();
        let here = smoothstep(0.30, 0.55, perlin(p * 26.0, 60 + k));
        scratch = scratch.max(smoothstep(0.045, 0.0, line) * here);
    }
    rough += 0.14 * scratch * (1.0 - to_metal);
    base *= 1.0 - 0.06 * scratch * (1.0 - below);

    // Dirt: in joints, around rivets, where it is sheltered, in streaks that ran down.
    let sheltered = smoothstep(0.80, 0.30, t.open);
    let seep = smoothstep(0.006, 0.0, l.joint - 0.0006) * smoothstep(-0.2, 0.6, fine + broad);
    let streak_noise = fbm(Vec3::new(p.x * 150.0, p.y * 7.0, p.z * 150.0), 3, 71);
    let streak =
        smoothstep(0.15, 0.75, streak_noise) * smoothstep(-0.3, 0.5, broad) * smoothstep(0.10, -0.09, p.y);
    let dirt = (0.85 * groove + 0.55 * sheltered + 0.35 * seep + 0.60 * moat + 0.34 * streak).min(0.92);
    base = base.lerp(Vec3::new(0.050, 0.042, 0.033), dirt * (1.0 - 0.5 * to_metal));
    rough = mix(rough, 0.75, dirt * 0.8);
    metallic *= 1.0 - 0.6 * groove;
    // Pale dust settles on the jaw, thicker towards the neck.
    let dusty = 0.32
        * smoothstep(-0.05, -0.125, p.y + 0.02 * broad)
        * (0.3 + 0.7 * smoothstep(-0.4, 0.6, fbm(p * 190.0, 4, 91)));
    base = base.lerp(Vec3::new(0.20, 0.17, 0.135), dusty);
    rough = mix(rough, 0.82, dusty);
    // Dust and handling lift the gloss in soft patches.
    rough += 0.06 * smoothstep(0.0, 0.7, fbm(p * 30.0, 4, 81));

    Paint { base, metallic, roughness: rough.clamp(0.12, 0.95), height, emissive: Vec3::ZERO }
}
