//! The paint of everything that shares the hardware's pictures: frame, ring, pods, mouthpiece, connectors, bolts, buckle, lamp.

use crate::bake::{Paint, Texel};
use crate::noise::{fbm, mix, perlin, smoothstep};
use glam::Vec3;

/// The parts in the hardware atlas; 0 is nothing.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[repr(u8)]
pub enum Part {
    /// The visor's frame.
    Frame = 1,
    /// The rubber between frame and visor.
    Gasket,
    /// The neck's ring.
    Neck,
    /// The breathing hose.
    Hose,
    /// An ear pod.
    Pod,
    /// The mouthpiece.
    Mouth,
    /// The mouthpiece's slats.
    Grille,
    /// The hose's connectors.
    Connector,
    /// A bolt.
    Bolt,
    /// The strap's buckle.
    Buckle,
    /// The lamp on the brow.
    Lamp,
}

const BLACK: Vec3 = Vec3::new(0.027, 0.028, 0.031);
const RUBBER: Vec3 = Vec3::new(0.016, 0.016, 0.017);
const STEEL: Vec3 = Vec3::new(0.54, 0.53, 0.51);
const BRASS: Vec3 = Vec3::new(0.78, 0.56, 0.27);
const RED: Vec3 = Vec3::new(0.60, 0.055, 0.012);
/// The status light's colour: ice blue, and the warning amber.
const ICE: Vec3 = Vec3::new(0.04, 0.52, 1.0);
const AMBER: Vec3 = Vec3::new(1.0, 0.36, 0.04);

fn rubber(t: &Texel) -> Paint {
    let p = t.pos;
    let n = fbm(p * 120.0, 3, 101);
    Paint {
        base: RUBBER * (1.0 + 0.35 * n) + Vec3::splat(0.010) * smoothstep(0.0, 0.6, fbm(p * 40.0, 3, 102)),
        metallic: 0.0,
        roughness: 0.58 + 0.10 * n,
        height: 2.0e-5 * perlin(p * 900.0, 103),
        emissive: Vec3::ZERO,
    }
}

fn bare_metal(t: &Texel, colour: Vec3, rough: f32) -> Paint {
    let p = t.pos;
    let n = fbm(p * 60.0, 4, 111);
    let tarnish = smoothstep(0.1, 0.7, fbm(p * 35.0, 3, 112));
    Paint {
        base: colour * (1.0 + 0.06 * n) * (1.0 - 0.25 * tarnish),
        metallic: 1.0,
        roughness: rough + 0.05 * n + 0.10 * tarnish,
        height: 0.0,
        emissive: Vec3::ZERO,
    }
}

/// Paint over metal, worn through where the geometry's ridges are.
fn painted(t: &Texel, colour: Vec3, rough: f32, amount: f32) -> Paint {
    let p = t.pos;
    let n = fbm(p * 60.0, 4, 121);
    let chips = 0.6 * fbm(p * 150.0, 4, 122) + 0.4 * fbm(p * 500.0, 2, 123);
    let patchy = smoothstep(-0.4, 0.5, fbm(p * 22.0, 3, 124));
    let worn = 1.0 * t.ridge * (0.35 + 0.8 * patchy) + 0.80 * chips;
    let through = smoothstep(1.0 - amount, 1.08 - amount, worn);
    let metal = bare_metal(t, STEEL, 0.30);
    Paint {
        base: (colour * (1.0 + 0.10 * n)).lerp(metal.base, through),
        metallic: through,
        roughness: mix(rough + 0.06 * n, metal.roughness, through),
        height: 1.2e-5 * perlin(p * 520.0, 125) - 4.0e-5 * through,
        emissive: Vec3::ZERO,
    }
}

/// Grime in sheltered places.
fn soiled(t: &Texel, mut p: Paint, amount: f32) -> Paint {
    let n = fbm(t.pos * 80.0, 3, 131);
    let dirt = amount * smoothstep(0.75, 0.25, t.open + 0.15 * n);
    p.base = p.base.lerp(Vec3::new(0.035, 0.030, 0.024), dirt);
    p.roughness = mix(p.roughness, 0.80, dirt);
    p.metallic *= 1.0 - 0.7 * dirt;
    p
}

/// Length of the frame's outline from its foot to the step between flange and lip, metres.
const FRAME_STEP: f32 = 0.0196;

fn frame(t: &Texel) -> Paint {
    let mut p = painted(t, BLACK, 0.34, 0.34);
    // Lines of light at both temples, in the step between flange and lip.
    let side = smoothstep(0.062, 0.066, t.pos.x.abs())
        * smoothstep(-0.032, -0.028, t.pos.y)
        * smoothstep(0.052, 0.048, t.pos.y);
    let line = smoothstep(0.0010, 0.0006, (t.aux.y - FRAME_STEP).abs()) * side;
    p.emissive = ICE * line;
    p.base = p.base.lerp(Vec3::splat(0.2), line);
    p
}

fn neck(t: &Texel) -> Paint {
    // The outline runs from inside below over the band to the rubber roll.
    if t.aux.y < 0.0330 {
        let knurl =
            (t.aux.x * 2400.0).sin() * smoothstep(0.006, 0.009, t.aux.y) * smoothstep(0.019, 0.016, t.aux.y);
        let mut p = bare_metal(t, STEEL * 0.82, 0.30);
        p.height += 6.0e-5 * knurl;
        p
    } else {
        rubber(t)
    }
}

fn pod(t: &Texel) -> Paint {
    let r = t.aux.x;
    let angle = t.aux.y;
    // Distances from the centre along the outline.
    if r > 0.0560 {
        return rubber(t);
    }
    if r > 0.0372 {
        let mut p = bare_metal(t, STEEL, 0.24);
        let knurl = (angle * 96.0).sin() * smoothstep(0.0440, 0.0446, r) * smoothstep(0.0496, 0.0490, r);
        p.height += 9.0e-5 * knurl;
        return p;
    }
    if r > 0.0330 {
        let mut p = painted(t, BLACK, 0.4, 0.0);
        let glow = smoothstep(0.0332, 0.0336, r) * smoothstep(0.0368, 0.0364, r);
        let gap = smoothstep(0.10, 0.13, (((angle / std::f32::consts::TAU * 3.0).fract() - 0.5) * 2.0).abs());
        p.emissive = ICE * glow * gap;
        p.base = p.base.lerp(Vec3::splat(0.25), glow * gap);
        return p;
    }
    if r > 0.0200 {
        return painted(t, RED, 0.28, 0.36);
    }
    if r > 0.0105 {
        return painted(t, BLACK, 0.45, 0.30);
    }
    bare_metal(t, BRASS, 0.26)
}

fn mouth(t: &Texel) -> Paint {
    let mut p = painted(t, BLACK * 1.3, 0.40, 0.32);
    // A thin line of light on the upper bevel, and a status lamp on either side of it.
    let (x, y) = (t.aux.x, t.aux.y - 0.0222);
    let line = smoothstep(0.0010, 0.0006, y.abs()) * smoothstep(0.0135, 0.0130, x.abs());
    let lamp = smoothstep(0.0015, 0.0011, ((x.abs() - 0.0205).powi(2) + y * y).sqrt());
    p.emissive = ICE * line + AMBER * lamp;
    p.base = p.base.lerp(Vec3::splat(0.2), line.max(lamp));
    p
}

fn connector(t: &Texel) -> Paint {
    let (r, angle) = (t.aux.x, t.aux.y);
    let mut p = if r > 0.0450 {
        painted(t, BLACK, 0.4, 0.32)
    } else if r > 0.0250 {
        bare_metal(t, BRASS, 0.28)
    } else {
        bare_metal(t, STEEL * 0.8, 0.33)
    };
    let knurl = (angle * 48.0).sin() * smoothstep(0.0268, 0.0275, r) * smoothstep(0.0345, 0.0338, r);
    p.height += 1.2e-4 * knurl;
    p
}

/// Paints a place of the hardware.
pub fn parts_paint(t: &Texel) -> Paint {
    let part = |p: Part| p as u8 == t.part;
    let p = if part(Part::Frame) {
        frame(t)
    } else if part(Part::Gasket) || part(Part::Hose) {
        rubber(t)
    } else if part(Part::Neck) {
        neck(t)
    } else if part(Part::Pod) {
        pod(t)
    } else if part(Part::Mouth) {
        mouth(t)
    } else if part(Part::Grille) {
        bare_metal(t, STEEL * 0.55, 0.32)
    } else if part(Part::Connector) {
        connector(t)
    } else if part(Part::Lamp) {
        let mut p = painted(t, BLACK, 0.35, 0.36);
        let lens = smoothstep(0.0100, 0.0096, t.aux.x);
        // A lens of rings, brightest in the middle.
        let rings = 0.75 + 0.25 * (t.aux.x * 5200.0).cos();
        let spot = 0.02 + 0.40 * smoothstep(0.0085, 0.0, t.aux.x).powi(2);
        p.emissive = Vec3::new(1.0, 0.84, 0.60) * (lens * rings * spot);
        p.base = p.base.lerp(Vec3::splat(0.30), lens);
        p.roughness = mix(p.roughness, 0.12, lens);
        p.height += 8.0e-5 * lens * (t.aux.x * 5200.0).cos();
        p
    } else {
        bare_metal(t, STEEL, 0.27)
    };
    soiled(t, p, 0.75)
}
