//! How a picture shows all directions.

use crate::{Image, ImageError, Pixels};
use std::fmt;
use std::str::FromStr;

/// How the six sides of a cube, or the sphere, lie in a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SkyLayout {
    /// Longitude to the right, latitude down.
    LatLong,
    /// Six faces below one another, or beside one another: +X, −X, +Y, −Y, +Z, −Z, oriented as graphics processors take them (OpenGL
    /// 4.6, table 8.19), what texture tools write.
    Strip,
    /// The same order, each face as it is seen from inside: OpenEXR's `envmap = cube` (`ImfEnvmap.h`).
    StripExr,
    /// A cross unfolded as the cube is seen from inside, 4 × 3 faces or 3 × 4: −Z in the middle, +X to its right, +Y above; at the
    /// right end, or upside down at the lower end, +Z. What photographs of surroundings come as: letters can be read.
    Cross,
    /// A cross of faces oriented as graphics processors take them: +Z in the middle, +X to its right, +Y above, −Z at the end. What
    /// texture tools write: letters are mirrored.
    CrossTexture,
}

impl SkyLayout {
    /// Every layout.
    pub const ALL: [Self; 5] = [Self::LatLong, Self::Strip, Self::StripExr, Self::Cross, Self::CrossTexture];

    fn name(self) -> &'static str {
        match self {
            Self::LatLong => "latlong",
            Self::Strip => "strip",
            Self::StripExr => "strip-exr",
            Self::Cross => "cross",
            Self::CrossTexture => "cross-texture",
        }
    }
}

impl fmt::Display for SkyLayout {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for SkyLayout {
    type Err = String;

    fn from_str(s: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|l| l.name() == s).ok_or_else(|| {
            let names = Self::ALL.map(Self::name).join(", ");
            format!("no layout is called {s:?}; there are {names}")
        })
    }
}

/// A cell of a cross: column, row, the face in it, and whether that stands on its head.
type Cell = (u32, u32, usize, bool);

const ACROSS: [Cell; 6] = [
    (2, 1, 0, false),
    (0, 1, 1, false),
    (1, 0, 2, false),
    (1, 2, 3, false),
    (1, 1, 4, false),
    (3, 1, 5, false),
];
const UPRIGHT: [Cell; 6] = [
    (2, 1, 0, false),
    (0, 1, 1, false),
    (1, 0, 2, false),
    (1, 2, 3, false),
    (1, 1, 4, false),
    (1, 3, 5, true),
];

/// Columns, rows and cells of a picture that can be a cross; `None` for other sizes.
fn cross(image: &Image) -> Option<([u32; 2], &'static [Cell; 6])> {
    let is = |c: u32, r: u32| {
        image.width.is_multiple_of(c) && image.height.is_multiple_of(r) && image.width / c == image.height / r
    };
    if is(4, 3) {
        Some(([4, 3], &ACROSS))
    } else if is(3, 4) {
        Some(([3, 4], &UPRIGHT))
    } else {
        None
    }
}

/// The layout that a picture seems to have: a strip by its size, a cross by its size and its empty corners.
pub(super) fn detect(image: &Image) -> SkyLayout {
    let (w, h) = (u64::from(image.width), u64::from(image.height));
    if h == 6 * w || w == 6 * h {
        return SkyLayout::Strip;
    }
    let Some(([columns, rows], cells)) = cross(image) else { return SkyLayout::LatLong };
    let n = image.width / columns;
    let first = [0, 1, 2].map(|c| image.sample(0, 0, c));
    let empty = |column: u32, row: u32| {
        (0..n * n).all(|i| {
            let (x, y) = (column * n + i % n, row * n + i / n);
            // Lossy compression leaves traces.
            (0..3).all(|c| (image.sample(x, y, c) - first[usize::from(c)]).abs() <= 0.01)
        })
    };
    let filled = |column, row| cells.iter().any(|c| (c.0, c.1) == (column, row));
    let corners = (0..columns * rows).map(|i| (i % columns, i / columns));
    if corners.filter(|&(x, y)| !filled(x, y)).all(|(x, y)| empty(x, y)) {
        SkyLayout::Cross
    } else {
        SkyLayout::LatLong
    }
}

/// The six faces of a picture that shows a cube, as graphics processors take them.
pub(super) fn faces(image: &Image, layout: SkyLayout) -> Result<Vec<Image>, ImageError> {
    let (w, h) = (image.width, image.height);
    let wrong = || {
        let wanted = match layout {
            SkyLayout::Strip | SkyLayout::StripExr => "six square faces in a column or a row",
            _ => "4 × 3 or 3 × 4 square faces",
        };
        let feature = format!("{w} × {h} pixels as the layout {layout}, which has {wanted},");
        Err(ImageError::unsupported("a picture", feature))
    };
    match layout {
        SkyLayout::LatLong => wrong(),
        SkyLayout::Strip | SkyLayout::StripExr => {
            let (n, step) = if u64::from(h) == 6 * u64::from(w) {
                (w, [0, 1])
            } else if u64::from(w) == 6 * u64::from(h) {
                (h, [1, 0])
            } else {
                return wrong();
            };
            let all = (0..6).map(|f| cut(image, n, step[0] * f, step[1] * f)).collect();
            Ok(if layout == SkyLayout::StripExr { turned(all) } else { all })
        }
        SkyLayout::Cross | SkyLayout::CrossTexture => {
            let Some(([columns, _], cells)) = cross(image) else { return wrong() };
            let n = w / columns;
            let mut all: Vec<Image> = cells
                .iter()
                .map(|&(column, row, _, on_its_head)| {
                    let face = cut(image, n, column, row);
                    if on_its_head { mirrored(&face, true, true) } else { face }
                })
                .collect();
            if layout == SkyLayout::Cross {
                // The same cube with its Z axis reversed.
                all = turned(all);
                all.swap(4, 5);
            }
            Ok(all)
        }
    }
}

/// Faces seen from inside against those of textures: the sides left to right, top and bottom upside down.
pub(super) fn turned(faces: Vec<Image>) -> Vec<Image> {
    faces.iter().enumerate().map(|(i, f)| mirrored(f, i / 2 != 1, i / 2 == 1)).collect()
}

/// The cell of `n`² pixels in a column and row of such cells.
fn cut(image: &Image, n: u32, column: u32, row: u32) -> Image {
    let mut out = Vec::with_capacity(3 * (n * n) as usize);
    for y in 0..n {
        for x in 0..n {
            out.extend([0, 1, 2].map(|c| image.sample(column * n + x, row * n + y, c)));
        }
    }
    Image { width: n, height: n, channels: 3, pixels: Pixels::F32(out) }
}

fn mirrored(face: &Image, columns: bool, rows: bool) -> Image {
    let n = face.width;
    let at = |i: u32, turn: bool| if turn { n - 1 - i } else { i };
    let mut out = Vec::with_capacity(face.len());
    for y in 0..n {
        for x in 0..n {
            out.extend([0, 1, 2].map(|c| face.sample(at(x, columns), at(y, rows), c)));
        }
    }
    Image { width: n, height: n, channels: 3, pixels: Pixels::F32(out) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(width: u32, height: u32, f: impl Fn(u32, u32) -> f32) -> Image {
        let pixels = (0..width * height).flat_map(|i| [f(i % width, i / width); 3]).collect();
        Image { width, height, channels: 3, pixels: Pixels::F32(pixels) }
    }

    #[test]
    fn layouts_are_told_by_size_and_corners() {
        let busy = |x: u32, y: u32| 0.1 * (x + 3 * y) as f32;
        assert_eq!(detect(&picture(8, 4, busy)), SkyLayout::LatLong);
        assert_eq!(detect(&picture(4, 24, busy)), SkyLayout::Strip);
        assert_eq!(detect(&picture(24, 4, busy)), SkyLayout::Strip);
        assert_eq!(detect(&picture(16, 12, busy)), SkyLayout::LatLong, "no empty corners");
        let across = |x: u32, y: u32| if y / 4 == 1 || x / 4 == 1 { 1.0 + busy(x, y) } else { 0.005 };
        assert_eq!(detect(&picture(16, 12, across)), SkyLayout::Cross);
        assert_eq!(detect(&picture(12, 16, across)), SkyLayout::Cross);
        for l in SkyLayout::ALL {
            assert_eq!(l.to_string().parse(), Ok(l));
        }
        assert!("sphere".parse::<SkyLayout>().unwrap_err().contains("cross-texture"));
        let e = faces(&picture(9, 9, busy), SkyLayout::Cross).unwrap_err().to_string();
        assert!(e.contains("9 × 9") && e.contains("4 × 3"), "{e}");
    }
}
