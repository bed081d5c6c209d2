//! Textures: an image, how it repeats, and how a material refers to it.

use etendue_color::srgb_decode;
use etendue_image::Image;
use glam::{Affine2, Vec2, Vec4};

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

impl Wrap {
    /// Brings a far coordinate to where a float still tells texels apart and an `i32` holds them; not a number is 0.
    #[inline(always)]
    fn reduce(self, u: f32) -> f32 {
        if u.abs() < 1024.0 {
            u
        } else if !u.is_finite() {
            0.0
        } else if self == Self::Clamp {
            u.clamp(-1.0, 2.0)
        } else {
            u.rem_euclid(2.0)
        }
    }

    /// The texel that stands for texel `i` of a row of `n ≥ 1`.
    #[inline(always)]
    pub fn apply(self, i: i32, n: i32) -> u32 {
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

/// Where a lookup falls in an image: four texels, two columns by two rows, and their weights. Images of one size that are looked up at one place in one
/// way (a material's base colour, roughness, normal …) share it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footprint {
    /// The two columns.
    pub x: [u32; 2],
    /// The two rows.
    pub y: [u32; 2],
    /// Weights of (x₀, y₀), (x₁, y₀), (x₀, y₁), (x₁, y₁); they add up to 1.
    pub weights: [f32; 4],
}

impl Footprint {
    /// The texels of an image of `width × height` pixels about `uv`.
    #[inline(always)]
    pub fn new(sampler: &Sampler, width: u32, height: u32, uv: Vec2) -> Self {
        let (w, h) = (width as i32, height as i32);
        let p = Vec2::new(sampler.wrap_u.reduce(uv.x) * w as f32, sampler.wrap_v.reduce(uv.y) * h as f32);
        if sampler.filter == Filter::Nearest {
            let (x, y) = (floor(p.x), floor(p.y));
            let (x, y) = (sampler.wrap_u.apply(x, w), sampler.wrap_v.apply(y, h));
            return Self { x: [x; 2], y: [y; 2], weights: [1.0, 0.0, 0.0, 0.0] };
        }
        let p = p - 0.5;
        let (x, y) = (floor(p.x), floor(p.y));
        let (tx, ty) = (p.x - x as f32, p.y - y as f32);
        let (sx, sy) = (1.0 - tx, 1.0 - ty);
        Self {
            x: [sampler.wrap_u.apply(x, w), sampler.wrap_u.apply(x + 1, w)],
            y: [sampler.wrap_v.apply(y, h), sampler.wrap_v.apply(y + 1, h)],
            weights: [sx * sy, tx * sy, sx * ty, tx * ty],
        }
    }

    /// The weighted sum of what `texel` says of a column and a row.
    #[inline(always)]
    pub fn gather(&self, texel: impl Fn(u32, u32) -> Vec4) -> Vec4 {
        let ([x0, x1], [y0, y1], w) = (self.x, self.y, self.weights);
        texel(x0, y0) * w[0] + texel(x1, y0) * w[1] + texel(x0, y1) * w[2] + texel(x1, y1) * w[3]
    }

    /// RGBA of `image` here, colour channels decoded from sRGB to linear. Grey images give equal channels; no alpha is 1.
    pub fn srgb(&self, image: &Image) -> Vec4 {
        self.gather(|x, y| texel::<true>(image, x, y))
    }

    /// RGBA of `image` here as stored (data: normals, roughness …).
    pub fn linear(&self, image: &Image) -> Vec4 {
        self.gather(|x, y| texel::<false>(image, x, y))
    }
}

impl Texture {
    /// RGBA at `uv`, colour channels decoded from sRGB to linear: [`Footprint::srgb`].
    #[inline(always)]
    pub fn sample_srgb(&self, image: &Image, uv: Vec2) -> Vec4 {
        Footprint::new(&self.sampler, image.width, image.height, uv).srgb(image)
    }

    /// RGBA at `uv` as stored: [`Footprint::linear`].
    #[inline(always)]
    pub fn sample_linear(&self, image: &Image, uv: Vec2) -> Vec4 {
        Footprint::new(&self.sampler, image.width, image.height, uv).linear(image)
    }
}

/// Largest integer not above `x`, for |x| < 2³¹. The baseline x86-64 has no instruction for `f32::floor`.
#[inline(always)]
fn floor(x: f32) -> i32 {
    let i = x as i32;
    i - i32::from((i as f32) > x)
}

fn texel<const SRGB: bool>(image: &Image, x: u32, y: u32) -> Vec4 {
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
    use etendue_image::Pixels;

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
        assert_eq!([at(Wrap::Mirror, 1.25), at(Wrap::Clamp, 7.0), at(Wrap::Clamp, 1e9)], [1.0, 1.0, 1.0]);
        assert_eq!(
            [at(Wrap::Mirror, -1.25), at(Wrap::Clamp, -1e9), at(Wrap::Clamp, f32::MAX)],
            [1.0, 0.0, 1.0]
        );
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
