//! The roughness of the base, and how much of the light its microfacets let in on average.

use super::facet::Facet;
use crate::{
    energy::Row,
    fresnel::schlick_weight,
    fresnel_average::Rules,
    ggx::{ALPHA_DELTA, Ggx},
};
use glam::{Vec3A, vec3a};

/// A distribution of microfacets with what the tables say of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Shape {
    pub ggx: Ggx,
    /// True if all facets face up.
    pub mirror: bool,
    pub row: Row,
    rules: Rules,
    isotropic: bool,
}

/// Sixteen points of a rank-1 lattice (generator 7) in the middle of their cells: a fraction, and cosine and sine of an angle.
const LATTICE: [[f32; 3]; 16] = [
    [0.031250, 0.98078528, 0.19509032],
    [0.468750, 0.83146961, 0.55557023],
    [0.906250, 0.55557023, 0.83146961],
    [0.343750, 0.19509032, 0.98078528],
    [0.781250, -0.19509032, 0.98078528],
    [0.218750, -0.55557023, 0.83146961],
    [0.656250, -0.83146961, 0.55557023],
    [0.093750, -0.98078528, 0.19509032],
    [0.531250, -0.98078528, -0.19509032],
    [0.968750, -0.83146961, -0.55557023],
    [0.406250, -0.55557023, -0.83146961],
    [0.843750, -0.19509032, -0.98078528],
    [0.281250, 0.19509032, -0.98078528],
    [0.718750, 0.55557023, -0.83146961],
    [0.156250, 0.83146961, -0.55557023],
    [0.593750, 0.98078528, -0.19509032],
];

impl Shape {
    /// α along x and y, 0..1.
    #[inline(always)]
    pub fn new(alpha: [f32; 2]) -> Self {
        let isotropic = alpha[0] == alpha[1];
        let mean = if isotropic { alpha[0] } else { (alpha[0] * alpha[1]).sqrt() };
        let roughness = mean.sqrt();
        Self {
            ggx: Ggx::new(alpha[0], alpha[1]),
            mirror: alpha[0].max(alpha[1]) < ALPHA_DELTA,
            row: Row::new(roughness),
            rules: Rules::new(roughness),
            isotropic,
        }
    }

    /// True if it looks the same from all azimuths.
    #[inline(always)]
    pub fn is_isotropic(&self) -> bool {
        self.isotropic
    }

    /// The part of the light from `w` (above the surface) that enters the dielectric: one minus the facets' mean of [`Facet::under`].
    ///
    /// On Schlick's curve the mean is the table's; under a film that of a four-point rule ([`crate::fresnel_average`]).
    /// Anisotropic surfaces have no table: it is the mean over sixteen facets of equal weight that are seen from `w`.
    /// Total reflection is a step that four points cannot average: there the largest of the four is taken, which errs
    /// towards darkness.
    #[inline(always)]
    pub fn enters(&self, facet: &Facet, w: Vec3A) -> f32 {
        let under = if self.mirror {
            facet.under(w.z)
        } else if !self.isotropic {
            self.mean_of_seen(facet, w)
        } else if let Some((f0, f90)) = facet.under_schlick() {
            f0 + (f90 - f0) * self.row.directional(w.z).w
        } else {
            let rule = self.rules.directional(w.z);
            let each = rule.cos.into_iter().zip(rule.weight).map(|(c, weight)| (facet.under(c), weight));
            if facet.may_trap() {
                each.map(|(f, _)| f).fold(0.0, f32::max)
            } else {
                each.map(|(f, weight)| f * weight).sum()
            }
        };
        (1.0 - under).max(0.0).min(1.0)
    }

    fn mean_of_seen(&self, facet: &Facet, w: Vec3A) -> f32 {
        // All four quadrants are alike: one set of facets for all, lest the lattice tell them apart.
        let w = w.abs();
        let [ax, ay] = self.ggx.alpha();
        let stretched = vec3a(ax * w.x, ay * w.y, w.z);
        let i = stretched * (1.0 / stretched.length_squared().sqrt());
        let mut sum = 0.0;
        for [u, cos, sin] in LATTICE {
            // As `Ggx::sample_half` draws them.
            let drop = u * (1.0 + i.z);
            let r = (drop * (2.0 - drop)).max(0.0).sqrt();
            let m = vec3a(ax * (r * cos + i.x), ay * (r * sin + i.y), (1.0 - drop) + i.z);
            sum += facet.under(w.dot(m) * (1.0 / m.length_squared().sqrt()));
        }
        // Sixteen facets miss what is nearest to the horizon: at 89° a white surface returned up to 1.009. What is added here
        // there, and hardly elsewhere, is more than that.
        let grazing = schlick_weight(w.z) * schlick_weight(w.z);
        sum * (1.0 / LATTICE.len() as f32) + 0.013 * grazing
    }
}
