//! What a file contains, for people who want to know before they render.

use crate::assemble::Facts;
use crate::buffers::Buffers;
use crate::document::{Accessor, Document, LightShape, Mode, Projection};
use crate::extensions::{Support, is_draft, support};
use crate::sizes::Sizes;
use crate::texture::Decoded;
use crate::unusual;
use crate::uri;
use crate::warning::Warning;
use etendue_scene::{AlphaMode, Instance, Material, Scene};
use glam::Vec3;
use serde::Serialize;
use std::collections::HashMap;

/// The contents of a model file, and what became of them.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Info {
    /// Name or path of the file.
    pub file: String,
    /// `GLB`, `glTF`, `OBJ`, `PLY (text)` and so on.
    pub format: &'static str,
    /// Size of the file, bytes.
    pub bytes: u64,
    /// Size of the buffer files beside it, bytes.
    pub external_bytes: u64,
    /// Version of glTF that it was written for; empty for other formats.
    pub version: String,
    /// The program that wrote it, or the first comment of a format that has nothing else to say it.
    pub generator: Option<String>,
    /// What the format leaves open and how it was understood.
    pub assumed: Option<&'static str>,
    /// Whose it is.
    pub copyright: Option<String>,
    /// Name of the scene that is shown.
    pub scene: Option<String>,
    /// Where its bytes go.
    pub sizes: Sizes,
    /// What is allowed but odd: data that nothing refers to, pictures that are larger than they can be shown, and such.
    pub unusual: Vec<Warning>,
    /// What is against the specification though no picture depends on it, if the options ask for it.
    pub breaches: Vec<Warning>,
    /// How many of each there are.
    pub counts: Counts,
    /// Names of its material variants.
    pub variants: Vec<String>,
    /// The extensions that the file names.
    pub extensions: Vec<ExtensionInfo>,
    /// Its meshes.
    pub meshes: Vec<MeshInfo>,
    /// Its materials.
    pub materials: Vec<MaterialInfo>,
    /// Its images.
    pub images: Vec<ImageInfo>,
    /// What it says of itself in `KHR_xmp_json_ld`: packets of JSON-LD as they stand.
    pub xmp: Vec<serde_json::Value>,
    /// The packet that is about the whole file.
    pub xmp_of_asset: Option<u32>,
    /// Its cameras.
    pub cameras: Vec<CameraInfo>,
    /// Its punctual lights.
    pub lights: Vec<LightInfo>,
    /// Its animations.
    pub animations: Vec<AnimationInfo>,
}

/// Numbers of things: in the file, and in the scene that is shown.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Counts {
    /// Scenes in the file.
    pub scenes: u64,
    /// Nodes in the file.
    pub nodes: u64,
    /// Nodes that the scene shows.
    pub visible_nodes: u64,
    /// Meshes in the file.
    pub meshes: u64,
    /// Primitives in the file's meshes.
    pub primitives: u64,
    /// Triangles in the file's meshes, each counted once.
    pub triangles: u64,
    /// Vertices in the file's meshes, each counted once per primitive.
    pub vertices: u64,
    /// Materials in the file.
    pub materials: u64,
    /// Textures in the file.
    pub textures: u64,
    /// Images in the file.
    pub images: u64,
    /// Skins in the file.
    pub skins: u64,
    /// Placed meshes in the scene.
    pub instances: u64,
    /// Triangles in the scene, counted once per instance.
    pub shown_triangles: u64,
    /// Bytes of the scene's decoded images.
    pub image_bytes: u64,
}

/// An extension that a file names.
#[derive(Clone, Debug, Serialize)]
pub struct ExtensionInfo {
    /// Its name.
    pub name: String,
    /// Whether the file says that it cannot be shown without.
    pub required: bool,
    /// How far it is supported; `None` if it is unknown. A draft that was not asked for is ignored.
    pub support: Option<Support>,
    /// Whether it is a draft, which may still change.
    pub draft: bool,
}

/// A mesh of the file.
#[derive(Clone, Debug, Serialize)]
pub struct MeshInfo {
    /// Its name.
    pub name: String,
    /// Its primitives.
    pub primitives: Vec<PrimitiveInfo>,
}

/// A primitive of a mesh.
#[derive(Clone, Debug, Serialize)]
pub struct PrimitiveInfo {
    /// `triangles`, `strip`, `fan`, `lines`, `line loop`, `line strip` or `points`.
    pub mode: &'static str,
    /// Triangles that it makes.
    pub triangles: u64,
    /// Vertices that it has.
    pub vertices: u64,
    /// Names of its attributes.
    pub attributes: Vec<String>,
    /// Number of its material.
    pub material: Option<u32>,
    /// Number of its morph targets.
    pub morph_targets: u64,
}

/// A material of the file: what it sets.
#[derive(Clone, Debug, Serialize)]
pub struct MaterialInfo {
    /// Its name.
    pub name: String,
    /// `OPAQUE`, `MASK` or `BLEND`.
    pub alpha_mode: String,
    /// Whether it is seen from behind.
    pub double_sided: bool,
    /// Whether it is shown without lighting.
    pub unlit: bool,
    /// The factors that differ from glTF's defaults, as they stand in the file.
    pub factors: Vec<(&'static str, Vec<f64>)>,
    /// What it has textures for, with the number of the texture.
    pub textures: Vec<(&'static str, u32)>,
}

/// An image of the file.
#[derive(Clone, Debug, Default, Serialize)]
pub struct ImageInfo {
    /// Its name.
    pub name: String,
    /// Its file name; `None` if it is inside the model.
    pub uri: Option<String>,
    /// Whether the scene uses it; the fields below are known only then.
    pub used: bool,
    /// `PNG`, `JPEG`, `WebP`, `KTX2`, `KTX2 UASTC`, `KTX2 ETC1S`.
    pub format: &'static str,
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Channels per pixel.
    pub channels: u8,
    /// Bits per channel.
    pub bits: u32,
    /// Sizes in which the file has it. The largest is used: a pixel's samples integrate what mips would have averaged.
    pub mips: u32,
    /// Size of the coded image, bytes.
    pub bytes: u64,
    /// Size in memory, bytes.
    pub decoded_bytes: u64,
}

/// A camera of the file.
#[derive(Clone, Debug, Serialize)]
pub struct CameraInfo {
    /// Its name.
    pub name: String,
    /// `perspective` or `orthographic`.
    pub kind: &'static str,
    /// Vertical field of view (radians) or half height (metres).
    pub size: f64,
}

/// A punctual light of the file.
#[derive(Clone, Debug, Serialize)]
pub struct LightInfo {
    /// Its name.
    pub name: String,
    /// `directional`, `point`, `spot` or `unknown`.
    pub kind: &'static str,
    /// Candela, or lux for directional lights.
    pub intensity: f64,
}

/// An animation of the file.
#[derive(Clone, Debug, Serialize)]
pub struct AnimationInfo {
    /// Its name.
    pub name: String,
    /// Number of things that it moves.
    pub channels: u64,
}

impl Info {
    /// Describes the document itself.
    pub(crate) fn of_document(doc: &Document<'_>) -> Self {
        let mut info = Self {
            version: doc.asset.version.to_owned(),
            generator: doc.asset.generator.map(str::to_owned),
            copyright: doc.asset.copyright.map(str::to_owned),
            scene: doc
                .scenes
                .get(doc.scene.unwrap_or(0) as usize)
                .map(|s| s.name.to_owned())
                .filter(|n| !n.is_empty()),
            variants: doc.variants.iter().map(|&n| n.to_owned()).collect(),
            extensions: extensions(doc),
            meshes: doc.meshes.iter().map(|m| mesh(doc, m)).collect(),
            materials: doc.materials.iter().map(material).collect(),
            images: doc
                .images
                .iter()
                .map(|i| ImageInfo {
                    name: i.name.to_owned(),
                    uri: i.uri.filter(|u| !u.starts_with("data:")).map(uri::shorten),
                    ..ImageInfo::default()
                })
                .collect(),
            xmp: doc.xmp.iter().map(|&v| v.clone()).collect(),
            xmp_of_asset: doc.asset.xmp.filter(|&i| (i as usize) < doc.xmp.len()),
            cameras: doc.cameras.iter().map(camera).collect(),
            lights: doc.lights.iter().map(light).collect(),
            animations: doc
                .animations
                .iter()
                .map(|a| AnimationInfo { name: a.name.to_owned(), channels: a.channels.len() as u64 })
                .collect(),
            ..Self::default()
        };
        let primitives = || info.meshes.iter().flat_map(|m| &m.primitives);
        info.counts = Counts {
            scenes: doc.scenes.len() as u64,
            nodes: doc.nodes.len() as u64,
            meshes: doc.meshes.len() as u64,
            primitives: primitives().count() as u64,
            triangles: primitives().map(|p| p.triangles).fold(0, u64::saturating_add),
            vertices: primitives().map(|p| p.vertices).fold(0, u64::saturating_add),
            materials: doc.materials.len() as u64,
            textures: doc.textures.len() as u64,
            images: doc.images.len() as u64,
            skins: doc.skins.len() as u64,
            ..Counts::default()
        };
        info
    }

    /// Describes a scene that came from a format without documents of this kind.
    pub(crate) fn of_scene(scene: &Scene, images: &[Decoded], facts: Facts<'_>) -> Self {
        let meshes: Vec<MeshInfo> = scene.instances.iter().map(|i| scene_mesh(scene, i)).collect();
        let primitives = || meshes.iter().flat_map(|m| &m.primitives);
        let counts = Counts {
            meshes: meshes.len() as u64,
            primitives: meshes.len() as u64,
            triangles: primitives().map(|p| p.triangles).sum(),
            vertices: primitives().map(|p| p.vertices).sum(),
            materials: scene.materials.len() as u64,
            textures: scene.textures.len() as u64,
            images: images.len() as u64,
            instances: scene.instances.len() as u64,
            shown_triangles: scene.triangle_count(),
            image_bytes: images.iter().map(|d| d.image.bytes() as u64).sum(),
            ..Counts::default()
        };
        Self {
            file: facts.file.to_owned(),
            format: facts.format,
            bytes: facts.bytes,
            external_bytes: facts.external,
            generator: facts.comment,
            assumed: Some("units and axes are not said: taken as metres, +Y up"),
            sizes: Sizes {
                geometry: facts.bytes,
                images: images.iter().map(|d| d.encoded_bytes).sum(),
                ..Sizes::default()
            },
            counts,
            meshes,
            materials: scene.materials.iter().map(scene_material).collect(),
            images: images
                .iter()
                .map(|d| {
                    let mut info = ImageInfo::default();
                    info.set_decoded(d);
                    info
                })
                .collect(),
            ..Self::default()
        }
    }

    /// Adds what became of the document: `which` are the file's numbers of the `decoded` images.
    pub(crate) fn add_scene(
        &mut self,
        scene: &Scene,
        visible_nodes: usize,
        which: &[u32],
        decoded: &[Decoded],
        buffers: &Buffers<'_>,
    ) {
        self.external_bytes = buffers.external;
        self.counts.visible_nodes = visible_nodes as u64;
        self.counts.instances = scene.instances.len() as u64;
        self.counts.shown_triangles = scene.triangle_count();
        self.counts.image_bytes = decoded.iter().map(|d| d.image.bytes() as u64).sum();
        for (&i, d) in which.iter().zip(decoded) {
            let info = &mut self.images[i as usize];
            info.set_decoded(d);
            if info.uri.is_some() {
                self.sizes.images += d.encoded_bytes;
            }
        }
        let sizes = self.images.iter().enumerate().map(|(i, m)| (i, m.width, m.height));
        self.unusual.extend(unusual::of_images(sizes));
    }
}

impl ImageInfo {
    pub(crate) fn set_decoded(&mut self, d: &Decoded) {
        self.used = true;
        self.format = d.format;
        (self.width, self.height, self.channels) = (d.image.width, d.image.height, d.image.channels);
        self.mips = d.mips;
        self.bytes = d.encoded_bytes;
        self.decoded_bytes = d.image.bytes() as u64;
        self.bits = (8 * d.image.bytes() / d.image.len().max(1)) as u32;
    }
}

fn scene_mesh(scene: &Scene, i: &Instance) -> MeshInfo {
    let m = &scene.meshes[i.mesh as usize];
    let attributes = [
        ("positions", true),
        ("normals", !m.normals.is_empty()),
        ("tangents", !m.tangents.is_empty()),
        ("texture coordinates", !m.uvs.is_empty()),
        ("colours", !m.colors.is_empty()),
    ];
    let attributes = attributes.iter().filter(|(_, there)| *there).map(|(n, _)| (*n).to_owned());
    MeshInfo {
        name: m.name.clone(),
        primitives: vec![PrimitiveInfo {
            mode: "triangles",
            triangles: m.indices.len() as u64,
            vertices: m.positions.len() as u64,
            attributes: attributes.collect(),
            material: i.material,
            morph_targets: 0,
        }],
    }
}

fn scene_material(m: &Material) -> MaterialInfo {
    let wide = |v: Vec3| v.to_array().map(f64::from).to_vec();
    let e = m.extensions.as_deref();
    let factors = [
        ("baseColor", Some(wide(m.base_color))),
        ("alpha", (m.alpha != 1.0).then(|| vec![f64::from(m.alpha)])),
        ("metallic", Some(vec![f64::from(m.metallic)])),
        ("roughness", Some(vec![f64::from(m.roughness)])),
        ("emissive", (m.emissive != Vec3::ZERO).then(|| wide(m.emissive))),
        ("ior", (m.ior != 1.5).then(|| vec![f64::from(m.ior)])),
        ("specular", (m.specular != 1.0).then(|| vec![f64::from(m.specular)])),
        ("specularColor", (m.specular_color != Vec3::ONE).then(|| wide(m.specular_color))),
        ("sheenColor", e.and_then(|e| e.sheen).map(|s| wide(s.color))),
        ("clearcoat", e.and_then(|e| e.clearcoat).map(|c| vec![f64::from(c.factor)])),
        ("anisotropyStrength", e.and_then(|e| e.anisotropy).map(|a| vec![f64::from(a.strength)])),
        ("transmission", e.and_then(|e| e.transmission).map(|t| vec![f64::from(t.factor)])),
    ];
    let textures = [
        ("baseColor", m.base_color_texture),
        ("metallicRoughness", m.metallic_roughness_texture),
        ("normal", m.normal_texture.map(|n| n.texture)),
        ("occlusion", m.occlusion_texture),
        ("emissive", m.emissive_texture),
        ("specularColor", m.specular_color_texture),
        ("sheenColor", e.and_then(|e| e.sheen?.color_texture)),
    ];
    MaterialInfo {
        name: m.name.clone(),
        alpha_mode: match m.alpha_mode {
            AlphaMode::Opaque => "OPAQUE",
            AlphaMode::Mask(_) => "MASK",
            AlphaMode::Blend => "BLEND",
        }
        .to_owned(),
        double_sided: m.double_sided,
        unlit: m.unlit,
        factors: factors.into_iter().filter_map(|(k, v)| Some((k, v?))).collect(),
        textures: textures.into_iter().filter_map(|(k, t)| Some((k, t?.texture))).collect(),
    }
}

fn extensions(doc: &Document<'_>) -> Vec<ExtensionInfo> {
    let mut order: Vec<&str> = Vec::new();
    let mut required: HashMap<&str, bool> = HashMap::new();
    for (list, is_required) in [(&doc.extensions_used, false), (&doc.extensions_required, true)] {
        for &name in list {
            let entry = required.entry(name).or_insert_with(|| {
                order.push(name);
                false
            });
            *entry |= is_required;
        }
    }
    let info = |n: &str| {
        let (support, draft) = (support(n), is_draft(n));
        let support = if draft && !doc.drafts { Some(Support::Ignored) } else { support };
        ExtensionInfo { name: n.to_owned(), required: required[n], support, draft }
    };
    order.into_iter().map(info).collect()
}

fn mesh(doc: &Document<'_>, m: &crate::document::Mesh<'_>) -> MeshInfo {
    let count = |a: Option<u32>| a.and_then(|a| doc.accessors.get(a as usize)).map(|a: &Accessor| a.count);
    let primitive = |p: &crate::document::Primitive<'_>| {
        let vertices = count(p.attribute("POSITION")).unwrap_or(0);
        let corners = count(p.indices).unwrap_or(vertices);
        let (mode, triangles) = match p.mode {
            Mode::Points => ("points", 0),
            Mode::Lines => ("lines", 0),
            Mode::LineLoop => ("line loop", 0),
            Mode::LineStrip => ("line strip", 0),
            Mode::Triangles => ("triangles", corners / 3),
            Mode::Strip => ("strip", corners.saturating_sub(2)),
            Mode::Fan => ("fan", corners.saturating_sub(2)),
        };
        PrimitiveInfo {
            mode,
            triangles,
            vertices,
            attributes: p.attributes.iter().map(|(n, _)| (*n).to_owned()).collect(),
            material: p.material,
            morph_targets: p.targets.len() as u64,
        }
    };
    MeshInfo { name: m.name.to_owned(), primitives: m.primitives.iter().map(primitive).collect() }
}

fn material(m: &crate::document::Material<'_>) -> MaterialInfo {
    let specular = m.specular.unwrap_or_default();
    let one = |v: Option<f64>| v.map(|v| vec![v]);
    let factors = [
        ("baseColor", m.base_color.map(|v| v.to_vec())),
        ("metallic", one(m.metallic)),
        ("roughness", one(m.roughness)),
        ("normalScale", one(m.normal_scale)),
        ("occlusionStrength", one(m.occlusion_strength)),
        ("emissive", m.emissive.map(|v| v.to_vec())),
        ("emissiveStrength", one(m.emissive_strength)),
        ("alphaCutoff", one(m.alpha_cutoff)),
        ("ior", one(m.ior)),
        ("specular", one(specular.factor)),
        ("specularColor", specular.color.map(|v| v.to_vec())),
    ];
    let textures = [
        ("baseColor", m.base_color_texture),
        ("metallicRoughness", m.metallic_roughness_texture),
        ("normal", m.normal_texture),
        ("occlusion", m.occlusion_texture),
        ("emissive", m.emissive_texture),
        ("specular", specular.texture),
        ("specularColor", specular.color_texture),
    ];
    MaterialInfo {
        name: m.name.to_owned(),
        alpha_mode: m.alpha_mode.unwrap_or("OPAQUE").to_owned(),
        double_sided: m.double_sided,
        unlit: m.unlit,
        factors: factors
            .into_iter()
            .filter_map(|(k, v)| Some((k, v?)))
            .chain(m.surface.iter().flat_map(|s| s.factors()))
            .collect(),
        textures: textures
            .into_iter()
            .filter_map(|(k, t)| Some((k, t?)))
            .chain(m.surface.iter().flat_map(|s| s.textures()))
            .map(|(k, t)| (k, t.index))
            .collect(),
    }
}

fn camera(c: &crate::document::Camera<'_>) -> CameraInfo {
    let (kind, size) = match c.projection {
        Projection::Perspective { yfov, .. } => ("perspective", yfov),
        Projection::Orthographic { ymag, .. } => ("orthographic", ymag),
    };
    CameraInfo { name: c.name.to_owned(), kind, size }
}

fn light(l: &crate::document::Light<'_>) -> LightInfo {
    let kind = match l.shape {
        LightShape::Unknown => "unknown",
        LightShape::Directional => "directional",
        LightShape::Point => "point",
        LightShape::Spot { .. } => "spot",
    };
    LightInfo { name: l.name.to_owned(), kind, intensity: l.intensity }
}
