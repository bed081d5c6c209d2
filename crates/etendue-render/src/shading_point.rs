//! A surface point as a shading model outside of this crate sees it: where it is, how it is turned, and what it is made of after
//! all textures.
//!
//! What the path tracer shades and what is handed out here come from the same textures by the same lookups, so that two models
//! of one point differ in the model only.

use crate::lookup::Lookup;
use crate::surface::{Surface, emitted};
use crate::world::World;
use etendue_bxdf::gltf::GltfParams;
use etendue_bxdf::math::{exp2, ln};
use etendue_bxdf::model::Model;
use etendue_color::Spectrum;
use etendue_scene::{AlphaMode, Material, Substitute};
use etendue_trace::{Hit, Ray};
use glam::{Mat3A, Vec2, Vec3A};
use std::cell::Cell;
use std::f32::consts::LOG2_E;

/// All that a fragment shader would have of a point, on the side that is seen. Vectors are unit vectors in world space.
#[derive(Clone, Copy, Debug)]
pub struct ShadingPoint {
    /// Where it is, metres.
    pub position: Vec3A,
    /// Normal of the triangle.
    pub geometric: Vec3A,
    /// Between the vertices' normals, without a normal map.
    pub smooth: Vec3A,
    /// Along the first texture coordinate, as normal maps have it; some direction in the surface where the material has
    /// neither a normal map nor a lobe with a direction.
    pub tangent: Vec3A,
    /// Along the second.
    pub bitangent: Vec3A,
    /// The frame that [`ShadingPoint::params`] refer to: columns direction of anisotropy, across, shading normal. The viewer is
    /// above the normal's plane, and what a metal mirrors comes from above the triangle's.
    pub frame: Mat3A,
    /// The side that the winding makes the front is seen.
    pub front: bool,
    /// First texture coordinate.
    pub uv: Vec2,
    /// Index into the scene's instances.
    pub instance: u32,
    /// Index into the scene's materials.
    pub material: u32,
    /// The material here: factors times textures, not yet clamped. `thickness` is in metres of the world.
    pub params: GltfParams,
    /// Ambient occlusion, 0 none gets here .. 1 all.
    pub occlusion: f32,
    /// Emitted radiance towards the viewer, through any coat, zero on the back of a one-sided surface; of an unlit surface its colour.
    pub emission: Spectrum,
    /// Part of the light that meets the surface at all, 0..1; the rest passes (`alphaMode` "BLEND").
    pub alpha: f32,
    /// Shown as it is, without lighting.
    pub unlit: bool,
    /// The smooth surface that the triangles stand for: where rays start that leave on the seen side.
    lifted: Vec3A,
    epsilon: f32,
}

impl ShadingPoint {
    /// Where a ray that leaves towards `wi` starts, so that it does not meet the surface that it comes from.
    #[inline(always)]
    pub fn ray_origin(&self, wi: Vec3A) -> Vec3A {
        let distance = self.lifted.abs().max_element() * 1e-6 + self.epsilon;
        if wi.dot(self.geometric) >= 0.0 {
            self.lifted + self.geometric * distance
        } else {
            self.position - self.geometric * distance
        }
    }
}

impl World {
    /// The nearest surface that a camera ray meets, and whether its front is seen. The alpha test decides where "MASK" surfaces are, and
    /// blended ones are there wherever they are not perfectly clear; backs of one-sided surfaces are not there
    /// (glTF 2.0, section 3.9.6).
    #[inline(always)]
    pub fn seen(&self, ray: &Ray) -> Option<Hit> {
        /// Backs that a ray looks through before it is given up.
        const MOST_BACKS: u32 = 1024;
        let mut ray = *ray;
        for _ in 0..MOST_BACKS {
            let hit = self.accel.closest(&ray, &|i, t, u, v| self.covers(i, t, u, v))?;
            let material = &self.scene.materials[self.instances[hit.instance as usize].material as usize];
            if material.double_sided || self.faces(&hit, ray.direction) {
                return Some(hit);
            }
            ray.t_min = hit.t;
        }
        None
    }

    /// The part of the light that gets along the ray, 0..1: none past solid surfaces and masked ones that are there, of each
    /// blended one what its alpha leaves. Backs stop light as fronts do.
    #[inline(always)]
    pub fn transmittance(&self, ray: &Ray) -> f32 {
        /// Steps of log₂, so that the sum is of integers: surfaces are met in no particular order.
        const STEPS: f32 = 65_536.0;
        /// Light after this many stops is none.
        const DARK: u32 = 16 * 65_536;
        let stops = Cell::new(0u32);
        let stopped = self.accel.any(ray, &|i, t, u, v| {
            let m = &self.scene.materials[self.instances[i as usize].material as usize];
            if m.alpha_mode != AlphaMode::Blend {
                return self.covers(i, t, u, v);
            }
            let left = 1.0 - self.alpha(i, t, u, v).clamp(0.0, 1.0);
            let more = if left > 1e-5 { (-LOG2_E * STEPS * ln(left)) as u32 } else { DARK };
            stops.set(stops.get() + more);
            stops.get() >= DARK
        });
        match stops.get() {
            _ if stopped => 0.0,
            0 => 1.0,
            n => exp2(n as f32 / -STEPS),
        }
    }

    /// Radiance of the sky from the direction `d` (unit), as the camera sees it.
    #[inline(always)]
    pub fn sky_radiance(&self, d: Vec3A) -> Spectrum {
        self.lights.sky_radiance(d)
    }

    /// All that shading needs of `hit`, which a ray along `direction` (unit) met.
    ///
    /// A material that another model replaces (`Substitute`) keeps its own factors here, unless that model is glTF's
    /// (`gltf`, `metal-rough`).
    #[inline(always)]
    pub fn shading_point(&self, hit: &Hit, direction: Vec3A) -> ShadingPoint {
        let mut surface = Surface::new(self, hit, direction);
        let m = &self.scene.materials[surface.material as usize];
        let unlit = m.unlit;
        let (tangent, bitangent) = match surface.along.side {
            0.0 => (surface.frame.x_axis, surface.frame.y_axis),
            _ => {
                let along = &surface.along;
                (along.tangent, (along.front.cross(along.tangent) * along.sign).normalize_or_zero())
            }
        };
        let mut params = match &m.substitute {
            Some(Substitute::Model(model)) => constant(model),
            _ => None,
        }
        .unwrap_or_else(|| surface.params(self, hit, m));
        if params.thickness > 0.0 {
            params.thickness *= self.thickness_scale(hit, m, &mut surface.lookup);
        }
        let mut occlusion = 1.0;
        if let Some(t) = &m.occlusion_texture {
            let mesh = &self.meshes[self.instances[hit.instance as usize].mesh as usize];
            occlusion = 1.0 + m.occlusion_strength * (surface.lookup.linear(self, mesh, t).x - 1.0);
        }
        let emission = match () {
            _ if unlit => surface.base_color(self, hit, m),
            _ if m.is_emissive() && (surface.front || m.double_sided) => {
                let cos = surface.geometric.dot(surface.wo);
                emitted(self, m, hit.instance, &mut surface.lookup, cos)
            }
            _ => Spectrum::ZERO,
        };
        let alpha = match m.alpha_mode {
            AlphaMode::Blend => self.alpha(hit.instance, hit.triangle, hit.u, hit.v).clamp(0.0, 1.0),
            _ => 1.0,
        };
        ShadingPoint {
            position: surface.point,
            geometric: surface.geometric,
            smooth: surface.smooth,
            tangent,
            bitangent,
            emission,
            frame: surface.frame,
            front: surface.front,
            uv: surface.uv,
            instance: hit.instance,
            material: surface.material,
            params,
            occlusion: occlusion.clamp(0.0, 1.0),
            alpha,
            unlit,
            lifted: surface.lifted,
            epsilon: self.epsilon,
        }
    }

    /// True if the triangle's front is turned against `direction`.
    #[inline(always)]
    fn faces(&self, hit: &Hit, direction: Vec3A) -> bool {
        let [a, b, c] = self.corners(hit.instance, hit.triangle);
        let handedness = self.instances[hit.instance as usize].handedness;
        (b - a).cross(c - a).dot(direction) * handedness < 0.0
    }

    /// True if any of the surface is there.
    #[inline(always)]
    fn covers(&self, instance: u32, triangle: u32, u: f32, v: f32) -> bool {
        let m = &self.scene.materials[self.instances[instance as usize].material as usize];
        match m.alpha_mode {
            AlphaMode::Opaque => true,
            AlphaMode::Mask(cutoff) => self.alpha(instance, triangle, u, v) >= cutoff,
            AlphaMode::Blend => self.alpha(instance, triangle, u, v) > 0.0,
        }
    }

    /// Metres of the world that one unit of thickness is here: the texture's share and the instance's scale.
    fn thickness_scale(&self, hit: &Hit, m: &Material, lookup: &mut Lookup) -> f32 {
        let mesh = &self.meshes[self.instances[hit.instance as usize].mesh as usize];
        let volume = m.extensions.as_ref().and_then(|e| e.volume.as_ref());
        let texture = volume.and_then(|v| v.thickness_texture.as_ref());
        let share = texture.map_or(1.0, |t| lookup.linear(self, mesh, t).y);
        // Not `self.instances`: what stands in one place only has lost its transform.
        let scale = self.scene.instances[hit.instance as usize].transform.matrix3.determinant().abs().cbrt();
        share * scale
    }
}

/// A replacement's parameters, if it is a glTF surface.
fn constant(model: &Model) -> Option<GltfParams> {
    match model {
        Model::Gltf(p) => Some(*p),
        Model::MetalRough(p) => Some((*p).into()),
        _ => None,
    }
}
