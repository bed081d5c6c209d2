//! Textures: which images are needed, decoded once each, all at the same time.

use crate::buffers::Buffers;
use crate::document::{self, Document, get};
use crate::error::Fault;
use crate::limits::shown;
use crate::source::Source;
use crate::uri;
use crate::warning::Warnings;
use etendue_image::{DecodeLimits, Image, ImageError, Ktx2, decode, is_tga};
use etendue_scene::{Filter, Sampler, Scene, Texture, TextureRef, Wrap};
use rayon::prelude::*;
use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// The textures that materials use, in the order in which they ask for them.
pub(crate) struct Textures<'a> {
    doc: &'a Document<'a>,
    /// Textures of the scene.
    pub textures: Vec<Texture>,
    /// Per image of the scene: the image of the file.
    pub images: Vec<u32>,
    by_content: HashMap<(u32, u8, u8, u8), u32>,
    by_place: HashMap<Place<'a>, u32>,
    by_image: HashMap<u32, u32>,
}

/// Where an image's bytes are: two images with the same place are one.
#[derive(PartialEq, Eq, Hash)]
enum Place<'a> {
    Uri(&'a str),
    View(u32),
}

impl<'a> Textures<'a> {
    pub fn new(doc: &'a Document<'a>) -> Self {
        Self {
            doc,
            textures: Vec::new(),
            images: Vec::new(),
            by_content: HashMap::new(),
            by_place: HashMap::new(),
            by_image: HashMap::new(),
        }
    }

    /// The scene's number of the file's texture `index`, to which `from` refers; `None`, with a warning, if it has no
    /// image that can be read.
    pub fn get(
        &mut self,
        index: u32,
        from: impl Fn() -> String,
        warnings: &mut Warnings,
    ) -> Result<Option<u32>, Fault> {
        let t = get(&self.doc.textures, index, "texture", from)?;
        let pointer = || format!("/textures/{index}");
        let Some(source) = t.source else {
            // An unsupported extension that holds the image has been named already.
            warnings.add(
                pointer(),
                if t.other_source {
                    "the texture has its image only in an extension that is not supported; shown without it"
                } else {
                    "the texture has no image; shown without it"
                },
            );
            return Ok(None);
        };
        let image = match self.by_image.get(&source) {
            Some(&known) => known,
            None => self.image(source, || format!("{}/source", pointer()))?,
        };
        let sampler = match t.sampler {
            None => Sampler::default(),
            Some(s) => {
                let s_pointer = || format!("{}/sampler", pointer());
                sampler(get(&self.doc.samplers, s, "sampler", s_pointer)?, s, warnings)
            }
        };
        let texture = Texture { image, sampler };
        let content = (image, sampler.wrap_u as u8, sampler.wrap_v as u8, sampler.filter as u8);
        Ok(Some(*self.by_content.entry(content).or_insert_with(|| {
            self.textures.push(texture);
            (self.textures.len() - 1) as u32
        })))
    }

    /// The scene's number of the file's image `index`, which is asked for the first time.
    fn image(&mut self, index: u32, from: impl Fn() -> String) -> Result<u32, Fault> {
        let image = get(&self.doc.images, index, "image", from)?;
        let place = match (image.uri, image.buffer_view) {
            (Some(uri), _) => Place::Uri(uri),
            (None, Some(view)) => Place::View(view),
            (None, None) => {
                return Err(Fault::invalid(format!("/images/{index}"), "has neither `uri` nor `bufferView`"));
            }
        };
        let number = *self.by_place.entry(place).or_insert_with(|| {
            self.images.push(index);
            (self.images.len() - 1) as u32
        });
        self.by_image.insert(index, number);
        Ok(number)
    }
}

fn sampler(s: &document::Sampler, index: u32, warnings: &mut Warnings) -> Sampler {
    let mut wrap = |value: Option<u64>, key: &str| match value {
        None | Some(10497) => Wrap::Repeat,
        Some(33071) => Wrap::Clamp,
        Some(33648) => Wrap::Mirror,
        Some(v) => {
            warnings.add(format!("/samplers/{index}/{key}"), format!("{v} is no wrap mode; taken as repeat"));
            Wrap::Repeat
        }
    };
    let (wrap_u, wrap_v) = (wrap(s.wrap_s, "wrapS"), wrap(s.wrap_t, "wrapT"));
    let filter = match s.mag_filter {
        None | Some(9729) => Filter::Linear,
        Some(9728) => Filter::Nearest,
        Some(v) => {
            warnings
                .add(format!("/samplers/{index}/magFilter"), format!("{v} is no filter; taken as linear"));
            Filter::Linear
        }
    };
    Sampler { wrap_u, wrap_v, filter }
}

/// The encoded bytes of image `index`.
pub(crate) fn bytes<'b>(
    doc: &Document<'_>,
    index: u32,
    buffers: &'b Buffers<'_>,
    source: &Source<'_>,
) -> Result<Cow<'b, [u8]>, Fault> {
    let pointer = format!("/images/{index}");
    let image = get(&doc.images, index, "image", || pointer.clone())?;
    match (image.uri, image.buffer_view) {
        (Some(uri), _) => source.read(uri, "image", &pointer).map(Cow::Owned),
        (None, Some(v)) => buffers.view(doc, v, || format!("{pointer}/bufferView")).map(Cow::Borrowed),
        (None, None) => Err(Fault::invalid(pointer, "has neither `uri` nor `bufferView`")),
    }
}

/// A decoded image and the size of its code.
#[derive(Clone)]
pub(crate) struct Decoded {
    pub image: Arc<Image>,
    pub encoded_bytes: u64,
    pub format: &'static str,
    /// Mips in the file.
    pub mips: u32,
    /// Whether the file says that its colours are encoded, or that they are not; most formats do not say.
    pub srgb: Option<bool>,
    /// The code itself, if it is to be kept.
    pub file: Option<Arc<Vec<u8>>>,
}

/// Reads and decodes images `which`, in parallel. Others that were decoded before take `already` bytes; `done` is told of each.
pub(crate) fn decode_all(
    doc: &Document<'_>,
    which: &[u32],
    buffers: &Buffers<'_>,
    source: &Source<'_>,
    already: u64,
    done: &(dyn Fn() + Sync),
) -> Vec<Result<Decoded, Fault>> {
    let (allowed, limit) = source.limits.for_images(source.used);
    let total = AtomicU64::new(already);
    which
        .par_iter()
        .map(|&i| {
            let code = bytes(doc, i, buffers, source)?;
            let limits = DecodeLimits { max_pixels: source.limits.image_pixels, max_bytes: allowed };
            let format = format_of(&code);
            let refused = |what: String| Fault::Unsupported {
                pointer: format!("/images/{i}"),
                what,
                hint: "; export the model with PNG, JPEG, WebP or Basis Universal textures".into(),
            };
            if format == "DDS" {
                return Err(refused("DDS textures".into()));
            }
            let fault = |e: ImageError| match e {
                ImageError::Unsupported { feature, .. } if format == "KTX2" => {
                    refused(format!("KTX2 textures with {feature}"))
                }
                ImageError::TooLarge { width, height, cause, .. } if cause.contains("the limit of") => {
                    let pixels = width.saturating_mul(height) > limits.max_pixels;
                    Fault::TooLarge {
                        pointer: format!("/images/{i}"),
                        what: format!("{width} × {height} pixels: {cause}"),
                        limit: if pixels { "image_pixels" } else { limit },
                    }
                }
                // What the PNG decoder needs beside the picture counts, too.
                e if e.to_string().contains("more memory than is allowed") => Fault::TooLarge {
                    pointer: format!("/images/{i}"),
                    what: format!("decodes to more than {}", shown(allowed)),
                    limit,
                },
                e => {
                    let d = &doc.images[i as usize];
                    let name = d.uri.map_or_else(|| format!("`{}`", uri::shorten(d.name)), uri::shorten);
                    Fault::Image { pointer: format!("/images/{i}"), image: name, message: e.to_string() }
                }
            };
            let (mut said, mut mips, mut srgb) = (format, 1, None);
            let image = if format == "KTX2" {
                let k = Ktx2::new(&code, &limits).map_err(fault)?;
                (mips, srgb) = (k.mips(), Some(k.is_srgb()));
                said = match k.coding() {
                    "ETC1S" => "KTX2 ETC1S",
                    "UASTC" => "KTX2 UASTC",
                    _ => format,
                };
                k.texture().map_err(fault)?
            } else {
                decode(&code, &limits).map_err(fault)?
            };
            source.dimensions(&image).map_err(|what| Fault::TooLarge {
                pointer: format!("/images/{i}"),
                what,
                limit: "image_dimension",
            })?;
            let size = image.bytes() as u64;
            if total.fetch_add(size, Ordering::Relaxed).saturating_add(size) > allowed {
                return Err(Fault::TooLarge {
                    pointer: "/images".into(),
                    what: format!("decodes to more than {}", shown(allowed)),
                    limit,
                });
            }
            let encoded_bytes = code.len() as u64;
            let file = source.keep_files.then(|| Arc::new(code.to_vec()));
            done();
            Ok(Decoded { image: Arc::new(image), encoded_bytes, format: said, mips, srgb, file })
        })
        .collect()
}

/// Warns of images that say of their colours what glTF does not have where they are used. glTF decides
/// (`KHR_texture_basisu`: colour textures have to be sRGB, others linear).
pub(crate) fn check_encoding(scene: &Scene, which: &[u32], decoded: &[Decoded], warnings: &mut Warnings) {
    let mut check = |t: Option<TextureRef>, color: bool| {
        let image = t.map(|t| scene.textures[t.texture as usize].image as usize);
        if let Some(i) = image
            && decoded[i].srgb == Some(!color)
        {
            warnings.add(
                format!("/images/{}", which[i]),
                if color {
                    "says that it is linear, but a material has it for colour; taken as sRGB"
                } else {
                    "says that it is sRGB, but a material has it for data; taken as it stands"
                },
            );
        }
    };
    for m in &scene.materials {
        check(m.base_color_texture, true);
        check(m.emissive_texture, true);
        check(m.metallic_roughness_texture, false);
        check(m.normal_texture.map(|n| n.texture), false);
    }
}

/// The picture format by its first bytes.
pub(crate) fn format_of(bytes: &[u8]) -> &'static str {
    match bytes {
        [0x89, b'P', b'N', b'G', ..] => "PNG",
        [0xff, 0xd8, ..] => "JPEG",
        [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => "WebP",
        [0xab, b'K', b'T', b'X', ..] => "KTX2",
        [b'D', b'D', b'S', b' ', ..] => "DDS",
        [b'B', b'M', ..] => "BMP",
        _ if is_tga(bytes) => "TGA",
        _ => "unknown",
    }
}
