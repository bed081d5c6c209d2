//! A film becomes pictures: the beauty image, and layers for compositing.

use crate::film::{BEAUTY_PLANES, Film};
use crate::ids::ranked;
use crate::{Pass, name_hash};
use etendue_image::{ChannelData, Image, Layer, Metadata, Pixels};
use etendue_scene::Scene;
use std::collections::BTreeMap;

/// Cryptomatte keeps this many ids per pixel, two to a layer.
const RANKS: usize = 6;

impl Film {
    /// The beauty picture: linear Rec.709 floats; four channels with premultiplied alpha if `transparent`, else three.
    pub fn picture(&self, transparent: bool) -> Image {
        let channels = if transparent { 4 } else { 3 };
        let pixels = self.beauty().iter().flat_map(|p| p[..channels].to_vec()).collect();
        Image {
            width: self.width,
            height: self.height,
            channels: channels as u8,
            pixels: Pixels::F32(pixels),
        }
    }

    /// Beauty (with alpha if `transparent`), every recorded pass, and `error`, the standard error of the luminance.
    ///
    /// Normal, position, depth and texture coordinates are means over the samples that met a surface. Ids are stored as
    /// Cryptomatte (specification 1.2.0); their layers' metadata are returned beside, with the names from `names` (objects,
    /// materials).
    pub fn layers(&self, transparent: bool, names: &[Vec<String>; 2]) -> (Vec<Layer>, Metadata) {
        let mut layers = Vec::new();
        let mut metadata = Metadata::default();
        let n = if transparent { 4 } else { 3 };
        let plane = |p: usize| (0..self.pixels()).map(|i| self.mean(i, p)).collect::<Vec<f32>>();
        let beauty = ["R", "G", "B", "A"];
        let channels = (0..n).map(|c| (beauty[c].into(), ChannelData::Color(plane(c)))).collect();
        layers.push(Layer { name: String::new(), channels });
        let mut at = BEAUTY_PLANES;
        for pass in self.passes.iter() {
            match pass {
                Pass::ObjectId | Pass::MaterialId => {
                    let which = usize::from(pass == Pass::MaterialId);
                    let title = if which == 0 { "CryptoObject" } else { "CryptoMaterial" };
                    layers.extend(self.cryptomatte(which, title));
                    describe_cryptomatte(&mut metadata, title, &names[which]);
                }
                _ => {
                    let over_surface = matches!(pass, Pass::Normal | Pass::Position | Pass::Depth | Pass::Uv);
                    let coverage =
                        |i: usize| if over_surface { self.mean(i, 3).max(f32::MIN_POSITIVE) } else { 1.0 };
                    let channels = pass
                        .channels()
                        .iter()
                        .enumerate()
                        .map(|(c, name)| {
                            let v = (0..self.pixels()).map(|i| self.mean(i, at + c) / coverage(i)).collect();
                            let data = if over_surface { ChannelData::F32(v) } else { ChannelData::Color(v) };
                            (name.to_string(), data)
                        })
                        .collect();
                    at += pass.channels().len();
                    layers.push(Layer { name: pass.name().into(), channels });
                }
            }
        }
        let error = ChannelData::F32(self.standard_error().iter().map(|e| e.min(f32::MAX)).collect());
        layers.push(Layer { name: "error".into(), channels: vec![("Y".into(), error)] });
        (layers, metadata)
    }

    fn cryptomatte(&self, kind: usize, title: &str) -> Vec<Layer> {
        let ranks: Vec<_> = self.ids[kind].iter().map(|c| ranked(c, self.samples(), RANKS)).collect();
        (0..RANKS / 2)
            .map(|l| {
                let channel = |k: usize| ranks.iter().map(|r| r[l * 2 + k / 2][k % 2]).collect();
                let names = ["R", "G", "B", "A"];
                Layer {
                    name: format!("{title}{l:02}"),
                    channels: (0..4).map(|k| (names[k].into(), ChannelData::F32(channel(k)))).collect(),
                }
            })
            .collect()
    }
}

/// Names of a scene's objects and materials, for [`Film::layers`].
pub fn id_names(scene: &Scene) -> [Vec<String>; 2] {
    [
        scene.instances.iter().map(|i| i.name.clone()).collect(),
        scene.materials.iter().map(|m| m.name.clone()).collect(),
    ]
}

fn describe_cryptomatte(metadata: &mut Metadata, title: &str, names: &[String]) {
    let manifest: BTreeMap<&str, String> =
        names.iter().map(|n| (n.as_str(), format!("{:08x}", name_hash(n)))).collect();
    // The key is the first seven digits of the layer name's hash (specification, section "Metadata").
    let key = format!("{:08x}", name_hash(title))[..7].to_string();
    metadata.set(format!("cryptomatte/{key}/name"), title);
    metadata.set(format!("cryptomatte/{key}/hash"), "MurmurHash3_32");
    metadata.set(format!("cryptomatte/{key}/conversion"), "uint32_to_float32");
    let manifest = serde_json::to_string(&manifest).expect("names are text");
    metadata.set(format!("cryptomatte/{key}/manifest"), manifest);
}
