//! What an `[override]` may say of a material: every parameter that glTF has for one.

use super::key::{Kind, Value};
use super::place::{Field, field};
use etendue_bxdf::model;
use etendue_bxdf::model::Field as _;
use etendue_bxdf::multiscatter::Compensation;
use etendue_scene::{
    AlphaMode, Anisotropy, Clearcoat, DiffuseRoughness, DiffuseTransmission, Extensions, Fuzz, Iridescence,
    Material, NormalTexture, Scatter, Sheen, SpecularGlossiness, TextureRef, Transmission, Volume,
};

/// A key of a surface.
pub(crate) struct SurfaceKey {
    pub field: Field<Material>,
    /// Whether it still counts when another model scatters in the material's place.
    pub stays: bool,
}

/// A texture slot of a surface.
pub(crate) struct TextureKey {
    pub key: super::Key,
    pub set: fn(&mut Material, Option<TextureRef>),
    pub stays: bool,
}

fn extensions(m: &mut Material) -> &mut Extensions {
    m.extensions.get_or_insert_default()
}
fn anisotropy(m: &mut Material) -> &mut Anisotropy {
    extensions(m).anisotropy.get_or_insert_default()
}
fn coat(m: &mut Material) -> &mut Clearcoat {
    extensions(m).clearcoat.get_or_insert_default()
}
fn rough(m: &mut Material) -> &mut DiffuseRoughness {
    extensions(m).diffuse_roughness.get_or_insert_default()
}
fn passes(m: &mut Material) -> &mut DiffuseTransmission {
    extensions(m).diffuse_transmission.get_or_insert_default()
}
fn fuzz(m: &mut Material) -> &mut Fuzz {
    extensions(m).fuzz.get_or_insert_default()
}
fn film(m: &mut Material) -> &mut Iridescence {
    extensions(m).iridescence.get_or_insert_default()
}
fn sheen(m: &mut Material) -> &mut Sheen {
    extensions(m).sheen.get_or_insert_default()
}
fn glossy(m: &mut Material) -> &mut SpecularGlossiness {
    extensions(m).specular_glossiness.get_or_insert_default()
}
fn refracts(m: &mut Material) -> &mut Transmission {
    extensions(m).transmission.get_or_insert_default()
}
fn scatters(m: &mut Material) -> &mut Scatter {
    extensions(m).scatter.get_or_insert_default()
}
fn volume(m: &mut Material) -> &mut Volume {
    extensions(m).volume.get_or_insert_default()
}

/// Factors and switches, in the order of glTF's documents. Factors are multiplied by the material's textures.
pub(crate) fn factors() -> Vec<SurfaceKey> {
    let field = field::<Material>;
    let unit = || Kind::UNIT;
    let plain = |field| SurfaceKey { field, stays: false };
    let stays = |field| SurfaceKey { field, stays: true };
    let compensations = Kind::choice(Compensation::CHOICES);
    vec![
        plain(field("base_color", Kind::Color, "Colour of the diffuse part or of the metal", |m, v| m.base_color = v.numbers().into()).or("[1, 1, 1]")),
        plain(field("metallic", unit(), "0 dielectric to 1 metal; ends the specular-glossiness workflow", |m, v| {
            m.metallic = v.f32();
            if let Some(e) = &mut m.extensions {
                e.specular_glossiness = None;
            }
        }).or("1")),
        plain(field("roughness", unit(), "Perceptual roughness: 0 mirror to 1", |m, v| {
            m.roughness = v.f32();
            if let Some(g) = m.extensions.as_mut().and_then(|e| e.specular_glossiness.as_mut()) {
                g.glossiness = 1.0 - v.f32();
            }
        }).or("1")),
        stays(field("normal_scale", Kind::ANY, "Strength of the normal map", |m, v| {
            if let Some(n) = &mut m.normal_texture {
                n.scale = v.f32();
            }
        }).or("1")),
        plain(field("occlusion_strength", unit(), "How much of the occlusion texture applies in real-time shading", |m, v| m.occlusion_strength = v.f32()).or("1")),
        stays(field("emissive", Kind::Color, "Radiance that it sends out", |m, v| m.emissive = v.numbers().into()).or("[0, 0, 0]")),
        stays(field("alpha", unit(), "Opacity, read as alpha_mode says", |m, v| m.alpha = v.f32()).or("1")),
        stays(field("alpha_mode", Kind::choice(&["opaque", "mask", "blend"]), "How opacity is read: ignored, there or not by alpha_cutoff, or as coverage", |m, v| {
            m.alpha_mode = match (v.text(), m.alpha_mode) {
                ("blend", _) => AlphaMode::Blend,
                ("mask", AlphaMode::Mask(cutoff)) => AlphaMode::Mask(cutoff),
                ("mask", _) => AlphaMode::Mask(0.5),
                _ => AlphaMode::Opaque,
            };
        }).or("\"opaque\"")),
        stays(field("alpha_cutoff", unit(), "There where the opacity is at least this; makes alpha_mode \"mask\"", |m, v| m.alpha_mode = AlphaMode::Mask(v.f32())).or("0.5")),
        stays(field("double_sided", Kind::Flag, "Whether it is seen from behind", |m, v| m.double_sided = v.flag()).or("false")),
        plain(field("unlit", Kind::Flag, "Show the base colour as it is, without lighting", |m, v| m.unlit = v.flag()).or("false")),
        plain(field("ior", Kind::Number([0.0, 100.0]), "Index of refraction; 0 reflects everything", |m, v| m.ior = v.f32()).or("1.5")),
        plain(field("specular", unit(), "Strength of a dielectric's reflection", |m, v| m.specular = v.f32()).or("1")),
        plain(field("specular_color", Kind::Color, "Tints a dielectric's reflection", |m, v| m.specular_color = v.numbers().into()).or("[1, 1, 1]")),
        plain(field("compensation", compensations, "What is done about light that meets several microfacets", |m, v| {
            let word = Compensation::CHOICES.iter().find(|c| **c == v.text());
            if let Some(way) = word.and_then(|w| Compensation::from_value(model::Value::Choice(w))) {
                m.compensation = way;
            }
        })),
        plain(field("anisotropy_strength", unit(), "How much highlights are stretched", |m, v| anisotropy(m).strength = v.f32()).or("0")),
        plain(field("anisotropy_rotation", Kind::ANY, "Direction of the stretch: radians from the tangent, counter-clockwise", |m, v| anisotropy(m).rotation = v.f32()).or("0")),
        plain(field("clearcoat", unit(), "Coverage of a layer of lacquer", |m, v| coat(m).factor = v.f32()).or("0")),
        plain(field("clearcoat_roughness", unit(), "Perceptual roughness of the lacquer", |m, v| coat(m).roughness = v.f32()).or("0")),
        plain(field("clearcoat_normal_scale", Kind::ANY, "Strength of the lacquer's normal map", |m, v| {
            if let Some(n) = m.extensions.as_mut().and_then(|e| e.clearcoat.as_mut()?.normal_texture.as_mut()) {
                n.scale = v.f32();
            }
        }).or("1")),
        plain(field("coat_ior", Kind::Number([0.0, 100.0]), "Index of the lacquer; 0 reflects everything", |m, v| coat(m).ior = v.f32()).or("1.5")),
        plain(field("coat_color", Kind::Color, "What is left of white light that goes through the lacquer and back", |m, v| coat(m).color = v.numbers().into()).or("[1, 1, 1]")),
        plain(field("coat_darkening", unit(), "How much light between lacquer and base darkens the base", |m, v| coat(m).darkening = v.f32()).or("0")),
        plain(field("coat_anisotropy_strength", unit(), "How much the lacquer's highlights are stretched", |m, v| coat(m).anisotropy.strength = v.f32()).or("0")),
        plain(field("coat_anisotropy_rotation", Kind::ANY, "Direction of that stretch: radians from the tangent, counter-clockwise", |m, v| coat(m).anisotropy.rotation = v.f32()).or("0")),
        plain(field("diffuse_roughness", unit(), "Roughness of what is scattered diffusely: 0 even to 1", |m, v| rough(m).factor = v.f32()).or("0")),
        plain(field("diffuse_transmission", unit(), "Part of the diffuse light that passes, as through a leaf", |m, v| passes(m).factor = v.f32()).or("0")),
        plain(field("diffuse_transmission_color", Kind::Color, "Colour of what passes", |m, v| passes(m).color = v.numbers().into()).or("[1, 1, 1]")),
        plain(field("dispersion", Kind::POSITIVE, "20 over the Abbe number of the interior; 0 for none", |m, v| extensions(m).dispersion = v.f32()).or("0")),
        plain(field("fuzz", unit(), "Coverage by fibres or dust, on top of everything", |m, v| fuzz(m).factor = v.f32()).or("0")),
        plain(field("fuzz_color", Kind::Color, "Colour of the fuzz", |m, v| fuzz(m).color = v.numbers().into()).or("[1, 1, 1]")),
        plain(field("fuzz_roughness", unit(), "Roughness of the fuzz: 0 upright fibres to 1 dust", |m, v| fuzz(m).roughness = v.f32()).or("0.5")),
        plain(field("iridescence", unit(), "Coverage of a thin film", |m, v| film(m).factor = v.f32()).or("0")),
        plain(field("iridescence_ior", Kind::Number([1.0, 100.0]), "Index of the film", |m, v| film(m).ior = v.f32()).or("1.3")),
        plain(field("iridescence_thickness", Kind::Numbers(vec![1, 2]), "Thickness of the film, nanometres; or where its texture is 0 and where it is 1 or absent", |m, v| {
            film(m).thickness = match v {
                Value::Numbers(n) if n.len() == 1 => v.numbers::<1>().map(|t| [t; 2])[0],
                v => v.numbers(),
            }
            .map(|t| t.max(0.0));
        }).or("[100, 400]")),
        plain(field("sheen_color", Kind::Color, "Colour and strength of sheen, fibres under the lacquer", |m, v| sheen(m).color = v.numbers().into()).or("[0, 0, 0]")),
        plain(field("sheen_roughness", unit(), "Perceptual roughness of sheen", |m, v| sheen(m).roughness = v.f32()).or("0")),
        plain(field("glossiness", unit(), "1 − roughness; of the older specular-glossiness workflow, which this begins", |m, v| glossy(m).glossiness = v.f32()).or("1")),
        plain(field("glossiness_specular", Kind::Color, "Reflection at normal incidence; of the specular-glossiness workflow, which this begins", |m, v| glossy(m).specular = v.numbers().into()).or("[1, 1, 1]")),
        plain(field("transmission", unit(), "Part of the light that is refracted instead of scattered diffusely", |m, v| refracts(m).factor = v.f32()).or("0")),
        plain(field("thickness", Kind::POSITIVE, "Above 0 the surface encloses a body; at 0 it is a thin sheet. Rasterisers need the number, in the mesh's units", |m, v| volume(m).thickness = v.f32()).or("0")),
        plain(field("attenuation_distance", Kind::POSITIVE, "Metres inside the body after which white light has the attenuation colour [default: endless]", |m, v| volume(m).attenuation_distance = if v.f32() > 0.0 { v.f32() } else { f32::MIN_POSITIVE })),
        plain(field("scatter_strength", unit(), "How much of what is refracted is scattered: in the body, or by the sheet", |m, v| scatters(m).strength = v.f32()).or("0")),
        plain(field("multiscatter_color", Kind::Color, "Colour of a deep body in which light is scattered, or of the light that a sheet scatters", |m, v| scatters(m).color = v.numbers().into()).or("[1, 1, 1]")),
        plain(field("scatter_anisotropy", Kind::Number([-1.0, 1.0]), "Where to: -1 back, 0 evenly, 1 straight on", |m, v| scatters(m).anisotropy = v.f32()).or("0")),
        plain(field("attenuation_color", Kind::Color, "Colour of white light after that distance", |m, v| volume(m).attenuation_color = v.numbers().into()).or("[1, 1, 1]")),
    ]
}

fn normal(t: Option<TextureRef>) -> Option<NormalTexture> {
    t.map(|texture| NormalTexture { texture, scale: 1.0 })
}

/// The places for textures.
pub(crate) fn textures() -> Vec<TextureKey> {
    let slot = |name: &str, about: &str, stays: bool, set: fn(&mut Material, Option<TextureRef>)| {
        TextureKey { key: super::Key::new(name, Kind::Texture, about), set, stays }
    };
    vec![
        slot("base_color_texture", "Base colour (sRGB), and opacity in alpha", true, |m, t| {
            m.base_color_texture = t
        }),
        slot("metallic_roughness_texture", "Roughness in green, metalness in blue", false, |m, t| {
            m.metallic_roughness_texture = t
        }),
        slot("normal_texture", "Normal map, +Y up", true, |m, t| m.normal_texture = normal(t)),
        slot("occlusion_texture", "Ambient occlusion in red, for real-time shading", false, |m, t| {
            m.occlusion_texture = t
        }),
        slot("emissive_texture", "Emission (sRGB)", true, |m, t| m.emissive_texture = t),
        slot("specular_texture", "Strength of the dielectric reflection in alpha", false, |m, t| {
            m.specular_texture = t
        }),
        slot("specular_color_texture", "Tint of the dielectric reflection (sRGB)", false, |m, t| {
            m.specular_color_texture = t
        }),
        slot(
            "anisotropy_texture",
            "Direction of the stretch in red and green, strength in blue",
            false,
            |m, t| anisotropy(m).texture = t,
        ),
        slot("clearcoat_texture", "Coverage of the lacquer in red", false, |m, t| coat(m).texture = t),
        slot("clearcoat_roughness_texture", "Roughness of the lacquer in green", false, |m, t| {
            coat(m).roughness_texture = t
        }),
        slot("clearcoat_normal_texture", "Normal map of the lacquer, +Y up", false, |m, t| {
            coat(m).normal_texture = normal(t)
        }),
        slot("coat_color_texture", "Colour of the lacquer (sRGB)", false, |m, t| coat(m).color_texture = t),
        slot(
            "coat_anisotropy_texture",
            "Direction of the lacquer's stretch in red and green, strength in blue",
            false,
            |m, t| coat(m).anisotropy.texture = t,
        ),
        slot("fuzz_texture", "Coverage by fuzz in red", false, |m, t| fuzz(m).texture = t),
        slot("fuzz_color_texture", "Colour of the fuzz (sRGB)", false, |m, t| fuzz(m).color_texture = t),
        slot("fuzz_roughness_texture", "Roughness of the fuzz in alpha", false, |m, t| {
            fuzz(m).roughness_texture = t
        }),
        slot(
            "diffuse_roughness_texture",
            "Roughness of what is scattered diffusely, in red",
            false,
            |m, t| rough(m).texture = t,
        ),
        slot("diffuse_transmission_texture", "Part that passes diffusely, in alpha", false, |m, t| {
            passes(m).texture = t
        }),
        slot(
            "diffuse_transmission_color_texture",
            "Colour of what passes diffusely (sRGB)",
            false,
            |m, t| passes(m).color_texture = t,
        ),
        slot("iridescence_texture", "Coverage of the film in red", false, |m, t| film(m).texture = t),
        slot("iridescence_thickness_texture", "Thickness of the film in green", false, |m, t| {
            film(m).thickness_texture = t
        }),
        slot("scatter_strength_texture", "How much is scattered, in alpha", false, |m, t| {
            scatters(m).texture = t
        }),
        slot("multiscatter_color_texture", "Colour of what is scattered (sRGB)", false, |m, t| {
            scatters(m).color_texture = t
        }),
        slot("sheen_color_texture", "Colour of the sheen (sRGB)", false, |m, t| sheen(m).color_texture = t),
        slot("sheen_roughness_texture", "Roughness of the sheen in alpha", false, |m, t| {
            sheen(m).roughness_texture = t
        }),
        slot("glossiness_texture", "Specular colour (sRGB), and glossiness in alpha", false, |m, t| {
            glossy(m).texture = t
        }),
        slot("transmission_texture", "Part that is refracted, in red", false, |m, t| refracts(m).texture = t),
        slot("thickness_texture", "Thickness in green", false, |m, t| volume(m).thickness_texture = t),
    ]
}
