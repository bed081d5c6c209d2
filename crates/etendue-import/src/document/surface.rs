//! The material extensions that change how a surface scatters, as the file says them: nothing clamped, nothing defaulted.

use super::TextureInfo;
use super::drafts::Drafts;
use super::material::with_factor;
use crate::error::Fault;
use crate::extensions as ext;
use crate::json::{Object, Reader};
use serde_json::Value;

/// `KHR_materials_anisotropy`.
#[derive(Clone, Copy, Default)]
pub(crate) struct Anisotropy {
    pub strength: Option<f64>,
    pub rotation: Option<f64>,
    pub texture: Option<TextureInfo>,
}

/// `KHR_materials_clearcoat`.
#[derive(Clone, Copy, Default)]
pub(crate) struct Clearcoat {
    pub factor: Option<f64>,
    pub texture: Option<TextureInfo>,
    pub roughness: Option<f64>,
    pub roughness_texture: Option<TextureInfo>,
    pub normal_texture: Option<TextureInfo>,
    pub normal_scale: Option<f64>,
}

/// `KHR_materials_diffuse_transmission`.
#[derive(Clone, Copy, Default)]
pub(crate) struct DiffuseTransmission {
    pub factor: Option<f64>,
    pub texture: Option<TextureInfo>,
    pub color: Option<[f64; 3]>,
    pub color_texture: Option<TextureInfo>,
}

/// `KHR_materials_iridescence`.
#[derive(Clone, Copy, Default)]
pub(crate) struct Iridescence {
    pub factor: Option<f64>,
    pub texture: Option<TextureInfo>,
    pub ior: Option<f64>,
    pub thickness_minimum: Option<f64>,
    pub thickness_maximum: Option<f64>,
    pub thickness_texture: Option<TextureInfo>,
}

/// `KHR_materials_sheen`.
#[derive(Clone, Copy, Default)]
pub(crate) struct Sheen {
    pub color: Option<[f64; 3]>,
    pub color_texture: Option<TextureInfo>,
    pub roughness: Option<f64>,
    pub roughness_texture: Option<TextureInfo>,
}

/// `KHR_materials_pbrSpecularGlossiness`.
#[derive(Clone, Copy, Default)]
pub(crate) struct SpecularGlossiness {
    pub diffuse: Option<[f64; 4]>,
    pub diffuse_texture: Option<TextureInfo>,
    pub specular: Option<[f64; 3]>,
    pub glossiness: Option<f64>,
    pub texture: Option<TextureInfo>,
}

/// `KHR_materials_transmission`.
#[derive(Clone, Copy, Default)]
pub(crate) struct Transmission {
    pub factor: Option<f64>,
    pub texture: Option<TextureInfo>,
}

/// `KHR_materials_volume`.
#[derive(Clone, Copy, Default)]
pub(crate) struct Volume {
    pub thickness: Option<f64>,
    pub thickness_texture: Option<TextureInfo>,
    pub attenuation_distance: Option<f64>,
    pub attenuation_color: Option<[f64; 3]>,
}

/// All of them; most materials have none.
#[derive(Clone, Copy, Default)]
pub(crate) struct Surface {
    pub anisotropy: Option<Anisotropy>,
    pub clearcoat: Option<Clearcoat>,
    pub diffuse_transmission: Option<DiffuseTransmission>,
    pub dispersion: Option<f64>,
    pub iridescence: Option<Iridescence>,
    pub sheen: Option<Sheen>,
    pub specular_glossiness: Option<SpecularGlossiness>,
    pub transmission: Option<Transmission>,
    pub volume: Option<Volume>,
    pub drafts: Drafts,
}

impl Surface {
    /// Reads those of the material `o`; `None` if it has none of them.
    pub fn read<'v>(r: &mut Reader<'v>, o: &'v Object) -> Result<Option<Box<Self>>, Fault> {
        let Some(Value::Object(e)) = o.get("extensions") else { return Ok(None) };
        if !e.keys().any(|k| ext::ON_SURFACE.contains(&k.as_str())) {
            return Ok(None);
        }
        let number = Reader::number;
        Ok(Some(Box::new(Self {
            anisotropy: r.extension(o, ext::ANISOTROPY, |r, o| {
                Ok(Anisotropy {
                    strength: r.soft(o, "anisotropyStrength", number),
                    rotation: r.soft(o, "anisotropyRotation", number),
                    texture: r.opt(o, "anisotropyTexture", TextureInfo::read)?,
                })
            })?,
            clearcoat: r.extension(o, ext::CLEARCOAT, |r, o| {
                let (normal_texture, normal_scale) = with_factor(r, o, "clearcoatNormalTexture", "scale")?;
                Ok(Clearcoat {
                    factor: r.soft(o, "clearcoatFactor", number),
                    texture: r.opt(o, "clearcoatTexture", TextureInfo::read)?,
                    roughness: r.soft(o, "clearcoatRoughnessFactor", number),
                    roughness_texture: r.opt(o, "clearcoatRoughnessTexture", TextureInfo::read)?,
                    normal_texture,
                    normal_scale,
                })
            })?,
            diffuse_transmission: r.extension(o, ext::DIFFUSE_TRANSMISSION, |r, o| {
                Ok(DiffuseTransmission {
                    factor: r.soft(o, "diffuseTransmissionFactor", number),
                    texture: r.opt(o, "diffuseTransmissionTexture", TextureInfo::read)?,
                    color: r.soft(o, "diffuseTransmissionColorFactor", Reader::numbers),
                    color_texture: r.opt(o, "diffuseTransmissionColorTexture", TextureInfo::read)?,
                })
            })?,
            dispersion: r
                .extension(o, ext::DISPERSION, |r, o| Ok(r.soft(o, "dispersion", number)))?
                .flatten(),
            iridescence: r.extension(o, ext::IRIDESCENCE, |r, o| {
                Ok(Iridescence {
                    factor: r.soft(o, "iridescenceFactor", number),
                    texture: r.opt(o, "iridescenceTexture", TextureInfo::read)?,
                    ior: r.soft(o, "iridescenceIor", number),
                    thickness_minimum: r.soft(o, "iridescenceThicknessMinimum", number),
                    thickness_maximum: r.soft(o, "iridescenceThicknessMaximum", number),
                    thickness_texture: r.opt(o, "iridescenceThicknessTexture", TextureInfo::read)?,
                })
            })?,
            sheen: r.extension(o, ext::SHEEN, |r, o| {
                Ok(Sheen {
                    color: r.soft(o, "sheenColorFactor", Reader::numbers),
                    color_texture: r.opt(o, "sheenColorTexture", TextureInfo::read)?,
                    roughness: r.soft(o, "sheenRoughnessFactor", number),
                    roughness_texture: r.opt(o, "sheenRoughnessTexture", TextureInfo::read)?,
                })
            })?,
            specular_glossiness: r.extension(o, ext::SPECULAR_GLOSSINESS, |r, o| {
                Ok(SpecularGlossiness {
                    diffuse: r.soft(o, "diffuseFactor", Reader::numbers),
                    diffuse_texture: r.opt(o, "diffuseTexture", TextureInfo::read)?,
                    specular: r.soft(o, "specularFactor", Reader::numbers),
                    glossiness: r.soft(o, "glossinessFactor", number),
                    texture: r.opt(o, "specularGlossinessTexture", TextureInfo::read)?,
                })
            })?,
            transmission: r.extension(o, ext::TRANSMISSION, |r, o| {
                Ok(Transmission {
                    factor: r.soft(o, "transmissionFactor", number),
                    texture: r.opt(o, "transmissionTexture", TextureInfo::read)?,
                })
            })?,
            volume: r.extension(o, ext::VOLUME, |r, o| {
                Ok(Volume {
                    thickness: r.soft(o, "thicknessFactor", number),
                    thickness_texture: r.opt(o, "thicknessTexture", TextureInfo::read)?,
                    attenuation_distance: r.soft(o, "attenuationDistance", number),
                    attenuation_color: r.soft(o, "attenuationColor", Reader::numbers),
                })
            })?,
            drafts: Drafts::read(r, o)?,
        })))
    }

    /// The numbers that the file gives, by the names of `etendue info`.
    pub fn factors(&self) -> impl Iterator<Item = (&'static str, Vec<f64>)> {
        let one = |v: Option<f64>| v.map(|v| vec![v]);
        let anisotropy = self.anisotropy.unwrap_or_default();
        let coat = self.clearcoat.unwrap_or_default();
        let diffuse = self.diffuse_transmission.unwrap_or_default();
        let film = self.iridescence.unwrap_or_default();
        let sheen = self.sheen.unwrap_or_default();
        let gloss = self.specular_glossiness.unwrap_or_default();
        let volume = self.volume.unwrap_or_default();
        [
            ("anisotropy", one(anisotropy.strength)),
            ("anisotropyRotation", one(anisotropy.rotation)),
            ("clearcoat", one(coat.factor)),
            ("clearcoatRoughness", one(coat.roughness)),
            ("clearcoatNormalScale", one(coat.normal_scale)),
            ("diffuseTransmission", one(diffuse.factor)),
            ("diffuseTransmissionColor", diffuse.color.map(Vec::from)),
            ("dispersion", one(self.dispersion)),
            ("iridescence", one(film.factor)),
            ("iridescenceIor", one(film.ior)),
            ("iridescenceThicknessMinimum", one(film.thickness_minimum)),
            ("iridescenceThicknessMaximum", one(film.thickness_maximum)),
            ("sheenColor", sheen.color.map(Vec::from)),
            ("sheenRoughness", one(sheen.roughness)),
            ("diffuse", gloss.diffuse.map(Vec::from)),
            ("specular (F0)", gloss.specular.map(Vec::from)),
            ("glossiness", one(gloss.glossiness)),
            ("transmission", one(self.transmission.and_then(|t| t.factor))),
            ("thickness", one(volume.thickness)),
            ("attenuationDistance", one(volume.attenuation_distance)),
            ("attenuationColor", volume.attenuation_color.map(Vec::from)),
        ]
        .into_iter()
        .filter_map(|(k, v)| Some((k, v?)))
        .chain(self.drafts.factors())
    }

    /// The textures that the file gives, by the names of `etendue info`.
    pub fn textures(&self) -> impl Iterator<Item = (&'static str, TextureInfo)> {
        let coat = self.clearcoat.unwrap_or_default();
        let diffuse = self.diffuse_transmission.unwrap_or_default();
        let film = self.iridescence.unwrap_or_default();
        let sheen = self.sheen.unwrap_or_default();
        let gloss = self.specular_glossiness.unwrap_or_default();
        [
            ("anisotropy", self.anisotropy.and_then(|e| e.texture)),
            ("clearcoat", coat.texture),
            ("clearcoatRoughness", coat.roughness_texture),
            ("clearcoatNormal", coat.normal_texture),
            ("diffuseTransmission", diffuse.texture),
            ("diffuseTransmissionColor", diffuse.color_texture),
            ("iridescence", film.texture),
            ("iridescenceThickness", film.thickness_texture),
            ("sheenColor", sheen.color_texture),
            ("sheenRoughness", sheen.roughness_texture),
            ("diffuse", gloss.diffuse_texture),
            ("specularGlossiness", gloss.texture),
            ("transmission", self.transmission.and_then(|e| e.texture)),
            ("thickness", self.volume.and_then(|e| e.thickness_texture)),
        ]
        .into_iter()
        .filter_map(|(k, t)| Some((k, t?)))
        .chain(self.drafts.textures())
    }
}
