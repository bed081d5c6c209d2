//! An environment made ready to be looked up and integrated.

use etendue_bxdf::math::{acos, atan2_turns};
use etendue_color::Spectrum;
use etendue_image::{Image, Pixels};
use etendue_scene::Environment;
use glam::Vec3A;
use rayon::prelude::*;
use std::f32::consts::FRAC_1_PI;
use std::sync::Arc;

/// The most radiance of a texel.
const BRIGHTEST: f32 = 1e30;

/// Why an environment cannot be integrated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BadSky {
    /// The picture has no pixels, or fewer samples than its size says.
    #[error("the sky's picture is {width} × {height} pixels with {samples} samples")]
    Size {
        /// Pixels in a row.
        width: u32,
        /// Rows.
        height: u32,
        /// Samples that are there.
        samples: usize,
    },
    /// A pixel is NaN, infinite or negative; `etendue_image::read_environment` mends such files.
    #[error("the sky's pixel ({x}, {y}) is {value}: radiance is finite and not negative")]
    Pixel {
        /// Column.
        x: u32,
        /// Row.
        y: u32,
        /// The first bad sample.
        value: f32,
    },
    /// The intensity, rotation or constant colour is not a finite number, or negative.
    #[error("the sky's {0} is not a finite, non-negative number")]
    Parameter(&'static str),
}

/// The sky as a function of direction: the picture's texels joined bilinearly, as the path tracer sees them.
///
/// Radiance above 1e30 counts as 1e30, so that sums of it stay finite. A direction `d` is looked up at `u = atan2(d.z, d.x)/2π + ½ + rotation/2π`, `v = ½ − asin(d.y)/π`; columns wrap,
/// rows end at the poles.
#[derive(Clone, Debug)]
pub struct SkyMap {
    image: Arc<Image>,
    scale: f32,
    turn: f32,
}

impl SkyMap {
    /// Prepares `environment`; a constant one becomes a picture of one pixel.
    ///
    /// # Errors
    /// [`BadSky`] when a radiance is not finite or negative, or the picture is no picture.
    pub fn new(environment: &Environment) -> Result<Self, BadSky> {
        let (image, rotation, intensity) = match environment {
            Environment::Constant(c) => {
                if !(c.is_finite() && c.min_element() >= 0.0) {
                    return Err(BadSky::Parameter("colour"));
                }
                let pixels = Pixels::F32(c.to_array().to_vec());
                (Arc::new(Image { width: 1, height: 1, channels: 3, pixels }), 0.0, 1.0)
            }
            Environment::LatLong { image, rotation, intensity } => (image.clone(), *rotation, *intensity),
        };
        if !(intensity.is_finite() && intensity >= 0.0) {
            return Err(BadSky::Parameter("intensity"));
        }
        if !rotation.is_finite() {
            return Err(BadSky::Parameter("rotation"));
        }
        let samples = match &image.pixels {
            Pixels::U8(p) => p.len(),
            Pixels::U16(p) => p.len(),
            Pixels::F32(p) => p.len(),
        };
        if image.is_empty() || samples != image.len() {
            return Err(BadSky::Size { width: image.width, height: image.height, samples });
        }
        if let Pixels::F32(p) = &image.pixels {
            let bad = |v: &f32| !(*v >= 0.0 && *v * intensity < f32::INFINITY);
            if let Some(i) = p.par_iter().position_first(bad) {
                let pixel = i / image.channels as usize;
                let (x, y) = ((pixel % image.width as usize) as u32, (pixel / image.width as usize) as u32);
                return Err(BadSky::Pixel { x, y, value: p[i] });
            }
        }
        let turn = (f64::from(rotation) / std::f64::consts::TAU).rem_euclid(1.0) as f32;
        Ok(Self { image, scale: intensity, turn })
    }

    /// Columns of the picture.
    pub fn width(&self) -> usize {
        self.image.width as usize
    }

    /// Rows of the picture.
    pub fn height(&self) -> usize {
        self.image.height as usize
    }

    /// What is added to u, in turns.
    pub fn turn(&self) -> f32 {
        self.turn
    }

    /// Radiance of the texel in column `x` and row `y`.
    #[inline]
    pub fn texel(&self, x: usize, y: usize) -> Spectrum {
        let n = self.image.channels as usize;
        if let Pixels::F32(p) = &self.image.pixels
            && n >= 3
        {
            let at = (y * self.width() + x) * n;
            return Spectrum::rgb(p[at], p[at + 1], p[at + 2]).map(|v| (v * self.scale).min(BRIGHTEST));
        }
        let c = |c: u8| self.image.sample(x as u32, y as u32, if n < 3 { 0 } else { c });
        Spectrum::rgb(c(0), c(1), c(2)).map(|v| (v * self.scale).min(BRIGHTEST))
    }

    /// Radiance from the direction `d` (unit), bilinear.
    pub fn radiance(&self, d: Vec3A) -> Spectrum {
        let u = atan2_turns(d.z, d.x) + 0.5 + self.turn;
        self.bilinear(u, acos(d.y) * FRAC_1_PI)
    }

    /// Radiance at picture coordinates, `u` in 0..2 (it wraps) and `v` in 0..1.
    pub fn bilinear(&self, u: f32, v: f32) -> Spectrum {
        let (w, h) = (self.width(), self.height());
        let (x, y) = (u * w as f32 + (w as f32 - 0.5), v * h as f32 + 0.5);
        // Both are at least 0 up to rounding: one turn and one row were added.
        let (ix, iy) = (x as usize, y as usize);
        let (tx, ty) = (x - ix as f32, y - iy as f32);
        let (x0, x1) = (ix % w, (ix + 1) % w);
        let (y0, y1) = (iy.saturating_sub(1).min(h - 1), iy.min(h - 1));
        self.texel(x0, y0)
            .lerp(self.texel(x1, y0), tx)
            .lerp(self.texel(x0, y1).lerp(self.texel(x1, y1), tx), ty)
    }

    /// True if no light comes from anywhere.
    pub fn is_black(&self) -> bool {
        (0..self.height()).into_par_iter().all(|y| (0..self.width()).all(|x| self.texel(x, y).is_black()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn picture(w: u32, h: u32, f: impl Fn(u32, u32) -> f32) -> Image {
        let pixels = (0..w * h).flat_map(|i| [f(i % w, i / w); 3]).collect();
        Image { width: w, height: h, channels: 3, pixels: Pixels::F32(pixels) }
    }

    fn sky(image: Image, rotation: f32) -> SkyMap {
        SkyMap::new(&Environment::LatLong { image: Arc::new(image), rotation, intensity: 2.0 }).unwrap()
    }

    /// The picture's centre is +X, three quarters is +Z, the first row +Y; a turn of a quarter brings +X to −Z.
    #[test]
    fn directions_follow_the_convention() {
        let column = |c: u32| move |x: u32, _: u32| if x == c { 1.0 } else { 0.0 };
        // With an odd width the middle column is centred on +X.
        assert_eq!(sky(picture(5, 3, column(2)), 0.0).radiance(Vec3A::X)[0], 2.0);
        let quarter = std::f32::consts::FRAC_PI_2;
        assert!((sky(picture(5, 3, column(2)), quarter).radiance(Vec3A::NEG_Z)[0] - 2.0).abs() < 1e-4);
        let z = sky(picture(8, 3, |x, _| x as f32), 0.0).radiance(Vec3A::Z)[0];
        assert!((z - 2.0 * (0.75 * 8.0 - 0.5)).abs() < 1e-3, "{z}");
        assert_eq!(sky(picture(4, 4, |_, y| y as f32), 0.0).radiance(Vec3A::Y)[0], 0.0);
        assert_eq!(sky(picture(4, 4, |_, y| y as f32), 0.0).radiance(Vec3A::NEG_Y)[0], 6.0);
    }

    #[test]
    fn bad_skies_are_refused() {
        for bad in [f32::NAN, -1.0, f32::INFINITY] {
            let image = picture(4, 2, |x, y| if (x, y) == (3, 1) { bad } else { 1.0 });
            let e =
                SkyMap::new(&Environment::LatLong { image: Arc::new(image), rotation: 0.0, intensity: 1.0 });
            assert!(matches!(e, Err(BadSky::Pixel { x: 3, y: 1, .. })), "{e:?}");
            assert!(SkyMap::new(&Environment::Constant(Vec3::splat(bad))).is_err());
            if bad != -1.0 {
                let image = Arc::new(picture(4, 2, |_, _| 1.0));
                let e = SkyMap::new(&Environment::LatLong { image, rotation: bad, intensity: 1.0 });
                assert_eq!(e.unwrap_err(), BadSky::Parameter("rotation"));
            }
        }
    }

    #[test]
    fn one_pixel_is_a_constant() {
        let s = sky(picture(1, 1, |_, _| 0.5), 1.0);
        for d in [Vec3A::X, Vec3A::NEG_Y, Vec3A::new(0.6, 0.0, -0.8)] {
            assert_eq!(s.radiance(d).to_rgb(), [1.0; 3]);
        }
        assert!(!s.is_black() && sky(picture(2, 1, |_, _| 0.0), 0.0).is_black());
    }
}

/// Skies for tests of this room.
#[cfg(test)]
pub(crate) mod tests_support {
    use super::*;

    /// A picture by column and row, turned.
    pub(crate) fn lat_long(w: u32, h: u32, rotation: f32, f: impl Fn(u32, u32) -> [f32; 3]) -> SkyMap {
        let pixels = Pixels::F32((0..w * h).flat_map(|i| f(i % w, i / w)).collect());
        let image = Arc::new(Image { width: w, height: h, channels: 3, pixels });
        SkyMap::new(&Environment::LatLong { image, rotation, intensity: 1.0 }).unwrap()
    }
}
