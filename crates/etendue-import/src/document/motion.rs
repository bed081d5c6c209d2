//! `skins` and `animations`.

use super::name;
use crate::error::Fault;
use crate::extensions as ext;
use crate::json::Reader;
use serde_json::Value;

/// Joints that carry vertices.
pub(crate) struct Skin {
    pub inverse_bind_matrices: Option<u32>,
    pub joints: Vec<u32>,
}

impl Skin {
    pub fn read<'v>(r: &mut Reader<'v>, v: &'v Value) -> Result<Self, Fault> {
        let o = r.object(v)?;
        // `skeleton` is a hint for tools; it changes nothing in the picture.
        Ok(Self {
            inverse_bind_matrices: r.opt(o, "inverseBindMatrices", Reader::index)?,
            joints: r.req(o, "joints", |r, v| r.array(v, Reader::index))?,
        })
    }
}

/// What a channel moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Path {
    Translation,
    Rotation,
    Scale,
    Weights,
}

/// How values between keyframes are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Interpolation {
    Step,
    Linear,
    CubicSpline,
}

/// One moved property: of a node, or what a JSON pointer leads to. `None` as node, path and pointer: nothing that is known here.
pub(crate) struct Channel<'v> {
    pub sampler: u32,
    pub node: Option<u32>,
    pub path: Option<Path>,
    /// `KHR_animation_pointer`.
    pub pointer: Option<&'v str>,
}

/// Keyframes.
pub(crate) struct Keyframes {
    pub input: u32,
    pub output: u32,
    pub interpolation: Interpolation,
}

/// A clip.
pub(crate) struct Animation<'v> {
    pub name: &'v str,
    pub channels: Vec<Channel<'v>>,
    pub samplers: Vec<Keyframes>,
}

impl<'v> Animation<'v> {
    pub fn read(r: &mut Reader<'v>, v: &'v Value) -> Result<Self, Fault> {
        let o = r.object(v)?;
        r.other_extensions(o, &[]);
        Ok(Self {
            name: name(r, o),
            channels: r.req(o, "channels", |r, v| r.array(v, Channel::read))?,
            samplers: r.req(o, "samplers", |r, v| r.array(v, Keyframes::read))?,
        })
    }
}

impl<'v> Channel<'v> {
    fn read(r: &mut Reader<'v>, v: &'v Value) -> Result<Self, Fault> {
        let o = r.object(v)?;
        let sampler = r.req(o, "sampler", Reader::index)?;
        let (node, path, pointer) = r.req(o, "target", |r, v| {
            let o = r.object(v)?;
            r.other_extensions(o, &[ext::ANIMATION_POINTER]);
            let pointer =
                r.extension(o, ext::ANIMATION_POINTER, |r, o| r.req(o, "pointer", Reader::string))?;
            let node = r.opt(o, "node", Reader::index)?;
            let path = r.req(o, "path", |r, v| {
                Ok(match r.string(v)? {
                    "translation" => Some(Path::Translation),
                    "rotation" => Some(Path::Rotation),
                    "scale" => Some(Path::Scale),
                    "weights" => Some(Path::Weights),
                    "pointer" => {
                        if pointer.is_none() {
                            r.warn("an animation of a pointer without a pointer; ignored");
                        }
                        None
                    }
                    other => {
                        r.warn(format!("animations of `{other}` are not known; ignored"));
                        None
                    }
                })
            })?;
            let pointer = pointer.filter(|_| path.is_none());
            Ok((node, path, pointer))
        })?;
        Ok(Self { sampler, node, path, pointer })
    }
}

impl Keyframes {
    fn read<'v>(r: &mut Reader<'v>, v: &'v Value) -> Result<Self, Fault> {
        let o = r.object(v)?;
        Ok(Self {
            input: r.req(o, "input", Reader::index)?,
            output: r.req(o, "output", Reader::index)?,
            interpolation: r
                .opt(o, "interpolation", |r, v| {
                    Ok(match r.string(v)? {
                        "STEP" => Interpolation::Step,
                        "LINEAR" => Interpolation::Linear,
                        "CUBICSPLINE" => Interpolation::CubicSpline,
                        other => return Err(r.fault(format!("`{other}` is no interpolation"))),
                    })
                })?
                .unwrap_or(Interpolation::Linear),
        })
    }
}
