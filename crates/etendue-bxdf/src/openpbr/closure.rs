//! The closure: all layers at a point.

use super::{
    OpenPbrParams,
    coat::{Coat, CoatView, Under},
    facet::{Boundary, Facets, Mix, boundary},
    index::{self, anisotropic_alpha, unit},
    lobe::Lobe,
};
use crate::{
    bsdf::{Bsdf, BsdfSample, DeltaPart, Eval, LobeKind, MIN_COS},
    dielectric::{GgxDielectric, Interface},
    diffuse::{Lambert, eon::Eon},
    fresnel::f0_from_ior,
    ggx::mirror,
    model::Incidence,
    multiscatter::{loss::BoundaryLoss, mean_alpha},
    sampling::cosine_hemisphere,
    sheen::Fuzz,
};
use etendue_color::Spectrum;
use glam::{Vec3A, vec3a};

/// The closure of an OpenPBR surface at a point; see the [module](super).
///
/// Not reciprocal. What single scattering loses between the facets of a volume's boundary is given back to what passes (from
/// inside to both parts alike) as far as the tables of [`crate::multiscatter`] are certain of it. Its [`Bsdf::albedo`] is the tables' for isotropic roughness, within 2e-3 of the integral for cos θ ≥
/// 0.05 if the coat is clear and nothing enters a volume, and an estimate otherwise. Where α falls below
/// [`crate::ggx::ALPHA_DELTA`] a lobe is perfectly specular.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OpenPbr {
    fuzz: Option<FuzzLayer>,
    coat: Option<Coat>,
    base: Lobe,
    facets: Facets,
    mix: Mix,
    /// The metal's `specular_weight`.
    metal_weight: f32,
    /// The rough diffuse base, the subsurface, and what diffuses through a sheet.
    diffuse: [Option<Matte>; 3],
    beyond: Beyond,
    /// The part of the surface that looks from behind as it does from the front; the rest is the inside of the
    /// translucent base. 1 from the front.
    outer: f32,
    /// What light is multiplied by that passes into or out of the translucent base, without the coat.
    passage: Spectrum,
    emission: Spectrum,
}

/// Fibres on top of all.
#[derive(Clone, Copy, Debug, PartialEq)]
struct FuzzLayer {
    lobe: Fuzz,
    weight: f32,
}

/// A diffuse lobe and its factor.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Matte {
    lobe: MatteLobe,
    scale: Spectrum,
}

/// Without roughness EON is Lambert's lobe, at a tenth of the cost.
#[derive(Clone, Copy, Debug, PartialEq)]
enum MatteLobe {
    Even(Lambert),
    Rough(Eon),
}

impl MatteLobe {
    #[inline(always)]
    fn new(color: Spectrum, roughness: f32) -> Self {
        if roughness == 0.0 { Self::Even(Lambert { color }) } else { Self::Rough(Eon::new(color, roughness)) }
    }

    #[inline(always)]
    fn eval_pdf(&self, wo: Vec3A, wi: Vec3A) -> Eval {
        match self {
            Self::Even(l) => l.eval_pdf(wo, wi),
            Self::Rough(l) => l.eval_pdf(wo, wi),
        }
    }

    #[inline(always)]
    fn sample(&self, wo: Vec3A, uc: f32, u: [f32; 2]) -> Option<Vec3A> {
        match self {
            Self::Even(_) => Some(cosine_hemisphere(u)),
            Self::Rough(l) => l.sample(wo, uc, u).map(|s| s.wi),
        }
    }

    #[inline(always)]
    fn albedo(&self, wo: Vec3A) -> Spectrum {
        match self {
            Self::Even(l) => l.color,
            Self::Rough(l) => l.albedo(wo),
        }
    }
}

/// What lies behind the translucent part.
#[derive(Clone, Copy, Debug, PartialEq)]
// The closure is on the stack in any case.
#[allow(clippy::large_enum_variant)]
enum Beyond {
    /// There is none.
    Nothing,
    /// The other side of a sheet.
    Sheet(Lobe),
    /// A volume that light enters.
    Volume(Refraction),
    /// The volume that light comes from.
    Inside(Refraction),
}

/// The boundary of a volume.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Refraction {
    lobe: GgxDielectric<Boundary>,
    /// What one scattering event of the bare boundary loses between its microfacets; `None` if it is smooth.
    loss: Option<Loss>,
}

/// The loss of a bare boundary of microfacets, as [`crate::multiscatter`] has it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Loss {
    table: BoundaryLoss,
    /// The part of the table's that lobes with two widths certainly lose.
    share: f32,
}

/// How far the part of the light that passes may be above what the loss's table says.
const LOSS_SLACK: f32 = 0.003;

impl Refraction {
    #[inline]
    fn new(alpha: [f32; 2], boundary: Boundary, at: &Incidence) -> Self {
        let lobe = GgxDielectric::new(alpha, boundary, at.transport);
        let loss = lobe.is_rough().then(|| {
            let (mean, share) = mean_alpha(lobe.ggx().alpha());
            Loss { table: BoundaryLoss::new(mean, lobe.interface().eta()), share }
        });
        Self { lobe, loss }
    }

    /// The part of the light that one event of the bare boundary brings out on either side, rather above than below.
    #[inline(always)]
    fn kept(&self, wo: Vec3A) -> f32 {
        self.loss.as_ref().map_or(1.0, |l| (1.0 + LOSS_SLACK - l.table.directional(wo.z) * l.share).min(1.0))
    }

    /// What part of the light the lobe lets pass by one event, by lane, rather above than below: `e` is the albedo of a
    /// mirror of the same facets, `bare` the bare boundary's mean reflectance and `mean` the one that it has here.
    ///
    /// All that the bare boundary keeps less what it reflects; and where a coat or a film lets more enter than the bare
    /// boundary does, at most all of that. The means are over facets whose reflection comes out; those whose reflection is
    /// lost are steeper, and differ by up to three times as much.
    #[inline(always)]
    fn passed(&self, wo: Vec3A, e: f32, bare: Spectrum, mean: Spectrum) -> Spectrum {
        if self.loss.is_none() {
            return (Spectrum::ONE - mean).max(Spectrum::ZERO);
        }
        let more = (bare - mean).max(Spectrum::ZERO) * (3.0 - 2.0 * e);
        (Spectrum::splat(self.kept(wo)) - bare * e + more).map(|v| v.max(0.01))
    }

    /// The part that the boundary seen from inside keeps, rather above than below; `facets` are those of the base.
    #[inline]
    fn kept_inside(&self, wo: Vec3A, facets: &Facets, base: &Lobe) -> f32 {
        let boundary = self.lobe.interface();
        if self.loss.is_none() || facets.bare_eta() == Some(1.0 / boundary.eta()) {
            return self.kept(wo);
        }
        let [other] = base.seen(wo).mean(|cos| [boundary.change(cos)]);
        (self.kept(wo) + other.max_element()).min(1.0)
    }
}

/// What can be drawn from: the order of the probabilities. The three diffuse parts follow each other.
const FUZZ: usize = 0;
const COAT: usize = 1;
const BASE: usize = 2;
const DIFFUSE: usize = 3;
const DIFFUSE_THROUGH: usize = 5;
const BEYOND: usize = 6;
const PARTS: usize = 7;

/// What depends on `wo` alone.
#[derive(Clone, Copy)]
struct View {
    /// 1 − what the fuzz takes.
    under_fuzz: f32,
    coat: Option<CoatView>,
    /// Factors of the kinds of facet: weight and compensation; the opaque one's with its tint.
    metal: Spectrum,
    opaque: Spectrum,
    clear: Spectrum,
    /// Factor of the diffuse parts: what gets through the dielectric's surface.
    substrate: Spectrum,
    /// Factor of what passes the translucent part.
    through: Spectrum,
    /// Factor of the boundary seen from inside.
    inside: f32,
    /// Factor of everything on the base that does not depend on `wi`.
    under: Spectrum,
    /// The part of the light that each part returns.
    albedo: [Spectrum; PARTS],
    /// Probability to draw from each.
    p: [f32; PARTS],
}

/// (x, y, −z).
#[inline(always)]
fn turned_over(w: Vec3A) -> Vec3A {
    vec3a(w.x, w.y, -w.z)
}

/// a / b by lane, 0 where b is 0.
#[inline(always)]
fn ratio(a: Spectrum, b: Spectrum) -> Spectrum {
    Spectrum(core::array::from_fn(|i| if b[i] > 0.0 { a[i] / b[i] } else { 0.0 }))
}

/// The mean 1/µ in the coat of the far end of a diffuse path is taken at this cosine.
const DIFFUSE_COS: f32 = 2.0 / 3.0;

/// What the coat's darkening must know of the base.
fn under_coat(p: &OpenPbrParams, facets: &Facets, mix: Mix) -> Under {
    let f0 = f0_from_ior(facets.eta());
    let subsurface = unit(p.subsurface_weight);
    let diffuse =
        (p.base_color.map(unit) * unit(p.base_weight)).lerp(p.subsurface_color.map(unit), subsurface);
    let substrate = diffuse.lerp(passage(p), unit(p.transmission_weight));
    let dielectric = p.specular_color.map(unit) * f0 + substrate * (1.0 - f0);
    let metal = facets.metal_f0() * unit(p.specular_weight);
    let r = unit(p.specular_roughness);
    // OpenPBR 1.1, equations "dielectric_roughness_estimate" and "base_roughness_estimate".
    let dielectric_roughness = 1.0 + (r - 1.0) * f0;
    Under {
        albedo: dielectric.lerp(metal, mix.metal),
        roughness: dielectric_roughness + (r - dielectric_roughness) * mix.metal,
    }
}

/// The colour of passing the surface of the translucent base, or the sheet that it is.
fn passage(p: &OpenPbrParams) -> Spectrum {
    let clear_surface = !p.geometry_thin_walled && p.transmission_depth > 0.0;
    if clear_surface { Spectrum::ONE } else { p.transmission_color.map(unit) }
}

impl OpenPbr {
    /// The closure for light that arrives as `at` says.
    pub fn new(p: &OpenPbrParams, at: &Incidence) -> Self {
        let thin = p.geometry_thin_walled;
        let mix = Mix::new(p);
        // Seen from within, the translucent part is another surface; the rest looks as it does from outside.
        let inside = !at.front && !thin && mix.clear > 0.0;
        let outer = if inside { 1.0 - mix.clear } else { 1.0 };
        let shown = if inside {
            let scale = if outer > 0.0 { 1.0 / outer } else { 0.0 };
            Mix { metal: mix.metal * scale, opaque: mix.opaque * scale, clear: 0.0 }
        } else {
            mix
        };

        let outside = index::index(at.exterior_ior);
        let coverage = unit(p.coat_weight);
        let roughness = index::roughened(unit(p.specular_roughness), unit(p.coat_roughness), coverage);
        let alpha = anisotropic_alpha(roughness, p.specular_roughness_anisotropy);
        let facets = Facets::new(p, outside, coverage, mix);
        let base = Lobe::new(alpha);

        let beyond = if mix.clear == 0.0 {
            Beyond::Nothing
        } else if thin {
            // Light is bent at both faces, each time by (η − 1) times the facet's tilt; reflection turns it by twice the
            // tilt.
            let narrower = (facets.eta().max(1.0 / facets.eta()) - 1.0) * core::f32::consts::FRAC_1_SQRT_2;
            Beyond::Sheet(Lobe::new(alpha.map(|a| (a * narrower).min(1.0))))
        } else {
            let ior = p.interior_ior(outside, at.lane);
            let eta = if inside { outside / ior } else { ior / outside };
            let lobe = Refraction::new(alpha, Boundary::new(facets, base, eta, !inside), at);
            if inside { Beyond::Inside(lobe) } else { Beyond::Volume(lobe) }
        };

        let fuzz_weight = unit(p.fuzz_weight);
        Self {
            fuzz: (fuzz_weight > 0.0)
                .then(|| FuzzLayer { lobe: Fuzz::new(p.fuzz_color, p.fuzz_roughness), weight: fuzz_weight }),
            coat: Coat::new(p, outside, under_coat(p, &facets, mix)),
            base,
            facets: facets.showing(shown),
            mix: shown,
            metal_weight: unit(p.specular_weight),
            diffuse: mattes(p, shown),
            beyond,
            outer,
            passage: if thin { Spectrum::ONE } else { passage(p) },
            emission: p.emission_color.map(|v| v.max(0.0).min(f32::MAX))
                * if inside { 0.0 } else { p.emission_luminance.max(0.0).min(1e30) },
        }
    }

    /// Luminance that the base sends towards `wo`, by lane, cd/m², as it leaves the fuzz (OpenPBR 1.1, "Reduction to a
    /// mixture of lobes": lerp(1, T, coat_weight) of what the base emits, here over the coat's path length towards `wo`,
    /// times what the fuzz lets through). Zero from inside a volume.
    #[inline]
    pub fn emission(&self, wo: Vec3A) -> Spectrum {
        if self.emission.is_black() { Spectrum::ZERO } else { self.emission * self.emission_tint(wo) }
    }

    /// The part of the base's emission towards `wo` that coat and fuzz let through; zero below the surface.
    #[inline]
    pub fn emission_tint(&self, wo: Vec3A) -> Spectrum {
        if !(wo.z > MIN_COS) {
            return Spectrum::ZERO;
        }
        let fuzz = self.fuzz.map_or(1.0, |f| 1.0 - f.weight * f.lobe.reflectance(wo.z));
        match &self.coat {
            None => Spectrum::splat(fuzz),
            Some(c) => {
                let crossed = c.transmittance(c.longer(c.local(wo).z));
                Spectrum::ONE.lerp(crossed, c.weight) * fuzz
            }
        }
    }

    #[inline]
    fn view(&self, wo: Vec3A) -> View {
        let black = Spectrum::ZERO;
        let mut albedo = [black; PARTS];
        let mut under_fuzz = 1.0;
        if let Some(f) = &self.fuzz {
            let r = f.weight * f.lobe.reflectance(wo.z);
            under_fuzz = 1.0 - r;
            albedo[FUZZ] = f.lobe.albedo(wo) * f.weight;
        }
        let mut under = Spectrum::splat(under_fuzz);
        let coat = self.coat.as_ref().map(|c| c.view(wo));
        // The coat's factor of light that goes back by a mirror's, and by a diffuse path, and that passes.
        let mut over = [Spectrum::ONE; 3];
        if let (Some(c), Some(v)) = (&self.coat, &coat) {
            albedo[COAT] = Spectrum::splat(v.albedo * under_fuzz);
            under *= v.darkening;
            over =
                [c.over(v, 2.0 * v.longer), c.over(v, v.longer + c.longer(DIFFUSE_COS)), c.over(v, v.longer)];
        }

        let seen = self.base.seen(wo);
        let [m, o, c, tinted, passed] = seen.mean(|cos| {
            let f = self.facets.at(cos);
            [f.metal, f.opaque, f.clear, f.tinted, f.passed]
        });
        let metal_weight = self.mix.metal * self.metal_weight;
        let opaque_scale = seen.compensation(o);
        let clear_scale = seen.compensation(c + passed);
        let metal = seen.compensation(m) * metal_weight;
        let opaque = opaque_scale * self.facets.tint() * self.mix.opaque;
        let mut clear = clear_scale * self.mix.clear;
        let rest = Spectrum::splat(1.0 - seen.slack);
        let entered = (rest - o * opaque_scale * seen.e).max(black) * self.mix.opaque;
        for (i, matte) in self.diffuse.iter().enumerate() {
            if let Some(d) = matte {
                let over = if DIFFUSE + i == DIFFUSE_THROUGH { over[2] } else { over[1] };
                albedo[DIFFUSE + i] = d.lobe.albedo(wo) * d.scale * entered * under * over;
            }
        }
        let mut through = black;
        match &self.beyond {
            Beyond::Nothing => {}
            Beyond::Sheet(lobe) => {
                let behind = lobe.seen(wo);
                let [p] = behind.mean(|cos| [self.facets.at(cos).passed]);
                let part = passed * clear * (seen.e - seen.slack).max(0.0);
                through = ratio(part, p * behind.e);
                albedo[BEYOND] = part * under * over[2];
            }
            Beyond::Volume(r) => {
                let eta = r.lobe.interface().eta();
                let part = if self.facets.eta() < 1.0 {
                    // Both parts are scaled alike: the mean over a step, where total reflection begins, is not to be
                    // trusted with the smaller part.
                    let scale = self.mix.clear / r.kept(wo);
                    clear = Spectrum::splat(scale);
                    through = self.passage * scale;
                    (Spectrum::splat(r.kept(wo)) - c * seen.e).max(black) * through
                } else {
                    // All that is not reflected, whatever the facets lose of it.
                    let part = (rest - c * clear_scale * seen.e).max(black) * self.mix.clear * self.passage;
                    let bare = if self.facets.bare_eta() == Some(eta) {
                        c
                    } else {
                        let [bare] = seen.mean(|cos| [Spectrum::splat(boundary(cos, eta))]);
                        bare
                    };
                    through = ratio(part, r.passed(wo, seen.e, bare, c));
                    part
                };
                albedo[BEYOND] = part * under * over[2];
            }
            Beyond::Inside(_) => {}
        }
        let specular = (m * metal + o * opaque + tinted * clear) * seen.e;
        albedo[BASE] = specular * under * over[0];
        let mut inside = 0.0;
        if self.outer < 1.0 {
            for a in &mut albedo {
                *a *= self.outer;
            }
            if let Beyond::Inside(r) = &self.beyond {
                inside = (1.0 - self.outer) / r.kept_inside(wo, &self.facets, &self.base);
                let [r, t] = r.lobe.energy(wo);
                albedo[BEYOND] = (r + t * self.passage) * (1.0 - self.outer);
            }
        }
        View {
            under_fuzz,
            coat,
            metal,
            opaque,
            clear,
            substrate: entered,
            through,
            inside,
            under,
            p: probabilities(&albedo),
            albedo,
        }
    }

    /// Value by lobe and density; `wo` above [`MIN_COS`], `wi` away from the horizon.
    #[inline]
    fn eval_with(&self, view: &View, wo: Vec3A, wi: Vec3A) -> Eval {
        let mut e = if wi.z > 0.0 { self.reflected(view, wo, wi) } else { self.passed(view, wo, wi) };
        if self.outer < 1.0 {
            e.diffuse *= self.outer;
            e.specular *= self.outer;
            if let Beyond::Inside(r) = &self.beyond {
                let inside = r.lobe.eval_pdf(wo, wi);
                let tint = if wi.z > 0.0 { Spectrum::ONE } else { self.exit(wi) };
                e.specular += inside.specular * tint * view.inside;
                e.pdf += view.p[BEYOND] * inside.pdf;
            }
        }
        if e.pdf < f32::INFINITY && e.specular.is_finite() && e.diffuse.is_finite() { e } else { Eval::ZERO }
    }

    /// What light that leaves a volume towards `wi` is multiplied by.
    #[inline(always)]
    fn exit(&self, wi: Vec3A) -> Spectrum {
        match &self.coat {
            None => self.passage,
            Some(c) => self.passage * Spectrum::ONE.lerp(c.transmittance(c.longer(-wi.z)), c.weight),
        }
    }

    /// The coat's factor of the base for a pair of directions; `crossings` of `wi` as 1/µ within the coat, 0 if `wi` does
    /// not cross it.
    #[inline(always)]
    fn over(&self, view: &View, far: impl Fn(&Coat) -> f32) -> Spectrum {
        match (&self.coat, &view.coat) {
            (Some(c), Some(v)) => c.over(v, v.longer + far(c)) * view.under,
            _ => view.under,
        }
    }

    #[inline]
    fn reflected(&self, view: &View, wo: Vec3A, wi: Vec3A) -> Eval {
        let mut e = Eval::ZERO;
        if let Some(f) = &self.fuzz {
            let fuzz = f.lobe.eval_pdf(wo, wi);
            e.diffuse += fuzz.diffuse * f.weight;
            e.pdf += view.p[FUZZ] * fuzz.pdf;
        }
        if let (Some(c), Some(v)) = (&self.coat, &view.coat) {
            let up = c.local(wi);
            if !c.lobe.mirror && v.wo.z > MIN_COS && up.z > MIN_COS {
                let pair = c.lobe.ggx.pair(v.wo, up);
                // The lobe's cosine is the coat's; the contract's the base's.
                let cosine = if c.is_tilted() { up.z / wi.z } else { 1.0 };
                let value = pair.value * v.scale * c.fresnel(pair.cos_half) * view.under_fuzz * cosine;
                e.specular += Spectrum::splat(value);
                e.pdf += view.p[COAT] * pair.pdf;
            }
        }
        let over = self.over(view, |c| c.longer(c.local(wi).z));
        if !self.base.mirror {
            let pair = self.base.ggx.pair(wo, wi);
            let f = self.facets.at(pair.cos_half.min(1.0));
            let facets = f.metal * view.metal + f.opaque * view.opaque + f.tinted * view.clear;
            e.specular += facets * over * pair.value;
            e.pdf += view.p[BASE] * pair.pdf;
        }
        for (i, matte) in self.diffuse[..DIFFUSE_THROUGH - DIFFUSE].iter().enumerate() {
            if let Some(d) = matte {
                let lobe = d.lobe.eval_pdf(wo, wi);
                e.diffuse += lobe.diffuse * d.scale * view.substrate * over;
                e.pdf += view.p[DIFFUSE + i] * lobe.pdf;
            }
        }
        e
    }

    #[inline]
    fn passed(&self, view: &View, wo: Vec3A, wi: Vec3A) -> Eval {
        let mut e = Eval::ZERO;
        let over = self.over(view, |_| 0.0);
        if let Some(d) = &self.diffuse[DIFFUSE_THROUGH - DIFFUSE] {
            let lobe = d.lobe.eval_pdf(wo, turned_over(wi));
            e.diffuse += lobe.diffuse * d.scale * view.substrate * over;
            e.pdf += view.p[DIFFUSE_THROUGH] * lobe.pdf;
        }
        match &self.beyond {
            Beyond::Sheet(lobe) if !lobe.mirror => {
                let pair = lobe.ggx.pair(wo, turned_over(wi));
                let passed = self.facets.at(pair.cos_half.min(1.0)).passed;
                e.specular += passed * view.through * over * pair.value;
                e.pdf += view.p[BEYOND] * pair.pdf;
            }
            Beyond::Volume(r) => {
                let inside = r.lobe.eval_pdf(wo, wi);
                e.specular += inside.specular * view.through * over;
                e.pdf += view.p[BEYOND] * inside.pdf;
            }
            _ => {}
        }
        e
    }

    /// The perfectly specular reflection of coat, base and, from inside, boundary together.
    #[inline]
    fn mirrored(&self, view: &View, wo: Vec3A) -> Option<DeltaPart> {
        let mut reflectance = Spectrum::ZERO;
        let mut probability = 0.0;
        if let (Some(c), Some(v)) = (&self.coat, &view.coat)
            && c.lobe.mirror
        {
            reflectance += Spectrum::splat(v.scale * c.fresnel(wo.z) * view.under_fuzz);
            probability += view.p[COAT];
        }
        if self.base.mirror {
            let f = self.facets.at(wo.z);
            let facets = f.metal * view.metal + f.opaque * view.opaque + f.tinted * view.clear;
            reflectance += facets * self.over(view, |c| c.longer(c.local(mirror(wo)).z));
            probability += view.p[BASE];
        }
        reflectance *= self.outer;
        if let Beyond::Inside(r) = &self.beyond
            && let [Some(d), _] = r.lobe.deltas(wo)
        {
            reflectance += d.reflectance * view.inside;
            probability += view.p[BEYOND] * d.probability;
        }
        (probability > 0.0).then_some(DeltaPart { wi: mirror(wo), reflectance, probability })
    }

    /// What passes in one direction.
    #[inline]
    fn straight(&self, view: &View, wo: Vec3A) -> Option<DeltaPart> {
        match &self.beyond {
            Beyond::Sheet(lobe) if lobe.mirror && view.p[BEYOND] > 0.0 => {
                let passed = self.facets.at(wo.z).passed * view.through * self.over(view, |_| 0.0);
                Some(DeltaPart { wi: -wo, reflectance: passed, probability: view.p[BEYOND] })
            }
            Beyond::Volume(r) => {
                let d = r.lobe.deltas(wo)[1]?;
                let reflectance = d.reflectance * view.through * self.over(view, |_| 0.0);
                let probability = d.probability * view.p[BEYOND];
                (probability > 0.0).then_some(DeltaPart { reflectance, probability, ..d })
            }
            Beyond::Inside(r) => {
                let d = r.lobe.deltas(wo)[1]?;
                let reflectance = d.reflectance * self.exit(d.wi) * view.inside;
                let probability = d.probability * view.p[BEYOND];
                (probability > 0.0).then_some(DeltaPart { reflectance, probability, ..d })
            }
            _ => None,
        }
    }

    /// A direction from one part; the flag says that it is the part's perfectly specular one.
    #[inline]
    fn draw(&self, view: &View, part: usize, wo: Vec3A, uc: f32, u: [f32; 2]) -> Option<(Vec3A, bool)> {
        match part {
            FUZZ => Some((self.fuzz.as_ref()?.lobe.sample(wo, uc, u)?.wi, false)),
            COAT => {
                let (c, v) = (self.coat.as_ref()?, view.coat.as_ref()?);
                if c.lobe.mirror {
                    return Some((mirror(wo), true));
                }
                let local = c.lobe.ggx.sample_reflection(v.wo, u);
                let wi = c.base_direction(local);
                (local.z > MIN_COS && wi.z > MIN_COS).then_some((wi, false))
            }
            BASE if self.base.mirror => Some((mirror(wo), true)),
            BASE => {
                let wi = self.base.ggx.sample_reflection(wo, u);
                (wi.z > MIN_COS).then_some((wi, false))
            }
            BEYOND => match &self.beyond {
                Beyond::Nothing => None,
                Beyond::Sheet(lobe) if lobe.mirror => Some((-wo, true)),
                Beyond::Sheet(lobe) => {
                    let wi = lobe.ggx.sample_reflection(wo, u);
                    (wi.z > MIN_COS).then_some((turned_over(wi), false))
                }
                Beyond::Volume(r) => {
                    // A facet that reflects all gives the lobe a direction on this side, where it has no value.
                    let s = r.lobe.sample(wo, uc, u).filter(|s| s.wi.z < 0.0)?;
                    Some((s.wi, s.delta))
                }
                Beyond::Inside(r) => {
                    let s = r.lobe.sample(wo, uc, u)?;
                    Some((s.wi, s.delta))
                }
            },
            _ => {
                let wi = self.diffuse[part - DIFFUSE].as_ref()?.lobe.sample(wo, uc, u)?;
                Some((if part == DIFFUSE_THROUGH { turned_over(wi) } else { wi }, false))
            }
        }
    }
}

/// The diffuse lobes of what is opaque.
fn mattes(p: &OpenPbrParams, shown: Mix) -> [Option<Matte>; 3] {
    let subsurface = unit(p.subsurface_weight);
    let sigma = unit(p.base_diffuse_roughness);
    let matte = |color: Spectrum, sigma: f32, scale: Spectrum| {
        (shown.opaque > 0.0 && !(scale * color).is_black())
            .then(|| Matte { lobe: MatteLobe::new(color, sigma), scale })
    };
    let diffuse =
        matte(p.base_color.map(unit), sigma, Spectrum::splat((1.0 - subsurface) * unit(p.base_weight)));
    let color = p.subsurface_color.map(unit);
    if !p.geometry_thin_walled {
        return [diffuse, matte(color, 0.0, Spectrum::splat(subsurface)), None];
    }
    // OpenPBR 1.1, equation "thin_wall_subsurface"; the lobes themselves are white.
    let forward = 0.5 * (1.0 + p.subsurface_scatter_anisotropy.max(-1.0).min(1.0));
    let part = |part: f32| matte(Spectrum::ONE, sigma, color * (subsurface * part));
    [diffuse, part(1.0 - forward), part(forward)]
}

/// Each part in proportion to the largest lane of its albedo.
#[inline(always)]
fn probabilities(albedo: &[Spectrum; PARTS]) -> [f32; PARTS] {
    let mut p = albedo.map(|a| a.max_element().max(0.0));
    let all: f32 = p.iter().sum();
    // Less light than that is none: its inverse could leave f32.
    if !(all > 1e-30) {
        return [0.0; PARTS];
    }
    // A part of less than a millionth is never picked: one over its probability could leave f32.
    let least = all * 1e-6;
    p = p.map(|v| if v > least { v } else { 0.0 });
    let inv = 1.0 / p.iter().sum::<f32>();
    p.map(|v| v * inv)
}

impl Bsdf for OpenPbr {
    #[inline]
    fn eval_pdf(&self, wo: Vec3A, wi: Vec3A) -> Eval {
        // Also taken by NaN.
        if !(wo.z > MIN_COS && wi.z.abs() > MIN_COS && wo.is_finite() && wi.is_finite()) {
            return Eval::ZERO;
        }
        self.eval_with(&self.view(wo), wo, wi)
    }

    #[inline]
    fn sample(&self, wo: Vec3A, uc: f32, u: [f32; 2]) -> Option<BsdfSample> {
        if !(wo.z > MIN_COS && wo.is_finite()) {
            return None;
        }
        let view = self.view(wo);
        let mut rest = uc.max(0.0);
        let mut part = None;
        for (i, &p) in view.p.iter().enumerate() {
            if p > 0.0 {
                // Rounding at the end falls to the last part that is there.
                part = Some((i, (rest / p).min(1.0 - f32::EPSILON)));
                if rest < p {
                    break;
                }
                rest -= p;
            }
        }
        let (part, uc) = part?;
        let (wi, delta) = self.draw(&view, part, wo, uc, u)?;
        if delta {
            let d = if wi.z > 0.0 { self.mirrored(&view, wo)? } else { self.straight(&view, wo)? };
            let weight = d.reflectance * (1.0 / d.probability);
            return Some(BsdfSample {
                wi: d.wi,
                weight,
                weight_diffuse: Spectrum::ZERO,
                weight_specular: weight,
                pdf: d.probability,
                delta: true,
                lobe: LobeKind::Specular,
            });
        }
        if !(wi.is_finite() && wi.z.abs() > MIN_COS) {
            return None;
        }
        let e = self.eval_with(&view, wo, wi);
        if !(e.pdf > 0.0) {
            return None;
        }
        let scale = wi.z.abs() / e.pdf;
        let (weight_diffuse, weight_specular) = (e.diffuse * scale, e.specular * scale);
        let diffuse = part == FUZZ || (DIFFUSE..=DIFFUSE_THROUGH).contains(&part);
        Some(BsdfSample {
            wi,
            weight: weight_diffuse + weight_specular,
            weight_diffuse,
            weight_specular,
            pdf: e.pdf,
            delta: false,
            lobe: if diffuse { LobeKind::Diffuse } else { LobeKind::Specular },
        })
    }

    #[inline]
    fn albedo(&self, wo: Vec3A) -> Spectrum {
        if !(wo.z > MIN_COS && wo.is_finite()) {
            return Spectrum::ZERO;
        }
        self.view(wo).albedo.into_iter().fold(Spectrum::ZERO, |a, b| a + b)
    }

    fn deltas(&self, wo: Vec3A) -> [Option<DeltaPart>; 2] {
        if !(wo.z > MIN_COS && wo.is_finite()) {
            return [None, None];
        }
        let view = self.view(wo);
        [self.mirrored(&view, wo), self.straight(&view, wo)]
    }

    fn narrowest_alpha(&self) -> [f32; 2] {
        let mut out = [1.0f32; 2];
        let mut narrow = |a: [f32; 2]| out = [out[0].min(a[0]), out[1].min(a[1])];
        self.base.alpha().into_iter().for_each(&mut narrow);
        if let Some(a) = self.coat.as_ref().and_then(|c| c.lobe.alpha()) {
            // A coat with a frame of its own may be narrow along any axis.
            let least = a[0].min(a[1]);
            narrow(if self.coat.as_ref().is_some_and(Coat::has_frame) { [least; 2] } else { a });
        }
        if let Beyond::Sheet(lobe) = &self.beyond {
            lobe.alpha().into_iter().for_each(&mut narrow);
        }
        out
    }

    fn refraction(&self) -> Option<f32> {
        match &self.beyond {
            Beyond::Volume(r) | Beyond::Inside(r) => r.lobe.refraction(),
            Beyond::Sheet(_) => Some(1.0),
            Beyond::Nothing => self.diffuse[DIFFUSE_THROUGH - DIFFUSE].map(|_| 1.0),
        }
    }
}
