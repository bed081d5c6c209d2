//! `etendue tonemap`: light into a picture, without rendering.

use super::args::TonemapArgs;
use super::output::expose;
use super::{CliError, say};
use crate::image::{
    ChannelData, DecodeLimits, Image, Layer, Metadata, PictureFormat, Pixels, read_environment,
    read_exr_layers, write_picture,
};

pub(crate) fn run(args: &TonemapArgs) -> Result<(), CliError> {
    let format = PictureFormat::from_path(&args.output)?;
    if let Err(source) = std::fs::metadata(&args.input) {
        return Err(CliError::Read { path: args.input.clone(), source });
    }
    let is_exr = PictureFormat::from_path(&args.input).is_ok_and(|f| f == PictureFormat::Exr);
    let (mut image, metadata) =
        if is_exr { layer(args)? } else { (read_environment(&args.input)?.image, Metadata::default()) };
    if matches!(format, PictureFormat::Exr | PictureFormat::Hdr) {
        expose(&mut image, args.develop.exposure);
    }
    write_picture(&args.output, &image, &args.develop.write_options(metadata))?;
    say(&format!("{}: {} × {}", args.output.display(), image.width, image.height));
    Ok(())
}

/// One layer of an OpenEXR file as a picture.
fn layer(args: &TonemapArgs) -> Result<(Image, Metadata), CliError> {
    let bytes =
        std::fs::read(&args.input).map_err(|source| CliError::Read { path: args.input.clone(), source })?;
    let exr = read_exr_layers(&bytes, &DecodeLimits::default()).map_err(|e| e.in_file(&args.input))?;
    let layer = exr.layer(&args.layer).ok_or_else(|| {
        let names: Vec<_> = exr.layers.iter().map(|l| format!("{:?}", l.name)).collect();
        CliError::Usage(format!(
            "{} has no layer {:?}; it has {}",
            args.input.display(),
            args.layer,
            names.join(", ")
        ))
    })?;
    let planes = planes(layer);
    let n = planes.len();
    let pixels = exr.width as usize * exr.height as usize;
    let mut out = Vec::with_capacity(pixels * n);
    for i in 0..pixels {
        out.extend(planes.iter().map(|p| p[i]));
    }
    let image = Image { width: exr.width, height: exr.height, channels: n as u8, pixels: Pixels::F32(out) };
    Ok((image, exr.metadata.clone()))
}

/// The layer's channels in the order in which a picture wants them: R G B A, X Y Z, U V, or the first.
fn planes(layer: &Layer) -> Vec<Vec<f32>> {
    let floats = |d: &ChannelData| match d {
        ChannelData::Color(v) | ChannelData::F32(v) => v.clone(),
        ChannelData::U32(v) => v.iter().map(|x| *x as f32).collect(),
    };
    for order in [&["R", "G", "B", "A"][..], &["R", "G", "B"], &["X", "Y", "Z"]] {
        let found: Vec<_> = order.iter().filter_map(|c| layer.channel(c).map(floats)).collect();
        if found.len() == order.len() {
            return found;
        }
    }
    layer.channels.iter().take(1).map(|c| floats(&c.1)).collect()
}
