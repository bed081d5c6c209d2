//! Integrals over intervals by Gauss-Kronrod pairs, halved where the two rules of a pair disagree.
//!
//! The pair is Kronrod's extension of three Gauss nodes to seven (Kronrod 1965, "Nodes and Weights of Quadrature
//! Formulas"): exact for polynomials of degree 11, with Gauss's rule of degree 5 in its nodes to tell the error.
//! Halving reaches a step in the integrand at one bit per level, so steps need not be known beforehand.

/// Positive nodes on −1..1, their Kronrod weights and, for those that Gauss's rule has, its weights; the last is the middle.
const PAIR: [(f64, f64, f64); 4] = [
    (0.960_491_268_708_020_283_42, 0.104_656_226_026_467_265_19, 0.0),
    (0.774_596_669_241_483_377_04, 0.268_488_089_868_333_440_73, 5.0 / 9.0),
    (0.434_243_749_346_802_558_00, 0.401_397_414_775_962_222_91, 0.0),
    (0.0, 0.450_916_538_658_474_142_35, 8.0 / 9.0),
];

/// The seven nodes of an interval `from..to` with both rules' weights.
pub(super) fn nodes(from: f64, to: f64) -> [(f64, f64, f64); 7] {
    let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
    core::array::from_fn(|i| {
        let (x, k, g) = PAIR[if i < 4 { i } else { 6 - i }];
        (middle + if i < 4 { -half * x } else { half * x }, half * k, half * g)
    })
}

/// An estimate of the error of the Kronrod value from the difference of the two rules and from ∫ |f − mean|.
///
/// At a step both rules err alike, and the difference is the error. Where the integrand is smooth the longer rule is the
/// better the smaller the difference is beside the integrand's variation: twice as many digits, to be careful by a factor.
pub(super) fn error(difference: f64, variation: f64) -> f64 {
    let d = difference.abs();
    if variation > 0.0 { d.min(100.0 * d * d / variation) } else { d }
}

/// What may be wrong with an integral over one interval.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tolerance {
    /// In the integral's own unit.
    pub absolute: f64,
    /// As a part of the integral.
    pub relative: f64,
}

/// Levels of halving at most.
const DEPTH: u32 = 26;
/// Levels that may bring nothing, as rounding errors of the integrand do, before halving ends.
const STALLS: u32 = 3;

/// True if two halves are no better than the whole, and both of them are bad: the mark of noise. A step leaves one half
/// without an error.
pub(super) fn stalls(whole: f64, halves: [f64; 2]) -> bool {
    let [a, b] = halves;
    a.min(b) > 0.1 * a.max(b) && a + b > 0.5 * whole
}

/// One interval by the pair: the integral of each lane, and whether it is good enough and by what factor not.
struct Panel<const N: usize> {
    value: [f64; N],
    error: f64,
}

fn panel<const N: usize>(
    f: &mut impl FnMut(f64) -> [f64; N],
    from: f64,
    to: f64,
    tolerance: Tolerance,
) -> Panel<N> {
    let nodes = nodes(from, to);
    let values = nodes.map(|(x, _, _)| f(x));
    let mut out = Panel { value: [0.0; N], error: 0.0 };
    for lane in 0..N {
        let (mut kronrod, mut gauss) = (0.0, 0.0);
        for ((_, k, g), v) in nodes.iter().zip(&values) {
            kronrod += k * v[lane];
            gauss += g * v[lane];
        }
        let mean = kronrod / (to - from);
        let variation: f64 = nodes.iter().zip(&values).map(|((_, k, _), v)| k * (v[lane] - mean).abs()).sum();
        let allowed = tolerance.absolute.max(tolerance.relative * kronrod.abs());
        out.value[lane] = kronrod;
        out.error = out.error.max(error(kronrod - gauss, variation) / allowed);
    }
    out
}

/// ∫ f over `from..to`, each lane within `tolerance` on every interval that is not halved further.
pub(super) fn integrate<const N: usize>(
    f: &mut impl FnMut(f64) -> [f64; N],
    from: f64,
    to: f64,
    tolerance: Tolerance,
) -> [f64; N] {
    let whole = panel(f, from, to, tolerance);
    let mut sum = [0.0; N];
    refine(f, from, to, whole, tolerance, DEPTH, STALLS, &mut sum);
    sum
}

fn refine<const N: usize>(
    f: &mut impl FnMut(f64) -> [f64; N],
    from: f64,
    to: f64,
    whole: Panel<N>,
    tolerance: Tolerance,
    depth: u32,
    patience: u32,
    sum: &mut [f64; N],
) {
    // Not a number is no error that halving mends.
    if !(whole.error > 1.0) || depth == 0 || patience == 0 {
        for (s, v) in sum.iter_mut().zip(whole.value) {
            *s += v;
        }
        return;
    }
    let middle = 0.5 * (from + to);
    let left = panel(f, from, middle, tolerance);
    let right = panel(f, middle, to, tolerance);
    let patience = if stalls(whole.error, [left.error, right.error]) { patience - 1 } else { STALLS };
    refine(f, from, middle, left, tolerance, depth - 1, patience, sum);
    refine(f, middle, to, right, tolerance, depth - 1, patience, sum);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_rules_are_exact_for_their_degree() {
        for degree in 0..12 {
            let (mut kronrod, mut gauss) = (0.0, 0.0);
            for (x, k, g) in nodes(0.0, 1.0) {
                kronrod += k * x.powi(degree);
                gauss += g * x.powi(degree);
            }
            let exact = 1.0 / (degree as f64 + 1.0);
            assert!((kronrod - exact).abs() < 1e-15, "degree {degree}: {kronrod}");
            assert_eq!((gauss - exact).abs() < 1e-15, degree < 6, "degree {degree}: {gauss}");
        }
    }

    #[test]
    fn steps_spikes_and_roots_are_found() {
        let tolerance = Tolerance { absolute: 1e-9, relative: 0.0 };
        let by = |f: &dyn Fn(f64) -> f64| {
            let mut calls = 0;
            let mut lanes = |x: f64| {
                calls += 1;
                [f(x), 1.0]
            };
            let [v, one] = integrate(&mut lanes, 0.0, 1.0, tolerance);
            assert!((one - 1.0).abs() < 1e-12);
            (v, calls)
        };
        let (step, calls) = by(&|x| if x < 0.618_033_988 { 1.0 } else { 0.0 });
        assert!((step - 0.618_033_988).abs() < 1e-7 && calls < 500, "{step} in {calls}");
        let (root, calls) = by(&|x| (x - 0.3).max(0.0).sqrt());
        assert!((root - 2.0 / 3.0 * 0.7f64.powf(1.5)).abs() < 1e-7 && calls < 500, "{root} in {calls}");
        // A Cauchy distribution as wide as a ten-thousandth.
        let width = 1e-4;
        let (spike, calls) = by(&|x| width / (width * width + (x - 0.4f64).powi(2)) / core::f64::consts::PI);
        let exact = ((0.6f64 / width).atan() + (0.4f64 / width).atan()) / core::f64::consts::PI;
        assert!((spike - exact).abs() < 1e-7 && calls < 1500, "{spike} for {exact} in {calls}");
    }

    #[test]
    fn noise_does_not_take_for_ever() {
        let mut rng = crate::laws::Rng::new(1);
        let mut calls = 0;
        let mut noisy = |x: f64| {
            calls += 1;
            [x * (1.0 + 0.01 * (rng.uniform() as f64 - 0.5))]
        };
        let tolerance = Tolerance { absolute: 1e-12, relative: 1e-9 };
        let [v] = integrate(&mut noisy, 0.0, 1.0, tolerance);
        assert!((v - 0.5).abs() < 1e-3 && calls < 20_000, "{v} in {calls}");
    }
}
