//! The environment as a light: radiance by direction, and directions by radiance.

use crate::distribution::Distribution2;
use etendue_bxdf::math::{acos, atan2_turns, sin_cos_tau};
use etendue_color::Spectrum;
use etendue_scene::Environment;
use glam::Vec3A;
use std::f32::consts::{FRAC_1_PI, PI};

/// A sky that can be looked up and sampled.
#[derive(Clone, Debug)]
pub struct Sky {
    texels: Vec<Spectrum>,
    width: usize,
    height: usize,
    /// Turns of the picture: added to u.
    turn: f32,
    distribution: Option<Distribution2>,
    irradiance: f32,
}

/// A direction drawn from the sky.
#[derive(Clone, Copy, Debug)]
pub struct SkySample {
    /// Unit vector towards the sky.
    pub wi: Vec3A,
    /// Light from there.
    pub radiance: Spectrum,
    /// Density per solid angle.
    pub pdf: f32,
}

impl Sky {
    /// Prepares `environment`.
    ///
    /// Directions are drawn from what exceeds the sky's mean (Karlík et al. 2019, "MIS Compensation", section 5.2): scattering
    /// finds the even part by itself, so light sampling spends its samples where light is concentrated. A constant sky is
    /// never sampled at all.
    pub fn new(environment: &Environment) -> Self {
        match environment {
            Environment::Constant(c) => Self {
                texels: vec![Spectrum::from_rgb(c.to_array())],
                width: 1,
                height: 1,
                turn: 0.0,
                distribution: None,
                irradiance: 0.0,
            },
            Environment::LatLong { image, rotation, intensity } => {
                let (w, h) = (image.width as usize, image.height as usize);
                let grey = image.channels < 3;
                let mut texels = Vec::with_capacity(w * h);
                for y in 0..image.height {
                    for x in 0..image.width {
                        let c = |c: u8| image.sample(x, y, if grey { 0 } else { c }) * intensity;
                        texels.push(Spectrum::rgb(c(0), c(1), c(2)));
                    }
                }
                let turn = turns(*rotation);
                let (distribution, irradiance) = concentrated_part(&texels, w, h);
                Self { texels, width: w, height: h, turn, distribution, irradiance }
            }
        }
    }

    /// The same sky, turned to `rotation` instead (radians; see [`Environment::LatLong`]).
    pub(crate) fn turned(self, rotation: f32) -> Self {
        Self { turn: turns(rotation), ..self }
    }

    /// True if directions can be drawn; otherwise the sky is constant and scattering alone finds it.
    pub fn is_sampled(&self) -> bool {
        self.distribution.is_some()
    }

    /// Rough irradiance from the sampled part of the sky on a surface of unknown orientation.
    pub fn sampled_irradiance(&self) -> f32 {
        self.irradiance
    }

    /// Radiance from the direction `d` (unit), bilinear.
    #[inline(always)]
    pub fn radiance(&self, d: Vec3A) -> Spectrum {
        if self.texels.len() == 1 {
            return self.texels[0];
        }
        let (u, v) = self.coordinates(d);
        self.bilinear(u, v)
    }

    /// Radiance from the direction `d` (unit), and the density per solid angle with which [`Sky::sample`] draws it.
    #[inline(always)]
    pub fn radiance_and_pdf(&self, d: Vec3A) -> (Spectrum, f32) {
        let Some(distribution) = &self.distribution else { return (self.radiance(d), 0.0) };
        let (u, v) = self.coordinates(d);
        let cell = |t: f32, n: usize| ((t * n as f32) as usize).min(n - 1);
        let sin_theta = (1.0 - d.y * d.y).max(0.0).sqrt();
        let density = distribution.density(cell(u, self.width), cell(v, self.height));
        let pdf = if sin_theta > 0.0 { density * (0.5 * FRAC_1_PI * FRAC_1_PI) / sin_theta } else { 0.0 };
        (self.bilinear(u, v), pdf)
    }

    /// Draws a direction; `None` if the sky is constant.
    #[inline(always)]
    pub fn sample(&self, u: [f32; 2]) -> Option<SkySample> {
        let (p, density) = self.distribution.as_ref()?.sample(u);
        let (sin_theta, cos_theta) = sin_cos_tau(p[1] * 0.5);
        let mut a = p[0] - 0.5 - self.turn;
        if a < 0.0 {
            a += 1.0;
        }
        if a < 0.0 {
            a += 1.0;
        }
        let (sin_phi, cos_phi) = sin_cos_tau(a);
        if sin_theta <= 0.0 || density <= 0.0 {
            return None;
        }
        Some(SkySample {
            wi: Vec3A::new(sin_theta * cos_phi, cos_theta, sin_theta * sin_phi),
            radiance: self.bilinear(p[0], p[1]),
            pdf: density * (0.5 * FRAC_1_PI * FRAC_1_PI) / sin_theta,
        })
    }

    #[inline(always)]
    fn coordinates(&self, d: Vec3A) -> (f32, f32) {
        let u = atan2_turns(d.z, d.x) + 0.5 + self.turn;
        // Between 0 and 2: at most one turn too far.
        (if u >= 1.0 { u - 1.0 } else { u }, acos(d.y) * FRAC_1_PI)
    }

    #[inline(always)]
    fn bilinear(&self, u: f32, v: f32) -> Spectrum {
        let (x, y) = (u * self.width as f32 - 0.5, v * self.height as f32 - 0.5);
        // Truncation of what is at least 0 is the floor; the baseline x86-64 has no instruction for the floor itself.
        let (ix, iy) = ((x + 1.0) as i32 - 1, (y + 1.0) as i32 - 1);
        let (tx, ty) = (x - ix as f32, y - iy as f32);
        let (w, h) = (self.width as i32, self.height as i32);
        let wrap = |i: i32| {
            (if i < 0 {
                i + w
            } else if i >= w {
                i - w
            } else {
                i
            }) as usize
        };
        let (x0, x1) = (wrap(ix), wrap(ix + 1));
        let row = |i: i32| i.clamp(0, h - 1) as usize * self.width;
        let (y0, y1) = (row(iy), row(iy + 1));
        let t = |i: usize| self.texels[i];
        (t(y0 + x0) * (1.0 - tx) + t(y0 + x1) * tx) * (1.0 - ty)
            + (t(y1 + x0) * (1.0 - tx) + t(y1 + x1) * tx) * ty
    }
}

/// Radians as turns between 0 and 1.
fn turns(rotation: f32) -> f32 {
    (f64::from(rotation) / std::f64::consts::TAU).rem_euclid(1.0) as f32
}

/// The density over the picture of what exceeds the sky's mean, and that part's irradiance.
fn concentrated_part(texels: &[Spectrum], w: usize, h: usize) -> (Option<Distribution2>, f32) {
    let grey = |s: Spectrum| (s[0] + s[1] + s[2]) * (1.0 / 3.0);
    // The mean of the bilinear picture over each texel's cell, so that no bright texel leaks out of its density.
    let smooth: Vec<f32> = (0..w * h)
        .map(|i| {
            let (x, y) = (i % w, i / w);
            let at = |dx: usize, dy: usize| {
                let yy = (y + dy).saturating_sub(1).min(h - 1);
                grey(texels[yy * w + (x + dx + w - 1) % w])
            };
            let row = |dy| 0.125 * at(0, dy) + 0.75 * at(1, dy) + 0.125 * at(2, dy);
            0.125 * row(0) + 0.75 * row(1) + 0.125 * row(2)
        })
        .collect();
    let sin = |y: usize| sin_cos_tau((y as f32 + 0.5) / h as f32 * 0.5).0.max(0.0);
    let total_sin: f64 = (0..h).map(|y| f64::from(sin(y)) * w as f64).sum();
    let mean: f64 =
        smooth.iter().enumerate().map(|(i, v)| f64::from(v * sin(i / w))).sum::<f64>() / total_sin;
    let weights: Vec<f32> =
        smooth.iter().enumerate().map(|(i, v)| (v - mean as f32).max(0.0) * sin(i / w)).collect();
    let d = Distribution2::new(&weights, w);
    let excess = d.total() / total_sin;
    // Rounding alone must not make a constant picture look concentrated.
    if excess <= mean * 1e-4 {
        return (None, 0.0);
    }
    (Some(d), PI * excess as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue_image::{Image, Pixels};
    use std::f32::consts::TAU;
    use std::sync::Arc;

    fn lumpy(rotation: f32) -> Sky {
        let (w, h) = (32, 16);
        let mut p = vec![0.25f32; w * h * 3];
        for c in 0..3 {
            p[(3 * w + 20) * 3 + c] = 90.0;
            p[(12 * w + 31) * 3 + c] = 40.0;
            p[c] = 30.0;
        }
        let image = Image { width: w as u32, height: h as u32, channels: 3, pixels: Pixels::F32(p) };
        Sky::new(&Environment::LatLong { image: Arc::new(image), rotation, intensity: 1.0 })
    }

    /// The picture's centre is +X, its left edge −X, a quarter in from the right is +Z; v runs from +Y down; turning the sky
    /// by a quarter, counter-clockwise from above, brings what was at +X to −Z.
    #[test]
    fn directions_follow_the_convention() {
        let s = lumpy(0.0);
        let near = |a: (f32, f32), b: (f32, f32)| {
            assert!((a.0 - b.0).abs() < 1e-6 && (a.1 - b.1).abs() < 1e-6, "{a:?}")
        };
        near(s.coordinates(Vec3A::X), (0.5, 0.5));
        near(s.coordinates(Vec3A::Z), (0.75, 0.5));
        near(s.coordinates(Vec3A::NEG_Z), (0.25, 0.5));
        assert!(s.coordinates(Vec3A::Y).1 < 1e-3 && s.coordinates(Vec3A::NEG_Y).1 > 0.999);
        near(lumpy(PI * 0.5).coordinates(Vec3A::NEG_Z), (0.5, 0.5));
    }

    /// `sample` and `radiance_and_pdf` agree on radiance and density, and the density integrates to 1.
    #[test]
    fn sampling_and_lookup_agree() {
        for rotation in [0.0, 1.0, -2.5] {
            let s = lumpy(rotation);
            let mut strays = 0;
            for i in 0..64 {
                for j in 0..64 {
                    let k = s.sample([(i as f32 + 0.37) / 64.0, (j as f32 + 0.61) / 64.0]).unwrap();
                    assert!((k.wi.length() - 1.0).abs() < 1e-5);
                    let (radiance, pdf) = s.radiance_and_pdf(k.wi);
                    // A direction on the border of two cells may fall into the other by rounding.
                    strays += u32::from((pdf - k.pdf).abs() > 1e-2 * k.pdf);
                    assert!((radiance[0] - k.radiance[0]).abs() < 2e-2 * k.radiance[0], "{radiance:?} {k:?}");
                }
            }
            assert!(strays < 8, "{strays} of 4096 densities differ");
            let (n, mut sum) = (512, 0.0f64);
            for i in 0..n {
                for j in 0..2 * n {
                    let (z, phi) =
                        (1.0 - 2.0 * (i as f32 + 0.5) / n as f32, TAU * (j as f32 + 0.5) / (2 * n) as f32);
                    let r = (1.0 - z * z).sqrt();
                    sum += f64::from(s.radiance_and_pdf(Vec3A::new(r * phi.cos(), z, r * phi.sin())).1);
                }
            }
            let integral = sum * 4.0 * std::f64::consts::PI / f64::from(2 * n * n);
            assert!((integral - 1.0).abs() < 5e-3, "{integral}");
        }
    }

    #[test]
    fn constant_skies_are_left_to_scattering() {
        assert!(!Sky::new(&Environment::Constant(glam::Vec3::ONE)).is_sampled());
        let image = Image { width: 8, height: 4, channels: 3, pixels: Pixels::F32(vec![0.7; 96]) };
        assert!(
            !Sky::new(&Environment::LatLong { image: Arc::new(image), rotation: 0.0, intensity: 2.0 })
                .is_sampled()
        );
    }
}
