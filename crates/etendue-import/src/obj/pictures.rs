//! The pictures of materials: read and decoded once each, and joined where glTF wants in one what MTL has in several.

use super::library::{Map, read};
use crate::error::Fault;
use crate::limits::shown as shown_bytes;
use crate::source::Source;
use crate::text::shown;
use crate::texture::Decoded;
use crate::warning::Warnings;
use etendue_image::{Image, Pixels};
use rayon::prelude::*;
use std::collections::HashMap;
use std::sync::Arc;

/// Decoded files by folder and name.
pub(super) struct Pictures {
    files: HashMap<(Vec<u8>, Vec<u8>), Decoded>,
}

impl Pictures {
    /// Reads the files of `maps`, in parallel. One that cannot be read or decoded is named in a warning and left out.
    pub fn load(maps: &[(&Map, &str)], source: &Source<'_>, warnings: &mut Warnings) -> Result<Self, Fault> {
        let mut wanted: Vec<(&Map, &str)> = Vec::new();
        let mut seen = std::collections::HashSet::new();
        for m in maps {
            if seen.insert((&m.0.folder, &m.0.file)) {
                wanted.push(*m);
            }
        }
        let (allowed, limit) = source.limits.for_images(source.used);
        let results: Vec<Result<Decoded, String>> = wanted
            .par_iter()
            .map(|(m, _)| {
                let bytes = read(source, &places(m).iter().map(|p| &p[..]).collect::<Vec<_>>(), "picture")?;
                let image = source
                    .decode(&bytes, allowed)
                    .map_err(|e| format!("the picture `{}` cannot be decoded: {e}", shown(&m.file)))?;
                Ok(source.decoded(Arc::new(image), bytes))
            })
            .collect();
        let mut files = HashMap::new();
        let mut total = 0u64;
        for ((m, place), r) in wanted.iter().zip(results) {
            match r {
                Ok(d) => {
                    total = total.saturating_add(d.image.bytes() as u64);
                    if total > allowed {
                        let what = format!("its pictures decode to more than {}", shown_bytes(allowed));
                        return Err(Fault::TooLarge { pointer: (*place).into(), what, limit });
                    }
                    files.insert((m.folder.clone(), m.file.clone()), d);
                }
                Err(why) => warnings.add(*place, format!("{why}; shown without")),
            }
        }
        Ok(Self { files })
    }

    /// The picture of `map`, if it could be read.
    pub fn get(&self, map: Option<&Map>) -> Option<&Decoded> {
        let map = map?;
        self.files.get(&(map.folder.clone(), map.file.clone()))
    }
}

/// Where a picture may be: beside the library, beside the model, and, for paths of another machine, under its last name in both.
fn places(m: &Map) -> Vec<Vec<u8>> {
    let join = |name: &[u8]| [&m.folder[..], name].concat();
    let last = m.file.rsplit(|b| matches!(b, b'/' | b'\\')).next().unwrap_or(&m.file);
    let mut out = vec![join(&m.file), m.file.clone(), join(last), last.to_vec()];
    out.dedup();
    out
}

/// One channel of a picture.
#[derive(Clone)]
pub(super) struct Channel {
    pub image: Arc<Image>,
    pub which: Which,
}

/// Which number of a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Which {
    /// Channel by number.
    One(u8),
    /// Mean of the colours.
    Mean,
}

impl Channel {
    /// What `map` asks for of its picture: a colour or alpha by `-imfchan`, else the mean of the colours.
    pub fn new(image: &Arc<Image>, map: &Map) -> Self {
        let colors = color_channels(image);
        let which = match map.channel {
            Some(b'r') => Which::One(0),
            Some(b'g') if colors == 3 => Which::One(1),
            Some(b'b') if colors == 3 => Which::One(2),
            Some(b'm') if image.channels > colors => Which::One(colors),
            _ => Which::Mean,
        };
        Self { image: image.clone(), which }
    }

    fn at(&self, x: u32, y: u32) -> f32 {
        match self.which {
            Which::One(c) => self.image.sample(x, y, c),
            Which::Mean => {
                let n = color_channels(&self.image);
                (0..n).map(|c| self.image.sample(x, y, c)).sum::<f32>() / f32::from(n)
            }
        }
    }

    /// The value at a pixel of a picture of `size`, which may differ from this one's: the nearest one's.
    fn scaled(&self, x: u32, y: u32, size: (u32, u32)) -> f32 {
        let near =
            |i: u32, n: u32, of: u32| ((u64::from(2 * i + 1) * u64::from(of)) / (2 * u64::from(n))) as u32;
        self.at(near(x, size.0, self.image.width), near(y, size.1, self.image.height))
    }
}

/// 1 for grey, 3 for colours.
fn color_channels(i: &Image) -> u8 {
    if i.channels < 3 { 1 } else { 3 }
}

/// A picture whose pixels are made by `f`, as large as the largest of `from` and as deep as the deepest.
fn make(from: &[&Image], channels: u8, f: impl Fn(u32, u32, (u32, u32), &mut [f32]) + Sync) -> Image {
    let width = from.iter().map(|i| i.width).max().unwrap_or(1);
    let height = from.iter().map(|i| i.height).max().unwrap_or(1);
    let n = usize::from(channels);
    let row = width as usize * n;
    let fill = |line: &mut Vec<f32>, y: u32| {
        line.resize(row, 1.0);
        for (x, p) in line.chunks_exact_mut(n).enumerate() {
            f(x as u32, y, (width, height), p);
        }
    };
    let pixels = if from.iter().any(|i| !matches!(i.pixels, Pixels::U8(_))) {
        let mut data = vec![0u16; row * height as usize];
        data.par_chunks_mut(row).enumerate().for_each_init(Vec::new, |line, (y, out)| {
            fill(line, y as u32);
            out.iter_mut().zip(line).for_each(|(o, v)| *o = (*v * 65535.0 + 0.5) as u16);
        });
        Pixels::U16(data)
    } else {
        let mut data = vec![0u8; row * height as usize];
        data.par_chunks_mut(row).enumerate().for_each_init(Vec::new, |line, (y, out)| {
            fill(line, y as u32);
            out.iter_mut().zip(line).for_each(|(o, v)| *o = (*v * 255.0 + 0.5) as u8);
        });
        Pixels::U8(data)
    };
    Image { width, height, channels, pixels }
}

/// glTF's roughness (G) and metalness (B) from a channel each; where one is missing it is 1. `rough` is put through
/// `to_roughness`.
pub(super) fn metal_rough(
    rough: Option<&Channel>,
    metal: Option<&Channel>,
    to_roughness: impl Fn(f32) -> f32 + Sync,
) -> Image {
    let from: Vec<&Image> = [rough, metal].into_iter().flatten().map(|c| &*c.image).collect();
    make(&from, 3, |x, y, size, p| {
        p[0] = 1.0;
        p[1] = rough.map_or(1.0, |c| to_roughness(c.scaled(x, y, size)));
        p[2] = metal.map_or(1.0, |c| c.scaled(x, y, size));
    })
}

/// Colour with an alpha channel from elsewhere; white where there is no colour.
pub(super) fn with_alpha(color: Option<&Arc<Image>>, alpha: &Channel) -> Image {
    let mut from = vec![&*alpha.image];
    from.extend(color.map(|c| &**c));
    make(&from, 4, |x, y, size, p| {
        for k in 0..3 {
            p[usize::from(k)] = color.map_or(1.0, |i| {
                let which = Which::One(if color_channels(i) == 1 { 0 } else { k });
                Channel { image: i.clone(), which }.scaled(x, y, size)
            });
        }
        p[3] = alpha.scaled(x, y, size);
    })
}

/// A grey picture in R, G or A of an otherwise white one, wherever it is looked for.
pub(super) fn spread(value: &Channel) -> Image {
    make(&[&value.image], 4, |x, y, _, p| p.fill(value.at(x, y)))
}

/// True if a picture is a map of normals rather than of heights: mostly pointing out (blue), and coloured.
pub(super) fn is_normal_map(i: &Image) -> bool {
    if i.channels < 3 {
        return false;
    }
    let (mut sum, mut n, mut grey) = ([0.0f64; 3], 0.0, 0.0);
    // A grid of at most 256 × 256 tells.
    let step = |of: u32| (of / 256).max(1) as usize;
    for y in (0..i.height).step_by(step(i.height)) {
        for x in (0..i.width).step_by(step(i.width)) {
            let p = [0, 1, 2].map(|c| i.sample(x, y, c));
            grey += f64::from(u8::from((p[0] - p[1]).abs() < 0.02 && (p[1] - p[2]).abs() < 0.02));
            (0..3).for_each(|c| sum[c] += f64::from(p[c]));
            n += 1.0;
        }
    }
    let [r, g, b] = sum.map(|s| s / n);
    let middle = 0.3..0.7;
    middle.contains(&r) && middle.contains(&g) && b > 0.6 && grey < 0.9 * n
}

/// Normals of a height map whose full range is `depth` of the picture's width.
///
/// With heights h and texels of side 1/width the normal is along (−∂h/∂x, −∂h/∂y, 1); differences are central, and the
/// picture repeats or is continued by its edge.
pub(super) fn normals_of_heights(height: &Channel, depth: f32, clamp: bool) -> Image {
    let (w, h) = (height.image.width, height.image.height);
    let step = |i: u32, n: u32, by: i64| {
        let k = i64::from(i) + by;
        (if clamp { k.clamp(0, i64::from(n) - 1) } else { k.rem_euclid(i64::from(n)) }) as u32
    };
    let slope = 0.5 * depth * w as f32;
    make(&[&height.image], 3, |x, y, _, p| {
        let dx = height.at(step(x, w, 1), y) - height.at(step(x, w, -1), y);
        // Up on the picture is towards smaller rows.
        let dy = height.at(x, step(y, h, -1)) - height.at(x, step(y, h, 1));
        let n = glam::Vec3::new(-dx * slope, -dy * slope, 1.0).normalize();
        p.copy_from_slice(&(n * 0.5 + 0.5).to_array());
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(width: u32, height: u32, v: &[u8]) -> Arc<Image> {
        Arc::new(Image { width, height, channels: 1, pixels: Pixels::U8(v.to_vec()) })
    }
    fn all(image: Arc<Image>) -> Channel {
        Channel { image, which: Which::Mean }
    }

    #[test]
    fn channels_are_joined_at_the_larger_size() {
        let (rough, metal) = (all(grey(2, 1, &[10, 20])), all(grey(4, 2, &[0, 1, 2, 3, 4, 5, 6, 7])));
        let i = metal_rough(Some(&rough), Some(&metal), |v| v);
        assert_eq!((i.width, i.height, i.channels), (4, 2, 3));
        let Pixels::U8(p) = i.pixels else { panic!() };
        let expected = [10, 10, 20, 20, 10, 10, 20, 20].iter().zip(0u8..).flat_map(|(&r, m)| [255, r, m]);
        assert_eq!(p, expected.collect::<Vec<_>>());
    }

    #[test]
    fn a_slope_bends_the_normal_against_it() {
        // Rising to the right by 51 of 255 per texel; full range is half of the width of 5.
        let ramp = all(grey(5, 1, &[0, 51, 102, 153, 204]));
        let i = normals_of_heights(&ramp, 0.5, true);
        let n: Vec<f32> = (0..3).map(|c| i.sample(2, 0, c) * 2.0 - 1.0).collect();
        // Slope 0.2 × 2.5 = 0.5.
        let expected = glam::Vec3::new(-0.5, 0.0, 1.0).normalize();
        for (a, b) in n.iter().zip(expected.to_array()) {
            assert!((a - b).abs() < 0.008, "{n:?} {expected}");
        }
        // Rising upward: the normal leans down, to −y.
        let up = all(grey(1, 3, &[200, 100, 0]));
        assert!(normals_of_heights(&up, 0.5, true).sample(0, 1, 1) < 0.45);
        assert!(!is_normal_map(&grey(1, 1, &[128])));
        assert!(is_normal_map(&i));
    }
}
