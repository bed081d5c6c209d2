//! Motion blur: the picture of a scene that changes while the shutter is open.
//!
//! The picture is the mean over the shutter's time of the pictures of its moments. Each sample is taken at a moment that
//! [`Shutter::time`] says; for each moment there is a world, in which whatever moves, however it moves, is where it is at that
//! time: surfaces by their transforms, skins and morph targets, lights, the camera, the values of materials. Nothing is
//! interpolated, and a picture of one moment knows nothing of time and pays nothing for it. A world is made of that of the moment
//! before ([`World::again`]), and costs what has changed. Moments are stratified, for each pixel and among neighbours; see
//! `moments.rs`. (Haeberli, Akeley 1990, "The Accumulation Buffer", section 4.3, where all pixels of a sample share a moment.)
//!
//! A sample remains a pure function of (seed, pixel, index), so that parts merge and interrupted runs go on to the bit.

use crate::fingerprint::Checksums;
use crate::moments::Block;
use crate::renderer::{Pick, ranges_with};
use crate::{Counters, Film, Renderer, Settings, Shutter, World};
use etendue_scene::{Camera, InvalidScene, Scene};
use std::time::{Duration, Instant};

/// Worlds of one scene at several moments, each made of what is still good of the last.
#[derive(Default)]
pub struct Series {
    world: Option<World>,
    checksums: Checksums,
}

impl Series {
    /// Makes the world of `scene`: that of [`World::new`], and faster where it shares meshes and images (the same
    /// [`std::sync::Arc`]) with the last one.
    ///
    /// # Errors
    /// What [`Scene::validate`] finds.
    pub fn world(&mut self, scene: Scene) -> Result<&World, InvalidScene> {
        let world = World::build(scene, self.world.take(), &mut self.checksums)?;
        Ok(self.world.insert(world))
    }

    /// The world that was made last.
    pub fn last(&self) -> Option<&World> {
        self.world.as_ref()
    }

    /// As [`crate::picture_id`], without reading again what is known of an earlier scene.
    pub fn picture_id(&mut self, scene: &Scene, camera: &Camera, settings: &Settings) -> String {
        self.checksums.picture_id(scene, camera, settings)
    }
}

/// What there is to see at one time, and from where.
#[derive(Clone, Debug)]
pub struct Moment {
    /// The world.
    pub scene: Scene,
    /// The eye.
    pub camera: Camera,
}

/// Renders samples of one picture of a scene that moves. `M` says what there is to see at a time in seconds.
///
/// ```
/// use etendue_render::{Moment, MovingRenderer, Series, Settings, Shutter};
/// use etendue_scene::{Camera, Environment, InvalidScene, Scene};
/// use glam::Vec3;
/// // A sky that brightens from 0 to 1 within a second.
/// let at = |t: f64| {
///     let scene = Scene { environment: Environment::Constant(Vec3::splat(t as f32)), ..Scene::default() };
///     Ok::<_, InvalidScene>(Moment { scene, camera: Camera::look_at(Vec3::Z, Vec3::ZERO, Vec3::Y, 1.0) })
/// };
/// let settings = Settings { width: 1, height: 1, ..Settings::default() };
/// let mut series = Series::default();
/// let mut renderer = MovingRenderer::new(at, Shutter::around(0.5, 1.0), settings, 0, &mut series)?;
/// let mut film = renderer.film();
/// renderer.render(&mut film, 0, 64, &Default::default())?;
/// assert!((film.mean(0, 0) - 0.5).abs() < 1.0 / 64.0);
/// # Ok::<(), InvalidScene>(())
/// ```
pub struct MovingRenderer<'s, M> {
    at: M,
    shutter: Shutter,
    settings: Settings,
    id: String,
    series: &'s mut Series,
    preparing: Duration,
    /// Of the pixels, row by row.
    classes: Vec<u16>,
}

impl<'s, M, E> MovingRenderer<'s, M>
where
    M: Fn(f64) -> Result<Moment, E>,
    E: From<InvalidScene>,
{
    /// A renderer of what `at` says while the shutter is open, whose worlds go on from the last of the `series`. `digest` names how
    /// things move: [`Self::picture_id`] depends on it, on the moments at which the shutter opens and closes, and on the shutter.
    ///
    /// # Errors
    /// What `at` returns.
    pub fn new(
        at: M,
        shutter: Shutter,
        settings: Settings,
        digest: u32,
        series: &'s mut Series,
    ) -> Result<Self, E> {
        let ends = [at(shutter.open)?, at(shutter.close)?];
        let id = series.checksums.moving_id(&ends, &shutter, &settings, digest);
        Ok(Self { at, shutter, settings, id, series, preparing: Duration::ZERO, classes: Vec::new() })
    }

    /// The settings that it was made with.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Names exactly this picture, as [`Renderer::picture_id`] does.
    pub fn picture_id(&self) -> String {
        self.id.clone()
    }

    /// An empty film of the right size and passes.
    pub fn film(&self) -> Film {
        Film::new(self.settings.width, self.settings.height, self.settings.passes)
    }

    /// The world of the moment that was rendered last.
    pub fn world(&self) -> Option<&World> {
        self.series.last()
    }

    /// How many samples share their moments: taken at once, as many as that need a world each, and fewer need as many.
    pub fn block(&self) -> u32 {
        self.shutter.block()
    }

    /// The time that the worlds of moments have taken so far.
    pub fn preparing(&self) -> Duration {
        self.preparing
    }

    /// Takes the samples `from..to` of every pixel and adds them to `film`.
    ///
    /// # Errors
    /// What the source of moments returns. The film then holds light of samples that it does not count, and is of no use.
    ///
    /// # Panics
    /// As [`Renderer::render`].
    pub fn render(&mut self, film: &mut Film, from: u32, to: u32, counters: &Counters) -> Result<(), E> {
        let ranges = ranges_with(film, &self.settings, from, to);
        let mut at = from;
        while at < to {
            let block = Block::new(&self.shutter, self.settings.seed, at);
            let end = to.min(block.first.saturating_add(block.size()));
            self.block_of(film, &block, at, end, counters)?;
            at = end;
        }
        film.ranges = ranges;
        Ok(())
    }

    /// The samples `from..to` of a block, in the order of time.
    fn block_of(
        &mut self,
        film: &mut Film,
        block: &Block,
        from: u32,
        to: u32,
        counters: &Counters,
    ) -> Result<(), E> {
        let Settings { width, height, seed, .. } = self.settings;
        if self.classes.is_empty() {
            let row = |y| (0..width).map(move |x| (x, y));
            let class = |(x, y)| self.shutter.class(seed, x, y) as u16;
            self.classes = (0..height).flat_map(row).map(class).collect();
        }
        // A small picture may not have pixels of all classes.
        let mut there = vec![false; block.size() as usize];
        self.classes.iter().for_each(|c| there[usize::from(*c)] = true);
        let classes: Vec<u32> = (0..block.size()).filter(|c| there[*c as usize]).collect();
        for part in 0..block.size() {
            if !classes.iter().any(|c| (from..to).contains(&block.sample(part, *c))) {
                continue;
            }
            let begun = Instant::now();
            let time = self.shutter.time_of(seed, block.sample_of(part));
            let Moment { scene, camera } = (self.at)(time)?;
            let world = self.series.world(scene)?;
            self.preparing += begun.elapsed();
            let pick = Pick::Part { block, part, from, to, classes: &self.classes, width };
            Renderer::new(world, camera, self.settings.clone()).add(film, &pick, counters);
        }
        Ok(())
    }
}
