//! The built-in sky: a photographer's studio, drawn by formula.

use crate::noise::smoothstep;
use etendue_image::{Image, PictureFormat, Pixels, WriteOptions, encode_picture};
use glam::Vec3;
use std::f32::consts::{PI, TAU};

/// Width of the picture, pixels; it is half as high.
pub const WIDTH: usize = 512;

/// A lamp far away: a rounded rectangle with soft edges around a direction.
struct Softbox {
    /// Azimuth from +Z towards +X and elevation, degrees.
    at: [f32; 2],
    /// Half width and half height, as tangents of angles.
    half: [f32; 2],
    /// Turn around its own axis, degrees.
    roll: f32,
    /// Width of the soft edge, in the same unit as `half`.
    soft: f32,
    /// Radiance at the middle.
    light: Vec3,
    /// How much of it is left at the edge.
    falloff: f32,
}

impl Softbox {
    fn radiance(&self, d: Vec3) -> Vec3 {
        let centre = crate::form::direction(self.at[0].to_radians(), self.at[1].to_radians());
        let ahead = d.dot(centre);
        if ahead <= 0.02 {
            return Vec3::ZERO;
        }
        let x = Vec3::Y.cross(centre).normalize();
        let y = centre.cross(x);
        let (s, c) = self.roll.to_radians().sin_cos();
        let (px, py) = (d.dot(x) / ahead, d.dot(y) / ahead);
        let (px, py) = (px * c + py * s, py * c - px * s);
        // Signed distance to a rectangle with rounded corners.
        let round = 0.35 * self.half[0].min(self.half[1]);
        let q = [px.abs() - self.half[0] + round, py.abs() - self.half[1] + round];
        let outside = (q[0].max(0.0).powi(2) + q[1].max(0.0).powi(2)).sqrt();
        let distance = outside + q[0].max(q[1]).min(0.0) - round;
        let r2 = 0.5 * ((px / self.half[0]).powi(2) + (py / self.half[1]).powi(2));
        let inner = 1.0 - (1.0 - self.falloff) * r2.min(1.0);
        self.light * (inner * smoothstep(0.5 * self.soft, -0.5 * self.soft, distance))
    }
}

/// The lamps. The camera stands at azimuth 24°, elevation 11°.
fn lamps() -> Vec<Softbox> {
    let warm = Vec3::new(1.0, 0.93, 0.84);
    let cool = Vec3::new(0.80, 0.90, 1.0);
    let mut all = vec![
        // The key: large, high, on the camera's left.
        Softbox {
            at: [-50.0, 40.0],
            half: [0.50, 0.38],
            roll: 8.0,
            soft: 0.09,
            light: warm * 9.5,
            falloff: 0.55,
        },
        // The top light.
        Softbox {
            at: [150.0, 78.0],
            half: [0.55, 0.38],
            roll: 0.0,
            soft: 0.25,
            light: Vec3::ONE * 3.2,
            falloff: 0.6,
        },
        // Two strips behind for the rims.
        Softbox {
            at: [122.0, 12.0],
            half: [0.12, 0.85],
            roll: -6.0,
            soft: 0.08,
            light: cool * 22.0,
            falloff: 0.45,
        },
        Softbox {
            at: [-112.0, 16.0],
            half: [0.10, 0.80],
            roll: 8.0,
            soft: 0.08,
            light: cool * 15.0,
            falloff: 0.45,
        },
        // A reflector on the floor in front: lights the jaw from below.
        Softbox {
            at: [-5.0, -56.0],
            half: [0.85, 0.30],
            roll: 0.0,
            soft: 0.45,
            light: warm * 1.5,
            falloff: 0.3,
        },
    ];
    // A window on the camera's right: two by three panes.
    for column in 0..2 {
        for row in 0..3 {
            all.push(Softbox {
                at: [62.0 + 17.0 * (column as f32 - 0.5), 30.0 + 14.5 * (row as f32 - 1.0)],
                half: [0.125, 0.105],
                roll: 0.0,
                soft: 0.02,
                light: cool * 5.5,
                falloff: 0.8,
            });
        }
    }
    all
}

/// Radiance from direction `d` (unit).
pub fn radiance(d: Vec3) -> Vec3 {
    let elevation = d.y.clamp(-1.0, 1.0).asin();
    // How far the direction lies to the front, where the camera stands: the walls there are lit, those behind are not.
    let front = smoothstep(-0.75, 0.55, d.z);
    let dark = Vec3::new(0.020, 0.025, 0.031);
    let glow = dark.lerp(Vec3::new(0.80, 0.77, 0.72), front);
    let ceiling = dark.lerp(Vec3::new(0.11, 0.12, 0.14), front);
    let wall = glow.lerp(ceiling, smoothstep(0.02, 0.85, elevation));
    let near = dark.lerp(Vec3::new(0.40, 0.34, 0.28), front);
    let floor = near.lerp(Vec3::new(0.045, 0.040, 0.036), smoothstep(-0.25, -1.2, elevation));
    let mut l = floor.lerp(wall, smoothstep(-0.16, 0.03, elevation));
    // A pool of light on the backdrop, behind whatever the camera looks at.
    let pool = crate::form::direction(204f32.to_radians(), -9f32.to_radians());
    let angle = d.dot(pool).clamp(-1.0, 1.0).acos();
    l += Vec3::new(0.150, 0.185, 0.205) * (-(angle / 0.27).powi(2)).exp();
    l += Vec3::new(0.018, 0.024, 0.030) * (-(angle / 0.95).powi(2)).exp();
    lamps().iter().fold(l, |sum, s| sum + s.radiance(d))
}

/// The sky as linear RGB, row by row from the top, `WIDTH` × `WIDTH / 2`. A pixel is the mean over 3 × 3 directions.
pub fn pixels() -> Vec<[f32; 3]> {
    let (w, h) = (WIDTH, WIDTH / 2);
    let mut out = Vec::with_capacity(w * h);
    for y in 0..h {
        for x in 0..w {
            let mut sum = Vec3::ZERO;
            for k in 0..9 {
                let u = (x as f32 + (k % 3) as f32 / 3.0 + 1.0 / 6.0) / w as f32;
                let v = (y as f32 + (k / 3) as f32 / 3.0 + 1.0 / 6.0) / h as f32;
                // u = atan2(z, x) / 2π + ½, v = ½ − asin(y) / π.
                let (sa, ca) = ((u - 0.5) * TAU).sin_cos();
                let (se, ce) = ((0.5 - v) * PI).sin_cos();
                sum += radiance(Vec3::new(ca * ce, se, sa * ce));
            }
            out.push((sum / 9.0).to_array());
        }
    }
    out
}

/// The sky as a Radiance picture.
pub fn studio() -> Vec<u8> {
    let light = Image {
        width: WIDTH as u32,
        height: WIDTH as u32 / 2,
        channels: 3,
        pixels: Pixels::F32(pixels().into_flattened()),
    };
    let mut file = Vec::new();
    encode_picture(&mut file, PictureFormat::Hdr, &light, &WriteOptions::default())
        .expect("a sound picture into memory");
    file
}
