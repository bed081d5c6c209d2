//! Pages of pictures with something under each.

use super::output::count;
use super::sheet_args::Names;
use crate::lab::draw::{Anchor, Drawing, GREY, INK, Item, LETTER, Rgb};
use std::path::{Path, PathBuf};

/// One model on a page.
pub(crate) struct Cell {
    /// What it is called.
    pub name: String,
    /// Rows of sRGB pixels, or why there are none.
    pub picture: Result<Vec<Rgb>, String>,
    /// Kinds of warnings.
    pub warnings: usize,
    /// Triangles that are shown.
    pub triangles: u64,
}

/// How pages are laid out.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layout {
    /// Width and height of a picture.
    pub cell: u32,
    pub columns: u32,
    /// Rows on a page.
    pub rows: u32,
}

/// Between pictures, and around all of them.
const GAP: u32 = 12;
/// Height of a line of text.
const LINE: u32 = 19;
/// What lies under a picture: its name, what there is to say, and some room.
const UNDER: u32 = 2 * LINE + 10;
/// Something is wrong.
const RED: Rgb = [0xb0, 0x1c, 0x1c];
/// Something may be wrong.
const ORANGE: Rgb = [0xb3, 0x5c, 0x00];
/// Behind an error.
const PALE_RED: Rgb = [0xfb, 0xea, 0xea];
/// Most pixels of a page.
const MOST_PIXELS: u64 = 1 << 26;

impl Layout {
    fn width(&self) -> u32 {
        self.columns * (self.cell + GAP) + GAP
    }

    fn row_height(&self) -> u32 {
        self.cell + UNDER
    }

    /// Models on a page: as many as were asked for, if it does not grow too large.
    pub fn per_page(&self) -> usize {
        let most = MOST_PIXELS / u64::from(self.width()) / u64::from(self.row_height());
        let rows = u64::from(self.rows).min(most).max(1);
        rows as usize * self.columns as usize
    }

    /// A page, as high as it has to be.
    pub fn page(&self, cells: &[Cell]) -> Drawing {
        let rows = (cells.len() as u32).div_ceil(self.columns).max(1);
        let mut d = Drawing::new(self.width(), rows * self.row_height() + GAP);
        for (i, cell) in cells.iter().enumerate() {
            let (column, row) = (i as u32 % self.columns, i as u32 / self.columns);
            let at = [GAP + column * (self.cell + GAP), GAP + row * self.row_height()].map(|v| v as f32);
            self.draw(&mut d, at, cell);
        }
        d
    }

    fn draw(&self, d: &mut Drawing, at: [f32; 2], cell: &Cell) {
        let side = self.cell as f32;
        let letters = (side / LETTER) as usize;
        let under = |line: u32| [at[0], at[1] + side + (line * LINE) as f32 + 0.5 * LINE as f32];
        d.text(under(0), shorten(&cell.name, letters), INK, Anchor::Start);
        let (note, color) = match (&cell.picture, cell.warnings) {
            (Err(_), _) => ("failed".into(), RED),
            (Ok(_), 1) => ("1 warning".into(), ORANGE),
            (Ok(_), n @ 2..) => (format!("{n} warnings"), ORANGE),
            (Ok(_), 0) if cell.triangles == 0 => ("shows no triangles".into(), GREY),
            (Ok(_), 0) => (format!("{} triangles", count(cell.triangles as f64)), GREY),
        };
        d.text(under(1), shorten(&note, letters), color, Anchor::Start);
        match &cell.picture {
            Ok(pixels) => d.items.push(Item::Picture {
                at,
                size: [side; 2],
                cells: [self.cell as usize; 2],
                pixels: pixels.iter().copied().map(Some).collect(),
            }),
            Err(why) => {
                d.rectangle(at, [side; 2], PALE_RED);
                let most = ((side - 16.0) / LINE as f32) as usize;
                for (i, line) in lines(why, letters - 2).into_iter().take(most).enumerate() {
                    let y = at[1] + 8.0 + (i as f32 + 0.5) * LINE as f32;
                    d.text([at[0] + LETTER, y], line, RED, Anchor::Start);
                }
            }
        }
    }
}

/// The first line of `text`, broken at `most` letters.
fn lines(text: &str, most: usize) -> Vec<String> {
    let letters: Vec<char> = text.lines().next().unwrap_or_default().chars().collect();
    let mut out = Vec::new();
    let mut rest = &letters[..];
    while !rest.is_empty() {
        let fits = rest.len().min(most.max(1));
        // Between words if there is such a place in the second half.
        let space =
            rest[..fits].iter().rposition(|c| *c == ' ').filter(|p| rest.len() > fits && 2 * p > fits);
        let (line, after) = rest.split_at(space.unwrap_or(fits));
        out.push(line.iter().collect());
        rest = after.strip_prefix(&[' ']).unwrap_or(after);
    }
    out
}

/// `text` in at most `most` letters: what is too much is left out of the middle.
fn shorten(text: &str, most: usize) -> String {
    let letters: Vec<char> = text.chars().collect();
    if letters.len() <= most || most < 5 {
        return letters.into_iter().take(most).collect();
    }
    let kept = most - 2;
    let (front, back) = (kept.div_ceil(2), kept / 2);
    let part = |range: std::ops::Range<usize>| letters[range].iter().collect::<String>();
    format!("{}..{}", part(0..front), part(letters.len() - back..letters.len()))
}

/// What stands under the pictures: file names without extensions, with more of the path where two would be alike.
pub(crate) fn titles(files: &[PathBuf], names: Names) -> Vec<String> {
    let path = |p: &Path| p.with_extension("").display().to_string();
    let short: Vec<String> = match names {
        Names::Path => return files.iter().map(|p| path(p)).collect(),
        Names::File => {
            files.iter().map(|p| p.file_stem().unwrap_or_default().to_string_lossy().into()).collect()
        }
    };
    let mut seen = std::collections::HashMap::new();
    short.iter().for_each(|s| *seen.entry(s.as_str()).or_insert(0) += 1);
    let title = |(p, s): (&PathBuf, &String)| match p.parent().and_then(Path::file_name) {
        Some(folder) if seen[s.as_str()] > 1 => match folder.to_string_lossy() {
            // A folder that is named after its model tells enough.
            f if f.contains(s.as_str()) => f.into_owned(),
            f => format!("{f}/{s}"),
        },
        _ => s.clone(),
    };
    files.iter().zip(&short).map(title).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cell(picture: Result<Vec<Rgb>, String>) -> Cell {
        Cell { name: "name".into(), picture, warnings: 0, triangles: 1 }
    }

    #[test]
    fn pictures_stand_beside_and_below_one_another() {
        let layout = Layout { cell: 32, columns: 2, rows: 3 };
        assert_eq!(layout.per_page(), 6);
        let colors: [Rgb; 3] = [[255, 0, 0], [0, 255, 0], [0, 0, 255]];
        let cells: Vec<Cell> = colors.map(|c| cell(Ok(vec![c; 32 * 32]))).into();
        let d = layout.page(&cells);
        assert_eq!((d.width, d.height), (2 * 44 + 12, 2 * 80 + 12));
        let places: Vec<[f32; 2]> = d
            .items
            .iter()
            .filter_map(|i| match i {
                Item::Picture { at, .. } => Some(*at),
                _ => None,
            })
            .collect();
        assert_eq!(places, [[12.0, 12.0], [56.0, 12.0], [12.0, 92.0]]);
        let huge = Layout { cell: 2048, columns: 64, rows: 256 };
        assert_eq!(huge.per_page(), 64, "a page is bounded");
    }

    #[test]
    fn what_fails_says_why_in_its_place() {
        let layout = Layout { cell: 128, columns: 1, rows: 1 };
        let d = layout.page(&[cell(Err("byte 0: the file is empty\nmore".into()))]);
        let texts: Vec<&str> = d
            .items
            .iter()
            .filter_map(|i| match i {
                Item::Text { text, .. } => Some(text.as_str()),
                _ => None,
            })
            .collect();
        assert_eq!(texts, ["name", "failed", "byte 0: the", "file is empty"]);
    }

    #[test]
    fn names_are_short_and_tell_files_apart() {
        assert_eq!(shorten("abcdefghij", 10), "abcdefghij");
        assert_eq!(shorten("abcdefghijk", 9), "abcd..ijk");
        assert_eq!(lines("abcdefgh", 3), ["abc", "def", "gh"]);
        let files = ["a/scene.glb", "b/scene.glb", "Duck-2/Duck.gltf", "Duck/Duck.glb", "c/Box.ply"]
            .map(PathBuf::from);
        assert_eq!(titles(&files, Names::File), ["a/scene", "b/scene", "Duck-2", "Duck", "Box"]);
        let paths = ["a/scene", "b/scene", "Duck-2/Duck", "Duck/Duck", "c/Box"];
        assert_eq!(titles(&files, Names::Path), paths);
    }
}
