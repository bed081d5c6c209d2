//! From meshes to pictures: which place of the surface each texel shows, and what the surface does around it.

use crate::noise::{hash, smoothstep};
use crate::occlusion::Occluders;
use crate::shape::Mesh;
use glam::{Vec2, Vec3, Vec4};
use rayon::prelude::*;

/// A place on the surface as a texel sees it.
#[derive(Clone, Copy)]
pub struct Texel {
    /// Position in the helmet's space, metres.
    pub pos: Vec3,
    /// Unit normal.
    pub nrm: Vec3,
    /// Change of position per texel to the right and per texel up.
    pub right: Vec3,
    /// See `right`.
    pub up: Vec3,
    /// Tangent and handedness as the file has them.
    pub tangent: Vec4,
    /// The part's paint coordinates.
    pub aux: Vec3,
    /// Which part, 0 for none.
    pub part: u8,
    /// Openness 0..1.
    pub open: f32,
    /// Sharpness of the edge: 0 flat or hollow, towards 1 on a sharp ridge.
    pub ridge: f32,
}

const NOTHING: Texel = Texel {
    pos: Vec3::ZERO,
    nrm: Vec3::Z,
    right: Vec3::X,
    up: Vec3::Y,
    tangent: Vec4::new(1.0, 0.0, 0.0, 1.0),
    aux: Vec3::ZERO,
    part: 0,
    open: 1.0,
    ridge: 0.0,
};

/// A picture of places.
pub struct Atlas {
    /// Width, texels.
    pub width: usize,
    /// Height, texels.
    pub height: usize,
    /// Row by row from the top.
    pub texels: Vec<Texel>,
}

impl Atlas {
    /// An empty atlas.
    pub fn new(width: usize, height: usize) -> Self {
        Self { width, height, texels: vec![NOTHING; width * height] }
    }

    /// Draws a mesh (positions in the helmet's space) into its texture coordinates as part `part` (1..).
    pub fn draw(&mut self, m: &Mesh, part: u8) {
        let size = Vec2::new(self.width as f32, self.height as f32);
        let tangents = m.tangents();
        for t in m.idx.chunks_exact(3) {
            let i = [0, 1, 2].map(|k| t[k] as usize);
            let uv = i.map(|k| m.uv[k] * size);
            let (e1, e2) = (uv[1] - uv[0], uv[2] - uv[0]);
            let det = e1.perp_dot(e2);
            if det.abs() < 1e-9 {
                continue;
            }
            let (p1, p2) = (m.pos[i[1]] - m.pos[i[0]], m.pos[i[2]] - m.pos[i[0]]);
            let right = (p1 * e2.y - p2 * e1.y) / det;
            let ridge = smoothstep(150.0, 500.0, bend(m, i));
            let down = (p2 * e1.x - p1 * e2.x) / det;
            let min = uv[0].min(uv[1]).min(uv[2]) - 0.5;
            let max = uv[0].max(uv[1]).max(uv[2]) + 0.5;
            for y in (min.y.max(0.0) as usize)..=(max.y.max(0.0) as usize).min(self.height - 1) {
                for x in (min.x.max(0.0) as usize)..=(max.x.max(0.0) as usize).min(self.width - 1) {
                    let q = Vec2::new(x as f32 + 0.5, y as f32 + 0.5) - uv[0];
                    let (b, c) = (q.perp_dot(e2) / det, e1.perp_dot(q) / det);
                    let w = [1.0 - b - c, b, c];
                    if w.iter().any(|w| *w < -1e-4) {
                        continue;
                    }
                    let of = |v: &[Vec3]| v[i[0]] * w[0] + v[i[1]] * w[1] + v[i[2]] * w[2];
                    self.texels[y * self.width + x] = Texel {
                        pos: of(&m.pos),
                        nrm: of(&m.nrm).normalize_or(Vec3::Z),
                        right,
                        up: -down,
                        tangent: tangents[i[0]] * w[0] + tangents[i[1]] * w[1] + tangents[i[2]] * w[2],
                        aux: of(&m.aux),
                        part,
                        open: 1.0,
                        ridge,
                    };
                }
            }
        }
    }

    /// Grows every part into the empty texels around it, `steps` texels far, so that filtering finds no gap.
    pub fn grow(&mut self, steps: usize) {
        let (w, h) = (self.width, self.height);
        for _ in 0..steps {
            let old = self.texels.clone();
            self.texels.par_chunks_mut(w).enumerate().for_each(|(y, row)| {
                for x in 0..w {
                    if row[x].part != 0 {
                        continue;
                    }
                    for (dx, dy) in [(1i64, 0i64), (-1, 0), (0, 1), (0, -1)] {
                        let (nx, ny) = (x as i64 + dx, y as i64 + dy);
                        if nx < 0 || ny < 0 || nx >= w as i64 || ny >= h as i64 {
                            continue;
                        }
                        let t = &old[ny as usize * w + nx as usize];
                        if t.part != 0 {
                            // Go on along the surface's tangent, so that patterns go on too.
                            row[x] = Texel { pos: t.pos - t.right * dx as f32 + t.up * dy as f32, ..*t };
                            break;
                        }
                    }
                }
            });
        }
    }

    /// Widens and softens ridges by `radius` texels within their part.
    pub fn soften_ridges(&mut self, radius: usize) {
        let (w, h) = (self.width, self.height);
        for along_x in [true, false] {
            let old: Vec<(u8, f32)> = self.texels.iter().map(|t| (t.part, t.ridge)).collect();
            self.texels.par_iter_mut().enumerate().filter(|(_, t)| t.part != 0).for_each(|(i, t)| {
                let (at, end, stride) = if along_x { (i % w, w, 1) } else { (i / w, h, w) };
                let (mut sum, mut n) = (0.0, 0.0);
                for k in at.saturating_sub(radius)..=(at + radius).min(end - 1) {
                    let (part, ridge) = old[i + k * stride - at * stride];
                    if part == t.part {
                        sum += ridge;
                        n += 1.0;
                    }
                }
                t.ridge = sum / n;
            });
        }
    }

    /// Computes openness (within `reach` metres) on every `step`-th texel and spreads it linearly between.
    pub fn occlude(&mut self, world: &Occluders, reach: f32, step: usize, rays: u32) {
        let (cw, ch) = (self.width.div_ceil(step), self.height.div_ceil(step));
        let coarse: Vec<Option<(f32, u8)>> = (0..cw * ch)
            .into_par_iter()
            .map(|i| {
                let (x, y) = ((i % cw * step + step / 2), (i / cw * step + step / 2));
                let t = &self.texels[y.min(self.height - 1) * self.width + x.min(self.width - 1)];
                (t.part != 0).then(|| {
                    let salt = hash(i as u32);
                    let open = world.openness(t.pos + t.nrm * 4e-4, t.nrm, reach, rays, salt);
                    (open, t.part)
                })
            })
            .collect();
        let texels = &mut self.texels;
        let width = self.width;
        texels.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
            for (x, t) in row.iter_mut().enumerate() {
                if t.part == 0 {
                    continue;
                }
                let (fx, fy) = (
                    (x as f32 - (step / 2) as f32) / step as f32,
                    (y as f32 - (step / 2) as f32) / step as f32,
                );
                let (mut sum, mut weight) = (0.0, 0.0);
                // A tent two coarse texels wide: bilinear, and a little softer against the rays' noise.
                for cy in (fy.floor() as i64 - 1)..=(fy.floor() as i64 + 2) {
                    for cx in (fx.floor() as i64 - 1)..=(fx.floor() as i64 + 2) {
                        if cx < 0 || cy < 0 || cx >= cw as i64 || cy >= ch as i64 {
                            continue;
                        }
                        if let Some((v, part)) = coarse[cy as usize * cw + cx as usize]
                            && part == t.part
                        {
                            let k = (1.6 - (cx as f32 - fx).abs()).max(0.0)
                                * (1.6 - (cy as f32 - fy).abs()).max(0.0);
                            sum += v * k;
                            weight += k;
                        }
                    }
                }
                if weight > 0.0 {
                    t.open = sum / weight;
                }
            }
        });
    }
}

/// The strongest convex bend along a triangle's edges, 1/metres: the change of the normal along the edge, by its length.
fn bend(m: &Mesh, i: [usize; 3]) -> f32 {
    [(0, 1), (1, 2), (2, 0)].iter().fold(0.0f32, |most, &(a, b)| {
        let (a, b) = (i[a], i[b]);
        let edge = m.pos[b] - m.pos[a];
        most.max((m.nrm[b] - m.nrm[a]).dot(edge) / edge.length_squared().max(1e-12))
    })
}

/// What the paint is like at a texel.
#[derive(Clone, Copy)]
pub struct Paint {
    /// Base colour, linear.
    pub base: Vec3,
    /// 0 dielectric, 1 metal.
    pub metallic: f32,
    /// Perceptual roughness.
    pub roughness: f32,
    /// Height over the geometry, metres.
    pub height: f32,
    /// Emitted colour, 0..1 linear.
    pub emissive: Vec3,
}

/// The pictures of one material, 8 bits, RGB, row by row.
pub struct Maps {
    /// Width, texels.
    pub width: usize,
    /// Height, texels.
    pub height: usize,
    /// Base colour, sRGB-encoded.
    pub base: Vec<u8>,
    /// Occlusion, roughness, metallic.
    pub orm: Vec<u8>,
    /// Tangent-space normal, +Y up.
    pub normal: Vec<u8>,
    /// Emission, sRGB-encoded.
    pub emissive: Vec<u8>,
}

/// The sRGB encoding of a linear value (IEC 61966-2-1), 8 bits.
pub fn srgb8(x: f32) -> u8 {
    let x = x.clamp(0.0, 1.0);
    let e = if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
    (e * 255.0 + 0.5) as u8
}

fn unit8(x: f32) -> u8 {
    (x.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}

/// Paints an atlas. `background` fills the texels that show nothing.
pub fn paint(atlas: &Atlas, background: Vec3, painter: impl Fn(&Texel) -> Paint + Sync) -> Maps {
    let (w, h) = (atlas.width, atlas.height);
    let none = Paint { base: background, metallic: 0.0, roughness: 0.5, height: 0.0, emissive: Vec3::ZERO };
    let paints: Vec<Paint> =
        atlas.texels.par_iter().map(|t| if t.part == 0 { none } else { painter(t) }).collect();
    let normals: Vec<[u8; 3]> = (0..w * h)
        .into_par_iter()
        .map(|i| {
            let t = &atlas.texels[i];
            if t.part == 0 {
                return [128, 128, 255];
            }
            let (x, y) = (i % w, i / w);
            let same = |k: usize| atlas.texels[k].part == t.part;
            // Height difference per texel, central where both neighbours show the same part.
            let slope = |before: Option<usize>, after: Option<usize>| {
                let (a, b) = (before.filter(|k| same(*k)), after.filter(|k| same(*k)));
                let (ka, kb) = (a.unwrap_or(i), b.unwrap_or(i));
                let n = a.is_some() as u32 + b.is_some() as u32;
                if n == 0 { 0.0 } else { (paints[kb].height - paints[ka].height) / n as f32 }
            };
            let du = slope((x > 0).then(|| i - 1), (x + 1 < w).then_some(i + 1));
            let dv = slope((y + 1 < h).then_some(i + w), (y > 0).then(|| i - w));
            let n = t.nrm;
            // The surface gradient of the height in the (oblique) frame of the texture (Mikkelsen 2010).
            let (r1, r2) = (t.up.cross(n), n.cross(t.right));
            let det = t.right.dot(r1);
            if det.abs() < 1e-16 {
                return [128, 128, 255];
            }
            let bent = (n - (r1 * du + r2 * dv) / det).normalize_or(n);
            let tx = t.tangent.truncate();
            let tx = (tx - n * n.dot(tx)).normalize_or(Vec3::X);
            let ty = n.cross(tx) * t.tangent.w.signum();
            [bent.dot(tx), bent.dot(ty), bent.dot(n)].map(|c| unit8(c * 0.5 + 0.5))
        })
        .collect();
    let bytes = |f: &(dyn Fn(usize) -> [u8; 3] + Sync)| -> Vec<u8> { (0..w * h).flat_map(f).collect() };
    Maps {
        width: w,
        height: h,
        base: bytes(&|i| [paints[i].base.x, paints[i].base.y, paints[i].base.z].map(srgb8)),
        orm: bytes(&|i| {
            let p = &paints[i];
            [unit8(atlas.texels[i].open), unit8(p.roughness), unit8(p.metallic)]
        }),
        normal: normals.concat(),
        emissive: bytes(&|i| paints[i].emissive.to_array().map(srgb8)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A plate in the xy plane, 1 m a side, that fills the atlas upright.
    fn plate(n: usize) -> Atlas {
        let mut m = Mesh::default();
        for (x, y) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
            m.push(Vec3::new(x, y, 0.0), Vec3::Z, Vec2::new(x, 1.0 - y), Vec3::ZERO);
        }
        m.tri(0, 1, 2);
        m.tri(0, 2, 3);
        let mut a = Atlas::new(n, n);
        a.draw(&m, 1);
        a
    }

    #[test]
    fn texels_lie_where_they_are_drawn() {
        let a = plate(16);
        assert!(a.texels.iter().all(|t| t.part == 1));
        let t = &a.texels[3 * 16 + 5];
        assert!(t.pos.distance(Vec3::new(5.5 / 16.0, 1.0 - 3.5 / 16.0, 0.0)) < 1e-5);
        assert!(t.right.distance(Vec3::X / 16.0) < 1e-6 && t.up.distance(Vec3::Y / 16.0) < 1e-6);
    }

    /// A slope that rises to the right and upward leans its normal to the left and downward, by exactly its steepness.
    #[test]
    fn normals_follow_the_height() {
        let a = plate(16);
        let (sx, sy) = (0.3, 0.4);
        let maps = paint(&a, Vec3::ZERO, |t| Paint {
            base: Vec3::ZERO,
            metallic: 0.0,
            roughness: 0.5,
            height: sx * t.pos.x + sy * t.pos.y,
            emissive: Vec3::ZERO,
        });
        let want = Vec3::new(-sx, -sy, 1.0).normalize();
        for n in maps.normal.chunks_exact(3) {
            let n = Vec3::new(n[0] as f32, n[1] as f32, n[2] as f32) / 127.5 - 1.0;
            assert!(n.distance(want) < 0.01, "{n} instead of {want}");
        }
    }
}
