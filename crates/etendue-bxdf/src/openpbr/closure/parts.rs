//! The parts that a sample is drawn from.

use super::{Beyond, OpenPbr, scatter::turned_over, view::View};
use crate::{
    bsdf::{Bsdf, MIN_COS},
    ggx::mirror,
};
use etendue_color::Spectrum;
use glam::Vec3A;

/// What can be drawn from: the order of the probabilities. The three diffuse parts follow each other.
pub(super) const FUZZ: usize = 0;
pub(super) const COAT: usize = 1;
pub(super) const BASE: usize = 2;
pub(super) const DIFFUSE: usize = 3;
pub(super) const DIFFUSE_THROUGH: usize = 5;
pub(super) const BEYOND: usize = 6;
pub(super) const PARTS: usize = 7;

/// Each part in proportion to the largest lane of its albedo.
#[inline(always)]
pub(super) fn probabilities(albedo: &[Spectrum; PARTS]) -> [f32; PARTS] {
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

impl OpenPbr {
    /// A direction from one part; the flag says that it is the part's perfectly specular one.
    #[inline]
    pub(super) fn draw(
        &self,
        view: &View,
        part: usize,
        wo: Vec3A,
        uc: f32,
        u: [f32; 2],
    ) -> Option<(Vec3A, bool)> {
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
                // A facet that reflects all may give a lobe without reflection a direction on this side.
                Beyond::Volume(r) => r.sample(wo, uc, u).filter(|s| r.reflects() || s.0.z < 0.0),
                Beyond::Inside(r) => r.sample(wo, uc, u),
            },
            _ => {
                let wi = self.diffuse[part - DIFFUSE].as_ref()?.lobe.sample(wo, uc, u)?;
                Some((if part == DIFFUSE_THROUGH { turned_over(wi) } else { wi }, false))
            }
        }
    }
}
