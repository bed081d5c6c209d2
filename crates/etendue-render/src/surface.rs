//! A hit becomes a surface: where it is, how it is turned, what it is made of.

use crate::lookup::Lookup;
use crate::mesh_data::{MeshData, Vertex};
use crate::world::World;
use etendue_bxdf::gltf::under_coat;
use etendue_bxdf::sampling::basis;
use etendue_bxdf::sheen::Fuzz;
use etendue_bxdf::{MetalRough, MetalRoughParams, Schlick};
use etendue_color::Spectrum;
use etendue_scene::{Material, TextureRef};
use etendue_trace::Hit;
use glam::{Mat3A, Vec2, Vec3A, Vec4};

/// The point that a ray met.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Surface {
    pub point: Vec3A,
    /// Where rays that leave this point start: moved to the smooth surface that the triangles stand for, so that their
    /// facets do not shadow it.
    pub lifted: Vec3A,
    /// Normal of the triangle, on the side that the ray came from.
    pub geometric: Vec3A,
    /// Shading frame: columns tangent, bitangent, normal.
    pub frame: Mat3A,
    /// Seen from the side that its winding makes the front.
    pub front: bool,
    /// First texture coordinate.
    pub uv: Vec2,
    pub material: u32,
    /// Normal between the vertices', without a normal map, on the side that the ray came from.
    pub smooth: Vec3A,
    /// The tangent plane that normal maps refer to; only made if one is there or a lobe needs a direction.
    pub along: Along,
    /// Unit, towards where the ray came from.
    pub wo: Vec3A,
    pub lookup: Lookup,
}

/// The directions of a texture on the surface.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Along {
    pub tangent: Vec3A,
    /// The smooth normal on the front.
    pub front: Vec3A,
    /// The bitangent is cross(front, tangent) · sign.
    pub sign: f32,
    /// +1 if the front is seen, −1 for the back.
    pub side: f32,
}

impl Along {
    /// The normal that a texel of a normal map stands for, on the side that is seen; `None` if it has no length.
    #[inline(always)]
    pub fn bend(&self, texel: Vec4, scale: f32) -> Option<Vec3A> {
        let bitangent = self.front.cross(self.tangent) * self.sign;
        let (x, y) = ((texel.x * 2.0 - 1.0) * scale, (texel.y * 2.0 - 1.0) * scale);
        let bent = self.tangent * x + bitangent * y + self.front * (texel.z * 2.0 - 1.0);
        (bent * self.side).try_normalize()
    }
}

impl Surface {
    /// Geometry of `hit`, seen along `direction` (unit).
    #[inline(always)]
    pub fn new(world: &World, hit: &Hit, direction: Vec3A) -> Self {
        let instance = &world.instances[hit.instance as usize];
        let mesh = &world.meshes[instance.mesh as usize];
        let corners = mesh.indices[hit.triangle as usize];
        // Arrays are spelled out on this path: `array::map` is not inlined, and loses the wide instructions.
        let vertex = |k: usize| &mesh.vertices[corners[k] as usize];
        let (a, b, c) = (vertex(0), vertex(1), vertex(2));
        let w = [1.0 - hit.u - hit.v, hit.u, hit.v];
        let place = |v: &Vertex| {
            let p = Vec3A::from(v.position);
            if instance.baked { p } else { instance.to_world.transform_point3a(p) }
        };
        let p = [place(a), place(b), place(c)];
        let point = p[0] * w[0] + p[1] * w[1] + p[2] * w[2];
        let wo = -direction;
        // Rays meet only triangles that have an area, but its square may vanish in a float.
        let ng = (p[1] - p[0]).cross(p[2] - p[0]) * instance.handedness;
        let mut geometric = ng.try_normalize().unwrap_or(wo);
        let front = geometric.dot(wo) > 0.0;
        if !front {
            geometric = -geometric;
        }
        let uv = if mesh.has_uv { a.uv * w[0] + b.uv * w[1] + c.uv * w[2] } else { Vec2::ZERO };
        let mut lifted = point;
        let mut normal = geometric;
        let mut smooth = geometric;
        let mut lookup = Lookup::new(corners, w);
        let mut tangent = None;
        let mut along = Along::default();
        let material = &world.scene.materials[instance.material as usize];
        if mesh.has_normals {
            let side = if front { 1.0 } else { -1.0 };
            let turn = |v: &Vertex| {
                let n = Vec3A::from(v.normal);
                if !instance.baked {
                    let n = instance.normal_to_world * n;
                    n.try_normalize().unwrap_or(geometric * side) * side
                } else if n == Vec3A::ZERO {
                    geometric
                } else {
                    n * side
                }
            };
            let n = [turn(a), turn(b), turn(c)];
            smooth = (n[0] * w[0] + n[1] * w[1] + n[2] * w[2]).try_normalize().unwrap_or(geometric);
            lifted = lift(point, &p, &n, w, geometric);
            normal = smooth;
            let directed =
                material.normal_texture.is_some() || world.bodies[instance.material as usize].directed;
            if directed && mesh.has_tangents {
                let t = a.tangent * w[0] + b.tangent * w[1] + c.tangent * w[2];
                let sign = a.tangent.w * instance.handedness;
                let t = Vec3A::from_vec4(t);
                let t = if instance.baked { t } else { instance.to_world.matrix3 * t };
                if let Some(t) = t.try_normalize() {
                    // All three axes turn over on the back, as in glTF's reference implementation.
                    along = Along { tangent: t, front: smooth * side, sign, side };
                    tangent = Some(t);
                    if let Some(map) = &material.normal_texture {
                        let s = lookup.linear(world, mesh, &map.texture);
                        normal = along.bend(s, map.scale).unwrap_or(smooth);
                    }
                }
            }
        }
        let mut normal = towards(normal, wo);
        let bent = towards_reflection(normal, wo, geometric);
        if bent != normal {
            let metallic = metallic(material, world, mesh, &mut lookup).clamp(0.0, 1.0);
            // Both lie within a right angle of `wo`, so their mix does.
            normal = normal.lerp(bent, metallic).try_normalize().unwrap_or(bent);
        }
        Self {
            point,
            lifted,
            geometric,
            frame: frame(normal, tangent),
            front,
            uv,
            material: instance.material,
            smooth,
            along,
            wo,
            lookup,
        }
    }

    /// The material's emitted radiance here, zero on the back of a one-sided surface; for an unlit surface its colour.
    #[inline(always)]
    pub fn emission(&mut self, world: &World, hit: &Hit) -> Spectrum {
        let m = &world.scene.materials[self.material as usize];
        if m.unlit {
            return self.base_color(world, hit, m);
        }
        if !m.is_emissive() || !(self.front || m.double_sided) || world.lights.emitter(hit).is_none() {
            return Spectrum::ZERO;
        }
        emitted(world, m, hit.instance, &mut self.lookup, self.geometric.dot(self.wo))
    }

    /// How a surface of glTF's core material scatters.
    #[inline(always)]
    pub fn plain(&mut self, world: &World, hit: &Hit) -> MetalRough {
        let m = &world.scene.materials[self.material as usize];
        let mesh = &world.meshes[world.instances[hit.instance as usize].mesh as usize];
        let (mut metallic, mut roughness) = (m.metallic, m.roughness);
        if let Some(t) = &m.metallic_roughness_texture {
            let s = self.lookup.linear(world, mesh, t);
            roughness *= s.y;
            metallic *= s.z;
        }
        let mut specular = m.specular;
        if let Some(t) = &m.specular_texture {
            specular *= self.lookup.linear(world, mesh, t).w;
        }
        let mut specular_color = m.specular_color;
        if let Some(t) = &m.specular_color_texture {
            specular_color *= self.lookup.srgb(world, mesh, t).truncate();
        }
        MetalRough::new(&MetalRoughParams {
            base_color: self.base_color(world, hit, m),
            metallic: metallic.clamp(0.0, 1.0),
            roughness: roughness.clamp(0.0, 1.0),
            ior: m.ior,
            specular: specular.clamp(0.0, 1.0),
            specular_color: Spectrum::from_rgb(specular_color.max(glam::Vec3::ZERO).to_array()),
            compensation: m.compensation,
        })
    }

    #[inline(always)]
    pub fn base_color(&mut self, world: &World, hit: &Hit, m: &Material) -> Spectrum {
        let mesh = &world.meshes[world.instances[hit.instance as usize].mesh as usize];
        let mut c = m.base_color;
        if let Some(t) = &m.base_color_texture {
            c *= self.lookup.srgb(world, mesh, t).truncate();
        }
        c *= self.lookup.vertex_color(mesh).truncate();
        Spectrum::from_rgb(c.clamp(glam::Vec3::ZERO, glam::Vec3::ONE).to_array())
    }

    /// Start of a ray that leaves towards `wi`: off the surface by more than rounding can move it back.
    #[inline(always)]
    pub fn origin(&self, world: &World, wi: Vec3A) -> Vec3A {
        let distance = self.lifted.abs().max_element() * 1e-6 + world.epsilon;
        if wi.dot(self.geometric) >= 0.0 {
            self.lifted + self.geometric * distance
        } else {
            self.point - self.geometric * distance
        }
    }
}

/// Radiance that a point of an emissive triangle sends out at an angle of cosine `cos` to the triangle's normal.
#[inline(always)]
pub(crate) fn emitted(world: &World, m: &Material, instance: u32, lookup: &mut Lookup, cos: f32) -> Spectrum {
    let mesh = &world.meshes[world.instances[instance as usize].mesh as usize];
    let mut e = emitted_below(world, m, instance, lookup);
    let Some(x) = m.extensions.as_deref() else { return e };
    let scale = |lookup: &mut Lookup, factor: f32, t: &Option<TextureRef>, channel: usize| {
        t.as_ref().map_or(1.0, |t| lookup.linear(world, mesh, t)[channel]) * factor
    };
    // What shines below a clear coat has to get through it (KHR_materials_clearcoat, "Emission"), and through fuzz.
    if let Some(coat) = &x.clearcoat {
        let cover = scale(lookup, coat.factor, &coat.texture, 0);
        if coat.is_plain() {
            e *= 1.0 - cover * COAT.eval(cos.abs())[0];
        } else {
            let mut color = coat.color;
            if let Some(t) = &coat.color_texture {
                color *= lookup.srgb(world, mesh, t).truncate();
            }
            e *= under_coat(cover, coat.ior, Spectrum::from_rgb(color.to_array()), cos.abs());
        }
    }
    if let Some(f) = &x.fuzz {
        let (cover, roughness) =
            (scale(lookup, f.factor, &f.texture, 0), scale(lookup, f.roughness, &f.roughness_texture, 3));
        e *= 1.0 - cover * Fuzz::new(Spectrum::ONE, roughness).reflectance(cos.abs());
    }
    e
}

/// The same below the layers.
#[inline(always)]
pub(crate) fn emitted_below(world: &World, m: &Material, instance: u32, lookup: &mut Lookup) -> Spectrum {
    let mesh = &world.meshes[world.instances[instance as usize].mesh as usize];
    let mut e = m.emissive;
    if let Some(t) = &m.emissive_texture {
        e *= lookup.srgb(world, mesh, t).truncate();
    }
    Spectrum::from_rgb(e.to_array())
}

/// Reflectance of a clear coat: index 1.5.
const COAT: Schlick = Schlick { f0: Spectrum::splat(0.04), f90: Spectrum::ONE };

/// How much of a surface is metal.
fn metallic(m: &Material, world: &World, mesh: &MeshData, lookup: &mut Lookup) -> f32 {
    m.metallic * m.metallic_roughness_texture.as_ref().map_or(1.0, |t| lookup.linear(world, mesh, t).z)
}

/// The point on the smooth surface that the vertex normals describe, where that lies outside the triangle (Hanika 2021,
/// "Hacking the Shadow Terminator", Ray Tracing Gems II, chapter 4). Concave parts stay where they are.
#[inline(always)]
fn lift(point: Vec3A, p: &[Vec3A; 3], n: &[Vec3A; 3], w: [f32; 3], geometric: Vec3A) -> Vec3A {
    let mut offset = Vec3A::ZERO;
    for k in 0..3 {
        let below = (point - p[k]).dot(n[k]).min(0.0);
        offset -= n[k] * (below * w[k]);
    }
    // Normals that lean far from their triangle would carry the point away sideways.
    point + geometric * offset.dot(geometric).max(0.0)
}

/// Bends `n` until `wo` lies above it: a viewer never sees the back of a surface that faces him, whatever a normal map or
/// an interpolated normal says.
#[inline(always)]
pub(crate) fn towards(n: Vec3A, wo: Vec3A) -> Vec3A {
    const LEAST: f32 = 1e-3;
    let cos = n.dot(wo);
    if cos >= LEAST {
        return n;
    }
    (n + wo * (LEAST - cos)).try_normalize().unwrap_or(wo)
}

/// Bends `n` until the mirror image of `wo` lies above the triangle, but not above where the triangle itself would mirror
/// it. What a mirror sends into its own inside is lost, and would leave a black rim where a normal map is steep. (A
/// rough lobe loses less, and diffuse light hardly any: there the bend would only flatten the relief. One frame serves
/// all lobes, so it is for metals, which have no other.)
#[inline(always)]
fn towards_reflection(n: Vec3A, wo: Vec3A, geometric: Vec3A) -> Vec3A {
    const LEAST: f32 = 1e-2;
    let cos = wo.dot(geometric);
    let least = LEAST.min(cos);
    let mirrored = n * (2.0 * n.dot(wo)) - wo;
    let height = mirrored.dot(geometric);
    if height >= least || cos <= 0.0 {
        return n;
    }
    // The mirror image is turned up to `least`; the normal that mirrors so is half-way.
    let Some(flat) = (mirrored - geometric * height).try_normalize() else { return n };
    let lifted = flat * (1.0 - least * least).sqrt() + geometric * least;
    (wo + lifted).try_normalize().unwrap_or(n)
}

/// An orthonormal frame about `n`, along `tangent` if there is one.
#[inline(always)]
pub(crate) fn frame(n: Vec3A, tangent: Option<Vec3A>) -> Mat3A {
    match tangent.and_then(|t| (t - n * n.dot(t)).try_normalize()) {
        Some(t) => Mat3A::from_cols(t, n.cross(t), n),
        None => {
            let (t, b) = basis(n);
            Mat3A::from_cols(t, b, n)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::Sampler;
    use etendue_bxdf::sampling::uniform_sphere;

    /// A mirror with the bent normal sends what is seen above the triangle, and normals that do already stay as they are.
    #[test]
    fn a_mirrors_view_lies_above_the_triangle() {
        let (mut bent, mut kept) = (0, 0);
        for i in 0..10_000 {
            let sampler = Sampler::new(1, 0, 0, i);
            let [u0, u1, u2, u3] = sampler.get4(0);
            let [u4, u5, ..] = sampler.get4(1);
            let [ng, wo, n] = [[u0, u1], [u2, u3], [u4, u5]].map(uniform_sphere);
            let wo = if wo.dot(ng) < 0.0 { -wo } else { wo };
            let n = towards(if n.dot(ng) < 0.0 { -n } else { n }, wo);
            let m = towards_reflection(n, wo, ng);
            let mirror = |n: Vec3A| (n * (2.0 * n.dot(wo)) - wo).dot(ng);
            assert!((m.length() - 1.0).abs() < 1e-5 && m.dot(wo) > 0.0, "{n} {wo} {ng}");
            assert!(mirror(m) > 0.01f32.min(wo.dot(ng)) - 1e-4, "{} of {n} {wo} {ng}", mirror(m));
            if mirror(n) >= 0.01 {
                assert_eq!(m, n);
                kept += 1;
            } else {
                bent += 1;
            }
        }
        assert!(bent > 1000 && kept > 1000, "{bent} {kept}");
    }
}
