//! The helmet put together: every part made, its pictures baked and painted, the file written.

use crate::bake::{Atlas, Maps, paint};
use crate::details::*;
use crate::fabric::{quilt, webbing};
use crate::gltf_write::Gltf;
use crate::occlusion::Occluders;
use crate::paint_parts::{Part, parts_paint};
use crate::paint_shell::shell_paint;
use crate::paint_visor::visor_paint;
use crate::rim::{frame_mesh, gasket_mesh, lining_mesh, neck_mesh};
use crate::shape::{Mesh, Rect};
use crate::shell::shell_mesh;
use crate::strap::{buckle_mesh, buckle_place, strap_mesh};
use crate::visor::visor_mesh;
use glam::{Mat4, Vec2, Vec3};
use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};
use serde_json::{Value, json};

/// Side of the hardware's pictures, texels.
const PARTS: f32 = 1024.0;

/// Folds a long strip in two halves that lie one above the other in `rect`.
fn fold(mut m: Mesh, rows: [Rect; 2]) -> Mesh {
    // A vertex on the fold belongs to both halves: a triangle's own middle decides, shared vertices are doubled.
    let mut out = Mesh::default();
    let mut made = std::collections::HashMap::new();
    for t in m.idx.chunks_exact(3) {
        let middle: f32 = t.iter().map(|i| m.uv[*i as usize].x).sum::<f32>() / 3.0;
        let half = (middle > 0.5) as usize;
        for &i in t {
            let k = i as usize;
            let v = *made.entry((i, half)).or_insert_with(|| {
                let uv = rows[half].at(Vec2::new((m.uv[k].x - 0.5 * half as f32) * 2.0, m.uv[k].y));
                out.push(m.pos[k], m.nrm[k], uv, m.aux[k])
            });
            out.idx.push(v);
        }
    }
    m.idx.clear();
    out
}

/// A part, its place(s) and its share of the hardware's pictures.
struct Placed {
    name: &'static str,
    part: Part,
    mesh: Mesh,
    places: Vec<Mat4>,
}

/// A strip of the hardware's pictures.
fn strip(x: f32, y: f32, w: f32, h: f32) -> Rect {
    Rect::px(x, y, w, h, [PARTS, PARTS])
}

fn hardware() -> Vec<Placed> {
    let here = vec![Mat4::IDENTITY];
    let left = connector_place(1.0);
    vec![
        Placed {
            name: "frame",
            part: Part::Frame,
            mesh: fold(frame_mesh(), [strip(6.0, 6.0, 1012.0, 92.0), strip(6.0, 106.0, 1012.0, 92.0)]),
            places: here.clone(),
        },
        Placed {
            name: "gasket",
            part: Part::Gasket,
            mesh: gasket_mesh().place_uv(strip(6.0, 206.0, 1012.0, 30.0)),
            places: here.clone(),
        },
        Placed {
            name: "neck ring",
            part: Part::Neck,
            mesh: neck_mesh().place_uv(strip(6.0, 244.0, 1012.0, 84.0)),
            places: here.clone(),
        },
        Placed {
            name: "hose",
            part: Part::Hose,
            mesh: hose_mesh().place_uv(strip(6.0, 336.0, 560.0, 110.0)),
            places: here.clone(),
        },
        Placed {
            name: "mouthpiece",
            part: Part::Mouth,
            mesh: mouth_mesh().place_uv(strip(6.0, 456.0, 560.0, 322.0)),
            places: here.clone(),
        },
        Placed {
            name: "grille",
            part: Part::Grille,
            mesh: grille_mesh().place_uv(strip(6.0, 788.0, 200.0, 60.0)),
            places: here,
        },
        Placed {
            name: "pod",
            part: Part::Pod,
            mesh: pod_mesh().place_uv(strip(576.0, 336.0, 440.0, 440.0)),
            places: vec![pod_place(), mirrored(pod_place())],
        },
        Placed {
            name: "connector",
            part: Part::Connector,
            mesh: connector_mesh().place_uv(strip(576.0, 784.0, 232.0, 232.0)),
            places: vec![left, connector_place(-1.0), hose_end()],
        },
        Placed {
            name: "bolt",
            part: Part::Bolt,
            mesh: bolt_mesh().place_uv(strip(816.0, 784.0, 64.0, 64.0)),
            places: bolt_places(),
        },
        Placed {
            name: "buckle",
            part: Part::Buckle,
            mesh: buckle_mesh().place_uv(strip(216.0, 788.0, 350.0, 60.0)),
            places: vec![buckle_place(), mirrored(buckle_place())],
        },
        Placed {
            name: "lamp",
            part: Part::Lamp,
            mesh: lamp_mesh().place_uv(strip(816.0, 856.0, 160.0, 160.0)),
            places: vec![lamp_place()],
        },
    ]
}

fn jpeg(w: usize, h: usize, rgb: &[u8], quality: u8) -> Vec<u8> {
    let mut out = Vec::new();
    JpegEncoder::new_with_quality(&mut out, quality)
        .encode(rgb, w as u32, h as u32, ExtendedColorType::Rgb8)
        .expect("writing to memory does not fail");
    out
}

fn png(w: usize, h: usize, rgb: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    PngEncoder::new_with_quality(&mut out, CompressionType::Best, FilterType::Adaptive)
        .write_image(rgb, w as u32, h as u32, ExtendedColorType::Rgb8)
        .expect("writing to memory does not fail");
    out
}

/// Quality of the JPEGs of base colour, occlusion-roughness-metallic, and normal.
type Quality = [u8; 3];

/// Adds a material with its pictures.
fn material(g: &mut Gltf, name: &str, maps: &Maps, quality: Quality, extra: Value) -> usize {
    let (w, h) = (maps.width, maps.height);
    let base = g.texture(&format!("{name} base colour"), "image/jpeg", &jpeg(w, h, &maps.base, quality[0]));
    let orm = g.texture(
        &format!("{name} occlusion roughness metallic"),
        "image/jpeg",
        &jpeg(w, h, &maps.orm, quality[1]),
    );
    let mut m = json!({
        "name": name,
        "pbrMetallicRoughness": {
            "baseColorTexture": { "index": base },
            "metallicRoughnessTexture": { "index": orm }
        },
        "occlusionTexture": { "index": orm }
    });
    if quality[2] > 0 {
        let normal =
            g.texture(&format!("{name} normal"), "image/jpeg", &jpeg(w, h, &maps.normal, quality[2]));
        m["normalTexture"] = json!({ "index": normal });
    }
    if maps.emissive.iter().any(|e| *e > 0) {
        let e = g.texture(&format!("{name} emissive"), "image/png", &png(w, h, &maps.emissive));
        m["emissiveTexture"] = json!({ "index": e });
        m["emissiveFactor"] = json!([1.0, 1.0, 1.0]);
    }
    if let Value::Object(more) = extra {
        for (k, v) in more {
            m[k] = v;
        }
    }
    g.material(m)
}

/// The helmet as binary glTF, metres, +Z front, +Y up, standing on y = 0.
pub fn helmet() -> Vec<u8> {
    let (shell, visor, strap, lining) = (shell_mesh(), visor_mesh(), strap_mesh(), lining_mesh());
    let hardware = hardware();

    // Everything in place, as the rays see it.
    let mut world = vec![shell.clone(), visor.clone(), strap.clone(), lining.clone()];
    for p in &hardware {
        world.extend(p.places.iter().map(|m| p.mesh.clone().transform(*m)));
    }
    let occluders = Occluders::new(world.iter());
    let floor = world.iter().flat_map(|m| &m.pos).map(|p| p.y).fold(f32::MAX, f32::min);

    let mut shell_atlas = Atlas::new(2048, 1024);
    shell_atlas.draw(&shell, 1);
    shell_atlas.occlude(&occluders, 0.07, 4, 64);
    shell_atlas.grow(6);
    let shell_maps = paint(&shell_atlas, Vec3::splat(0.3), shell_paint);

    let mut visor_atlas = Atlas::new(1024, 512);
    visor_atlas.draw(&visor, 1);
    visor_atlas.occlude(&occluders, 0.05, 4, 64);
    visor_atlas.grow(6);
    let visor_maps = paint(&visor_atlas, Vec3::new(0.8, 0.5, 0.2), visor_paint);

    let mut parts_atlas = Atlas::new(PARTS as usize, PARTS as usize);
    for p in &hardware {
        // Of several places the first is the one that faces the usual camera.
        parts_atlas.draw(&p.mesh.clone().transform(p.places[0]), p.part as u8);
    }
    parts_atlas.soften_ridges(2);
    parts_atlas.occlude(&occluders, 0.05, 2, 64);
    parts_atlas.grow(4);
    let parts_maps = paint(&parts_atlas, Vec3::splat(0.02), parts_paint);

    let mut g = Gltf::new();
    let shell_material = material(&mut g, "shell", &shell_maps, [86, 82, 86], json!({}));
    let visor_material = material(&mut g, "visor", &visor_maps, [84, 84, 0], json!({}));
    let glow = json!({ "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": 5.0 } } });
    let rim_material = material(&mut g, "rim", &parts_maps, [86, 82, 86], glow.clone());
    let hardware_material = material(&mut g, "hardware", &parts_maps, [86, 82, 86], glow);
    let strap_material = material(&mut g, "strap", &webbing(), [84, 80, 86], json!({}));
    let lining_material = material(&mut g, "lining", &quilt(), [80, 76, 82], json!({ "doubleSided": true }));

    let shell_index = g.mesh("shell", &[(&shell, shell_material)]);
    g.node("shell", shell_index, Mat4::IDENTITY);
    let visor_index = g.mesh("visor", &[(&visor, visor_material)]);
    g.node("visor", visor_index, Mat4::IDENTITY);
    let strap_index = g.mesh("strap", &[(&strap, strap_material)]);
    g.node("strap", strap_index, Mat4::IDENTITY);
    let lining_index = g.mesh("lining", &[(&lining, lining_material)]);
    g.node("lining", lining_index, Mat4::IDENTITY);
    let mut rim = Vec::new();
    for p in &hardware {
        if matches!(p.part, Part::Frame | Part::Gasket | Part::Neck) {
            rim.push(&p.mesh);
            continue;
        }
        let mesh = g.mesh(p.name, &[(&p.mesh, hardware_material)]);
        for (k, place) in p.places.iter().enumerate() {
            let name = if p.places.len() > 1 { format!("{} {}", p.name, k + 1) } else { p.name.to_owned() };
            g.node(&name, mesh, *place);
        }
    }
    let primitives: Vec<_> = rim.iter().map(|m| (*m, rim_material)).collect();
    let rim_index = g.mesh("rim", &primitives);
    g.node("rim", rim_index, Mat4::IDENTITY);
    g.finish("helmet", -floor).expect("a few megabytes")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_parts_share_a_texel() {
        let size = PARTS as usize;
        let mut taken = vec![0u8; size * size];
        for p in hardware() {
            let mut atlas = Atlas::new(size, size);
            atlas.draw(&p.mesh, p.part as u8);
            atlas.grow(2);
            for (a, t) in taken.iter_mut().zip(&atlas.texels) {
                if t.part != 0 {
                    assert!(*a == 0 || *a == t.part, "{} lies on part {a}", p.name);
                    *a = t.part;
                }
            }
            assert!(p.mesh.uv.iter().all(|t| t.min_element() >= 0.0 && t.max_element() <= 1.0), "{}", p.name);
        }
    }

    #[test]
    fn places_are_rigid() {
        for p in hardware() {
            for m in p.places {
                let (scale, _, _) = m.to_scale_rotation_translation();
                assert!((scale - Vec3::ONE).abs().max_element() < 1e-4, "{}: scale {scale}", p.name);
                assert!(m.determinant() > 0.0, "{}: mirrored", p.name);
            }
        }
    }
}
