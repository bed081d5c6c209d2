//! What is rendered: the picture of a moment, or of the time that the shutter is open.

use super::CliError;
use super::sequence::Clock;
use super::stage::Stage;
use crate::render::{Counters, Film, Moment, MovingRenderer, Renderer, Series, Settings, Shutter, World};
use std::time::Duration;

/// Says what there is to see at a time.
type Moments<'a> = Box<dyn Fn(f64) -> Result<Moment, CliError> + 'a>;

/// Takes the samples of one picture.
pub(crate) enum Shot<'a> {
    Still(Box<Renderer<'a>>, &'a World),
    Moving(Box<MovingRenderer<'a, Moments<'a>>>),
}

impl<'a> Shot<'a> {
    /// What `stage` shows while the shutter is open for `seconds` around `clock`'s time; its worlds go on from those of the `series`.
    pub fn moving(
        stage: &'a Stage<'_>,
        clock: Clock,
        seconds: f64,
        settings: Settings,
        series: &'a mut Series,
    ) -> Result<Self, CliError> {
        let middle = clock.at.unwrap_or(0.0);
        let at: Moments<'a> = Box::new(move |t| Ok(stage.moment(&clock.later(t - middle))?.0));
        let digest = stage.digest(&clock)?;
        let shutter = Shutter { moments: stage.moments(), ..Shutter::around(middle, seconds) };
        let renderer = MovingRenderer::new(at, shutter, settings, digest, series)?;
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

    /// How many samples it takes to have one at each moment, and how long worlds of moments took so far.
    pub fn moments(&self) -> Option<(u32, Duration)> {
        match self {
            Self::Still(..) => None,
            Self::Moving(r) => Some((r.block(), r.preparing())),
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
