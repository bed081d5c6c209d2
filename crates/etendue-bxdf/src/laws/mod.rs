//! The laws that a scattering function must keep, as code that anything can be put to.
//!
//! | module | law |
//! |---|---|
//! | [`chi2`] | `sample` draws from `pdf` |
//! | [`sampling`] | each sample's weight is `eval · cos / pdf`; `pdf` integrates to what `sample` returns |
//! | [`furnace`] | no more light comes back than went in; sampling and quadrature agree on how much |
//! | [`reciprocity`] | f(wo, wi) = f(wi, wo), and its like through an interface |
//! | [`finite`] | no input gives anything but finite values that are not negative |
//!
//! Each function judges one closure at one `wo` and returns what it measured; what samples are held against comes from
//! [`expected`]. [`verify`] runs all of them over the
//! [`cases`] of a model: this crate's tests and the command line share it. [`grid`] has the angles, and lobes that are
//! not models.

pub mod cases;
pub mod chi2;
pub mod expected;
pub mod finite;
pub mod furnace;
pub mod gamma;
pub mod grid;
pub mod reciprocity;
pub mod sampling;
pub mod verify;

/// Random numbers for the statistical laws: a counter through Stafford's 13th mix (Steele, Lea, Flood 2014,
/// "Fast Splittable Pseudorandom Number Generators"). The same seed gives the same numbers everywhere.
#[derive(Clone, Debug)]
pub struct Rng(u64);

impl Rng {
    /// A sequence of its own for each seed.
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0xd134_2543_de82_ef95).wrapping_add(0x9e37_79b9_7f4a_7c15))
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in 0..1, 24 bits, never 1.
    pub fn uniform(&mut self) -> f32 {
        (self.bits() >> 40) as f32 * (1.0 / 16777216.0)
    }

    /// A point of the unit square.
    pub fn square(&mut self) -> [f32; 2] {
        [self.uniform(), self.uniform()]
    }
}

/// The significance level of each of `cells` tests such that all together have the level `alpha` (Šidák 1967):
/// 1 − (1 − α)^(1/cells).
pub fn sidak(alpha: f64, cells: usize) -> f64 {
    // expm1 and ln_1p keep the digits of the small result.
    -((-alpha).ln_1p() / cells.max(1) as f64).exp_m1()
}
