//! Light that enters a surface at another point than where it leaves.

use crate::surface::Surface;
use crate::world::World;
use etendue_bxdf::bssrdf::{EntryLobe, Subsurface, SubsurfaceParams};
use etendue_bxdf::model::{Incidence, ModelParams};
use etendue_bxdf::{Bsdf, MetalRough};
use etendue_color::Spectrum;
use etendue_trace::Ray;
use glam::Vec3A;

/// A translucent material.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Skin {
    /// The reflection at the surface.
    pub gloss: MetalRough,
    pub entry: EntryLobe,
    subsurface: Subsurface,
    /// The lobe of light that leaves where it entered, through the same surface.
    whole: MetalRough,
}

/// Hits of one probe that are kept; a probe that meets more is cut off there.
const MOST_HITS: u32 = 64;

impl Skin {
    pub fn new(p: &SubsurfaceParams) -> Self {
        let white = SubsurfaceParams { color: Spectrum::ONE, ..*p };
        Self {
            gloss: p.gloss(),
            entry: p.entry(),
            subsurface: Subsurface::new(p),
            whole: white.closure(&Incidence::default()),
        }
    }

    /// Part of the light seen along `wo` that came through the surface and not from its gloss, and the probability with
    /// which to follow the gloss.
    pub fn split(&self, wo: Vec3A) -> (f32, f32) {
        let gloss = self.gloss.albedo(wo);
        let through = (self.whole.albedo(wo) - gloss).max_element().max(0.0);
        let below = (self.subsurface.albedo() + self.subsurface.local()).max_element() * through;
        let above = gloss.max_element();
        let p = if above + below > 0.0 { above / (above + below) } else { 1.0 };
        (through, p)
    }

    /// Where the light that leaves at `from` entered, and what it is worth: per unit of light that leaves, over the density of
    /// the choice. `None` if the probe finds nothing.
    ///
    /// `uc` picks what `Subsurface::sample_probe` picks, `u` the radius and angle, `pick` one of the points that the probe
    /// finds. Only the material of `from` is looked for: other objects do not stop a probe.
    pub fn enter(
        &self,
        world: &World,
        from: &Surface,
        uc: f32,
        u: [f32; 2],
        pick: f32,
    ) -> Option<(Surface, Spectrum)> {
        // Lanes that do not travel leave where they entered.
        let local = self.subsurface.local();
        let all = local.max_element() + self.subsurface.albedo().max_element();
        let stays = if all > 0.0 { local.max_element() / all } else { return None };
        if uc < stays {
            return Some((*from, local / stays));
        }
        let uc = (uc - stays) / (1.0 - stays);
        let probe = self.subsurface.sample_probe(uc, u)?;
        let origin = from.point + from.frame * probe.origin;
        let direction = (from.frame * probe.direction).normalize();
        let mut ray = Ray { origin, direction, t_min: 0.0, t_max: probe.length };
        let mut chosen = None;
        let (mut count, mut pick) = (0u32, pick);
        for _ in 0..MOST_HITS {
            let Some(hit) = world.accel.closest(&ray, &|_, _, _, _| true) else { break };
            ray.t_min = hit.t;
            if world.instances[hit.instance as usize].material != from.material {
                continue;
            }
            count += 1;
            // One of all with the same probability, without knowing how many there will be; what is left of the number
            // picks again.
            let keep = 1.0 / count as f32;
            if pick < keep {
                chosen = Some(hit);
                pick /= keep;
            } else {
                pick = (pick - keep) / (1.0 - keep);
            }
        }
        let hit = chosen?;
        let mut surface = Surface::new(world, &hit, direction);
        if !surface.front {
            surface = Surface::new(world, &hit, -direction);
        }
        let to_local = from.frame.transpose();
        let found =
            self.subsurface.found(to_local * (surface.point - from.point), to_local * surface.geometric);
        if found.pdf <= 0.0 || found.pdf.is_nan() {
            return None;
        }
        let weight = found.value * (count as f32 / ((1.0 - stays) * found.pdf));
        Some((surface, weight))
    }
}
