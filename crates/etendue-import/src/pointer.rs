//! What JSON pointers of `KHR_animation_pointer` lead to: the mutable properties of the glTF 2.0 Asset Object Model (Khronos) that
//! a picture shows.

use crate::document::Path;
use crate::extensions as ext;
use serde_json::{Map, Value};

/// An object whose values are read again after they were changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Owner {
    Material(u32),
    Camera(u32),
    Light(u32),
    /// Surroundings (`EXT_lights_image_based`).
    Sky(u32),
}

impl Owner {
    /// JSON pointer to it.
    pub fn pointer(&self) -> String {
        match self {
            Self::Material(i) => format!("/materials/{i}"),
            Self::Camera(i) => format!("/cameras/{i}"),
            Self::Light(i) => format!("/extensions/{}/lights/{i}", ext::LIGHTS_PUNCTUAL),
            Self::Sky(i) => format!("/extensions/{}/lights/{i}", ext::LIGHTS_IMAGE_BASED),
        }
    }
}

/// What a pointer leads to.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Property<'v> {
    /// Of a node.
    Node(u32, Path),
    /// One weight of a node's morph targets.
    NodeWeight(u32, usize),
    /// The weights of a mesh's morph targets, or one of them.
    MeshWeights(u32, Option<usize>),
    /// Whether a node is shown.
    Visible(u32),
    /// So many numbers at a path within an object.
    Value(Owner, Vec<&'v str>, usize),
}

/// Object that holds the property (nothing for the owner itself), the property's name, how many numbers it is.
type Known = (&'static str, &'static str, usize);

const MATERIAL: &[Known] = &[
    ("", "alphaCutoff", 1),
    ("", "emissiveFactor", 3),
    ("pbrMetallicRoughness", "baseColorFactor", 4),
    ("pbrMetallicRoughness", "metallicFactor", 1),
    ("pbrMetallicRoughness", "roughnessFactor", 1),
    ("normalTexture", "scale", 1),
    ("occlusionTexture", "strength", 1),
    (ext::TEXTURE_TRANSFORM, "offset", 2),
    (ext::TEXTURE_TRANSFORM, "rotation", 1),
    (ext::TEXTURE_TRANSFORM, "scale", 2),
    (ext::ANISOTROPY, "anisotropyStrength", 1),
    (ext::ANISOTROPY, "anisotropyRotation", 1),
    (ext::CLEARCOAT, "clearcoatFactor", 1),
    (ext::CLEARCOAT, "clearcoatRoughnessFactor", 1),
    ("clearcoatNormalTexture", "scale", 1),
    (ext::COAT, "coatFactor", 1),
    (ext::COAT, "coatRoughnessFactor", 1),
    (ext::COAT, "coatIor", 1),
    (ext::COAT, "coatColorFactor", 3),
    (ext::COAT, "coatDarkeningFactor", 1),
    (ext::COAT, "coatAnisotropyStrength", 1),
    (ext::COAT, "coatAnisotropyRotation", 1),
    ("coatNormalTexture", "scale", 1),
    (ext::FUZZ, "fuzzFactor", 1),
    (ext::FUZZ, "fuzzColorFactor", 3),
    (ext::FUZZ, "fuzzRoughnessFactor", 1),
    (ext::DIFFUSE_ROUGHNESS, "diffuseRoughnessFactor", 1),
    (ext::DIFFUSE_TRANSMISSION, "diffuseTransmissionFactor", 1),
    (ext::DIFFUSE_TRANSMISSION, "diffuseTransmissionColorFactor", 3),
    (ext::DISPERSION, "dispersion", 1),
    (ext::EMISSIVE_STRENGTH, "emissiveStrength", 1),
    (ext::IOR, "ior", 1),
    (ext::IRIDESCENCE, "iridescenceFactor", 1),
    (ext::IRIDESCENCE, "iridescenceIor", 1),
    (ext::IRIDESCENCE, "iridescenceThicknessMinimum", 1),
    (ext::IRIDESCENCE, "iridescenceThicknessMaximum", 1),
    (ext::SHEEN, "sheenColorFactor", 3),
    (ext::SHEEN, "sheenRoughnessFactor", 1),
    (ext::SPECULAR, "specularFactor", 1),
    (ext::SPECULAR, "specularColorFactor", 3),
    (ext::SPECULAR_GLOSSINESS, "diffuseFactor", 4),
    (ext::SPECULAR_GLOSSINESS, "specularFactor", 3),
    (ext::SPECULAR_GLOSSINESS, "glossinessFactor", 1),
    (ext::TRANSMISSION, "transmissionFactor", 1),
    (ext::SCATTER, "scatterStrengthFactor", 1),
    (ext::SCATTER, "multiscatterColorFactor", 3),
    (ext::SCATTER, "scatterAnisotropy", 1),
    (ext::VOLUME_SCATTER, "multiscatterColorFactor", 3),
    (ext::VOLUME_SCATTER, "multiscatterColor", 3),
    (ext::VOLUME_SCATTER, "scatterAnisotropy", 1),
    (ext::VOLUME, "thicknessFactor", 1),
    (ext::VOLUME, "attenuationDistance", 1),
    (ext::VOLUME, "attenuationColor", 3),
];

/// Clipping planes are not used, but known.
const CAMERA: &[Known] = &[
    ("perspective", "aspectRatio", 1),
    ("perspective", "yfov", 1),
    ("perspective", "zfar", 1),
    ("perspective", "znear", 1),
    ("orthographic", "xmag", 1),
    ("orthographic", "ymag", 1),
    ("orthographic", "zfar", 1),
    ("orthographic", "znear", 1),
];

const LIGHT: &[Known] = &[
    ("", "color", 3),
    ("", "intensity", 1),
    ("", "range", 1),
    ("spot", "innerConeAngle", 1),
    ("spot", "outerConeAngle", 1),
];

const SKY: &[Known] = &[("", "rotation", 4), ("", "intensity", 1)];

/// The property at `pointer`; `None` if it is none that is known. Whether what it belongs to exists is not looked at.
pub(crate) fn resolve(pointer: &str) -> Option<Property<'_>> {
    let steps: Vec<&str> = pointer.strip_prefix('/')?.split('/').collect();
    let number = |s: &str| s.parse::<u32>().ok();
    let one = |s: &str| s.parse::<usize>().ok();
    match steps[..] {
        ["nodes", i, property] => {
            let path = match property {
                "translation" => Path::Translation,
                "rotation" => Path::Rotation,
                "scale" => Path::Scale,
                "weights" => Path::Weights,
                _ => return None,
            };
            Some(Property::Node(number(i)?, path))
        }
        ["nodes", i, "weights", k] => Some(Property::NodeWeight(number(i)?, one(k)?)),
        ["nodes", i, "extensions", ext::NODE_VISIBILITY, "visible"] => Some(Property::Visible(number(i)?)),
        ["meshes", i, "weights"] => Some(Property::MeshWeights(number(i)?, None)),
        ["meshes", i, "weights", k] => Some(Property::MeshWeights(number(i)?, Some(one(k)?))),
        ["materials", i, ..] => value(Owner::Material(number(i)?), &steps[2..], MATERIAL),
        ["cameras", i, ..] => value(Owner::Camera(number(i)?), &steps[2..], CAMERA),
        ["extensions", ext::LIGHTS_PUNCTUAL, "lights", i, ..] => {
            value(Owner::Light(number(i)?), &steps[4..], LIGHT)
        }
        ["extensions", ext::LIGHTS_IMAGE_BASED, "lights", i, ..] => {
            value(Owner::Sky(number(i)?), &steps[4..], SKY)
        }
        _ => None,
    }
}

/// The property of `owner` at `path`, if it is one of the `known`.
fn value<'v>(owner: Owner, path: &[&'v str], known: &[Known]) -> Option<Property<'v>> {
    let (leaf, above) = path.split_last()?;
    let holder = above.last().copied().unwrap_or("");
    let found = known.iter().find(|k| (k.0, k.1) == (holder, *leaf))?;
    Some(Property::Value(owner, path.to_vec(), found.2))
}

/// Sets the property at `path` of `object`. Objects on the way that have no required properties of their own are made if they are
/// missing; returns false, and changes nothing, if another one is.
pub(crate) fn set(object: &mut Value, path: &[&str], value: Value) -> bool {
    let Some((key, rest)) = path.split_first() else {
        *object = value;
        return true;
    };
    let Some(map) = object.as_object_mut() else { return false };
    if rest.is_empty() {
        map.insert((*key).to_owned(), value);
        return true;
    }
    let free = matches!(*key, "pbrMetallicRoughness" | "extensions" | "spot")
        || key.starts_with("KHR_")
        || key.starts_with("EXT_");
    match map.get_mut(*key) {
        Some(below) => set(below, rest, value),
        None if free => {
            let mut below = Value::Object(Map::new());
            let done = set(&mut below, rest, value);
            if done {
                map.insert((*key).to_owned(), below);
            }
            done
        }
        None => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn pointers_lead_to_properties() {
        assert_eq!(resolve("/nodes/3/rotation"), Some(Property::Node(3, Path::Rotation)));
        assert_eq!(resolve("/nodes/3/weights/2"), Some(Property::NodeWeight(3, 2)));
        assert_eq!(resolve("/meshes/0/weights"), Some(Property::MeshWeights(0, None)));
        assert_eq!(resolve("/nodes/7/extensions/KHR_node_visibility/visible"), Some(Property::Visible(7)));
        let values = |p| match resolve(p) {
            Some(Property::Value(owner, path, n)) => Some((owner.pointer() + "/" + &path.join("/"), n)),
            _ => None,
        };
        for (p, n) in [
            ("/materials/1/pbrMetallicRoughness/baseColorFactor", 4),
            ("/materials/1/normalTexture/scale", 1),
            ("/materials/1/normalTexture/extensions/KHR_texture_transform/scale", 2),
            ("/materials/1/extensions/KHR_materials_pbrSpecularGlossiness/specularFactor", 3),
            ("/materials/1/extensions/KHR_materials_specular/specularFactor", 1),
            ("/cameras/0/perspective/yfov", 1),
            ("/extensions/KHR_lights_punctual/lights/2/spot/innerConeAngle", 1),
            ("/extensions/EXT_lights_image_based/lights/0/rotation", 4),
        ] {
            assert_eq!(values(p), Some((p.to_owned(), n)));
        }
        for p in [
            "",
            "nodes/0/scale",
            "/nodes/0",
            "/nodes/x/scale",
            "/nodes/0/matrix",
            "/materials/0/normalTexture/offset",
            "/materials/0/doubleSided",
            "/materials/0",
            "/extensions/KHR_lights_punctual/lights/2/type",
            "/scenes/0/name",
        ] {
            assert_eq!(resolve(p), None, "{p}");
        }
    }

    #[test]
    fn values_are_set_where_their_object_may_be() {
        let mut m = json!({"normalTexture": {"index": 0}});
        assert!(set(
            &mut m,
            &["normalTexture", "extensions", "KHR_texture_transform", "offset"],
            json!([1, 2])
        ));
        assert!(set(&mut m, &["normalTexture", "scale"], json!(0.5)));
        assert!(!set(&mut m, &["occlusionTexture", "strength"], json!(0.5)), "a texture without an index");
        let expected = json!({"normalTexture": {
            "index": 0, "scale": 0.5, "extensions": {"KHR_texture_transform": {"offset": [1, 2]}}
        }});
        assert_eq!(m, expected);
    }
}
