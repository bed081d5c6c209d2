//! One 256-bit register. Only to be used inside functions that enable AVX2 and FMA (see `accel`).

use super::{F32x8, Lanes};
use std::arch::x86_64::*;

/// Eight lanes in one AVX register.
#[derive(Clone, Copy)]
pub(crate) struct Avx2(__m256);

macro_rules! op {
    ($($name:ident = $f:expr;)*) => {$(
        #[inline(always)]
        fn $name(self, o: Self) -> Self {
            // SAFETY: the only callers are kernels entered after AVX2 was detected.
            Self(unsafe { $f(self.0, o.0) })
        }
    )*};
}

impl Lanes for Avx2 {
    #[inline(always)]
    fn splat(x: f32) -> Self {
        // SAFETY: the only callers are kernels entered after AVX2 was detected.
        Self(unsafe { _mm256_set1_ps(x) })
    }
    #[inline(always)]
    fn load(x: &F32x8) -> Self {
        // SAFETY: AVX2 was detected; the type is 32 bytes long and aligned to 32.
        Self(unsafe { _mm256_load_ps(x.0.as_ptr()) })
    }
    #[inline(always)]
    fn store(self) -> F32x8 {
        let mut x = F32x8([0.0; 8]);
        // SAFETY: AVX2 was detected; the type is 32 bytes long and aligned to 32.
        unsafe { _mm256_store_ps(x.0.as_mut_ptr(), self.0) };
        x
    }
    op! {
        add = _mm256_add_ps;
        sub = _mm256_sub_ps;
        mul = _mm256_mul_ps;
        div = _mm256_div_ps;
        min = _mm256_min_ps;
        max = _mm256_max_ps;
        lt = _mm256_cmp_ps::<_CMP_LT_OQ>;
        le = _mm256_cmp_ps::<_CMP_LE_OQ>;
        and = _mm256_and_ps;
        or = _mm256_or_ps;
    }
    #[inline(always)]
    fn loose_mul_sub(self, factor: Self, o: Self) -> Self {
        // SAFETY: the only callers are kernels entered after AVX2 and FMA were detected.
        Self(unsafe { _mm256_fmsub_ps(self.0, factor.0, o.0) })
    }
    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: the only callers are kernels entered after AVX2 was detected.
        Self(unsafe { _mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0) })
    }
    #[inline(always)]
    fn signs(self) -> u32 {
        // SAFETY: the only callers are kernels entered after AVX2 was detected.
        unsafe { _mm256_movemask_ps(self.0) as u32 }
    }
    #[inline(always)]
    fn prefetch<T>(value: &T) {
        super::prefetch(value);
    }
}
