//! What in a file is against its specification though every picture in it is clear.

use super::container::Scheme;
use super::descriptor::Model;
use super::{Channel, Ktx2, View};

/// Keys that the specification knows (KTX 2.0, 3.11, and its registered ones).
const KNOWN: [&str; 12] = [
    "KTXcubemapIncomplete",
    "KTXorientation",
    "KTXglFormat",
    "KTXdxgiFormat__",
    "KTXmetalPixelFormat",
    "KTXswizzle",
    "KTXwriter",
    "KTXwriterScParams",
    "KTXastcDecodeMode",
    "KTXanimData",
    "KTXmapRange",
    "KTXdfSampleNames",
];

/// Keys whose values are text that ends with a zero.
const TEXTS: [&str; 5] =
    ["KTXorientation", "KTXswizzle", "KTXwriter", "KTXwriterScParams", "KTXastcDecodeMode"];

/// Keys of other programs' formats: name, size of the value in bytes.
const FORMATS: [(&str, usize); 3] = [("KTXglFormat", 12), ("KTXdxgiFormat__", 4), ("KTXmetalPixelFormat", 4)];

/// Bits of `KTXcubemapIncomplete` that stand for faces.
const FACES: u8 = 0x3f;

impl Ktx2<'_> {
    /// What is against the specification (KTX 2.0, sections 3 and 4) but does not touch the pictures, a sentence each.
    pub fn remarks(&self) -> Vec<String> {
        let mut out = Vec::new();
        self.keys(&mut out);
        self.formats(&mut out);
        self.cube(&mut out);
        let c = &self.container;
        if c.depth > 1
            && let Some(o) = c.value("KTXorientation")
            && o.strip_suffix(b"\0").unwrap_or(o).len() < 3
        {
            out.push("KTXorientation does not say how a volume's slices run".into());
        }
        if !c.places.has_depth
            && let Some(o) = c.value("KTXorientation")
            && o.strip_suffix(b"\0").unwrap_or(o).len() > 2
        {
            out.push("KTXorientation has more letters than the texture dimensions".into());
        }
        if c.value("KTXanimData").is_some_and(|v| v.len() != 12) {
            out.push("KTXanimData has not 12 bytes".into());
        }
        if c.value("KTXanimData").is_some() && !c.places.has_layers {
            out.push("KTXanimData in a texture without layers".into());
        }
        if c.value("KTXanimData").is_some() && c.value("KTXcubemapIncomplete").is_some() {
            out.push("KTXanimData beside KTXcubemapIncomplete".into());
        }
        let p = &c.places;
        let before = if p.values.1 > 0 { p.values.0 + p.values.1 } else { p.descriptor.0 + p.descriptor.1 };
        if p.global.1 > 0 && p.global.0 != before.next_multiple_of(8) {
            out.push("the global data do not stand at the next multiple of 8".into());
        }
        let d = &self.descriptor;
        let expected = match d.model {
            Model::Plain => Some(d.texel_bytes),
            Model::Uastc | Model::Bc6h => Some(16),
            Model::Etc1s => None,
        };
        if expected.is_some_and(|n| c.scheme == Scheme::None && d.plane_bytes != n) {
            out.push("the descriptor does not give the bytes of a texel's block".into());
        }
        // 0 is not said, 1 is linear, 2 sRGB, where the mark may be left out.
        if d.transfer > 2 && d.samples.iter().any(|s| s.channel == 15 && !s.linear) {
            out.push("alpha is not marked as linear where the colours are not".into());
        }
        out
    }

    /// Order, padding and text of the key-value data.
    fn keys(&self, out: &mut Vec<String>) {
        let c = &self.container;
        let mut before: &[u8] = &[];
        let mut add = |s: String| {
            if !out.contains(&s) {
                out.push(s);
            }
        };
        for entry in c.entries() {
            if entry.key < before {
                add("the keys do not stand in the order of their bytes".into());
            }
            before = entry.key;
            if entry.padding.iter().any(|&b| b != 0) {
                add("padding that is not zero between the key-value data".into());
            }
            let Ok(key) = std::str::from_utf8(entry.key) else {
                add("a key that is no UTF-8".into());
                continue;
            };
            if key.get(..3).is_some_and(|k| k.eq_ignore_ascii_case("ktx"))
                && key.starts_with("KTX") | key.starts_with("ktx")
                && !KNOWN.contains(&key)
            {
                add(format!("the key {key} is reserved and not known"));
            }
            if TEXTS.contains(&key) {
                match entry.value.split_last() {
                    Some((0, text)) if std::str::from_utf8(text).is_ok() => {}
                    Some((0, _)) => add(format!("{key} is no UTF-8")),
                    _ => add(format!("{key} does not end with a zero")),
                }
            }
        }
        if !c.values_end_whole() {
            out.push("the key-value data do not fill their place".into());
        }
        if c.value("KTXwriterScParams").is_some() && c.value("KTXwriter").is_none() {
            out.push("KTXwriterScParams without KTXwriter".into());
        }
    }

    fn formats(&self, out: &mut Vec<String>) {
        let c = &self.container;
        for (key, size) in FORMATS {
            let Some(v) = c.value(key) else { continue };
            if v.len() != size {
                out.push(format!("{key} has not {size} bytes"));
            } else if c.format != 0 {
                out.push(format!("{key} beside a format of Vulkan"));
            } else if key == "KTXglFormat" && self.descriptor.model != Model::Plain {
                // glFormat and glType of compressed textures are 0; universal ones have no format of OpenGL at all.
                let zero = v.get(4..).is_some_and(|w| w.iter().all(|&b| b == 0));
                if !zero {
                    out.push(format!("{key} with a type of texels, which compressed data have not"));
                }
            }
        }
    }

    /// `KTXcubemapIncomplete` (3.11.1): which faces of a cube the layers are.
    fn cube(&self, out: &mut Vec<String>) {
        let c = &self.container;
        let Some(v) = c.value("KTXcubemapIncomplete") else { return };
        let &[bits] = v else {
            out.push("KTXcubemapIncomplete has not one byte".into());
            return;
        };
        let faces = (bits & FACES).count_ones();
        if bits & !FACES != 0 {
            out.push("KTXcubemapIncomplete has bits that are no faces".into());
        }
        if faces == 6 {
            out.push("KTXcubemapIncomplete says that no face is missing".into());
        }
        if faces == 0 {
            out.push("KTXcubemapIncomplete says that all faces are missing".into());
        } else if !c.layers.is_multiple_of(faces) {
            out.push("the layers are no multiple of the faces of KTXcubemapIncomplete".into());
        }
        if c.faces != 1 {
            out.push("KTXcubemapIncomplete in a whole cube".into());
        }
        if c.width != c.height || c.places.has_depth {
            out.push("KTXcubemapIncomplete in a texture that is no square of one slice".into());
        }
    }

    /// What is against `KHR_texture_basisu`, which allows glTF fewer forms of KTX2, a sentence each.
    pub fn remarks_for_gltf(&self) -> Vec<String> {
        let (c, d) = (&self.container, &self.descriptor);
        let mut out = Vec::new();
        let mut wrong = |is: bool, what: &str| {
            if is {
                out.push(format!("{what}, which glTF does not allow"));
            }
        };
        wrong(!matches!(d.model, Model::Etc1s | Model::Uastc), "texels that are neither ETC1S nor UASTC");
        wrong(
            d.model == Model::Uastc && !matches!(c.scheme, Scheme::None | Scheme::Zstandard),
            "UASTC packed other than by Zstandard",
        );
        let flat = c.faces == 1 && !c.places.has_layers && !c.places.has_depth && c.places.has_height;
        wrong(!flat, "a texture that is not one picture of two dimensions");
        wrong(
            !c.width.is_multiple_of(4) || !c.height.is_multiple_of(4),
            "a width or height that is no multiple of 4",
        );
        let all = 32 - c.width.max(c.height).leading_zeros();
        let levels = c.levels.len() as u32;
        wrong(levels != 1 && levels != all, "neither one mip nor all");
        let channels: Vec<u8> = d.samples.iter().map(|s| s.channel).collect();
        let known = match d.model {
            // RGB, RRR; with AAA or GGG as second: (KDF 1.3, table 5.27).
            Model::Etc1s => matches!(channels[..], [0] | [0, 15]),
            // RGB, RGBA.
            Model::Uastc => matches!(channels[..], [0] | [3]),
            _ => true,
        };
        wrong(!known, "channels other than RGB and RGBA");
        let color = (d.primaries, d.transfer);
        // Primaries BT.709 with sRGB, or unspecified ones and linear values.
        wrong(!matches!(color, (1, 2) | (0, 1)), "colours neither sRGB nor plain data");
        wrong(
            self.view.swizzle != View::PLAIN.swizzle
                && self.view.swizzle != [Channel::From(0), Channel::From(1), Channel::From(2), Channel::One],
            "a KTXswizzle other than rgba",
        );
        wrong(self.view.upwards || self.view.leftwards, "a KTXorientation other than rd");
        out
    }
}
