//! What can be said about time: frames, animations, the shutter.

use super::values::positive;
use crate::render::Shutter;
use clap::Args;
use serde::{Deserialize, Serialize};
use std::str::FromStr;

/// Frames per second where nothing else is said: the cinema's.
pub(crate) const FPS: f32 = 24.0;

#[derive(Clone, Debug, Args, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct MotionArgs {
    /// Render these frames of the animation, the last one included (as Blender counts them), or one; frame N is N / fps seconds into it. #### in --output is the frame's number with as many digits. Frames that are there with the same settings are not rendered again
    #[arg(long, value_name = "A..B", conflicts_with = "at", help_heading = "Animation")]
    pub frames: Option<FrameRange>,
    /// Frames per second [default: 24]
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = positive, help_heading = "Animation")]
    pub fps: Option<f32>,
    /// Which of the model's animations plays: by number (from 0), by name, or `all` at once [default: the first]
    #[arg(long, value_name = "N|NAME", help_heading = "Animation")]
    pub animation: Option<String>,
    /// Move the camera once round the model in N frames, counter-clockwise from above; with --frames it is one of these, and the animation plays
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000), help_heading = "Animation")]
    pub turntable: Option<u32>,
    /// Motion blur: how long the shutter is open around each frame's time (or --at), as an angle of the time between frames or in seconds: 180deg, 1/50s, 0.02s, or none
    #[arg(long, value_name = "TIME", default_value_t, help_heading = "Animation")]
    pub shutter: Opening,
    /// Motion blur: at how many moments the shutter's time is seen, however few samples there are; each sample of a pixel is at one of them. A power of two. 1 shows the whole picture of a sample at one moment
    #[arg(long, value_name = "N", default_value_t = Shutter::MOMENTS, value_parser = moments, help_heading = "Animation")]
    pub moments: u32,
    /// Render frames again that are there with the same settings
    #[arg(long, help_heading = "Animation")]
    pub overwrite: bool,
    /// The only frame of a turntable that a film is of.
    #[arg(skip)]
    pub turn_frame: Option<u32>,
}

impl Default for MotionArgs {
    fn default() -> Self {
        Self {
            frames: None,
            fps: None,
            animation: None,
            turntable: None,
            shutter: Opening::None,
            moments: Shutter::MOMENTS,
            overwrite: false,
            turn_frame: None,
        }
    }
}

fn moments(s: &str) -> Result<u32, String> {
    let most = Shutter::MOST_MOMENTS;
    let n = s.parse().ok().filter(|n: &u32| n.is_power_of_two() && *n <= most);
    n.ok_or_else(|| format!("give a power of two from 1 to {most}"))
}

impl MotionArgs {
    /// True if more than a single picture may be meant.
    pub fn is_sequence(&self) -> bool {
        self.frames.is_some() || self.turntable.is_some()
    }

    /// Frames per second.
    pub fn rate(&self) -> f64 {
        f64::from(self.fps.unwrap_or(FPS))
    }

    /// How long the shutter is open, seconds; `None` takes pictures of a moment.
    pub fn open_for(&self) -> Option<f64> {
        match self.shutter {
            Opening::None => None,
            Opening::Seconds(s) => Some(s),
            Opening::Angle(degrees) => Some(degrees / 360.0 / self.rate()),
        }
    }
}

/// Numbers of frames, the last included.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub(crate) struct FrameRange {
    pub first: u32,
    pub last: u32,
}

/// More would not have names that sort.
const MOST_FRAMES: u32 = 99_999_999;

impl FromStr for FrameRange {
    type Err = String;
    fn from_str(s: &str) -> Result<Self, String> {
        let number = |s: &str| s.trim().parse().ok().filter(|n| *n <= MOST_FRAMES);
        let both = match s.split_once("..") {
            Some((a, b)) => number(a).zip(number(b.strip_prefix('=').unwrap_or(b))),
            None => number(s).map(|n| (n, n)),
        };
        both.filter(|(a, b)| a <= b)
            .map(|(first, last)| Self { first, last })
            .ok_or_else(|| "give the first frame and the last, as in 0..47, or one frame".into())
    }
}

impl std::fmt::Display for FrameRange {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.first == self.last { self.first.fmt(f) } else { write!(f, "{}..{}", self.first, self.last) }
    }
}

/// How long the shutter is open.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub(crate) enum Opening {
    /// It is not: the picture is of a moment.
    #[default]
    None,
    /// Degrees of a rotary shutter's turn, which lasts as long as a frame.
    Angle(f64),
    Seconds(f64),
}

impl FromStr for Opening {
    type Err = String;
    fn from_str(s: &str) -> Result<Self, String> {
        let fail = || "give an angle, as in 180deg, a time, as in 1/50s or 0.02s, or none".to_owned();
        if s == "none" {
            return Ok(Self::None);
        }
        let number = |s: &str| s.trim().parse::<f64>().ok().filter(|v| v.is_finite() && *v > 0.0);
        let (digits, angle, scale) = if let Some(d) = s.strip_suffix("deg").or(s.strip_suffix('°')) {
            (d, true, 1.0)
        } else if let Some(d) = s.strip_suffix("ms") {
            (d, false, 1e-3)
        } else {
            (s.strip_suffix('s').ok_or_else(fail)?, false, 1.0)
        };
        let value = match digits.split_once('/') {
            Some((a, b)) => number(a).zip(number(b)).map(|(a, b)| a / b),
            None => number(digits),
        };
        let value = value.map(|v| v * scale).filter(|v| v.is_finite() && *v > 0.0).ok_or_else(fail)?;
        Ok(if angle { Self::Angle(value) } else { Self::Seconds(value) })
    }
}

impl std::fmt::Display for Opening {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::None => f.write_str("none"),
            Self::Angle(d) => write!(f, "{d}deg"),
            Self::Seconds(s) => write!(f, "{s}s"),
        }
    }
}

macro_rules! as_text {
    ($($t:ty)*) => { $(
        impl TryFrom<String> for $t {
            type Error = String;
            fn try_from(s: String) -> Result<Self, String> { s.parse() }
        }
        impl From<$t> for String {
            fn from(v: $t) -> String { v.to_string() }
        }
    )* };
}
as_text!(FrameRange Opening);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_include_the_last() {
        assert_eq!("0..47".parse(), Ok(FrameRange { first: 0, last: 47 }));
        assert_eq!("3..=4".parse(), Ok(FrameRange { first: 3, last: 4 }));
        assert_eq!("7".parse(), Ok(FrameRange { first: 7, last: 7 }));
        assert!(
            ["4..3", "-1..3", "a", "..", "1..", "123456789"].iter().all(|s| s.parse::<FrameRange>().is_err())
        );
        assert_eq!(
            FrameRange { first: 0, last: 47 }.to_string().parse(),
            Ok(FrameRange { first: 0, last: 47 })
        );
    }

    #[test]
    fn shutters_are_angles_or_times() {
        assert_eq!("180deg".parse(), Ok(Opening::Angle(180.0)));
        assert_eq!("1/50s".parse(), Ok(Opening::Seconds(0.02)));
        assert_eq!("20ms".parse(), Ok(Opening::Seconds(0.02)));
        assert_eq!("none".parse(), Ok(Opening::None));
        assert!(["180", "0s", "-1s", "1/0s", "deg", "nans"].iter().all(|s| s.parse::<Opening>().is_err()));
        let args = |s: &str, fps| MotionArgs { shutter: s.parse().unwrap(), fps, ..MotionArgs::default() };
        assert_eq!(args("180deg", None).open_for(), Some(1.0 / 48.0));
        assert_eq!(args("180deg", Some(50.0)).open_for(), Some(0.01));
        assert_eq!(args("0.25s", Some(50.0)).open_for(), Some(0.25));
        assert_eq!((args("none", None).open_for(), MotionArgs::default().open_for()), (None, None));
    }
}
