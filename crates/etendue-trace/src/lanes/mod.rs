//! Eight `f32` at a time, in the instruction set at hand.
//!
//! Every operation but one is one IEEE 754 rounding (no fused multiply-add, no approximate reciprocal), and
//! `min`/`max` mean the same for NaN everywhere, so that a kernel gives the same bits with each implementation. The
//! exception, [`Lanes::loose_mul_sub`], is for box tests, which are conservative by more than it can differ.

mod array;
#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod sse2;

pub(crate) use array::Array;
#[cfg(target_arch = "x86_64")]
pub(crate) use avx2::Avx2;
#[cfg(target_arch = "x86_64")]
pub(crate) use sse2::Sse2;

/// Eight values, aligned for every implementation.
#[repr(C, align(32))]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct F32x8(pub [f32; 8]);

/// Eight lanes. A mask is a value whose lanes have all bits set or none.
pub(crate) trait Lanes: Copy {
    fn splat(x: f32) -> Self;
    fn load(x: &F32x8) -> Self;
    fn store(self) -> F32x8;
    fn add(self, o: Self) -> Self;
    fn sub(self, o: Self) -> Self;
    fn mul(self, o: Self) -> Self;
    fn div(self, o: Self) -> Self;
    /// `self · factor − o`, with one rounding or two.
    fn loose_mul_sub(self, factor: Self, o: Self) -> Self;
    /// `self` where it is less, else `o`: `o` if either is NaN.
    fn min(self, o: Self) -> Self;
    /// `self` where it is greater, else `o`: `o` if either is NaN.
    fn max(self, o: Self) -> Self;
    fn abs(self) -> Self;
    fn lt(self, o: Self) -> Self;
    fn le(self, o: Self) -> Self;
    fn and(self, o: Self) -> Self;
    fn or(self, o: Self) -> Self;
    /// One bit per lane: its sign.
    fn signs(self) -> u32;
    /// Asks for the cache lines of a value that will be read soon.
    #[inline(always)]
    fn prefetch<T>(_value: &T) {}
}

/// Asks for each cache line of a value.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
#[allow(unused_unsafe, reason = "the intrinsic may become safe in later compilers")]
fn prefetch<T>(value: &T) {
    use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
    let start = (&raw const *value).cast::<i8>();
    let mut at = 0;
    while at < size_of::<T>() {
        // SAFETY: SSE is part of x86-64; the address lies within the value.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(start.add(at)) };
        at += 64;
    }
}
