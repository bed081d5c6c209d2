//! Four lanes of light.

use core::ops::{Add, AddAssign, Div, DivAssign, Index, IndexMut, Mul, MulAssign, Neg, Sub, SubAssign};

/// Light, reflectance or any other spectral quantity as four SIMD-friendly lanes.
///
/// In RGB mode the lanes are linear Rec.709 red, green, blue and a spare that stays zero in quantities of light;
/// in spectral mode they are four sampled wavelengths. Scattering code treats all lanes alike and never asks which;
/// only the edges (reading a texture or a light, writing the film) know.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(16))]
pub struct Spectrum(pub [f32; 4]);

impl Spectrum {
    /// No light.
    pub const ZERO: Self = Self([0.0; 4]);
    /// One in each lane.
    pub const ONE: Self = Self([1.0; 4]);

    /// The same value in each lane.
    #[inline(always)]
    pub const fn splat(v: f32) -> Self {
        Self([v; 4])
    }

    /// Linear Rec.709 red, green, blue; the spare lane is zero.
    #[inline(always)]
    pub const fn rgb(r: f32, g: f32, b: f32) -> Self {
        Self([r, g, b, 0.0])
    }

    /// Linear Rec.709 from an array; the spare lane is zero.
    #[inline(always)]
    pub const fn from_rgb(c: [f32; 3]) -> Self {
        Self([c[0], c[1], c[2], 0.0])
    }

    /// The first three lanes: linear Rec.709 in RGB mode.
    #[inline(always)]
    pub const fn to_rgb(self) -> [f32; 3] {
        [self.0[0], self.0[1], self.0[2]]
    }

    /// Relative luminance of a linear Rec.709 value (ITU-R BT.709-6, item 3.2).
    #[inline(always)]
    pub fn luminance(self) -> f32 {
        0.2126 * self.0[0] + 0.7152 * self.0[1] + 0.0722 * self.0[2]
    }

    /// The largest lane.
    #[inline(always)]
    pub fn max_element(self) -> f32 {
        let [a, b, c, d] = self.0;
        a.max(b).max(c.max(d))
    }

    /// True if every lane is zero.
    #[inline(always)]
    pub fn is_black(self) -> bool {
        self.0 == [0.0; 4]
    }

    /// True if no lane is NaN or infinite.
    #[inline(always)]
    pub fn is_finite(self) -> bool {
        self.0.iter().all(|v| v.is_finite())
    }

    /// Applies `f` to each lane.
    #[inline(always)]
    pub fn map(self, f: impl Fn(f32) -> f32) -> Self {
        Self(self.0.map(f))
    }

    /// Lane-wise minimum.
    #[inline(always)]
    pub fn min(self, o: Self) -> Self {
        Self(core::array::from_fn(|i| self.0[i].min(o.0[i])))
    }

    /// Lane-wise maximum.
    #[inline(always)]
    pub fn max(self, o: Self) -> Self {
        Self(core::array::from_fn(|i| self.0[i].max(o.0[i])))
    }

    /// Lane-wise `self · (1 − t) + o · t`.
    #[inline(always)]
    pub fn lerp(self, o: Self, t: f32) -> Self {
        self * (1.0 - t) + o * t
    }

    /// Lane-wise square root.
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        self.map(f32::sqrt)
    }
}

macro_rules! lanewise {
    ($op:ident, $f:ident, $assign:ident, $g:ident, $sym:tt) => {
        impl $op for Spectrum {
            type Output = Self;
            #[inline(always)]
            fn $f(self, o: Self) -> Self {
                let (a, b) = (self.0, o.0);
                Self([a[0] $sym b[0], a[1] $sym b[1], a[2] $sym b[2], a[3] $sym b[3]])
            }
        }
        impl $assign for Spectrum {
            #[inline(always)]
            fn $g(&mut self, o: Self) {
                *self = *self $sym o;
            }
        }
    };
}
lanewise!(Add, add, AddAssign, add_assign, +);
lanewise!(Sub, sub, SubAssign, sub_assign, -);
lanewise!(Mul, mul, MulAssign, mul_assign, *);
lanewise!(Div, div, DivAssign, div_assign, /);

impl Mul<f32> for Spectrum {
    type Output = Self;
    #[inline(always)]
    fn mul(self, s: f32) -> Self {
        self * Self::splat(s)
    }
}
impl Mul<Spectrum> for f32 {
    type Output = Spectrum;
    #[inline(always)]
    fn mul(self, s: Spectrum) -> Spectrum {
        s * self
    }
}
impl MulAssign<f32> for Spectrum {
    #[inline(always)]
    fn mul_assign(&mut self, s: f32) {
        *self = *self * s;
    }
}
impl Div<f32> for Spectrum {
    type Output = Self;
    #[inline(always)]
    fn div(self, s: f32) -> Self {
        self * (1.0 / s)
    }
}
impl Neg for Spectrum {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self * -1.0
    }
}
impl Index<usize> for Spectrum {
    type Output = f32;
    fn index(&self, i: usize) -> &f32 {
        &self.0[i]
    }
}
impl IndexMut<usize> for Spectrum {
    fn index_mut(&mut self, i: usize) -> &mut f32 {
        &mut self.0[i]
    }
}
