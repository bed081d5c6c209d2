//! The statements of an OBJ file.

use crate::error::Fault;
use crate::text::{Lines, number, shown, split_word, words};
use crate::warning::Warnings;
use glam::{Vec2, Vec3};
use std::collections::HashMap;

/// "No such index".
pub(super) const NONE: u32 = u32::MAX;

/// One corner of a face: numbers of its position, texture coordinate and normal, from 0; the latter two may be [`NONE`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Corner {
    pub position: u32,
    pub uv: u32,
    pub normal: u32,
}

/// A face: its number of corners and its smoothing group; 0 is none.
#[derive(Clone, Copy, Debug)]
pub(super) struct Face {
    pub corners: u32,
    pub smoothing: u32,
}

/// The faces, lines and points of one object, group and material.
#[derive(Debug, Default)]
pub(super) struct Group {
    pub name: String,
    /// Number in [`Obj::materials`].
    pub material: Option<u32>,
    pub faces: Vec<Face>,
    pub corners: Vec<Corner>,
    /// Ends of lines, as numbers of positions; both are one of a point.
    pub strokes: Vec<[u32; 2]>,
}

/// What an OBJ file says.
#[derive(Debug, Default)]
pub(super) struct Obj {
    pub positions: Vec<Vec3>,
    /// sRGB, one per position, or none at all.
    pub colors: Vec<Vec3>,
    /// Origin bottom-left.
    pub uvs: Vec<Vec2>,
    pub normals: Vec<Vec3>,
    /// In the order of their first face.
    pub groups: Vec<Group>,
    /// Names, in the order of their first use.
    pub materials: Vec<String>,
    /// File names as they stand, with the line.
    pub libraries: Vec<(u64, Vec<u8>)>,
    /// The first comment: most programs name themselves there.
    pub comment: Option<String>,
}

/// The largest index seen of a kind and where: references may go before what they refer to.
#[derive(Default)]
struct Reach {
    count: u64,
    line: u64,
}

/// Object, group and material.
type GroupKey = (Vec<u8>, Vec<u8>, Option<u32>);

#[derive(Default)]
struct Parser {
    out: Obj,
    object: Vec<u8>,
    group: Vec<u8>,
    material: Option<u32>,
    smoothing: u32,
    material_numbers: HashMap<Vec<u8>, u32>,
    group_numbers: HashMap<GroupKey, u32>,
    /// Number of the group that faces go to, until object, group or material change.
    current: Option<u32>,
    smoothing_names: HashMap<Vec<u8>, u32>,
    reach: [Reach; 3],
}

pub(super) fn parse(bytes: &[u8], warnings: &mut Warnings) -> Result<Obj, Fault> {
    let mut p = Parser::default();
    for (line, text) in Lines::new(bytes) {
        p.statement(line, &text, warnings)?;
    }
    // A file of nothing but positions is a cloud of points.
    if p.out.groups.is_empty() && !p.out.positions.is_empty() {
        let g = p.group();
        p.out.groups[g].strokes = (0..p.out.positions.len() as u32).map(|i| [i, i]).collect();
    }
    let o = &p.out;
    let have = [o.positions.len(), o.uvs.len(), o.normals.len()];
    for ((what, reach), have) in ["position", "texture coordinate", "normal"].iter().zip(&p.reach).zip(have) {
        if reach.count > have as u64 {
            let message = format!("refers to {what} {}, but the file has {have}", reach.count);
            return Err(Fault::line(reach.line, message));
        }
    }
    Ok(p.out)
}

impl Parser {
    fn statement(&mut self, line: u64, text: &[u8], warnings: &mut Warnings) -> Result<(), Fault> {
        let (key, rest) = split_word(text);
        match key {
            b"v" => self.position(line, rest, warnings)?,
            b"vt" => {
                let [u, v] = numbers(line, "a texture coordinate", rest, 1)?;
                self.out.uvs.push(Vec2::new(u, v));
            }
            b"vn" => {
                let n: [f32; 3] = numbers(line, "a normal", rest, 3)?;
                self.out.normals.push(Vec3::from_array(n));
            }
            b"f" | b"fo" => self.face(line, rest)?,
            b"o" => {
                self.object = rest.to_vec();
                // A group belongs to its object.
                self.group.clear();
                self.current = None;
            }
            b"g" => {
                self.group = rest.to_vec();
                self.current = None;
            }
            b"usemtl" => {
                self.material = Some(self.material(rest));
                self.current = None;
            }
            b"s" => self.smoothing = self.smoothing(rest),
            b"mtllib" => self.out.libraries.push((line, rest.to_vec())),
            b"l" => self.strokes(line, rest, false)?,
            b"p" => self.strokes(line, rest, true)?,
            // Said by some programs, and without meaning for a picture.
            b"vp" | b"lod" | b"shadow_obj" | b"trace_obj" | b"bevel" | b"c_interp" | b"d_interp" | b"end" => {
            }
            b"curv" | b"curv2" | b"surf" | b"cstype" | b"deg" | b"parm" | b"trim" | b"hole" | b"bmat"
            | b"step" | b"scrv" | b"sp" | b"con" | b"ctech" | b"stech" | b"mg" => {
                warnings.add(at(line), "free-form curves and surfaces are not supported; left out");
            }
            [] => {}
            [b'#', ..] => self.comment(text),
            other => {
                warnings.add(at(line), format!("`{}` is no statement that is known; ignored", shown(other)));
            }
        }
        Ok(())
    }

    fn comment(&mut self, text: &[u8]) {
        if self.out.comment.is_none() && self.out.positions.is_empty() {
            let text = text.trim_ascii().strip_prefix(b"#").unwrap_or_default().trim_ascii();
            self.out.comment = (!text.is_empty()).then(|| shown(text));
        }
    }

    fn position(&mut self, line: u64, rest: &[u8], warnings: &mut Warnings) -> Result<(), Fault> {
        let mut v = [0.0f32; 7];
        let mut n = 0;
        for word in words(rest).take(7) {
            v[n] = number(word).ok_or_else(|| not_a_number(line, word))?;
            n += 1;
        }
        if n < 3 {
            return Err(Fault::line(line, format!("a position needs 3 numbers, not {n}")));
        }
        // x y z [w], x y z r g b, or x y z w r g b.
        if (n == 4 || n == 7) && v[3] != 1.0 {
            warnings
                .add(at(line), "the weight of a position (its fourth number) serves curves only; ignored");
        }
        let positions = &mut self.out.positions;
        if n >= 6 {
            self.out.colors.resize(positions.len(), Vec3::ONE);
            self.out.colors.push(Vec3::from_slice(&v[n - 3..]));
        } else if !self.out.colors.is_empty() {
            self.out.colors.push(Vec3::ONE);
        }
        positions.push(Vec3::from_slice(&v));
        if positions.len() >= NONE as usize {
            return Err(Fault::line(line, "more than 4 294 967 294 positions"));
        }
        Ok(())
    }

    fn material(&mut self, name: &[u8]) -> u32 {
        if let Some(&known) = self.material_numbers.get(name) {
            return known;
        }
        let number = self.out.materials.len() as u32;
        self.out.materials.push(String::from_utf8_lossy(name).into_owned());
        self.material_numbers.insert(name.to_vec(), number);
        number
    }

    /// Smoothing groups are numbers, but some programs write names.
    fn smoothing(&mut self, word: &[u8]) -> u32 {
        if matches!(word, b"off" | b"0" | b"" | b"null") {
            return 0;
        }
        let next = self.smoothing_names.len() as u32 + 1;
        *self.smoothing_names.entry(word.to_vec()).or_insert(next)
    }

    /// Where faces go now.
    fn group(&mut self) -> usize {
        if let Some(n) = self.current {
            return n as usize;
        }
        let key = (self.object.clone(), self.group.clone(), self.material);
        let next = self.out.groups.len() as u32;
        let n = *self.group_numbers.entry(key).or_insert(next);
        if n == next {
            let object = String::from_utf8_lossy(&self.object);
            let group = String::from_utf8_lossy(&self.group);
            let name = match (&object[..], &group[..]) {
                ("", g) | (g, "") => g.to_owned(),
                (o, g) if o == g => o.to_owned(),
                (o, g) => format!("{o}/{g}"),
            };
            let material = self.material;
            self.out.groups.push(Group { name, material, ..Group::default() });
        }
        self.current = Some(n);
        n as usize
    }

    fn face(&mut self, line: u64, rest: &[u8]) -> Result<(), Fault> {
        let g = self.group();
        let before = self.out.groups[g].corners.len();
        for word in words(rest) {
            let corner = self.corner(line, word)?;
            self.out.groups[g].corners.push(corner);
        }
        let group = &mut self.out.groups[g];
        let corners = group.corners.len() - before;
        if corners < 3 {
            return Err(Fault::line(line, format!("a face needs 3 corners or more, not {corners}")));
        }
        group.faces.push(Face { corners: corners as u32, smoothing: self.smoothing });
        Ok(())
    }

    /// A line from corner to corner, or a point at each.
    fn strokes(&mut self, line: u64, rest: &[u8], points: bool) -> Result<(), Fault> {
        let g = self.group();
        let mut last = None;
        for word in words(rest) {
            let to = self.corner(line, word)?.position;
            let from = if points { Some(to) } else { last };
            self.out.groups[g].strokes.extend(from.map(|from| [from, to]));
            last = Some(to);
        }
        Ok(())
    }

    /// `v`, `v/vt`, `v//vn` or `v/vt/vn`.
    fn corner(&mut self, line: u64, word: &[u8]) -> Result<Corner, Fault> {
        let mut found = [NONE; 3];
        let o = &self.out;
        let have = [o.positions.len(), o.uvs.len(), o.normals.len()];
        for (k, part) in word.split(|&b| b == b'/').enumerate() {
            let bad = || {
                let message = format!("`{}` is no corner (v, v/vt, v//vn or v/vt/vn)", shown(word));
                Fault::line(line, message)
            };
            if k > 2 || (part.is_empty() && k == 0) {
                return Err(bad());
            }
            if part.is_empty() {
                continue;
            }
            let index: i64 = number(part).ok_or_else(bad)?;
            // From 1, or backwards from the latest.
            let at = match index {
                0 => return Err(Fault::line(line, "an index is 0; they count from 1, or backwards from -1")),
                1.. => index - 1,
                _ => index.saturating_add(have[k] as i64),
            };
            let Some(at) = u32::try_from(at).ok().filter(|&at| at != NONE) else {
                let message = format!("the index {index} is out of range: {} stand before it", have[k]);
                return Err(Fault::line(line, message));
            };
            if u64::from(at) + 1 > self.reach[k].count {
                self.reach[k] = Reach { count: u64::from(at) + 1, line };
            }
            found[k] = at;
        }
        Ok(Corner { position: found[0], uv: found[1], normal: found[2] })
    }
}

/// The place of line `n` in warnings.
pub(super) fn at(n: u64) -> String {
    format!("line {n}")
}

fn not_a_number(line: u64, word: &[u8]) -> Fault {
    Fault::line(line, format!("`{}` is not a number", shown(word)))
}

/// The first `N` numbers of `rest`, of which `least` have to be there; others are 0.
fn numbers<const N: usize>(line: u64, what: &str, rest: &[u8], least: usize) -> Result<[f32; N], Fault> {
    let mut v = [0.0; N];
    let mut n = 0;
    for word in words(rest).take(N) {
        v[n] = number(word).ok_or_else(|| not_a_number(line, word))?;
        n += 1;
    }
    if n < least {
        return Err(Fault::line(line, format!("{what} needs {least} numbers, not {n}")));
    }
    Ok(v)
}
