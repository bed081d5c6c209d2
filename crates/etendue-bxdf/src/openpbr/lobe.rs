//! A GGX lobe with what layering needs of it: the part of the light that it takes, for any Fresnel term.

use crate::{
    energy::Row,
    fresnel_average::{AnisotropicRules, Rule, Rules},
    ggx::{ALPHA_DELTA, Ggx},
};
use etendue_color::Spectrum;
use glam::Vec3A;

/// A reflecting lobe, or the mirror that it becomes below [`ALPHA_DELTA`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Lobe {
    pub ggx: Ggx,
    pub mirror: bool,
    tables: Tables,
}

/// Where the lobe's albedo and the angles of its facets stand.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Tables {
    Isotropic(Row, Rules),
    Anisotropic(AnisotropicRules),
}

/// The lobe from one direction: its albedo for F = 1, and the angles at which its facets are met.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    pub e: f32,
    /// How far the part that is reflected may be from what the tables say: what lies below gets so much less, so that no
    /// error of a table makes light.
    pub slack: f32,
    rule: Rule,
    mirror: bool,
}

/// The largest error of the anisotropic tables ([`AnisotropicRules::directional`]).
const ANISOTROPIC_SLACK: f32 = 0.008;

impl Lobe {
    /// α along x and y; clamped to 1.
    #[inline(always)]
    pub fn new(alpha: [f32; 2]) -> Self {
        let mirror = !(alpha[0].max(alpha[1]) >= ALPHA_DELTA);
        let ggx = Ggx::new(alpha[0], alpha[1]);
        let [x, y] = ggx.alpha();
        let tables = if (x - y).abs() > 1e-3 * x.max(y) {
            Tables::Anisotropic(AnisotropicRules::new([x, y]))
        } else {
            let roughness = x.sqrt();
            Tables::Isotropic(Row::new(roughness), Rules::new(roughness))
        };
        Self { ggx, mirror, tables }
    }

    #[inline(always)]
    pub fn seen(&self, wo: Vec3A) -> Seen {
        if self.mirror {
            return Seen { e: 1.0, slack: 0.0, rule: Rule::mirror(wo.z), mirror: true };
        }
        match &self.tables {
            Tables::Isotropic(row, rules) => {
                Seen { e: row.directional(wo.z).e, slack: 0.0, rule: rules.directional(wo.z), mirror: false }
            }
            Tables::Anisotropic(rules) => {
                let (rule, e) = rules.directional(wo);
                Seen { e: (e + ANISOTROPIC_SLACK).min(1.0), slack: ANISOTROPIC_SLACK, rule, mirror: false }
            }
        }
    }

    /// α where it is not a mirror's.
    #[inline(always)]
    pub fn alpha(&self) -> Option<[f32; 2]> {
        (!self.mirror).then(|| self.ggx.alpha())
    }
}

impl Seen {
    /// The mean of `f` over the facets; `N` quantities at once.
    #[inline(always)]
    pub fn mean<const N: usize>(&self, f: impl Fn(f32) -> [Spectrum; N]) -> [Spectrum; N] {
        if self.mirror {
            return f(self.rule.cos[0]);
        }
        let mut sum = [Spectrum::ZERO; N];
        for (&cos, &weight) in self.rule.cos.iter().zip(&self.rule.weight) {
            let v = f(cos);
            for (sum, v) in sum.iter_mut().zip(v) {
                *sum += v * weight;
            }
        }
        sum
    }

    /// The factor that gives a lobe back what single scattering loses between its facets, if each of them reflects (or
    /// scatters, on both sides together) `f` on average: 1 / (1 − f (1 − E)).
    ///
    /// The sum of f E (f (1 − E))ᵏ over bounces k, each of which escapes with probability E. Where E is its own average
    /// over directions this is the albedo of Kulla, Conty 2017 ("Revisiting Physically Based Shading at Imageworks",
    /// eq. 13: E f + (1 − E) f² E / (1 − f (1 − E))); the lobe keeps its shape, as in Turquin 2019 ("Practical Multiple
    /// Scattering Compensation for Microfacet Models"), whose factor 1 + f (1 − E) / E agrees at f = 0 and f = 1 and
    /// gives more between. For f = 1 nothing is lost.
    #[inline(always)]
    pub fn compensation(&self, f: Spectrum) -> Spectrum {
        let lost = 1.0 - self.e;
        f.map(|f| 1.0 / (1.0 - f * lost).max(1e-3))
    }
}
