//! Code of other crates, compiled for the processor's wide instructions.
//!
//! A program for any x86-64 machine is compiled for the oldest one: no three-operand instructions, no fused multiply-add, no
//! rounding. [`run_wide`] holds a second compilation of what is inlined into it, for processors that have AVX2, and chooses when
//! it runs. The numbers do not change: nothing is contracted or reordered, only encoded better.

/// True if the processor has AVX2 and what came with it: fused multiply-add and bit manipulation.
#[cfg(target_arch = "x86_64")]
#[inline]
pub(crate) fn has_avx2() -> bool {
    is_x86_feature_detected!("avx2")
        && is_x86_feature_detected!("fma")
        && is_x86_feature_detected!("bmi1")
        && is_x86_feature_detected!("bmi2")
        && is_x86_feature_detected!("lzcnt")
        && is_x86_feature_detected!("popcnt")
}

/// Something to do, whose hot parts are `#[inline(always)]`.
pub trait Work {
    /// What comes out.
    type Output;
    /// Does it. Mark the implementation `#[inline(always)]`, and what it calls.
    fn run(self) -> Self::Output;
}

/// Does `work`, compiled for AVX2 where the processor has it.
#[inline]
pub fn run_wide<W: Work>(work: W) -> W::Output {
    #[cfg(target_arch = "x86_64")]
    {
        /// The second compilation.
        ///
        /// # Safety
        /// The processor has the features.
        #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
        unsafe fn avx2<W: Work>(work: W) -> W::Output {
            work.run()
        }
        if has_avx2() {
            // SAFETY: `has_avx2` asks for each of the features.
            return unsafe { avx2(work) };
        }
    }
    work.run()
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Sum<'a>(&'a [f32]);
    impl Work for Sum<'_> {
        type Output = f32;
        #[inline(always)]
        fn run(self) -> f32 {
            self.0.iter().fold(0.0, |a, x| a * 1.000_1 + x.floor())
        }
    }

    /// Both compilations give the same bits: no multiplication and addition is fused behind one's back.
    #[test]
    fn the_same_bits() {
        let values: Vec<f32> = (0..10_000).map(|i| i as f32 * 0.3713 - 900.0).collect();
        assert_eq!(run_wide(Sum(&values)).to_bits(), Sum(&values).run().to_bits());
    }
}
