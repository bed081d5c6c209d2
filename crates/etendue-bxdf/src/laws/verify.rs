//! Every law over every case of a model: pure data out, for a test to assert on and for a report to show.
//!
//! Statistical laws give the probability of a result at least as bad if the law holds, and are judged together: with
//! n of them, each at the level 1 − (1 − α)^(1/n) (Šidák), so that a run over sound models fails with probability α.

use super::{
    Rng,
    cases::{Case, Settings, cases},
    chi2::chi2_against,
    expected::Expected,
    finite::finite,
    furnace::furnace_against,
    gamma::upper_regularised,
    grid::wo_at,
    reciprocity::{reciprocity, reciprocity_through},
    sampling::samples_against,
    sidak,
};
use crate::{
    bsdf::Bsdf,
    model::{Claim, Model, Transport},
};

/// What must hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Law {
    /// `sample` draws from `pdf`: p-value of χ².
    Chi2,
    /// Each sample is what `eval` and `pdf` say of it: largest relative error, infinite if anything is not finite.
    Weights,
    /// `pdf` integrates to what `sample` returns: p-value.
    Density,
    /// No more light comes back than went in: directional albedo.
    Furnace,
    /// The mean weight of samples is the albedo by quadrature: p-value, the least over lanes.
    Sampled,
    /// [`Bsdf::albedo`] is finite and not negative: its largest distance from quadrature, for information.
    Albedo,
    /// Reflection is reciprocal: largest relative difference.
    Reciprocity,
    /// Transmission is reciprocal up to η²: largest relative difference.
    ReciprocityThrough,
    /// No input breaks it: number of broken answers, 0 or 1 (the first).
    Finite,
}

impl Law {
    /// All laws, in the order of a report.
    pub const ALL: [Self; 9] = [
        Self::Chi2,
        Self::Weights,
        Self::Density,
        Self::Furnace,
        Self::Sampled,
        Self::Albedo,
        Self::Reciprocity,
        Self::ReciprocityThrough,
        Self::Finite,
    ];

    /// Its name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Chi2 => "chi2",
            Self::Weights => "weights",
            Self::Density => "density",
            Self::Furnace => "furnace",
            Self::Sampled => "sampled-albedo",
            Self::Albedo => "albedo",
            Self::Reciprocity => "reciprocity",
            Self::ReciprocityThrough => "reciprocity-through",
            Self::Finite => "finite",
        }
    }

    /// What it says, in a sentence.
    pub fn about(self) -> &'static str {
        match self {
            Self::Chi2 => "sample draws from pdf: χ² over bins on both sides, p-value",
            Self::Weights => {
                "each sample's weight is eval · |cos| / pdf and its density is pdf: largest relative error"
            }
            Self::Density => "pdf integrates to the part of samples that return a direction: p-value",
            Self::Furnace => "no more light comes back than went in: directional albedo",
            Self::Sampled => "the mean weight of samples is the albedo by quadrature: p-value",
            Self::Albedo => "the claimed albedo is finite: its distance from quadrature",
            Self::Reciprocity => "f(wo, wi) = f(wi, wo): largest relative difference",
            Self::ReciprocityThrough => {
                "f(wo, wi) η² = f(wi, wo) through the surface: largest relative difference"
            }
            Self::Finite => {
                "no parameters and directions give anything but finite values that are not negative"
            }
        }
    }

    /// True if the value is a p-value.
    pub fn is_statistical(self) -> bool {
        matches!(self, Self::Chi2 | Self::Density | Self::Sampled)
    }

    /// The largest value that is allowed; of statistical laws the least, and of no use before [`judge`].
    fn bound(self) -> f64 {
        match self {
            Self::Chi2 | Self::Density | Self::Sampled => 0.0,
            Self::Weights | Self::Reciprocity => 1e-4,
            Self::Furnace => 1.001,
            Self::Albedo => f64::MAX,
            // `f32` on two routes through an interface (see `reciprocity_through`): 2.8e-3 at α = 1e-4, where a lobe is some
            // fifty numbers wide.
            Self::ReciprocityThrough => 4e-3,
            Self::Finite => 0.0,
        }
    }
}

/// What a cell came to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The law holds.
    Holds,
    /// The law is broken.
    Fails,
    /// The model does not claim the law, and why; the value is for information.
    Waived(&'static str),
}

/// One law on one case at one angle.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    /// The law.
    pub law: Law,
    /// Angle of `wo` to the normal in degrees; `None` if the law is over all directions.
    pub angle: Option<f32>,
    /// What was measured; what it is says [`Law`].
    pub value: f64,
    /// What it is held to: an upper bound, of p-values a lower one.
    pub bound: f64,
    /// What it came to.
    pub verdict: Verdict,
    /// The seed of its random numbers.
    pub seed: u64,
    /// What else was measured, in words.
    pub note: String,
}

/// The cells of one case.
#[derive(Clone, Debug, PartialEq)]
pub struct CaseReport {
    /// The case.
    pub case: Case,
    /// Its cells.
    pub cells: Vec<Cell>,
}

/// The outcome of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// By case, in order.
    pub cases: Vec<CaseReport>,
    /// How many cells are statistical.
    pub statistical: usize,
    /// The level of each of them.
    pub level: f64,
}

impl Report {
    /// Each cell with its case.
    pub fn cells(&self) -> impl Iterator<Item = (&Case, &Cell)> {
        self.cases.iter().flat_map(|c| c.cells.iter().map(|cell| (&c.case, cell)))
    }

    /// The broken ones.
    pub fn failures(&self) -> impl Iterator<Item = (&Case, &Cell)> {
        self.cells().filter(|(_, c)| c.verdict == Verdict::Fails)
    }
}

/// Puts `model` to every law over all cases of `settings`, one after another.
///
/// To spread the work: [`cases`], [`measure`] on each in any order, then [`judge`].
pub fn verify(model: &Model, settings: &Settings) -> Report {
    let measured = cases(model, settings)
        .into_iter()
        .map(|case| CaseReport { cells: measure(&case, settings), case })
        .collect();
    judge(measured, settings.significance)
}

/// Gives each statistical cell its level, the same for all, and every cell its verdict.
pub fn judge(mut cases: Vec<CaseReport>, significance: f64) -> Report {
    let statistical = cases.iter().flat_map(|c| &c.cells).filter(|c| c.law.is_statistical()).count();
    let level = sidak(significance, statistical);
    for cell in cases.iter_mut().flat_map(|c| &mut c.cells) {
        if matches!(cell.verdict, Verdict::Waived(_)) {
            continue;
        }
        let holds = if cell.law.is_statistical() {
            cell.bound = level;
            cell.value >= level
        } else {
            cell.value <= cell.bound
        };
        cell.verdict = if holds { Verdict::Holds } else { Verdict::Fails };
    }
    Report { cases, statistical, level }
}

/// Runs the laws on one case. The verdicts are open until [`judge`].
pub fn measure(case: &Case, settings: &Settings) -> Vec<Cell> {
    let mut out = Vec::new();
    let closure = case.closure();
    let claims = case.model.claims();
    let seed = seed_of(&case.label(), settings.seed);
    let mut push = |law: Law, angle: Option<f32>, claim: Claim, value: f64, note: String| {
        let verdict = match claim {
            Claim::Holds => Verdict::Holds,
            Claim::Breaks(why) => Verdict::Waived(why),
        };
        out.push(Cell { law, angle, value, bound: law.bound(), verdict, seed, note });
    };
    let n = settings.samples;
    // Radiance that is refracted is no energy, and its furnace no law: that is asked of the adjoint.
    let energy = case.transport == Transport::Importance || closure.refraction().is_none_or(|eta| eta == 1.0);
    for (i, &angle) in case.angles.iter().enumerate() {
        let wo = wo_at(angle);
        let seed = seed.wrapping_add(i as u64);
        let at = Some(angle);
        let expected = Expected::new(&closure, wo, n);
        let c = chi2_against(&expected, &closure, wo, n, seed);
        let note =
            format!("χ² {:.1} of {} degrees of freedom, ∫pdf {:.6}", c.statistic, c.dof, c.pdf_integral);
        push(Law::Chi2, at, Claim::Holds, c.p, note);

        let m = samples_against(expected.pdf_integral, &closure, wo, (n / 10).max(1_000), seed ^ 0x5a);
        let worst = m.weight_error.max(m.pdf_error).max(m.split_error).max(m.length_error);
        let note = format!(
            "weight {:.1e}, pdf {:.1e}, split {:.1e}, length {:.1e}, largest weight {:.3}",
            m.weight_error, m.pdf_error, m.split_error, m.length_error, m.largest_weight
        );
        push(Law::Weights, at, Claim::Holds, if m.broken { f64::INFINITY } else { worst }, note);
        let note = format!("∫pdf {:.6}, {:.6} of the samples", m.pdf_integral, m.continuous);
        push(Law::Density, at, Claim::Holds, m.p, note);

        let f = furnace_against(expected.albedo, &closure, wo, (n / 4).max(1_000), seed ^ 0xa5);
        let note =
            format!("sampled {:.5}, variance {:.4}", f.sampled.max_element(), f.variance.max_element());
        if energy {
            push(Law::Furnace, at, claims.conserves, f.albedo.max_element() as f64, note.clone());
        }
        // Four lanes: the least of four p-values, each counted as if it were alone.
        let p = -(4.0 * (-normal_p(f.z)).ln_1p()).exp_m1();
        push(Law::Sampled, at, Claim::Holds, p, format!("{:.2} standard errors; {note}", f.z));
        let distance = (f.claimed - f.albedo).map(f32::abs).max_element() as f64;
        let finite = f.claimed.is_finite() && f.claimed.0.iter().all(|&v| v >= 0.0);
        let note =
            format!("claimed {:.5}, quadrature {:.5}", f.claimed.max_element(), f.albedo.max_element());
        push(Law::Albedo, at, Claim::Holds, if finite { distance } else { f64::INFINITY }, note);
    }
    let pairs = (n / 10).clamp(2_000, 100_000);
    let r = reciprocity(&closure, pairs, seed);
    push(Law::Reciprocity, None, claims.reciprocal, r.error, format!("at {} and {}", r.pair[0], r.pair[1]));
    if closure.refraction().is_some() && case.front {
        let r = reciprocity_through(&closure, &case.other_side(), case.transport, pairs, seed);
        push(
            Law::ReciprocityThrough,
            None,
            claims.reciprocal,
            r.error,
            format!("at {} and {}", r.pair[0], r.pair[1]),
        );
    }
    if case.variant == "grid" && case.front && case.transport == Transport::Radiance {
        let found = finite(&case.model, (n / 4).max(2_000), seed);
        push(
            Law::Finite,
            None,
            Claim::Holds,
            if found.is_some() { 1.0 } else { 0.0 },
            found.unwrap_or_default(),
        );
    }
    out
}

/// Two-sided p-value of a standard normal variable.
fn normal_p(z: f64) -> f64 {
    upper_regularised(0.5, 0.5 * z * z)
}

/// A seed that depends on the case alone, not on the order of work.
fn seed_of(label: &str, seed: u64) -> u64 {
    // FNV-1a over the label, then mixed.
    let hash = label
        .bytes()
        .fold(0xcbf2_9ce4_8422_2325u64 ^ seed, |h, b| (h ^ b as u64).wrapping_mul(0x0100_0000_01b3));
    Rng::new(hash).bits()
}
