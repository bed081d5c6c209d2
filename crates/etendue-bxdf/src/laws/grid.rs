//! The closures and directions that the laws are run over.

use crate::{
    bsdf::Bsdf,
    diffuse::Lambert,
    fresnel::Schlick,
    ggx::GgxReflection,
    metal_rough::{Coupling, MetalRough, MetalRoughParams},
    multiscatter::Compensation,
};
use etendue_color::Spectrum;
use glam::{Vec3A, vec3a};

pub use crate::ggx::anisotropic_alpha;

/// One closure.
pub struct Subject {
    /// What it is and with which parameters.
    pub name: String,
    /// The closure.
    pub bsdf: Box<dyn Bsdf>,
}

/// Perceptual roughness of the grid.
pub const ROUGHNESS: [f32; 6] = [0.0, 0.01, 0.1, 0.3, 0.6, 1.0];
/// Anisotropy of the grid.
pub const ANISOTROPY: [f32; 3] = [0.0, 0.5, 0.9];
/// Angles of `wo` to the normal, in degrees.
pub const ANGLES: [f32; 5] = [0.0, 30.0, 60.0, 80.0, 89.0];
/// Metalness of the grid.
pub const METALLIC: [f32; 3] = [0.0, 0.5, 1.0];

/// `wo` at an angle to the normal in degrees; its azimuth is no symmetry axis of anything.
pub fn wo_at(degrees: f32) -> Vec3A {
    let (sin, cos) = (degrees as f64).to_radians().sin_cos();
    let (y, x) = 0.7f64.sin_cos();
    vec3a((sin * x) as f32, (sin * y) as f32, cos as f32)
}

/// Lambert and the GGX lobe over roughness × anisotropy, with F = 1 and with a coloured Fresnel.
pub fn lobes() -> Vec<Subject> {
    let mut out = vec![Subject {
        name: "lambert".into(),
        bsdf: Box::new(Lambert { color: Spectrum::rgb(1.0, 0.5, 0.0) }),
    }];
    let gold = Schlick { f0: Spectrum::rgb(1.0, 0.77, 0.34), f90: Spectrum::ONE };
    for (fresnel_name, fresnel) in [("F=1", Schlick::ONE), ("gold", gold)] {
        for roughness in ROUGHNESS {
            for anisotropy in ANISOTROPY {
                let [ax, ay] = anisotropic_alpha(roughness, anisotropy);
                out.push(Subject {
                    name: format!("ggx {fresnel_name} roughness {roughness} anisotropy {anisotropy}"),
                    bsdf: Box::new(GgxReflection::new(ax, ay, fresnel)),
                });
            }
        }
    }
    out
}

/// The metal-rough closure over roughness × metallic, white (the worst case for energy) and coloured, and with the
/// extensions' parameters at their ends.
pub fn metal_rough() -> Vec<Subject> {
    let mut out = Vec::new();
    let mut push = |name: &str, p: MetalRoughParams| {
        let name = format!("metal-rough {name} metallic {} roughness {}", p.metallic, p.roughness);
        out.push(Subject { name, bsdf: Box::new(MetalRough::new(&p)) });
    };
    let coloured = Spectrum::rgb(0.9, 0.4, 0.05);
    for roughness in ROUGHNESS {
        for metallic in METALLIC {
            let p = MetalRoughParams { metallic, roughness, ..Default::default() };
            push("white", p);
            push("coloured", MetalRoughParams { base_color: coloured, ..p });
            push("uncompensated", MetalRoughParams { compensation: Compensation::None, ..p });
        }
        let p = MetalRoughParams { roughness, base_color: Spectrum::ONE, ..Default::default() };
        push("ior 0", MetalRoughParams { ior: 0.0, specular_color: Spectrum::rgb(0.3, 0.6, 0.1), ..p });
        push("ior 1", MetalRoughParams { ior: 1.0, ..p });
        push("ior 2.42", MetalRoughParams { ior: 2.42, ..p });
        push("specular 0", MetalRoughParams { specular: 0.0, ..p });
        push(
            "specular 0.5 red",
            MetalRoughParams { specular: 0.5, specular_color: Spectrum::rgb(9.0, 0.2, 0.2), ..p },
        );
    }
    out
}

/// The metal-rough closure with glTF's literal coupling, which keeps every law but the furnace.
pub fn metal_rough_half_vector() -> Vec<Subject> {
    ROUGHNESS
        .into_iter()
        .map(|roughness| {
            let p = MetalRoughParams { roughness, ..Default::default() };
            let bsdf = MetalRough::new(&p).with_coupling(Coupling::HalfVector);
            let name = format!("metal-rough half-vector metallic 0 roughness {roughness}");
            Subject { name, bsdf: Box::new(bsdf) }
        })
        .collect()
}
