//! Light that meets more than one microfacet.
//!
//! A microfacet lobe with one scattering event loses what is masked on its way out: at roughness 1 and normal incidence
//! a mirror of F = 1 keeps 1 − ln 2 = 0.3069. Three ways to give it back:
//!
//! | type | what it is |
//! |---|---|
//! | [`CompensatedGgx`], [`CompensatedDielectric`] with [`Compensation::KullaConty`] | a second, wide lobe with the energy that is missing; reciprocal |
//! | the same with [`Compensation::Turquin`] | the lobe scaled up by what is missing from `wo`; not reciprocal, keeps its shape |
//! | [`Microsurface`] | the random walk between microfacets itself (Heitz et al. 2016): slow and noisy, the oracle for the others |
//!
//! How much is missing is in the tables of [`loss`].

mod dielectric;
mod further;
pub mod loss;
mod microsurface;
mod reflection;
mod wide;

pub use dielectric::CompensatedDielectric;
pub(crate) use further::Further;
pub use microsurface::{Microsurface, Opaque, Walked};
pub use reflection::CompensatedGgx;

/// The one α that a surface of two loses as much light as: √((αx² + αy²) / 2), right to 2 % of itself at normal incidence
/// over anisotropy 0..0.9; and what part of that loss may be given back without making light anywhere.
///
/// At grazing angles the loss depends on the azimuth, which neither table knows. The part (αmin / αmax)^(5/4) stays below
/// the loss at every angle tried (8 angles, 4 azimuths, αmax 0.03..1, ratios 0.1..0.8; mirrors and glass from both sides).
#[inline(always)]
pub(crate) fn mean_alpha([x, y]: [f32; 2]) -> (f32, f32) {
    let ratio = x.min(y) / x.max(y);
    ((0.5 * (x * x + y * y)).sqrt(), ratio * ratio.sqrt().sqrt())
}

crate::choices! {
    /// What is done about light that meets more than one microfacet.
    pub enum Compensation {
        /// Nothing: it is lost.
        None = "none",
        /// A second lobe (Kulla, Conty 2017); reciprocal.
        KullaConty = "kulla-conty",
        /// The lobe is scaled (Turquin 2019); not reciprocal.
        Turquin = "turquin",
    }
}

/// By a second lobe: conserves energy and is reciprocal.
impl Default for Compensation {
    fn default() -> Self {
        Self::KullaConty
    }
}

impl Compensation {
    /// The claims of a model that keeps all laws without it.
    pub fn claims(self) -> crate::model::Claims {
        use crate::model::{Claim, Claims};
        match self {
            Self::Turquin => Claims {
                reciprocal: Claim::Breaks("Turquin's scaling looks at the side of wo only"),
                ..Claims::ALL
            },
            _ => Claims::ALL,
        }
    }
}
