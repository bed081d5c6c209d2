//! Two interfaces with or without a medium between them, by random walk: the measure of every cheaper layering.
//!
//! Light is followed through the stack in directions and depths only, without positions across it (Guo, Hašan, Zhao 2018,
//! "Position-Free Monte Carlo Simulation for Arbitrary Layered BSDFs"). Everything that the layers do to each other is in it:
//! refraction at both sides, interreflection, internal total reflection, absorption and scattering between.
//!
//! [`Layered`] is not a [`Bsdf`]: its value and its samples are estimates, each with noise of its own, and the density of a
//! walk's end is not known; the contract's weight = eval · cos / pdf holds only in the mean. What it offers instead:
//! [`Layered::eval`] (unbiased, average many), [`Layered::sample`] (a direction and an unbiased weight) and
//! [`Layered::albedo`] (mean and standard error).
//!
//! What passes the bottom is lost.
//!
//! # Figures
//! How far glTF's albedo-scaled coat ([`crate::gltf`], coverage 1) is from the walk: directional albedo (`cargo run --release -p
//! etendue-bxdf --example layering` prints more rows; standard errors of the walks are below 0.002). The first walk has the same
//! physics as the extension, a coat that does not bend light, and adds what goes to and fro; the second is a real lacquer of
//! index 1.5.
//!
//! | base | coat's roughness | angle | glTF | walk, no refraction | walk, refraction |
//! |---|---|---|---|---|---|
//! | diffuse 1 | 0 | 0° | 1.000 | 1.000 | 1.002 |
//! | diffuse 1 | 0.4 | 60° | 0.995 | 0.990 | 0.848 |
//! | diffuse 0.8 | 0 | 0° | 0.808 | 0.794 | 0.635 |
//! | diffuse 0.8 | 0.4 | 60° | 0.809 | 0.795 | 0.582 |
//! | diffuse 0.2 | 0 | 0° | 0.232 | 0.219 | 0.128 |
//! | diffuse 0.2 | 0 | 80° | 0.528 | 0.518 | 0.443 |
//! | metal 1, smooth | 0 | 60° | 1.000 | 1.000 | 1.000 |
//! | metal 0.5, smooth | 0 | 60° | 0.550 | 0.533 | 0.524 |
//! | metal 0.5, smooth | 0 | 80° | 0.819 | 0.747 | 0.618 |
//! | metal 0.9, roughness 0.4 | 0 | 60° | 0.810 | 0.832 | 0.724 |
//! | metal 0.9, roughness 0.4 | 0.4 | 80° | 0.811 | 0.793 | 0.579 |
//!
//! So the scaling is within 0.03 of its own physics, but for grey metals near grazing (0.07), whose light the coat dims twice
//! and the scaling once. What glTF leaves out is larger: under a real lacquer total reflection sends most of the diffuse
//! light back to the base, which darkens all bases but white ones. (Where the coat is rough the second walk also loses what a
//! single bounce on its facets loses, each time that light passes it.)

use crate::{
    bsdf::Bsdf,
    laws::Rng,
    math::{exp, ln, sin_cos_tau},
    model::{Incidence, Transport},
    reflectance::from_behind,
    sampling::Frame,
};
use core::f32::consts::TAU;
use etendue_color::Spectrum;
use glam::{Vec3A, vec3a};

/// Bounces after which a walk may end by roulette.
const ROULETTE_AFTER: usize = 8;
/// Bounces after which it ends in any case; the roulette lets one walk in 10²⁰ of a lossless stack come so far.
const LONGEST: usize = 1000;

/// A homogeneous medium between two interfaces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slab {
    /// Optical depth across it, along the normal, ≥ 0.
    depth: f32,
    /// Part of the light that an encounter scatters, each lane 0..1.
    albedo: Spectrum,
    /// Mean cosine of the scattering angle, −1..1 (Henyey, Greenstein 1941).
    g: f32,
}

impl Slab {
    /// Nothing between the interfaces.
    pub const EMPTY: Self = Self { depth: 0.0, albedo: Spectrum::ZERO, g: 0.0 };

    /// Optical depth ≥ 0, single-scattering albedo (lanes 0..1), mean cosine −0.99..0.99; out of range is clamped, NaN to the
    /// lower end, of `g` to 0.
    pub fn new(depth: f32, albedo: Spectrum, g: f32) -> Self {
        Self {
            depth: depth.max(0.0).min(1e6),
            albedo: albedo.map(|v| v.max(0.0).min(1.0)),
            g: if g.is_nan() { 0.0 } else { g.clamp(-0.99, 0.99) },
        }
    }

    /// The part of the light that crosses `depth` at an inclination of |cos| `cos`.
    fn crosses(&self, depth: f32, cos: f32) -> f32 {
        if depth > 0.0 { exp(-depth / cos.abs()) } else { 1.0 }
    }

    /// Density of scattering by an angle of cosine `cos`, per steradian.
    fn phase(&self, cos: f32) -> f32 {
        let q = (1.0 + self.g * self.g - 2.0 * self.g * cos).max(1e-9);
        (1.0 - self.g * self.g) / (2.0 * TAU * q * q.sqrt())
    }

    /// A direction from [`Slab::phase`], for light that goes along `w`.
    fn scatter(&self, w: Vec3A, u: [f32; 2]) -> Vec3A {
        let cos = if self.g.abs() < 1e-3 {
            1.0 - 2.0 * u[0]
        } else {
            let r = (1.0 - self.g * self.g) / (1.0 - self.g + 2.0 * self.g * u[0]);
            ((1.0 + self.g * self.g - r * r) / (2.0 * self.g)).clamp(-1.0, 1.0)
        };
        let sin = ((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt();
        let (s, c) = sin_cos_tau(u[1]);
        let out = Frame::from_normal(w).to_world(vec3a(sin * c, sin * s, cos));
        out * (1.0 / out.length_squared().sqrt())
    }
}

/// A top interface over a bottom surface.
///
/// ```
/// use etendue_bxdf::{
///     Lambert, dielectric::{Dielectric, GgxDielectric}, laws::Rng, layered::{Layered, Slab},
/// };
/// use etendue_color::Spectrum;
/// use glam::Vec3A;
///
/// // Smooth varnish of index 1.5 over white chalk: everything comes out again.
/// let varnish = |at: &_| -> GgxDielectric<Dielectric> {
///     let at: &etendue_bxdf::model::Incidence = at;
///     GgxDielectric::new([0.0; 2], Dielectric::new(if at.front { 1.5 } else { 1.0 / 1.5 }), at.transport)
/// };
/// let stack = Layered::new(varnish, Lambert { color: Spectrum::ONE }, Slab::EMPTY);
/// let (mean, error) = stack.albedo(Vec3A::Z, 2000, &mut Rng::new(1));
/// assert!((mean[0] - 1.0).abs() < 4.0 * error[0] + 0.01);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layered<T, B> {
    outside: T,
    inside: T,
    /// From outside, for what light carries: the adjoint of `inside`.
    entering: T,
    bottom: B,
    slab: Slab,
}

/// Where a step through the slab ends.
enum Step {
    Top,
    Bottom,
    Within(f32),
}

impl<T: Bsdf, B: Bsdf> Layered<T, B> {
    /// `top` makes the interface's closure for either side and either kind of transport (`exterior_ior` is 1, all lanes
    /// are there); `bottom` is asked from above.
    pub fn new(top: impl Fn(&Incidence) -> T, bottom: B, slab: Slab) -> Self {
        let at = |front, transport| Incidence { front, transport, ..Incidence::default() };
        Self {
            outside: top(&at(true, Transport::Radiance)),
            inside: top(&at(false, Transport::Radiance)),
            entering: top(&at(true, Transport::Importance)),
            bottom,
            slab,
        }
    }

    /// Flight along `w` from the depth `z` (0 at the top).
    fn step(&self, z: f32, w: Vec3A, rng: &mut Rng) -> Step {
        let depth = self.slab.depth;
        if depth > 0.0 {
            let z = z - w.z * -ln(1.0 - rng.uniform());
            if z > 0.0 && z < depth {
                return Step::Within(z);
            }
        }
        if w.z > 0.0 { Step::Top } else { Step::Bottom }
    }

    /// Ends walks that carry little; false if this one ended.
    fn roulette(bounce: usize, beta: &mut Spectrum, rng: &mut Rng) -> bool {
        if bounce < ROULETTE_AFTER {
            return true;
        }
        let q = beta.max_element().min(0.95);
        let goes_on = rng.uniform() < q;
        *beta *= 1.0 / q.max(1e-6);
        goes_on && bounce < LONGEST
    }

    /// A direction above the stack and its weight f · cos / density; `None` if the walk's light is lost.
    pub fn sample(&self, wo: Vec3A, rng: &mut Rng) -> Option<(Vec3A, Spectrum)> {
        let first = self.outside.sample(wo, rng.uniform(), rng.square())?;
        if first.wi.z > 0.0 {
            return Some((first.wi, first.weight));
        }
        let (mut w, mut beta, mut z) = (first.wi, first.weight, 0.0);
        for bounce in 0.. {
            if !Self::roulette(bounce, &mut beta, rng) {
                return None;
            }
            match self.step(z, w, rng) {
                Step::Within(at) => {
                    beta *= self.slab.albedo;
                    w = self.slab.scatter(w, rng.square());
                    z = at;
                }
                Step::Bottom => {
                    let s = self.bottom.sample(-w, rng.uniform(), rng.square())?;
                    if !(s.wi.z > 0.0) {
                        return None;
                    }
                    (w, z) = (s.wi, self.slab.depth);
                    beta *= s.weight;
                }
                Step::Top => {
                    let s = self.inside.sample(from_behind(-w), rng.uniform(), rng.square())?;
                    beta *= s.weight;
                    (w, z) = (from_behind(s.wi), 0.0);
                    if w.z > 0.0 {
                        return Some((w, beta));
                    }
                }
            }
        }
        None
    }

    /// An unbiased estimate of f(wo, wi), 1/sr, both above the stack; without perfectly specular reflection of the whole
    /// stack.
    ///
    /// Two ways lead to `wi`: from a vertex towards a direction that light takes after it came in from `wi`, and by the
    /// value of the top interface where the walk meets it from below; they are weighted by their densities (Veach 1997, eq. 9.15,
    /// power heuristic).
    pub fn eval(&self, wo: Vec3A, wi: Vec3A, rng: &mut Rng) -> Spectrum {
        let mut sum = self.outside.eval(wo, wi);
        if !(wo.z > 0.0 && wi.z > 0.0) {
            return Spectrum::ZERO;
        }
        let Some(first) = self.outside.sample(wo, rng.uniform(), rng.square()).filter(|s| s.wi.z < 0.0)
        else {
            return sum;
        };
        let light = self.entering.sample(wi, rng.uniform(), rng.square()).filter(|s| s.wi.z < 0.0);
        let (mut w, mut beta, mut z) = (first.wi, first.weight, 0.0);
        for bounce in 0.. {
            if !Self::roulette(bounce, &mut beta, rng) {
                return sum;
            }
            match self.step(z, w, rng) {
                Step::Within(at) => {
                    beta *= self.slab.albedo;
                    z = at;
                    if let Some(l) = light {
                        let towards = self.slab.phase(w.dot(-l.wi));
                        let mis = if l.delta { 1.0 } else { power(l.pdf, towards) };
                        // The weight holds a cosine that a surface needs and a medium does not.
                        let crosses = self.slab.crosses(z, l.wi.z) / l.wi.z.abs();
                        sum += beta * l.weight * (towards * crosses * mis);
                    }
                    let out = self.slab.scatter(w, rng.square());
                    sum += self.seen_from_below(beta, out, wi, z, Some(self.slab.phase(w.dot(out))));
                    w = out;
                }
                Step::Bottom => {
                    if let Some(l) = light {
                        let e = self.bottom.eval_pdf(-w, -l.wi);
                        let mis = if l.delta { 1.0 } else { power(l.pdf, e.pdf) };
                        let crosses = self.slab.crosses(self.slab.depth, l.wi.z);
                        sum += beta * e.value() * l.weight * (crosses * mis);
                    }
                    let Some(s) =
                        self.bottom.sample(-w, rng.uniform(), rng.square()).filter(|s| s.wi.z > 0.0)
                    else {
                        return sum;
                    };
                    beta *= s.weight;
                    (w, z) = (s.wi, self.slab.depth);
                    sum += self.seen_from_below(beta, w, wi, z, (!s.delta).then_some(s.pdf));
                }
                Step::Top => {
                    // Light that leaves here was counted where it started for the top.
                    let Some(s) = self
                        .inside
                        .sample(from_behind(-w), rng.uniform(), rng.square())
                        .filter(|s| s.wi.z > 0.0)
                    else {
                        return sum;
                    };
                    beta *= s.weight;
                    (w, z) = (from_behind(s.wi), 0.0);
                }
            }
        }
        sum
    }

    /// What goes along `w` from the depth `z` and leaves the top towards `wi`; `pdf` is the density of `w`, `None` if it
    /// could not have been any other.
    fn seen_from_below(&self, beta: Spectrum, w: Vec3A, wi: Vec3A, z: f32, pdf: Option<f32>) -> Spectrum {
        if !(w.z > 0.0) {
            return Spectrum::ZERO;
        }
        let f = self.inside.eval(from_behind(-w), from_behind(wi));
        if f.is_black() {
            return f;
        }
        let mis = pdf.map_or(1.0, |p| power(p, self.entering.pdf(wi, -w)));
        beta * f * (self.slab.crosses(z, w.z) * mis)
    }

    /// Directional albedo and its standard error, by `walks` ≥ 2 walks.
    pub fn albedo(&self, wo: Vec3A, walks: usize, rng: &mut Rng) -> (Spectrum, Spectrum) {
        let n = walks.max(2);
        let (mut first, mut second) = ([0.0f64; 4], [0.0f64; 4]);
        for _ in 0..n {
            let weight = self.sample(wo, rng).map_or(Spectrum::ZERO, |s| s.1);
            for lane in 0..4 {
                first[lane] += weight[lane] as f64;
                second[lane] += weight[lane] as f64 * weight[lane] as f64;
            }
        }
        let n = n as f64;
        let mean = first.map(|v| v / n);
        let error =
            core::array::from_fn(|i| ((second[i] / n - mean[i] * mean[i]).max(0.0) / n).sqrt() as f32);
        (Spectrum(mean.map(|v| v as f32)), Spectrum(error))
    }
}

/// a² / (a² + b²).
fn power(a: f32, b: f32) -> f32 {
    crate::sampling::power_heuristic(a, b)
}
