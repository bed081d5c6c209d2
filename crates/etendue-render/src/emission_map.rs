//! Which triangles of a textured emitter stay dark.
//!
//! Most of a model whose material has an emissive texture emits nothing. Knowing which triangles surely do not keeps them
//! out of the light tree and saves the lookup at each hit.

use etendue_image::Image;
use etendue_scene::{Sampler, Wrap};
use glam::Vec2;

/// Texels along a block's side.
const BLOCK: i32 = 8;

/// For blocks of an image: is any texel in it not black?
pub(crate) struct EmissionMap {
    lit: Vec<bool>,
    columns: usize,
    size: [i32; 2],
    sampler: Sampler,
    any: bool,
}

impl EmissionMap {
    pub fn new(image: &Image, sampler: Sampler) -> Self {
        let size = [image.width as i32, image.height as i32];
        let columns = size[0].div_euclid(BLOCK) as usize + 1;
        let rows = size[1].div_euclid(BLOCK) as usize + 1;
        let mut lit = vec![false; columns * rows];
        let colors = if image.channels < 3 { 1 } else { 3 };
        for y in 0..image.height {
            for x in 0..image.width {
                if (0..colors).any(|c| image.sample(x, y, c) > 0.0) {
                    lit[(y as i32 / BLOCK) as usize * columns + (x as i32 / BLOCK) as usize] = true;
                }
            }
        }
        let any = lit.contains(&true);
        Self { lit, columns, size, sampler, any }
    }

    /// False if no point of the triangle with these texture coordinates can be lit. Errs towards true.
    pub fn may_emit(&self, uv: [Vec2; 3]) -> bool {
        if !self.any || !uv.iter().all(|p| p.is_finite()) {
            return self.any;
        }
        let (lo, hi) = (uv[0].min(uv[1]).min(uv[2]), uv[0].max(uv[1]).max(uv[2]));
        // Beyond this a float no longer tells texels apart.
        if lo.abs().max(hi.abs()).max_element() >= 1024.0 {
            return true;
        }
        let blocks = |axis: usize, wrap: Wrap| -> Vec<usize> {
            let n = self.size[axis];
            // A lookup touches the texels half a texel to both sides; one more for rounding.
            let first = (lo[axis] * n as f32).floor() as i32 - 2;
            let last = (hi[axis] * n as f32).floor() as i32 + 2;
            let mut out: Vec<usize> = if last - first >= n {
                (0..n).step_by(BLOCK as usize).map(|i| (i / BLOCK) as usize).collect()
            } else {
                (first..=last).map(|i| (wrap.apply(i, n) as i32 / BLOCK) as usize).collect()
            };
            out.dedup();
            out
        };
        let columns = blocks(0, self.sampler.wrap_u);
        let rows = blocks(1, self.sampler.wrap_v);
        rows.iter().any(|r| columns.iter().any(|c| self.lit[r * self.columns + c]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue_image::Pixels;

    #[test]
    fn finds_the_lit_corner_through_every_wrap() {
        let mut p = vec![0u8; 64 * 64 * 3];
        p[(60 * 64 + 62) * 3 + 1] = 9;
        let image = Image { width: 64, height: 64, channels: 3, pixels: Pixels::U8(p) };
        let at = |wrap, u: f32, v: f32| {
            let m = EmissionMap::new(&image, Sampler { wrap_u: wrap, wrap_v: wrap, ..Sampler::default() });
            let d = 0.01;
            m.may_emit([Vec2::new(u, v), Vec2::new(u + d, v), Vec2::new(u, v + d)])
        };
        assert!(at(Wrap::Clamp, 0.96, 0.93) && !at(Wrap::Clamp, 0.5, 0.5));
        assert!(
            at(Wrap::Repeat, -0.03, 0.94) && at(Wrap::Repeat, 3.97, -1.06) && !at(Wrap::Repeat, 1.5, 0.94)
        );
        assert!(at(Wrap::Mirror, 1.02, 1.05) && !at(Wrap::Mirror, 0.02, 0.05));
        assert!(at(Wrap::Clamp, 7.0, 0.93), "the edge goes on");
        let m = EmissionMap::new(&image, Sampler::default());
        assert!(m.may_emit([Vec2::ZERO, Vec2::new(5.0, 0.0), Vec2::new(0.0, 5.0)]));
        assert!(m.may_emit([Vec2::NAN; 3]));
    }
}
