//! Pictures: buffers with their depth, readers that bound what a file may ask for, writers that never leave half a
//! file, development from scene light to display values, and metrics.
//!
//! - [`decode`]: PNG, JPEG, WebP, KTX2, BMP, TGA → [`Image`] at the file's own depth, for textures.
//! - [`Ktx2`]: all that a KTX2 texture holds: mips, layers, faces, whether its colours are encoded.
//! - [`read_environment`]: Radiance HDR, OpenEXR, cubes of KTX2 and DDS, strips and crosses → linear light without a pixel that is not finite.
//! - [`decode_picture`]: any of these as it stands, to be looked at or compared.
//! - [`write_picture`], [`write_layers_exr`]: light → files, atomically, with [`Metadata`].
//! - [`develop`]: exposure, tone curve, encoding.
//! - [`rmse`], [`rel_mse`], [`psnr`], [`ldr_flip`], [`hdr_flip`]: how far a picture is from its reference.
#![forbid(unsafe_code)]

mod atomic;
mod bc6h;
mod buffer;
mod dds;
mod decode;
mod develop;
mod environment;
mod error;
mod exr_read;
mod exr_write;
mod hdr;
mod ktx2;
mod metadata;
mod metrics;
mod picture;
mod write;

pub use atomic::write_atomic;
pub use buffer::{Image, Pixels};
pub use decode::{DecodeLimits, decode, is_tga};
pub use develop::{Depth, Development, develop};
pub use environment::{
    Environment, SkyLayout, decode_environment, decode_environment_as, lat_long_of_cube, read_environment,
    read_environment_as,
};
pub use error::ImageError;
pub use exr_read::read_exr_layers;
pub use exr_write::{ChannelData, ExrImage, Layer, write_layers_exr};
pub use ktx2::Ktx2;
pub use metadata::Metadata;
pub use metrics::{DEFAULT_PPD, Flip, hdr_flip, ldr_flip, psnr, rel_mse, rmse};
pub use picture::decode_picture;
pub use write::{PictureFormat, WriteOptions, encode_picture, write_picture};
