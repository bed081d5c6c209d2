//! OBJ, PLY and STL: what they say becomes the scene that they mean; what is wrong is said with its place.
use etendue_import::{ImportError, ImportOptions, Imported, Limits, import, import_bytes};
use etendue_scene::AlphaMode;
use glam::{Vec2, Vec3, Vec4};
use std::fs;
use std::path::Path;

fn read(name: &str, text: impl AsRef<[u8]>) -> Imported {
    let m = import_bytes(text.as_ref(), name, &ImportOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(m.scene.validate(), Ok(()));
    m
}

fn fail(name: &str, text: impl AsRef<[u8]>) -> String {
    match import_bytes(text.as_ref(), name, &ImportOptions::default()) {
        Err(e) => e.to_string(),
        Ok(_) => panic!("was imported"),
    }
}

fn warnings(m: &Imported) -> Vec<String> {
    m.warnings.iter().map(ToString::to_string).collect()
}

/// A file of `bytes` in a folder.
fn file(folder: &Path, name: &str, bytes: impl AsRef<[u8]>) {
    let path = folder.join(name);
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    fs::write(path, bytes).unwrap();
}

/// An 8-bit PNG.
fn png(width: u32, height: u32, channels: u8, data: &[u8]) -> Vec<u8> {
    use etendue_image::{Image, PictureFormat, Pixels, WriteOptions, encode_picture};
    let i = Image { width, height, channels, pixels: Pixels::U8(data.to_vec()) };
    let mut out = Vec::new();
    encode_picture(&mut out, PictureFormat::Png, &i, &WriteOptions::default()).unwrap();
    out
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

#[test]
fn obj_faces_share_vertices_and_turn_v_over() {
    let m = read(
        "a.obj",
        format!(
            "{SQUARE}vt 0 0\nvt 1 0.25\nvn 0 0 2\nf 1/1/1 2/2/1 3/2/1 4/1/1\nf -4/-2/-1 -3/-1/-1 -2/-1/-1\n"
        ),
    );
    let mesh = &m.scene.meshes[0];
    assert_eq!(mesh.indices, [[0, 1, 2], [0, 2, 3], [0, 1, 2]]);
    assert_eq!(mesh.normals, [Vec3::Z; 4], "made unit vectors");
    assert_eq!(
        mesh.uvs,
        [[Vec2::new(0.0, 1.0), Vec2::new(1.0, 0.75), Vec2::new(1.0, 0.75), Vec2::new(0.0, 1.0)]]
    );
    let material = &m.scene.materials[0];
    assert!(material.double_sided && material.metallic == 0.0);
    assert_eq!(warnings(&m), Vec::<String>::new());
}

#[test]
fn obj_groups_and_materials_are_meshes() {
    let text = format!(
        "{SQUARE}o a\nf 1 2 3\ng b\nusemtl red\nf 1 2 3\nusemtl blue\nf 1 2 3\nusemtl red\nf 2 3 4\no c\nf 1 2 3\n"
    );
    let m = read("a.obj", text);
    let names: Vec<_> = m.scene.instances.iter().map(|i| &i.name[..]).collect();
    assert_eq!(names, ["a", "a/b", "a/b", "c"]);
    assert_eq!(m.scene.meshes[1].indices.len(), 2, "faces of one material come together again");
    let materials: Vec<_> =
        m.scene.instances.iter().map(|i| &m.scene.materials[i.material.unwrap() as usize].name[..]).collect();
    assert_eq!(materials, ["plain", "red", "blue", "red"]);
}

#[test]
fn obj_smoothing_groups_decide_over_normals() {
    // Two faces that meet at a right angle along an edge.
    let fold = "v 0 0 0\nv 0 1 0\nv 1 0 0\nv 0 0 1\n";
    let flat = read("a.obj", format!("{fold}f 1 3 2\nf 1 2 4\n"));
    assert!(flat.scene.meshes[0].normals.is_empty() && flat.scene.meshes[0].positions.len() == 4);
    let smooth = read("a.obj", format!("{fold}s 1\nf 1 3 2\nf 1 2 4\n"));
    let mesh = &smooth.scene.meshes[0];
    assert_eq!(mesh.positions.len(), 4);
    let middle = Vec3::new(1.0, 0.0, 1.0).normalize();
    assert!(
        (mesh.normals[0] - middle).length() < 1e-6 && (mesh.normals[1] - Vec3::Z).length() < 1e-6,
        "{:?}",
        mesh.normals
    );
    let mixed = read("a.obj", format!("{fold}s 1\nf 1 3 2\ns off\nf 1 2 4\n"));
    assert_eq!(mixed.scene.meshes[0].normals, [Vec3::Z, Vec3::Z, Vec3::Z, Vec3::X, Vec3::X, Vec3::X]);
}

#[test]
fn obj_smooth_normals_of_a_sphere_are_radial() {
    // Max 1999: exact for any triangulation of a sphere.
    let mut text = String::from("s 1\n");
    let (rings, sides) = (7, 9);
    for r in 0..=rings {
        for s in 0..sides {
            let (a, b) =
                (r as f32 / rings as f32 * 3.0 + 0.07, s as f32 / sides as f32 * std::f32::consts::TAU);
            text += &format!("v {} {} {}\n", a.sin() * b.cos(), a.cos(), a.sin() * b.sin());
        }
    }
    for r in 0..rings {
        for s in 0..sides {
            let (a, b) = (r * sides + s + 1, r * sides + (s + 1) % sides + 1);
            text += &format!("f {a} {b} {}\nf {a} {} {}\n", b + sides, b + sides, a + sides);
        }
    }
    let m = read("a.obj", text);
    let mesh = &m.scene.meshes[0];
    // Rings of the border have faces on one side only.
    let inner = mesh.positions.iter().zip(&mesh.normals).filter(|(p, _)| p.y.abs() < 0.9);
    let worst = inner.map(|(p, n)| 1.0 - p.normalize().dot(*n)).fold(0.0, f32::max);
    assert!(worst < 1e-5, "{worst}");
}

#[test]
fn obj_vertex_colours_are_srgb() {
    let m = read("a.obj", "v 0 0 0 1 0.5 0\nv 1 0 0 1 1 1\nv 0 1 0 0 0 0\nf 1 2 3\n");
    let c = m.scene.meshes[0].colors[0];
    assert!((c.y - 0.214_04).abs() < 1e-4 && c.x == 1.0, "{c}");
    assert_eq!(m.scene.materials[0].base_color, Vec3::ONE);
}

#[test]
fn obj_faults_name_the_line() {
    assert!(
        fail("a.obj", format!("{SQUARE}f 1 2 5\n"))
            .contains("a.obj: line 5: refers to position 5, but the file has 4")
    );
    assert!(fail("a.obj", format!("{SQUARE}f 1 2 0\n")).contains("line 5: an index is 0"));
    assert!(
        fail("a.obj", format!("{SQUARE}f 1 2 -5\n"))
            .contains("line 5: the index -5 is out of range: 4 stand before it")
    );
    assert!(fail("a.obj", "v 1 2 x\n").contains("line 1: `x` is not a number"));
    assert!(fail("a.obj", format!("{SQUARE}f 1 2\n")).contains("needs 3 corners"));
    assert!(fail("a.obj", format!("{SQUARE}f 1 2 3/4/5/6\n")).contains("no corner (v, v/vt"));
    let m = read("a.obj", format!("{SQUARE}mtllib none.mtl\nusemtl x\nf 1 2 3\ncurv 1 2\nfoo\nsurf 2 3\n"));
    let said = warnings(&m).join("\n");
    for part in [
        "line 8: free-form curves and surfaces are not supported; left out (and 1 more)",
        "line 9: `foo`",
        "line 5: the material library none.mtl",
        "the material `x` is not there",
    ] {
        assert!(said.contains(part), "{part}\n{said}");
    }
}

/// Lines are tubes, points are balls: twelve triangles for a ball and twenty-four for a tube, unlit; each once.
#[test]
fn obj_lines_and_points() {
    let m = read("a.obj", format!("{SQUARE}o wires\nl 1 2 3\nl 1 2\np 4 -1\no face\nf 1 2 3\n"));
    assert_eq!(warnings(&m), Vec::<String>::new());
    let s = &m.scene;
    assert_eq!(s.meshes.iter().map(|m| m.indices.len()).collect::<Vec<_>>(), [2 * 24 + 12, 1]);
    let unlit = |i: usize| s.materials[s.instances[i].material.unwrap() as usize].unlit;
    assert!(unlit(0) && !unlit(1) && s.meshes[0].name == "wires");
    // As long as the lines and as thick as 1/500 of what they span.
    let low = s.meshes[0].positions.iter().fold(Vec3::INFINITY, |a, p| a.min(*p));
    let high = s.meshes[0].positions.iter().fold(Vec3::NEG_INFINITY, |a, p| a.max(*p));
    let r = 2f32.sqrt() / 1000.0;
    assert!(
        (low - Vec3::new(-r, -r, -r)).length() < r && (high - Vec3::new(1.0 + r, 1.0 + r, r)).length() < r
    );
    // Nothing but positions: a cloud, with its colours.
    let m = read("a.obj", "v 0 0 0 1 0 0\nv 1 0 0 1 1 1\nv 0 1 0 0 0 0\n");
    let (mesh, material) = (&m.scene.meshes[0], &m.scene.materials[0]);
    assert_eq!(
        (mesh.indices.len(), mesh.colors.len(), mesh.colors[0]),
        (36, 24, Vec4::new(1.0, 0.0, 0.0, 1.0))
    );
    assert!(material.unlit && material.base_color == Vec3::ONE);
    assert!(fail("a.obj", format!("{SQUARE}l 1 5\n")).contains("refers to position 5"));
    let few =
        ImportOptions { limits: Limits { vertices: 20, ..Limits::default() }, ..ImportOptions::default() };
    let e = import_bytes(b"v 0 0 0\nv 1 0 0\nv 2 0 0\n", "a.obj", &few).unwrap_err().to_string();
    assert!(e.contains("more than 20 vertices"), "{e}");
}

/// Vertices without faces: balls, lit where they have normals.
#[test]
fn ply_clouds() {
    let head = |normals: &str| {
        format!(
            "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n{normals}property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n"
        )
    };
    let m = read("a.ply", head("") + "0 0 0 255 0 0\n1 2 2 0 0 255\n");
    assert_eq!(warnings(&m), Vec::<String>::new());
    let mesh = &m.scene.meshes[0];
    assert_eq!((mesh.indices.len(), mesh.positions.len(), mesh.normals.len()), (24, 16, 0));
    assert_eq!(
        (mesh.colors[0], mesh.colors[15]),
        (Vec4::new(1.0, 0.0, 0.0, 1.0), Vec4::new(0.0, 0.0, 1.0, 1.0))
    );
    assert!(m.scene.materials[0].unlit && m.scene.materials[0].base_color == Vec3::ONE);
    for p in &mesh.positions[8..] {
        assert!((p.distance(Vec3::new(1.0, 2.0, 2.0)) - 3.0 / 1000.0).abs() < 1e-5, "{p}");
    }
    let normals = "property float nx\nproperty float ny\nproperty float nz\n";
    let m = read("a.ply", head(normals) + "0 0 0 0 0 1 255 0 0\n1 2 2 0 0 1 0 0 255\n");
    assert!(!m.scene.materials[0].unlit && m.scene.materials.len() == 1);
    assert_eq!(m.scene.meshes[0].normals.len(), 16);
}

#[test]
fn obj_materials_with_pictures() {
    let dir = tempfile::tempdir().unwrap();
    let d = dir.path();
    file(
        d,
        "m.obj",
        format!(
            "mtllib sub/m.mtl\n{SQUARE}vt 0 0\nvt 1 0\nvt 1 1\nusemtl a\nf 1/1 2/2 3/3\nusemtl gold\nf 1 2 3\nusemtl glass\nf 1 2 3\nusemtl shiny\nf 1/1 2/2 3/3\n"
        ),
    );
    file(
        d,
        "sub/m.mtl",
        "newmtl a\nKd 0 0 0\nmap_Kd -s 2 2 -o 0.25 0.5 C:\\elsewhere\\color.png\nd 0.5\nmap_d alpha.png\nmap_Pr rough.png\nPm 0.25\nmap_Bump -bm 2 heights.png\nKe 2 0 0\nmap_Kd gone.png\nmap_Kd -s 2 2 -o 0.25 0.5 C:\\elsewhere\\color.png\nnewmtl gold\nKd 0 0 0\nKs 1 0.8 0.2\nillum 3\nNs 198\nnewmtl glass\nillum 7\nNi 1.4\nTf 0.5 1 1\nnewmtl shiny\nKs 0 0 0\nPs 0.5\nPc 1\nPcr 0.1\nmap_Ns gone.png\n",
    );
    file(d, "sub/color.png", png(1, 1, 3, &[255, 128, 0]));
    file(d, "alpha.png", png(2, 1, 1, &[0, 255]));
    file(d, "sub/rough.png", png(2, 2, 1, &[10, 20, 30, 40]));
    file(d, "sub/heights.png", png(2, 2, 1, &[0, 255, 0, 255]));
    let m = import(&d.join("m.obj"), &ImportOptions::default()).unwrap();
    let s = &m.scene;
    assert_eq!(warnings(&m).len(), 1, "{:?}", warnings(&m));
    assert!(warnings(&m)[0].contains("gone.png"));
    let a = &s.materials[0];
    assert_eq!((a.base_color, a.alpha, a.alpha_mode), (Vec3::ONE, 0.5, AlphaMode::Blend));
    let base = a.base_color_texture.unwrap();
    // (0, 0) at the bottom left is v = 1 here: 0 × 2 + 0.5 from the bottom is 0.5 from the top.
    assert_eq!(base.transform.transform_point2(Vec2::new(0.0, 1.0)), Vec2::new(0.25, 0.5));
    let image = |t: u32| &*s.images[s.textures[t as usize].image as usize];
    assert_eq!(
        (image(base.texture).width, image(base.texture).sample(0, 0, 3), image(base.texture).sample(1, 0, 3)),
        (2, 0.0, 1.0)
    );
    assert_eq!(image(base.texture).sample(1, 0, 1), 128.0 / 255.0);
    let rough = a.metallic_roughness_texture.unwrap();
    assert_eq!((image(rough.texture).sample(1, 1, 1) * 255.0, a.roughness, a.metallic), (40.0, 1.0, 0.25));
    assert!(a.normal_texture.is_some() && s.meshes[0].tangents.len() == 3);
    assert_eq!(a.emissive, Vec3::new(2.0, 0.0, 0.0));
    let gold = &s.materials[1];
    assert_eq!((gold.metallic, gold.base_color), (1.0, Vec3::new(1.0, 0.8, 0.2)));
    // (2 / 200)^¼
    assert!((gold.roughness - 0.316_23).abs() < 1e-4);
    let glass = &s.materials[2];
    let e = glass.extensions.as_ref().unwrap();
    assert!(
        e.transmission.unwrap().factor == 1.0
            && e.volume.is_some()
            && glass.ior == 1.4
            && glass.roughness == 0.0
    );
    assert_eq!(glass.base_color, Vec3::new(0.5, 1.0, 1.0));
    let shiny = s.materials[3].extensions.as_ref().unwrap();
    assert_eq!(
        (shiny.clearcoat.unwrap().roughness, shiny.sheen.unwrap().color, s.materials[3].specular),
        (0.1, Vec3::splat(0.5), 0.0)
    );
}

#[test]
fn obj_does_not_read_outside_its_folder() {
    let dir = tempfile::tempdir().unwrap();
    file(dir.path(), "in/m.obj", format!("mtllib ../m.mtl\n{SQUARE}usemtl a\nf 1 2 3\n"));
    file(dir.path(), "m.mtl", "newmtl a\nKd 1 0 0\n");
    let path = dir.path().join("in/m.obj");
    let m = import(&path, &ImportOptions::default()).unwrap();
    assert!(warnings(&m)[0].contains("outside"), "{:?}", warnings(&m));
    let limits = Limits { outside_folder: true, ..Limits::default() };
    let m = import(&path, &ImportOptions { limits, ..ImportOptions::default() }).unwrap();
    assert_eq!(m.scene.materials[0].base_color, Vec3::X);
}

/// The same shape as text and in both byte orders.
fn plys() -> [Vec<u8>; 3] {
    let header = |format: &str| {
        format!(
            "ply\nformat {format} 1.0\ncomment made by hand\nelement extra 1\nproperty list uchar short junk\nelement vertex 4\nproperty float x\nproperty double y\nproperty float z\nproperty float nx\nproperty float ny\nproperty float nz\nproperty float s\nproperty float t\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nelement face 1\nproperty uchar flag\nproperty list uchar int vertex_indices\nend_header\n"
        )
    };
    let points = [[0.0f32, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let mut text = header("ascii") + "2 7 8\n";
    for [x, y] in points {
        text += &format!("{x} {y} 0 0 0 1 {x} {y} 255 188 0\n");
    }
    text += "9 4 0 1 2 3\n";
    let binary = |big: bool| {
        let mut out = header(if big { "binary_big_endian" } else { "binary_little_endian" }).into_bytes();
        let mut put = |b: &mut [u8]| {
            if big {
                b.reverse();
            }
            out.extend_from_slice(b);
        };
        put(&mut [2]);
        put(&mut 7i16.to_le_bytes());
        put(&mut 8i16.to_le_bytes());
        for [x, y] in points {
            put(&mut x.to_le_bytes());
            put(&mut f64::from(y).to_le_bytes());
            for v in [0.0, 0.0, 0.0, 1.0, x, y] {
                put(&mut f32::to_le_bytes(v));
            }
            for c in [255, 188, 0] {
                put(&mut [c]);
            }
        }
        put(&mut [9]);
        put(&mut [4]);
        for i in 0..4i32 {
            put(&mut i.to_le_bytes());
        }
        out
    };
    [text.into_bytes(), binary(false), binary(true)]
}

#[test]
fn ply_in_its_three_forms() {
    for bytes in plys() {
        let m = read("no extension", &bytes);
        let mesh = &m.scene.meshes[0];
        assert_eq!(mesh.indices, [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(mesh.positions[2], Vec3::new(1.0, 1.0, 0.0));
        assert_eq!((mesh.normals[3], mesh.uvs[0][3]), (Vec3::Z, Vec2::new(0.0, 0.0)));
        assert!((mesh.colors[0].y - 0.502_886).abs() < 1e-4, "{}", mesh.colors[0]);
        assert_eq!(warnings(&m), Vec::<String>::new());
        assert_eq!(m.info.generator.as_deref(), Some("made by hand"));
        // Cut anywhere, an error and no panic. The last byte of the text is a line's end.
        for n in 0..bytes.len() - 1 {
            assert!(import_bytes(&bytes[..n], "a.ply", &ImportOptions::default()).is_err(), "{n}");
        }
    }
}

#[test]
fn ply_corners_and_faces_with_values_of_their_own() {
    let head = "ply\nformat ascii 1.0\ncomment TextureFile skin.png\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 2\nproperty list uchar int vertex_index\n";
    let points = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
    let dir = tempfile::tempdir().unwrap();
    file(dir.path(), "skin.png", png(1, 1, 3, &[1, 2, 3]));
    file(
        dir.path(),
        "a.ply",
        format!(
            "{head}property list uchar float texcoord\nend_header\n{points}3 0 1 2 6 0 0 1 0 1 1\n3 0 2 3 6 0 0 1 1 0.5 0.5\n"
        ),
    );
    let m = import(&dir.path().join("a.ply"), &ImportOptions::default()).unwrap();
    assert_eq!(m.scene.meshes[0].positions.len(), 4, "corners that agree are one vertex");
    assert_eq!(m.scene.meshes[0].uvs[0][3], Vec2::new(0.5, 0.5));
    assert!(m.scene.materials[0].base_color_texture.is_some() && m.warnings.is_empty());
    let colors = "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n";
    let m = read("a.ply", format!("{head}{colors}{points}3 0 1 2 255 0 0\n3 0 2 3 0 255 0\n"));
    assert_eq!(m.scene.meshes[0].positions.len(), 6);
    assert_eq!(m.scene.meshes[0].colors[5].truncate(), Vec3::Y);
    let m = read(
        "a.ply",
        "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\nelement tristrips 1\nproperty list int int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n2 2 2\n8 0 1 2 3 -1 1 2 4\n",
    );
    assert_eq!(m.scene.meshes[0].indices, [[0, 1, 2], [1, 3, 2], [1, 2, 4]]);
}

#[test]
fn ply_faults_name_the_place() {
    let text = String::from_utf8(plys()[0].clone()).unwrap();
    assert!(fail("a", text.replace("4 0 1 2 3", "4 0 1 2 4")).contains("uses vertex 4, but there are 4"));
    assert!(fail("a", text.replace("4 0 1 2 3", "4 0 1 x 3")).contains("a: line 27: `x` is not a number"));
    assert!(
        fail("a", text.replace("vertex 4", "vertex 4000000000"))
            .contains("4000000000 elements `vertex` announced")
    );
    assert!(fail("a", text.replace("9 4 0", "9 200 0")).contains("a list `vertex_indices` of 200 numbers"));
    assert!(fail("a", text.replace("double", "quad")).contains("line 8: `quad` is no type"));
    assert!(fail("a", text.replace("end_header", "end")).contains("`end` is not known"));
    let cloud = read("a", text.replace("element face 1", "element face 0").replace("9 4 0 1 2 3\n", ""));
    assert_eq!(cloud.scene.meshes[0].indices.len(), 4 * 12, "a cloud of points");
    // What is announced but not there takes no memory.
    let o = ImportOptions::default();
    let huge = "ply\nformat binary_little_endian 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\nelement face 18446744073709551615\nend_header\n";
    assert!(import_bytes(huge.as_bytes(), "a", &o).is_ok());
    assert!(
        import_bytes(huge.replace("end_", "property list uint int vertex_indices\nend_").as_bytes(), "a", &o)
            .is_err()
    );
}

#[test]
fn stl_in_both_forms_joins_corners() {
    let facet = |a: &str, b: &str, c: &str| {
        format!("facet normal 0 0 0\nouter loop\nvertex {a}\nvertex {b}\nvertex {c}\nendloop\nendfacet\n")
    };
    let text = format!(
        "solid one\n{}{}endsolid one\nsolid two\n{}endsolid\n",
        facet("0 0 0", "1 0 0", "1 1 0"),
        facet("0 0 -0", "1 1 0", "0 1 0"),
        facet("0 0 0", "1 0 0", "0 0 1e0")
    );
    let m = read("x", &text);
    assert_eq!(m.scene.meshes.len(), 2);
    assert_eq!((&m.scene.meshes[0].name[..], m.scene.meshes[0].positions.len()), ("one", 4));
    assert!(m.scene.meshes[0].normals.is_empty());
    let mut bytes = vec![0u8; 80];
    bytes[..9].copy_from_slice(b"solid not");
    bytes.extend(2u32.to_le_bytes());
    for t in [
        [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]],
        [[-0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]],
    ] {
        bytes.extend([0; 12]);
        bytes.extend(t.as_flattened().iter().flat_map(|v| v.to_le_bytes()));
        bytes.extend([0, 128]);
    }
    let b = read("x", &bytes);
    assert_eq!((b.scene.meshes[0].positions.len(), b.scene.meshes[0].indices.len()), (4, 2));
    assert!(warnings(&b)[0].contains("2 triangles have attribute bytes"));
    assert_eq!(b.info.format, "STL (binary)");
    let cut = fail("x.stl", &bytes[..150]);
    assert!(cut.contains("byte 80: 2 triangles announced, 1 present"), "{cut}");
    assert!(
        fail("x.stl", text.replace("vertex 1 1 0", "vertex 1 1"))
            .contains("line 6: a vertex needs 3 numbers")
    );
    assert!(fail("x.stl", &text.as_bytes()[..53]).contains("the file ends within a facet"));
    assert!(fail("x.stl", "").contains("ends within the header"));
}

#[test]
fn limits_hold_for_every_door() {
    let limits = Limits { vertices: 3, ..Limits::default() };
    let o = ImportOptions { limits, ..ImportOptions::default() };
    for (name, bytes) in
        [("a.obj", format!("{SQUARE}f 1 2 3 4\n").into_bytes()), ("a.ply", plys()[0].clone())]
    {
        match import_bytes(&bytes, name, &o) {
            Err(ImportError::TooLarge { limit: "vertices", .. }) => {}
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn files_of_other_programs() {
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/assets"));
    let mut seen = 0;
    for folder in [
        "scenes/luxcore-cornell",
        "reference/nori-pa4/cbox/meshes",
        "reference/nori-pa4/tests/meshes",
        "reference/mitsuba/scenes-cbox/meshes",
        "reference/mitsuba/participating_media/meshes",
    ] {
        let Ok(list) = fs::read_dir(root.join(folder)) else { continue };
        for path in list.flatten().map(|e| e.path()) {
            if !matches!(path.extension().and_then(|e| e.to_str()), Some("obj" | "ply" | "stl")) {
                continue;
            }
            let m = import(&path, &ImportOptions::default()).unwrap_or_else(|e| panic!("{e}"));
            assert!(m.scene.triangle_count() > 0, "{}", path.display());
            assert_eq!(m.scene.validate(), Ok(()));
            seen += 1;
        }
    }
    if seen == 0 {
        println!("skipped: {} is absent", root.display());
    }
}
