//! Polygons into triangles.
//!
//! Convex outlines become fans from their first corner, as everybody does it. Others are cut by ears (Meisters 1975,
//! "Polygons have ears"): a corner that turns with the outline and whose triangle holds no other corner is cut off, until
//! a triangle is left. The outline is seen along its Newell normal (Sutherland, Sproull, Schumacker 1974), so that it need
//! not be flat.

use glam::{DVec2, DVec3};

/// Comparisons of a corner with a triangle that one import may spend; far more than any real model takes, and a few
/// seconds of work at most.
const WORK: u64 = 1 << 29;

/// Cuts polygons; remembers how much work it may still do, so that a hostile outline cannot hold it up.
pub(crate) struct Cutter {
    work: u64,
    points: Vec<DVec2>,
    next: Vec<u32>,
    previous: Vec<u32>,
    /// Corners that do not turn with the outline.
    reflex: Vec<u32>,
    /// True once an outline was too costly and became a fan, whatever its shape.
    pub gave_up: bool,
}

impl Default for Cutter {
    fn default() -> Self {
        Self {
            work: WORK,
            points: Vec::new(),
            next: Vec::new(),
            previous: Vec::new(),
            reflex: Vec::new(),
            gave_up: false,
        }
    }
}

/// The polygon's normal, twice its area long; zero if it has no area or is not finite.
pub(crate) fn newell(corners: &[DVec3]) -> DVec3 {
    let Some(&origin) = corners.first() else { return DVec3::ZERO };
    let mut n = DVec3::ZERO;
    for (i, &a) in corners.iter().enumerate() {
        let b = corners[(i + 1) % corners.len()];
        n += (a - origin).cross(b - origin);
    }
    if n.is_finite() { n } else { DVec3::ZERO }
}

impl Cutter {
    /// Appends the triangles of an outline to `out`, as numbers of its corners. Fewer than three corners make none.
    pub fn cut(&mut self, corners: &[DVec3], out: &mut Vec<[u32; 3]>) {
        let n = corners.len() as u32;
        if n <= 3 {
            out.extend((n == 3).then_some([0, 1, 2]));
            return;
        }
        let normal = newell(corners);
        let fan = |out: &mut Vec<[u32; 3]>| out.extend((1..n - 1).map(|i| [0, i, i + 1]));
        if normal == DVec3::ZERO {
            return fan(out);
        }
        // Along the axis nearest to the normal nothing is folded over.
        let a = normal.abs();
        self.points.clear();
        self.points.extend(corners.iter().map(|p| {
            let q = *p - corners[0];
            if a.z >= a.x && a.z >= a.y {
                DVec2::new(q.x, q.y * normal.z.signum())
            } else if a.y >= a.x {
                DVec2::new(q.z, q.x * normal.y.signum())
            } else {
                DVec2::new(q.y, q.z * normal.x.signum())
            }
        }));
        self.next.clear();
        self.next.extend((0..n).map(|i| (i + 1) % n));
        self.previous.clear();
        self.previous.extend((0..n).map(|i| (i + n - 1) % n));
        self.reflex.clear();
        for i in 0..n {
            if self.turn(i) <= 0.0 {
                self.reflex.push(i);
            }
        }
        if (0..n).all(|i| self.turn(i) >= 0.0) {
            return fan(out);
        }
        self.ears(n, out);
    }

    /// Twice the area of the triangle at corner `i`: positive if it turns with the outline.
    fn turn(&self, i: u32) -> f64 {
        let at = |k: u32| self.points[k as usize];
        let (a, b, c) = (at(self.previous[i as usize]), at(i), at(self.next[i as usize]));
        (b - a).perp_dot(c - b)
    }

    fn ears(&mut self, n: u32, out: &mut Vec<[u32; 3]>) {
        let (mut i, mut left, mut misses) = (0u32, n, 0u32);
        while left > 3 {
            let (a, c) = (self.previous[i as usize], self.next[i as usize]);
            let cost = self.reflex.len() as u64 + 1;
            if self.work < cost {
                self.gave_up = true;
                break;
            }
            self.work -= cost;
            // After a whole round without an ear the outline crosses itself: any corner will do.
            if misses < left && !(self.turn(i) > 0.0 && self.is_empty(a, i, c)) {
                misses += 1;
                i = c;
                continue;
            }
            out.push([a, i, c]);
            self.next[a as usize] = c;
            self.previous[c as usize] = a;
            self.reflex.retain(|&r| r != i);
            for k in [a, c] {
                if self.turn(k) > 0.0 {
                    self.reflex.retain(|&r| r != k);
                }
            }
            left -= 1;
            misses = 0;
            // Not the neighbour: taking every other corner keeps triangles from becoming slivers around one of them.
            i = self.next[c as usize];
        }
        let first = i;
        let mut k = self.next[first as usize];
        for _ in 0..left - 2 {
            let after = self.next[k as usize];
            out.push([first, k, after]);
            k = after;
        }
    }

    /// True if no other corner lies in the triangle. Only corners that turn against the outline can be the first to
    /// do so. Those in the same place as one of its own do not count: outlines with holes touch themselves.
    fn is_empty(&self, a: u32, b: u32, c: u32) -> bool {
        let [pa, pb, pc] = [a, b, c].map(|k| self.points[k as usize]);
        self.reflex.iter().all(|&r| {
            let p = self.points[r as usize];
            let inside = (pb - pa).perp_dot(p - pa) >= 0.0
                && (pc - pb).perp_dot(p - pb) >= 0.0
                && (pa - pc).perp_dot(p - pc) >= 0.0;
            !inside || p == pa || p == pb || p == pc
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cut(p: &[DVec3]) -> Vec<[u32; 3]> {
        let mut out = Vec::new();
        Cutter::default().cut(p, &mut out);
        out
    }

    /// Sum of the triangles' areas along `normal`, and of their absolute values: equal if none is turned over.
    fn areas(p: &[DVec3], t: &[[u32; 3]]) -> (f64, f64) {
        let n = newell(p).normalize();
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| p[i as usize]);
            0.5 * (b - a).cross(c - a).dot(n)
        };
        (t.iter().map(area).sum(), t.iter().map(|t| area(t).abs()).sum())
    }

    fn star(n: usize, inner: f64, tilt: DVec3) -> Vec<DVec3> {
        let (x, y) = tilt.normalize().any_orthonormal_pair();
        (0..n)
            .map(|i| {
                let (s, c) = (i as f64 / n as f64 * std::f64::consts::TAU).sin_cos();
                (x * c + y * s) * if i % 2 == 0 { 1.0 } else { inner }
            })
            .collect()
    }

    #[test]
    fn concave_outlines_are_covered_once() {
        for tilt in [DVec3::Z, DVec3::NEG_Z, DVec3::X, DVec3::NEG_Y, DVec3::new(1.0, 2.0, -3.0)] {
            for n in [4, 6, 8, 50, 400] {
                let p = star(n, 0.2, tilt);
                let t = cut(&p);
                assert_eq!(t.len(), n - 2);
                let (sum, absolute) = areas(&p, &t);
                assert!((sum - absolute).abs() < 1e-12, "{n} {tilt}: {sum} {absolute}");
                assert!((sum - 0.5 * newell(&p).length()).abs() < 1e-12, "{n} {tilt}");
            }
        }
    }

    #[test]
    fn a_concave_quad_is_cut_at_its_dent() {
        let p = [(0.0, 0.0), (2.0, -1.0), (0.5, 0.0), (2.0, 1.0)].map(|(x, y)| DVec3::new(x, y, 0.0));
        let t = cut(&p);
        assert!(t.iter().all(|t| t.contains(&0) && t.contains(&2)), "{t:?}");
    }

    #[test]
    fn convex_outlines_are_fans() {
        assert_eq!(cut(&star(5, 1.0, DVec3::Z)), [[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
    }

    #[test]
    fn an_outline_with_a_hole() {
        // A square with a square hole, joined by a cut from corner to corner that is passed both ways.
        let xy = [
            (0., 0.),
            (4., 0.),
            (4., 4.),
            (0., 4.),
            (0., 0.),
            (1., 1.),
            (1., 3.),
            (3., 3.),
            (3., 1.),
            (1., 1.),
        ];
        let p = xy.map(|(x, y)| DVec3::new(x, y, 1.0));
        let (sum, absolute) = areas(&p, &cut(&p));
        assert_eq!((sum, absolute), (12.0, 12.0));
    }

    #[test]
    fn odd_outlines_end() {
        let nan = DVec3::splat(f64::NAN);
        let bow = [(0., 0.), (1., 1.), (1., 0.), (0., 1.1)].map(|(x, y)| DVec3::new(x, y, 0.0));
        for p in [
            &[][..],
            &[nan; 2],
            &[nan; 5],
            &[DVec3::ONE; 9],
            &bow,
            &[DVec3::MAX, DVec3::MIN, DVec3::X, DVec3::Y],
        ] {
            assert_eq!(cut(p).len(), p.len().saturating_sub(2));
        }
        // A comb whose teeth are all in each other's way: work without bound would take minutes.
        let comb: Vec<_> = (0..200_000)
            .map(|i| {
                let (s, c) = (f64::from(i) * 2.4).sin_cos();
                DVec3::new(c, s, 0.0) * (1.0 + f64::from(i % 7))
            })
            .collect();
        let mut out = Vec::new();
        let mut cutter = Cutter::default();
        cutter.cut(&comb, &mut out);
        assert!(cutter.gave_up && out.len() == comb.len() - 2);
    }
}
