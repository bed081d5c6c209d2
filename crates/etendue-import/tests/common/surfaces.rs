//! Materials with extensions.

use serde_json::{Value, json};

/// A material with the extension `KHR_materials_{name}`.
pub fn extended(name: &str, extension: Value) -> Value {
    json!({"extensions": {format!("KHR_materials_{name}"): extension}})
}

/// A reference to texture 1, set 1, shifted.
pub fn texture() -> Value {
    json!({"index": 1, "extensions": {"KHR_texture_transform": {"offset": [0.5, 0.25], "scale": [2, 4], "texCoord": 1}}})
}

/// The same for drafts.
pub fn drafts() -> Vec<(&'static str, Value, Value)> {
    let t = texture;
    vec![
        (
            "diffuse_roughness",
            json!({"diffuseRoughnessFactor": 0.5, "diffuseRoughnessTexture": t()}),
            json!({"diffuseRoughnessTexture": t()}),
        ),
        (
            "fuzz",
            json!({
                "fuzzFactor": 0.5, "fuzzTexture": t(), "fuzzColorFactor": [0.1, 0.2, 0.3], "fuzzColorTexture": t(),
                "fuzzRoughnessFactor": 0.25, "fuzzRoughnessTexture": t()
            }),
            json!({"fuzzTexture": t(), "fuzzColorFactor": [0.1, 0.2, 0.3], "fuzzRoughnessFactor": 1}),
        ),
        (
            "coat",
            json!({
                "coatFactor": 0.5, "coatTexture": t(), "coatRoughnessFactor": 0.25, "coatRoughnessTexture": t(),
                "coatNormalTexture": {"index": 1, "texCoord": 1, "scale": -3}, "coatIor": 1.75,
                "coatColorFactor": [0.1, 0.2, 0.3], "coatColorTexture": t(), "coatDarkeningFactor": 0.75,
                "coatAnisotropyStrength": 0.6, "coatAnisotropyRotation": 1.5, "coatAnisotropyTexture": t()
            }),
            json!({"coatTexture": t(), "coatColorFactor": [0.1, 0.2, 0.3], "coatAnisotropyStrength": 1}),
        ),
    ]
}

/// Per extension: its name, one that does something, and one whose factors make it do nothing.
pub fn samples() -> Vec<(&'static str, Value, Value)> {
    let t = texture;
    vec![
        (
            "anisotropy",
            json!({"anisotropyStrength": 0.6, "anisotropyRotation": 1.5, "anisotropyTexture": t()}),
            json!({"anisotropyRotation": 1.5, "anisotropyTexture": t()}),
        ),
        (
            "clearcoat",
            json!({
                "clearcoatFactor": 0.5, "clearcoatTexture": t(), "clearcoatRoughnessFactor": 0.25,
                "clearcoatRoughnessTexture": t(),
                "clearcoatNormalTexture": {"index": 1, "texCoord": 1, "scale": -3}
            }),
            json!({"clearcoatTexture": t(), "clearcoatRoughnessFactor": 1, "clearcoatNormalTexture": t()}),
        ),
        (
            "diffuse_transmission",
            json!({
                "diffuseTransmissionFactor": 0.5, "diffuseTransmissionTexture": t(),
                "diffuseTransmissionColorFactor": [0.1, 0.2, 0.3], "diffuseTransmissionColorTexture": t()
            }),
            json!({"diffuseTransmissionTexture": t(), "diffuseTransmissionColorFactor": [1, 0, 0]}),
        ),
        (
            "iridescence",
            json!({
                "iridescenceFactor": 0.5, "iridescenceTexture": t(), "iridescenceIor": 1.5,
                "iridescenceThicknessMinimum": 200, "iridescenceThicknessMaximum": 150,
                "iridescenceThicknessTexture": t()
            }),
            json!({"iridescenceTexture": t(), "iridescenceIor": 2, "iridescenceThicknessTexture": t()}),
        ),
        (
            "sheen",
            json!({
                "sheenColorFactor": [0.1, 0.2, 0.3], "sheenColorTexture": t(), "sheenRoughnessFactor": 0.5,
                "sheenRoughnessTexture": t()
            }),
            json!({"sheenColorTexture": t(), "sheenRoughnessFactor": 0.5, "sheenRoughnessTexture": t()}),
        ),
        (
            "transmission",
            json!({"transmissionFactor": 0.75, "transmissionTexture": t()}),
            json!({"transmissionTexture": t()}),
        ),
    ]
}
