//! MTL materials as metal-rough surfaces.
//!
//! | MTL | becomes |
//! |---|---|
//! | `Kd`, `map_Kd` | base colour (linear factor, sRGB picture); `Kd 0 0 0` beside a picture counts as white |
//! | `Ks` | whether a dielectric reflects (not black), and in what tint (`KHR_materials_specular`); its scale means something else in each program. With a black `Kd`, and nothing that passes light, it is the colour of a metal |
//! | `map_Ks` | tint of the reflection |
//! | `Ns`, `map_Ns` | roughness: a Blinn-Phong lobe of exponent n is as wide as a microfacet lobe with α² = 2/(n + 2) (Walter et al. 2007, §5.2), so roughness = (2/(n + 2))^¼ |
//! | `illum` 0, 1 | no reflection |
//! | `illum` 6, 7 | transmission with refraction (`KHR_materials_transmission`, `_volume`), tinted by `Tf` |
//! | `Ni` | index of refraction, where it is above 1 (1 is what programs write that do not know) |
//! | `d`, `Tr`, `map_d` | alpha, blended; `Tr` = 1 − `d` |
//! | `Ke`, `map_Ke` | emission |
//! | `norm` | normal map, +Y up |
//! | `bump`, `map_Bump` | normal map if it looks like one, with `-bm` as its scale; else a height map whose full range is `-bm` hundredths of the picture's width, made into a normal map |
//! | `Pr`, `Pm`, `map_Pr`, `map_Pm` | roughness, metalness; one coloured picture for both holds them in G and B |
//! | `map_ORM` | occlusion, roughness, metalness in R, G, B |
//! | `Ps`, `map_Ps` | sheen, white, as rough as the surface |
//! | `Pc`, `Pcr`, `map_Pc`, `map_Pcr` | clearcoat and its roughness |
//! | `aniso`, `anisor` | anisotropy and its rotation in turns |
//!
//! `Ka`, `map_Ka`, `sharpness` have no meaning where light is computed and are passed over; `disp`, `decal`, `refl` are named in
//! warnings.

use super::library::{Libraries, Map, Mtl};
use super::parse::Obj;
use super::pictures::{
    Channel, Pictures, Which, is_normal_map, metal_rough, normals_of_heights, spread, with_alpha,
};
use crate::assemble::{Assembly, plain};
use crate::error::Fault;
use crate::source::Source;
use crate::texture::Decoded;
use crate::warning::Warnings;
use etendue_image::Image;
use etendue_scene::{
    AlphaMode, Anisotropy, Clearcoat, Extensions, Material, NormalTexture, Sampler, Sheen, TextureRef,
    Transmission, Volume, Wrap,
};
use glam::{Affine2, Mat2, Vec2, Vec3};
use std::collections::HashMap;
use std::sync::Arc;

/// Adds a surface for each material that a face has; returns the number of each of [`Obj::materials`].
pub(super) fn convert_all(
    obj: &Obj,
    libraries: &Libraries,
    source: &Source<'_>,
    out: &mut Assembly,
    warnings: &mut Warnings,
) -> Result<Vec<Option<u32>>, Fault> {
    let mut used = vec![false; obj.materials.len()];
    for g in &obj.groups {
        g.material.into_iter().for_each(|m| used[m as usize] = true);
    }
    let found = |i: usize| libraries.get(obj.materials[i].as_bytes());
    let mut maps: Vec<(&Map, &str)> = Vec::new();
    for m in (0..used.len()).filter(|&i| used[i]).filter_map(found) {
        let mut list: Vec<_> = m.maps.iter().filter(|(k, _)| USED.contains(&&k[..])).collect();
        list.sort_unstable_by_key(|(k, _)| *k);
        maps.extend(list.into_iter().map(|(_, map)| (map, &m.place[..])));
    }
    let pictures = Pictures::load(&maps, source, warnings)?;
    let mut shared = HashMap::new();
    let mut numbers = vec![None; used.len()];
    for i in (0..used.len()).filter(|&i| used[i]) {
        let name = &obj.materials[i];
        let mut material = match found(i) {
            Some(m) => {
                let mut maker = Maker { m, pictures: &pictures, shared: &mut shared, out, warnings };
                maker.material()
            }
            None => {
                let why =
                    if libraries.is_empty() { "there is no material library" } else { "no library has it" };
                warnings.add("usemtl", format!("the material `{name}` is not there ({why}); shown plain"));
                plain()
            }
        };
        material.name.clone_from(name);
        numbers[i] = Some(out.materials.len() as u32);
        out.materials.push(material);
    }
    Ok(numbers)
}

/// The maps that surfaces are made of.
const USED: [&str; 14] = [
    "map_kd", "map_ks", "map_ke", "map_ns", "map_d", "map_tr", "map_bump", "bump", "norm", "map_kn",
    "map_pr", "map_pm", "map_orm", "map_ps",
];

/// Makes one material.
struct Maker<'a> {
    m: &'a Mtl,
    pictures: &'a Pictures,
    /// Numbers of images that are in the scene, by what they are made of.
    shared: &'a mut HashMap<String, u32>,
    out: &'a mut Assembly,
    warnings: &'a mut Warnings,
}

impl<'a> Maker<'a> {
    fn value(&self, key: &str) -> Option<[f32; 3]> {
        self.m.values.get(key).copied()
    }

    /// A number between 0 and `max`.
    fn scalar(&self, key: &str, max: f32) -> Option<f32> {
        self.value(key).map(|v| v[0].clamp(0.0, max))
    }

    /// A map whose picture is there.
    fn map(&self, key: &str) -> Option<(&'a Map, &'a Decoded)> {
        let map = self.m.maps.get(key)?;
        Some((map, self.pictures.get(Some(map))?))
    }

    /// A factor that a picture is multiplied with. Programs that replace the number by the picture write 0 for it.
    fn factor(&self, key: &str, default: f32, has_map: bool) -> f32 {
        match self.scalar(key, 1.0) {
            None | Some(0.0) if has_map => 1.0,
            v => v.unwrap_or(default),
        }
    }

    fn color(&self, key: &str, default: Vec3, has_map: bool, max: f32) -> Vec3 {
        let v = self.value(key).map(|v| Vec3::from_array(v).clamp(Vec3::ZERO, Vec3::splat(max)));
        match v {
            None | Some(Vec3::ZERO) if has_map => Vec3::ONE,
            v => v.unwrap_or(default),
        }
    }

    /// A reference to the picture `key`, which `make` makes when it is asked for the first time.
    fn texture(&mut self, key: String, map: &Map, make: impl FnOnce() -> Decoded) -> TextureRef {
        let image = match self.shared.get(&key) {
            Some(&known) => known,
            None => {
                let number = self.out.images.len() as u32;
                self.out.images.push(make());
                self.shared.insert(key, number);
                number
            }
        };
        let wrap = if map.clamp { Wrap::Clamp } else { Wrap::Repeat };
        let texture = self.out.texture(image, Sampler { wrap_u: wrap, wrap_v: wrap, ..Sampler::default() });
        let ([su, sv], [ou, ov]) = (map.scale, map.offset);
        // v counts from the bottom in MTL, from the top here: 1 − ((1 − v) s + o).
        let transform = Affine2 {
            matrix2: Mat2::from_diagonal(Vec2::new(su, sv)),
            translation: Vec2::new(ou, 1.0 - sv - ov),
        };
        let transform = if transform.is_finite() { transform } else { Affine2::IDENTITY };
        TextureRef { texture, uv_set: 0, transform }
    }

    /// The picture of `map` as it is.
    fn plain(&mut self, map: &Map, d: &Decoded) -> TextureRef {
        self.texture(name(map), map, || d.clone())
    }

    fn material(&mut self) -> Material {
        let illum = self.value("illum").map_or(2, |v| v[0] as i32);
        for key in ["disp", "map_disp", "decal", "refl", "map_refl", "map_pc", "map_pcr"] {
            if self.m.maps.contains_key(key) {
                self.warnings.add(self.m.place.clone(), format!("`{key}` is not supported; ignored"));
            }
        }
        let base_map = self.map("map_kd");
        let (alpha, alpha_map) = self.alpha(illum);
        let mut out = Material {
            base_color: self.color("kd", Vec3::splat(0.8), base_map.is_some(), 1.0),
            alpha,
            alpha_mode: if alpha < 1.0 || alpha_map.is_some() { AlphaMode::Blend } else { AlphaMode::Opaque },
            double_sided: true,
            metallic: 0.0,
            ..Material::default()
        };
        out.base_color_texture = self.base_texture(base_map, alpha_map);
        self.reflection(illum, &mut out);
        self.roughness(&mut out);
        out.normal_texture = self.normals();
        let glow = self.map("map_ke");
        out.emissive = self.color("ke", Vec3::ZERO, glow.is_some(), 1e18);
        out.emissive_texture = glow.map(|(map, d)| self.plain(map, d));
        self.extensions(illum, &mut out);
        out
    }

    /// Opacity and the map that multiplies it.
    fn alpha(&self, illum: i32) -> (f32, Option<(&'a Map, &'a Decoded)>) {
        // Refracting glass says by its transmission that light passes.
        if refracts(illum) {
            return (1.0, None);
        }
        let map = self.map("map_d").or_else(|| self.map("map_tr"));
        let alpha = match (self.scalar("d", 1.0), self.scalar("tr", 1.0)) {
            (Some(d), _) => d,
            (None, Some(tr)) => 1.0 - tr,
            (None, None) => 1.0,
        };
        (if alpha == 0.0 && map.is_some() { 1.0 } else { alpha }, map)
    }

    fn base_texture(
        &mut self,
        color: Option<(&'a Map, &'a Decoded)>,
        alpha: Option<(&'a Map, &'a Decoded)>,
    ) -> Option<TextureRef> {
        let Some((alpha_map, a)) = alpha else { return color.map(|(map, d)| self.plain(map, d)) };
        let has_alpha = matches!(a.image.channels, 2 | 4) && alpha_map.channel.is_none();
        if let Some((map, d)) = color
            && map.file == alpha_map.file
            && has_alpha
        {
            return Some(self.plain(map, d));
        }
        let mut channel = Channel::new(&a.image, alpha_map);
        if has_alpha {
            channel.which = Which::One(a.image.channels - 1);
        }
        let map = color.map_or(alpha_map, |(map, _)| map);
        let key =
            format!("alpha {:?} {:?} {:?}", color.map(|(m, _)| name(m)), name(alpha_map), channel.which);
        Some(self.texture(key, map, || composed(with_alpha(color.map(|(_, d)| &d.image), &channel))))
    }

    /// Specular strength and tint, index, and metals in Phong's clothes.
    fn reflection(&mut self, illum: i32, out: &mut Material) {
        let tint_map = self.map("map_ks");
        let ks = self.value("ks").map(|v| Vec3::from_array(v).clamp(Vec3::ZERO, Vec3::ONE));
        if let Some(ni) = self.value("ni").map(|v| v[0]).filter(|n| *n > 1.0) {
            out.ior = ni.min(1e3);
        }
        let metal =
            self.value("pm").is_some() || self.map("map_pm").is_some() || self.map("map_orm").is_some();
        let opaque = out.alpha == 1.0 && !refracts(illum) && !matches!(illum, 4 | 9);
        let tint = ks.unwrap_or(Vec3::ONE);
        let black = out.base_color == Vec3::ZERO;
        if black && opaque && !metal && ks.is_some_and(|k| k != Vec3::ZERO) && illum >= 2 {
            out.metallic = 1.0;
            out.base_color = tint;
            out.base_color_texture = tint_map.map(|(map, d)| self.plain(map, d));
            return;
        }
        if illum < 2 || tint == Vec3::ZERO && tint_map.is_none() {
            // With the physical keys the old ones are leftovers.
            out.specular = if metal || self.value("pr").is_some() { 1.0 } else { 0.0 };
            return;
        }
        if tint != Vec3::ZERO {
            out.specular_color = tint / tint.max_element();
        }
        out.specular_color_texture = tint_map.map(|(map, d)| self.plain(map, d));
    }

    fn roughness(&mut self, out: &mut Material) {
        if let Some((map, d)) = self.map("map_orm") {
            let texture = self.plain(map, d);
            out.occlusion_texture = Some(texture);
            out.metallic_roughness_texture = Some(texture);
            out.roughness = self.factor("pr", 1.0, true);
            out.metallic = self.factor("pm", 1.0, true);
            return;
        }
        let (rough, metal) = (self.map("map_pr"), self.map("map_pm"));
        if self.value("pm").is_some() || metal.is_some() {
            out.metallic = self.factor("pm", 0.0, metal.is_some());
        }
        let exponent = self.value("ns").map(|v| v[0].clamp(0.0, 1e9));
        let of_exponent = |n: f32| (2.0 / (n + 2.0)).sqrt().sqrt();
        let gloss = self.map("map_ns").filter(|_| rough.is_none() && self.value("pr").is_none());
        out.roughness = match (self.value("pr").is_some() || rough.is_some(), gloss, exponent) {
            (true, ..) => self.factor("pr", 0.5, rough.is_some()),
            (false, Some(_), _) => 1.0,
            (false, None, Some(n)) => of_exponent(n),
            (false, None, None) => 0.5,
        };
        let most = exponent.unwrap_or(1000.0);
        let rough_or_gloss = rough.or(gloss);
        let Some((map, _)) = rough_or_gloss.or(metal) else { return };
        if let (Some((r, d)), Some((m, _))) = (rough, metal)
            && r.file == m.file
            && d.image.channels >= 3
            && r.channel.is_none()
            && m.channel.is_none()
        {
            out.metallic_roughness_texture = Some(self.plain(r, d));
            return;
        }
        if let (Some((a, _)), Some((b, _))) = (rough_or_gloss, metal)
            && (a.scale, a.offset) != (b.scale, b.offset)
        {
            let why = "the maps of roughness and metalness are scaled differently; both are shown with the first one's";
            self.warnings.add(self.m.place.clone(), why);
        }
        let channel = |(map, d): (&Map, &Decoded)| Channel::new(&d.image, map);
        let (r, m) = (rough_or_gloss.map(channel), metal.map(channel));
        let is_gloss = gloss.is_some();
        let part = |p: Option<(&Map, &Decoded)>, c: &Option<Channel>| {
            p.map(|(map, _)| (name(map), c.as_ref().map(|c| c.which)))
        };
        let key = format!(
            "roughness {:?} {:?} metal {:?}",
            part(rough_or_gloss, &r),
            is_gloss.then(|| most.to_bits()),
            part(metal, &m)
        );
        let texture = self.texture(key, map, || {
            let convert = |v: f32| if is_gloss { of_exponent(v * most) } else { v };
            composed(metal_rough(r.as_ref(), m.as_ref(), convert))
        });
        out.metallic_roughness_texture = Some(texture);
    }

    fn normals(&mut self) -> Option<NormalTexture> {
        if let Some((map, d)) = self.map("norm").or_else(|| self.map("map_kn")) {
            return Some(NormalTexture { texture: self.plain(map, d), scale: map.bump });
        }
        let (map, d) = self.map("map_bump").or_else(|| self.map("bump"))?;
        if map.channel.is_none() && is_normal_map(&d.image) {
            return Some(NormalTexture { texture: self.plain(map, d), scale: map.bump });
        }
        let height = Channel::new(&d.image, map);
        let key = format!("heights {} {:?} {} {}", name(map), height.which, map.bump.to_bits(), map.clamp);
        let depth = map.bump.clamp(-100.0, 100.0) * 0.01;
        let texture = self.texture(key, map, || composed(normals_of_heights(&height, depth, map.clamp)));
        Some(NormalTexture { texture, scale: 1.0 })
    }

    fn extensions(&mut self, illum: i32, out: &mut Material) {
        let mut e = Extensions::default();
        let sheen = self.map("map_ps");
        let strength = self.factor("ps", 0.0, sheen.is_some());
        if strength > 0.0 {
            let color_texture = sheen.map(|(map, d)| {
                let channel = Channel::new(&d.image, map);
                self.texture(format!("sheen {} {:?}", name(map), channel.which), map, || {
                    composed(spread(&channel))
                })
            });
            let (color, roughness) = (Vec3::splat(strength), out.roughness);
            e.sheen = Some(Sheen { color, color_texture, roughness, roughness_texture: None });
        }
        let coat = self.factor("pc", 0.0, false);
        if coat > 0.0 {
            let roughness = self.factor("pcr", 0.0, false);
            e.clearcoat = Some(Clearcoat { factor: coat, roughness, ..Clearcoat::default() });
        }
        let strength = self.factor("aniso", 0.0, false);
        if strength > 0.0 {
            let turns = self.value("anisor").map_or(0.0, |v| v[0].rem_euclid(1.0));
            let rotation = turns * std::f32::consts::TAU;
            e.anisotropy = Some(Anisotropy { strength, rotation, texture: None });
        }
        if refracts(illum) {
            // What passes is tinted; the diffuse colour has nothing left to scatter.
            out.base_color = self.color("tf", Vec3::ONE, false, 1.0);
            out.base_color_texture = None;
            if self.value("ns").is_none() && self.value("pr").is_none() {
                out.roughness = 0.0;
            }
            e.transmission = Some(Transmission { factor: 1.0, texture: None });
            e.volume = Some(Volume { thickness: 1.0, ..Volume::default() });
        }
        out.extensions = (e != Extensions::default()).then(|| Box::new(e));
    }
}

/// "Transparency: refraction on".
fn refracts(illum: i32) -> bool {
    matches!(illum, 6 | 7)
}

fn name(map: &Map) -> String {
    format!("{} {}", String::from_utf8_lossy(&map.folder), String::from_utf8_lossy(&map.file))
}

/// A picture that no file holds.
fn composed(image: Image) -> Decoded {
    Decoded { image: Arc::new(image), encoded_bytes: 0, format: "composed", mips: 1, srgb: None, file: None }
}
