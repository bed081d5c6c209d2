//! Materials in glTF's words.

use super::document::Document;
use crate::extensions as ext;
use etendue_scene::{AlphaMode, Extensions, Material, NormalTexture, TextureRef};
use glam::Vec3;
use serde_json::{Map, Value, json};

/// An object under construction: values that are what their absence means are left out.
#[derive(Default)]
struct Object(Map<String, Value>);

impl Object {
    fn set(&mut self, key: &str, value: Value) {
        self.0.insert(key.into(), value);
    }

    fn number(&mut self, key: &str, value: f32, default: f32) {
        if value != default {
            self.set(key, json!(value));
        }
    }

    fn color(&mut self, key: &str, value: Vec3, default: Vec3) {
        if value != default {
            self.set(key, json!(value.to_array()));
        }
    }

    fn some(&mut self, key: &str, value: Option<Value>) {
        if let Some(v) = value {
            self.set(key, v);
        }
    }
}

/// Writes references to textures.
struct Writer<'a> {
    textures: &'a [Option<usize>],
    doc: &'a mut Document,
    notes: &'a mut Vec<String>,
}

impl Writer<'_> {
    fn texture(&mut self, t: Option<TextureRef>) -> Option<Value> {
        let t = t?;
        let number = (*self.textures.get(t.texture as usize)?)?;
        let mut out = json!({ "index": number });
        if t.uv_set != 0 {
            out["texCoord"] = json!(t.uv_set);
        }
        if t.transform != glam::Affine2::IDENTITY {
            self.doc.uses(ext::TEXTURE_TRANSFORM);
            out["extensions"] = json!({ ext::TEXTURE_TRANSFORM: self.transform(&t.transform) });
        }
        Some(out)
    }

    fn normal(&mut self, n: Option<NormalTexture>) -> Option<Value> {
        let n = n?;
        let mut out = self.texture(Some(n.texture))?;
        if n.scale != 1.0 {
            out["scale"] = json!(n.scale);
        }
        Some(out)
    }

    /// Scale, then rotation by `a`, then offset: columns (cos a, −sin a) x and (sin a, cos a) y.
    fn transform(&mut self, m: &glam::Affine2) -> Value {
        let (c0, c1) = (m.matrix2.x_axis.as_dvec2(), m.matrix2.y_axis.as_dvec2());
        let x = c0.length();
        let (c, s) = if x > 0.0 {
            (c0.x / x, -c0.y / x)
        } else {
            let y = c1.length().max(f64::MIN_POSITIVE);
            (c1.y / y, c1.x / y)
        };
        let y = c1.x * s + c1.y * c;
        if (c1.x * c - c1.y * s).abs() > 1e-5 * c1.length() {
            self.notes.push("a sheared texture transform, which KHR_texture_transform cannot say; written without the shear".into());
        }
        let mut out = Map::new();
        let t = m.translation;
        if t != glam::Vec2::ZERO {
            out.insert("offset".into(), json!(t.to_array()));
        }
        // No rotation at all rather than half a turn with both scales turned over.
        let (angle, x, y) = if s == 0.0 && c < 0.0 { (0.0, -x, -y) } else { (s.atan2(c), x, y) };
        if angle != 0.0 {
            out.insert("rotation".into(), json!(angle));
        }
        if (x, y) != (1.0, 1.0) {
            out.insert("scale".into(), json!([x, y]));
        }
        Value::Object(out)
    }
}

/// Material `m` as it stands in a file; `textures` are the file's numbers of the scene's textures.
pub(super) fn json(
    m: &Material,
    textures: &[Option<usize>],
    doc: &mut Document,
    notes: &mut Vec<String>,
) -> Value {
    if m.substitute.is_some() {
        notes.push("models and measurements in place of materials, which glTF cannot say; the materials under them are written".into());
    }
    let mut w = Writer { textures, doc, notes };
    let mut out = Object::default();
    if !m.name.is_empty() {
        out.set("name", json!(m.name));
    }
    let mut base = Object::default();
    let rgba = [m.base_color.x, m.base_color.y, m.base_color.z, m.alpha];
    if rgba != [1.0; 4] {
        base.set("baseColorFactor", json!(rgba));
    }
    base.some("baseColorTexture", w.texture(m.base_color_texture));
    base.number("metallicFactor", m.metallic, 1.0);
    base.number("roughnessFactor", m.roughness, 1.0);
    base.some("metallicRoughnessTexture", w.texture(m.metallic_roughness_texture));
    let mut e = Map::new();
    let gloss = m.extensions.as_ref().and_then(|x| x.specular_glossiness);
    if let Some(g) = gloss.filter(|_| !m.unlit) {
        let mut o = Object::default();
        if rgba != [1.0; 4] {
            o.set("diffuseFactor", json!(rgba));
        }
        o.some("diffuseTexture", w.texture(m.base_color_texture));
        o.color("specularFactor", g.specular, Vec3::ONE);
        o.number("glossinessFactor", g.glossiness, 1.0);
        o.some("specularGlossinessTexture", w.texture(g.texture));
        e.insert(ext::SPECULAR_GLOSSINESS.into(), Value::Object(o.0));
        // For readers that do not know the extension: a surface as rough as this one.
        base.set("metallicFactor", json!(0.0));
        base.set("roughnessFactor", json!(1.0 - g.glossiness));
    }
    if !base.0.is_empty() {
        out.set("pbrMetallicRoughness", Value::Object(base.0));
    }
    out.some("normalTexture", w.normal(m.normal_texture));
    if let Some(mut t) = w.texture(m.occlusion_texture) {
        if m.occlusion_strength != 1.0 {
            t["strength"] = json!(m.occlusion_strength);
        }
        out.set("occlusionTexture", t);
    }
    let strength = m.emissive.max_element();
    if strength > 1.0 {
        out.set("emissiveFactor", json!((m.emissive.as_dvec3() / f64::from(strength)).to_array()));
        e.insert(ext::EMISSIVE_STRENGTH.into(), json!({ "emissiveStrength": strength }));
    } else {
        out.color("emissiveFactor", m.emissive, Vec3::ZERO);
    }
    out.some("emissiveTexture", w.texture(m.emissive_texture));
    match m.alpha_mode {
        AlphaMode::Opaque => {}
        AlphaMode::Blend => out.set("alphaMode", json!("BLEND")),
        AlphaMode::Mask(cutoff) => {
            out.set("alphaMode", json!("MASK"));
            if cutoff != 0.5 {
                out.set("alphaCutoff", json!(cutoff));
            }
        }
    }
    if m.double_sided {
        out.set("doubleSided", json!(true));
    }
    if m.unlit {
        e.insert(ext::UNLIT.into(), json!({}));
    } else if gloss.is_none() {
        lit(m, &mut w, &mut e);
    }
    for name in e.keys() {
        // In the order of their names, whatever was written first.
        if let Some(known) = ext::ON_MATERIAL.into_iter().find(|k| k == name) {
            w.doc.uses(known);
        }
    }
    if !e.is_empty() {
        out.set("extensions", Value::Object(e));
    }
    Value::Object(out.0)
}

/// The extensions of a lit metal-rough surface.
fn lit(m: &Material, w: &mut Writer<'_>, e: &mut Map<String, Value>) {
    let mut add = |name: &str, o: Object| {
        e.insert(name.into(), Value::Object(o.0));
    };
    if m.ior != 1.5 {
        let mut o = Object::default();
        o.set("ior", json!(m.ior));
        add(ext::IOR, o);
    }
    let mut o = Object::default();
    o.number("specularFactor", m.specular, 1.0);
    o.some("specularTexture", w.texture(m.specular_texture));
    o.color("specularColorFactor", m.specular_color, Vec3::ONE);
    o.some("specularColorTexture", w.texture(m.specular_color_texture));
    if !o.0.is_empty() {
        add(ext::SPECULAR, o);
    }
    let Some(x) = m.extensions.as_deref() else { return };
    let Extensions {
        anisotropy,
        clearcoat,
        diffuse_roughness,
        diffuse_transmission,
        dispersion,
        fuzz,
        iridescence,
        scatter,
        sheen,
        specular_glossiness: _,
        transmission,
        volume,
    } = *x;
    if let Some(a) = anisotropy {
        let mut o = Object::default();
        o.number("anisotropyStrength", a.strength, 0.0);
        o.number("anisotropyRotation", a.rotation, 0.0);
        o.some("anisotropyTexture", w.texture(a.texture));
        add(ext::ANISOTROPY, o);
    }
    if let Some(c) = clearcoat.filter(|c| !c.is_plain()) {
        let mut o = Object::default();
        o.number("coatFactor", c.factor, 0.0);
        o.some("coatTexture", w.texture(c.texture));
        o.number("coatRoughnessFactor", c.roughness, 0.0);
        o.some("coatRoughnessTexture", w.texture(c.roughness_texture));
        o.some("coatNormalTexture", w.normal(c.normal_texture));
        o.number("coatIor", c.ior, 1.5);
        o.color("coatColorFactor", c.color, Vec3::ONE);
        o.some("coatColorTexture", w.texture(c.color_texture));
        o.number("coatDarkeningFactor", c.darkening, 1.0);
        o.number("coatAnisotropyStrength", c.anisotropy.strength, 0.0);
        o.number("coatAnisotropyRotation", c.anisotropy.rotation, 0.0);
        o.some("coatAnisotropyTexture", w.texture(c.anisotropy.texture));
        add(ext::COAT, o);
    }
    if let Some(f) = fuzz {
        let mut o = Object::default();
        o.number("fuzzFactor", f.factor, 0.0);
        o.some("fuzzTexture", w.texture(f.texture));
        o.color("fuzzColorFactor", f.color, Vec3::ONE);
        o.some("fuzzColorTexture", w.texture(f.color_texture));
        o.set("fuzzRoughnessFactor", json!(f.roughness));
        o.some("fuzzRoughnessTexture", w.texture(f.roughness_texture));
        add(ext::FUZZ, o);
    }
    // Also beside a coat, for readers that do not know it.
    if let Some(c) = clearcoat {
        let mut o = Object::default();
        o.number("clearcoatFactor", c.factor, 0.0);
        o.some("clearcoatTexture", w.texture(c.texture));
        o.number("clearcoatRoughnessFactor", c.roughness, 0.0);
        o.some("clearcoatRoughnessTexture", w.texture(c.roughness_texture));
        o.some("clearcoatNormalTexture", w.normal(c.normal_texture));
        add(ext::CLEARCOAT, o);
    }
    if let Some(d) = diffuse_roughness {
        let mut o = Object::default();
        o.number("diffuseRoughnessFactor", d.factor, 0.0);
        o.some("diffuseRoughnessTexture", w.texture(d.texture));
        add(ext::DIFFUSE_ROUGHNESS, o);
    }
    if let Some(d) = diffuse_transmission {
        let mut o = Object::default();
        o.number("diffuseTransmissionFactor", d.factor, 0.0);
        o.some("diffuseTransmissionTexture", w.texture(d.texture));
        o.color("diffuseTransmissionColorFactor", d.color, Vec3::ONE);
        o.some("diffuseTransmissionColorTexture", w.texture(d.color_texture));
        add(ext::DIFFUSE_TRANSMISSION, o);
    }
    if dispersion != 0.0 {
        let mut o = Object::default();
        o.set("dispersion", json!(dispersion));
        add(ext::DISPERSION, o);
    }
    if let Some(i) = iridescence {
        let mut o = Object::default();
        o.number("iridescenceFactor", i.factor, 0.0);
        o.some("iridescenceTexture", w.texture(i.texture));
        o.number("iridescenceIor", i.ior, 1.3);
        o.number("iridescenceThicknessMinimum", i.thickness[0], 100.0);
        o.number("iridescenceThicknessMaximum", i.thickness[1], 400.0);
        o.some("iridescenceThicknessTexture", w.texture(i.thickness_texture));
        add(ext::IRIDESCENCE, o);
    }
    if let Some(s) = sheen {
        let mut o = Object::default();
        o.color("sheenColorFactor", s.color, Vec3::ZERO);
        o.some("sheenColorTexture", w.texture(s.color_texture));
        o.number("sheenRoughnessFactor", s.roughness, 0.0);
        o.some("sheenRoughnessTexture", w.texture(s.roughness_texture));
        add(ext::SHEEN, o);
    }
    if let Some(t) = transmission {
        let mut o = Object::default();
        o.number("transmissionFactor", t.factor, 0.0);
        o.some("transmissionTexture", w.texture(t.texture));
        add(ext::TRANSMISSION, o);
    }
    if let Some(s) = scatter {
        let mut o = Object::default();
        if diffuse_transmission.is_some() {
            // Beside which the newer extension must not stand; in the older one the strength is in the colour.
            o.color("multiscatterColorFactor", s.color * s.strength, Vec3::ZERO);
        } else {
            o.number("scatterStrengthFactor", s.strength, 0.0);
            o.some("scatterStrengthTexture", w.texture(s.texture));
            o.color("multiscatterColorFactor", s.color, Vec3::ONE);
        }
        o.some("multiscatterColorTexture", w.texture(s.color_texture));
        o.number("scatterAnisotropy", s.anisotropy, 0.0);
        add(if diffuse_transmission.is_some() { ext::VOLUME_SCATTER } else { ext::SCATTER }, o);
    }
    if let Some(v) = volume {
        let mut o = Object::default();
        o.number("thicknessFactor", v.thickness, 0.0);
        o.some("thicknessTexture", w.texture(v.thickness_texture));
        if v.attenuation_distance.is_finite() {
            o.set("attenuationDistance", json!(v.attenuation_distance));
        }
        o.color("attenuationColor", v.attenuation_color, Vec3::ONE);
        add(ext::VOLUME, o);
    }
}
