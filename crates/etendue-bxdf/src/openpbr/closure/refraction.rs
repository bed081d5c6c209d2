//! The boundary of a volume, and what its microfacets lose of the light that passes.

use crate::{
    dielectric::{GgxDielectric, Interface},
    model::Incidence,
    multiscatter::{loss::BoundaryLoss, mean_alpha},
    openpbr::{
        facet::{Boundary, Facets},
        lobe::Lobe,
    },
};
use etendue_color::Spectrum;
use glam::Vec3A;

/// The boundary of a volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Refraction {
    pub lobe: GgxDielectric<Boundary>,
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
    pub(super) fn new(alpha: [f32; 2], boundary: Boundary, at: &Incidence) -> Self {
        let lobe = GgxDielectric::new(alpha, boundary, at.transport);
        let loss = lobe.is_rough().then(|| {
            let (mean, share) = mean_alpha(lobe.ggx().alpha());
            Loss { table: BoundaryLoss::new(mean, lobe.interface().eta()), share }
        });
        Self { lobe, loss }
    }

    /// The part of the light that one event of the bare boundary brings out on either side, rather above than below.
    #[inline(always)]
    pub(super) fn kept(&self, wo: Vec3A) -> f32 {
        self.loss.as_ref().map_or(1.0, |l| (1.0 + LOSS_SLACK - l.table.directional(wo.z) * l.share).min(1.0))
    }

    /// What part of the light the lobe lets pass by one event, by lane, rather above than below: `e` is the albedo of a
    /// mirror of the same facets, `bare` the bare boundary's mean reflectance and `mean` the one that it has here.
    ///
    /// All that the bare boundary keeps less what it reflects; and where a coat or a film lets more enter than the bare
    /// boundary does, at most all of that. The means are over facets whose reflection comes out; those whose reflection is
    /// lost are steeper, and differ by up to three times as much.
    #[inline(always)]
    pub(super) fn passed(&self, wo: Vec3A, e: f32, bare: Spectrum, mean: Spectrum) -> Spectrum {
        if self.loss.is_none() {
            return (Spectrum::ONE - mean).max(Spectrum::ZERO);
        }
        let more = (bare - mean).max(Spectrum::ZERO) * (3.0 - 2.0 * e);
        (Spectrum::splat(self.kept(wo)) - bare * e + more).map(|v| v.max(0.01))
    }

    /// The part that the boundary seen from inside keeps, rather above than below; `facets` are those of the base.
    #[inline]
    pub(super) fn kept_inside(&self, wo: Vec3A, facets: &Facets, base: &Lobe) -> f32 {
        let boundary = self.lobe.interface();
        if self.loss.is_none() || facets.bare_eta() == Some(1.0 / boundary.eta()) {
            return self.kept(wo);
        }
        let [other] = base.seen(wo).mean(|cos| [boundary.change(cos)]);
        (self.kept(wo) + other.max_element()).min(1.0)
    }
}
