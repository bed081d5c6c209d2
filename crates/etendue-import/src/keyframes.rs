//! Values between keyframes (glTF 2.0, appendix C).

use crate::accessor::Elements;
use crate::document::Interpolation;
use crate::error::Fault;
use crate::nodes::rotation;
use glam::DQuat;

/// Keyframe times and the moment that is looked for in them.
pub(crate) struct Track<'a> {
    pub input: &'a Elements<'a>,
    pub seconds: f64,
    pub interpolation: Interpolation,
}

/// Between which keyframes a moment lies.
struct Span {
    /// The keyframe before.
    k: usize,
    /// How far on the way to the next one, 0..1; 0 at the ends of the animation.
    t: f64,
    /// Seconds between the two.
    length: f64,
}

impl Track<'_> {
    /// Checks that there are as many values as keyframes need.
    pub fn check(&self, values: usize, per_key: usize, pointer: impl Fn() -> String) -> Result<(), Fault> {
        let per_key = if self.interpolation == Interpolation::CubicSpline { 3 * per_key } else { per_key };
        let needed = self.input.len().saturating_mul(per_key);
        if values < needed {
            let keys = self.input.len();
            return Err(Fault::invalid(
                format!("{}/sampler", pointer()),
                format!("{values} values for {keys} keyframes that need {needed}"),
            ));
        }
        Ok(())
    }

    fn time(&self, k: usize) -> f64 {
        let [t] = self.input.floats::<1>(Some(&[k as u32]))[0];
        t.into()
    }

    /// Finds the keyframes around the moment by bisection; outside their range the nearest one holds.
    fn span(&self) -> Span {
        let last = self.input.len() - 1;
        let hold = |k| Span { k, t: 0.0, length: 0.0 };
        let first = self.time(0);
        // A time that is not a number holds the first keyframe.
        if last == 0 || self.seconds.is_nan() || first.is_nan() || self.seconds <= first {
            return hold(0);
        }
        if self.seconds >= self.time(last) {
            return hold(last);
        }
        let (mut lo, mut hi) = (0, last);
        while hi - lo > 1 {
            let mid = lo + (hi - lo) / 2;
            if self.time(mid) <= self.seconds { lo = mid } else { hi = mid }
        }
        let (a, b) = (self.time(lo), self.time(hi));
        let length = b - a;
        let t = (self.seconds - a) / length;
        if length > 0.0 && (0.0..=1.0).contains(&t) { Span { k: lo, t, length } } else { hold(lo) }
    }

    /// The value at the moment; `value(k)` is output element `k`. In a cubic spline each keyframe has three: in-tangent,
    /// value, out-tangent (glTF 2.0, appendix C.5).
    pub fn sample<const N: usize>(&self, value: impl Fn(usize) -> [f32; N]) -> [f64; N] {
        let s = self.span();
        let wide = |v: [f32; N]| v.map(f64::from);
        match self.interpolation {
            Interpolation::Step => wide(value(s.k)),
            Interpolation::Linear if s.t == 0.0 => wide(value(s.k)),
            Interpolation::Linear => {
                let (a, b) = (wide(value(s.k)), wide(value(s.k + 1)));
                std::array::from_fn(|i| a[i] + (b[i] - a[i]) * s.t)
            }
            Interpolation::CubicSpline => self.cubic(&s, value),
        }
    }

    fn cubic<const N: usize>(&self, s: &Span, value: impl Fn(usize) -> [f32; N]) -> [f64; N] {
        let wide = |v: [f32; N]| v.map(f64::from);
        let v0 = wide(value(3 * s.k + 1));
        if s.t == 0.0 {
            return v0;
        }
        let out0 = wide(value(3 * s.k + 2));
        let (in1, v1) = (wide(value(3 * (s.k + 1))), wide(value(3 * (s.k + 1) + 1)));
        let (t, t2, t3) = (s.t, s.t * s.t, s.t * s.t * s.t);
        std::array::from_fn(|i| {
            (2.0 * t3 - 3.0 * t2 + 1.0) * v0[i]
                + s.length * (t3 - 2.0 * t2 + t) * out0[i]
                + (-2.0 * t3 + 3.0 * t2) * v1[i]
                + s.length * (t3 - t2) * in1[i]
        })
    }

    /// [`Track::sample`] for unit quaternions: linear means along the shorter great arc (appendix C.4), and a spline is
    /// normalised afterwards (C.5).
    pub fn rotation(&self, value: impl Fn(usize) -> [f32; 4]) -> DQuat {
        let s = self.span();
        let unit = |v: [f64; 4]| {
            if v.iter().all(|c| c.is_finite()) {
                rotation(v, || {})
            } else {
                DQuat::from_array([f64::NAN; 4])
            }
        };
        if self.interpolation == Interpolation::Linear && s.t > 0.0 {
            let (a, b) = (unit(value(s.k).map(f64::from)), unit(value(s.k + 1).map(f64::from)));
            return if a.is_nan() || b.is_nan() { DQuat::from_array([f64::NAN; 4]) } else { a.slerp(b, s.t) };
        }
        unit(self.sample(value))
    }
}
