//! IES profiles: how a lamp was measured to shine (ANSI/IES LM-63, editions of 1986, 1991, 1995, 2002 and 2019).

mod gltf;
mod write;

use crate::source::{ReadError, read_file};
use crate::text::{Lines, number, shown};
use etendue_scene::{LightProfile, Web};
use std::path::Path;

pub(crate) use gltf::{Loaded, light, load};
pub use write::write_ies;

/// The largest file that is read, bytes: the largest grid of whole degrees takes less than one million.
const MOST_BYTES: u64 = 16 << 20;

/// A file that was read.
#[derive(Clone, Debug, PartialEq)]
pub struct IesFile {
    /// Candela by direction, factors of lamp and ballast included.
    pub profile: LightProfile,
    /// The lines of text before the measurements, as they stand.
    pub labels: Vec<String>,
    /// Lumens of the lamps in the luminaire, if the file says (relative photometry); −1 in the file stands for not.
    pub lamp_lumens: Option<f64>,
    /// What was mended or left out, each a sentence.
    pub notes: Vec<String>,
}

/// Why a file is no IES profile.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: {message}")]
pub struct IesError {
    /// From 1; the last one if the file ends too early.
    pub line: u64,
    /// What is wrong there.
    pub message: String,
}

/// Reads an IES profile from a file.
///
/// # Errors
/// A sentence with the file's name.
pub fn read_ies(path: &Path) -> Result<IesFile, String> {
    let bytes = read_file(path, MOST_BYTES).map_err(|e| match e {
        ReadError::Io(e) => format!("cannot read {}: {e}", path.display()),
        ReadError::TooLarge(n) => format!("{}: {n} bytes are no IES profile", path.display()),
    })?;
    parse_ies(&bytes).map_err(|e| format!("{}: {e}", path.display()))
}

/// Numbers of a text, separated by white space or commas, with their lines.
struct Numbers<'a> {
    lines: Lines<'a>,
    line: u64,
    /// Of the current line, in reverse.
    words: Vec<Vec<u8>>,
}

impl Numbers<'_> {
    fn fault<T>(&self, message: impl Into<String>) -> Result<T, IesError> {
        Err(IesError { line: self.line, message: message.into() })
    }

    fn next(&mut self, what: &str) -> Result<f64, IesError> {
        while self.words.is_empty() {
            let Some((n, line)) = self.lines.next() else {
                return self.fault(format!("the file ends where {what} should stand"));
            };
            self.line = n;
            let is_gap = |b: &u8| b.is_ascii_whitespace() || matches!(b, b',' | 0x1a);
            self.words = line.split(is_gap).filter(|w| !w.is_empty()).map(<[u8]>::to_vec).rev().collect();
        }
        let word = self.words.pop().unwrap_or_default();
        match number::<f64>(&word).filter(|v| v.is_finite()) {
            Some(v) => Ok(v),
            None => self.fault(format!("`{}` is no number where {what} should stand", shown(&word))),
        }
    }

    fn count(&mut self, what: &str) -> Result<usize, IesError> {
        let v = self.next(what)?;
        if v.fract() == 0.0 && (1.0..=100_000.0).contains(&v) {
            Ok(v as usize)
        } else {
            self.fault(format!("{what} is {v}"))
        }
    }

    fn list(&mut self, count: usize, what: &str) -> Result<Vec<f32>, IesError> {
        // Not allocated at once: what a count claims has to be there.
        (0..count).map(|_| self.next(what).map(|v| v as f32)).collect()
    }
}

/// Reads an IES profile.
///
/// Candela are multiplied by the file's multiplier, the ballast factor and, before 2002, the ballast-lamp factor. Symmetries are
/// unfolded. What a tilted lamp loses (`TILT=INCLUDE` or a file) is not applied; a note says so.
///
/// # Errors
/// [`IesError`] with the line.
pub fn parse_ies(bytes: &[u8]) -> Result<IesFile, IesError> {
    let mut lines = Lines::new(bytes);
    let (mut labels, mut notes, mut last) = (Vec::new(), Vec::new(), 0);
    let mut tilt = None;
    // Labels of any number, until the line that says how the lamp's tilt counts.
    for (n, line) in lines.by_ref() {
        last = n;
        let text = line.trim_ascii();
        if text.len() >= 5
            && text[..4].eq_ignore_ascii_case(b"TILT")
            && text[4..].trim_ascii_start().starts_with(b"=")
        {
            let value = text[4..].trim_ascii_start()[1..].trim_ascii();
            tilt = Some(String::from_utf8_lossy(value).to_ascii_uppercase());
            break;
        }
        if n > 10_000 {
            break;
        }
        labels.push(shown(text));
    }
    let Some(tilt) = tilt else {
        return Err(IesError { line: last, message: "no IES profile: there is no line `TILT=`".into() });
    };
    let mut n = Numbers { lines, line: last, words: Vec::new() };
    match tilt.as_str() {
        "NONE" | "" => {}
        "INCLUDE" => {
            n.next("the geometry of the lamp")?;
            let pairs = n.count("the number of tilts")?;
            n.list(pairs, "a tilt")?;
            n.list(pairs, "the factor of a tilt")?;
            notes.push("what the lamps lose when they are tilted is not applied".to_owned());
        }
        _ => notes
            .push("what the lamps lose when they are tilted stands in another file; not applied".to_owned()),
    }
    let lamps = n.next("the number of lamps")?;
    let lumens = n.next("the lumens of a lamp")?;
    let mut scale = n.next("the multiplier")?;
    let vertical = n.count("the number of vertical angles")?;
    let horizontal = n.count("the number of horizontal angles")?;
    let web = match n.next("the photometric type")? {
        1.0 => Web::C,
        2.0 => Web::B,
        3.0 => Web::A,
        other => return n.fault(format!("{other} is no photometric type: those are 1, 2 and 3")),
    };
    for what in ["the unit of length", "the width", "the length", "the height"] {
        n.next(what)?;
    }
    let ballast = n.next("the ballast factor")?;
    let second = n.next("the ballast-lamp factor")?;
    n.next("the power")?;
    scale *= ballast;
    // The place is reserved since 2002.
    let first = labels.first().map(String::as_str).unwrap_or_default();
    let since_2002 = ["2002", "2019"].iter().any(|y| first.contains(y));
    if !since_2002 {
        scale *= second;
    }
    if !(scale.is_finite() && scale > 0.0) {
        return n.fault(format!("the factors multiply to {scale}"));
    }
    let vertical = n.list(vertical, "a vertical angle")?;
    let horizontal = n.list(horizontal, "a horizontal angle")?;
    let mut candela = n.list(vertical.len().saturating_mul(horizontal.len()), "an intensity")?;
    let negative = candela.iter().filter(|c| **c < 0.0).count();
    if negative > 0 {
        notes.push(format!("{negative} intensities below 0 are taken as 0"));
    }
    candela.iter_mut().for_each(|c| *c = (f64::from(*c).max(0.0) * scale).min(1e30) as f32);
    let (horizontal, candela) = unfold(web, vertical.len(), horizontal, candela, &mut notes);
    match LightProfile::new(web, vertical, horizontal, candela) {
        Ok(profile) => {
            let lamp_lumens = (lumens > 0.0 && lamps > 0.0).then_some(lumens * lamps);
            Ok(IesFile { profile, labels, lamp_lumens, notes })
        }
        Err(e) => n.fault(e),
    }
}

/// The horizontal angles and intensities without symmetries: what the first and the last angle leave out is mirrored.
fn unfold(
    web: Web,
    rows: usize,
    horizontal: Vec<f32>,
    candela: Vec<f32>,
    notes: &mut Vec<String>,
) -> (Vec<f32>, Vec<f32>) {
    let mut planes: Vec<(f32, &[f32])> = horizontal.iter().copied().zip(candela.chunks_exact(rows)).collect();
    if planes.len() == 1 {
        // The same all around: where it stands does not count.
        return (vec![0.0], candela);
    }
    if !horizontal.is_sorted_by(|a, b| a < b) {
        return (horizontal, candela);
    }
    if web == Web::C && planes.iter().any(|p| !(0.0..=360.0).contains(&p.0)) {
        notes.push("horizontal angles outside of 0 to 360 are taken around".to_owned());
        planes.iter_mut().for_each(|p| p.0 = p.0.rem_euclid(360.0));
        planes.sort_by(|a, b| a.0.total_cmp(&b.0));
        planes.dedup_by(|a, b| a.0 == b.0);
    }
    let (first, last) = (planes[0].0, planes[planes.len() - 1].0);
    // The planes mirrored at `angle`, but those that meet themselves.
    let mirror = |planes: &mut Vec<(f32, &[f32])>, angle: f32| {
        let more: Vec<_> = planes.iter().filter(|p| p.0 != angle).map(|p| (2.0 * angle - p.0, p.1)).collect();
        planes.extend(more);
    };
    if web == Web::C {
        if first == 0.0 && last == 90.0 {
            mirror(&mut planes, 90.0);
        }
        if first == 90.0 && last == 270.0 {
            // About the plane of 90 and 270 degrees (1995): 80 is as 100, 280 as 260.
            let more: Vec<_> = planes.iter().map(|p| ((540.0 - p.0) % 360.0, p.1)).collect();
            planes.extend(more.into_iter().filter(|m| !(90.0..=270.0).contains(&m.0)));
        } else if first == 0.0 && (last == 90.0 || last == 180.0) {
            mirror(&mut planes, 180.0);
        } else if last < 180.0 || first > 0.0 {
            notes.push(format!("horizontal angles from {first} to {last}: the rest is filled in between"));
        }
        // All around without saying so: the gap is closed.
        planes.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (a, b) = (planes[0], planes[planes.len() - 1]);
        if a.0 > 0.0 {
            planes.push((b.0 - 360.0, b.1));
        }
        if a.0 > 0.0 || b.0 < 360.0 {
            planes.push((a.0 + 360.0, a.1));
        }
    } else if first == 0.0 {
        mirror(&mut planes, 0.0);
    }
    planes.sort_by(|a, b| a.0.total_cmp(&b.0));
    planes.dedup_by(|a, b| a.0 == b.0);
    if web == Web::C && planes.iter().any(|p| p.0 == 360.0) {
        planes.retain(|p| p.0 <= 360.0);
    }
    // A plane before 0 becomes the one at 0, in between.
    let mut out: Vec<(f32, Vec<f32>)> = planes.iter().map(|p| (p.0, p.1.to_vec())).collect();
    if web == Web::C && out[0].0 < 0.0 && out.len() > 1 {
        let t = -out[0].0 / (out[1].0 - out[0].0);
        let between: Vec<f32> = out[0].1.iter().zip(&out[1].1).map(|(a, b)| a + (b - a) * t).collect();
        out.retain(|p| p.0 > 0.0 && p.0 < 360.0);
        out.insert(0, (0.0, between.clone()));
        out.push((360.0, between));
    }
    (out.iter().map(|p| p.0).collect(), out.into_iter().flat_map(|p| p.1).collect())
}
