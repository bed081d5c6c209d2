//! KTX 2.0: textures with their mips, faces and layers, in plain samples or as Basis Universal codes them.
//!
//! Read: every format of plain red, green, blue and alpha samples that stand in whole texels (1 to 32 bits normalised, half
//! and single floats, packed floats with and without a common exponent), UASTC, ETC1S and BC6H, without supercompression or with
//! Zstandard, zlib or BasisLZ. Not read: depth and stencil, integers, chroma of its own size, other formats of one kind of
//! graphics hardware (BC, ETC2, ASTC, PVRTC), video. Written from Khronos, "KTX File Format Specification" 2.0 and "Khronos
//! Data Format Specification" 1.3.

mod consistency;
mod container;
mod descriptor;
mod etc1s;
mod huffman;
mod inflate;
mod plain;
mod remarks;
mod uastc;

use crate::{DecodeLimits, Image, ImageError, Pixels, bc6h};
use container::Container;
use descriptor::{Descriptor, Model};

const F: &str = "KTX2";

/// A KTX2 file whose structure has been checked; pictures are decoded when they are asked for.
pub struct Ktx2<'a> {
    container: Container<'a>,
    descriptor: Descriptor,
    /// What every picture goes through after it is decoded.
    view: View,
    /// The codebooks, if the pictures need some.
    books: Option<etc1s::Codebooks>,
    limits: DecodeLimits,
}

/// How decoded channels become those of the picture, and rows and columns those that are shown.
struct View {
    /// Where red, green, blue and alpha come from.
    swizzle: [Channel; 4],
    /// Whether the first row is the lowest.
    upwards: bool,
    /// Whether the first column is the rightmost.
    leftwards: bool,
}

/// Where a channel of a picture comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Channel {
    Zero,
    One,
    /// A channel of the coded texel: 0 red, 1 green, 2 blue, 3 alpha.
    From(u8),
}

impl<'a> Ktx2<'a> {
    /// Checks the file's structure and reads the codebooks.
    ///
    /// # Errors
    /// [`ImageError::Damaged`], [`ImageError::Unsupported`], [`ImageError::TooLarge`].
    pub fn new(bytes: &'a [u8], limits: &DecodeLimits) -> Result<Self, ImageError> {
        let container = Container::read(bytes)?;
        let descriptor = Descriptor::read(container.descriptor)?;
        container.check_scheme(descriptor.model)?;
        let size = (container.width.into(), container.height.into());
        limits.check(F, size, 0, usize::MAX, 1)?;
        let view = View::new(&container)?;
        let books = match descriptor.model {
            Model::Etc1s => Some(etc1s::Codebooks::read(container.global, container.images())?),
            _ => None,
        };
        let out = Self { container, descriptor, view, books, limits: *limits };
        out.check_plain()?;
        consistency::check(&out.container, &out.descriptor)?;
        if let Some(books) = &out.books {
            let sizes = (0..out.mips()).flat_map(|mip| {
                let bytes = out.container.levels[mip as usize].bytes.len();
                (0..out.container.images_of(mip)).map(move |_| bytes)
            });
            books.check(sizes, out.descriptor.samples.len())?;
        }
        Ok(out)
    }

    /// Size of the largest mip, pixels.
    pub fn size(&self) -> (u32, u32) {
        (self.container.width, self.container.height)
    }

    /// Number of mips, at least 1.
    pub fn mips(&self) -> u32 {
        self.container.levels.len() as u32
    }

    /// Number of layers, at least 1.
    pub fn layers(&self) -> u32 {
        self.container.layers
    }

    /// 6 for a cube (+X, −X, +Y, −Y, +Z, −Z), else 1.
    pub fn faces(&self) -> u32 {
        self.container.faces
    }

    /// Number of slices of the largest mip: 1 unless the texture is a volume.
    pub fn depth(&self) -> u32 {
        self.container.depth
    }

    /// Whether colours are encoded as sRGB has it; else they are linear, or data.
    pub fn is_srgb(&self) -> bool {
        self.descriptor.srgb
    }

    /// Whether colours are multiplied by alpha.
    pub fn is_premultiplied(&self) -> bool {
        self.descriptor.premultiplied
    }

    /// How the texels are coded, for people: `UASTC`, `ETC1S`, `BC6H`, `plain`.
    pub fn coding(&self) -> &'static str {
        match self.descriptor.model {
            Model::Plain => "plain",
            Model::Etc1s => "ETC1S",
            Model::Uastc => "UASTC",
            Model::Bc6h => "BC6H",
        }
    }

    /// The pictures of mip `mip` (0 is the largest): for each layer, its faces; for each face, its slices.
    ///
    /// Integers keep their bits (up to 8 and up to 16), floats and what is signed become floats; a channel that is missing is
    /// black, missing alpha is left out, and three equal channels become one. Rows run from the top.
    ///
    /// # Errors
    /// As [`Ktx2::new`]; also for a mip that is not there.
    pub fn mip(&self, mip: u32) -> Result<Vec<Image>, ImageError> {
        let count = self.container.images_of(mip);
        self.decode(mip, count)
    }

    /// The first picture of the largest mip: all of a plain 2D texture.
    ///
    /// # Errors
    /// As [`Ktx2::mip`].
    pub fn first(&self) -> Result<Image, ImageError> {
        let mut all = self.decode(0, 1)?;
        all.pop().ok_or_else(|| ImageError::damaged(F, "no picture"))
    }

    /// [`Ktx2::first`] as [`crate::decode()`] gives it: floats are not for textures.
    ///
    /// # Errors
    /// As [`Ktx2::mip`]; [`ImageError::Unsupported`] for floats.
    pub fn texture(&self) -> Result<Image, ImageError> {
        let image = self.first()?;
        if matches!(image.pixels, Pixels::F32(_)) {
            return Err(ImageError::unsupported(F, "floats as a texture"));
        }
        Ok(image)
    }

    /// Decodes the first `count` pictures of a mip.
    fn decode(&self, mip: u32, count: u64) -> Result<Vec<Image>, ImageError> {
        let c = &self.container;
        let Some(level) = c.levels.get(mip as usize) else {
            return Err(ImageError::damaged(F, format!("mip {mip} of {}", c.levels.len())));
        };
        let (width, height) = ((c.width >> mip).max(1), (c.height >> mip).max(1));
        let texels = u64::from(width) * u64::from(height);
        let decoded = texels.saturating_mul(self.bytes_per_texel()).saturating_mul(count);
        self.limits.check(F, (width.into(), height.into()), decoded, usize::MAX, 1)?;
        // Within the limits, so that counts and sizes fit.
        let images = if let Some(books) = &self.books {
            let first = (0..mip).map(|m| c.images_of(m)).sum::<u64>() as usize;
            (first..first + count as usize)
                .map(|i| books.image(i, level.bytes, width, height, &self.descriptor))
                .collect::<Result<Vec<_>, _>>()?
        } else {
            let one = match self.descriptor.model {
                Model::Uastc => uastc::size(width, height),
                Model::Bc6h => bc6h::size(width, height),
                _ => texels * u64::from(self.descriptor.texel_bytes),
            };
            let whole = one.saturating_mul(c.images_of(mip));
            let bytes = inflate::level(level, c.scheme, whole)?;
            bytes
                .chunks_exact(one as usize)
                .take(count as usize)
                .map(|b| match self.descriptor.model {
                    Model::Uastc => uastc::image(b, width, height, &self.descriptor),
                    Model::Bc6h => Ok(self.light(b, width, height)),
                    _ => plain::image(b, width, height, &self.descriptor),
                })
                .collect::<Result<Vec<_>, _>>()?
        };
        Ok(images.into_iter().map(|t| self.view.apply(t)).collect())
    }

    /// Bytes of a decoded texel.
    fn bytes_per_texel(&self) -> u64 {
        match self.descriptor.model {
            Model::Plain => plain::bytes_per_texel(&self.descriptor),
            Model::Etc1s | Model::Uastc => 4,
            Model::Bc6h => 12,
        }
    }

    /// A picture in blocks of light.
    fn light(&self, bytes: &[u8], width: u32, height: u32) -> Texels {
        let signed = self.descriptor.samples.iter().any(|s| s.signed);
        let pixels = Pixels::F32(bc6h::image(bytes, width, height, signed));
        let map = [Channel::From(0), Channel::From(1), Channel::From(2), Channel::One];
        Texels { width, height, channels: 3, pixels, map }
    }

    /// What can be said of plain samples before one is read.
    fn check_plain(&self) -> Result<(), ImageError> {
        if self.descriptor.model == Model::Plain {
            plain::check(&self.descriptor, self.container.format)?;
        }
        Ok(())
    }
}

/// A sample of a texel of another container.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlainSample {
    pub bit: u32,
    pub bits: u32,
    /// 0 red, 1 green, 2 blue, 15 alpha.
    pub channel: u8,
    pub float: bool,
    pub signed: bool,
    /// The common exponent of all.
    pub exponent: bool,
}

/// A picture of plain samples that stand in texels of `texel` bytes, at most 32; `bytes` are those of all texels.
pub(crate) fn plain_picture(
    bytes: &[u8],
    (width, height): (u32, u32),
    texel: u32,
    samples: &[PlainSample],
) -> Result<Image, ImageError> {
    let samples = samples.iter().map(|s| descriptor::Sample {
        bit: s.bit,
        bits: s.bits,
        channel: s.channel,
        float: s.float,
        signed: s.signed,
        exponent: s.exponent,
        linear: false,
        position: 0,
        lower: 0,
        upper: u32::MAX >> (32 - s.bits.min(32)),
    });
    let descriptor = Descriptor {
        model: Model::Plain,
        srgb: false,
        primaries: 0,
        transfer: 1,
        premultiplied: false,
        texel_bytes: texel,
        plane_bytes: texel,
        samples: samples.collect(),
    };
    Ok(View::PLAIN.apply(plain::image(bytes, width, height, &descriptor)?))
}

/// The texels of a picture as they are coded: `Image` with channels that may mean anything.
struct Texels {
    width: u32,
    height: u32,
    /// Channels per texel in `pixels`.
    channels: u8,
    pixels: Pixels,
    /// Where red, green, blue and alpha are among them.
    map: [Channel; 4],
}

impl View {
    /// As it stands.
    const PLAIN: Self = Self {
        swizzle: [Channel::From(0), Channel::From(1), Channel::From(2), Channel::From(3)],
        upwards: false,
        leftwards: false,
    };

    fn new(c: &Container<'_>) -> Result<Self, ImageError> {
        let mut view = Self::PLAIN;
        if let Some(s) = c.value("KTXswizzle") {
            let letters = s.strip_suffix(b"\0").unwrap_or(s);
            if letters.len() != 4 {
                return Err(ImageError::damaged(F, "KTXswizzle has not four letters"));
            }
            for (to, letter) in view.swizzle.iter_mut().zip(letters) {
                *to = match letter {
                    b'r' => Channel::From(0),
                    b'g' => Channel::From(1),
                    b'b' => Channel::From(2),
                    b'a' => Channel::From(3),
                    b'0' => Channel::Zero,
                    b'1' => Channel::One,
                    _ => return Err(ImageError::damaged(F, "KTXswizzle has letters other than rgba01")),
                };
            }
        }
        if let Some(o) = c.value("KTXorientation") {
            view.leftwards = o.first() == Some(&b'l');
            view.upwards = o.get(1) == Some(&b'u');
        }
        Ok(view)
    }

    /// The picture of decoded texels.
    fn apply(&self, t: Texels) -> Image {
        let map = self.swizzle.map(|c| match c {
            Channel::From(i) => t.map[usize::from(i)],
            constant => constant,
        });
        let grey = map[0] == map[1] && map[1] == map[2];
        let mut wanted = if grey { vec![map[0]] } else { map[..3].to_vec() };
        if map[3] != Channel::One {
            wanted.push(map[3]);
        }
        let (width, height) = (t.width as usize, t.height as usize);
        let from = usize::from(t.channels);
        let in_place = wanted.iter().copied().eq((0..t.channels).map(Channel::From));
        let channels = wanted.len() as u8;
        let pixels = if in_place && !self.upwards && !self.leftwards {
            t.pixels
        } else {
            let shape = (width, height, from);
            match t.pixels {
                Pixels::U8(p) => Pixels::U8(self.rearrange(&p, shape, &wanted, u8::MAX)),
                Pixels::U16(p) => Pixels::U16(self.rearrange(&p, shape, &wanted, u16::MAX)),
                Pixels::F32(p) => Pixels::F32(self.rearrange(&p, shape, &wanted, 1.0)),
            }
        };
        Image { width: t.width, height: t.height, channels, pixels }
    }

    fn rearrange<T: Copy + Default>(
        &self,
        pixels: &[T],
        (width, height, from): (usize, usize, usize),
        wanted: &[Channel],
        one: T,
    ) -> Vec<T> {
        let mut out = Vec::with_capacity(width * height * wanted.len());
        for y in 0..height {
            let y = if self.upwards { height - 1 - y } else { y };
            for x in 0..width {
                let x = if self.leftwards { width - 1 - x } else { x };
                let texel = &pixels[(y * width + x) * from..][..from];
                out.extend(wanted.iter().map(|c| match c {
                    Channel::Zero => T::default(),
                    Channel::One => one,
                    Channel::From(i) => texel[usize::from(*i)],
                }));
            }
        }
        out
    }
}
