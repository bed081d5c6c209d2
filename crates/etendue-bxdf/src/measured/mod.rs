//! Materials as they were measured: tables from files.
//!
//! | arrays in the file | layout | source |
//! |---|---|---|
//! | `vndf`, `luminance`, `spectra` or `rgb`, … | adaptive parameterization | Dupuy, Jakob 2018 (the RGL material database, `.bsdf`) |
//! | `M`, `phi_d`, `theta_d`, `theta_h`, `wvls` | Mueller matrices over half-vector angles, of which M00 is used | Baek et al. 2020 (`.pbsdf`) |
//!
//! Spectra become linear Rec.709 once, when a file is read (CIE 1931 observer, D65, relative to a perfect reflector); from there
//! on three lanes are values like any others.
//!
//! Reading and asking are apart: [`Measured::from_bytes`] takes a file's bytes, and `&Measured` is a closure
//! (small, `Copy`, [`crate::Bsdf`]). Measured materials are no named model: they have no parameters.

mod half;
mod observer;
mod polarised;
mod rgl;
mod tensor;
mod warp;

use crate::{
    bsdf::{Bsdf, BsdfSample, Eval, LobeKind, MIN_COS},
    math::sin_cos_tau,
};
use etendue_color::Spectrum;
use glam::{Vec3A, vec3a};
use thiserror::Error;

/// Why bytes are not a measured material.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum MeasuredError {
    /// The first bytes are not those of a tensor file.
    #[error("not a tensor file: it does not begin with \"tensor_file\"")]
    NotATensorFile,
    /// Another version than 1.0.
    #[error("tensor file version {major}.{minor}: only 1.0 is known")]
    Version {
        /// First number.
        major: u8,
        /// Second number.
        minor: u8,
    },
    /// The directory or an array reaches beyond the end.
    #[error("the file ends before its arrays do")]
    Truncated,
    /// The name of an array is not UTF-8.
    #[error("the name of an array is not text")]
    Name,
    /// An array that the layout needs is not there.
    #[error("the array {name:?} is missing")]
    Missing {
        /// Its name.
        name: &'static str,
    },
    /// An array is not what the layout needs.
    #[error("the array {name:?} is not as expected: {expected}")]
    Field {
        /// Its name.
        name: String,
        /// What was expected.
        expected: &'static str,
    },
}

#[derive(Clone, Debug, PartialEq)]
enum Table {
    Rgl(rgl::Rgl),
    Polarised(polarised::Polarised),
}

/// Nodes of the albedo's table, even in the cosine.
const ALBEDO_NODES: usize = 17;

/// A measured material.
///
/// ```no_run
/// use etendue_bxdf::{Bsdf, measured::Measured};
/// use glam::Vec3A;
///
/// let bytes = std::fs::read("spectralon.pbsdf")?;
/// let material = Measured::from_bytes(&bytes)?;
/// println!("{:?}", (&material).albedo(Vec3A::Z));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// Measurements keep no law exactly: values are neither quite reciprocal nor bounded by an energy of one. Nothing tells surface
/// reflection from what lies under it, so all of it is called specular. [`Bsdf::albedo`] is an estimate, from
/// some hundred samples at each of 17 angles (averaged over azimuths), interpolated.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    table: Table,
    description: String,
    albedo: Vec<Spectrum>,
    alpha: f32,
}

impl Measured {
    /// Reads a file of either layout.
    ///
    /// Never panics, and allocates no more than a small multiple of `bytes`.
    ///
    /// # Errors
    /// [`MeasuredError`], with the array that is wrong.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, MeasuredError> {
        let file = tensor::TensorFile::from_bytes(bytes)?;
        let table = if file.get("M").is_some() {
            Table::Polarised(polarised::Polarised::read(&file)?)
        } else {
            Table::Rgl(rgl::Rgl::read(&file)?)
        };
        let description = match file.get("description") {
            Some(f) if f.kind == tensor::U8 => String::from_utf8_lossy(f.bytes).into_owned(),
            _ => String::new(),
        };
        let mut out = Self { table, description, albedo: Vec::new(), alpha: 1.0 };
        out.alpha = out.measure_alpha();
        out.albedo = out.measure_albedo();
        Ok(out)
    }

    /// What the file says of itself; often empty.
    pub fn description(&self) -> &str {
        &self.description
    }

    /// True if only the difference of azimuths counts.
    pub fn is_isotropic(&self) -> bool {
        match &self.table {
            Table::Rgl(t) => t.is_isotropic(),
            Table::Polarised(_) => true,
        }
    }

    /// f and density; both directions lie above the horizon.
    fn eval_above(&self, wo: Vec3A, wi: Vec3A) -> Eval {
        let (value, pdf) = match &self.table {
            Table::Rgl(t) => t.eval_pdf(wo, wi),
            Table::Polarised(t) => (t.value(wo, wi), t.pdf(wo, wi)),
        };
        if value.is_finite() && (0.0..f32::INFINITY).contains(&pdf) {
            Eval { diffuse: Spectrum::ZERO, specular: value, pdf }
        } else {
            Eval::ZERO
        }
    }

    /// The GGX α of the lobe that falls to a quarter as the retro-reflection f(m, m) does; 1 if it does not.
    ///
    /// (GGX's D falls to a quarter where the half vector's tangent is α.)
    fn measure_alpha(&self) -> f32 {
        let retro = |u: f32| {
            let (sin, cos) = sin_cos_tau(0.25 * u * u);
            let m = vec3a(sin, 0.0, cos);
            self.eval_above(m, m).specular.max_element()
        };
        let peak = (0..=8).map(|i| retro(0.01 + 0.005 * i as f32)).fold(0.0, f32::max);
        (2..=60).map(|i| i as f32 / 64.0).find(|&u| retro(u) < 0.25 * peak).map_or(1.0, |u| {
            let (sin, cos) = sin_cos_tau(0.25 * u * u);
            (sin / cos).max(1e-3).min(1.0)
        })
    }

    fn measure_albedo(&self) -> Vec<Spectrum> {
        let azimuths = if self.is_isotropic() { 1 } else { 4 };
        let side = if self.is_isotropic() { 16 } else { 8 };
        (0..ALBEDO_NODES)
            .map(|node| {
                let cos = (node as f32 / (ALBEDO_NODES - 1) as f32).max(0.01);
                let sin = ((1.0 - cos) * (1.0 + cos)).sqrt();
                let mut sum = Spectrum::ZERO;
                for azimuth in 0..azimuths {
                    let (y, x) = sin_cos_tau((azimuth as f32 + 0.31) / azimuths as f32);
                    let wo = vec3a(sin * x, sin * y, cos);
                    for i in 0..side * side {
                        let u = [(i % side) as f32 + 0.5, (i / side) as f32 + 0.5].map(|v| v / side as f32);
                        // A third coordinate that is even over the cells: multiples of the golden ratio.
                        let uc = (i as f32 * 0.618_034).fract();
                        // A file may hold anything: the sum stays finite.
                        sum +=
                            self.sample(wo, uc, u).map_or(Spectrum::ZERO, |s| s.weight.map(|w| w.min(1e6)));
                    }
                }
                sum / (azimuths * side * side) as f32
            })
            .collect()
    }
}

impl Bsdf for Measured {
    fn eval_pdf(&self, wo: Vec3A, wi: Vec3A) -> Eval {
        // Also taken by NaN.
        if !(wo.z > MIN_COS && wi.z > MIN_COS && wo.is_finite() && wi.is_finite()) {
            return Eval::ZERO;
        }
        self.eval_above(wo, wi)
    }

    fn sample(&self, wo: Vec3A, uc: f32, u: [f32; 2]) -> Option<BsdfSample> {
        if !(wo.z > MIN_COS && wo.is_finite()) {
            return None;
        }
        let wi = match &self.table {
            Table::Rgl(t) => t.sample(wo, u),
            Table::Polarised(t) => t.sample(wo, uc, u),
        };
        if !(wi.z > MIN_COS && wi.is_finite()) {
            return None;
        }
        let wi = wi.normalize();
        let e = self.eval_above(wo, wi);
        let weight = e.specular * (wi.z / e.pdf);
        if !(e.pdf > 0.0 && weight.is_finite() && wi.z > MIN_COS) {
            return None;
        }
        Some(BsdfSample {
            wi,
            weight,
            weight_diffuse: Spectrum::ZERO,
            weight_specular: weight,
            pdf: e.pdf,
            delta: false,
            lobe: LobeKind::Specular,
        })
    }

    fn albedo(&self, wo: Vec3A) -> Spectrum {
        if !(wo.z > MIN_COS && wo.is_finite()) {
            return Spectrum::ZERO;
        }
        let (i, t) = warp::cell(ALBEDO_NODES, wo.z);
        self.albedo[i].lerp(self.albedo[i + 1], t)
    }

    fn narrowest_alpha(&self) -> [f32; 2] {
        [self.alpha; 2]
    }
}
