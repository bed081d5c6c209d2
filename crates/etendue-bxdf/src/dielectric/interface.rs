//! How much of the light a boundary reflects and how much it lets through.

use crate::{
    fresnel::{Schlick, schlick_weight},
    fresnel_term::{Dielectric, Fresnel},
};
use etendue_color::Spectrum;
use glam::Vec3A;

/// Relative indices of refraction nearer to 1 than this count as 1: such a boundary reflects 2.5e-7 of the light at
/// normal incidence and bends it by less than 0.06° up to 45°.
pub const MATCHED: f32 = 1e-3;

/// A boundary between two media, as its microfacets show it to light that comes from the near side.
///
/// For reciprocity the interfaces seen from the two sides of one boundary must reflect alike at angles that refraction
/// joins; [`Dielectric`] and [`SchlickInterface`] do.
pub trait Interface: Copy {
    /// Index of refraction of the far side over that of the near side, > 0; 1 where light is not bent.
    fn eta(&self) -> f32;

    /// The part that is reflected at an angle of cosine `cos` (0..1) on the near side; each lane 0..1.
    fn reflect(&self, cos: f32) -> Spectrum;

    /// The part that passes, each lane 0..1; reflection and transmission together at most 1.
    #[inline(always)]
    fn transmit(&self, cos: f32) -> Spectrum {
        Spectrum::ONE - self.reflect(cos)
    }

    /// [`Interface::reflect`] for a refracted ray whose cosines on both sides are known: `near` and `far`, 0..1. It keeps
    /// the digits where one of them is small, so that both sides of a boundary agree, and needs no root.
    #[inline(always)]
    fn reflect_between(&self, near: f32, far: f32) -> Spectrum {
        let _ = far;
        self.reflect(near)
    }

    /// [`Interface::transmit`] for a refracted ray, as [`Interface::reflect_between`].
    #[inline(always)]
    fn transmit_between(&self, near: f32, far: f32) -> Spectrum {
        Spectrum::ONE - self.reflect_between(near, far)
    }

    /// The part that is reflected by all the microfacets that are seen from `wo` (in the lobe's frame), over which
    /// Schlick's (1 − cos)⁵ has the mean `w`: exact for interfaces that follow Schlick's curve and for smooth
    /// surfaces, an estimate for others.
    #[inline(always)]
    fn reflect_mean(&self, wo: Vec3A, w: f32) -> Spectrum {
        let cos = wo.z;
        let steep = self.reflect(0.0) - self.reflect(1.0);
        shifted(self.reflect(cos), steep, w - schlick_weight(cos))
    }

    /// The part that passes them, as [`Interface::reflect_mean`].
    #[inline(always)]
    fn transmit_mean(&self, wo: Vec3A, w: f32) -> Spectrum {
        let cos = wo.z;
        let steep = self.transmit(0.0) - self.transmit(1.0);
        shifted(self.transmit(cos), steep, w - schlick_weight(cos))
    }
}

/// start + slope · by, lanes clamped to 0..1.
#[inline(always)]
fn shifted(start: Spectrum, slope: Spectrum, by: f32) -> Spectrum {
    (start + slope * by).map(|v| clamp(v, 0.0, 1.0))
}

/// `x` clamped to `low..high`, NaN to `low`.
#[inline(always)]
fn clamp(x: f32, low: f32, high: f32) -> f32 {
    x.max(low).min(high)
}

/// A relative index as the lobes take it: exactly 1 within [`MATCHED`].
#[inline(always)]
fn snapped(eta: f32) -> f32 {
    if (eta - 1.0).abs() < MATCHED { 1.0 } else { eta }
}

/// Within [`MATCHED`] of index 1 there is no boundary: everything passes.
impl Interface for Dielectric {
    #[inline(always)]
    fn eta(&self) -> f32 {
        snapped(Dielectric::eta(self))
    }

    #[inline(always)]
    fn reflect(&self, cos: f32) -> Spectrum {
        if Interface::eta(self) == 1.0 { Spectrum::ZERO } else { self.eval(cos) }
    }

    #[inline(always)]
    fn reflect_between(&self, near: f32, far: f32) -> Spectrum {
        let eta = Interface::eta(self);
        if eta == 1.0 {
            return Spectrum::ZERO;
        }
        let parallel = (eta * near - far) / (eta * near + far);
        let perpendicular = (near - eta * far) / (near + eta * far);
        // 0 / 0 counts as grazing: everything is reflected.
        Spectrum::splat((0.5 * (parallel * parallel + perpendicular * perpendicular)).min(1.0))
    }
}

/// Schlick's curve with its own F0 and F90 over refraction by a given index, as material models with an artist's
/// specular colour need it.
///
/// The curve is taken at the angle on the side of the smaller index, and is 1 beyond the critical angle, so that both
/// sides of the boundary reflect alike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SchlickInterface {
    schlick: Schlick,
    eta: f32,
}

impl SchlickInterface {
    /// The curve (lanes clamped to 0..1, NaN to 0) and the relative index (as [`Dielectric::new`] takes it).
    #[inline(always)]
    pub fn new(schlick: Schlick, eta: f32) -> Self {
        let unit = |x: f32| clamp(x, 0.0, 1.0);
        Self {
            schlick: Schlick { f0: schlick.f0.map(unit), f90: schlick.f90.map(unit) },
            eta: snapped(Dielectric::new(eta).eta()),
        }
    }
}

impl Interface for SchlickInterface {
    #[inline(always)]
    fn eta(&self) -> f32 {
        self.eta
    }

    #[inline(always)]
    fn reflect(&self, cos: f32) -> Spectrum {
        let c = clamp(cos, 0.0, 1.0);
        if self.eta >= 1.0 {
            return self.schlick.eval(c);
        }
        let cos2_t = 1.0 - (1.0 - c) * (1.0 + c) / (self.eta * self.eta);
        if cos2_t > 0.0 { self.schlick.eval(cos2_t.sqrt()) } else { Spectrum::ONE }
    }

    #[inline(always)]
    fn reflect_between(&self, near: f32, far: f32) -> Spectrum {
        self.schlick.eval(if self.eta >= 1.0 { near } else { far })
    }
}

/// A sheet with two parallel faces in place of one boundary: light goes to and fro inside it without end.
///
/// With R the reflectance of one face and a the part of the light that survives one crossing (geometric series; for
/// a = 1 it is the pile of plates of Stokes 1862):
///
/// ```text
/// R' = R + (1 − R)² a² R / (1 − a² R²),   T' = (1 − R)² a / (1 − a² R²)
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sheet<I> {
    face: I,
    crossing: Spectrum,
}

impl<I: Interface> Sheet<I> {
    /// One face, seen from outside, and the part of the light that survives a crossing (lanes 0..1, NaN to 0) whatever
    /// its direction.
    #[inline(always)]
    pub fn new(face: I, crossing: Spectrum) -> Self {
        Self { face, crossing: crossing.map(|v| clamp(v, 0.0, 1.0)) }
    }

    /// R' and T' of a face that reflects `r`.
    #[inline(always)]
    fn both(&self, r: Spectrum) -> [Spectrum; 2] {
        let mut out = [r, Spectrum::ZERO];
        for lane in 0..4 {
            let (r, a) = (r[lane], self.crossing[lane]);
            let through = 1.0 - r;
            // A face that reflects everything lets nothing in: the inverse only has to be finite.
            let series = through * through * a / (1.0 - a * a * r * r).max(1e-12);
            out[0][lane] = (r + series * a * r).min(1.0);
            out[1][lane] = series.min(1.0);
        }
        out
    }
}

impl<I: Interface> Interface for Sheet<I> {
    /// 1: what passes goes on in its direction.
    #[inline(always)]
    fn eta(&self) -> f32 {
        1.0
    }

    #[inline(always)]
    fn reflect(&self, cos: f32) -> Spectrum {
        self.both(self.face.reflect(cos))[0]
    }

    #[inline(always)]
    fn transmit(&self, cos: f32) -> Spectrum {
        self.both(self.face.reflect(cos))[1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_boundary_reflects_alike_from_both_sides() {
        let schlick = Schlick { f0: Spectrum::rgb(0.04, 0.1, 0.5), f90: Spectrum::splat(0.9) };
        for i in 10..100 {
            let c = i as f32 / 100.0;
            let t = (1.0 - (1.0 - c * c) / 2.25f32).sqrt();
            let a = SchlickInterface::new(schlick, 1.5).reflect(c);
            let b = SchlickInterface::new(schlick, 1.0 / 1.5).reflect(t);
            assert!((a - b).map(f32::abs).max_element() < 1e-5);
        }
    }

    #[test]
    fn a_clear_sheet_loses_nothing() {
        for i in 0..=100 {
            let c = i as f32 / 100.0;
            let sheet = Sheet::new(Dielectric::new(1.5), Spectrum::ONE);
            let sum = sheet.reflect(c) + sheet.transmit(c);
            assert!((sum - Spectrum::ONE).map(f32::abs).max_element() < 1e-5, "{c}: {sum:?}");
            // Two faces without absorption: R' = 2R / (1 + R) (Stokes 1862).
            let r = Dielectric::new(1.5).reflect(c)[0];
            assert!((sheet.reflect(c)[0] - 2.0 * r / (1.0 + r)).abs() < 1e-5);
        }
        let smoked = Sheet::new(Dielectric::new(1.5), Spectrum::splat(0.5));
        // By adding the bounces one by one.
        let (r, a) = (0.04f32, 0.5f32);
        let (mut back, mut through, mut inside) = (r, 0.0, (1.0 - r) * a);
        for bounce in 0..20 {
            if bounce % 2 == 0 {
                through += inside * (1.0 - r)
            } else {
                back += inside * (1.0 - r)
            }
            inside *= r * a;
        }
        assert!((smoked.reflect(1.0)[0] - back).abs() < 1e-6);
        assert!((smoked.transmit(1.0)[0] - through).abs() < 1e-6);
    }
}
