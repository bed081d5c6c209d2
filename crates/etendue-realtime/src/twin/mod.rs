//! The twin: the real-time picture drawn on the processor, pixel by pixel.
//!
//! Where a GPU rasterises triangles, here a ray finds what a sample of a pixel sees; what is shaded then is what a fragment
//! shader would shade. Camera rays are the path tracer's own ([`PixelRays`]), sample by sample, so that both pictures lie exactly
//! over each other; blended surfaces are laid over each other in order of distance; textures are read as the path tracer reads
//! them, texel by texel without mip levels: what is smaller than a pixel is averaged by the pixel's samples, after shading,
//! which is what the reference does and what mip levels approximate.
//!
//! A pixel is a pure function of scene and settings: the bits do not depend on threads.

mod frame;
mod neighbourhood;
mod point;

pub use frame::Frame;

use crate::choices::Choices;
use crate::inputs::{Inputs, Part};
use crate::lighting::Lighting;
use crate::passes::{Pass, PassSet};
use crate::shade::shade;
use crate::terms::{Shaded, Terms, Values};
use etendue_color::Spectrum;
use etendue_render::{Counters, Filter, PixelRays, Sampler, ShadingPoint, World};
use etendue_scene::Camera;
use etendue_trace::{Ray, Work, run_wide};
use frame::BEAUTY;
use glam::{Vec2, Vec3A};
use neighbourhood::Neighbourhood;
use rayon::prelude::*;
use std::cell::Cell;
use std::sync::atomic::{AtomicU64, Ordering};

/// What is to be drawn, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct TwinSettings {
    /// Pixels in a row, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
    /// Samples per pixel, at least 1.
    pub samples: u32,
    /// Pixel filter.
    pub filter: Filter,
    /// Changes where in its pixel a sample is; equal seeds share their rays with the path tracer.
    pub seed: u32,
    /// If false the sky lights the scene but is not in the picture.
    pub sky_visible: bool,
    /// What to record beside the picture.
    pub passes: PassSet,
}

impl Default for TwinSettings {
    fn default() -> Self {
        Self {
            width: 512,
            height: 512,
            samples: 16,
            filter: Filter::default(),
            seed: 0,
            sky_visible: true,
            passes: PassSet::default(),
        }
    }
}

/// Draws one picture of a world by real-time shading.
///
/// ```
/// use etendue_realtime::{Choices, Lighting, Twin, TwinSettings};
/// use etendue_render::World;
/// use etendue_scene::{Camera, Environment, Scene};
/// use glam::Vec3;
///
/// let world = World::new(Scene { environment: Environment::Constant(Vec3::splat(0.5)), ..Scene::default() })?;
/// let camera = Camera::look_at(Vec3::Z, Vec3::ZERO, Vec3::Y, 0.6);
/// let choices = Choices::default();
/// let lighting = Lighting::new(world.scene(), &choices)?;
/// let settings = TwinSettings { width: 8, height: 8, ..TwinSettings::default() };
/// let frame = Twin::new(&world, &camera, &lighting, choices, settings).render(&Default::default());
/// assert!(frame.beauty().all(|[r, g, b, a]| [r, g, b] == [0.5; 3] && a == 0.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Twin<'a> {
    world: &'a World,
    lighting: &'a Lighting,
    choices: Choices,
    rays: PixelRays,
    origin: Vec3A,
    settings: TwinSettings,
}

/// Blended surfaces that one ray goes through before the rest is left to the sky.
const MOST_LAYERS: u32 = 64;
/// What is left of a ray after blended surfaces and may be forgotten.
const NOTHING_LEFT: f32 = 1.0 / 1024.0;
/// Rows that a thread takes at a time.
const BAND: usize = 4;

impl<'a> Twin<'a> {
    /// A twin of `world` seen by `camera`. `lighting` is made from `world.scene()` for the same `choices`.
    pub fn new(
        world: &'a World,
        camera: &Camera,
        lighting: &'a Lighting,
        choices: Choices,
        settings: TwinSettings,
    ) -> Self {
        let rays = PixelRays::new(camera, [settings.width, settings.height], settings.filter);
        Self { world, lighting, choices, rays, origin: camera.transform.translation, settings }
    }

    /// Draws the picture, on all threads of the current pool; `counters` may be read meanwhile.
    pub fn render(&self, counters: &Counters) -> Frame {
        let s = &self.settings;
        let (width, height) = (s.width as usize, s.height as usize);
        let stride = Frame::stride(s.passes);
        let mut values = vec![0.0; width * height * stride];
        let rejected = AtomicU64::new(0);
        values.par_chunks_mut(BAND * width * stride).enumerate().for_each(|(band, values)| {
            let first_row = (band * BAND) as u32;
            let done = run_wide(Band { twin: self, first_row, values });
            counters.closest_rays.fetch_add(done.rays[0], Ordering::Relaxed);
            counters.any_rays.fetch_add(done.rays[1], Ordering::Relaxed);
            counters.samples.fetch_add(done.samples, Ordering::Relaxed);
            rejected.fetch_add(done.rejected, Ordering::Relaxed);
        });
        Frame { width: s.width, height: s.height, passes: s.passes, rejected: rejected.into_inner(), values }
    }

    /// Goes along a ray through the surfaces that are seen on it, from the nearest on: `each` gets the point, the shading model's
    /// inputs and the part of the ray that meets it there. Surfaces of which `skip` is true are not there. Returns the part that
    /// meets none.
    #[inline(always)]
    fn layers(
        &self,
        mut ray: Ray,
        part: Part,
        rays: &[Cell<u64>; 2],
        skip: impl Fn(&ShadingPoint) -> bool,
        mut each: impl FnMut(&ShadingPoint, &Inputs, f32),
    ) -> f32 {
        let direction = ray.direction;
        let mut left = 1.0f32;
        for _ in 0..MOST_LAYERS {
            rays[0].set(rays[0].get() + 1);
            let Some(hit) = self.world.seen(&ray) else { break };
            ray.t_min = hit.t;
            let p = self.world.shading_point(&hit, direction);
            if skip(&p) {
                continue;
            }
            each(&p, &point::inputs(&p, direction, part), left * p.alpha);
            left *= 1.0 - p.alpha;
            if left < NOTHING_LEFT {
                return 0.0;
            }
        }
        left
    }

    /// One sample of a pixel.
    #[inline(always)]
    fn sample<const PASSES: bool>(&self, x: u32, y: u32, index: u32, rays: &[Cell<u64>; 2]) -> Sample {
        let sampler = Sampler::new(self.settings.seed, x, y, index);
        let (origin, direction) = self.rays.sample([x, y], &sampler);
        let mut out = Sample::default();
        // Sums begin at nothing; a point of its own is open.
        (out.values.occlusion, out.values.specular_occlusion) = (0.0, 0.0);
        let [u0, u1, ..] = sampler.get4(1);
        let part = Part { index, of: self.settings.samples };
        let left = self.layers(
            Ray::new(origin, direction),
            part,
            rays,
            |_| false,
            |p, inputs, weight| {
                let around = Neighbourhood { twin: self, point: p, part, lobe: Some([u0, u1]), rays };
                let shaded = shade(inputs, self.lighting, &self.choices, &around);
                out.add::<PASSES>(&shaded, p, weight);
            },
        );
        out.alpha = 1.0 - left;
        if left > 0.0 && self.settings.sky_visible {
            out.environment = self.world.sky_radiance(direction) * left;
        }
        out
    }
}

/// One sample of one pixel; of surfaces what each weighs.
#[derive(Clone, Copy, Debug, Default)]
struct Sample {
    terms: Terms,
    environment: Spectrum,
    alpha: f32,
    values: Values,
    position: Vec3A,
    uv: Vec2,
}

impl Sample {
    #[inline(always)]
    fn add<const PASSES: bool>(&mut self, shaded: &Shaded, p: &ShadingPoint, weight: f32) {
        let (a, b) = (&mut self.terms, &shaded.terms);
        a.direct_diffuse += b.direct_diffuse * weight;
        a.direct_specular += b.direct_specular * weight;
        a.indirect_diffuse += b.indirect_diffuse * weight;
        a.indirect_specular += b.indirect_specular * weight;
        a.transmission += b.transmission * weight;
        a.emission += b.emission * weight;
        if !PASSES {
            return;
        }
        self.position += p.position * weight;
        self.uv += p.uv * weight;
        let (a, b) = (&mut self.values, &shaded.values);
        macro_rules! add {
            ($($field:ident)*) => { $( a.$field += b.$field * weight; )* };
        }
        add!(normal tangent bitangent vertex_normal reflection nv nl hv d f g ks kd irradiance prefiltered mip);
        add!(kd_indirect occlusion specular_occlusion base_color metallic roughness f0);
        (0..2).for_each(|i| a.env_brdf[i] += b.env_brdf[i] * weight);
    }

    /// Adds the sample to a pixel's sums.
    #[inline(always)]
    fn add_to(&self, sums: &mut [f32], passes: PassSet, eye: Vec3A, axis: Vec3A) {
        let [r, g, b, _] = (self.terms.sum() + self.environment).0;
        for (sum, v) in sums.iter_mut().zip([r, g, b, self.alpha]) {
            *sum += v;
        }
        if passes.is_empty() {
            return;
        }
        let mut at = sums[BEAUTY..].iter_mut();
        let mut put = |values: &[f32]| {
            for (v, sum) in values.iter().zip(at.by_ref()) {
                *sum += if v.is_finite() { *v } else { 0.0 };
            }
        };
        let (t, v) = (&self.terms, &self.values);
        for pass in passes.iter() {
            match pass {
                Pass::Position => put(&self.position.to_array()),
                Pass::Depth => put(&[(self.position - eye * self.alpha).dot(axis)]),
                Pass::Uv => put(&self.uv.to_array()),
                Pass::Tangent => put(&v.tangent.to_array()),
                Pass::Bitangent => put(&v.bitangent.to_array()),
                Pass::VertexNormal => put(&v.vertex_normal.to_array()),
                Pass::Normal => put(&v.normal.to_array()),
                Pass::Reflection => put(&v.reflection.to_array()),
                Pass::BaseColor => put(&v.base_color.to_rgb()),
                Pass::Metallic => put(&[v.metallic]),
                Pass::Roughness => put(&[v.roughness]),
                Pass::F0 => put(&v.f0.to_rgb()),
                Pass::Nv => put(&[v.nv]),
                Pass::Nl => put(&[v.nl]),
                Pass::Hv => put(&[v.hv]),
                Pass::D => put(&[v.d]),
                Pass::F => put(&v.f.to_rgb()),
                Pass::G => put(&[v.g]),
                Pass::Ks => put(&v.ks.to_rgb()),
                Pass::Kd => put(&v.kd.to_rgb()),
                Pass::DirectDiffuse => put(&t.direct_diffuse.to_rgb()),
                Pass::DirectSpecular => put(&t.direct_specular.to_rgb()),
                Pass::Irradiance => put(&v.irradiance.to_rgb()),
                Pass::KdIndirect => put(&v.kd_indirect.to_rgb()),
                Pass::IndirectDiffuse => put(&t.indirect_diffuse.to_rgb()),
                Pass::Prefiltered => put(&v.prefiltered.to_rgb()),
                Pass::Mip => put(&[v.mip]),
                Pass::EnvBrdf => put(&v.env_brdf),
                Pass::IndirectSpecular => put(&t.indirect_specular.to_rgb()),
                Pass::Occlusion => put(&[v.occlusion]),
                Pass::SpecularOcclusion => put(&[v.specular_occlusion]),
                Pass::Transmission => put(&t.transmission.to_rgb()),
                Pass::Emission => put(&t.emission.to_rgb()),
                Pass::Environment => put(&self.environment.to_rgb()),
                Pass::Linear | Pass::ToneMapped => {}
            }
        }
    }
}

/// Some rows of pixels to be drawn.
struct Band<'a, 'v> {
    twin: &'a Twin<'a>,
    first_row: u32,
    values: &'v mut [f32],
}

/// Work that was done.
#[derive(Default)]
struct Done {
    rays: [u64; 2],
    samples: u64,
    rejected: u64,
}

impl Work for Band<'_, '_> {
    type Output = Done;

    #[inline(always)]
    fn run(self) -> Done {
        if self.twin.settings.passes.is_empty() { self.draw::<false>() } else { self.draw::<true>() }
    }
}

impl Band<'_, '_> {
    #[inline(always)]
    fn draw<const PASSES: bool>(self) -> Done {
        let s = &self.twin.settings;
        let (eye, axis) = (self.twin.origin, self.twin.rays.axis());
        let rays = [const { Cell::new(0) }; 2];
        let mut done = Done::default();
        let inverse = 1.0 / s.samples as f32;
        for (i, pixel) in self.values.chunks_exact_mut(Frame::stride(s.passes)).enumerate() {
            let (x, y) = (i as u32 % s.width, self.first_row + i as u32 / s.width);
            for index in 0..s.samples {
                let mut sample = self.twin.sample::<PASSES>(x, y, index, &rays);
                if !(sample.terms.sum() + sample.environment).is_finite() {
                    done.rejected += 1;
                    (sample.terms, sample.environment) = (Terms::default(), Spectrum::ZERO);
                }
                sample.add_to(pixel, s.passes, eye, axis);
            }
            pixel.iter_mut().for_each(|v| *v *= inverse);
            done.samples += u64::from(s.samples);
        }
        done.rays = rays.map(Cell::into_inner);
        done
    }
}
