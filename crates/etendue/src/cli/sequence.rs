//! The frames of an animation: their numbers, times and names, and which of them are done.

use super::CliError;
use super::args::RenderArgs;
use std::path::{Path, PathBuf};

/// When a picture is taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Clock {
    /// Seconds into the animation; `None` is at rest.
    pub at: Option<f64>,
    /// How far the camera has gone round the model, turns, and how fast it goes on, turns per second.
    pub turn: Option<[f64; 2]>,
}

impl Clock {
    /// That of a single picture.
    pub fn of(args: &RenderArgs) -> Self {
        Self { at: args.at.map(f64::from), turn: None }
    }

    /// That of frame `n`.
    pub fn of_frame(args: &RenderArgs, n: u32) -> Self {
        let rate = args.motion.rate();
        let turn = args.motion.turntable.map(|all| [f64::from(n) / f64::from(all), rate / f64::from(all)]);
        let at =
            if args.motion.frames.is_some() { Some(f64::from(n) / rate) } else { args.at.map(f64::from) };
        Self { at, turn }
    }

    /// `seconds` later. A model at rest stays there.
    pub fn later(&self, seconds: f64) -> Self {
        let turn = self.turn.map(|[turns, speed]| [turns + speed * seconds, speed]);
        Self { at: self.at.map(|t| t + seconds), turn }
    }
}

/// The numbers of the frames that the arguments ask for.
pub(crate) fn numbers(args: &RenderArgs) -> std::ops::RangeInclusive<u32> {
    let m = &args.motion;
    match (m.frames, m.turn_frame, m.turntable) {
        (Some(f), ..) => f.first..=f.last,
        (None, Some(n), _) => n..=n,
        (None, None, Some(n)) => 0..=n - 1,
        (None, None, None) => 0..=0,
    }
}

/// The name of frame `n`: the last row of # in the file's name becomes the number, with at least as many digits. `None` if there
/// is none.
pub(crate) fn frame_path(pattern: &Path, n: u32) -> Option<PathBuf> {
    let name = pattern.file_name()?.to_str()?;
    let end = name.rfind('#')? + 1;
    let begin = name[..end].trim_end_matches('#').len();
    Some(pattern.with_file_name(format!(
        "{}{n:0width$}{}",
        &name[..begin],
        &name[end..],
        width = end - begin
    )))
}

/// The paths of a pattern's frames, or an error that says how to name more than one.
pub(crate) fn frame_paths(option: &str, pattern: &Path, args: &RenderArgs) -> Result<Vec<PathBuf>, CliError> {
    let numbers = numbers(args);
    let one = numbers.start() == numbers.end();
    numbers
        .map(|n| match frame_path(pattern, n) {
            Some(path) => Ok(path),
            None if one => Ok(pattern.to_path_buf()),
            None => Err(CliError::Usage(format!(
                "{option} {} is one name for many frames: put #### where the frame's number is to be, as in {}",
                pattern.display(),
                with_number(pattern).display()
            ))),
        })
        .collect()
}

/// `walk.png` as `walk-####.png`.
pub(crate) fn with_number(path: &Path) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let extension = path.extension().map_or(String::new(), |e| format!(".{}", e.to_string_lossy()));
    path.with_file_name(format!("{stem}-####{extension}"))
}

/// Entry of a frame's metadata by which it is known again.
pub(crate) const SETTINGS: &str = "Settings";

/// Names all that a finished frame depends on, for its metadata.
pub(crate) fn settings_key(parts: &[&str]) -> String {
    let mut h = crc32fast::Hasher::new();
    parts.iter().for_each(|p| {
        h.update(p.as_bytes());
        h.update(&[0]);
    });
    let first = h.clone().finalize();
    h.update(b"etendue");
    // A word that is found in no other file, so that it may be looked for in any format.
    format!("etendue-frame-{first:08x}{:08x}", h.finalize())
}

/// True if the picture at `path` says of itself that it is finished and was made with the settings of that name. Pictures are
/// written in one go, so what says so is whole.
pub(crate) fn is_done(path: &Path, key: &str) -> bool {
    // Every format has its metadata as plain text.
    std::fs::read(path).is_ok_and(|bytes| contains(&bytes, key.as_bytes()))
}

fn contains(bytes: &[u8], word: &[u8]) -> bool {
    bytes.windows(word.len()).any(|w| w == word)
}

#[cfg(test)]
mod tests {
    use super::super::motion_args::{FrameRange, MotionArgs};
    use super::*;

    #[test]
    fn names_of_frames() {
        let of = |pattern: &str, n| frame_path(Path::new(pattern), n);
        assert_eq!(of("a/f-####.png", 7), Some("a/f-0007.png".into()));
        assert_eq!(of("#.png", 12345), Some("12345.png".into()));
        assert_eq!(of("shot#2-###.exr", 41), Some("shot#2-041.exr".into()));
        assert_eq!(of("##/plain.png", 1), None);
        let motion =
            |first, last| MotionArgs { frames: Some(FrameRange { first, last }), ..Default::default() };
        let args = |first, last| RenderArgs { motion: motion(first, last), ..RenderArgs::builtin() };
        let paths = |pattern: &str, a| frame_paths("--output", Path::new(pattern), &a);
        assert_eq!(paths("f##.png", args(9, 10)).ok(), Some(vec!["f09.png".into(), "f10.png".into()]));
        assert_eq!(paths("f.png", args(9, 9)).ok(), Some(vec!["f.png".into()]));
        assert!(paths("f.png", args(9, 10)).is_err_and(|e| e.to_string().contains("f-####.png")));
    }

    #[test]
    fn clocks() {
        let motion = MotionArgs {
            frames: Some(FrameRange { first: 0, last: 9 }),
            fps: Some(10.0),
            turntable: Some(40),
            ..Default::default()
        };
        let mut args = RenderArgs { motion, ..RenderArgs::builtin() };
        let c = Clock::of_frame(&args, 4);
        assert_eq!(c, Clock { at: Some(0.4), turn: Some([0.1, 0.25]) });
        assert_eq!(c.later(0.2).turn, Some([0.1 + 0.05, 0.25]));
        args.motion.frames = None;
        assert_eq!(Clock::of_frame(&args, 4).later(0.2).at, None, "a turntable alone moves the camera only");
        assert_eq!(numbers(&args), 0..=39);
    }

    #[test]
    fn frames_are_known_by_their_settings() {
        let (a, b) = (settings_key(&["x", "yz"]), settings_key(&["xy", "z"]));
        assert_ne!(a, b);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        assert!(!is_done(&path, &a));
        std::fs::write(&path, format!("...{a}...")).unwrap();
        assert!(is_done(&path, &a) && !is_done(&path, &b));
    }
}
