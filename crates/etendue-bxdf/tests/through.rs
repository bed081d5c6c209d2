//! The laws on both sides of a surface, on a rough interface written out from its paper: Walter et al. 2007,
//! "Microfacet Models for Refraction through Rough Surfaces". It is not one of the crate's lobes, so that the laws and
//! the lobes do not share their mistakes; what it leaves out (single scattering loses light) is known.

use etendue_bxdf::{
    Bsdf, BsdfSample, DeltaPart, Eval, Ggx, LobeKind,
    bsdf::MIN_COS,
    fresnel::dielectric,
    laws::{
        chi2, furnace,
        grid::{anisotropic_alpha, wo_at},
        reciprocity, sampling, sidak,
    },
    model::Transport,
    quadrature::{directional_albedo, pdf_integral},
    reflectance::{bihemispherical, directional_hemispherical, hemispherical_directional},
};
use etendue_color::Spectrum;
use glam::Vec3A;

/// What is wrong with the interface, to see that a law catches it.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Planted {
    Nothing,
    /// The Jacobian of refraction without η², in the density only.
    Jacobian,
    /// αx and αy exchanged when sampling.
    Alpha,
    /// No compression of radiance.
    Compression,
    /// A tenth more light in the transmitted lobe.
    Light,
}

#[derive(Clone, Copy, Debug)]
struct Interface {
    alpha: [f32; 2],
    eta: f32,
    transport: Transport,
    planted: Planted,
}

impl Interface {
    fn scale(&self) -> f32 {
        match self.transport {
            Transport::Radiance if self.planted != Planted::Compression => 1.0 / (self.eta * self.eta),
            _ => 1.0,
        }
    }

    /// The transmitted or reflected half vector, towards +z.
    fn half(&self, wo: Vec3A, wi: Vec3A) -> Vec3A {
        let h = if wi.z > 0.0 { wo + wi } else { wo + wi * self.eta };
        let m = h.normalize();
        if m.z < 0.0 { -m } else { m }
    }
}

impl Bsdf for Interface {
    fn eval_pdf(&self, wo: Vec3A, wi: Vec3A) -> Eval {
        if !(wo.z > MIN_COS && wi.z.abs() > MIN_COS) {
            return Eval::ZERO;
        }
        let ggx = Ggx::new(self.alpha[0], self.alpha[1]);
        let m = self.half(wo, wi);
        let (om, im) = (wo.dot(m), wi.dot(m));
        if om <= 0.0 || (im > 0.0) != (wi.z > 0.0) {
            return Eval::ZERO;
        }
        let f = dielectric(om, self.eta);
        let density = ggx.pdf_half(wo, m);
        let (value, pdf) = if wi.z > 0.0 {
            (f * ggx.d(m) * ggx.g2(wo, wi) / (4.0 * wo.z * wi.z), f * density / (4.0 * om))
        } else {
            let root = om + self.eta * im;
            let eta2 = self.eta * self.eta;
            let jacobian = eta2 * im.abs() / (root * root);
            // Separable masking for light that passes.
            let g = ggx.g1(wo) * ggx.g1(wi);
            let light = if self.planted == Planted::Light { 1.1 } else { 1.0 };
            let value = light * (1.0 - f) * ggx.d(m) * g * om * jacobian / (wo.z * wi.z.abs()) * self.scale();
            let jacobian = if self.planted == Planted::Jacobian { jacobian / eta2 } else { jacobian };
            (value, (1.0 - f) * density * jacobian)
        };
        Eval { diffuse: Spectrum::ZERO, specular: Spectrum::splat(value), pdf }
    }

    fn sample(&self, wo: Vec3A, uc: f32, u: [f32; 2]) -> Option<BsdfSample> {
        let [x, y] = self.alpha;
        let ggx = if self.planted == Planted::Alpha { Ggx::new(y, x) } else { Ggx::new(x, y) };
        let m = ggx.sample_half(wo, u);
        let om = wo.dot(m);
        let wi = if uc < dielectric(om, self.eta) {
            m * (2.0 * om) - wo
        } else {
            let sin2 = (1.0 - om * om) / (self.eta * self.eta);
            (m * (om / self.eta - (1.0 - sin2).sqrt()) - wo / self.eta).normalize()
        };
        let up = uc < dielectric(om, self.eta);
        let e = self.eval_pdf(wo, wi);
        if up != (wi.z > 0.0) || e.pdf <= 0.0 {
            return None;
        }
        let weight = e.specular * (wi.z.abs() / e.pdf);
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

    fn albedo(&self, _wo: Vec3A) -> Spectrum {
        Spectrum::ONE
    }

    fn narrowest_alpha(&self) -> [f32; 2] {
        self.alpha
    }

    fn refraction(&self) -> Option<f32> {
        Some(self.eta)
    }
}

/// A smooth interface: reflection and transmission without width.
#[derive(Clone, Copy, Debug)]
struct Smooth {
    eta: f32,
    transport: Transport,
}

impl Bsdf for Smooth {
    fn eval_pdf(&self, _wo: Vec3A, _wi: Vec3A) -> Eval {
        Eval::ZERO
    }

    fn sample(&self, wo: Vec3A, uc: f32, _u: [f32; 2]) -> Option<BsdfSample> {
        let [reflected, refracted] = self.deltas(wo);
        let part = if uc < dielectric(wo.z, self.eta) { reflected } else { refracted }?;
        let weight = part.reflectance / part.probability;
        Some(BsdfSample {
            wi: part.wi,
            weight,
            weight_diffuse: Spectrum::ZERO,
            weight_specular: weight,
            pdf: part.probability,
            delta: true,
            lobe: LobeKind::Specular,
        })
    }

    fn albedo(&self, _wo: Vec3A) -> Spectrum {
        Spectrum::ONE
    }

    fn deltas(&self, wo: Vec3A) -> [Option<DeltaPart>; 2] {
        let f = dielectric(wo.z, self.eta);
        let scale = match self.transport {
            Transport::Radiance => 1.0 / (self.eta * self.eta),
            Transport::Importance => 1.0,
        };
        let sin2 = (1.0 - wo.z * wo.z) / (self.eta * self.eta);
        let part = |wi, r, probability| DeltaPart { wi, reflectance: Spectrum::splat(r), probability };
        let down = Vec3A::new(-wo.x / self.eta, -wo.y / self.eta, -(1.0 - sin2).max(0.0).sqrt());
        [
            Some(part(Vec3A::new(-wo.x, -wo.y, wo.z), f, f)),
            (f < 1.0).then(|| part(down, (1.0 - f) * scale, 1.0 - f)),
        ]
    }

    fn refraction(&self) -> Option<f32> {
        Some(self.eta)
    }
}

const ETAS: [f32; 4] = [1.0 / 2.42, 1.0 / 1.5, 1.33, 1.5];
const ANGLES: [f32; 4] = [0.0, 40.0, 70.0, 89.0];

fn interfaces(planted: Planted, transport: Transport) -> Vec<Interface> {
    let mut out = Vec::new();
    for eta in ETAS {
        for (roughness, anisotropy) in [(0.01, 0.0), (0.1, 0.9), (0.5, 0.5), (1.0, 0.0)] {
            let alpha = anisotropic_alpha(roughness, anisotropy);
            out.push(Interface { alpha, eta, transport, planted });
        }
    }
    out
}

/// Smallest p over the interfaces and angles, and how many there are.
fn worst_p(planted: Planted) -> (f64, usize) {
    let mut worst = 1.0f64;
    let mut cells = 0;
    for b in interfaces(planted, Transport::Radiance) {
        for angle in ANGLES {
            cells += 1;
            let found = chi2::chi2(&b, wo_at(angle), 50_000, cells as u64);
            if found.p < worst {
                worst = found.p;
                println!("{b:?} {angle}°: {found:?}");
            }
        }
    }
    (worst, cells)
}

#[test]
fn refracted_samples_follow_their_density() {
    let (p, cells) = worst_p(Planted::Nothing);
    assert!(p >= sidak(0.01, cells), "p {p} in one of {cells} cells");
}

#[test]
fn a_wrong_density_and_a_swapped_alpha_are_caught() {
    assert!(worst_p(Planted::Jacobian).0 < 1e-12);
    assert!(worst_p(Planted::Alpha).0 < 1e-12);
}

#[test]
fn an_interface_keeps_energy_and_is_reciprocal() {
    for b in interfaces(Planted::Nothing, Transport::Importance) {
        let other = Interface { eta: 1.0 / b.eta, ..b };
        for angle in ANGLES {
            let wo = wo_at(angle);
            let f = furnace::furnace(&b, wo, 20_000, 5);
            let at = format!("{b:?} {angle}°: {f:?}");
            assert!(f.albedo[0] <= 1.0 + 1e-3 && f.z < 4.5, "{at}");
            // What is lost is lost between microfacets.
            assert!(b.alpha[0] > 1e-3 || angle > 80.0 || f.albedo[0] > 0.999, "{at}");
            let m = sampling::samples(&b, wo, 5_000, 6);
            assert!(!m.broken && m.z < 4.5 && m.weight_error < 2e-2, "{b:?} {angle}°: {m:?}");
            assert!(m.pdf_integral <= 1.0 + 2e-5);
        }
        // The half vector of this plain writing-out loses digits where α is small.
        for transport in [Transport::Radiance, Transport::Importance] {
            let (near, far) = (Interface { transport, ..b }, Interface { transport, ..other });
            let r = reciprocity::reciprocity_through(&near, &far, transport, 20_000, 7);
            assert!(b.alpha[0] < 0.1 || r.error < 2e-3, "{b:?}: {r:?}");
        }
    }
}

#[test]
fn missing_compression_and_added_light_are_caught() {
    let of = |planted, transport, eta| Interface { alpha: [0.09; 2], eta, transport, planted };
    let (near, far) = (
        of(Planted::Compression, Transport::Radiance, 1.5),
        of(Planted::Compression, Transport::Radiance, 1.0 / 1.5),
    );
    let r = reciprocity::reciprocity_through(&near, &far, Transport::Radiance, 2_000, 1);
    assert!(r.error > 0.5, "{r:?}");
    let bright = of(Planted::Light, Transport::Importance, 1.5);
    assert!(directional_albedo(&bright, wo_at(30.0))[0] > 1.05);
}

/// The reflectances of Nicodemus against each other and against Fresnel's formula.
#[test]
fn reflectances_of_an_interface_are_what_fresnel_says() {
    for eta in ETAS {
        let of = |eta, transport| Smooth { eta, transport };
        let (near, far) = (of(eta, Transport::Radiance), of(1.0 / eta, Transport::Radiance));
        for angle in ANGLES {
            let w = wo_at(angle);
            let f = dielectric(w.z, eta);
            let seen = hemispherical_directional(&near, w);
            let sent = directional_hemispherical(&near, Some(&far), w);
            let power = hemispherical_directional(&of(eta, Transport::Importance), w);
            assert!((seen.reflection[0] - f).abs() < 1e-6);
            assert!((seen.transmission[0] * eta * eta - (1.0 - f)).abs() < 1e-5);
            assert!((power.total()[0] - 1.0).abs() < 1e-6);
            assert!((sent.total()[0] - 1.0).abs() < 2e-4, "η {eta} {angle}°: {sent:?}");
            assert!((sent.reflection[0] - f).abs() < 1e-6);
        }
        // The diffuse reflectance of an interface of 1.5: 0.0918 from outside (Walsh 1926), and from inside by
        // conservation of étendue 1 − (1 − 0.0918)/1.5² = 0.5964.
        if eta == 1.5 {
            let (outside, inside) = (bihemispherical(&near), bihemispherical(&far));
            assert!((outside.reflection[0] - 0.0918).abs() < 2e-4, "{outside:?}");
            assert!((inside.reflection[0] - 0.5964).abs() < 2e-4, "{inside:?}");
        }
    }
    // Rough: the two directional kinds agree when what passes is counted as power.
    for b in interfaces(Planted::Nothing, Transport::Radiance) {
        let far = Interface { eta: 1.0 / b.eta, ..b };
        for angle in [0.0, 40.0, 70.0] {
            let w = wo_at(angle);
            let sent = directional_hemispherical(&b, Some(&far), w);
            let power = hemispherical_directional(&Interface { transport: Transport::Importance, ..b }, w);
            let tolerance = if b.alpha[0] < 1e-3 { 2e-3 } else { 1e-4 };
            let difference = (sent.transmission - power.transmission).map(f32::abs).max_element();
            assert!(difference < tolerance, "{b:?} {angle}°: {sent:?} {power:?}");
            assert!((sent.reflection - power.reflection).map(f32::abs).max_element() < 1e-4);
            assert!(pdf_integral(&b, w) <= 1.0 + 2e-5);
        }
    }
}
