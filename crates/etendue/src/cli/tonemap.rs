//! `etendue tonemap`: light into a picture, without rendering.

use super::args::TonemapArgs;
use super::output::{expose, read_whole, unwritten};
use super::{CliError, say, target};
use crate::image::{
    ChannelData, DecodeLimits, Image, Layer, Metadata, PictureFormat, Pixels, decode_environment,
    read_exr_layers, write_picture,
};

/// The first bytes of every OpenEXR file.
const EXR_MAGIC: &[u8] = &[0x76, 0x2f, 0x31, 0x01];

pub(crate) fn run(args: &TonemapArgs) -> Result<(), CliError> {
    let format = target::format(&args.output)?;
    target::check_writable(&args.output)?;
    let bytes = read_whole(&args.input)?;
    let (mut image, metadata) = if bytes.starts_with(EXR_MAGIC) {
        layer(args, &bytes)?
    } else if args.layer.is_empty() {
        let sky = decode_environment(&bytes, &DecodeLimits::default()).map_err(|e| e.in_file(&args.input))?;
        (sky.image, Metadata::default())
    } else {
        return Err(CliError::Usage(format!("{} has no layers: it is no .exr", args.input.display())));
    };
    if matches!(format, PictureFormat::Exr | PictureFormat::Hdr) {
        expose(&mut image, args.develop.exposure);
    }
    write_picture(&args.output, &image, &args.develop.write_options(metadata))
        .map_err(|e| unwritten(&args.output, e))?;
    if !args.quiet {
        say(&format!("{}: {} × {}", args.output.display(), image.width, image.height));
    }
    Ok(())
}

/// One layer of an OpenEXR file as a picture.
fn layer(args: &TonemapArgs, bytes: &[u8]) -> Result<(Image, Metadata), CliError> {
    let exr = read_exr_layers(bytes, &DecodeLimits::default()).map_err(|e| e.in_file(&args.input))?;
    let layer = exr.layer(&args.layer).ok_or_else(|| {
        let names: Vec<_> =
            exr.layers.iter().filter(|l| !l.name.is_empty()).map(|l| l.name.as_str()).collect();
        let wanted =
            if args.layer.is_empty() { "beauty picture".into() } else { format!("layer {}", args.layer) };
        CliError::Usage(format!(
            "{} has no {wanted}; its layers are: {}",
            args.input.display(),
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
