//! Pictures: buffers with their depth, readers that bound what a file may ask for, writers that never leave half a
//! file, development from scene light to display values, and metrics.
//!
//! - [`decode`]: PNG, JPEG, WebP, KTX2 → [`Image`] at the file's own depth, for textures.
//! - [`Ktx2`]: all that a KTX2 texture holds: mips, layers, faces, whether its colours are encoded.
//! - [`read_environment`]: Radiance HDR, OpenEXR → linear light without a pixel that is not finite.
//! - [`decode_picture`]: any of these as it stands, to be looked at or compared.
//! - [`write_picture`], [`write_layers_exr`]: light → files, atomically, with [`Metadata`].
//! - [`develop`]: exposure, tone curve, encoding.
//! - [`rmse`], [`rel_mse`], [`psnr`], [`ldr_flip`], [`hdr_flip`]: how far a picture is from its reference.
#![forbid(unsafe_code)]

mod atomic;
mod buffer;
mod cube_strip;
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
pub use decode::{DecodeLimits, decode};
pub use develop::{Depth, Development, develop};
pub use environment::{Environment, decode_environment, read_environment};
pub use error::ImageError;
pub use exr_read::read_exr_layers;
pub use exr_write::{ChannelData, ExrImage, Layer, write_layers_exr};
pub use ktx2::Ktx2;
pub use metadata::Metadata;
pub use metrics::{DEFAULT_PPD, Flip, hdr_flip, ldr_flip, psnr, rel_mse, rmse};
pub use picture::decode_picture;
pub use write::{PictureFormat, WriteOptions, encode_picture, write_picture};
