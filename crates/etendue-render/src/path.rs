//! The path tracer: unidirectional, next-event estimation at each vertex, multiple importance sampling.

use crate::lights::LightChoice;
use crate::sampler::Sampler;
use crate::surface::Surface;
use crate::world::World;
use etendue_bxdf::Bsdf;
use etendue_bxdf::sampling::power_heuristic;
use etendue_color::Spectrum;
use etendue_trace::{Hit, Ray};
use glam::{Vec2, Vec3A};

/// What limits a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathOptions {
    /// Most times that light is scattered on its way to the camera; 0 shows only what shines by itself.
    pub bounces: u32,
    /// Bounces after which a path may be ended by chance (Russian roulette), in proportion to what it still carries.
    pub roulette_after: u32,
    /// Largest value of any channel of one sample's indirect light; infinite (the default) is unbiased.
    pub clamp_indirect: f32,
    /// If false the sky lights the scene but camera rays that meet nothing return nothing.
    pub sky_visible: bool,
}

impl Default for PathOptions {
    fn default() -> Self {
        Self { bounces: 8, roulette_after: 2, clamp_indirect: f32::INFINITY, sky_visible: true }
    }
}

/// One sample of one pixel.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PathSample {
    pub radiance: Spectrum,
    /// 1 if the camera ray met a surface.
    pub alpha: f32,
    /// Rays that were traced: closest-hit and any-hit.
    pub rays: [u32; 2],
}

/// What the passes are made of; filled only if asked for.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Layers {
    pub albedo: Spectrum,
    pub normal: Vec3A,
    pub position: Vec3A,
    pub depth: f32,
    pub uv: Vec2,
    pub direct: Spectrum,
    pub indirect: Spectrum,
    pub diffuse: Spectrum,
    pub specular: Spectrum,
    pub emission: Spectrum,
    pub environment: Spectrum,
    /// Instance and material that the camera sees.
    pub seen: Option<(u32, u32)>,
}

/// Backs that a camera ray looks through before one is taken for a front.
const MOST_LAYERS: u32 = 1024;

/// Dimension sets: the camera has 0; each bounce has two.
const SETS_PER_BOUNCE: u32 = 2;

/// Traces a path from the camera. `LAYERS` fills `layers`; `axis` is the camera's unit view direction.
#[inline(always)]
pub(crate) fn trace<const LAYERS: bool>(
    world: &World,
    options: &PathOptions,
    sampler: &Sampler,
    origin: Vec3A,
    direction: Vec3A,
    axis: Vec3A,
    layers: &mut Layers,
) -> PathSample {
    let mut out = PathSample::default();
    let mut origin = origin;
    let mut direction = direction;
    let mut throughput = Spectrum::ONE;
    // The part of `throughput` whose first scattering, seen from the camera, was diffuse.
    let mut diffuse_part = Spectrum::ZERO;
    // How the last vertex would have drawn the light that this ray finds; `None` if it could not.
    let mut last: Option<(f32, LightChoice)> = None;
    let mut bounce = 0;

    // Light found after `bounce` scatterings, worth `light` × `throughput`.
    let add = |out: &mut PathSample,
               layers: &mut Layers,
               throughput: Spectrum,
               diffuse_part: Spectrum,
               light: Spectrum,
               bounces: u32| {
        let mut value = throughput * light;
        if bounces > 1 && options.clamp_indirect < f32::INFINITY {
            let max = value.max_element();
            if max > options.clamp_indirect {
                value *= options.clamp_indirect / max;
            }
        }
        out.radiance += value;
        if LAYERS && bounces > 0 {
            let l = layers;
            let diffuse = (diffuse_part * light).min(value);
            l.diffuse += diffuse;
            l.specular += value - diffuse;
            *(if bounces == 1 { &mut l.direct } else { &mut l.indirect }) += value;
        }
    };

    loop {
        let key = sampler.hash(bounce * 2);
        let mut ray = Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY };
        // The camera looks through the backs of one-sided surfaces, as glTF asks for (`doubleSided`, section 3.9.6). For light,
        // a surface has two sides.
        let hit = loop {
            out.rays[0] += 1;
            let Some(hit) = world.closest(&ray, key) else { break None };
            let surface = Surface::new(world, &hit, direction);
            let seen = surface.front || world.scene.materials[surface.material as usize].double_sided;
            if bounce > 0 || seen || out.rays[0] > MOST_LAYERS {
                break Some((hit, surface));
            }
            ray.t_min = hit.t;
        };

        let Some((hit, mut surface)) = hit else {
            if bounce > 0 || options.sky_visible {
                let (light, weight) = match &last {
                    Some((pdf, choice)) => {
                        let (light, light_pdf) = world.lights.sky(choice, direction);
                        (light, power_heuristic(*pdf, light_pdf))
                    }
                    None => (world.lights.sky_radiance(direction), 1.0),
                };
                add(&mut out, layers, throughput, diffuse_part, light * weight, bounce);
                if LAYERS && bounce == 0 {
                    layers.environment = light;
                }
            }
            return out;
        };

        let emission = surface.emission(world, &hit);
        let material = &world.scene.materials[surface.material as usize];
        if !emission.is_black() {
            let weight = match &last {
                Some((pdf, choice)) if !material.unlit => {
                    power_heuristic(*pdf, world.lights.hit_pdf(world, choice, &hit, direction))
                }
                _ => 1.0,
            };
            add(&mut out, layers, throughput, diffuse_part, emission * weight, bounce);
        }
        if bounce == 0 {
            out.alpha = 1.0;
            if LAYERS {
                layers.emission = emission;
                record_geometry(layers, &hit, &surface, surface.point - origin, axis);
            }
        }
        if material.unlit {
            if LAYERS && bounce == 0 {
                layers.albedo = emission;
            }
            return out;
        }
        if bounce >= options.bounces && !(LAYERS && bounce == 0) {
            return out;
        }

        let closure = surface.closure(world, &hit);
        let wo = surface.frame.transpose() * -direction;
        if LAYERS && bounce == 0 {
            layers.albedo = closure.albedo(wo);
            if options.bounces == 0 {
                return out;
            }
        }
        let choice = world.lights.choose(surface.lifted, surface.frame.z_axis);

        // Light that is asked for.
        let set = 1 + bounce * SETS_PER_BOUNCE;
        let [u0, u1, pick, _] = sampler.get4(set);
        if let Some(light) = world.lights.sample(world, &choice, pick, [u0, u1]) {
            let cos_geometric = light.wi.dot(surface.geometric);
            if cos_geometric > 0.0 && light.pdf > 0.0 {
                let wi = surface.frame.transpose() * light.wi;
                let e = closure.eval_pdf(wo, wi);
                if !e.value().is_black() && !light.radiance.is_black() {
                    let from = surface.origin(world, light.wi);
                    // From where the ray really starts to the point on the light, and not quite there: aimed along `wi` it
                    // would meet a slanted light too early.
                    let ray = if light.distance.is_finite() {
                        let to = surface.lifted + light.wi * light.distance - from;
                        Ray { origin: from, direction: to, t_min: 0.0, t_max: 1.0 - 1e-4 }
                    } else {
                        Ray::new(from, light.wi)
                    };
                    out.rays[1] += 1;
                    if !world.occluded(&ray, sampler.hash(bounce * 2 + 1)) {
                        let weight = if light.delta { 1.0 } else { power_heuristic(light.pdf, e.pdf) };
                        let scale = light.radiance * (wi.z * weight / light.pdf);
                        let part = if bounce == 0 { e.diffuse } else { diffuse_part * e.value() };
                        add(&mut out, layers, throughput * e.value(), part, scale, bounce + 1);
                    }
                }
            }
        }

        // Light that scattering finds.
        let [u0, u1, uc, roulette] = sampler.get4(set + 1);
        let Some(s) = closure.sample(wo, uc, [u0, u1]) else { return out };
        let wi = surface.frame * s.wi;
        // Directions that lie above the shading normal but below the surface carry no light.
        if wi.dot(surface.geometric) <= 0.0 {
            return out;
        }
        throughput *= s.weight;
        diffuse_part = if bounce == 0 { s.weight_diffuse } else { diffuse_part * s.weight };
        last = (!s.delta).then_some((s.pdf, choice));
        bounce += 1;
        if bounce > options.roulette_after {
            let survival = throughput.max_element().min(1.0);
            if roulette >= survival {
                return out;
            }
            throughput *= 1.0 / survival;
            diffuse_part *= 1.0 / survival;
        }
        if throughput.is_black() {
            return out;
        }
        origin = surface.origin(world, wi);
        direction = wi.normalize();
    }
}

fn record_geometry(l: &mut Layers, hit: &Hit, surface: &Surface, to: Vec3A, axis: Vec3A) {
    l.normal = surface.frame.z_axis;
    l.position = surface.point;
    l.depth = to.dot(axis);
    l.uv = surface.uv;
    l.seen = Some((hit.instance, surface.material));
}
