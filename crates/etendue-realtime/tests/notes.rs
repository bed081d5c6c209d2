//! The preset `notes` is the founding notes' helmet shader.
//!
//! The fragment shader is transcribed here a second time, from the notes' HLSL and with nothing of the crate, and both are evaluated
//! at random points.

use etendue_bxdf::laws::Rng;
use etendue_bxdf::sampling::{Frame, uniform_sphere};
use etendue_color::Spectrum;
use etendue_ibl::{CubeLookup, Sh9, SkyMap, UnitySh};
use etendue_image::{Image, Pixels};
use etendue_realtime::{Inputs, Lighting, Preset, shade};
use etendue_scene::{Environment, Light, LightKind, Scene};
use glam::{Vec3, Vec3A};
use std::f32::consts::PI;
use std::sync::Arc;

fn d_distribution_ggx(n: Vec3, h: Vec3, roughness: f32) -> f32 {
    let a = roughness * roughness;
    let a2 = a * a;
    let nh = n.dot(h).max(0.0);
    let nh2 = nh * nh;
    let nominator = a2;
    let mut denominator = nh2 * (a2 - 1.0) + 1.0;
    denominator = PI * denominator * denominator;
    nominator / denominator.max(0.00001)
}

fn g_schlick_ggx(nv: f32, roughness: f32) -> f32 {
    let a = roughness + 1.0;
    let k = a * a / 8.0;
    let nominator = nv;
    let denominator = nv * (1.0 - k) + k;
    nominator / denominator.max(0.00001)
}

fn g_smith(n: Vec3, v: Vec3, l: Vec3, roughness: f32) -> f32 {
    let nv = n.dot(v).max(0.0);
    let nl = n.dot(l).max(0.0);
    g_schlick_ggx(nv, roughness) * g_schlick_ggx(nl, roughness)
}

fn f_schlick(vh: f32, f0: Vec3) -> Vec3 {
    f0 + (1.0 - f0) * (1.0 - vh).powi(5)
}

fn f_schlick_roughness(nv: f32, f0: Vec3, roughness: f32) -> Vec3 {
    let smoothness = 1.0 - roughness;
    f0 + (Vec3::splat(smoothness).max(f0) - f0) * (1.0 - nv).powf(5.0)
}

fn ami_brdf_approx(roughness: f32, no_v: f32) -> [f32; 2] {
    let c0 = [-1.0, -0.0275, -0.572, 0.022];
    let c1 = [1.0, 0.0425, 1.04, -0.04];
    let r: [f32; 4] = std::array::from_fn(|i| roughness * c0[i] + c1[i]);
    let a004 = (r[0] * r[0]).min((-9.28 * no_v).exp2()) * r[0] + r[1];
    [-1.04 * a004 + r[2], 1.04 * a004 + r[3]]
}

/// `frag`, from the variables on; the four terms as they are added up.
struct Fragment {
    base_color: Vec3,
    roughness: f32,
    metallic: f32,
    emission: Vec3,
    ao: f32,
    l: Vec3,
    v: Vec3,
    n: Vec3,
    light_color: Vec3,
}

impl Fragment {
    fn terms(&self, shade_sh9: impl Fn(Vec3) -> Vec3, spec_cube: impl Fn(Vec3, f32) -> Vec3) -> [Vec3; 4] {
        let Self { base_color, roughness, metallic, l, v, n, .. } = *self;
        let h = (l + v).normalize();
        let vh = v.dot(h).max(0.0);
        let nv = n.dot(v).max(0.0);
        let nl = n.dot(l).max(0.0);
        let f0 = Vec3::splat(0.04).lerp(base_color, metallic);

        let ks = f_schlick(vh, f0);
        let kd = (1.0 - ks) * (1.0 - metallic);
        let diffuse = kd * base_color / PI;
        let d = d_distribution_ggx(n, h, roughness);
        let g = g_smith(n, v, l, roughness);
        let specular = d * ks * g / (4.0 * nv * nl).max(0.0001);

        let ks_ami = f_schlick_roughness(nv, f0, roughness);
        let kd_ami = (1.0 - ks_ami) * (1.0 - metallic);
        let irradiance = shade_sh9(n);
        let diffuse_ami = irradiance * base_color * kd_ami / PI;
        let r = 2.0 * n.dot(v) * n - v;
        let mip = roughness * (1.7 - 0.7 * roughness) * 6.0;
        let prefiltered = spec_cube(r, mip);
        let brdf_ami = ami_brdf_approx(roughness, nv);
        let specular_ami = prefiltered * (ks_ami * brdf_ami[0] + brdf_ami[1]);
        [
            diffuse * nl * self.light_color,
            specular * nl * self.light_color,
            diffuse_ami * self.ao,
            specular_ami * self.ao,
        ]
    }
}

fn environment() -> Environment {
    let (w, h) = (64u32, 32u32);
    let pixels = (0..w * h).flat_map(|i| {
        let sun = if i == 20 * w / 2 + 13 { 300.0 } else { 0.0 };
        [sun + 0.5 + (i % w) as f32 / 64.0, 0.3 + (i / w) as f32 / 32.0, 0.9 + ((i * 7) % 5) as f32 / 9.0]
    });
    let image = Arc::new(Image { width: w, height: h, channels: 3, pixels: Pixels::F32(pixels.collect()) });
    Environment::LatLong { image, rotation: 0.7, intensity: 1.0 }
}

#[test]
fn pixel_by_pixel() {
    let choices = Preset::Notes.choices();
    let environment = environment();
    let unity = UnitySh::new(&Sh9::project(&SkyMap::new(&environment).expect("a sky")));
    let mut scene = Scene { environment, ..Scene::default() };
    let mut rng = Rng::new(12);
    let light_color = Vec3::new(2.5, 2.0, 1.5);
    let mut lighting = Lighting::new(&scene, &choices).expect("a sky");
    let cube: CubeLookup =
        lighting.sky.as_ref().and_then(|s| s.specular_cube()).expect("prefiltered").clone();
    assert_eq!((cube.size(), cube.mip_count()), (128, 7));
    let (mut lit, mut worst) = (0, 0.0f32);
    for _ in 0..4000 {
        let unit = |rng: &mut Rng| Vec3::from(uniform_sphere(rng.square()));
        let (n, l) = (unit(&mut rng), unit(&mut rng));
        let v = unit(&mut rng);
        let v = if v.dot(n) < 0.0 { -v } else { v };
        if v.dot(n) < 0.01 {
            continue;
        }
        let mut colour = || Vec3::new(rng.uniform(), rng.uniform(), rng.uniform());
        let fragment = Fragment {
            base_color: colour(),
            emission: colour() * 3.0,
            roughness: 0.05 + 0.95 * rng.uniform(),
            metallic: rng.uniform(),
            ao: rng.uniform(),
            l,
            v,
            n,
            light_color,
        };
        let want = fragment.terms(
            |n| Vec3::from_array(unity.shade(n)),
            |r, mip| Vec3::from_array(cube.trilinear(Vec3A::from(r), mip).to_rgb()),
        );

        scene.lights = vec![Light {
            name: String::new(),
            kind: LightKind::Directional,
            intensity: light_color,
            position: Vec3::ZERO,
            direction: -l,
            range: None,
        }];
        lighting.lights = scene.lights.iter().map(Into::into).collect();
        let mut point = Inputs::new(Vec3A::ZERO, v.into(), n.into());
        point.frame = Frame::from_normal(n.into());
        point.surface.base_color = Spectrum::from_rgb(fragment.base_color.to_array());
        point.surface.roughness = fragment.roughness;
        point.surface.metallic = fragment.metallic;
        point.occlusion = fragment.ao;
        point.emission = Spectrum::from_rgb(fragment.emission.to_array());
        let got = shade(&point, &lighting, &choices, &()).terms;

        let pairs = [got.direct_diffuse, got.direct_specular, got.indirect_diffuse, got.indirect_specular];
        // D's denominator is 1 − NH² (1 − a²): near the peak rounding is divided by a², a = roughness².
        let a2 = fragment.roughness.powi(4);
        for (k, (got, want)) in pairs.iter().zip(&want).enumerate() {
            let rounding = if k == 1 { 4e-6 + 2e-6 / a2 } else { 8e-6 };
            for lane in 0..3 {
                let error = (got[lane] - want[lane]).abs();
                assert!(
                    error <= rounding * want[lane].abs() + 3e-6,
                    "term {k}: {got:?} {want} at roughness {}",
                    fragment.roughness
                );
                worst = worst.max(error / (want[lane].abs() + 0.1));
            }
        }
        let whole = want.iter().sum::<Vec3>() + fragment.emission;
        let sum = got.sum();
        for lane in 0..3 {
            assert!((sum[lane] - whole[lane]).abs() <= (1e-5 + 2e-6 / a2) * whole[lane].abs() + 1e-5);
        }
        lit += usize::from(n.dot(l) > 0.0);
    }
    println!("worst difference relative to (value + 0.1): {worst:.1e}");
    assert!(lit > 1500, "{lit}");
}

/// The post-process shader is the tone curve that the preset names.
#[test]
fn tone_curve_is_the_notes() {
    let curve = Preset::Notes.tone_curve().expect("the notes have one");
    let mut rng = Rng::new(2);
    for _ in 0..200 {
        let x = 20.0 * rng.uniform() * rng.uniform();
        let (a, b, c, d, e) = (2.51f32, 0.03f32, 2.43f32, 0.59f32, 0.14f32);
        let want = ((x * (a * x + b)) / (x * (c * x + d) + e)).clamp(0.0, 1.0);
        assert!((curve.apply([x; 3])[0] - want).abs() < 1e-6);
    }
}
