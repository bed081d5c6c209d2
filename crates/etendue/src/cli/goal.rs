//! When a run is finished.

use super::args::RenderArgs;
use crate::render::Film;
use std::time::Duration;

/// Samples per pixel if nothing else says when to stop.
const DEFAULT_SAMPLES: u32 = 64;
/// Samples per pixel at which a run ends that waits for an error or a time.
const MOST_SAMPLES: u32 = 1 << 20;
/// Samples that an error estimate needs before it may end a run.
const LEAST_FOR_NOISE: u64 = 16;

/// When to stop.
#[derive(Debug)]
pub(crate) struct Goal {
    /// First sample of the range that is wanted.
    pub from: u32,
    /// The one after its last.
    pub to: u32,
    /// Relative error that is small enough.
    pub noise: Option<f64>,
    /// Time that may be spent on samples.
    pub time: Option<Duration>,
    /// Samples per pixel that this run takes at most.
    pub missing: u64,
    /// `to` is only a bound; error or time end the run.
    pub open: bool,
}

impl Goal {
    /// What the arguments ask for beyond what the film holds.
    pub fn new(args: &RenderArgs, film: &Film) -> Self {
        let open =
            args.spp.is_none() && args.samples.is_none() && (args.noise.is_some() || args.time.is_some());
        let all = args.spp.unwrap_or(if open { MOST_SAMPLES } else { DEFAULT_SAMPLES });
        let (from, to) = args.samples.unwrap_or((0, all));
        let missing = film.ranges.missing(from, to).iter().map(|r| u64::from(r.1 - r.0)).sum();
        Self { from, to, noise: args.noise.map(f64::from), time: args.time, missing, open }
    }

    /// The next number of samples per pixel at which the error is judged, for a film with `have`.
    ///
    /// A fixed sequence, so that the same picture stops at the same sample however fast the machine is and wherever the
    /// run was interrupted: 16, then steps of an eighth.
    pub fn next_check(have: u64) -> u64 {
        let mut at = LEAST_FOR_NOISE;
        while at <= have {
            at += (at / 8).max(4);
        }
        at
    }

    /// True if the error is judged at `have` samples and small enough.
    pub fn is_quiet(&self, have: u64, error: impl FnOnce() -> f64) -> bool {
        let judged = have > 0 && Self::next_check(have - 1) == have;
        self.noise.is_some_and(|e| judged && error() < e)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_is_judged_at_fixed_samples() {
        let mut at = 0;
        let mut checks = Vec::new();
        while at < 100 {
            at = Goal::next_check(at);
            checks.push(at);
        }
        assert_eq!(checks, [16, 20, 24, 28, 32, 36, 40, 45, 50, 56, 63, 70, 78, 87, 97, 109]);
        // Wherever one begins.
        assert!((0..97).all(|have| checks.contains(&Goal::next_check(have))));
        let goal = Goal { from: 0, to: 9, noise: Some(0.1), time: None, missing: 9, open: true };
        assert!(goal.is_quiet(16, || 0.05) && !goal.is_quiet(16, || 0.2));
        assert!(!goal.is_quiet(17, || 0.05) && !goal.is_quiet(0, || 0.0) && !goal.is_quiet(12, || 0.0));
    }
}
