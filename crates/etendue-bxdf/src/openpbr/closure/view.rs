//! The closure from one direction: what its layers leave each other, and what each part returns.

use super::{
    Beyond, OpenPbr,
    parts::{BASE, BEYOND, COAT, DIFFUSE, DIFFUSE_THROUGH, FUZZ, PARTS, probabilities},
};
use crate::{bsdf::Bsdf, openpbr::coat::CoatView};
use etendue_color::Spectrum;
use glam::Vec3A;

/// What depends on `wo` alone.
#[derive(Clone, Copy)]
pub(super) struct View {
    /// 1 − what the fuzz takes.
    pub under_fuzz: f32,
    pub coat: Option<CoatView>,
    /// Factors of the kinds of facet: weight and compensation; the opaque one's with its tint.
    pub metal: Spectrum,
    pub opaque: Spectrum,
    pub clear: Spectrum,
    /// Factor of the diffuse parts: what gets through the dielectric's surface.
    pub substrate: Spectrum,
    /// Factor of what passes the translucent part.
    pub through: Spectrum,
    /// Factor of the boundary seen from inside.
    pub inside: f32,
    /// Factor of everything on the base that does not depend on `wi`.
    pub under: Spectrum,
    /// The part of the light that each part returns.
    pub albedo: [Spectrum; PARTS],
    /// Probability to draw from each.
    pub p: [f32; PARTS],
}

/// a / b by lane, 0 where b is 0.
#[inline(always)]
fn ratio(a: Spectrum, b: Spectrum) -> Spectrum {
    Spectrum(core::array::from_fn(|i| if b[i] > 0.0 { a[i] / b[i] } else { 0.0 }))
}

/// The mean 1/µ in the coat of the far end of a diffuse path is taken at this cosine.
const DIFFUSE_COS: f32 = 2.0 / 3.0;

impl OpenPbr {
    #[inline]
    pub(super) fn view(&self, wo: Vec3A) -> View {
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
            Beyond::Volume(r) if r.reflects() => {
                // Its own lobe reflects what this part reflects.
                clear = black;
                through = self.passage * self.mix.clear;
                let [reflected, passed] = r.energy(wo, c);
                albedo[BEYOND] = (reflected * self.facets.tint() * over[0] * self.mix.clear
                    + passed * through * over[2])
                    * under;
            }
            Beyond::Volume(_) => {
                let part = if self.facets.eta() < 1.0 {
                    // The mean over a step, where total reflection begins, is not to be trusted with the smaller part.
                    clear = Spectrum::splat(self.mix.clear);
                    through = self.passage * self.mix.clear;
                    (Spectrum::ONE - c * seen.e).max(black) * through
                } else {
                    // All that is not reflected, whatever the facets lose of it.
                    let part = (rest - c * clear_scale * seen.e).max(black) * self.mix.clear * self.passage;
                    through = ratio(part, (Spectrum::ONE - c).max(black));
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
                inside = 1.0 - self.outer;
                let boundary = r.lobe.interface();
                let [mean] = seen.mean(|cos| [boundary.whole(cos)]);
                let [r, t] = r.energy(wo, mean);
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
}
