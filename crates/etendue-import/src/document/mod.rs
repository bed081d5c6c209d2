//! The glTF document as typed values: what the JSON says, before any binary data is looked at.
//!
//! Names and structure follow the glTF 2.0 specification (Khronos, 2021), section 5 "Properties Reference". A value of
//! the wrong type is a fault where the picture depends on it, a warning where it does not. Indices are as in the file;
//! who follows one checks it.

mod asset;
mod data;
pub(crate) mod drafts;
mod geometry;
mod ies;
mod material;
mod motion;
mod node;
mod sky;
pub(crate) mod surface;
mod variants;

pub(crate) use asset::{Asset, Scene};
pub(crate) use data::{Accessor, Buffer, BufferView, Component, Compressed, Shape, Sparse};
pub(crate) use geometry::{Mesh, Mode, Primitive, Target};
pub(crate) use ies::{IesLight, IesProfile};
pub(crate) use material::{Image, Material, Sampler, Texture, TextureInfo};
pub(crate) use motion::{Animation, Channel, Interpolation, Path, Skin};
pub(crate) use node::{Camera, Light, LightShape, Local, Node, Projection};
pub(crate) use sky::ImageLight;
pub(crate) use surface::Surface;
pub(crate) use variants::Mapping;

use crate::error::Fault;
use crate::extensions;
use crate::json::{Object, Reader};
use crate::limits::Limits;
use serde_json::Value;

/// The whole document.
pub(crate) struct Document<'v> {
    pub asset: Asset<'v>,
    pub scene: Option<u32>,
    pub scenes: Vec<Scene<'v>>,
    pub nodes: Vec<Node<'v>>,
    pub meshes: Vec<Mesh<'v>>,
    pub materials: Vec<Material<'v>>,
    pub textures: Vec<Texture>,
    pub images: Vec<Image<'v>>,
    pub samplers: Vec<Sampler>,
    pub cameras: Vec<Camera<'v>>,
    pub lights: Vec<Light<'v>>,
    /// `EXT_lights_ies`.
    pub ies_profiles: Vec<IesProfile<'v>>,
    /// `EXT_lights_image_based`.
    pub image_lights: Vec<ImageLight>,
    /// Packets of `KHR_xmp_json_ld`.
    pub xmp: Vec<&'v Value>,
    /// Names of `KHR_materials_variants`.
    pub variants: Vec<&'v str>,
    pub skins: Vec<Skin>,
    pub animations: Vec<Animation<'v>>,
    pub accessors: Vec<Accessor>,
    pub buffer_views: Vec<BufferView>,
    pub buffers: Vec<Buffer<'v>>,
    pub extensions_used: Vec<&'v str>,
    pub extensions_required: Vec<&'v str>,
    /// Whether drafts of extensions are read.
    pub drafts: bool,
}

impl<'v> Document<'v> {
    /// Reads the document from its JSON tree.
    pub fn read(r: &mut Reader<'v>, root: &'v Value, limits: &Limits) -> Result<Self, Fault> {
        let o = r.object(root)?;
        // Version and required extensions first: a file from the future should be told so, not that it is broken.
        let asset = Asset::read(r, o)?;
        let extensions_used = names(r, o, "extensionsUsed");
        let extensions_required = names(r, o, "extensionsRequired");
        extensions::check_required(&extensions_required, r.drafts)?;
        for (limit, most) in [("nodes", limits.nodes), ("accessors", limits.accessors)] {
            let count = o.get(limit).and_then(Value::as_array).map_or(0, Vec::len) as u64;
            if count > most {
                let what = format!("{count} {limit}");
                return Err(Fault::TooLarge { pointer: format!("/{limit}"), what, limit });
            }
        }
        let lights = r.extension(o, extensions::LIGHTS_PUNCTUAL, |r, o| r.list(o, "lights", Light::read))?;
        let ies_profiles =
            r.extension(o, extensions::LIGHTS_IES, |r, o| r.list(o, "lights", IesProfile::read))?;
        let image_lights =
            r.extension(o, extensions::LIGHTS_IMAGE_BASED, |r, o| r.list(o, "lights", ImageLight::read))?;
        let xmp = r.extension(o, extensions::XMP, |r, o| r.list(o, "packets", |_, v| Ok(v)))?;
        let variants = variants::names(r, o)?;
        r.other_extensions(o, &extensions::ON_ROOT);
        Ok(Self {
            asset,
            scene: r.opt(o, "scene", Reader::index)?,
            scenes: r.list(o, "scenes", Scene::read)?,
            nodes: r.list(o, "nodes", Node::read)?,
            meshes: r.list(o, "meshes", Mesh::read)?,
            materials: r.list(o, "materials", Material::read)?,
            textures: r.list(o, "textures", Texture::read)?,
            images: r.list(o, "images", Image::read)?,
            samplers: r.list(o, "samplers", Sampler::read)?,
            cameras: r.list(o, "cameras", Camera::read)?,
            lights: lights.unwrap_or_default(),
            image_lights: image_lights.unwrap_or_default(),
            xmp: xmp.unwrap_or_default(),
            ies_profiles: ies_profiles.unwrap_or_default(),
            variants,
            skins: r.list(o, "skins", Skin::read)?,
            animations: r.list(o, "animations", Animation::read)?,
            accessors: r.list(o, "accessors", Accessor::read)?,
            buffer_views: r.list(o, "bufferViews", BufferView::read)?,
            buffers: r.list(o, "buffers", Buffer::read)?,
            extensions_used,
            extensions_required,
            drafts: r.drafts,
        })
    }
}

/// A list of names; harmless when broken.
fn names<'v>(r: &mut Reader<'v>, o: &'v Object, key: &'static str) -> Vec<&'v str> {
    r.soft(o, key, |r, v| r.array(v, Reader::string)).unwrap_or_default()
}

/// The optional name of an object.
fn name<'v>(r: &mut Reader<'v>, o: &'v Object) -> &'v str {
    r.soft(o, "name", Reader::string).unwrap_or_default()
}

/// Looks up `list[index]`, or says that `pointer` refers to something that is not there.
pub(crate) fn get<'a, T>(
    list: &'a [T],
    index: u32,
    what: &str,
    pointer: impl FnOnce() -> String,
) -> Result<&'a T, Fault> {
    list.get(index as usize).ok_or_else(|| {
        Fault::invalid(pointer(), format!("{what} {index} does not exist; the file has {}", list.len()))
    })
}
