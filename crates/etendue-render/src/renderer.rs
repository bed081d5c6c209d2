//! A camera, a world and settings: samples of pixels, and batches of them on all threads.

use crate::film::{BEAUTY_PLANES, Film};
use crate::filter::Filter;
use crate::fixed::Running;
use crate::moments::Block;
use crate::path::{Layers, PathOptions, PathSample, Source, trace};
use crate::pixel_rays::PixelRays;
use crate::sampler::Sampler;
use crate::world::World;
use crate::{Coverage, Fixed, Pass, PassSet};
use etendue_color::Spectrum;
use etendue_scene::Camera;
use etendue_trace::{Work, run_wide};
use glam::Vec3A;
use rayon::prelude::*;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

/// What is to be rendered, and how, apart from the number of samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Pixels in a row, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
    /// Pixel filter.
    pub filter: Filter,
    /// Changes all random numbers.
    pub seed: u32,
    /// Path limits.
    pub path: PathOptions,
    /// What to record beside the beauty picture.
    pub passes: PassSet,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            width: 512,
            height: 512,
            filter: Filter::default(),
            seed: 0,
            path: PathOptions::default(),
            passes: PassSet::default(),
        }
    }
}

/// Work done so far; may be read from another thread while rendering goes on.
#[derive(Debug, Default)]
pub struct Counters {
    /// Closest-hit rays traced.
    pub closest_rays: AtomicU64,
    /// Any-hit rays traced.
    pub any_rays: AtomicU64,
    /// Samples taken, over all pixels.
    pub samples: AtomicU64,
}

impl Counters {
    /// Rays of both kinds.
    pub fn rays(&self) -> u64 {
        self.closest_rays.load(Ordering::Relaxed) + self.any_rays.load(Ordering::Relaxed)
    }
}

/// Renders samples of one picture.
pub struct Renderer<'a> {
    world: &'a World,
    camera: Camera,
    rays: PixelRays,
    settings: Settings,
    hashes: [Vec<u32>; 2],
    /// The scene needs more than glTF's core closure.
    whole: bool,
}

/// Side of the square of pixels that a thread takes at a time.
const TILE: u32 = 16;

impl<'a> Renderer<'a> {
    /// A renderer of `world` seen by `camera`.
    pub fn new(world: &'a World, camera: Camera, settings: Settings) -> Self {
        let scene = world.scene();
        let hashes = if settings.passes.has(Pass::ObjectId) || settings.passes.has(Pass::MaterialId) {
            [
                scene.instances.iter().map(|i| crate::name_hash(&i.name)).collect(),
                scene.materials.iter().map(|m| crate::name_hash(&m.name)).collect(),
            ]
        } else {
            [Vec::new(), Vec::new()]
        };
        let rays = PixelRays::new(&camera, [settings.width, settings.height], settings.filter);
        Self { world, camera, rays, settings, hashes, whole: world.is_whole() }
    }

    /// The settings that it was made with.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The camera that it was made with.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Names exactly this picture: scene, camera and settings. Films with the same name add.
    pub fn picture_id(&self) -> String {
        crate::fingerprint::picture(self.world.fingerprint(), &self.camera, &self.settings)
    }

    /// An empty film of the right size and passes.
    pub fn film(&self) -> Film {
        Film::new(self.settings.width, self.settings.height, self.settings.passes)
    }

    /// One sample of one pixel: linear radiance and whether a surface was seen. A pure function of its arguments; what
    /// [`Renderer::render`] adds to the film.
    pub fn sample(&self, x: u32, y: u32, index: u32) -> (Spectrum, f32) {
        let s = self.path::<true, true>(x, y, index, &mut Layers::default());
        (s.radiance, s.alpha)
    }

    #[inline(always)]
    fn path<const LAYERS: bool, const WHOLE: bool>(
        &self,
        x: u32,
        y: u32,
        index: u32,
        layers: &mut Layers,
    ) -> PathSample {
        let s = &self.settings;
        let sampler = Sampler::new(s.seed, x, y, index);
        let (origin, direction) = self.rays.sample([x, y], &sampler);
        trace::<LAYERS, WHOLE>(self.world, &s.path, &sampler, origin, direction, self.rays.axis(), layers)
    }

    /// Takes the samples `from..to` of every pixel and adds them to `film`, on all threads of the current pool.
    ///
    /// # Panics
    /// If `film` has another size or other passes, or already holds one of the samples.
    pub fn render(&self, film: &mut Film, from: u32, to: u32, counters: &Counters) {
        let ranges = ranges_with(film, &self.settings, from, to);
        self.add(film, &Pick::Range(from, to), counters);
        film.ranges = ranges;
    }

    /// Adds the samples of a pick to the film's sums, and leaves it to the caller to say which those are.
    pub(crate) fn add(&self, film: &mut Film, pick: &Pick<'_>, counters: &Counters) {
        let (w, h) = (film.width, film.height);
        let across = w.div_ceil(TILE);
        let shared = Mutex::new(&mut *film);
        (0..across * h.div_ceil(TILE)).into_par_iter().for_each(|tile| {
            let (x0, y0) = (tile % across * TILE, tile / across * TILE);
            let size = [TILE.min(w - x0), TILE.min(h - y0)];
            let part = run_wide(TileWork { renderer: self, at: [x0, y0], size, pick });
            counters.closest_rays.fetch_add(part.rays[0], Ordering::Relaxed);
            counters.any_rays.fetch_add(part.rays[1], Ordering::Relaxed);
            counters.samples.fetch_add(part.samples, Ordering::Relaxed);
            // A thread that panicked has left whole tiles only; the panic itself is passed on by the pool.
            let mut film = shared.lock().unwrap_or_else(|e| e.into_inner());
            part.add_to(&mut film, [x0, y0], size);
        });
    }

    #[inline(always)]
    fn tile<const LAYERS: bool, const WHOLE: bool>(
        &self,
        at: [u32; 2],
        size: [u32; 2],
        pick: &Pick<'_>,
    ) -> Tile {
        let passes = self.settings.passes;
        let stride = Film::stride_of(passes);
        let pixels = (size[0] * size[1]) as usize;
        let mut t = Tile { sums: vec![Fixed::default(); pixels * stride], ..Tile::default() };
        for (kind, pass) in [Pass::ObjectId, Pass::MaterialId].into_iter().enumerate() {
            if passes.has(pass) {
                t.ids[kind] = vec![Coverage::new(); pixels];
            }
        }
        for (i, sums) in t.sums.chunks_exact_mut(stride).enumerate() {
            let (x, y) = (at[0] + i as u32 % size[0], at[1] + i as u32 / size[0]);
            let (from, to) = pick.of(x, y);
            t.samples += u64::from(to - from);
            let mut beauty = [Running::default(); BEAUTY_PLANES];
            let mut layers = Layers::default();
            for index in from..to {
                if LAYERS {
                    layers = Layers::default();
                }
                if (index - from) % Running::TERMS == Running::TERMS - 1 {
                    flush(&mut beauty, sums);
                }
                let mut s = self.path::<LAYERS, WHOLE>(x, y, index, &mut layers);
                t.rays[0] += u64::from(s.rays[0]);
                t.rays[1] += u64::from(s.rays[1]);
                if !s.radiance.is_finite() {
                    t.rejected += 1;
                    s.radiance = Spectrum::ZERO;
                }
                let l = s.radiance.luminance();
                let [r, g, b, _] = s.radiance.0;
                for (sum, v) in beauty.iter_mut().zip([r, g, b, s.alpha, l * l]) {
                    sum.add(v);
                }
                if LAYERS {
                    add_layers(&mut sums[BEAUTY_PLANES..], passes, &layers);
                    if let Some((instance, material)) = layers.seen {
                        for (kind, index) in [instance, material].into_iter().enumerate() {
                            if let Some(c) = t.ids[kind].get_mut(i) {
                                *c.entry(self.hashes[kind][index as usize]).or_default() += 1;
                            }
                        }
                    }
                }
            }
            flush(&mut beauty, sums);
        }
        t
    }
}

fn flush(beauty: &mut [Running], sums: &mut [Fixed]) {
    for (sum, part) in sums.iter_mut().zip(beauty) {
        sum.add(part.take());
    }
}

fn add_layers(sums: &mut [Fixed], passes: PassSet, l: &Layers) {
    let mut at = sums.iter_mut();
    let mut put = |values: &[f32]| {
        for (v, sum) in values.iter().zip(at.by_ref()) {
            sum.add(Fixed::from_f32(if v.is_finite() { *v } else { 0.0 }));
        }
    };
    for pass in passes.iter() {
        match pass {
            Pass::Albedo => put(&l.albedo.to_rgb()),
            Pass::Normal => put(&Vec3A::to_array(&l.normal)),
            Pass::Position => put(&Vec3A::to_array(&l.position)),
            Pass::Depth => put(&[l.depth]),
            Pass::Uv => put(&l.uv.to_array()),
            Pass::Direct => put(&l.direct.to_rgb()),
            Pass::Indirect => put(&l.indirect.to_rgb()),
            Pass::Diffuse => put(&l.diffuse.to_rgb()),
            Pass::Specular => put(&l.specular.to_rgb()),
            Pass::Emission => put(&l.emission.to_rgb()),
            Pass::Environment => put(&l.environment.to_rgb()),
            Pass::LightDiffuse => put(&l.sources[Source::Light as usize][0].to_rgb()),
            Pass::LightSpecular => put(&l.sources[Source::Light as usize][1].to_rgb()),
            Pass::SkyDiffuse => put(&l.sources[Source::Sky as usize][0].to_rgb()),
            Pass::SkySpecular => put(&l.sources[Source::Sky as usize][1].to_rgb()),
            Pass::BounceDiffuse => put(&l.sources[Source::Surface as usize][0].to_rgb()),
            Pass::BounceSpecular => put(&l.sources[Source::Surface as usize][1].to_rgb()),
            Pass::Transmission => put(&l.transmission.to_rgb()),
            Pass::ObjectId | Pass::MaterialId => {}
        }
    }
}

/// The samples that a film holds when it has `from..to`, too.
///
/// # Panics
/// If it is of another picture or has one of them.
pub(crate) fn ranges_with(film: &Film, settings: &Settings, from: u32, to: u32) -> crate::SampleRanges {
    let of = |w, h, passes| (w, h, passes);
    assert_eq!(
        of(film.width, film.height, film.passes),
        of(settings.width, settings.height, settings.passes)
    );
    let ranges = film.ranges.union(&crate::SampleRanges::new([(from, to)]).expect("one range"));
    ranges.expect("the film holds none of these samples")
}

/// Which samples of each pixel are to be taken.
pub(crate) enum Pick<'a> {
    /// From the first to before the second, of every pixel.
    Range(u32, u32),
    /// Of those, the one that the pixel takes in a part of the time.
    /// `classes` are those of the pixels, row by row.
    Part { block: &'a Block, part: u32, from: u32, to: u32, classes: &'a [u16], width: u32 },
}

impl Pick<'_> {
    fn of(&self, x: u32, y: u32) -> (u32, u32) {
        match *self {
            Self::Range(from, to) => (from, to),
            Self::Part { block, part, from, to, classes, width } => {
                let class = classes[y as usize * width as usize + x as usize];
                let i = block.sample(part, u32::from(class));
                if from <= i && i < to { (i, i + 1) } else { (i, i) }
            }
        }
    }
}

/// A square of pixels to be sampled.
struct TileWork<'a> {
    renderer: &'a Renderer<'a>,
    at: [u32; 2],
    size: [u32; 2],
    pick: &'a Pick<'a>,
}

impl Work for TileWork<'_> {
    type Output = Tile;
    #[inline(always)]
    fn run(self) -> Tile {
        let Self { renderer, at, size, pick } = self;
        // Each form costs seconds of compilation: where speed matters less, one does for all scenes.
        let layers = !renderer.settings.passes.is_empty() || renderer.settings.path.light_only;
        match (layers, renderer.whole) {
            (true, _) => renderer.tile::<true, true>(at, size, pick),
            (false, true) => renderer.tile::<false, true>(at, size, pick),
            (false, false) => renderer.tile::<false, false>(at, size, pick),
        }
    }
}

/// Sums over a square of pixels, by one thread.
#[derive(Default)]
struct Tile {
    sums: Vec<Fixed>,
    ids: [Vec<Coverage>; 2],
    rays: [u64; 2],
    samples: u64,
    rejected: u64,
}

impl Tile {
    fn add_to(&self, film: &mut Film, at: [u32; 2], size: [u32; 2]) {
        let stride = film.stride();
        let row = size[0] as usize * stride;
        film.rejected += self.rejected;
        for y in 0..size[1] {
            let first = (at[1] + y) as usize * film.width as usize + at[0] as usize;
            let target = &mut film.sums[first * stride..][..row];
            for (a, b) in target.iter_mut().zip(&self.sums[y as usize * row..][..row]) {
                a.add(*b);
            }
            for (all, part) in film.ids.iter_mut().zip(&self.ids) {
                let source = part.iter().skip((y * size[0]) as usize).take(size[0] as usize);
                for (a, b) in all.iter_mut().skip(first).zip(source) {
                    for (id, n) in b {
                        *a.entry(*id).or_default() += n;
                    }
                }
            }
        }
    }
}
