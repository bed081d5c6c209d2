//! Valid pictures beside their decoded form, where a suite has it.

use etendue::image::{ChannelData, DecodeLimits, Pixels, decode, read_exr_layers};
use std::error::Error;
use std::path::Path;

/// Differences of a picture's samples from its reference's.
struct Difference {
    mean: f64,
    most: f64,
}

fn difference(a: &[f32], b: &[f32]) -> Result<Difference, String> {
    if a.len() != b.len() {
        return Err(format!("{} samples, and {} in the reference", a.len(), b.len()));
    }
    // Where both are not finite they agree.
    let each = a
        .iter()
        .zip(b)
        .map(|(x, y)| if x == y || !(x - y).is_finite() { 0.0 } else { f64::from((x - y).abs()) });
    let (mut sum, mut most) = (0.0, 0.0f64);
    for d in each {
        sum += d;
        most = most.max(d);
    }
    Ok(Difference { mean: sum / a.len().max(1) as f64, most })
}

/// Three channels in steps of eight bits.
fn steps(path: &Path) -> Result<Vec<f32>, Box<dyn Error>> {
    let image = decode(&std::fs::read(path)?, &DecodeLimits::default())?;
    let shift = if matches!(image.pixels, Pixels::U16(_)) { 65535.0 } else { 255.0 };
    let mut out = Vec::new();
    for y in 0..image.height {
        for x in 0..image.width {
            for c in 0..3 {
                let v = image.sample(x, y, if image.channels < 3 { 0 } else { c });
                out.push((v * shift).round() * (255.0 / shift));
            }
        }
    }
    Ok(out)
}

/// All channels of an OpenEXR picture.
fn channels(path: &Path) -> Result<Vec<f32>, Box<dyn Error>> {
    let exr = read_exr_layers(&std::fs::read(path)?, &DecodeLimits::default())?;
    let mut out = Vec::new();
    for (_, channel) in exr.layers.iter().flat_map(|l| &l.channels) {
        match channel {
            ChannelData::Color(v) | ChannelData::F32(v) => out.extend_from_slice(v),
            ChannelData::U32(v) => out.extend(v.iter().map(|x| *x as f32)),
        }
    }
    Ok(out)
}

/// Pictures of `exrs-compression` and what they are to be equal to.
const EXR: [(&str, &str, &str); 3] = [
    ("f16", "uncompressed", "rle zip pxr24=decompressed_pxr24 b44=decompressed_b44"),
    ("f32", "zip", "zips rle piz"),
    ("u16", "f32_uncompressed", "f32_zip f32_piz f16_rle=f16_uncompressed"),
];

/// Largest mean difference of a JPEG from its suite's decoded picture, steps of eight bits: decoders differ in how they
/// transform and spread chroma.
const JPEG: f64 = 1.5;

/// Prints how far pictures are from their references; false if one is further than it may be.
pub fn compare(folder: &Path) -> Result<bool, Box<dyn Error>> {
    let mut good = true;
    println!("\npictures beside their references, mean and largest difference");
    let mut show = |name: &str, unit: &str, limit: f64, d: Result<Difference, Box<dyn Error>>| {
        let (text, within) = match d {
            Ok(d) => (format!("{:.4}, {:.4}{unit}", d.mean, d.most), d.mean <= limit),
            Err(e) => (e.to_string(), false),
        };
        println!("  {name:<44}{text}{}", if within { "" } else { "  BEYOND" });
        good &= within;
    };
    for (part, usual, list) in EXR {
        let file = |name: &str| folder.join("exrs-compression").join(part).join(format!("{name}.exr"));
        for pair in list.split(' ') {
            let (name, reference) = pair.split_once('=').unwrap_or((pair, usual));
            let d = channels(&file(name)).and_then(|a| Ok(difference(&a, &channels(&file(reference))?)?));
            show(&format!("{part}/{name}.exr = {reference}.exr"), "", 0.0, d);
        }
    }
    // The suite itself does not compare what it lists as disabled.
    let disabled = std::fs::read_to_string(folder.join("jpeg-reftest/disabled.list")).unwrap_or_default();
    let mut jpegs = crate::files(&folder.join("jpeg-reftest"));
    jpegs.retain(|p| p.extension().is_some_and(|e| e == "jpg") && p.with_extension("png").is_file());
    jpegs.retain(|p| !disabled.lines().any(|l| !l.is_empty() && p.ends_with(l)));
    for path in jpegs {
        let d = steps(&path).and_then(|a| Ok(difference(&a, &steps(&path.with_extension("png"))?)?));
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        show(&name, " of 255", JPEG, d);
    }
    Ok(good)
}
