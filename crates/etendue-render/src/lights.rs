//! Every light of a scene behind one question: "send me some light to this point".

use crate::distribution::Distribution1;
use crate::emission_map::EmissionMap;
use crate::light_tree::{LightBounds, LightTree};
use crate::lookup::Lookup;
use crate::mesh_data::MeshData;
use crate::sky::Sky;
use crate::surface::emitted;
use crate::world::{InstanceData, World};
use etendue_bxdf::sampling::uniform_triangle;
use etendue_color::Spectrum;
use etendue_scene::{AimedProfile, Bounds, Light, LightKind, TextureRef};
use etendue_trace::Hit;
use glam::{Vec2, Vec3A};
use rayon::prelude::*;
use std::collections::HashMap;

/// Light that may reach a point, if nothing is in between.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LightSample {
    /// Unit vector towards the light.
    pub wi: Vec3A,
    /// How far away it is; infinite for sky and directional lights.
    pub distance: f32,
    /// Radiance from there; for a light without extent, irradiance on a surface that faces it.
    pub radiance: Spectrum,
    /// Density per solid angle, choice of the light included; for a light without extent the choice's probability.
    pub pdf: f32,
    /// The light has no extent: scattering can not find it.
    pub delta: bool,
}

/// A light that stands somewhere.
#[derive(Clone, Copy, Debug)]
enum Emitter {
    Triangle { instance: u32, triangle: u32 },
    Punctual(u32),
}

/// Where the light at a point comes from: the share that is drawn from far lights (sky, directional), the rest from
/// those that stand somewhere.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct LightChoice {
    pub point: Vec3A,
    pub normal: Vec3A,
    far: f32,
}

/// All lights, ready to be drawn from.
#[derive(Debug, Default)]
pub(crate) struct Lights {
    sky: Option<Sky>,
    /// The sky (first, even if it is not sampled), then directional lights.
    far: Option<Distribution1>,
    far_irradiance: f32,
    directional: Vec<Light>,
    punctual: Vec<Light>,
    /// Of each punctual light; empty if none has one.
    profiles: Vec<Option<AimedProfile>>,
    tree: LightTree,
    emitters: Vec<Emitter>,
    /// Per instance, the emitter of each triangle or `NONE`; empty if all are dark.
    emitter_of: Vec<Vec<u32>>,
}

const NONE: u32 = u32::MAX;

impl Lights {
    /// The lights of `world` under `sky`, which is its environment made ready. `before` are those of another moment, and which
    /// instances emit what they emitted then; they need not be looked at again.
    pub fn new(world: &World, sky: Sky, before: Option<(Lights, Vec<bool>)>) -> Self {
        let scene = &world.scene;
        let (directional, punctual): (Vec<_>, Vec<_>) = scene
            .lights
            .iter()
            .filter(|l| l.intensity.max_element() > 0.0)
            .cloned()
            .partition(|l| l.kind == LightKind::Directional);
        let mut profiles: Vec<_> = punctual.iter().map(|l| scene.aimed_profile(l)).collect();
        if profiles.iter().all(Option::is_none) {
            profiles.clear();
        }
        let mut weights = vec![sky.sampled_irradiance()];
        weights.extend(directional.iter().map(|l| brightness(Spectrum::from_rgb(l.intensity.to_array()))));
        let far = Distribution1::new(weights.iter().copied());
        let mut lights = Self {
            sky: Some(sky),
            far_irradiance: far.total() as f32,
            far: (far.total() > 0.0).then_some(far),
            directional,
            punctual,
            profiles,
            ..Self::default()
        };
        let emits = |instance: &InstanceData| {
            let m = &scene.materials[instance.material as usize];
            m.is_emissive() && !m.unlit
        };
        let mut old = Old::default();
        if let Some((before, same)) = before {
            let still = |(i, instance): (usize, &InstanceData)| {
                same[i] || !emits(instance) && before.emitter_of[i].is_empty()
            };
            if before.punctual == lights.punctual
                && before.profiles == lights.profiles
                && same.len() == before.emitter_of.len()
                && world.instances.iter().enumerate().all(still)
            {
                let Self { tree, emitters, emitter_of, .. } = before;
                return Self { tree, emitters, emitter_of, ..lights };
            }
            old = Old { bounds: before.tree.lights(), emitter_of: before.emitter_of, same };
        }
        let mut bounds = Vec::new();
        lights.emitter_of = vec![Vec::new(); scene.instances.len()];
        let mut maps: HashMap<u32, EmissionMap> = HashMap::new();
        for (i, instance) in world.instances.iter().enumerate().filter(|(_, i)| emits(i)) {
            let mesh = &world.meshes[instance.mesh as usize];
            let count = mesh.indices.len() as u32;
            if lights.emitters.len() + count as usize >= (1 << 31) {
                break;
            }
            let (lit, its_bounds) = match old.of(i) {
                Some(known) => known,
                None => {
                    let m = &scene.materials[instance.material as usize];
                    let map = m.emissive_texture.as_ref().map(|t| {
                        &*maps.entry(t.texture).or_insert_with(|| {
                            let texture = &scene.textures[t.texture as usize];
                            EmissionMap::new(&scene.images[texture.image as usize], texture.sampler)
                        })
                    });
                    let lit: Vec<u32> = (0..count)
                        .into_par_iter()
                        .filter(|&t| match (map, &m.emissive_texture) {
                            (Some(map), Some(r)) => map.may_emit(texture_corners(mesh, r, t)),
                            _ => true,
                        })
                        .collect();
                    let its_bounds = lit.par_iter().map(|&t| triangle_bounds(world, i as u32, t)).collect();
                    (lit, its_bounds)
                }
            };
            if lit.is_empty() {
                continue;
            }
            lights.emitter_of[i] = vec![NONE; count as usize];
            for &t in &lit {
                lights.emitter_of[i][t as usize] = lights.emitters.len() as u32;
                lights.emitters.push(Emitter::Triangle { instance: i as u32, triangle: t });
            }
            bounds.extend(its_bounds);
        }
        for (i, l) in lights.punctual.iter().enumerate() {
            lights.emitters.push(Emitter::Punctual(i as u32));
            bounds.push(punctual_bounds(l, lights.profiles.get(i).and_then(Option::as_ref)));
        }
        lights.tree = LightTree::new(&bounds);
        lights
    }

    /// Takes the sky out.
    pub fn take_sky(&mut self) -> Option<Sky> {
        self.sky.take()
    }

    pub fn count(&self) -> usize {
        self.emitters.len() + self.directional.len()
    }

    /// Light from the sky in direction `d`.
    #[inline(always)]
    pub fn sky_radiance(&self, d: Vec3A) -> Spectrum {
        match &self.sky {
            Some(sky) => sky.radiance(d),
            None => Spectrum::ZERO,
        }
    }

    /// Decides between far and near lights for a surface point.
    #[inline(always)]
    pub fn choose(&self, point: Vec3A, normal: Vec3A) -> LightChoice {
        let far = match (&self.far, self.tree.is_empty()) {
            (None, _) => 0.0,
            (Some(_), true) => 1.0,
            // Bounds are no certainty: neither kind is given up entirely.
            (Some(_), false) => {
                let near = self.tree.importance(point, normal);
                if near > 0.0 {
                    (self.far_irradiance / (self.far_irradiance + near)).clamp(0.03, 0.97)
                } else {
                    1.0
                }
            }
        };
        LightChoice { point, normal, far }
    }

    /// Draws one light and a point on it.
    #[inline(always)]
    pub fn sample(&self, world: &World, choice: &LightChoice, pick: f32, u: [f32; 2]) -> Option<LightSample> {
        if pick < choice.far {
            let far = self.far.as_ref()?;
            let (i, _) = far.sample(pick / choice.far);
            let probability = choice.far * far.probability(i);
            if i == 0 {
                let s = self.sky.as_ref()?.sample(u)?;
                let pdf = s.pdf * probability;
                return Some(LightSample {
                    wi: s.wi,
                    distance: f32::INFINITY,
                    radiance: s.radiance,
                    pdf,
                    delta: false,
                });
            }
            let l = &self.directional[i - 1];
            return Some(LightSample {
                wi: -Vec3A::from(l.direction),
                distance: f32::INFINITY,
                radiance: Spectrum::from_rgb(l.intensity.to_array()),
                pdf: probability,
                delta: true,
            });
        }
        let pick = ((pick - choice.far) / (1.0 - choice.far)).min(crate::distribution::ONE_MINUS_EPSILON);
        let (light, probability) = self.tree.sample(choice.point, choice.normal, pick)?;
        let probability = probability * (1.0 - choice.far);
        match self.emitters[light as usize] {
            Emitter::Punctual(i) => {
                let profile = self.profiles.get(i as usize).and_then(Option::as_ref);
                punctual_sample(&self.punctual[i as usize], profile, choice.point, probability)
            }
            Emitter::Triangle { instance, triangle } => {
                triangle_sample(world, instance, triangle, choice.point, probability, u)
            }
        }
    }

    /// Light from the sky in direction `d`, and the density with which [`Lights::sample`] draws it.
    #[inline(always)]
    pub fn sky(&self, choice: &LightChoice, d: Vec3A) -> (Spectrum, f32) {
        let Some(sky) = &self.sky else { return (Spectrum::ZERO, 0.0) };
        match &self.far {
            Some(far) => {
                let (radiance, pdf) = sky.radiance_and_pdf(d);
                (radiance, pdf * choice.far * far.probability(0))
            }
            None => (sky.radiance(d), 0.0),
        }
    }

    /// The light that the triangle is; `None` if it is surely dark.
    #[inline(always)]
    pub fn emitter(&self, hit: &Hit) -> Option<u32> {
        self.emitter_of[hit.instance as usize].get(hit.triangle as usize).copied().filter(|l| *l != NONE)
    }

    /// The density per solid angle with which [`Lights::sample`] draws the point that a ray along `d` met.
    #[inline(always)]
    pub fn hit_pdf(&self, world: &World, choice: &LightChoice, hit: &Hit, d: Vec3A) -> f32 {
        let Some(light) = self.emitter(hit) else { return 0.0 };
        let chosen = self.tree.probability(light, choice.point, choice.normal) * (1.0 - choice.far);
        if chosen <= 0.0 {
            return 0.0;
        }
        let [a, b, c] = world.corners(hit.instance, hit.triangle);
        let twice = (b - a).cross(c - a);
        let point = a * (1.0 - hit.u - hit.v) + b * hit.u + c * hit.v;
        let d2 = (point - choice.point).length_squared();
        let projected = 0.5 * twice.dot(d).abs();
        if projected > 0.0 { chosen * d2 / projected } else { 0.0 }
    }
}

/// What is known of the emissive triangles of another moment.
#[derive(Default)]
struct Old {
    /// Of each emitter.
    bounds: Vec<LightBounds>,
    emitter_of: Vec<Vec<u32>>,
    same: Vec<bool>,
}

impl Old {
    /// The triangles of instance `i` that emit, and their bounds, if they are the same now.
    fn of(&self, i: usize) -> Option<(Vec<u32>, Vec<LightBounds>)> {
        let emitters = self.emitter_of.get(i).filter(|_| self.same.get(i) == Some(&true))?;
        let lit = (0u32..).zip(emitters).filter(|(_, e)| **e != NONE);
        Some(lit.map(|(t, &e)| (t, self.bounds[e as usize])).unzip())
    }
}

fn brightness(s: Spectrum) -> f32 {
    (s[0] + s[1] + s[2]) * (1.0 / 3.0)
}

/// Texture coordinates of a triangle's corners as `t` looks them up.
fn texture_corners(mesh: &MeshData, t: &TextureRef, triangle: u32) -> [Vec2; 3] {
    let corners = mesh.indices[triangle as usize];
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
        .map(|w| t.transform.transform_point2(mesh.uv(t.uv_set, corners, w)))
}

fn triangle_bounds(world: &World, instance: u32, triangle: u32) -> LightBounds {
    let i = &world.instances[instance as usize];
    let mesh = &world.meshes[i.mesh as usize];
    let m = &world.scene.materials[i.material as usize];
    let p = world.corners(instance, triangle);
    let twice = (p[1] - p[0]).cross(p[2] - p[0]) * i.handedness;
    let mut bounds = Bounds::EMPTY;
    p.iter().for_each(|&p| bounds.include(p));
    let area = twice.length() * 0.5;
    // The mean over the triangle by a grid that is as fine as the texture under it, within reason.
    let steps = match &m.emissive_texture {
        None => 1,
        Some(t) => {
            let texture = &world.scene.textures[t.texture as usize];
            let image = &world.scene.images[texture.image as usize];
            let uv = texture_corners(mesh, t, triangle);
            let texels =
                (uv[1] - uv[0]).perp_dot(uv[2] - uv[0]).abs() * image.width as f32 * image.height as f32;
            (texels.sqrt() as usize).clamp(2, 24)
        }
    };
    let corners = mesh.indices[triangle as usize];
    let mut sum = Spectrum::ZERO;
    let mut count = 0;
    for y in 0..steps {
        for x in 0..steps - y {
            let (u, v) = ((x as f32 + 1.0 / 3.0) / steps as f32, (y as f32 + 1.0 / 3.0) / steps as f32);
            sum += emitted(world, m, instance, &mut Lookup::new(corners, [1.0 - u - v, u, v]), 1.0);
            count += 1;
        }
    }
    let intensity = area * brightness(sum) / count as f32;
    LightBounds {
        bounds,
        axis: twice.try_normalize().unwrap_or(Vec3A::Y),
        cos_spread: 1.0,
        cos_reach: 0.0,
        two_sided: m.double_sided,
        intensity: if intensity.is_finite() { intensity } else { 0.0 },
    }
}

fn triangle_sample(
    world: &World,
    instance: u32,
    triangle: u32,
    from: Vec3A,
    probability: f32,
    u: [f32; 2],
) -> Option<LightSample> {
    let i = &world.instances[instance as usize];
    let m = &world.scene.materials[i.material as usize];
    let [a, b, c] = world.corners(instance, triangle);
    let w = uniform_triangle(u);
    let to = a * w[0] + b * w[1] + c * w[2] - from;
    let d2 = to.length_squared();
    let distance = d2.sqrt();
    if distance <= 0.0 {
        return None;
    }
    let wi = to / distance;
    let twice = (b - a).cross(c - a) * i.handedness;
    let facing = -twice.dot(wi);
    if facing <= 0.0 && !m.double_sided {
        return None;
    }
    let projected = 0.5 * facing.abs();
    if projected <= 0.0 {
        return None;
    }
    let corners = world.meshes[i.mesh as usize].indices[triangle as usize];
    let cos = facing / twice.length();
    let radiance = emitted(world, m, instance, &mut Lookup::new(corners, w), cos);
    Some(LightSample { wi, distance, radiance, pdf: probability * d2 / projected, delta: false })
}

fn punctual_bounds(l: &Light, profile: Option<&AimedProfile>) -> LightBounds {
    let p = Vec3A::from(l.position);
    let (axis, cos_reach) = match (l.kind, profile) {
        (LightKind::Spot { outer, .. }, _) => (Vec3A::from(l.direction), outer.cos()),
        (_, Some(p)) => (Vec3A::from(l.direction), p.profile().cos_reach()),
        _ => (Vec3A::Y, -1.0),
    };
    // As if a measured lamp were everywhere as strong as where it is strongest.
    let peak = profile.map_or(1.0, |p| p.profile().peak());
    // A spot is as strong everywhere within its cone: the spread, not the reach, is the cone; no cosine falls off.
    LightBounds {
        bounds: Bounds { min: p, max: p },
        axis,
        cos_spread: cos_reach,
        cos_reach: 0.0,
        two_sided: false,
        intensity: brightness(Spectrum::from_rgb(l.intensity.to_array())) * peak,
    }
}

/// Light from a point or spot light; equations of `KHR_lights_punctual`, "Range Property" and "Inner and Outer Cone Angles".
fn punctual_sample(
    l: &Light,
    profile: Option<&AimedProfile>,
    from: Vec3A,
    probability: f32,
) -> Option<LightSample> {
    let to = Vec3A::from(l.position) - from;
    let d2 = to.length_squared();
    let distance = d2.sqrt();
    if distance <= 0.0 {
        return None;
    }
    let wi = to / distance;
    let mut strength = 1.0 / d2;
    if let Some(range) = l.range.filter(|r| *r > 0.0) {
        let x = d2 / (range * range);
        strength *= (1.0 - x * x).clamp(0.0, 1.0);
    }
    if let LightKind::Spot { inner, outer } = l.kind {
        let cos_outer = outer.cos();
        let scale = 1.0 / (inner.cos() - cos_outer).max(1e-3);
        let t = ((-wi.dot(Vec3A::from(l.direction)) - cos_outer) * scale).clamp(0.0, 1.0);
        strength *= t * t;
    }
    if let Some(p) = profile {
        strength *= p.candela(-wi);
    }
    if strength <= 0.0 {
        return None;
    }
    let radiance = Spectrum::from_rgb((l.intensity * strength).to_array());
    Some(LightSample { wi, distance, radiance, pdf: probability, delta: true })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::Sampler;
    use etendue_scene::{Instance, Material, Mesh, Scene};
    use etendue_trace::Ray;
    use glam::{Affine3A, Vec3};

    /// Two rectangles near a point, one of them two-sided.
    fn world() -> World {
        let mut s = Scene::default();
        for (k, (center, two_sided)) in
            [(Vec3::new(0.0, 0.2, 0.0), true), (Vec3::new(2.0, 1.0, 0.3), false)].into_iter().enumerate()
        {
            let p = |x: f32, z: f32| center + Vec3::new(x, 0.1 * x, 0.5 * z);
            let mesh = Mesh {
                positions: vec![p(-1.0, -1.0), p(1.0, -1.0), p(1.0, 1.0), p(-1.0, 1.0)],
                indices: vec![[0, 1, 2], [0, 2, 3]],
                ..Mesh::default()
            };
            s.meshes.push(mesh.into());
            s.materials.push(Material {
                emissive: Vec3::splat(2.0 + k as f32),
                double_sided: two_sided,
                ..Material::default()
            });
            s.instances.push(Instance {
                name: String::new(),
                mesh: k as u32,
                material: Some(k as u32),
                transform: Affine3A::IDENTITY,
            });
        }
        World::new(s).expect("sound")
    }

    /// What `sample` says of its density is what `hit_pdf` says of the ray that finds the same point, and that density
    /// integrates over all directions to the share of samples that there are.
    #[test]
    fn both_ways_to_a_lamp_agree_on_the_density() {
        let w = world();
        for (p, n) in [
            (Vec3A::ZERO, Vec3A::Y),
            (Vec3A::new(0.3, 0.5, 0.1), Vec3A::NEG_Y),
            (Vec3A::new(1.5, -1.0, 0.0), Vec3A::new(0.6, 0.8, 0.0)),
        ] {
            let choice = w.lights.choose(p, n);
            let count = 1 << 16;
            let (mut there, mut integral) = (0u32, 0.0f64);
            for i in 0..count {
                let [u0, u1, pick, _] = Sampler::new(3, 0, 0, i).get4(0);
                if let Some(s) = w.lights.sample(&w, &choice, pick, [u0, u1]) {
                    there += 1;
                    let ray = Ray { t_min: s.distance * 0.999, ..Ray::new(p, s.wi) };
                    if let Some(hit) = w.accel.closest(&ray, &|_, _, _, _| true) {
                        let pdf = w.lights.hit_pdf(&w, &choice, &hit, s.wi);
                        assert!((pdf - s.pdf).abs() < 1e-2 * s.pdf, "{pdf} {} at {p}", s.pdf);
                    }
                }
                let d = etendue_bxdf::sampling::uniform_sphere([u0, u1]);
                let mut ray = Ray::new(p, d);
                while let Some(hit) = w.accel.closest(&ray, &|_, _, _, _| true) {
                    let front = crate::surface::Surface::new(&w, &hit, d).front;
                    if front || w.scene.materials[hit.instance as usize].double_sided {
                        integral += f64::from(w.lights.hit_pdf(&w, &choice, &hit, d));
                    }
                    ray.t_min = hit.t;
                }
            }
            let integral = integral * 4.0 * std::f64::consts::PI / f64::from(count);
            let share = f64::from(there) / f64::from(count);
            assert!((integral - share).abs() < 0.02, "{integral} of {share} at {p}");
        }
    }
}
