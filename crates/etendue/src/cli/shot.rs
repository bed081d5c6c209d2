//! What is rendered: the picture of a moment, or of the time that the shutter is open.

use super::CliError;
use super::sequence::Clock;
use super::stage::Stage;
use crate::render::{Counters, Film, Moment, MovingRenderer, Renderer, Settings, Shutter, World};

/// Says what there is to see at a time.
type Moments<'a> = Box<dyn Fn(f64) -> Result<Moment, CliError> + 'a>;

/// Takes the samples of one picture.
pub(crate) enum Shot<'a> {
    Still(Box<Renderer<'a>>, &'a World),
    Moving(Box<MovingRenderer<Moments<'a>>>),
}

impl<'a> Shot<'a> {
    /// What `stage` shows while the shutter is open for `seconds` around `clock`'s time.
    pub fn moving(
        stage: &'a Stage<'a>,
        clock: Clock,
        seconds: f64,
        settings: Settings,
    ) -> Result<Self, CliError> {
        let middle = clock.at.unwrap_or(0.0);
        let at: Moments<'a> = Box::new(move |t| Ok(stage.moment(&clock.later(t - middle))?.0));
        let digest = stage.digest(&clock);
        let renderer = MovingRenderer::new(at, Shutter::around(middle, seconds), settings, digest)?;
        Ok(Self::Moving(Box::new(renderer)))
    }

    pub fn settings(&self) -> &Settings {
        match self {
            Self::Still(r, _) => r.settings(),
            Self::Moving(r) => r.settings(),
        }
    }

    pub fn picture_id(&self) -> String {
        match self {
            Self::Still(r, _) => r.picture_id(),
            Self::Moving(r) => r.picture_id(),
        }
    }

    pub fn film(&self) -> Film {
        match self {
            Self::Still(r, _) => r.film(),
            Self::Moving(r) => r.film(),
        }
    }

    pub fn render(
        &mut self,
        film: &mut Film,
        from: u32,
        to: u32,
        counters: &Counters,
    ) -> Result<(), CliError> {
        match self {
            Self::Still(r, _) => {
                r.render(film, from, to, counters);
                Ok(())
            }
            Self::Moving(r) => r.render(film, from, to, counters),
        }
    }

    /// The world, or that of the last moment.
    pub fn world(&self) -> Option<&World> {
        match self {
            Self::Still(_, w) => Some(w),
            Self::Moving(r) => r.world(),
        }
    }
}
