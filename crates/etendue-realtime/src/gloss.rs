//! One GGX lobe: for light from a direction, and for the sky's.

use crate::choices::{Choices, Lobe, Masking, Specular};
use crate::film::Film;
use crate::inputs::Part;
use crate::sky_light::SkyLight;
use crate::surface::unit;
use etendue_bxdf::energy::{Albedo, Row};
use etendue_bxdf::fresnel::schlick_weight;
use etendue_bxdf::fresnel_average::{AnisotropicRules, Rule, Rules};
use etendue_bxdf::ggx::ALPHA_DELTA;
use etendue_bxdf::sampling::Frame;
use etendue_bxdf::{Ggx, MIN_COS};
use etendue_color::Spectrum;
use glam::{Vec3A, vec3a};
use std::f32::consts::PI;

/// The lobe seen from `wo`, in its own frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gloss {
    pub wo: Vec3A,
    /// Perceptual roughness; where the lobe is anisotropic that of a mean α.
    pub roughness: f32,
    pub ggx: Ggx,
    /// Too smooth for a lobe: a perfect mirror.
    pub mirror: bool,
    /// Mean Fresnel terms and albedo by angle, of a lobe with one α.
    row: Row,
    /// The same of one with two.
    stretched: Option<AnisotropicRules>,
}

/// The sky's light in a lobe. Weights are the lobe's without Fresnel's term, or with its two parts (1 − w) and w.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Lit {
    /// ∫ L lobe (1 − w): the factor of F0.
    pub straight: Spectrum,
    /// ∫ L lobe w: the factor of F90.
    pub grazing: Spectrum,
    /// ∫ L lobe F with a film's F.
    pub film: Spectrum,
    /// The mean light over the lobe.
    pub prefiltered: Spectrum,
    pub mip: f32,
}

impl Gloss {
    /// For α along x and y, 0..1.
    #[inline]
    pub fn new(wo: Vec3A, alpha: [f32; 2]) -> Self {
        let isotropic = alpha[0] == alpha[1];
        let mean = if isotropic { alpha[0] } else { (alpha[0] * alpha[1]).sqrt() };
        let roughness = mean.sqrt();
        Self {
            wo,
            roughness,
            ggx: Ggx::new(alpha[0], alpha[1]),
            mirror: !(alpha[0].max(alpha[1]) >= ALPHA_DELTA),
            row: Row::new(roughness),
            stretched: (!isotropic).then(|| AnisotropicRules::new(alpha)),
        }
    }

    /// True if it looks the same from all azimuths.
    #[inline(always)]
    pub fn is_isotropic(&self) -> bool {
        self.stretched.is_none()
    }

    /// Albedo for F = 1 and mean Schlick weight of the facets seen from `w` (above).
    #[inline(always)]
    pub fn directional(&self, w: Vec3A) -> Albedo {
        match &self.stretched {
            None => self.row.directional(w.z),
            Some(rules) => {
                let (rule, e) = rules.directional(w);
                let weighted = rule.cos.iter().zip(rule.weight).map(|(c, k)| schlick_weight(*c) * k);
                Albedo { e, w: weighted.sum() }
            }
        }
    }

    /// The mean Schlick weight over the hemisphere, of a lobe with one α.
    #[inline(always)]
    pub fn average_weight(&self) -> f32 {
        self.row.average().w
    }

    /// Angles that stand for the facets seen from `w`, and their weights.
    #[inline]
    pub fn rule(&self, w: Vec3A) -> Rule {
        match &self.stretched {
            _ if self.mirror => Rule::mirror(w.z),
            None => Rules::new(self.roughness).directional(w.z),
            Some(rules) => rules.directional(w).0,
        }
    }

    /// D, and D · V with V = G / (4 NL NV), for light from `wi` above the horizon.
    #[inline(always)]
    pub fn lobe(&self, wi: Vec3A, masking: Masking) -> (f32, f32) {
        let (nv, nl) = (self.wo.z, wi.z);
        let a = self.roughness * self.roughness;
        match masking {
            Masking::Smith if self.mirror => (0.0, 0.0),
            Masking::Smith => (self.ggx.d_along(self.wo + wi), self.ggx.pair(self.wo, wi).value),
            Masking::Fast => {
                let d = self.ggx.d_along(self.wo + wi);
                (d, d * 0.5 / (2.0 * nl * nv * (1.0 - a) + (nl + nv) * a).max(1e-5))
            }
            Masking::Schlick => {
                let d = self.ggx.d_along(self.wo + wi);
                let k = schlick_k(self.roughness);
                (d, d * 0.25 / ((nv * (1.0 - k) + k) * (nl * (1.0 - k) + k)))
            }
            Masking::Notes => {
                // The helmet shader line by line, with its guards; a guard keeps D of a smooth surface from its peak.
                let a2 = a * a;
                let nh = (self.wo + wi).normalize_or_zero().z.max(0.0);
                let denominator = nh * nh * (a2 - 1.0) + 1.0;
                let d = a2 / (PI * denominator * denominator).max(1e-5);
                let k = schlick_k(self.roughness);
                let g1 = |cos: f32| cos / (cos * (1.0 - k) + k).max(1e-5);
                (d, d * g1(nv) * g1(nl) / (4.0 * nv * nl).max(1e-4))
            }
        }
    }

    /// The sky's light, sampled; each sample multiplied by `factor` of its direction.
    ///
    /// Filtered importance sampling of the real lobe: Σ L(wi, level) f cos / (n pdf), where the level's texels are as large as
    /// the sample's share 1 / (n pdf) of the sphere (Křivánek, Colbert 2008, "Real-Time Shading with Filtered Importance
    /// Sampling", section 4). Beside each sum stands the one without light, whose value is known from the table: their ratio is
    /// the light, and a white sky gives the table's reflectance for any number of samples.
    #[inline]
    pub fn sampled(
        &self,
        frame: &Frame,
        sky: &SkyLight,
        draws: Draws,
        film: Option<(&Film, [Spectrum; 2])>,
        factor: impl Fn(Vec3A) -> f32,
    ) -> Lit {
        let with_film = |cos: f32, w: f32| match &film {
            Some((film, [f0, f90])) => film.over(f0.lerp(*f90, w), cos),
            None => Spectrum::ZERO,
        };
        if self.mirror {
            let (wi, w) = (mirror(self.wo), schlick_weight(self.wo.z));
            let light = sky.radiance(to_world(frame, wi));
            let lit = light * factor(wi);
            return Lit {
                straight: lit * (1.0 - w),
                grazing: lit * w,
                film: lit * with_film(self.wo.z, w),
                prefiltered: light,
                mip: 0.0,
            };
        }
        let mut out = Lit::default();
        let (mut white_straight, mut white_grazing) = (0.0, 0.0);
        let inv = 1.0 / draws.count as f32;
        for u in draws.points() {
            let wi = self.ggx.sample_reflection(self.wo, u);
            if !(wi.z > MIN_COS) {
                continue;
            }
            let pair = self.ggx.pair(self.wo, wi);
            let (light, lod) = sky.averaged(to_world(frame, wi), draws.share() / pair.pdf);
            let weight = pair.value * wi.z * inv / pair.pdf;
            let w = schlick_weight(pair.cos_half);
            let (w0, w90) = (weight * (1.0 - w), weight * w);
            let lit = light * factor(wi);
            out.straight += lit * w0;
            out.grazing += lit * w90;
            if film.is_some() {
                out.film += lit * with_film(pair.cos_half, w) * weight;
            }
            out.prefiltered += light * weight;
            white_straight += w0;
            white_grazing += w90;
            out.mip += weight * lod;
        }
        let over = |x: f32| if x > 0.0 { 1.0 / x } else { 0.0 };
        let total = white_straight + white_grazing;
        out.prefiltered *= over(total);
        out.mip *= over(total);
        // The table of lobes with two α is coarser than the sum itself.
        if !self.is_isotropic() {
            return out;
        }
        let known = self.directional(self.wo);
        out.straight *= known.e * (1.0 - known.w) * over(white_straight);
        out.grazing *= known.e * known.w * over(white_grazing);
        out.film *= known.e * over(total);
        out
    }

    /// The sky's light prefiltered: what the split sum multiplies by the lobe's reflectance; and the level of detail.
    #[inline]
    pub fn prefiltered(&self, frame: &Frame, sky: &SkyLight, choices: &Choices) -> (Spectrum, f32) {
        let r = mirror(self.wo);
        let alpha = self.roughness * self.roughness;
        match choices.lobe {
            Lobe::Mirror => {
                // Bent about the direction of anisotropy: the mirror at a normal that leans towards the viewer across the
                // highlight's length (McAuley 2015, "Rendering the World of Far Cry 4").
                let r = if self.is_isotropic() { r } else { self.bent_mirror() };
                sky.prefiltered(to_world(frame, r), self.roughness)
            }
            Lobe::Dominant => {
                let r = if self.is_isotropic() { r } else { self.bent_mirror() };
                let smooth = unit(1.0 - alpha);
                let towards_mirror = smooth * (smooth.sqrt() + alpha);
                let d = r * towards_mirror + Vec3A::Z * (1.0 - towards_mirror);
                sky.prefiltered(to_world(frame, d), self.roughness)
            }
            Lobe::Stretched => self.stretched(frame, sky),
        }
    }

    fn bent_mirror(&self) -> Vec3A {
        let [ax, ay] = self.ggx.alpha();
        // x is the long direction: the normal across it is the view without its part along x.
        let across = vec3a(0.0, self.wo.y, self.wo.z).normalize_or_zero();
        // As much as the ratio of both widths says: nothing for a round lobe.
        let bend = (1.0 - ay / ax.max(ay)) * unit(5.0 * self.roughness);
        let n = (Vec3A::Z + (across - Vec3A::Z) * bend).normalize_or_zero();
        n * (2.0 * n.dot(self.wo)) - self.wo
    }

    /// The mean of five looks whose half vectors lie in the plane of incidence.
    ///
    /// Half vectors are spread over an angle of about α around the normal in each direction. Mirrored at them, the view moves by
    /// twice the angle within the plane of incidence, but by 2 V·H times it beside the plane: the lobe is an ellipse 1 : V·H, where
    /// a prefiltered cube has circles. So each look is at a circle narrower by V·H, and the looks stand at the quantiles 0.1, 0.3, …
    /// 0.9 of the slopes within the plane, whose density is α² / (2 (α² + x²)^(3/2)), each weighted with what is visible of it.
    #[inline]
    fn stretched(&self, frame: &Frame, sky: &SkyLight) -> (Spectrum, f32) {
        // x / α = q / √(1 − q²) for q = 2u − 1.
        const SLOPES: [f32; 5] = [-1.333_333_4, -0.436_435_8, 0.0, 0.436_435_8, 1.333_333_4];
        let alpha = self.roughness * self.roughness;
        let along = vec3a(self.wo.x, self.wo.y, 0.0).normalize_or_zero();
        let (mut sum, mut total, mut mip) = (Spectrum::ZERO, 0.0, 0.0);
        for slope in SLOPES {
            let h = (Vec3A::Z + along * (alpha * slope)).normalize();
            let cos = self.wo.dot(h);
            let wi = h * (2.0 * cos) - self.wo;
            if !(cos > 0.0 && wi.z > 0.0) {
                continue;
            }
            let weight = cos * self.ggx.g2(self.wo, wi);
            // Not narrower than what lies between two looks.
            let narrow = self.roughness * cos.max(0.35).sqrt();
            let (light, lod) = sky.prefiltered(to_world(frame, wi), narrow);
            sum += light * weight;
            total += weight;
            mip += lod * weight;
        }
        if total > 0.0 {
            (sum * (1.0 / total), mip / total)
        } else {
            sky.prefiltered(to_world(frame, mirror(self.wo)), self.roughness)
        }
    }
}

/// Samples of the base's lobe; `None` for the split sum.
#[inline]
pub(crate) fn samples(specular: Specular) -> Option<u32> {
    match specular {
        Specular::SplitSum => None,
        Specular::SampledFew => Some(8),
        Specular::Sampled => Some(32),
        Specular::Exact => Some(1024),
    }
}

/// The points of a lobe's lattice that one point of a pixel takes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Draws {
    count: u32,
    part: Part,
}

impl Draws {
    /// Of `n` for the pixel, or more: fewer than eight would not tell a lobe's light from its reflectance.
    #[inline(always)]
    pub fn new(n: u32, part: Part) -> Self {
        let part = Part { index: part.index % part.of.max(1), of: part.of.max(1) };
        Self { count: (n / part.of).max(n.min(8)), part }
    }

    /// The part of the lobe that a point stands for: one over all points of the pixel.
    #[inline(always)]
    fn share(self) -> f32 {
        1.0 / (self.count as f32 * self.part.of as f32)
    }

    #[inline(always)]
    fn points(self) -> impl Iterator<Item = [f32; 2]> {
        let share = self.share();
        (0..self.count)
            .map(move |i| lattice(i.wrapping_mul(self.part.of).wrapping_add(self.part.index), share))
    }
}

/// Karis' k for lights: (roughness + 1)² / 8.
#[inline(always)]
fn schlick_k(roughness: f32) -> f32 {
    let a = roughness + 1.0;
    a * a / 8.0
}

/// Point `i` of the square's lattice of 1/`inv` points by the golden ratio, which is even for every number of points.
#[inline(always)]
pub(crate) fn lattice(i: u32, inv: f32) -> [f32; 2] {
    // 2³² over the golden ratio.
    let turns = (i.wrapping_mul(0x9e37_79b9) >> 8) as f32 * (1.0 / 16_777_216.0);
    [turns, (i as f32 + 0.5) * inv]
}

#[inline(always)]
pub(crate) fn mirror(wo: Vec3A) -> Vec3A {
    vec3a(-wo.x, -wo.y, wo.z)
}

#[inline(always)]
pub(crate) fn to_world(f: &Frame, w: Vec3A) -> Vec3A {
    f.x * w.x + f.y * w.y + f.z * w.z
}
