//! Files into a scene with a sky and a camera.

use super::args::RenderArgs;
use super::limit_args::LimitArgs;
use super::loading::Loading;
use super::material::{Replacement, compensate};
use super::{CliError, lamp, note_line};
use crate::builtin;
use crate::image::{SkyLayout, read_environment_as};
use crate::import::scene_file::is_scene_file;
use crate::import::{AnimationChoice, ImportOptions, Imported, import};
use crate::scene::{Bounds, Camera, Environment, Projection, Scene};
use glam::Vec3;
use std::path::Path;
use std::sync::Arc;

/// Starts as many threads as the arguments say.
pub(crate) fn start_threads(args: &RenderArgs) -> Result<(), CliError> {
    let Some(n) = args.threads else { return Ok(()) };
    rayon::ThreadPoolBuilder::new()
        .num_threads(n as usize)
        .build_global()
        .map_err(|e| CliError::Other(format!("cannot start {n} threads: {e}")))
}

/// How the model of the arguments is to be imported.
pub(crate) fn options(args: &RenderArgs) -> ImportOptions {
    let animation = match args.motion.animation.as_deref() {
        None => AnimationChoice::First,
        Some("all") => AnimationChoice::All,
        Some(a) => a.parse().map_or_else(|_| AnimationChoice::Name(a.into()), AnimationChoice::Index),
    };
    ImportOptions { at: args.at, animation, ..args.limits.options() }
}

/// The model under its sky, with the materials that the arguments ask for; and the warnings, which are printed unless nothing is to
/// be.
pub(crate) fn scene(args: &RenderArgs) -> Result<(Scene, Vec<String>), CliError> {
    let loading = Loading::new(!args.quiet && !args.json);
    let options = ImportOptions { progress: Some(loading.progress()), ..options(args) };
    let imported = read(args.model.as_deref(), &options, args.variant.as_deref())?;
    drop(loading);
    let (environment, notes) = match own_sky(&imported.scene.environment, args) {
        Some(sky) => (sky, Vec::new()),
        None => environment(args)?,
    };
    let warnings: Vec<String> = imported.warnings.iter().map(ToString::to_string).chain(notes).collect();
    if !args.quiet {
        warnings.iter().for_each(|w| note_line(&format!("warning: {w}")));
    }
    Ok((dress(imported.scene, environment, args)?, warnings))
}

/// The sky that a model brings along, turned and multiplied as the arguments say; `None` if it brings none, or they name another.
pub(crate) fn own_sky(sky: &Environment, args: &RenderArgs) -> Option<Environment> {
    match sky {
        Environment::LatLong { image, rotation, intensity } if args.sky.env.is_none() => {
            Some(Environment::LatLong {
                image: image.clone(),
                rotation: rotation + args.sky.env_rotation.to_radians(),
                intensity: intensity * args.sky.env_intensity,
            })
        }
        _ => None,
    }
}

/// The scene of a model under a sky, with the materials that the arguments ask for.
pub(crate) fn dress(
    mut scene: Scene,
    environment: Environment,
    args: &RenderArgs,
) -> Result<Scene, CliError> {
    scene.environment = environment;
    for note in lamp::add(&mut scene, &args.sky.light)? {
        if !args.quiet {
            note_line(&format!("warning: {note}"));
        }
    }
    if let Some(name) = &args.variant {
        scene.select_variant(name).map_err(CliError::Usage)?;
    }
    if let Some(way) = &args.compensation {
        compensate(&mut scene, way);
    }
    for text in &args.material {
        text.parse::<Replacement>()?.apply(&mut scene)?;
    }
    Ok(scene)
}

/// The model that the arguments name, for those who write it again: with the files of its pictures.
pub(crate) fn model_with_files(
    path: Option<&Path>,
    at: Option<f32>,
    limits: &LimitArgs,
) -> Result<Imported, CliError> {
    read(path, &ImportOptions { at, image_files: true, ..limits.options() }, None)
}

/// A model, or what a scene file makes of several; `variant` goes before those that it names.
pub(crate) fn read(
    path: Option<&Path>,
    options: &ImportOptions,
    variant: Option<&str>,
) -> Result<Imported, CliError> {
    Ok(match path {
        Some(p) if is_scene_file(p) => super::scene_file::load(p, options, variant)?,
        Some(p) => import(p, options)?,
        None => builtin::import_helmet(options)?,
    })
}

/// The sky that the arguments name, and what was done to it beyond reading it.
pub(crate) fn environment(args: &RenderArgs) -> Result<(Environment, Vec<String>), CliError> {
    let s = &args.sky;
    sky_as(s.env.as_deref().unwrap_or("studio"), s.env_layout, s.env_rotation, s.env_intensity)
}

/// As [`sky_as`], whatever the layout of a file.
pub(crate) fn sky(sky: &str, degrees: f32, intensity: f32) -> Result<(Environment, Vec<String>), CliError> {
    sky_as(sky, None, degrees, intensity)
}

/// A sky by file (of a `layout`, if that is said), name or colour, turned by `degrees` and multiplied; and what was done to it
/// beyond reading it.
pub(crate) fn sky_as(
    sky: &str,
    layout: Option<SkyLayout>,
    degrees: f32,
    intensity: f32,
) -> Result<(Environment, Vec<String>), CliError> {
    let rotation = degrees.to_radians();
    let constant = |c: [f32; 3]| (Environment::Constant(Vec3::from(c) * intensity), Vec::new());
    if sky == "none" {
        return Ok(constant([0.0; 3]));
    }
    if let Ok(c) = super::values::vec3(sky) {
        if c.0.iter().any(|v| *v < 0.0) {
            return Err(CliError::Usage(format!("the sky's colour {sky} is negative")));
        }
        return Ok(constant(c.0));
    }
    let path = Path::new(sky);
    if sky == "studio" && !path.exists() {
        return Ok((builtin::studio(rotation, intensity)?, Vec::new()));
    }
    if let Err(source) = std::fs::metadata(path) {
        return Err(CliError::Sky { path: path.to_path_buf(), source });
    }
    let e = read_environment_as(path, layout)?;
    let image = Arc::new(e.image);
    let notes = e.notes.iter().map(|n| format!("{sky}: {n}")).collect();
    Ok((Environment::LatLong { image, rotation, intensity }, notes))
}

/// Default vertical field of view, degrees.
const VFOV: f32 = 35.0;

/// Vertical field of view of cameras that are not the file's, radians.
pub(crate) fn vfov(args: &RenderArgs) -> f32 {
    args.vfov.unwrap_or(VFOV).to_radians()
}

/// Picture size and camera.
pub(crate) fn camera(args: &RenderArgs, scene: &Scene) -> Result<(Camera, (u32, u32)), CliError> {
    camera_of(args, &scene.cameras, |aspect, vfov| Ok((scene.bounds(), Camera::framing(scene, aspect, vfov))))
}

/// As [`camera`], for who knows the box around the model and the camera that frames it, of a picture's aspect and field of view.
pub(crate) fn camera_of(
    args: &RenderArgs,
    cameras: &[Camera],
    whole: impl Fn(f32, f32) -> Result<(Bounds, Camera), CliError>,
) -> Result<(Camera, (u32, u32)), CliError> {
    let mut camera = match &args.camera {
        Some(which) => Some(file_camera(which, cameras)?),
        None => None,
    };
    let aspect = camera.as_ref().and_then(|c| c.aspect).filter(|a| a.is_finite() && *a > 0.0);
    let size = args.size.unwrap_or_else(|| match aspect {
        // A file may ask for any shape; a thread is no picture.
        Some(a) => (((512.0 * a.clamp(0.1, 10.0)).round() as u32), 512),
        None => (512, 512),
    });
    if let (Some(c), Some(v)) = (&mut camera, args.vfov) {
        match &mut c.projection {
            Projection::Perspective { yfov } => *yfov = v.to_radians(),
            Projection::Orthographic { .. } => {
                return Err(CliError::Usage("--vfov does not apply to an orthographic camera".into()));
            }
        }
    }
    if let Some(c) = camera {
        return Ok((c, size));
    }
    let vfov = vfov(args);
    let aspect = size.0 as f32 / size.1 as f32;
    let camera = match args.eye {
        None => whole(aspect, vfov)?.1,
        Some(eye) => {
            let target = match args.target {
                Some(t) => Vec3::from(t.0),
                None => {
                    let (bounds, _) = whole(aspect, vfov)?;
                    if bounds.is_empty() { Vec3::ZERO } else { bounds.center().into() }
                }
            };
            let eye = Vec3::from(eye.0);
            let Some(view) = (target - eye).try_normalize() else {
                return Err(CliError::Usage("--eye and --target are the same point".into()));
            };
            let along = |up: Vec3| up.normalize_or_zero().cross(view).length() < 1e-4;
            let up = match args.up {
                Some(u) if along(Vec3::from(u.0)) => {
                    return Err(CliError::Usage("--up points along the view, or nowhere".into()));
                }
                Some(u) => Vec3::from(u.0),
                // Straight down or up: as on a map, away from the viewer is up.
                None if along(Vec3::Y) => Vec3::NEG_Z,
                None => Vec3::Y,
            };
            Camera::look_at(eye, target, up, vfov)
        }
    };
    Ok((camera, size))
}

fn file_camera(which: &str, cameras: &[Camera]) -> Result<Camera, CliError> {
    let by_number = which.parse::<usize>().ok().and_then(|n| cameras.get(n));
    if let Some(c) = by_number.or_else(|| cameras.iter().find(|c| c.name == which)) {
        return Ok(c.clone());
    }
    let name = |c: &Camera| if c.name.is_empty() { String::new() } else { format!(" ({})", c.name) };
    let list: Vec<_> = cameras.iter().enumerate().map(|(i, c)| format!("{i}{}", name(c))).collect();
    Err(CliError::Usage(if list.is_empty() {
        format!(
            "there is no camera {which}: the file has none; use --eye and --target, or neither to frame the model"
        )
    } else {
        format!("there is no camera {which}; the file has {}", list.join(", "))
    }))
}
