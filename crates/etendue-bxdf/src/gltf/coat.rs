//! The lacquer of `KHR_materials_clearcoat` and `KHR_materials_coat`: a layer with its own index, normal and roughness.

use super::{extended::unit, facet::Facet, params::GltfParams, shape::Shape};
use crate::{
    bsdf::MIN_COS,
    energy::Row,
    fresnel::{f0_from_ior, schlick_weight},
    ggx::{ALPHA_DELTA, Ggx, mirror},
    sampling::Frame,
    varnish::{Under, Varnish},
};
use etendue_color::Spectrum;
use glam::Vec3A;

/// Reflectance of a layer of index 1.5 at normal incidence.
const F0: f32 = 0.04;

/// Reflectance of a layer at normal incidence; of index 1.5 the number that `KHR_materials_clearcoat` has, to the bit.
#[inline]
pub fn coat_f0(ior: f32) -> f32 {
    if ior == 1.5 { F0 } else { f0_from_ior(ior) }
}

/// What a coat takes from the light of what lies below, besides what it reflects: by its colour, and by the light that goes to and
/// fro. Angles are to the coat's normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tint {
    coverage: f32,
    f0: f32,
    varnish: Varnish,
}

impl Tint {
    /// `None` if the coat is clear and does not darken, or is not there.
    #[inline]
    pub fn new(p: &GltfParams) -> Option<Self> {
        let (coverage, color) = (unit(p.clearcoat), p.coat_color.map(unit));
        let darkening = coverage * unit(p.coat_darkening);
        (coverage > 0.0 && (color != Spectrum::ONE || darkening > 0.0)).then(|| {
            // An infinite index bends light straight down.
            let eta = if p.coat_ior == 0.0 { 1e3 } else { p.coat_ior.max(1.0).min(1e3) };
            let varnish = Varnish::new(eta, color, under(p), darkening);
            Self { coverage, f0: coat_f0(p.coat_ior), varnish }
        })
    }

    /// The factor for light between a viewer at an angle of cosine `o` and light that passes the coat at one of cosine `i`, or does
    /// not pass it.
    #[inline(always)]
    pub fn pair(&self, o: f32, i: Option<f32>) -> Spectrum {
        let far = i.map_or(0.0, |i| self.varnish.longer(i));
        self.absorbed(self.varnish.longer(o) + far) * self.darkened(o)
    }

    /// The factor by absorption alone, for light that leaves at an angle of cosine `cos`.
    #[inline(always)]
    pub fn left(&self, cos: f32) -> Spectrum {
        self.absorbed(self.varnish.longer(cos))
    }

    /// Estimates of [`Tint::pair`] over the directions of what is mirrored, and of what is scattered diffusely.
    #[inline(always)]
    pub fn over(&self, o: f32) -> [Spectrum; 2] {
        // The mean 1/µ of the far end of a diffuse path is taken at this cosine.
        const DIFFUSE_COS: f32 = 2.0 / 3.0;
        let (near, dark) = (self.varnish.longer(o), self.darkened(o));
        [near, self.varnish.longer(DIFFUSE_COS)].map(|far| self.absorbed(near + far) * dark)
    }

    #[inline(always)]
    fn darkened(&self, o: f32) -> Spectrum {
        self.varnish.darkened(self.f0 + (1.0 - self.f0) * schlick_weight(o))
    }

    #[inline(always)]
    fn absorbed(&self, crossings: f32) -> Spectrum {
        Spectrum::ONE.lerp(self.varnish.transmittance(crossings), self.coverage)
    }
}

/// What lies under the coat.
fn under(p: &GltfParams) -> Under {
    let (base, far) = (p.base_color.map(unit), p.diffuse_transmission_color.map(unit));
    let dielectric = (p.specular_color * f0_from_ior(p.ior)).map(unit) * unit(p.specular);
    let f0 = dielectric.max_element();
    let tint = dielectric * if f0 > 0.0 { 1.0 / f0 } else { 0.0 };
    let diffuse = base.lerp(far, unit(p.diffuse_transmission));
    let through = base.lerp(p.multiscatter_color.map(unit), p.sheet_scatter());
    let substrate = diffuse.lerp(through, unit(p.transmission));
    Under::new(f0, tint, substrate, base, unit(p.metallic), unit(p.roughness))
}

/// The part of what shines below a coat that leaves it at an angle of cosine `cos`: 1 − coverage · F, and what the coat of a colour
/// (that of two crossings, 0..1) leaves of it on its way out.
pub fn under_coat(coverage: f32, ior: f32, color: Spectrum, cos: f32) -> Spectrum {
    let p = GltfParams { clearcoat: coverage, coat_ior: ior, coat_color: color, ..GltfParams::default() };
    let (cos, f0) = (unit(cos), coat_f0(ior));
    let passed = 1.0 - unit(coverage) * (f0 + (1.0 - f0) * schlick_weight(cos));
    Tint::new(&p).map_or(Spectrum::ONE, |t| t.left(cos)) * passed
}

/// The unit normal if it is one and not nearly +Z: one that is not a number or points down counts as +Z.
#[inline]
pub(super) fn own_normal(normal: Vec3A) -> Option<Vec3A> {
    // A length whose square leaves f32 is as good as none.
    let len2 = normal.length_squared();
    let n = normal * (1.0 / len2.sqrt());
    (n.is_finite() && n.z > 0.0 && n.z < 1.0 - 1e-6).then_some(n)
}

/// The coat's lobe, grey.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Coat {
    /// 0..1.
    coverage: f32,
    f0: f32,
    ggx: Ggx,
    mirror: bool,
    row: Row,
    /// Its facets if it is anisotropic.
    stretched: Option<Shape>,
    /// Its frame if it is not the base's.
    frame: Option<Frame>,
    /// True if its normal is not the base's.
    tilted: bool,
    tint: Option<Tint>,
}

impl Coat {
    /// `None` if there is no coat.
    #[inline]
    pub fn new(p: &GltfParams) -> Option<Self> {
        let coverage = unit(p.clearcoat);
        if coverage == 0.0 {
            return None;
        }
        let roughness = unit(p.clearcoat_roughness);
        let alpha = roughness * roughness;
        let strength = unit(p.coat_anisotropy_strength);
        let along = alpha + (1.0 - alpha) * (strength * strength);
        let own = own_normal(p.clearcoat_normal);
        let stretched = (along != alpha).then(|| Shape::new([along, alpha]));
        let frame = match &stretched {
            None => own.map(Frame::from_normal),
            Some(_) => Some(Frame::from_normal_tangent(own.unwrap_or(Vec3A::Z), p.coat_tangent)),
        };
        Some(Self {
            coverage,
            f0: coat_f0(p.coat_ior),
            ggx: Ggx::new(along, alpha),
            mirror: along < ALPHA_DELTA,
            row: stretched.as_ref().map_or_else(|| Row::new(roughness), |s| s.row),
            stretched,
            frame,
            tilted: own.is_some(),
            tint: Tint::new(p),
        })
    }

    /// The same as the narrowest lobe that is not perfectly specular.
    #[inline]
    pub fn blurred(mut self) -> Self {
        self.mirror = false;
        self
    }

    #[inline(always)]
    pub fn is_mirror(&self) -> bool {
        self.mirror
    }

    #[inline(always)]
    pub fn has_own_normal(&self) -> bool {
        self.tilted
    }

    /// True if it looks different from different azimuths.
    #[inline(always)]
    pub fn has_azimuths(&self) -> bool {
        self.frame.is_some()
    }

    /// α of the lobe.
    #[inline(always)]
    pub fn alpha(&self) -> [f32; 2] {
        self.ggx.alpha()
    }

    #[inline(always)]
    fn local(&self, w: Vec3A) -> Vec3A {
        match &self.frame {
            None => w,
            Some(f) => f.to_local(w),
        }
    }

    /// Reflectance of one microfacet with the coverage.
    #[inline(always)]
    fn fresnel(&self, weight: f32) -> f32 {
        self.coverage * (self.f0 + (1.0 - self.f0) * weight)
    }

    /// The part of the light from `w` that reaches what lies below, and the part that the lobe reflects.
    ///
    /// Like the extension takes |V · Nc|, so does this for directions behind the coat's own horizon.
    #[inline(always)]
    pub fn split(&self, w: Vec3A) -> (f32, f32) {
        let local = self.local(w);
        let z = local.z;
        if let Some(shape) = &self.stretched {
            // The mean of Schlick's weight over the facets that are seen.
            let above = Vec3A::new(local.x, local.y, z.abs().max(MIN_COS));
            let weight = 1.0 - shape.enters(&Facet::new(Spectrum::ZERO, 1.0, Spectrum::ZERO, 0.0), above);
            let f = self.fresnel(weight);
            return (1.0 - f, if z > MIN_COS { f * self.row.directional(z).e } else { 0.0 });
        }
        if self.mirror {
            let f = self.fresnel(schlick_weight(z.abs()));
            return (1.0 - f, if z > MIN_COS { f } else { 0.0 });
        }
        let albedo = self.row.directional(z.abs());
        let f = self.fresnel(albedo.w);
        (1.0 - f, if z > MIN_COS { f * albedo.e } else { 0.0 })
    }

    /// The part of the light from `w` that reaches what lies below.
    #[inline(always)]
    pub fn through(&self, w: Vec3A) -> f32 {
        self.split(w).0
    }

    /// Value (without the base's cosine) and density of a pair above the base.
    ///
    /// With a normal of its own the lobe meets light by the cosine to that normal, as the extension's renderers do: the base's
    /// cosine, which the caller multiplies by, is divided out.
    #[inline(always)]
    pub fn eval_pdf(&self, wo: Vec3A, wi: Vec3A) -> (f32, f32) {
        if self.mirror {
            return (0.0, 0.0);
        }
        let (o, i) = (self.local(wo), self.local(wi));
        if !(o.z > MIN_COS && i.z > MIN_COS) {
            return (0.0, 0.0);
        }
        let pair = self.ggx.pair(o, i);
        let value = self.fresnel(schlick_weight(pair.cos_half)) * pair.value;
        let value = if self.tilted { value * (i.z / wi.z) } else { value };
        if value < f32::INFINITY && pair.pdf < f32::INFINITY { (value, pair.pdf) } else { (0.0, 0.0) }
    }

    /// A direction from the lobe, or the mirror's; it may lie below the base. `None` if it lies below the coat, where
    /// another lobe's density must not stand in for this one's.
    #[inline(always)]
    pub fn sample(&self, wo: Vec3A, u: [f32; 2]) -> Option<Vec3A> {
        let o = self.local(wo);
        if !(o.z > MIN_COS) {
            return None;
        }
        let i = if self.mirror { mirror(o) } else { self.ggx.sample_reflection(o, u) };
        (i.z > MIN_COS).then(|| match &self.frame {
            None => i,
            Some(f) => f.to_world(i),
        })
    }

    /// The factor of what lies below by absorption and darkening, for light between the viewer at `wo` and a path of `wi` through
    /// the coat (`None` if that end does not pass it).
    #[inline(always)]
    pub fn varnished(&self, wo: Vec3A, wi: Option<Vec3A>) -> Spectrum {
        match &self.tint {
            None => Spectrum::ONE,
            Some(t) => t.pair(self.local(wo).z.abs(), wi.map(|w| self.local(w).z.abs())),
        }
    }

    /// The same by absorption alone, for light that passes the coat only towards `wi`, on its way out of a body.
    #[inline(always)]
    pub fn left(&self, wi: Vec3A) -> Spectrum {
        self.tint.as_ref().map_or(Spectrum::ONE, |t| t.left(self.local(wi).z.abs()))
    }

    /// An estimate of [`Coat::varnished`] over the directions of what is mirrored and of what is scattered diffusely.
    #[inline(always)]
    pub fn varnished_over(&self, wo: Vec3A) -> [Spectrum; 2] {
        self.tint.as_ref().map_or([Spectrum::ONE; 2], |t| t.over(self.local(wo).z.abs()))
    }

    /// If it is a mirror that `wo` sees: the direction and the reflectance.
    #[inline(always)]
    pub fn delta(&self, wo: Vec3A) -> Option<(Vec3A, f32)> {
        if !self.mirror {
            return None;
        }
        let wi = self.sample(wo, [0.0; 2])?;
        (wi.z > MIN_COS).then(|| (wi, self.fresnel(schlick_weight(self.local(wo).z))))
    }
}
