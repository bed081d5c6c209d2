//! Tables in the adaptive parameterization of Dupuy and Jakob 2018.
//!
//! For each direction `wo` of the table a warp of the unit square onto half vectors is stored (`vndf`: the density of visible
//! normals that an analysis of the retro-reflection gave). The measured values lie on an even grid of the square, so that
//! they are dense where the material scatters:
//!
//! ```text
//! f(wo, wi) cosθi = value(s) · D(m) / (4 σ(wo)),   m = vndf warp(s)
//! ```
//!
//! (Dupuy, Jakob 2018, "An Adaptive Parameterization for Efficient Material Acquisition and Rendering", eq. 1 and section
//! 5). `luminance` is a second warp, of random numbers onto the square in proportion to what the values weigh.

use super::{
    MeasuredError, half,
    observer::rec709_weights,
    tensor::{F32, Field, TensorFile, U8},
    warp::{Corners, Places, Warp, bilinear, cell},
};
use core::f32::consts::TAU;
use etendue_color::Spectrum;
use glam::Vec3A;

/// A grid of numbers over the unit square, at least 2 × 2.
#[derive(Clone, Debug, PartialEq)]
struct Grid {
    width: usize,
    height: usize,
    values: Vec<f32>,
}

impl Grid {
    fn new(field: &Field) -> Result<Self, MeasuredError> {
        let (height, width) = (field.shape[0], field.shape[1]);
        if width < 2 || height < 2 {
            return Err(field.wrong("at least 2 × 2 values"));
        }
        Ok(Self { width, height, values: field.floats()? })
    }

    fn at(&self, at: [f32; 2]) -> f32 {
        bilinear(self.width, self.height, at, |k| self.values[k])
    }
}

/// The tables of a file.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Rgl {
    places: Places,
    isotropic: bool,
    /// By how much the azimuth of `wo` is folded: 1, 2 (point symmetry) or 4 (two mirror planes).
    folds: u32,
    /// Whether the values are still to be multiplied by D / 4σ.
    jacobian: bool,
    ndf: Grid,
    sigma: Grid,
    vndf: Warp,
    luminance: Warp,
    /// Values as linear Rec.709, slice by slice, `side` × `side` each.
    rgb: Vec<[f32; 3]>,
    side: usize,
}

/// What depends on `wo` alone.
struct View {
    wo: Vec3A,
    /// Signs that folded `wo`, and unfold `wi`.
    flip: Vec3A,
    /// From where the half vector's azimuth counts, in turns.
    turns: f32,
    corners: Corners,
    /// 1 / 4σ.
    scale: f32,
}

impl Rgl {
    /// Reads the arrays `theta_i`, `phi_i`, `ndf`, `sigma`, `vndf`, `luminance`, `jacobian` (if there) and either `rgb` or
    /// `spectra` with `wavelengths`.
    pub fn read(file: &TensorFile) -> Result<Self, MeasuredError> {
        let theta = file.expect("theta_i", 1, F32)?;
        let phi = file.expect("phi_i", 1, F32)?;
        let places = Places { first: phi.places()?, second: theta.places()? };
        let slices = [places.first.len(), places.second.len()];
        let isotropic = slices[0] <= 2;
        let span = places.first[slices[0] - 1] - places.first[0];
        let folds = if isotropic { 1 } else { (TAU / span).round().max(1.0).min(4.0) as u32 };
        let folds = if folds == 3 { 2 } else { folds };

        let warp = |name| {
            let field = file.expect(name, 4, F32)?;
            let [a, b, height, width] = [0, 1, 2, 3].map(|i| field.shape[i]);
            if [a, b] != slices || width < 2 || height < 2 {
                return Err(field.wrong("phi_i × theta_i × (at least 2) × (at least 2) values"));
            }
            Ok((Warp::new(width, height, &field.floats()?), width, height))
        };
        let (vndf, ..) = warp("vndf")?;
        let (luminance, side, height) = warp("luminance")?;
        if side != height {
            return Err(MeasuredError::Field {
                name: "luminance".into(),
                expected: "as many rows as columns",
            });
        }
        let (values, weights) = match file.get("rgb") {
            Some(_) => {
                let unit = vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
                (file.expect("rgb", 5, F32)?, unit)
            }
            None => {
                let wavelengths = file.expect("wavelengths", 1, F32)?.places()?;
                (file.expect("spectra", 5, F32)?, rec709_weights(&wavelengths))
            }
        };
        if values.shape[..2] != slices
            || values.shape[2] != weights.len()
            || values.shape[3..] != [side, side]
        {
            return Err(values.wrong("phi_i × theta_i × colours × luminance's shape"));
        }
        let rgb = to_rgb(&values.floats()?, &weights, side * side);
        let jacobian = match file.get("jacobian") {
            Some(f) if f.kind == U8 => f.bytes.first().is_some_and(|&b| b != 0),
            Some(f) => return Err(f.wrong("bytes")),
            None => true,
        };
        Ok(Self {
            isotropic,
            folds,
            jacobian,
            ndf: Grid::new(file.expect("ndf", 2, F32)?)?,
            sigma: Grid::new(file.expect("sigma", 2, F32)?)?,
            vndf,
            luminance,
            rgb,
            side,
            places,
        })
    }

    /// True if the table does not depend on the azimuth of `wo`.
    pub fn is_isotropic(&self) -> bool {
        self.isotropic
    }

    fn view(&self, wo: Vec3A) -> View {
        // A folded table is given for azimuths from −π: to the first half, or the first quarter, of the turn.
        let sign = |x: f32| if x > 0.0 { -1.0 } else { 1.0 };
        let flip = match self.folds {
            4 => Vec3A::new(sign(wo.x), sign(wo.y), 1.0),
            2 => Vec3A::new(sign(wo.y), sign(wo.y), 1.0),
            _ => Vec3A::ONE,
        };
        let wo = wo * flip;
        let (theta, turns) = (half::elevation(wo), half::azimuth(wo));
        let sigma = self.sigma.at([half::u_of(theta), turns + 0.5]);
        View {
            wo,
            flip,
            turns: if self.isotropic { turns } else { 0.0 },
            corners: self.places.around(turns * TAU, theta),
            scale: 0.25 / sigma.max(1e-9),
        }
    }

    /// f and the density of `wi`.
    pub fn eval_pdf(&self, wo: Vec3A, wi: Vec3A) -> (Spectrum, f32) {
        let view = self.view(wo);
        let cos = wi.z;
        let m = (view.wo + wi * view.flip).normalize();
        let at = half::coordinates(m, view.turns);
        let s = self.vndf.invert(&view.corners, at);
        let pdf = self.vndf.density(&view.corners, at) * self.luminance.density(&view.corners, s)
            / half::jacobian(view.wo, m, at[0]);
        let scale = if self.jacobian { self.ndf.at(at) * view.scale / cos } else { 1.0 / cos };
        let [r, g, b] = self.value(&view.corners, s);
        (Spectrum::rgb(r, g, b).map(|v| (v * scale).max(0.0)), pdf)
    }

    /// A direction; its density is that of [`Rgl::eval_pdf`].
    pub fn sample(&self, wo: Vec3A, u: [f32; 2]) -> Vec3A {
        let view = self.view(wo);
        let s = self.luminance.sample(&view.corners, u);
        let m = half::direction(self.vndf.sample(&view.corners, s), view.turns);
        (m * (2.0 * view.wo.dot(m)) - view.wo) * view.flip
    }

    /// The values at a point of the square.
    fn value(&self, corners: &Corners, at: [f32; 2]) -> [f32; 3] {
        let ((i, s), (j, t)) = (cell(self.side, at[0]), cell(self.side, at[1]));
        let k = j * self.side + i;
        let nodes = [
            (k, (1.0 - s) * (1.0 - t)),
            (k + 1, s * (1.0 - t)),
            (k + self.side, (1.0 - s) * t),
            (k + self.side + 1, s * t),
        ];
        let mut sum = [0.0; 3];
        for &(slice, weight) in corners {
            if weight > 0.0 {
                for (node, w) in nodes {
                    let value = self.rgb[slice * self.side * self.side + node];
                    for c in 0..3 {
                        sum[c] += value[c] * (w * weight);
                    }
                }
            }
        }
        sum
    }
}

/// Values by (slice, colour, node) to colours by (slice, node).
fn to_rgb(values: &[f32], weights: &[[f64; 3]], area: usize) -> Vec<[f32; 3]> {
    let mut out = Vec::with_capacity(values.len() / weights.len().max(1));
    for slice in values.chunks_exact(weights.len() * area) {
        for node in 0..area {
            let mut sum = [0.0f64; 3];
            for (k, w) in weights.iter().enumerate() {
                for c in 0..3 {
                    sum[c] += slice[k * area + node] as f64 * w[c];
                }
            }
            out.push(sum.map(|v| v as f32));
        }
    }
    out
}
