//! The model, its sky and its camera at any moment.

use super::args::RenderArgs;
use super::sequence::Clock;
use super::{CliError, load, note_line, scene_file};
use crate::builtin::HELMET_GLB;
use crate::import::scene_file::{MovingScene, SceneModels, is_scene_file};
use crate::import::{Imported, Model, ModelFile};
use crate::render::Moment;
use crate::scene::{Bounds, Camera, Environment, Scene};
use glam::{Affine3A, DAffine3, DQuat, DVec3, Vec3, Vec3A};
use std::cell::{OnceCell, RefCell};
use std::collections::BTreeSet;

/// Moments of the animation, and positions on the way round it, at which a model is looked at to find a camera that shows it at all
/// of them.
const LOOKS: u32 = 16;

/// The file that the arguments name.
pub(crate) enum File<'v> {
    Model(Box<ModelFile<'static>>),
    Scene(Box<SceneModels<'v>>),
}

/// Reads the file that the arguments name.
pub(crate) fn file(args: &RenderArgs) -> Result<File<'_>, CliError> {
    let options = load::options(args);
    Ok(match &args.model {
        Some(path) if is_scene_file(path) => {
            if args.motion.animation.is_some() {
                return Err(CliError::Usage(
                    "each model of a scene file has its own animation: say `animation` there".into(),
                ));
            }
            File::Scene(Box::new(scene_file::models(path, &options, args.variant.as_deref())?))
        }
        Some(path) => File::Model(Box::new(ModelFile::read(path, &options)?)),
        None => File::Model(Box::new(ModelFile::from_bytes(HELMET_GLB, "built-in helmet", &options))),
    })
}

/// What is shown at a moment.
enum Source<'a> {
    Model(Model<'a>),
    Scene(MovingScene<'a>),
}

/// What the arguments put before the camera.
pub(crate) struct Stage<'a> {
    args: &'a RenderArgs,
    source: Source<'a>,
    environment: Environment,
    /// The box around the model at all times, and the camera that shows it then.
    whole: OnceCell<(Bounds, Camera)>,
    warnings: RefCell<(BTreeSet<String>, Vec<String>)>,
}

impl<'a> Stage<'a> {
    /// Reads model and sky.
    pub fn new(file: &'a File<'a>, args: &'a RenderArgs) -> Result<Self, CliError> {
        let source = match file {
            File::Model(file) => Source::Model(file.open()?),
            File::Scene(models) => Source::Scene(models.open()),
        };
        let (environment, notes) = load::environment(args)?;
        let stage = Self { args, source, environment, whole: OnceCell::new(), warnings: RefCell::default() };
        notes.into_iter().for_each(|n| stage.warn(n));
        Ok(stage)
    }

    /// Prints a warning, unless it was printed for another moment.
    fn warn(&self, text: String) {
        let (told, list) = &mut *self.warnings.borrow_mut();
        if told.insert(text.clone()) {
            if !self.args.quiet {
                note_line(&format!("warning: {text}"));
            }
            list.push(text);
        }
    }

    /// What was warned of so far.
    pub fn warnings(&self) -> Vec<String> {
        self.warnings.borrow().1.clone()
    }

    /// At how many moments an open shutter sees it.
    pub fn moments(&self) -> u32 {
        self.args.motion.moments
    }

    /// Names how model and camera move.
    pub fn digest(&self, clock: &Clock) -> Result<u32, CliError> {
        let speed = clock.turn.map(|[_, speed]| speed);
        let chosen = format!("{:?}", (&self.args.motion.animation, &self.args.camera, speed));
        let file = match &self.source {
            Source::Model(m) => m.digest(),
            Source::Scene(s) => s.digest()?,
        };
        let mut h = crc32fast::Hasher::new_with_initial(file);
        h.update(chosen.as_bytes());
        Ok(h.finalize())
    }

    fn imported(&self, at: Option<f64>) -> Result<Imported, CliError> {
        match &self.source {
            Source::Model(m) => Ok(m.at(at)?),
            Source::Scene(s) => Ok(s.at(at)?),
        }
    }

    /// The scene `at` seconds, or at rest.
    pub fn scene(&self, at: Option<f64>) -> Result<Scene, CliError> {
        let imported = self.imported(at)?;
        imported.warnings.iter().for_each(|w| self.warn(w.to_string()));
        let sky = load::own_sky(&imported.scene.environment, self.args);
        load::dress(imported.scene, sky.unwrap_or_else(|| self.environment.clone()), self.args)
    }

    /// Scene and camera at a time, and the picture's size.
    pub fn moment(&self, clock: &Clock) -> Result<(Moment, (u32, u32)), CliError> {
        let scene = self.scene(clock.at)?;
        // A camera that follows the model's bounds would take the motion out of the picture.
        let (mut camera, size) = if self.args.camera.is_none() {
            load::camera_of(self.args, &scene.cameras, |aspect, vfov| self.whole(aspect, vfov))?
        } else {
            load::camera(self.args, &scene)?
        };
        if let Some([turns, _]) = clock.turn {
            let pivot = match self.args.target {
                Some(t) => Vec3::from(t.0),
                None => middle(&self.whole(size.0 as f32 / size.1 as f32, load::vfov(self.args))?.0).into(),
            };
            camera.transform = turn(&camera.transform, self.axis(), pivot.as_dvec3(), turns);
        }
        Ok((Moment { scene, camera }, size))
    }

    /// What a turntable turns about.
    fn axis(&self) -> DVec3 {
        let up = self.args.up.map_or(Vec3::Y, |u| Vec3::from(u.0));
        up.as_dvec3().try_normalize().unwrap_or(DVec3::Y)
    }

    /// The box around the model during the whole animation (or at rest, if it does not play), and the camera that shows all of
    /// it, on a turntable from all sides. Both are the same for every frame, and of a model for any part of the frames.
    fn whole(&self, aspect: f32, vfov: f32) -> Result<(Bounds, Camera), CliError> {
        if let Some(known) = self.whole.get() {
            return Ok(known.clone());
        }
        let times = match (self.args.motion.frames, &self.source) {
            (None, _) => None,
            (Some(_), Source::Model(m)) => m.duration()?,
            // Which of its models moves when is not known.
            (Some(f), Source::Scene(_)) => {
                let rate = self.args.motion.rate();
                Some(f64::from(f.first) / rate..=f64::from(f.last) / rate)
            }
        };
        let moments: Vec<Option<f64>> = match times {
            Some(d) => {
                let part = |k| f64::from(k) / f64::from(LOOKS - 1);
                (0..LOOKS).map(|k| Some(d.start() + (d.end() - d.start()) * part(k))).collect()
            }
            None => vec![self.args.at.map(f64::from)],
        };
        let mut points = Vec::new();
        let mut bounds = Bounds::EMPTY;
        for at in moments {
            let now = outline(&self.imported(at)?.scene);
            now.iter().for_each(|p| bounds.include(*p));
            points.push(now);
        }
        let pivot = self.args.target.map_or(middle(&bounds), |t| Vec3::from(t.0).into());
        let sides = if self.args.motion.turntable.is_some() { LOOKS } else { 1 };
        let turned = (0..sides).flat_map(|k| {
            let back =
                turn(&Affine3A::IDENTITY, self.axis(), pivot.as_dvec3(), -f64::from(k) / f64::from(sides));
            points.iter().flatten().map(move |p| back.transform_point3a(*p))
        });
        let camera = Camera::framing_points(turned, aspect, vfov);
        Ok(self.whole.get_or_init(|| (bounds, camera)).clone())
    }
}

/// The middle of a box; the origin if it holds nothing.
fn middle(bounds: &Bounds) -> Vec3A {
    if bounds.is_empty() { Vec3A::ZERO } else { bounds.center() }
}

/// The corners of all triangles, each vertex once.
fn outline(scene: &Scene) -> Vec<Vec3A> {
    let mut out = Vec::new();
    for i in &scene.instances {
        let mesh = &scene.meshes[i.mesh as usize];
        let mut used = vec![false; mesh.positions.len()];
        mesh.indices.iter().flatten().for_each(|&k| used[k as usize] = true);
        let corners = mesh.positions.iter().zip(used).filter(|(_, used)| *used);
        out.extend(corners.map(|(p, _)| i.transform.transform_point3a((*p).into())));
    }
    out
}

/// `transform`, `turns` further round the axis through `pivot`, counter-clockwise for who looks against it.
fn turn(transform: &Affine3A, axis: DVec3, pivot: DVec3, turns: f64) -> Affine3A {
    if turns == 0.0 {
        return *transform;
    }
    let rotation = DQuat::from_axis_angle(axis, turns.rem_euclid(1.0) * std::f64::consts::TAU);
    let m = DAffine3::from_translation(pivot)
        * DAffine3::from_quat(rotation)
        * DAffine3::from_translation(-pivot);
    let columns = [m.matrix3.x_axis, m.matrix3.y_axis, m.matrix3.z_axis, m.translation].map(|c| c.as_vec3a());
    Affine3A::from_cols(columns[0], columns[1], columns[2], columns[3]) * *transform
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A quarter of a turn takes what stands before the model to its right, and looks at the model as before.
    #[test]
    fn turntables_go_counter_clockwise() {
        let camera = Camera::look_at(Vec3::new(1.0, 0.0, 5.0), Vec3::new(1.0, 0.0, 0.0), Vec3::Y, 0.5);
        let t = turn(&camera.transform, DVec3::Y, DVec3::new(1.0, 0.0, 0.0), 0.25);
        assert!(t.translation.abs_diff_eq(Vec3A::new(6.0, 0.0, 0.0), 1e-5), "{t}");
        assert!((-t.matrix3.z_axis).abs_diff_eq(Vec3A::NEG_X, 1e-6) && t.matrix3.y_axis == Vec3A::Y);
        assert_eq!(turn(&camera.transform, DVec3::Y, DVec3::ZERO, 0.0), camera.transform);
    }
}
