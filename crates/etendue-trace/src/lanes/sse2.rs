//! Two 128-bit registers: what every x86-64 machine has.

use super::{F32x8, Lanes};
use std::arch::x86_64::*;

/// Eight lanes in two SSE registers.
#[derive(Clone, Copy)]
pub(crate) struct Sse2(__m128, __m128);

macro_rules! op {
    ($($name:ident = $f:ident;)*) => {$(
        #[inline(always)]
        fn $name(self, o: Self) -> Self {
            // SAFETY: SSE2 is part of x86-64.
            unsafe { Self($f(self.0, o.0), $f(self.1, o.1)) }
        }
    )*};
}

#[allow(unused_unsafe, reason = "register-only intrinsics became safe in later compilers")]
impl Lanes for Sse2 {
    #[inline(always)]
    fn splat(x: f32) -> Self {
        // SAFETY: SSE2 is part of x86-64.
        unsafe { Self(_mm_set1_ps(x), _mm_set1_ps(x)) }
    }
    #[inline(always)]
    fn load(x: &F32x8) -> Self {
        // SAFETY: both halves lie within the 32 bytes and are aligned to 16.
        unsafe { Self(_mm_load_ps(x.0.as_ptr()), _mm_load_ps(x.0.as_ptr().add(4))) }
    }
    #[inline(always)]
    fn store(self) -> F32x8 {
        let mut x = F32x8([0.0; 8]);
        // SAFETY: both halves lie within the 32 bytes and are aligned to 16.
        unsafe {
            _mm_store_ps(x.0.as_mut_ptr(), self.0);
            _mm_store_ps(x.0.as_mut_ptr().add(4), self.1);
        }
        x
    }
    op! {
        add = _mm_add_ps;
        sub = _mm_sub_ps;
        mul = _mm_mul_ps;
        div = _mm_div_ps;
        min = _mm_min_ps;
        max = _mm_max_ps;
        lt = _mm_cmplt_ps;
        le = _mm_cmple_ps;
        and = _mm_and_ps;
        or = _mm_or_ps;
    }
    #[inline(always)]
    fn loose_mul_sub(self, factor: Self, o: Self) -> Self {
        self.mul(factor).sub(o)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: SSE2 is part of x86-64.
        unsafe {
            let sign = _mm_set1_ps(-0.0);
            Self(_mm_andnot_ps(sign, self.0), _mm_andnot_ps(sign, self.1))
        }
    }
    #[inline(always)]
    fn signs(self) -> u32 {
        // SAFETY: SSE2 is part of x86-64.
        unsafe { (_mm_movemask_ps(self.0) | _mm_movemask_ps(self.1) << 4) as u32 }
    }
    #[inline(always)]
    fn prefetch<T>(value: &T) {
        super::prefetch(value);
    }
}
