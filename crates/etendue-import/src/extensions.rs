//! Which glTF extensions are understood, and how far.

use crate::error::Fault;

pub(crate) const ANIMATION_POINTER: &str = "KHR_animation_pointer";
pub(crate) const ANISOTROPY: &str = "KHR_materials_anisotropy";
pub(crate) const CLEARCOAT: &str = "KHR_materials_clearcoat";
pub(crate) const COAT: &str = "KHR_materials_coat";
pub(crate) const DIFFUSE_ROUGHNESS: &str = "KHR_materials_diffuse_roughness";
pub(crate) const DIFFUSE_TRANSMISSION: &str = "KHR_materials_diffuse_transmission";
pub(crate) const DISPERSION: &str = "KHR_materials_dispersion";
pub(crate) const DRACO: &str = "KHR_draco_mesh_compression";
pub(crate) const EMISSIVE_STRENGTH: &str = "KHR_materials_emissive_strength";
pub(crate) const EXT_MESHOPT: &str = "EXT_meshopt_compression";
pub(crate) const FUZZ: &str = "KHR_materials_fuzz";
pub(crate) const GPU_INSTANCING: &str = "EXT_mesh_gpu_instancing";
pub(crate) const IOR: &str = "KHR_materials_ior";
pub(crate) const IRIDESCENCE: &str = "KHR_materials_iridescence";
pub(crate) const KHR_MESHOPT: &str = "KHR_meshopt_compression";
pub(crate) const LIGHTS_IES: &str = "EXT_lights_ies";
pub(crate) const LIGHTS_IMAGE_BASED: &str = "EXT_lights_image_based";
pub(crate) const LIGHTS_PUNCTUAL: &str = "KHR_lights_punctual";
pub(crate) const MESH_QUANTIZATION: &str = "KHR_mesh_quantization";
pub(crate) const NODE_VISIBILITY: &str = "KHR_node_visibility";
pub(crate) const SCATTER: &str = "KHR_materials_scatter";
pub(crate) const SHEEN: &str = "KHR_materials_sheen";
pub(crate) const SPECULAR: &str = "KHR_materials_specular";
pub(crate) const SPECULAR_GLOSSINESS: &str = "KHR_materials_pbrSpecularGlossiness";
pub(crate) const TEXTURE_BASISU: &str = "KHR_texture_basisu";
pub(crate) const TEXTURE_TRANSFORM: &str = "KHR_texture_transform";
pub(crate) const TEXTURE_WEBP: &str = "EXT_texture_webp";
pub(crate) const TRANSMISSION: &str = "KHR_materials_transmission";
pub(crate) const UNLIT: &str = "KHR_materials_unlit";
pub(crate) const VARIANTS: &str = "KHR_materials_variants";
pub(crate) const VOLUME: &str = "KHR_materials_volume";
pub(crate) const VOLUME_SCATTER: &str = "KHR_materials_volume_scatter";
/// May stand on anything; read where it stands on the asset.
pub(crate) const XMP: &str = "KHR_xmp_json_ld";

/// Extensions that may stand on an object of the kind and need no warning there.
pub(crate) const ON_ACCESSOR: [&str; 0] = [];
pub(crate) const ON_BUFFER_VIEW: [&str; 2] = [EXT_MESHOPT, KHR_MESHOPT];
pub(crate) const ON_ROOT: [&str; 4] = [LIGHTS_IES, LIGHTS_IMAGE_BASED, LIGHTS_PUNCTUAL, VARIANTS];
pub(crate) const ON_SCENE: [&str; 1] = [LIGHTS_IMAGE_BASED];
pub(crate) const ON_PRIMITIVE: [&str; 2] = [DRACO, VARIANTS];
pub(crate) const ON_MATERIAL: [&str; 18] = [
    UNLIT,
    EMISSIVE_STRENGTH,
    IOR,
    SPECULAR,
    ANISOTROPY,
    CLEARCOAT,
    COAT,
    DIFFUSE_ROUGHNESS,
    DIFFUSE_TRANSMISSION,
    DISPERSION,
    FUZZ,
    IRIDESCENCE,
    SCATTER,
    SHEEN,
    SPECULAR_GLOSSINESS,
    TRANSMISSION,
    VOLUME,
    VOLUME_SCATTER,
];
/// Those that describe what `etendue_scene::Extensions` holds.
pub(crate) const ON_SURFACE: [&str; 14] = [
    ANISOTROPY,
    CLEARCOAT,
    COAT,
    DIFFUSE_ROUGHNESS,
    DIFFUSE_TRANSMISSION,
    DISPERSION,
    FUZZ,
    IRIDESCENCE,
    SCATTER,
    SHEEN,
    SPECULAR_GLOSSINESS,
    TRANSMISSION,
    VOLUME,
    VOLUME_SCATTER,
];
pub(crate) const ON_NODE: [&str; 4] = [LIGHTS_IES, LIGHTS_PUNCTUAL, GPU_INSTANCING, NODE_VISIBILITY];

/// How far an extension is supported.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Support {
    /// As its specification says.
    Full,
    /// With exceptions, which warnings name.
    Partly,
    /// It is a draft that may still change: read as it stood when this was written, if
    /// [`ImportOptions::drafts`](crate::ImportOptions::drafts) asks for it, and otherwise ignored.
    Draft,
    /// It says nothing of how a scene looks in a picture, or is a draft that was not asked for: its data are skipped.
    Ignored,
    /// Its data cannot be skipped: a file that requires it is refused.
    Refused,
}

/// What is done about each extension; every one that is not listed is unknown.
const TABLE: &[(&str, Support)] = &[
    (ANIMATION_POINTER, Support::Full),
    (ANISOTROPY, Support::Full),
    (CLEARCOAT, Support::Full),
    (COAT, Support::Draft),
    (DIFFUSE_ROUGHNESS, Support::Draft),
    (FUZZ, Support::Draft),
    (DIFFUSE_TRANSMISSION, Support::Full),
    (DISPERSION, Support::Full),
    (DRACO, Support::Full),
    (EMISSIVE_STRENGTH, Support::Full),
    (EXT_MESHOPT, Support::Full),
    (GPU_INSTANCING, Support::Full),
    (IOR, Support::Full),
    (IRIDESCENCE, Support::Full),
    (KHR_MESHOPT, Support::Full),
    (LIGHTS_IES, Support::Full),
    (LIGHTS_IMAGE_BASED, Support::Full),
    (LIGHTS_PUNCTUAL, Support::Full),
    (MESH_QUANTIZATION, Support::Full),
    (NODE_VISIBILITY, Support::Full),
    (SCATTER, Support::Draft),
    (SHEEN, Support::Full),
    (SPECULAR, Support::Full),
    (SPECULAR_GLOSSINESS, Support::Full),
    (TEXTURE_BASISU, Support::Full),
    (TEXTURE_TRANSFORM, Support::Full),
    (TEXTURE_WEBP, Support::Full),
    (TRANSMISSION, Support::Full),
    (UNLIT, Support::Full),
    (VARIANTS, Support::Full),
    (VOLUME, Support::Full),
    (VOLUME_SCATTER, Support::Draft),
    (XMP, Support::Full),
    ("MSFT_texture_dds", Support::Refused),
];

/// Extensions that say nothing of how a scene looks in a picture: what can be done with it, how it sounds and moves by itself, what it
/// means, how it is to be packed. A file may require them and still be shown.
const BESIDE_PICTURES: &[&str] = &[
    "AGI_articulations",
    "AGI_stk_metadata",
    "EXT_feature_metadata",
    "EXT_instance_features",
    "EXT_mesh_features",
    "EXT_mesh_manifold",
    "EXT_structural_metadata",
    "FB_geometry_metadata",
    "GODOT_single_root",
    "GRIFFEL_bim_data",
    "KHR_audio",
    "KHR_audio_emitter",
    "KHR_audio_graph",
    "KHR_collision_shapes",
    "KHR_implicit_shapes",
    "KHR_interactivity",
    "KHR_node_hoverability",
    "KHR_node_selectability",
    "KHR_physics_rigid_bodies",
    "KHR_xmp",
    "MPEG_audio_spatial",
    "MPEG_viewport_recommended",
    "MSFT_audio_emitter",
    "MSFT_lod",
    "MSFT_packing_normalRoughnessMetallic",
    "MSFT_packing_occlusionRoughnessMetallic",
    "OMI_audio_emitter",
    "OMI_collider",
    "OMI_link",
    "OMI_personality",
    "OMI_physics_body",
    "OMI_physics_shape",
    "OMI_seat",
    "OMI_spawn_point",
    "OMI_vehicle_body",
    "OMI_vehicle_wheel",
];

/// How far the extension `name` is supported; `None` if nothing here knows it.
pub fn support(name: &str) -> Option<Support> {
    let known = TABLE.iter().find(|(n, _)| *n == name).map(|&(_, s)| s);
    known.or_else(|| BESIDE_PICTURES.contains(&name).then_some(Support::Ignored))
}

/// True if what an extension says is understood, though it may not be used.
pub(crate) fn is_understood(name: &str) -> bool {
    !matches!(support(name), None | Some(Support::Ignored))
}

/// True if the extension `name` is a draft that is known.
pub(crate) fn is_draft(name: &str) -> bool {
    support(name) == Some(Support::Draft)
}

/// How drafts are asked for.
pub(crate) const SWITCH: &str = "--drafts (in the library ImportOptions::drafts)";

/// Refuses a file that requires what cannot be left out, or a draft if `drafts` are not asked for.
pub(crate) fn check_required(required: &[&str], drafts: bool) -> Result<(), Fault> {
    let pending: Vec<&str> = required.iter().copied().filter(|n| !drafts && is_draft(n)).collect();
    if !pending.is_empty() {
        return Err(Fault::Unsupported {
            pointer: "/extensionsRequired".into(),
            what: pending.join(", "),
            hint: format!("; what is still a draft is read only with {SWITCH}"),
        });
    }
    let refused: Vec<&str> = required
        .iter()
        .copied()
        .filter(|n| matches!(support(n), None | Some(Support::Refused)))
        .take(16)
        .collect();
    if !refused.is_empty() {
        return Err(Fault::Unsupported {
            pointer: "/extensionsRequired".into(),
            what: refused.join(", "),
            hint: String::new(),
        });
    }
    Ok(())
}
