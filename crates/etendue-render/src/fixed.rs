//! Exact sums of floats.

/// A sum of `f32` values as a 128-bit integer in units of 2⁻⁶⁴.
///
/// Integer addition is associative and commutative, so a sum does not depend on the order of its terms: any partition of
/// the samples over threads, processes or machines gives the same bits. A finite float of magnitude 2⁻⁴¹ or more is held
/// exactly; what lies below 2⁻⁶⁴ of a smaller one is cut off. Magnitudes up to 2⁶² are held, larger ones count as 2⁶².
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Fixed(pub i128);

/// log2 of the number of units in 1.
const POINT: i32 = 64;

impl Fixed {
    /// The value of `v`; NaN counts as zero.
    #[inline]
    pub fn from_f32(v: f32) -> Self {
        let bits = v.to_bits();
        let biased = (bits >> 23 & 255) as i32;
        // A subnormal is below the resolution.
        if biased == 0 || v.is_nan() {
            return Self(0);
        }
        let mantissa = i128::from(bits & 0x7f_ffff | 0x80_0000);
        let shift = biased - 150 + POINT;
        let magnitude = if biased > 127 + 61 {
            1i128 << (62 + POINT)
        } else if shift >= 0 {
            mantissa << shift
        } else if shift > -24 {
            mantissa >> -shift
        } else {
            0
        };
        Self(if bits >> 31 == 0 { magnitude } else { -magnitude })
    }

    /// The sum as a float.
    #[inline]
    pub fn to_f64(self) -> f64 {
        self.0 as f64 * (-f64::from(POINT)).exp2()
    }

    /// Adds; saturates at the ends of the range instead of wrapping.
    #[inline]
    pub fn add(&mut self, o: Self) {
        self.0 = self.0.saturating_add(o.0);
    }
}

/// A [`Fixed`] that is being added to by few cheap instructions: what lies in the common range goes to 64 bits.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Running {
    near: i64,
    rest: Fixed,
}

impl Running {
    /// Terms after which [`Running::take`] must be called: 4096 × 512 × 2⁴¹ just fits.
    pub const TERMS: u32 = 4096;

    /// Adds a term exactly as [`Fixed::from_f32`] holds it.
    #[inline(always)]
    pub fn add(&mut self, v: f32) {
        const UNITS: f32 = (1u64 << 41) as f32;
        let a = v.abs();
        // From 2⁻¹⁸ on the last bit of a float is worth 2⁻⁴¹ or more.
        if a < 512.0 && (a >= 1.0 / 262_144.0 || a == 0.0) {
            self.near += (v * UNITS) as i64;
        } else {
            self.rest.add(Fixed::from_f32(v));
        }
    }

    /// The sum; starts anew.
    #[inline]
    pub fn take(&mut self) -> Fixed {
        let mut sum = std::mem::take(&mut self.rest);
        sum.add(Fixed(i128::from(std::mem::take(&mut self.near)) << (POINT - 41)));
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_quick_sum_is_the_same() {
        let (mut quick, mut slow) = (Running::default(), Fixed::default());
        for i in 0..Running::TERMS {
            let v = [511.99f32, 3.81e-6, 3.82e-6, 0.1, -7.3, 1e9, 1e-9, 0.0, f32::NAN][i as usize % 9]
                * (1.0 + i as f32 * 1e-7);
            quick.add(v);
            slow.add(Fixed::from_f32(v));
        }
        assert_eq!(quick.take(), slow);
        assert_eq!(quick.take(), Fixed(0));
        (0..Running::TERMS).for_each(|_| quick.add(511.999_97));
        assert_eq!(quick.take().to_f64(), 4096.0 * f64::from(511.999_97f32));
    }

    #[test]
    fn holds_floats_exactly() {
        for v in [0.0f32, 1.0, -1.0, 0.1, 1e-6, 3.4e12, -7.25, f32::from_bits(0x2b80_0001), 4.6e18] {
            assert_eq!(Fixed::from_f32(v).to_f64(), f64::from(v), "{v}");
        }
        assert_eq!(Fixed::from_f32(f32::NAN), Fixed(0));
        assert_eq!(Fixed::from_f32(1e-30), Fixed(0));
        assert_eq!(Fixed::from_f32(f32::INFINITY).to_f64(), 62f64.exp2());
        assert_eq!(Fixed::from_f32(-1e30).to_f64(), -62f64.exp2());
    }

    #[test]
    fn any_order_gives_the_same_sum() {
        let terms: Vec<f32> =
            (0..1000).map(|i| ((i * 7919 % 1000) as f32 - 499.5) * 1.7f32.powi(i % 40 - 20)).collect();
        let sum = |order: &mut dyn Iterator<Item = &f32>| {
            let mut s = Fixed::default();
            order.for_each(|&t| s.add(Fixed::from_f32(t)));
            s
        };
        assert_eq!(sum(&mut terms.iter()), sum(&mut terms.iter().rev()));
        let floats: f32 = terms.iter().sum();
        let reversed: f32 = terms.iter().rev().sum();
        assert_ne!(floats, reversed, "the terms must be such that floats would differ");
    }
}
