//! Many lights, one of them drawn in proportion to what it may contribute, at logarithmic cost.
//!
//! A binary tree over all finite lights (Conty Estevez and Kulla 2018, "Importance Sampling of Many Lights with Adaptive Tree
//! Splitting"): each node knows the box, the cone of directions and the power of its lights, and bounds from these what
//! it can send to a point (the bound is section 4.2's with the conservative cosines of Pharr, Jakob and Humphreys 2023,
//! section 12.6.3). The way down is taken by chance in that proportion.

use etendue_scene::Bounds;
use glam::Vec3A;

/// Where a light (or a group of them) is, where it shines, and how much.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LightBounds {
    pub bounds: Bounds,
    /// Axis of the cone that holds all emission normals.
    pub axis: Vec3A,
    /// Cosine of that cone's half angle.
    pub cos_spread: f32,
    /// Cosine of the angle from its normal within which a light emits.
    pub cos_reach: f32,
    /// Emits on both sides of its normal.
    pub two_sided: bool,
    /// Radiant intensity along the normal: area × radiance for a surface.
    pub intensity: f32,
}

impl LightBounds {
    /// Nothing that shines.
    pub const DARK: Self = Self {
        bounds: Bounds::EMPTY,
        axis: Vec3A::Y,
        cos_spread: 1.0,
        cos_reach: 0.0,
        two_sided: false,
        intensity: 0.0,
    };
}

fn angle(cos: f32) -> f32 {
    cos.clamp(-1.0, 1.0).acos()
}

/// cos(max(0, a − b)) from sines and cosines.
#[inline(always)]
fn cos_difference(sin_a: f32, cos_a: f32, sin_b: f32, cos_b: f32) -> f32 {
    if cos_a > cos_b { 1.0 } else { cos_a * cos_b + sin_a * sin_b }
}

/// sin(max(0, a − b)) from sines and cosines.
#[inline(always)]
fn sin_difference(sin_a: f32, cos_a: f32, sin_b: f32, cos_b: f32) -> f32 {
    if cos_a > cos_b { 0.0 } else { sin_a * cos_b - cos_a * sin_b }
}

#[inline(always)]
fn sin_of(cos: f32) -> f32 {
    (1.0 - cos * cos).max(0.0).sqrt()
}

impl LightBounds {
    fn union(&self, o: &Self) -> Self {
        if self.intensity <= 0.0 {
            return *o;
        }
        if o.intensity <= 0.0 {
            return *self;
        }
        let (axis, cos_spread) = union_cones(self.axis, self.cos_spread, o.axis, o.cos_spread);
        Self {
            bounds: self.bounds.union(o.bounds),
            axis,
            cos_spread,
            cos_reach: self.cos_reach.min(o.cos_reach),
            two_sided: self.two_sided | o.two_sided,
            intensity: self.intensity + o.intensity,
        }
    }

    /// Upper estimate of the irradiance at `p` on a surface with normal `n` (zero: any orientation).
    #[inline(always)]
    pub fn importance(&self, p: Vec3A, n: Vec3A) -> f32 {
        let center = self.bounds.center();
        let half = self.bounds.diagonal() * 0.5;
        let to = center - p;
        let d2_true = to.length_squared();
        let d2 = d2_true.max(half * half).max(1e-20);
        let wi = to * (1.0 / d2_true.max(1e-20).sqrt());
        let mut cos_w = -self.axis.dot(wi);
        if self.two_sided {
            cos_w = cos_w.abs();
        }
        let sin_w = sin_of(cos_w);
        // Cone of directions in which the box is seen from p.
        let cos_b = if d2_true > half * half { (1.0 - half * half / d2_true).max(0.0).sqrt() } else { -1.0 };
        let sin_b = sin_of(cos_b);
        let sin_o = sin_of(self.cos_spread);
        let cos_x = cos_difference(sin_w, cos_w, sin_o, self.cos_spread);
        let sin_x = sin_difference(sin_w, cos_w, sin_o, self.cos_spread);
        let cos_p = cos_difference(sin_x, cos_x, sin_b, cos_b);
        if cos_p <= self.cos_reach {
            return 0.0;
        }
        let mut importance = self.intensity * cos_p / d2;
        if n != Vec3A::ZERO {
            let cos_i = n.dot(wi);
            importance *= cos_difference(sin_of(cos_i), cos_i, sin_b, cos_b).max(0.0);
        }
        importance.max(0.0)
    }
}

/// The smallest cone that holds both; the whole sphere is cos −1.
fn union_cones(a: Vec3A, cos_a: f32, b: Vec3A, cos_b: f32) -> (Vec3A, f32) {
    let (ta, tb) = (angle(cos_a), angle(cos_b));
    let between = angle(a.dot(b));
    if (between + tb).min(std::f32::consts::PI) <= ta {
        return (a, cos_a);
    }
    if (between + ta).min(std::f32::consts::PI) <= tb {
        return (b, cos_b);
    }
    let t = (ta + between + tb) * 0.5;
    if t >= std::f32::consts::PI {
        return (a, -1.0);
    }
    let axis = a.cross(b);
    if axis.length_squared() < 1e-12 {
        return (a, -1.0);
    }
    let turn = t - ta;
    let k = axis.normalize();
    // Rodrigues: a is perpendicular to k.
    (a * turn.cos() + k.cross(a) * turn.sin(), t.cos())
}

#[derive(Clone, Copy, Debug)]
struct Node {
    light: LightBounds,
    /// Second child (the first follows its parent), or for a leaf the light's number with the top bit set.
    next: u32,
}

const LEAF: u32 = 1 << 31;

/// The tree over all finite lights.
#[derive(Clone, Debug, Default)]
pub(crate) struct LightTree {
    nodes: Vec<Node>,
    /// Per light: the turns from the root to its leaf, lowest bit first.
    trails: Vec<u64>,
}

impl LightTree {
    /// Builds over `lights`; light i keeps its number.
    pub fn new(lights: &[LightBounds]) -> Self {
        let mut tree = Self { nodes: Vec::with_capacity(2 * lights.len()), trails: vec![0; lights.len()] };
        let mut order: Vec<u32> =
            (0..lights.len() as u32).filter(|&i| lights[i as usize].intensity > 0.0).collect();
        if !order.is_empty() {
            tree.build(lights, &mut order, 0, 0);
        }
        tree
    }

    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// What the tree was built over; lights that are never drawn are dark in it.
    pub fn lights(&self) -> Vec<LightBounds> {
        let mut all = vec![LightBounds::DARK; self.trails.len()];
        for n in self.nodes.iter().filter(|n| n.next & LEAF != 0) {
            all[(n.next & !LEAF) as usize] = n.light;
        }
        all
    }

    fn build(&mut self, lights: &[LightBounds], order: &mut [u32], trail: u64, depth: u32) -> LightBounds {
        let at = self.nodes.len();
        if let [one] = *order {
            self.trails[one as usize] = trail;
            self.nodes.push(Node { light: lights[one as usize], next: LEAF | one });
            return lights[one as usize];
        }
        // A trail holds 64 turns: deep in a lopsided tree, halve by count, which ends within 32 more.
        let split = if depth < 24 { best_split(lights, order) } else { None };
        let middle = split.unwrap_or(order.len() / 2);
        self.nodes.push(Node { light: lights[order[0] as usize], next: 0 });
        let (left, right) = order.split_at_mut(middle);
        let a = self.build(lights, left, trail, depth + 1);
        self.nodes[at].next = self.nodes.len() as u32;
        let b = self.build(lights, right, trail | 1 << depth, depth + 1);
        self.nodes[at].light = a.union(&b);
        self.nodes[at].light
    }

    /// What all lights together may send to `p`: see [`LightBounds::importance`].
    #[inline(always)]
    pub fn importance(&self, p: Vec3A, n: Vec3A) -> f32 {
        self.nodes.first().map_or(0.0, |r| r.light.importance(p, n))
    }

    /// A light, and the probability with which it is drawn for this point; `None` if none can reach it.
    #[inline(always)]
    pub fn sample(&self, p: Vec3A, n: Vec3A, mut u: f32) -> Option<(u32, f32)> {
        let mut at = 0usize;
        let mut probability = 1.0;
        loop {
            let node = self.nodes.get(at)?;
            if node.next & LEAF != 0 {
                let reaches = at > 0 || node.light.importance(p, n) > 0.0;
                return reaches.then_some((node.next & !LEAF, probability));
            }
            let first = self.first_probability(at, p, n)?;
            if u < first {
                u /= first;
                probability *= first;
                at += 1;
            } else {
                u = ((u - first) / (1.0 - first)).min(crate::distribution::ONE_MINUS_EPSILON);
                probability *= 1.0 - first;
                at = node.next as usize;
            }
        }
    }

    /// The probability with which [`LightTree::sample`] draws `light` for this point.
    #[inline(always)]
    pub fn probability(&self, light: u32, p: Vec3A, n: Vec3A) -> f32 {
        let mut trail = self.trails[light as usize];
        let mut at = 0usize;
        let mut probability = 1.0;
        loop {
            let Some(node) = self.nodes.get(at) else { return 0.0 };
            if node.next & LEAF != 0 {
                let reaches = node.next & !LEAF == light && (at > 0 || node.light.importance(p, n) > 0.0);
                return if reaches { probability } else { 0.0 };
            }
            let Some(first) = self.first_probability(at, p, n) else { return 0.0 };
            if trail & 1 == 0 {
                probability *= first;
                at += 1;
            } else {
                probability *= 1.0 - first;
                at = node.next as usize;
            }
            trail >>= 1;
        }
    }

    #[inline(always)]
    fn first_probability(&self, at: usize, p: Vec3A, n: Vec3A) -> Option<f32> {
        let a = self.nodes[at + 1].light.importance(p, n);
        let b = self.nodes[self.nodes[at].next as usize].light.importance(p, n);
        (a + b > 0.0).then(|| a / (a + b))
    }
}

const BINS: usize = 12;

/// Reorders `order` and says where to cut it so that the surface-area-orientation cost (Conty Estevez and Kulla 2018,
/// section 4.1) of the halves is least. `None` if all centres coincide.
fn best_split(lights: &[LightBounds], order: &mut [u32]) -> Option<usize> {
    let mut centers = Bounds::EMPTY;
    let mut all = Bounds::EMPTY;
    for &i in order.iter() {
        centers.include(lights[i as usize].bounds.center());
        all = all.union(lights[i as usize].bounds);
    }
    let extent = centers.max - centers.min;
    let size = all.max - all.min;
    let mut best: Option<(f32, usize, usize)> = None;
    for axis in 0..3 {
        if extent[axis] <= 0.0 {
            continue;
        }
        let mut bins: [Option<LightBounds>; BINS] = [None; BINS];
        for &i in order.iter() {
            let l = &lights[i as usize];
            let b = bin_of(l, &centers, axis);
            bins[b] = Some(bins[b].map_or(*l, |x| x.union(l)));
        }
        let join = |a: Option<LightBounds>, b: Option<LightBounds>| match (a, b) {
            (Some(a), Some(b)) => Some(a.union(&b)),
            (a, b) => a.or(b),
        };
        let mut above = [None; BINS + 1];
        for b in (0..BINS).rev() {
            above[b] = join(above[b + 1], bins[b]);
        }
        let mut below = None;
        for cut in 1..BINS {
            below = join(below, bins[cut - 1]);
            if let (Some(a), Some(b)) = (below, above[cut]) {
                let stretch = size.max_element() / size[axis].max(1e-12);
                let c = (cost(&a) + cost(&b)) * stretch;
                if best.is_none_or(|(least, ..)| c < least) {
                    best = Some((c, axis, cut));
                }
            }
        }
    }
    let (_, axis, cut) = best?;
    order.sort_by_key(|&i| bin_of(&lights[i as usize], &centers, axis) >= cut);
    let middle = order.partition_point(|&i| bin_of(&lights[i as usize], &centers, axis) < cut);
    (middle > 0 && middle < order.len()).then_some(middle)
}

fn bin_of(l: &LightBounds, centers: &Bounds, axis: usize) -> usize {
    let t = (l.bounds.center()[axis] - centers.min[axis]) / (centers.max[axis] - centers.min[axis]);
    ((t * BINS as f32) as usize).min(BINS - 1)
}

/// Power × solid angle of emission × surface of the box.
fn cost(l: &LightBounds) -> f32 {
    let (spread, reach) = (angle(l.cos_spread), angle(l.cos_reach));
    let w = (spread + reach).min(std::f32::consts::PI);
    let sin_o = spread.sin();
    let orientation = std::f32::consts::TAU * (1.0 - l.cos_spread)
        + std::f32::consts::FRAC_PI_2
            * (2.0 * w * sin_o - (spread - 2.0 * w).cos() - 2.0 * spread * sin_o + l.cos_spread);
    let d = l.bounds.max - l.bounds.min;
    let area = 2.0 * (d.x * d.y + d.y * d.z + d.z * d.x);
    l.intensity * orientation * area.max(d.length_squared() * 1e-3).max(1e-12)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::{hash, unit};

    fn lights(n: u32) -> Vec<LightBounds> {
        let r = |k: u32| unit(hash(k * 2 + 1));
        (0..n)
            .map(|i| {
                let p = Vec3A::new(r(i * 9), r(i * 9 + 1), r(i * 9 + 2)) * 10.0;
                let axis = (Vec3A::new(r(i * 9 + 3), r(i * 9 + 4), r(i * 9 + 5)) - 0.5).normalize();
                LightBounds {
                    bounds: Bounds { min: p, max: p + r(i * 9 + 6) * 0.2 },
                    axis,
                    cos_spread: 1.0,
                    cos_reach: 0.0,
                    two_sided: i % 3 == 0,
                    intensity: 0.1 + r(i * 9 + 7),
                }
            })
            .collect()
    }

    /// `sample` draws each light with the probability that `probability` states, and those add up to one.
    #[test]
    fn sampling_matches_probability() {
        let all = lights(200);
        let tree = LightTree::new(&all);
        let (p, n) = (Vec3A::new(3.0, -1.0, 4.0), Vec3A::Y);
        let draws = 200_000;
        let mut counts = vec![0u32; all.len()];
        let mut none = 0;
        for i in 0..draws {
            // A group may look as if it reached the point when none of its lights does: nothing is drawn then.
            let Some((l, probability)) = tree.sample(p, n, (i as f32 + 0.5) / draws as f32) else {
                none += 1;
                continue;
            };
            assert!((probability - tree.probability(l, p, n)).abs() < 1e-6);
            counts[l as usize] += 1;
        }
        let sum: f32 = (0..200).map(|l| tree.probability(l, p, n)).sum::<f32>() + none as f32 / draws as f32;
        assert!(none < draws / 4);
        assert!((sum - 1.0).abs() < 1e-4, "{sum}");
        for (l, &c) in counts.iter().enumerate() {
            let expected = tree.probability(l as u32, p, n);
            assert!(
                (c as f32 / draws as f32 - expected).abs() < 1e-3 + 0.02 * expected,
                "light {l}: {c} {expected}"
            );
        }
    }

    /// No light that reaches the point has probability zero: the picture would lose it.
    #[test]
    fn every_visible_light_can_be_drawn() {
        let all = lights(300);
        let tree = LightTree::new(&all);
        for k in 0..40u32 {
            let r = |j: u32| unit(hash(k * 31 + j));
            let p = Vec3A::new(r(0), r(1), r(2)) * 14.0 - 2.0;
            let n = (Vec3A::new(r(3), r(4), r(5)) - 0.5).normalize();
            for (i, l) in all.iter().enumerate() {
                let center = l.bounds.center();
                let to = (center - p).normalize();
                let cos_l = -l.axis.dot(to);
                let faces = if l.two_sided { cos_l.abs() > 0.02 } else { cos_l > 0.02 };
                if faces && n.dot(to) > 0.02 {
                    assert!(tree.probability(i as u32, p, n) > 0.0, "light {i} is lost at {p}");
                }
            }
        }
    }

    /// Near and bright lights are drawn far more often than the average, 1/64; those that face away are not.
    #[test]
    fn probability_follows_contribution() {
        let mut all = lights(64);
        all[7].bounds = Bounds { min: Vec3A::new(5.0, 5.05, 5.0), max: Vec3A::new(5.01, 5.05, 5.01) };
        all[7].axis = Vec3A::NEG_Y;
        let tree = LightTree::new(&all);
        let near = tree.probability(7, Vec3A::new(5.0, 4.9, 5.0), Vec3A::Y);
        assert!(near > 0.1, "{near}");
        assert!(tree.probability(7, Vec3A::new(5.0, 60.0, 5.0), Vec3A::NEG_Y) < 0.1);
    }

    #[test]
    fn coinciding_lights_build() {
        let one = lights(1)[0];
        let tree = LightTree::new(&vec![one; 5000]);
        let p = one.bounds.center() - one.axis * -3.0;
        let sum: f32 = (0..5000).map(|i| tree.probability(i, p, Vec3A::ZERO)).sum();
        assert!((sum - 1.0).abs() < 1e-2, "{sum}");
    }
}
