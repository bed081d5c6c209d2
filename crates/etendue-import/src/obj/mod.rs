//! Wavefront OBJ with its material libraries (MTL).
//!
//! Positions, normals and texture coordinates with positive or negative indices; polygons of any number of corners,
//! concave ones too; objects, groups and materials, each combination of which becomes one mesh; smoothing groups; vertex
//! colours as most programs write them (three numbers after the position, sRGB). Texture coordinates are turned over, as
//! OBJ counts them from the bottom.
//!
//! A face without normals is flat unless a smoothing group (`s 1`) holds it, as the format says. OBJ knows neither units nor
//! which way is up: one unit is taken as a metre, +Y as up. It does not know either which side of a surface is the outside:
//! materials are double-sided. Lines and points are shown as tubes and balls, also where a file has nothing but positions; free-form surfaces
//! are left out with a warning.
//!
//! How materials become metal-rough surfaces stands in [`surface`].

pub(crate) mod library;
mod mesh;
mod parse;
mod pictures;
mod surface;

use crate::assemble::{Assembly, Facts};
use crate::error::Fault;
use crate::import::{ImportOptions, Imported};
use crate::limits::Budget;
use crate::source::Source;
use crate::warning::Warnings;
use std::path::Path;

pub(crate) fn read(
    bytes: &[u8],
    name: &str,
    folder: Option<&Path>,
    options: &ImportOptions,
) -> Result<Imported, Fault> {
    let mut warnings = Warnings::default();
    let obj = parse::parse(bytes, &mut warnings)?;
    let source =
        Source { folder, limits: &options.limits, keep_files: options.image_files, used: bytes.len() as u64 };
    let (libraries, read) = library::read_all(&obj.libraries, &source, &mut warnings);

    let mut out = Assembly::default();
    let materials = surface::convert_all(&obj, &libraries, &source, &mut out, &mut warnings)?;
    let input = bytes.len() as u64 + read;
    let mut budget = Budget::new(&options.limits, input);
    budget.beside(out.images.iter().map(|d| d.image.bytes() as u64).sum());
    mesh::build_all(&obj, &materials, &mut budget, &mut out, &mut warnings)?;
    let pictures: u64 = out.images.iter().map(|d| d.encoded_bytes).sum();
    let (bytes, external) = (bytes.len() as u64, read + pictures);
    let facts = Facts { file: name, format: "OBJ", bytes, external, comment: obj.comment };
    out.finish(facts, options.image_files, warnings)
}
