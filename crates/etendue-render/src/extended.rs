//! Closures of materials with extensions, and of other models.

use crate::body::Kind;
use crate::scattering::Scattering;
use crate::surface::{Surface, frame, towards};
use crate::world::World;
use etendue_bxdf::gltf::GltfParams;
use etendue_bxdf::math::sin_cos_tau;
use etendue_bxdf::model::{Closure, Incidence, ModelParams};
use etendue_color::Spectrum;
use etendue_scene::{Anisotropy, Extensions, Material, Scatter, Substitute, TextureRef};
use etendue_trace::Hit;
use glam::{Vec3, Vec3A, Vec4};

fn spectrum(c: Vec3) -> Spectrum {
    Spectrum::from_rgb(c.to_array())
}

/// What the material is where all its textures are white.
pub(crate) fn factors(m: &Material) -> GltfParams {
    let mut p = GltfParams {
        base_color: spectrum(m.base_color),
        metallic: m.metallic,
        roughness: m.roughness,
        ior: m.ior,
        specular: m.specular,
        specular_color: spectrum(m.specular_color),
        compensation: m.compensation,
        ..GltfParams::default()
    };
    let Some(e) = &m.extensions else { return p };
    p.dispersion = e.dispersion;
    if let Some(a) = &e.anisotropy {
        p.anisotropy_strength = a.strength;
    }
    if let Some(c) = &e.clearcoat {
        p.clearcoat = c.factor;
        p.clearcoat_roughness = c.roughness;
        p.coat_ior = c.ior;
        p.coat_color = spectrum(c.color);
        p.coat_darkening = c.darkening;
        p.coat_anisotropy_strength = c.anisotropy.strength;
    }
    if let Some(d) = &e.diffuse_roughness {
        p.diffuse_roughness = d.factor;
    }
    if let Some(d) = &e.diffuse_transmission {
        p.diffuse_transmission = d.factor;
        p.diffuse_transmission_color = spectrum(d.color);
    }
    if let Some(f) = &e.fuzz {
        p.fuzz = f.factor;
        p.fuzz_color = spectrum(f.color);
        p.fuzz_roughness = f.roughness;
    }
    if let Some(i) = &e.iridescence {
        p.iridescence = i.factor;
        p.iridescence_ior = i.ior;
        p.iridescence_thickness = i.thickness[1];
    }
    if let Some(s) = &e.sheen {
        p.sheen_color = spectrum(s.color);
        p.sheen_roughness = s.roughness;
    }
    if let Some(s) = &e.specular_glossiness {
        let older = GltfParams::specular_glossiness(p.base_color, spectrum(s.specular), s.glossiness);
        (p.metallic, p.roughness, p.ior, p.specular_color) =
            (older.metallic, older.roughness, older.ior, older.specular_color);
    }
    if let Some(t) = &e.transmission {
        p.transmission = t.factor;
    }
    if let Some(v) = &e.volume {
        p.thickness = v.thickness;
        p.attenuation_distance = v.attenuation_distance;
        p.attenuation_color = spectrum(v.attenuation_color);
    }
    if let Some(s) = &e.scatter {
        p.scatter_strength = s.strength;
        p.multiscatter_color = spectrum(s.color);
        p.scatter_anisotropy = s.anisotropy;
    }
    p
}

impl Surface {
    /// How any surface scatters.
    #[inline(always)]
    pub fn scattering<'w>(&mut self, world: &'w World, hit: &Hit, at: &Incidence) -> Scattering<'w> {
        match world.bodies[self.material as usize].kind {
            Kind::Plain => Scattering::Plain(self.plain(world, hit)),
            Kind::Extended | Kind::Model => Scattering::Whole(self.whole(world, hit, at)),
            Kind::Measured => match &world.scene.materials[self.material as usize].substitute {
                Some(Substitute::Measured(m)) => Scattering::Measured(m.table()),
                _ => Scattering::Plain(self.plain(world, hit)),
            },
        }
    }

    #[inline(never)]
    fn whole(&mut self, world: &World, hit: &Hit, at: &Incidence) -> Closure {
        let m = &world.scene.materials[self.material as usize];
        if let Some(Substitute::Model(model)) = &m.substitute {
            return model.closure(at);
        }
        Closure::Gltf(self.params(world, hit, m).closure(at))
    }

    /// What a glTF surface is here, and its frame turned to the direction of anisotropy.
    pub fn params(&mut self, world: &World, hit: &Hit, m: &Material) -> GltfParams {
        let mut p = factors(m);
        p.base_color = self.base_color(world, hit, m);
        let mut look = Look { surface: self, world, hit };
        if let Some(s) = look.linear(&m.metallic_roughness_texture) {
            p.roughness *= s.y;
            p.metallic *= s.z;
        }
        if let Some(s) = look.linear(&m.specular_texture) {
            p.specular *= s.w;
        }
        if let Some(s) = look.srgb(&m.specular_color_texture) {
            p.specular_color *= spectrum(s.truncate());
        }
        if let Some(e) = &m.extensions {
            look.layers(e, &mut p);
            look.surface.turn(world, hit, e, &mut p);
        }
        p
    }

    /// How the body scatters that light enters here: its textures are those of the surface at that place.
    pub fn entered(&mut self, world: &World, hit: &Hit) -> Option<etendue_bxdf::model::Scatter> {
        let m = &world.scene.materials[self.material as usize];
        let s = m.extensions.as_ref()?.scatter.as_ref()?;
        let mut p = factors(m);
        (Look { surface: self, world, hit }).scatter(s, &mut p);
        p.scatter()
    }

    /// Turns the frame to the direction of anisotropy, and finds the coat's normal and direction in it.
    fn turn(&mut self, world: &World, hit: &Hit, e: &Extensions, p: &mut GltfParams) {
        // Both directions are about the frame as it is now.
        let brushed = e.clearcoat.as_ref().map(|c| &c.anisotropy).filter(|a| a.strength > 0.0);
        let coat_along = brushed.map(|a| self.stretch(world, hit, a, &mut p.coat_anisotropy_strength));
        if let Some(a) = &e.anisotropy {
            let turned = self.stretch(world, hit, a, &mut p.anisotropy_strength);
            self.frame = frame(self.frame.z_axis, turned.try_normalize());
        }
        let Some(coat) = &e.clearcoat else { return };
        if let Some(along) = coat_along {
            p.coat_tangent = self.frame.transpose() * along;
        }
        let mut normal = self.smooth;
        if let Some(map) = &coat.normal_texture
            && self.along.side != 0.0
        {
            let texel = (Look { surface: self, world, hit }).linear(&Some(map.texture)).unwrap_or(Vec4::Z);
            normal = self.along.bend(texel, map.scale).unwrap_or(normal);
        }
        let wo = self.wo;
        p.clearcoat_normal = self.frame.transpose() * towards(normal, wo);
    }

    /// The direction in which highlights are stretched, and `strength` times what the texture says of it.
    fn stretch(&mut self, world: &World, hit: &Hit, a: &Anisotropy, strength: &mut f32) -> Vec3A {
        let (mut y, mut x) = sin_cos_tau(a.rotation * (0.5 * std::f32::consts::FRAC_1_PI));
        if let Some(s) = (Look { surface: self, world, hit }).linear(&a.texture) {
            *strength *= s.z;
            let (u, v) = (s.x * 2.0 - 1.0, s.y * 2.0 - 1.0);
            (x, y) = (u * x - v * y, u * y + v * x);
        }
        // The frame's second axis is the bitangent only where neither the texture nor the surface is turned over.
        let flip = self.along.sign * self.along.side;
        self.frame.x_axis * x + self.frame.y_axis * (y * flip)
    }
}

/// The textures of one point.
struct Look<'a> {
    surface: &'a mut Surface,
    world: &'a World,
    hit: &'a Hit,
}

impl Look<'_> {
    fn linear(&mut self, t: &Option<TextureRef>) -> Option<Vec4> {
        let mesh = &self.world.meshes[self.world.instances[self.hit.instance as usize].mesh as usize];
        t.as_ref().map(|t| self.surface.lookup.linear(self.world, mesh, t))
    }

    fn srgb(&mut self, t: &Option<TextureRef>) -> Option<Vec4> {
        let mesh = &self.world.meshes[self.world.instances[self.hit.instance as usize].mesh as usize];
        t.as_ref().map(|t| self.surface.lookup.srgb(self.world, mesh, t))
    }

    fn scatter(&mut self, s: &Scatter, p: &mut GltfParams) {
        p.scatter_strength *= self.linear(&s.texture).map_or(1.0, |s| s.w);
        if let Some(c) = self.srgb(&s.color_texture) {
            p.multiscatter_color *= spectrum(c.truncate());
        }
    }

    /// Multiplies the extensions' factors by their textures.
    fn layers(&mut self, e: &Extensions, p: &mut GltfParams) {
        if let Some(c) = &e.clearcoat {
            p.clearcoat *= self.linear(&c.texture).map_or(1.0, |s| s.x);
            p.clearcoat_roughness *= self.linear(&c.roughness_texture).map_or(1.0, |s| s.y);
            if let Some(s) = self.srgb(&c.color_texture) {
                p.coat_color *= spectrum(s.truncate());
            }
        }
        if let Some(d) = &e.diffuse_roughness {
            p.diffuse_roughness *= self.linear(&d.texture).map_or(1.0, |s| s.x);
        }
        if let Some(d) = &e.diffuse_transmission {
            p.diffuse_transmission *= self.linear(&d.texture).map_or(1.0, |s| s.w);
            if let Some(s) = self.srgb(&d.color_texture) {
                p.diffuse_transmission_color *= spectrum(s.truncate());
            }
        }
        if let Some(f) = &e.fuzz {
            p.fuzz *= self.linear(&f.texture).map_or(1.0, |s| s.x);
            if let Some(s) = self.srgb(&f.color_texture) {
                p.fuzz_color *= spectrum(s.truncate());
            }
            p.fuzz_roughness *= self.linear(&f.roughness_texture).map_or(1.0, |s| s.w);
        }
        if let Some(i) = &e.iridescence {
            p.iridescence *= self.linear(&i.texture).map_or(1.0, |s| s.x);
            if let Some(s) = self.linear(&i.thickness_texture) {
                p.iridescence_thickness = i.thickness[0] + (i.thickness[1] - i.thickness[0]) * s.y;
            }
        }
        if let Some(s) = &e.scatter {
            self.scatter(s, p);
        }
        if let Some(s) = &e.sheen {
            if let Some(c) = self.srgb(&s.color_texture) {
                p.sheen_color *= spectrum(c.truncate());
            }
            p.sheen_roughness *= self.linear(&s.roughness_texture).map_or(1.0, |s| s.w);
        }
        if let Some(g) = &e.specular_glossiness
            && let Some(s) = self.srgb(&g.texture)
        {
            p.specular_color *= spectrum(s.truncate());
            p.roughness = 1.0 - g.glossiness * s.w;
        }
        if let Some(t) = &e.transmission {
            p.transmission *= self.linear(&t.texture).map_or(1.0, |s| s.x);
        }
    }
}
