//! Tables of Mueller matrices over Rusinkiewicz's angles.
//!
//! Baek, Zeltner, Ku, Hwang, Tong, Jakob, Kim 2020, "Image-Based Acquisition and Modeling of Polarimetric Reflectance": for an
//! isotropic material a 4 × 4 matrix per (φd, θd, θh, wavelength), in the array `M`. Of unpolarised light the element M00 is
//! reflected as f; nothing else is kept.
//!
//! θh is the half vector's angle to the normal, θd `wi`'s to the half vector, φd `wi`'s azimuth around it, counted from the direction
//! in which the half vector leans away from the normal (Rusinkiewicz 1998). The arrays `phi_d`, `theta_d`, `theta_h` say at which
//! angles, in radians; where they are empty (a shape 0 × n, as in reduced files) the n angles are even: φd over −π..π, the
//! others over 0..π/2.

use super::{
    MeasuredError, half,
    observer::rec709_weights,
    tensor::{F32, TensorFile, U16},
    warp::{Places, Warp, interval},
};
use crate::{
    math::{asin, atan2_turns, sin_cos_tau},
    sampling::cosine_hemisphere,
};
use core::f32::consts::{FRAC_1_PI, FRAC_PI_2, PI, TAU};
use etendue_color::Spectrum;
use glam::{Vec3A, vec3a};

/// Nodes of the sampling table along u and v.
const WIDTH: usize = 48;
const HEIGHT: usize = 32;
/// Its places along θo, degrees: close where lobes change fastest.
const PLACES: [f32; 14] = [0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 58.0, 65.0, 71.0, 76.0, 80.0, 83.5, 86.5, 89.0];
/// The part of samples that follow the cosine: it bounds a weight where the table misses light between its nodes.
const COSINE_PART: f32 = 0.125;

/// A material's table.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Polarised {
    phi_d: Vec<f32>,
    theta_d: Vec<f32>,
    theta_h: Vec<f32>,
    /// Linear Rec.709 by (φd, θd, θh).
    rgb: Vec<[f32; 3]>,
    places: Places,
    sampler: Warp,
}

impl Polarised {
    /// Reads the arrays `phi_d`, `theta_d`, `theta_h`, `wvls` and `M`.
    pub fn read(file: &TensorFile) -> Result<Self, MeasuredError> {
        let matrices = file.expect("M", 6, F32)?;
        let [np, nd, nh, nw, rows, columns] = [0, 1, 2, 3, 4, 5].map(|i| matrices.shape[i]);
        if rows != 4 || columns != 4 || nw == 0 || [np, nd, nh].contains(&0) {
            return Err(matrices.wrong("phi_d × theta_d × theta_h × wvls × 4 × 4 values"));
        }
        let angles = |name, n: usize, low: f32, high: f32| {
            let field = file.expect(name, 2, F32)?;
            match field.shape[..] {
                [0, m] if m == n => {
                    let step = (high - low) / (n.max(2) - 1) as f32;
                    Ok((0..n).map(|i| low + step * i as f32).collect())
                }
                [1, m] if m == n => field.places(),
                _ => Err(field.wrong("a row of angles, as many as M has")),
            }
        };
        let phi_d = angles("phi_d", np, -PI, PI)?;
        let theta_d = angles("theta_d", nd, 0.0, FRAC_PI_2)?;
        let theta_h = angles("theta_h", nh, 0.0, FRAC_PI_2)?;
        let bands = file.expect("wvls", 1, U16)?;
        let (words, _) = bands.bytes.as_chunks::<2>();
        let wavelengths: Vec<f32> = words.iter().map(|&w| u16::from_le_bytes(w) as f32).collect();
        if wavelengths.len() != nw || !wavelengths.windows(2).all(|w| w[0] < w[1]) {
            return Err(bands.wrong("increasing wavelengths, as many as M has"));
        }
        let weights = rec709_weights(&wavelengths);
        let (words, _) = matrices.bytes.as_chunks::<4>();
        let mut rgb = Vec::with_capacity(np * nd * nh);
        for bands in words.chunks_exact(nw * 16) {
            let mut sum = [0.0f64; 3];
            for (matrix, w) in bands.chunks_exact(16).zip(&weights) {
                let m00 = f32::from_le_bytes(matrix[0]);
                // What could not be measured, transmission for instance, is written as NaN.
                let m00 = if m00.is_nan() { 0.0 } else { m00 as f64 };
                for c in 0..3 {
                    sum[c] += m00 * w[c];
                }
            }
            let colour = sum.map(|v| v.max(0.0) as f32);
            if !colour.iter().all(|v| v.is_finite()) {
                return Err(matrices.wrong("no infinite numbers"));
            }
            rgb.push(colour);
        }
        let places = Places { first: vec![0.0], second: PLACES.iter().map(|d| d * (PI / 180.0)).collect() };
        let mut out = Self { phi_d, theta_d, theta_h, rgb, places, sampler: Warp::new(WIDTH, HEIGHT, &[]) };
        out.sampler = Warp::new(WIDTH, HEIGHT, &out.targets());
        Ok(out)
    }

    /// What the sampling table shall be in proportion to: the light's sum over lanes, as a density of (u, v).
    fn targets(&self) -> Vec<f32> {
        let mut values = Vec::with_capacity(PLACES.len() * WIDTH * HEIGHT);
        for degrees in PLACES {
            let (sin, cos) = sin_cos_tau(degrees / 360.0);
            let wo = vec3a(sin, 0.0, cos);
            for j in 0..HEIGHT {
                for i in 0..WIDTH {
                    let at = [i as f32 / (WIDTH - 1) as f32, j as f32 / (HEIGHT - 1) as f32];
                    let m = half::direction(at, 0.0);
                    let wi = m * (2.0 * wo.dot(m)) - wo;
                    let value = if wi.z > 0.0 && wo.dot(m) > 0.0 {
                        let [r, g, b, _] = self.value(wo, wi).0;
                        (r + g + b) * wi.z * half::jacobian(wo, m, at[0])
                    } else {
                        0.0
                    };
                    values.push(value);
                }
            }
        }
        values
    }

    /// f.
    pub fn value(&self, wo: Vec3A, wi: Vec3A) -> Spectrum {
        let h = (wo + wi).normalize();
        let theta_h = half::elevation(h);
        let theta_d = asin(0.5 * (wi - wo).length());
        // The half vector's own frame: b horizontal, t away from the normal, both as long as its sine.
        let b = wi.y * h.x - wi.x * h.y;
        let t = (wi.x * h.x + wi.y * h.y) * h.z - wi.z * (h.x * h.x + h.y * h.y);
        let phi_d = atan2_turns(b, t) * TAU;
        let (i, a) = interval(&self.phi_d, phi_d);
        let (j, b) = interval(&self.theta_d, theta_d);
        let (k, c) = interval(&self.theta_h, theta_h);
        let mut sum = [0.0f32; 3];
        for corner in 0..8 {
            let (x, y, z) = (corner & 1, corner >> 1 & 1, corner >> 2);
            let side = |step: usize, t: f32| if step == 0 { 1.0 - t } else { t };
            let weight = side(x, a) * side(y, b) * side(z, c);
            if weight > 0.0 {
                let [p, d, h] = [i + x, j + y, k + z];
                let value = self.rgb[(p * self.theta_d.len() + d) * self.theta_h.len() + h];
                for c in 0..3 {
                    sum[c] += value[c] * weight;
                }
            }
        }
        Spectrum::from_rgb(sum)
    }

    /// Density of `wi`.
    pub fn pdf(&self, wo: Vec3A, wi: Vec3A) -> f32 {
        let m = (wo + wi).normalize();
        let at = half::coordinates(m, half::azimuth(wo));
        let corners = self.places.around(0.0, half::elevation(wo));
        let table = self.sampler.density(&corners, at) / half::jacobian(wo, m, at[0]);
        COSINE_PART * FRAC_1_PI * wi.z + (1.0 - COSINE_PART) * table
    }

    /// A direction; its density is that of [`Polarised::pdf`].
    pub fn sample(&self, wo: Vec3A, uc: f32, u: [f32; 2]) -> Vec3A {
        if uc < COSINE_PART {
            return cosine_hemisphere(u);
        }
        let corners = self.places.around(0.0, half::elevation(wo));
        let m = half::direction(self.sampler.sample(&corners, u), half::azimuth(wo));
        m * (2.0 * wo.dot(m)) - wo
    }
}
