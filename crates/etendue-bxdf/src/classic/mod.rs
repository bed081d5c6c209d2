//! Models from before, and beside, the physically based ones: what shaders computed and compute.
//!
//! They are here for comparison. Their documentation says what each gets wrong and by how much; what they are sampled by is
//! right in any case.

mod blinn_phong;
mod cook_torrance;
mod phong;

pub use blinn_phong::{BlinnPhongParams, BlinnPhongSurface};
pub use cook_torrance::{
    CookTorrance, CookTorranceDistribution, CookTorranceFresnel, CookTorranceMasking, CookTorranceParams,
};
pub use phong::{PhongParams, PhongSurface};

use crate::bsdf::{BsdfSample, Eval, LobeKind};
use etendue_color::Spectrum;
use glam::Vec3A;

/// 0..1, NaN to 0.
#[inline(always)]
fn unit(x: f32) -> f32 {
    x.max(0.0).min(1.0)
}

#[inline(always)]
fn sum(s: Spectrum) -> f32 {
    let [a, b, c, d] = s.0;
    (a + b) + (c + d)
}

/// The probability of the specular part from the light that each part is guessed to reflect: never so small that a wrong
/// guess makes weights large, and exactly 0 or 1 where a part is absent.
#[inline(always)]
fn choice(specular: f32, diffuse: f32) -> f32 {
    if !(diffuse > 0.0) {
        return 1.0;
    }
    if !(specular > 0.0) {
        return 0.0;
    }
    (specular / (specular + diffuse)).max(0.1).min(0.9)
}

/// The sample of a direction above the surface, of what `eval_pdf` says of it.
#[inline(always)]
fn sample_of(e: Eval, wi: Vec3A, lobe: LobeKind) -> Option<BsdfSample> {
    if !(e.pdf > 0.0 && e.pdf < f32::INFINITY) {
        return None;
    }
    let scale = wi.z / e.pdf;
    let (weight_diffuse, weight_specular) = (e.diffuse * scale, e.specular * scale);
    let weight = weight_diffuse + weight_specular;
    if !weight.is_finite() {
        return None;
    }
    Some(BsdfSample { wi, weight, weight_diffuse, weight_specular, pdf: e.pdf, delta: false, lobe })
}
