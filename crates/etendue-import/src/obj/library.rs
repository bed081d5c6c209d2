//! Material libraries: the statements of MTL files.
//!
//! A library that is not there, and whatever in it is not understood, is named in a warning; the shapes are shown all the
//! same.

use crate::source::Source;
use crate::text::{Lines, number, shown, split_word};
use crate::warning::Warnings;
use std::collections::HashMap;

/// A picture that a material refers to.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Map {
    /// As it stands in the file.
    pub file: Vec<u8>,
    /// Folder of the library, as the OBJ file says it, with `/` at its end, or empty.
    pub folder: Vec<u8>,
    /// `-o`: added to the texture coordinate, after the scale.
    pub offset: [f32; 2],
    /// `-s`: multiplies it.
    pub scale: [f32; 2],
    /// `-clamp on`.
    pub clamp: bool,
    /// `-bm`: how high a bump map is.
    pub bump: f32,
    /// `-imfchan`: r, g, b, m (alpha) or l.
    pub channel: Option<u8>,
}

/// One material: its statements by their names in small letters.
#[derive(Clone, Debug, Default)]
pub(super) struct Mtl {
    pub values: HashMap<String, [f32; 3]>,
    pub maps: HashMap<String, Map>,
    /// Where it begins, for warnings.
    pub place: String,
}

/// Materials by name; of two with one name the first counts.
pub(super) type Libraries = HashMap<Vec<u8>, Mtl>;

const VALUES: [&str; 18] = [
    "ka",
    "kd",
    "ks",
    "ke",
    "tf",
    "ns",
    "ni",
    "d",
    "tr",
    "illum",
    "sharpness",
    "pr",
    "pm",
    "ps",
    "pc",
    "pcr",
    "aniso",
    "anisor",
];
const MAPS: [&str; 22] = [
    "map_ka", "map_kd", "map_ks", "map_ke", "map_ns", "map_d", "map_tr", "map_bump", "bump", "norm",
    "map_pr", "map_pm", "map_ps", "map_pc", "map_pcr", "map_orm", "disp", "map_disp", "decal", "refl",
    "map_refl", "map_kn",
];

/// Reads the libraries that an OBJ file names, and how many bytes they have.
pub(super) fn read_all(
    names: &[(u64, Vec<u8>)],
    source: &Source<'_>,
    warnings: &mut Warnings,
) -> (Libraries, u64) {
    let mut out = Libraries::new();
    let mut total = 0;
    let mut seen: Vec<Vec<u8>> = Vec::new();
    for (line, statement) in names {
        // One name with spaces, or several names.
        let mut list = vec![statement.clone()];
        let whole = read(source, &[statement], "material library");
        if whole.is_err() && statement.contains(&b' ') {
            list = crate::text::words(statement).map(<[u8]>::to_vec).collect();
        }
        for name in list {
            if seen.contains(&name) {
                continue;
            }
            match read(source, &[&name], "material library") {
                Ok(bytes) => {
                    total += bytes.len() as u64;
                    parse(&bytes, &name, &mut out, warnings);
                }
                Err(why) => {
                    warnings.add(format!("line {line}"), format!("{why}; shown without its materials"))
                }
            }
            // Names of more libraries than any model has are not all remembered.
            if seen.len() < 100 {
                seen.push(name);
            }
        }
    }
    (out, total)
}

/// The first of the files `names` that can be read, or why the first of them cannot.
pub(crate) fn read(source: &Source<'_>, names: &[&[u8]], what: &'static str) -> Result<Vec<u8>, String> {
    let mut first = None;
    for name in names {
        // As a URI, so that the same rules hold for what may be read.
        let uri = String::from_utf8_lossy(name).replace('%', "%25").replace('\\', "/");
        match source.read(&uri, what, "") {
            Ok(bytes) => return Ok(bytes),
            Err(e) => first = first.or(Some(e)),
        }
    }
    Err(match first {
        Some(crate::error::Fault::Missing { looked_for, reason, .. }) => {
            format!("the {what} {} cannot be read ({reason})", looked_for.display())
        }
        Some(other) => format!("the {what} `{}` cannot be read: {}", shown(names[0]), other.message()),
        None => format!("the {what} has no name"),
    })
}

fn parse(bytes: &[u8], file: &[u8], out: &mut Libraries, warnings: &mut Warnings) {
    let folder = match file.iter().rposition(|b| matches!(b, b'/' | b'\\')) {
        Some(end) => &file[..=end],
        None => &[],
    };
    let name = shown(file);
    let mut current: Option<(Vec<u8>, Mtl)> = None;
    let mut finish = |m: Option<(Vec<u8>, Mtl)>| {
        if let Some((k, m)) = m {
            out.entry(k).or_insert(m);
        }
    };
    for (line, text) in Lines::new(bytes) {
        let (key, rest) = split_word(&text);
        let at = || format!("{name}, line {line}");
        if key.is_empty() || key[0] == b'#' {
            continue;
        }
        if key.eq_ignore_ascii_case(b"newmtl") {
            finish(current.take());
            current = Some((rest.to_vec(), Mtl { place: at(), ..Mtl::default() }));
            continue;
        }
        let lower = String::from_utf8_lossy(key).to_ascii_lowercase();
        let Some((_, m)) = &mut current else {
            warnings.add(at(), "a statement before the first `newmtl`; ignored");
            continue;
        };
        if VALUES.contains(&&lower[..]) {
            match values(rest) {
                Some(v) => drop(m.values.insert(lower, v)),
                None => warnings.add(at(), format!("`{}` is not followed by numbers; ignored", shown(key))),
            }
        } else if MAPS.contains(&&lower[..]) {
            let mut map = map(rest, &at, warnings);
            map.folder = folder.to_vec();
            if map.file.is_empty() {
                warnings.add(at(), format!("`{}` names no file; ignored", shown(key)));
            } else {
                m.maps.insert(lower, map);
            }
        } else if lower != "map_aat" {
            warnings
                .add(at(), format!("`{}` is no statement of a material that is known; ignored", shown(key)));
        }
    }
    finish(current);
}

/// One to three numbers; one stands for all three.
fn values(rest: &[u8]) -> Option<[f32; 3]> {
    // `d -halo 0.5` fades towards the outline; the number is kept.
    let rest = rest.strip_prefix(b"-halo").unwrap_or(rest);
    let mut v = [0.0; 3];
    let mut n = 0;
    for word in crate::text::words(rest).take(3) {
        v[n] = number::<f32>(word).filter(|x| x.is_finite())?;
        n += 1;
    }
    match n {
        0 => None,
        1 => Some([v[0]; 3]),
        _ => Some(v),
    }
}

/// The options of a map and its file, whose name may have spaces.
fn map(mut rest: &[u8], at: &impl Fn() -> String, warnings: &mut Warnings) -> Map {
    let mut out = Map { scale: [1.0; 2], bump: 1.0, ..Map::default() };
    loop {
        let (word, more) = split_word(rest);
        let most = match word {
            b"-o" | b"-s" | b"-t" => 3,
            b"-mm" => 2,
            b"-bm" | b"-boost" | b"-texres" | b"-clamp" | b"-blendu" | b"-blendv" | b"-cc" | b"-imfchan"
            | b"-type" | b"-colorspace" => 1,
            _ => {
                out.file = rest.to_vec();
                return out;
            }
        };
        rest = more;
        let mut v = [None; 3];
        if matches!(word, b"-o" | b"-s" | b"-t" | b"-mm" | b"-bm") {
            // The count is open: what is not a number is the next option or the file.
            for slot in v.iter_mut().take(most) {
                let (word, more) = split_word(rest);
                let Some(x) = number::<f32>(word).filter(|x| x.is_finite()) else { break };
                *slot = Some(x);
                rest = more;
            }
        }
        match word {
            b"-o" => out.offset = [v[0].unwrap_or(0.0), v[1].unwrap_or(0.0)],
            b"-s" => out.scale = [v[0].unwrap_or(1.0), v[1].unwrap_or(1.0)],
            b"-bm" => out.bump = v[0].unwrap_or(1.0),
            b"-t" => warnings.add(at(), "`-t` (turbulence) is not supported; ignored"),
            b"-mm" => {
                if v[..2] != [Some(0.0), Some(1.0)] {
                    warnings.add(at(), "`-mm` (range of a map's values) is not supported; ignored");
                }
            }
            _ => {
                let (value, more) = split_word(rest);
                rest = more;
                match (word, value) {
                    (b"-clamp", b"on") => out.clamp = true,
                    (b"-imfchan", [c, ..]) => out.channel = Some(c.to_ascii_lowercase()),
                    (b"-type", b"sphere") => warnings.add(at(), "`-type sphere` is not supported; ignored"),
                    _ => {}
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statements_and_options() {
        let text = b"Kd 1 1 1\nnewmtl a b\nKd 0.1 0.2 0.3\nNs 10\nKs 0.5\nmap_Kd -s 2 3 -o 0.5 -clamp on my wood.png\n\
            map_Bump -bm 0.3 -imfchan r b.png\nillum x\nfoo 1\nnewmtl a b\nKd 9 9 9\nd 0.5\n";
        let (mut out, mut warnings) = (Libraries::new(), Warnings::default());
        parse(text, b"sub\\x.mtl", &mut out, &mut warnings);
        let m = &out[&b"a b"[..]];
        assert_eq!(m.values["kd"], [0.1, 0.2, 0.3], "the first of two");
        assert_eq!((m.values["ks"], m.values["ns"][0]), ([0.5; 3], 10.0));
        let wood = &m.maps["map_kd"];
        assert_eq!((&wood.file[..], &wood.folder[..]), (&b"my wood.png"[..], &b"sub\\"[..]));
        assert_eq!((wood.scale, wood.offset, wood.clamp), ([2.0, 3.0], [0.5, 0.0], true));
        let bump = &m.maps["map_bump"];
        assert_eq!((bump.bump, bump.channel), (0.3, Some(b'r')));
        let said: Vec<_> =
            warnings.into_vec().into_iter().map(|w| format!("{}: {}", w.pointer, w.message)).collect();
        assert_eq!(said.len(), 3, "{said:?}");
        assert!(said[1].starts_with("sub\\x.mtl, line 8: `illum`"), "{said:?}");
    }
}
