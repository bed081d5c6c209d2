//! Lamps that the command line hangs up.

use super::CliError;
use super::values::{finite, vec3};
use crate::import::read_ies;
use crate::scene::{Light, LightKind, Scene, Web};
use glam::Vec3;
use std::path::Path;
use std::sync::Arc;

/// A lamp as `FILE@X,Y,Z[:toward=X,Y,Z][:scale=N]` says.
#[derive(Debug, PartialEq)]
struct Lamp<'a> {
    file: &'a str,
    at: Vec3,
    toward: Vec3,
    scale: f32,
}

fn parse(text: &str) -> Result<Lamp<'_>, String> {
    let how = "give a lamp as FILE@X,Y,Z[:toward=X,Y,Z][:scale=N], as in spot.ies@0,2.5,0:scale=0.1";
    // The name of a file may have any of these characters.
    let (file, rest) = text.rsplit_once('@').ok_or(how)?;
    let mut parts = rest.split(':');
    let at = Vec3::from(vec3(parts.next().unwrap_or_default())?.0);
    let mut lamp = Lamp { file, at, toward: at - Vec3::Y, scale: 1.0 };
    for p in parts {
        match p.split_once('=') {
            Some(("toward", v)) => lamp.toward = Vec3::from(vec3(v)?.0),
            Some(("scale", v)) => {
                lamp.scale = finite(v).ok().filter(|s| *s >= 0.0).ok_or("scale is a number of 0 or more")?;
            }
            _ => return Err(how.into()),
        }
    }
    if lamp.toward == lamp.at {
        return Err(format!("{text}: the lamp stands where it points to"));
    }
    Ok(lamp)
}

/// Adds the lamps of `texts` to the scene; returns what is to be said of their files.
pub(crate) fn add(scene: &mut Scene, texts: &[String]) -> Result<Vec<String>, CliError> {
    let mut notes = Vec::new();
    for text in texts {
        let lamp = parse(text).map_err(CliError::Usage)?;
        let file = read_ies(Path::new(lamp.file)).map_err(CliError::Other)?;
        notes.extend(file.notes.iter().map(|n| format!("{}: {n}", lamp.file)));
        let direction = (lamp.toward - lamp.at).normalize();
        // Headlights and floodlights stand upright; others are turned by what is to the right of the aim. Straight down it is +X.
        let right = direction.cross(Vec3::Y).try_normalize().unwrap_or(Vec3::X);
        let side = if file.profile.web() == Web::C { right } else { right.cross(direction) };
        scene.lights.push(Light {
            name: lamp.file.to_owned(),
            kind: LightKind::Profile { profile: scene.profiles.len() as u32, side },
            intensity: Vec3::splat(lamp.scale),
            position: lamp.at,
            direction,
            range: None,
        });
        scene.profiles.push(Arc::new(file.profile));
    }
    Ok(notes)
}

/// The same lamp with the whole path of its file.
pub(crate) fn absolute(text: &str) -> String {
    let whole = text
        .rsplit_once('@')
        .and_then(|(file, rest)| Some(format!("{}@{rest}", std::path::absolute(file).ok()?.display())));
    whole.unwrap_or_else(|| text.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lamps_are_parsed() {
        let lamp = parse("a@b:c.ies@1,2,-3:toward=0,0,0:scale=0.5").unwrap();
        assert_eq!(
            lamp,
            Lamp { file: "a@b:c.ies", at: Vec3::new(1.0, 2.0, -3.0), toward: Vec3::ZERO, scale: 0.5 }
        );
        assert_eq!(parse("a.ies@0,2,0").unwrap().toward, Vec3::Y);
        for bad in ["a.ies", "a@1,2", "a@1,2,3:scale=-1", "a@1,2,3:x=1", "a@1,2,3:toward=1,2,3"] {
            assert!(parse(bad).is_err(), "{bad}");
        }
        assert!(absolute("a.ies@0,2,0").ends_with("/a.ies@0,2,0"));
    }
}
