//! The path tracer: unidirectional, next-event estimation at each vertex, multiple importance sampling.

use crate::lights::LightChoice;
use crate::media::Media;
use crate::medium;
use crate::sampler::Sampler;
use crate::scattering::Scattering;
use crate::surface::Surface;
use crate::world::World;
use etendue_bxdf::Bsdf;
use etendue_bxdf::model::{Incidence, Transport};
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
    /// Shows what the lights and the sky alone would make of each surface: nothing stands in their way, and no surface lights
    /// another. This is what a real-time shading model without shadows aims at. `bounces` beyond 1 make no difference, and
    /// half-spaces are those of the shading normal. A body that lets light through shows the sky as its first surface refracts it.
    pub light_only: bool,
}

impl Default for PathOptions {
    fn default() -> Self {
        Self {
            bounces: 8,
            roulette_after: 2,
            clamp_indirect: f32::INFINITY,
            sky_visible: true,
            light_only: false,
        }
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
    /// By [`Source`]: diffuse, then specular.
    pub sources: [[Spectrum; 2]; 3],
    pub transmission: Spectrum,
    /// Instance and material that the camera sees.
    pub seen: Option<(u32, u32)>,
}

/// Where light comes from that a surface sends to the camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Source {
    /// Directional, point and spot lights.
    Light,
    Sky,
    /// Other surfaces, which shine or scatter.
    Surface,
}

/// Backs that a camera ray looks through before one is taken for a front.
const MOST_LAYERS: u32 = 1024;

/// Dimension sets: the camera has 0; each bounce has two, and further ones where light travels under a surface.
const SETS_PER_BOUNCE: u32 = 2;
const SKIN_SETS: u32 = 1 << 16;
const ENTRY_SETS: u32 = 1 << 17;
/// One for each way through a medium that scatters.
const MEDIUM_SETS: u32 = 1 << 18;

/// Lanes that carry light: one that a path chooses stands for all.
const LANES: u8 = 3;

/// Traces a path from the camera. `LAYERS` fills `layers`; `axis` is the camera's unit view direction. `WHOLE` follows light
/// through surfaces and asks models other than glTF's core; scenes without them do not pay for it. Only the form with
/// `LAYERS` knows [`PathOptions::light_only`].
#[inline(always)]
pub(crate) fn trace<const LAYERS: bool, const WHOLE: bool>(
    world: &World,
    options: &PathOptions,
    sampler: &Sampler,
    origin: Vec3A,
    direction: Vec3A,
    axis: Vec3A,
    layers: &mut Layers,
) -> PathSample {
    let alone = LAYERS && options.light_only;
    let mut out = PathSample::default();
    let mut origin = origin;
    let mut direction = direction;
    let mut throughput = Spectrum::ONE;
    // The part of `throughput` whose first scattering, seen from the camera, was diffuse.
    let mut diffuse_part = Spectrum::ZERO;
    // How the last vertex would have drawn the light that this ray finds; `None` if it could not.
    let mut last: Option<(f32, LightChoice)> = None;
    let mut bounce = 0;
    // What the path is inside of, the only lane that it carries after dispersion, and the part of its throughput that
    // refraction has compressed and will give back.
    let mut media = Media::default();
    let mut lane = None;
    let mut decompression = 1.0f32;
    // The path left the first surface on the other side.
    let mut through = false;
    // Ways through media that scatter.
    let mut flights = 0;

    // Light found after `bounce` scatterings, worth `light` × `throughput`.
    let add = |out: &mut PathSample,
               layers: &mut Layers,
               throughput: Spectrum,
               diffuse_part: Spectrum,
               light: Spectrum,
               bounces: u32,
               (source, through): (Source, bool)| {
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
            if through {
                l.transmission += value;
            } else {
                let source = if bounces == 1 { source } else { Source::Surface };
                let [d, s] = &mut l.sources[source as usize];
                *d += diffuse;
                *s += value - diffuse;
            }
        }
    };

    'path: loop {
        let key = sampler.hash(bounce * 2);
        let mut ray = Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY };
        // The camera looks through the backs of one-sided surfaces, as glTF asks for (`doubleSided`, section 3.9.6). For light,
        // a surface has two sides.
        let (mut travelled, mut crossed) = (0.0, 0);
        let hit = loop {
            if alone && bounce > 0 {
                break None;
            }
            out.rays[0] += 1;
            let Some(hit) = world.closest(&ray, key) else { break None };
            let surface = Surface::new(world, &hit, direction);
            if WHOLE {
                // A path that meets nothing is not inside of anything, whatever it has entered.
                if let Some((extinction, scatter)) = media.scatters(&world.bodies) {
                    let [pick, u, v0, v1] = sampler.get4(MEDIUM_SETS + flights);
                    let reach = hit.t - travelled;
                    let lanes = LANES.into();
                    let Some(flight) = medium::fly(extinction, &scatter, throughput, lanes, reach, [pick, u])
                    else {
                        return out;
                    };
                    throughput *= flight.factor;
                    diffuse_part *= flight.factor;
                    if let Some(distance) = flight.event {
                        let goes_on = medium::survival(flights, throughput.max_element() * decompression);
                        if flight.left >= goes_on {
                            return out;
                        }
                        throughput *= 1.0 / goes_on;
                        diffuse_part *= 1.0 / goes_on;
                        origin += direction * (travelled + distance);
                        direction = medium::scattered(direction, scatter.anisotropy, [v0, v1]);
                        // No light was asked for there: what is found counts fully.
                        last = None;
                        flights += 1;
                        continue 'path;
                    }
                    flights += 1;
                } else {
                    let left = media.transmittance(&world.bodies, hit.t - travelled);
                    throughput *= left;
                    diffuse_part *= left;
                }
                travelled = hit.t;
                let bounded = world.bodies[surface.material as usize].interior.is_some();
                if bounded
                    && crossed < MOST_LAYERS
                    && media.hides(&world.bodies, surface.material, surface.front)
                {
                    media.cross(surface.material, surface.front);
                    crossed += 1;
                    ray.t_min = hit.t;
                    continue;
                }
            }
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
                let from = (Source::Sky, through);
                add(&mut out, layers, throughput, diffuse_part, light * weight, bounce, from);
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
            let from = (Source::Surface, through);
            add(&mut out, layers, throughput, diffuse_part, emission * weight, bounce, from);
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

        let mut set = 1 + bounce * SETS_PER_BOUNCE;
        let mut points = sampler.get4(set);
        let body = &world.bodies[surface.material as usize];
        let passes = WHOLE && body.passes;
        let mut closure = if WHOLE {
            if lane.is_none() && body.interior.is_some_and(|m| m.dispersive) {
                let chosen = ((points[3] * f32::from(LANES)) as u8).min(LANES - 1);
                let only = |i| if i == chosen as usize { LANES.into() } else { 0.0 };
                let only = Spectrum(std::array::from_fn(only));
                throughput *= only;
                diffuse_part *= only;
                lane = Some(chosen);
            }
            let exterior_ior = media.exterior_ior(&world.bodies, surface.material, surface.front);
            let at = Incidence { front: surface.front, exterior_ior, transport: Transport::Radiance, lane };
            surface.scattering(world, &hit, &at)
        } else {
            Scattering::Plain(surface.plain(world, &hit))
        };
        let mut wo = surface.frame.transpose() * -direction;
        if LAYERS && bounce == 0 {
            layers.albedo = closure.albedo(wo);
            if options.bounces == 0 {
                return out;
            }
        }
        // On skin, the share of the light that came from below and the probability of following the gloss instead.
        let mut skin = if WHOLE { body.skin.as_ref().filter(|_| surface.front) } else { None };
        let (below, gloss) = skin.map_or((0.0, 1.0), |s| s.split(wo));
        if let Some(skin) = skin {
            closure = Scattering::Plain(skin.gloss);
        }
        let mut entered = false;

        // Once; on skin perhaps again, where the light entered.
        let (s, choice, roulette) = loop {
            let side = if passes { Vec3A::ZERO } else { surface.frame.z_axis };
            let choice = world.lights.choose(surface.lifted, side);

            // Light that is asked for.
            let [u0, u1, pick, _] = points;
            if let Some(light) = world.lights.sample(world, &choice, pick, [u0, u1]) {
                let wi = surface.frame.transpose() * light.wi;
                // The triangle's own half-space is what it hides from itself.
                let above = if alone { wi.z > 0.0 } else { light.wi.dot(surface.geometric) > 0.0 };
                let source = match (light.delta, light.distance.is_finite()) {
                    (true, _) => Source::Light,
                    (false, false) => Source::Sky,
                    (false, true) => Source::Surface,
                };
                let counts = !(alone && source == Source::Surface);
                // A direction above the shading normal and below the surface, or the other way round, carries no light.
                if counts && (above || passes) && light.pdf > 0.0 && (!passes || above == (wi.z > 0.0)) {
                    let mut e = closure.eval_pdf(wo, wi);
                    if WHOLE && skin.is_some() {
                        e.pdf *= gloss;
                    }
                    if !e.value().is_black() && !light.radiance.is_black() {
                        let from = surface.origin(world, light.wi);
                        // From where the ray really starts to the point on the light, and not quite there: aimed along
                        // `wi` it would meet a slanted light too early.
                        let ray = if light.distance.is_finite() {
                            let to = surface.lifted + light.wi * light.distance - from;
                            Ray { origin: from, direction: to, t_min: 0.0, t_max: 1.0 - 1e-4 }
                        } else {
                            Ray::new(from, light.wi)
                        };
                        let free = alone || {
                            out.rays[1] += 1;
                            !world.occluded(&ray, sampler.hash(bounce * 2 + 1))
                        };
                        if free {
                            let weight = if light.delta { 1.0 } else { power_heuristic(light.pdf, e.pdf) };
                            let mut scale = light.radiance * (wi.z.abs() * weight / light.pdf);
                            if WHOLE && light.distance.is_finite() {
                                let mut there = media;
                                if !above && body.interior.is_some() {
                                    there.cross(surface.material, surface.front);
                                }
                                scale *= there.transmittance(&world.bodies, light.distance);
                            }
                            let first = bounce == 0 && !(WHOLE && entered);
                            let part = if first { e.diffuse } else { diffuse_part * e.value() };
                            let from = (source, through || (bounce == 0 && !above));
                            add(&mut out, layers, throughput * e.value(), part, scale, bounce + 1, from);
                        }
                    }
                }
            }

            // Light that scattering finds.
            let [u0, u1, mut uc, roulette] = sampler.get4(set + 1);
            if let Some(s) = skin {
                if uc >= gloss {
                    let [v0, v1, pick, _] = sampler.get4(SKIN_SETS + bounce);
                    let uc = (uc - gloss) / (1.0 - gloss);
                    let Some((found, weight)) = s.enter(world, &surface, uc, [v0, v1], pick) else {
                        return out;
                    };
                    throughput *= weight * (below / (1.0 - gloss));
                    diffuse_part = if bounce == 0 {
                        throughput
                    } else {
                        diffuse_part * weight * (below / (1.0 - gloss))
                    };
                    surface = found;
                    closure = Scattering::Entry(s.entry);
                    wo = Vec3A::Z;
                    set = ENTRY_SETS + bounce * SETS_PER_BOUNCE;
                    points = sampler.get4(set);
                    (skin, entered) = (None, true);
                    continue;
                }
                uc /= gloss;
            }
            let Some(mut s) = closure.sample(wo, uc, [u0, u1]) else { return out };
            if WHOLE && skin.is_some() {
                s.pdf *= gloss;
                let scale = 1.0 / gloss;
                (s.weight, s.weight_diffuse) = (s.weight * scale, s.weight_diffuse * scale);
            }
            break (s, choice, roulette);
        };
        let wi = surface.frame * s.wi;
        let above = if alone { s.wi.z > 0.0 } else { wi.dot(surface.geometric) > 0.0 };
        if above != (!passes || s.wi.z > 0.0) {
            return out;
        }
        if passes && !above {
            if body.interior.is_some() {
                media.cross(surface.material, surface.front);
                if body.mottled && surface.front {
                    media.enter_mottled(surface.material, surface.entered(world, &hit));
                }
            }
            let eta = closure.refraction().unwrap_or(1.0);
            decompression *= eta * eta;
            through |= LAYERS && bounce == 0;
        }
        throughput *= s.weight;
        let first = bounce == 0 && !(WHOLE && entered);
        diffuse_part = if first { s.weight_diffuse } else { diffuse_part * s.weight };
        last = (!s.delta).then_some((s.pdf, choice));
        bounce += 1;
        if bounce > options.roulette_after {
            let survival = (throughput.max_element() * decompression).min(1.0);
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
