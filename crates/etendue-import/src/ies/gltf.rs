//! `EXT_lights_ies`.

use super::{MOST_BYTES, parse_ies};
use crate::buffers::Buffers;
use crate::document::{Document, IesLight, Node};
use crate::error::Fault;
use crate::extensions as ext;
use crate::source::Source;
use crate::warning::Warnings;
use etendue_scene::{Light, LightKind, LightProfile};
use glam::{DAffine3, DVec3, Vec3};
use std::sync::Arc;

/// The profiles of a file: their number in the scene, or `None` where one is none.
#[derive(Clone, Default)]
pub(crate) struct Loaded {
    pub profiles: Vec<Arc<LightProfile>>,
    number: Vec<Option<u32>>,
}

/// Reads the profiles that the file lists. A broken one is a warning: the rest can be shown.
pub(crate) fn load(
    doc: &Document<'_>,
    buffers: &Buffers<'_>,
    source: &Source<'_>,
    warnings: &mut Warnings,
) -> Loaded {
    let mut out = Loaded::default();
    for (i, p) in doc.ies_profiles.iter().enumerate() {
        let pointer = format!("/extensions/{}/lights/{i}", ext::LIGHTS_IES);
        let bytes = match (p.uri, p.buffer_view) {
            (Some(uri), _) => source.read(uri, "light profile", &pointer),
            (None, Some(v)) => buffers.view(doc, v, || format!("{pointer}/bufferView")).map(<[u8]>::to_vec),
            (None, None) => Err(Fault::invalid(&pointer, "has neither `uri` nor `bufferView`")),
        };
        let file = bytes.map_err(|e| e.message()).and_then(|b| {
            if b.len() as u64 > MOST_BYTES {
                return Err(format!("{} bytes are no IES profile", b.len()));
            }
            parse_ies(&b).map_err(|e| e.to_string())
        });
        match file {
            Ok(f) => {
                f.notes.iter().for_each(|n| warnings.add(&pointer, n.clone()));
                out.number.push(Some(out.profiles.len() as u32));
                out.profiles.push(Arc::new(f.profile));
            }
            Err(e) => {
                warnings.add(&pointer, format!("{e}; its lights are left out"));
                out.number.push(None);
            }
        }
    }
    out
}

/// The light `l` on a node that stands at `m`; `None`, with a warning, if it cannot shine.
pub(crate) fn light(
    l: &IesLight,
    loaded: &Loaded,
    pointer: &str,
    node: &Node<'_>,
    m: &DAffine3,
    warnings: &mut Warnings,
) -> Result<Option<Light>, Fault> {
    let Some(number) = loaded.number.get(l.light as usize) else {
        return Err(Fault::invalid(
            format!("{pointer}/light"),
            format!("light {} does not exist; the file has {}", l.light, loaded.number.len()),
        ));
    };
    let Some(profile) = *number else { return Ok(None) };
    let aim = (m.matrix3 * DVec3::NEG_Z).try_normalize();
    // At a right angle even where the node is sheared.
    let side = aim.and_then(|z| (m.matrix3 * DVec3::X).reject_from_normalized(z).try_normalize());
    let (Some(aim), Some(side)) = (aim, side) else {
        warnings.add(pointer, "points nowhere: its node's transform is flat; the light is left out");
        return Ok(None);
    };
    let color = Vec3::from_array(l.color.map(|c| c as f32));
    let multiplier = l.multiplier as f32;
    if color.min_element() < 0.0 || color.max_element() > 1.0 || multiplier < 0.0 {
        warnings.add(pointer, "a colour outside of 0..1 or a multiplier below 0; clamped");
    }
    let light = Light {
        name: node.name.to_owned(),
        kind: LightKind::Profile { profile, side: side.as_vec3() },
        intensity: color.clamp(Vec3::ZERO, Vec3::ONE) * multiplier.max(0.0),
        position: m.translation.as_vec3(),
        direction: aim.as_vec3(),
        range: None,
    };
    if !light.is_finite() {
        warnings.add(pointer, "a value is not finite; the light is left out");
        return Ok(None);
    }
    Ok(Some(light))
}
