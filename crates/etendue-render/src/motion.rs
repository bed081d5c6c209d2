//! Motion blur: the picture of a scene that changes while the shutter is open.
//!
//! The picture is the mean over the shutter's time of the pictures of its moments. Sample `i` of every pixel is taken at the
//! moment [`crate::moment`]`(seed, i)`: for each sample the world of its moment is made anew, so that whatever moves, however
//! it moves, is where it is at that time: surfaces by their transforms, skins and morph targets, lights, the camera, the
//! values of materials. Nothing is interpolated, and a picture of one moment knows nothing of time and pays nothing for it.
//! Moments are stratified: n samples per pixel see n moments, one in each n-th of the time where n is a power of two.
//! (Haeberli, Akeley 1990, "The Accumulation Buffer", section 4.3, with one sample per pixel and moment.)
//!
//! A sample remains a pure function of (seed, pixel, index), so that parts merge and interrupted runs go on to the bit.

use crate::{Counters, Film, Renderer, Settings, World};
use etendue_scene::{Camera, InvalidScene, Scene};

/// The time during which light falls on the film, seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shutter {
    /// When it opens.
    pub open: f64,
    /// When it closes; not before it opens.
    pub close: f64,
}

impl Shutter {
    /// Open for `seconds`, half of them before `middle`.
    pub fn around(middle: f64, seconds: f64) -> Self {
        Self { open: middle - 0.5 * seconds, close: middle + 0.5 * seconds }
    }

    /// When the sample `index` of a picture with this `seed` is taken.
    pub fn time(&self, seed: u32, index: u32) -> f64 {
        self.open + (self.close - self.open) * crate::moment(seed, index)
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
/// use etendue_render::{Moment, MovingRenderer, Settings, Shutter};
/// use etendue_scene::{Camera, Environment, InvalidScene, Scene};
/// use glam::Vec3;
/// // A sky that brightens from 0 to 1 within a second.
/// let at = |t: f64| {
///     let scene = Scene { environment: Environment::Constant(Vec3::splat(t as f32)), ..Scene::default() };
///     Ok::<_, InvalidScene>(Moment { scene, camera: Camera::look_at(Vec3::Z, Vec3::ZERO, Vec3::Y, 1.0) })
/// };
/// let settings = Settings { width: 1, height: 1, ..Settings::default() };
/// let mut renderer = MovingRenderer::new(at, Shutter { open: 0.0, close: 1.0 }, settings, 0)?;
/// let mut film = renderer.film();
/// renderer.render(&mut film, 0, 64, &Default::default())?;
/// assert!((film.mean(0, 0) - 0.5).abs() < 1.0 / 64.0);
/// # Ok::<(), InvalidScene>(())
/// ```
pub struct MovingRenderer<M> {
    at: M,
    shutter: Shutter,
    settings: Settings,
    id: String,
    /// Of the moment before.
    world: Option<World>,
}

impl<M, E> MovingRenderer<M>
where
    M: Fn(f64) -> Result<Moment, E>,
    E: From<InvalidScene>,
{
    /// A renderer of what `at` says while the shutter is open. `digest` names how things move: [`Self::picture_id`] depends on it,
    /// on the moments at which the shutter opens and closes, and on the shutter.
    ///
    /// # Errors
    /// What `at` returns.
    pub fn new(at: M, shutter: Shutter, settings: Settings, digest: u32) -> Result<Self, E> {
        let ends = [at(shutter.open)?, at(shutter.close)?];
        let id = crate::fingerprint::moving_id(&ends, &shutter, &settings, digest);
        Ok(Self { at, shutter, settings, id, world: None })
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
        self.world.as_ref()
    }

    /// Takes the samples `from..to` of every pixel and adds them to `film`.
    ///
    /// # Errors
    /// What the source of moments returns; the film then holds the samples before that moment.
    ///
    /// # Panics
    /// As [`Renderer::render`].
    pub fn render(&mut self, film: &mut Film, from: u32, to: u32, counters: &Counters) -> Result<(), E> {
        for index in from..to {
            let Moment { scene, camera } = (self.at)(self.shutter.time(self.settings.seed, index))?;
            let world = match self.world.take() {
                Some(before) => before.again(scene),
                None => World::new(scene),
            }?;
            Renderer::new(&world, camera, self.settings.clone()).render(film, index, index + 1, counters);
            self.world = Some(world);
        }
        Ok(())
    }
}
