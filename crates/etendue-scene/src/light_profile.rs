//! Measured distributions of a lamp's light over directions.

use etendue_bxdf::math::{acos, asin, atan2_turns};
use glam::{Vec3, Vec3A};
use std::f64::consts::PI;
use std::sync::Arc;

/// By which angles directions are told (IES LM-63, "photometric type"). The aim of the lamp is where both angles are 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Web {
    /// The polar axis is the aim: vertical angles 0..180 from it, horizontal ones 0..360 about it. Indoor and road lighting.
    C,
    /// The polar axis lies across: horizontal angles −90..90 towards it, vertical ones −90..90 about it. Floodlights.
    B,
    /// The polar axis stands upright: vertical angles −90..90 towards it, horizontal ones −90..90 about it. Headlights.
    A,
}

/// Luminous intensity by direction, on a grid of angles.
#[derive(Clone, Debug, PartialEq)]
pub struct LightProfile {
    web: Web,
    /// Degrees, ascending.
    vertical: Vec<f32>,
    /// Degrees, ascending; the whole range without symmetries. One alone: the same all around.
    horizontal: Vec<f32>,
    /// A row of `vertical` for each of `horizontal`.
    candela: Vec<f32>,
}

impl LightProfile {
    /// A profile of the intensities `candela`: for each horizontal angle those of all vertical ones. Angles are degrees.
    ///
    /// # Errors
    /// A sentence if there are not as many intensities as angles, a number is not finite or an intensity negative, or angles do not ascend or
    /// are outside of their web.
    pub fn new(
        web: Web,
        vertical: Vec<f32>,
        horizontal: Vec<f32>,
        candela: Vec<f32>,
    ) -> Result<Self, String> {
        let within = |angles: &[f32], (low, high): (f32, f32), what: &str| {
            if angles.is_empty() || !angles.is_sorted_by(|a, b| a < b) {
                return Err(format!("the {what} angles do not ascend"));
            }
            match angles.iter().find(|a| !(**a >= low && **a <= high)) {
                Some(a) => Err(format!("the {what} angle {a} is outside of {low}..{high} degrees")),
                None => Ok(()),
            }
        };
        let (v, h) =
            if web == Web::C { ((0.0, 180.0), (0.0, 360.0)) } else { ((-90.0, 90.0), (-90.0, 90.0)) };
        within(&vertical, v, "vertical")?;
        within(&horizontal, h, "horizontal")?;
        if candela.len() != vertical.len() * horizontal.len() {
            return Err(format!(
                "{} intensities for {} × {} angles",
                candela.len(),
                vertical.len(),
                horizontal.len()
            ));
        }
        if candela.iter().any(|c| !(c.is_finite() && *c >= 0.0)) {
            return Err("an intensity is negative or not finite".into());
        }
        Ok(Self { web, vertical, horizontal, candela })
    }

    /// By which angles directions are told.
    pub fn web(&self) -> Web {
        self.web
    }

    /// Vertical angles, degrees, ascending.
    pub fn vertical(&self) -> &[f32] {
        &self.vertical
    }

    /// Horizontal angles, degrees, ascending.
    pub fn horizontal(&self) -> &[f32] {
        &self.horizontal
    }

    /// Intensities, candela: a row over the vertical angles for each horizontal one.
    pub fn intensities(&self) -> &[f32] {
        &self.candela
    }

    /// The largest intensity, candela.
    pub fn peak(&self) -> f32 {
        self.candela.iter().copied().fold(0.0, f32::max)
    }

    /// The cosine of an angle from the aim beyond which there is no light; −1 if there may be some everywhere.
    pub fn cos_reach(&self) -> f32 {
        if self.web != Web::C {
            return -1.0;
        }
        let n = self.vertical.len();
        let lit = |i: usize| (0..self.horizontal.len()).any(|h| self.candela[h * n + i] > 0.0);
        match (0..n).rev().find(|&i| lit(i)) {
            // Light fades out towards the next angle.
            Some(i) => self.vertical[(i + 1).min(n - 1)].to_radians().cos(),
            None => 1.0,
        }
    }

    /// The intensity along the unit vector `d`, candela: bilinear in the angles. `d.z` is along the aim; at a horizontal angle of 0 the plane
    /// of x and z, for type C x itself and y at 90°; for types A and B x is upwards, and horizontal angles turn from z to −y. Outside
    /// of the angles that are there it is dark.
    #[inline]
    pub fn candela(&self, d: Vec3A) -> f32 {
        const TURN: f32 = 180.0 / std::f32::consts::PI;
        let (v, h) = match self.web {
            Web::C => {
                let turns = atan2_turns(d.y, d.x);
                (acos(d.z.clamp(-1.0, 1.0)) * TURN, 360.0 * if turns < 0.0 { turns + 1.0 } else { turns })
            }
            Web::A => (asin(d.x.clamp(-1.0, 1.0)) * TURN, 360.0 * atan2_turns(-d.y, d.z)),
            Web::B => (360.0 * atan2_turns(d.x, d.z), asin((-d.y).clamp(-1.0, 1.0)) * TURN),
        };
        let Some((i, s)) = place(&self.vertical, v) else { return 0.0 };
        let n = self.vertical.len();
        let along = |row: usize| {
            let at = |k: usize| self.candela[row * n + k.min(n - 1)];
            at(i) + (at(i + 1) - at(i)) * s
        };
        if self.horizontal.len() == 1 {
            return along(0);
        }
        let Some((k, t)) = place(&self.horizontal, h) else { return 0.0 };
        let (a, b) = (along(k), along((k + 1).min(self.horizontal.len() - 1)));
        a + (b - a) * t
    }

    /// The luminous flux, lumens: ∫ I dω.
    pub fn lumens(&self) -> f64 {
        // Cells of the grid in parts; within each the middle's intensity times its exact solid angle.
        const PARTS: usize = 8;
        let fine = |angles: &[f32], whole: Option<[f32; 2]>| -> Vec<f64> {
            let angles = whole.as_ref().map_or(angles, |w| &w[..]);
            let mut out = vec![f64::from(angles[0])];
            for w in angles.windows(2) {
                let (a, b) = (f64::from(w[0]), f64::from(w[1]));
                out.extend((1..=PARTS).map(|k| a + (b - a) * k as f64 / PARTS as f64));
            }
            out
        };
        let around = (self.horizontal.len() == 1)
            .then(|| if self.web == Web::C { [0.0, 360.0] } else { [-90.0, 90.0] });
        let (v, h) = (fine(&self.vertical, None), fine(&self.horizontal, around));
        let mut sum = 0.0;
        for a in h.windows(2) {
            for b in v.windows(2) {
                let (hm, vm) = ((0.5 * (a[0] + a[1])).to_radians(), (0.5 * (b[0] + b[1])).to_radians());
                let width = |w: &[f64]| (w[1] - w[0]) * PI / 180.0;
                let (d, solid) = match self.web {
                    Web::C => (
                        [vm.sin() * hm.cos(), vm.sin() * hm.sin(), vm.cos()],
                        width(a) * (b[0].to_radians().cos() - b[1].to_radians().cos()),
                    ),
                    Web::A => (
                        [vm.sin(), -vm.cos() * hm.sin(), vm.cos() * hm.cos()],
                        width(a) * (b[1].to_radians().sin() - b[0].to_radians().sin()),
                    ),
                    Web::B => (
                        [hm.cos() * vm.sin(), -hm.sin(), hm.cos() * vm.cos()],
                        width(b) * (a[1].to_radians().sin() - a[0].to_radians().sin()),
                    ),
                };
                let d = Vec3A::from_array(d.map(|v| v as f32));
                sum += f64::from(self.candela(d)) * solid;
            }
        }
        sum
    }
}

/// The last of ascending `angles` not above `x`, and how far `x` is on the way to the next; `None` outside of them, but for rounding.
#[inline]
fn place(angles: &[f32], x: f32) -> Option<(usize, f32)> {
    const ROUNDING: f32 = 1e-3;
    let (first, last) = (angles[0], angles[angles.len() - 1]);
    if !(x >= first - ROUNDING && x <= last + ROUNDING) {
        return None;
    }
    let i = angles.partition_point(|a| *a <= x).clamp(1, angles.len()) - 1;
    let Some(next) = angles.get(i + 1) else { return Some((i, 0.0)) };
    Some((i, ((x - angles[i]) / (next - angles[i])).clamp(0.0, 1.0)))
}

/// A profile on a lamp that is aimed somewhere.
#[derive(Clone, Debug, PartialEq)]
pub struct AimedProfile {
    profile: Arc<LightProfile>,
    axes: [Vec3A; 3],
}

impl AimedProfile {
    /// `aim` is where the lamp points, `side` where horizontal angle 0 is; both unit vectors at a right angle.
    pub fn new(profile: Arc<LightProfile>, aim: Vec3, side: Vec3) -> Self {
        let (x, z) = (Vec3A::from(side), Vec3A::from(aim));
        Self { profile, axes: [x, x.cross(z), z] }
    }

    /// The profile.
    pub fn profile(&self) -> &LightProfile {
        &self.profile
    }

    /// The intensity towards the unit direction `d` in the world, candela.
    #[inline]
    pub fn candela(&self, d: Vec3A) -> f32 {
        let [x, y, z] = self.axes;
        self.profile.candela(Vec3A::new(d.dot(x), d.dot(y), d.dot(z)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn profile(web: Web, v: &[f32], h: &[f32], f: impl Fn(f32, f32) -> f32) -> LightProfile {
        let candela = h.iter().flat_map(|h| v.iter().map(|v| f(*v, *h)).collect::<Vec<_>>()).collect();
        LightProfile::new(web, v.to_vec(), h.to_vec(), candela).unwrap()
    }

    fn steps(from: i32, to: i32, by: usize) -> Vec<f32> {
        (from..=to).step_by(by).map(|v| v as f32).collect()
    }

    #[test]
    fn directions_find_their_angles() {
        let c = profile(Web::C, &steps(0, 180, 10), &steps(0, 360, 30), |v, h| v + 1000.0 * (h % 360.0));
        let at = |v: f32, h: f32| {
            let (v, h) = (v.to_radians(), h.to_radians());
            Vec3A::new(v.sin() * h.cos(), v.sin() * h.sin(), v.cos())
        };
        for (v, h) in [(40.0, 30.0), (90.0, 240.0), (135.0, 15.0), (5.0, 300.0)] {
            assert!((c.candela(at(v, h)) - (v + 1000.0 * h)).abs() < 1.0, "{v} {h} {}", c.candela(at(v, h)));
        }
        // Type A: up is x, right of the aim (seen from above, up) −y.
        let a = profile(Web::A, &steps(-90, 90, 15), &steps(-90, 90, 15), |v, h| 500.0 + v + 2.0 * h);
        let (s, c30) = (30f32.to_radians().sin(), 30f32.to_radians().cos());
        assert!((a.candela(Vec3A::new(s, 0.0, c30)) - 530.0).abs() < 0.1);
        assert!((a.candela(Vec3A::new(0.0, -s, c30)) - 560.0).abs() < 0.1);
        assert_eq!(a.candela(Vec3A::NEG_Z), 0.0);
        // Types A and B differ where both angles count.
        let b = profile(Web::B, &steps(-90, 90, 15), &steps(-90, 90, 15), |v, h| 500.0 + v + 2.0 * h);
        let d = Vec3A::new(0.5, -0.6, 0.39f32.sqrt());
        let (h, v) = (0.6f32.asin().to_degrees(), 0.5f32.atan2(0.39f32.sqrt()).to_degrees());
        assert!((b.candela(d) - (500.0 + v + 2.0 * h)).abs() < 0.1);
        assert!((a.candela(d) - b.candela(d)).abs() > 1.0);
    }

    #[test]
    fn flux_is_the_integral_of_intensity() {
        let near = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 2e-3, "{a} {b}");
        near(profile(Web::C, &[0.0, 180.0], &[0.0], |_, _| 100.0).lumens(), 400.0 * PI);
        let lambert = |v: f32, _: f32| 100.0 * v.to_radians().cos().max(0.0);
        near(profile(Web::C, &steps(0, 90, 1), &[0.0], lambert).lumens(), 100.0 * PI);
        for web in [Web::A, Web::B] {
            let half = profile(web, &steps(-90, 90, 5), &steps(-90, 90, 5), |_, _| 100.0);
            near(half.lumens(), 200.0 * PI);
        }
        let lopsided =
            profile(Web::C, &steps(0, 180, 2), &steps(0, 360, 5), |_, h| 50.0 + h.to_radians().cos() * 50.0);
        near(lopsided.lumens(), 200.0 * PI);
    }

    #[test]
    fn faults_are_named() {
        let new =
            |v: &[f32], h: &[f32], c: &[f32]| LightProfile::new(Web::C, v.to_vec(), h.to_vec(), c.to_vec());
        assert!(new(&[0.0, 90.0], &[0.0], &[1.0]).unwrap_err().contains("1 intensities for 2"));
        assert!(new(&[90.0, 0.0], &[0.0], &[1.0, 1.0]).unwrap_err().contains("ascend"));
        assert!(new(&[0.0, f32::NAN], &[0.0], &[1.0, 1.0]).is_err());
        assert!(new(&[0.0, 190.0], &[0.0], &[1.0, 1.0]).unwrap_err().contains("190"));
        assert!(new(&[0.0, 90.0], &[0.0], &[1.0, -1.0]).unwrap_err().contains("negative"));
        let down = new(&[0.0, 60.0, 90.0], &[0.0], &[5.0, 0.0, 0.0]).unwrap();
        assert!((down.cos_reach() - 0.5).abs() < 1e-6);
        assert_eq!(down.candela(Vec3A::NEG_Z), 0.0);
    }
}
