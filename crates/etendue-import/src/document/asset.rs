//! `asset` and `scenes`.

use super::name;
use crate::error::Fault;
use crate::extensions as ext;
use crate::json::{Object, Reader};
use serde_json::Value;

/// Who made the file, and by which version of glTF.
pub(crate) struct Asset<'v> {
    pub version: &'v str,
    pub generator: Option<&'v str>,
    pub copyright: Option<&'v str>,
    /// Number of its packet of `KHR_xmp_json_ld`.
    pub xmp: Option<u32>,
}

impl<'v> Asset<'v> {
    /// Reads `asset` and refuses versions that cannot be read.
    pub fn read(r: &mut Reader<'v>, root: &'v Object) -> Result<Self, Fault> {
        r.req(root, "asset", |r, v| {
            let o = r.object(v)?;
            let version = r.req(o, "version", Reader::string)?;
            let min = r.opt(o, "minVersion", Reader::string)?;
            // A newer minor version must stay readable unless minVersion says otherwise (glTF 2.0, 3.2).
            if let Some(needed) = min.filter(|m| major_minor(m) != Some((2, 0))) {
                return Err(unsupported(r, "minVersion", needed));
            }
            match major_minor(version) {
                Some((2, 0)) => {}
                Some((2, _)) => {
                    r.warn(format!("glTF {version} is read as 2.0; what it adds is ignored"));
                }
                Some(_) => return Err(unsupported(r, "version", version)),
                None => return Err(r.fault(format!("`{version}` is no glTF version"))),
            }
            Ok(Self {
                version,
                generator: r.soft(o, "generator", Reader::string),
                copyright: r.soft(o, "copyright", Reader::string),
                xmp: r.extension(o, ext::XMP, |r, o| Ok(r.soft(o, "packet", Reader::index)))?.flatten(),
            })
        })
    }
}

fn major_minor(s: &str) -> Option<(u32, u32)> {
    let (a, b) = s.split_once('.')?;
    Some((a.parse().ok()?, b.parse().ok()?))
}

fn unsupported(r: &Reader, key: &str, version: &str) -> Fault {
    Fault::Unsupported {
        pointer: format!("{}/{key}", r.pointer()),
        what: format!("glTF {version}"),
        hint: "; glTF 2.0 is. Export the model again as glTF 2.0".into(),
    }
}

/// A set of root nodes to show.
pub(crate) struct Scene<'v> {
    pub name: &'v str,
    pub nodes: Vec<u32>,
    /// `EXT_lights_image_based`.
    pub image_light: Option<u32>,
}

impl<'v> Scene<'v> {
    pub fn read(r: &mut Reader<'v>, v: &'v Value) -> Result<Self, Fault> {
        let o = r.object(v)?;
        r.other_extensions(o, &ext::ON_SCENE);
        Ok(Self {
            name: name(r, o),
            nodes: r.list(o, "nodes", Reader::index)?,
            image_light: r.extension(o, ext::LIGHTS_IMAGE_BASED, |r, o| r.req(o, "light", Reader::index))?,
        })
    }
}
