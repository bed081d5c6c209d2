//! Values on the command line: numbers, sizes, times, and how a film stores them.

use serde::{Deserialize, Serialize};
use std::time::Duration;

/// Three numbers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Vec3Arg(pub [f32; 3]);

fn numbers<const N: usize>(s: &str) -> Option<[f32; N]> {
    let v: Vec<f32> =
        s.split(',').map(|p| p.trim().parse().ok().filter(|v: &f32| v.is_finite())).collect::<Option<_>>()?;
    v.try_into().ok()
}

pub(crate) fn vec3(s: &str) -> Result<Vec3Arg, String> {
    numbers(s).map(Vec3Arg).ok_or_else(|| "give three numbers, as in 1.5,0,-2".into())
}

pub(crate) fn finite(s: &str) -> Result<f32, String> {
    s.parse().ok().filter(|v: &f32| v.is_finite()).ok_or_else(|| "give a number".into())
}

pub(crate) fn positive(s: &str) -> Result<f32, String> {
    finite(s).ok().filter(|v| *v > 0.0).ok_or_else(|| "give a number above 0".into())
}

pub(crate) fn non_negative(s: &str) -> Result<f32, String> {
    finite(s).ok().filter(|v| *v >= 0.0).ok_or_else(|| "give a number that is not negative".into())
}

pub(crate) fn field_of_view(s: &str) -> Result<f32, String> {
    finite(s).ok().filter(|v| *v > 0.0 && *v < 180.0).ok_or_else(|| "give degrees between 0 and 180".into())
}

pub(crate) fn bits(s: &str) -> Result<u8, String> {
    match s {
        "8" => Ok(8),
        "16" => Ok(16),
        "32" => Ok(32),
        _ => Err("give 8, 16 or 32".into()),
    }
}

pub(crate) fn size(s: &str) -> Result<(u32, u32), String> {
    let parse = |p: &str| p.trim().parse().ok().filter(|v| (1..=65536).contains(v));
    s.split_once(['x', 'X', '×'])
        .and_then(|(w, h)| Some((parse(w)?, parse(h)?)))
        .ok_or_else(|| "give width and height in pixels, as in 1280x720".into())
}

pub(crate) fn range(s: &str) -> Result<(u32, u32), String> {
    s.split_once("..")
        .and_then(|(a, b)| Some((a.parse().ok()?, b.parse().ok()?)))
        .filter(|(a, b)| a < b)
        .ok_or_else(|| "give the first sample and the one after the last, as in 0..64".into())
}

pub(crate) fn positive_duration(s: &str) -> Result<Duration, String> {
    duration(s).ok().filter(|d| !d.is_zero()).ok_or_else(|| "give a time above 0, as in 90s, 5m or 1h".into())
}

pub(crate) fn duration(s: &str) -> Result<Duration, String> {
    let unit = s.trim_start_matches(|c: char| c.is_ascii_digit() || c == '.');
    let scale = match unit {
        "s" | "" => 1.0,
        "ms" => 1e-3,
        "m" | "min" => 60.0,
        "h" => 3600.0,
        _ => return Err("give a time, as in 90s, 5m or 1h".into()),
    };
    let value: f64 = s[..s.len() - unit.len()].parse().map_err(|_| "give a time, as in 90s, 5m or 1h")?;
    Duration::try_from_secs_f64(value * scale).map_err(|e| e.to_string())
}

/// Values that are their own name.
pub(crate) mod text {
    use serde::{Deserialize, Deserializer, Serializer};
    pub fn serialize<T: std::fmt::Display, S: Serializer>(v: &T, s: S) -> Result<S::Ok, S::Error> {
        s.collect_str(v)
    }
    pub fn deserialize<'a, T: std::str::FromStr<Err: std::fmt::Display>, D: Deserializer<'a>>(
        d: D,
    ) -> Result<T, D::Error> {
        String::deserialize(d)?.parse().map_err(serde::de::Error::custom)
    }
}

/// Paths as text, so that one which is not Unicode does not spoil the film.
pub(crate) mod path {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};
    use std::path::PathBuf;
    pub fn serialize<S: Serializer>(v: &Option<PathBuf>, s: S) -> Result<S::Ok, S::Error> {
        v.as_ref().map(|p| p.to_string_lossy()).serialize(s)
    }
    pub fn deserialize<'a, D: Deserializer<'a>>(d: D) -> Result<Option<PathBuf>, D::Error> {
        Option::deserialize(d)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_parse() {
        assert_eq!(size("1280x720"), Ok((1280, 720)));
        assert!(size("0x4").is_err() && size("12").is_err() && size("1x99999").is_err());
        assert_eq!(vec3("1,-2.5, 3"), Ok(Vec3Arg([1.0, -2.5, 3.0])));
        assert!(vec3("1,2").is_err() && vec3("1,2,inf").is_err());
        assert_eq!(duration("1.5m"), Ok(Duration::from_secs(90)));
        assert!(duration("soon").is_err() && duration("").is_err());
        assert_eq!(range("3..9"), Ok((3, 9)));
        assert!(range("9..3").is_err());
    }
}
