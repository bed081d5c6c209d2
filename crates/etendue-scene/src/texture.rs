//! Textures: an image, how it repeats, and how a material refers to it.

use etendue_image::{Image, Pixels};
use glam::{Affine2, Vec2, Vec4};
use std::sync::LazyLock;

/// What a coordinate outside 0..1 means.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// Tiles (glTF's default).
    #[default]
    Repeat,
    /// Tiles, every other one mirrored.
    Mirror,
    /// The edge texel goes on.
    Clamp,
}

/// How texels are joined when the picture is magnified.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Filter {
    /// Bilinear (the default).
    #[default]
    Linear,
    /// The texel that holds the point.
    Nearest,
}

/// Wrap and filter modes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sampler {
    /// Along u.
    pub wrap_u: Wrap,
    /// Along v.
    pub wrap_v: Wrap,
    /// Magnification. Minification is integrated by the pixel's samples, so no mip modes are kept.
    pub filter: Filter,
}

/// An image and its sampler.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Texture {
    /// Index into [`crate::Scene::images`].
    pub image: u32,
    /// How to look it up.
    pub sampler: Sampler,
}

/// A material's use of a texture: which UV set, transformed how.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureRef {
    /// Index into [`crate::Scene::textures`].
    pub texture: u32,
    /// Index into [`crate::Mesh::uvs`]; a mesh without that set is looked up at (0, 0).
    pub uv_set: u32,
    /// `KHR_texture_transform` as a matrix: applied to the mesh's coordinate before lookup.
    pub transform: Affine2,
}

impl TextureRef {
    /// Texture `texture` by UV set 0, untransformed.
    pub fn new(texture: u32) -> Self {
        Self { texture, uv_set: 0, transform: Affine2::IDENTITY }
    }
}

/// IEC 61966-2-1 decoding of the 256 eight-bit code values.
static SRGB8: LazyLock<[f32; 256]> = LazyLock::new(|| {
    std::array::from_fn(|i| {
        let c = i as f64 / 255.0;
        (if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }) as f32
    })
});

fn srgb_decode(c: f32) -> f32 {
    if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}

impl Wrap {
    /// Texel `i` of a row of `n ≥ 1`.
    #[inline]
    fn apply(self, i: i32, n: i32) -> u32 {
        (match self {
            Wrap::Repeat => {
                if (0..n).contains(&i) {
                    i
                } else {
                    i.rem_euclid(n)
                }
            }
            Wrap::Clamp => i.clamp(0, n - 1),
            Wrap::Mirror => {
                let m = i.rem_euclid(2 * n);
                if m < n { m } else { 2 * n - 1 - m }
            }
        }) as u32
    }
}

impl Texture {
    /// RGBA at `uv`, colour channels decoded from sRGB to linear. Grey images give equal channels; no alpha is 1.
    #[inline]
    pub fn sample_srgb(&self, image: &Image, uv: Vec2) -> Vec4 {
        self.filtered(image, uv, |x, y| texel::<true>(image, x, y))
    }

    /// RGBA at `uv` as stored (data: normals, roughness …).
    #[inline]
    pub fn sample_linear(&self, image: &Image, uv: Vec2) -> Vec4 {
        self.filtered(image, uv, |x, y| texel::<false>(image, x, y))
    }

    #[inline(always)]
    fn filtered(&self, image: &Image, uv: Vec2, texel: impl Fn(u32, u32) -> Vec4) -> Vec4 {
        let (w, h) = (image.width as i32, image.height as i32);
        let s = &self.sampler;
        let p = reduce(uv) * Vec2::new(w as f32, h as f32);
        if s.filter == Filter::Nearest {
            let f = p.floor();
            return texel(s.wrap_u.apply(f.x as i32, w), s.wrap_v.apply(f.y as i32, h));
        }
        let p = p - 0.5;
        let f = p.floor();
        let t = p - f;
        let (x, y) = (f.x as i32, f.y as i32);
        let (x0, x1) = (s.wrap_u.apply(x, w), s.wrap_u.apply(x + 1, w));
        let (y0, y1) = (s.wrap_v.apply(y, h), s.wrap_v.apply(y + 1, h));
        let top = texel(x0, y0) * (1.0 - t.x) + texel(x1, y0) * t.x;
        let bottom = texel(x0, y1) * (1.0 - t.x) + texel(x1, y1) * t.x;
        top * (1.0 - t.y) + bottom * t.y
    }
}

/// Brings far coordinates into a range where a float still tells texels apart and an `i32` holds them. All wrap modes
/// have period 2 or saturate outside it.
#[inline]
fn reduce(uv: Vec2) -> Vec2 {
    if uv.abs().max_element() < 1024.0 {
        uv
    } else if uv.is_finite() {
        uv.rem_euclid(Vec2::splat(2.0))
    } else {
        Vec2::ZERO
    }
}

#[inline(always)]
fn texel<const SRGB: bool>(image: &Image, x: u32, y: u32) -> Vec4 {
    let i = y as usize * image.width as usize + x as usize;
    match (&image.pixels, image.channels) {
        (Pixels::U8(p), 4) => {
            let c = &p[i * 4..i * 4 + 4];
            rgba8::<SRGB>([c[0], c[1], c[2], c[3]])
        }
        (Pixels::U8(p), 3) => {
            let c = &p[i * 3..i * 3 + 3];
            rgba8::<SRGB>([c[0], c[1], c[2], 255])
        }
        _ => texel_slow::<SRGB>(image, x, y),
    }
}

#[inline(always)]
fn rgba8<const SRGB: bool>(c: [u8; 4]) -> Vec4 {
    const N: f32 = 1.0 / 255.0;
    if SRGB {
        let t = &*SRGB8;
        Vec4::new(t[c[0] as usize], t[c[1] as usize], t[c[2] as usize], c[3] as f32 * N)
    } else {
        Vec4::new(c[0] as f32, c[1] as f32, c[2] as f32, c[3] as f32) * N
    }
}

#[inline(never)]
fn texel_slow<const SRGB: bool>(image: &Image, x: u32, y: u32) -> Vec4 {
    let s = |c| image.sample(x, y, c);
    let v = match image.channels {
        1 => Vec4::new(s(0), s(0), s(0), 1.0),
        2 => Vec4::new(s(0), s(0), s(0), s(1)),
        3 => Vec4::new(s(0), s(1), s(2), 1.0),
        _ => Vec4::new(s(0), s(1), s(2), s(3)),
    };
    if SRGB { Vec4::new(srgb_decode(v.x), srgb_decode(v.y), srgb_decode(v.z), v.w) } else { v }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp() -> Image {
        Image { width: 2, height: 1, channels: 1, pixels: Pixels::U8(vec![0, 255]) }
    }

    #[test]
    fn wraps_like_gl() {
        let at = |wrap, u: f32| {
            let t = Texture {
                image: 0,
                sampler: Sampler { wrap_u: wrap, wrap_v: wrap, filter: Filter::Nearest },
            };
            t.sample_linear(&ramp(), Vec2::new(u, 0.5)).x
        };
        assert_eq!([at(Wrap::Repeat, 0.25), at(Wrap::Repeat, 0.75), at(Wrap::Repeat, 1.25)], [0.0, 1.0, 0.0]);
        assert_eq!(
            [at(Wrap::Repeat, -0.25), at(Wrap::Clamp, -0.25), at(Wrap::Mirror, -0.25)],
            [1.0, 0.0, 0.0]
        );
        assert_eq!([at(Wrap::Mirror, 1.25), at(Wrap::Clamp, 7.0), at(Wrap::Mirror, -1.25)], [1.0, 1.0, 1.0]);
    }

    #[test]
    fn filters_between_texel_centres() {
        let t = Texture { image: 0, sampler: Sampler { wrap_u: Wrap::Clamp, ..Sampler::default() } };
        let at = |u: f32| t.sample_linear(&ramp(), Vec2::new(u, 0.5)).x;
        assert_eq!([at(0.25), at(0.5), at(0.75), at(0.0)], [0.0, 0.5, 1.0, 0.0]);
    }

    #[test]
    fn hostile_coordinates_stay_inside() {
        for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
            let t =
                Texture { image: 0, sampler: Sampler { wrap_u: wrap, wrap_v: wrap, ..Sampler::default() } };
            for u in [f32::NAN, f32::INFINITY, -1e30, 1e30, 1e9, -4096.5] {
                assert!(t.sample_srgb(&ramp(), Vec2::new(u, u)).is_finite());
            }
        }
    }
}
