//! The committed files are what the generator makes, and they are fit for their purpose.
//!
//! Byte equality is what a run on one machine gives. The formulas use the platform's sine, exponential and logarithm, whose
//! last bits differ between C libraries, so the law checked here is a little wider: the same structure, geometry within
//! 10 µm, pictures within a level and a half on average, the sky within 1 %. Whether the bytes were equal is printed.

use serde_json::Value;
use std::path::PathBuf;
use std::sync::OnceLock;

fn committed(name: &str) -> Vec<u8> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../etendue/assets").join(name);
    std::fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

fn generated() -> &'static Vec<u8> {
    static ONCE: OnceLock<Vec<u8>> = OnceLock::new();
    ONCE.get_or_init(etendue_builtin::helmet)
}

/// A parsed `.glb`.
struct Glb {
    doc: Value,
    bin: Vec<u8>,
}

impl Glb {
    fn new(file: &[u8]) -> Self {
        let word = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().expect("four bytes")) as usize;
        assert_eq!(&file[..4], b"glTF");
        assert_eq!(word(8), file.len());
        let json = word(12);
        let doc = serde_json::from_slice(&file[20..20 + json]).expect("JSON chunk");
        assert_eq!(word(20 + json) + 28 + json, file.len());
        Self { doc, bin: file[28 + json..].to_vec() }
    }

    fn list(&self, key: &str) -> &Vec<Value> {
        self.doc[key].as_array().expect(key)
    }

    fn view(&self, index: &Value) -> &[u8] {
        let v = &self.list("bufferViews")[index.as_u64().expect("index") as usize];
        let at = v["byteOffset"].as_u64().expect("offset") as usize;
        &self.bin[at..at + v["byteLength"].as_u64().expect("length") as usize]
    }

    fn floats(&self, accessor: &Value) -> Vec<f32> {
        let a = &self.list("accessors")[accessor.as_u64().expect("index") as usize];
        assert_eq!(a["componentType"], 5126);
        let raw = self.view(&a["bufferView"]);
        raw.chunks_exact(4).map(|b| f32::from_le_bytes(b.try_into().expect("four bytes"))).collect()
    }

    fn indices(&self, accessor: &Value) -> Vec<usize> {
        let a = &self.list("accessors")[accessor.as_u64().expect("index") as usize];
        let raw = self.view(&a["bufferView"]);
        raw.chunks_exact(2).map(|b| u16::from_le_bytes([b[0], b[1]]) as usize).collect()
    }

    fn primitives(&self) -> impl Iterator<Item = (&str, &Value)> {
        self.list("meshes").iter().flat_map(|m| {
            let name = m["name"].as_str().expect("name");
            m["primitives"].as_array().expect("primitives").iter().map(move |p| (name, p))
        })
    }

    fn names(&self, key: &str) -> Vec<&str> {
        self.list(key).iter().map(|v| v["name"].as_str().expect("name")).collect()
    }
}

fn pictures(g: &Glb) -> Vec<image::RgbImage> {
    g.list("images")
        .iter()
        .map(|i| image::load_from_memory(g.view(&i["bufferView"])).expect("a picture").to_rgb8())
        .collect()
}

#[test]
fn helmet_is_what_the_generator_makes() {
    let (old, new) = (committed("helmet.glb"), generated());
    println!("helmet.glb: bytes {}", if old == *new { "equal" } else { "differ" });
    let (old, new) = (Glb::new(&old), Glb::new(new));
    for key in ["nodes", "meshes", "materials", "textures"] {
        assert_eq!(old.names(key), new.names(key), "{key}");
    }
    for ((name, a), (_, b)) in old.primitives().zip(new.primitives()) {
        assert_eq!(old.indices(&a["indices"]).len(), new.indices(&b["indices"]).len(), "{name}");
        for (attribute, within) in [("POSITION", 1e-5), ("NORMAL", 2e-3), ("TEXCOORD_0", 1e-4)] {
            let p = old.floats(&a["attributes"][attribute]);
            let q = new.floats(&b["attributes"][attribute]);
            assert_eq!(p.len(), q.len(), "{name} {attribute}");
            let worst = p.iter().zip(&q).map(|(x, y)| (x - y).abs()).fold(0.0f32, f32::max);
            assert!(worst <= within, "{name} {attribute}: {worst}");
        }
    }
    for ((a, b), name) in pictures(&old).iter().zip(&pictures(&new)).zip(old.names("images")) {
        assert_eq!(a.dimensions(), b.dimensions(), "{name}");
        let sum: u64 = a.as_raw().iter().zip(b.as_raw()).map(|(x, y)| x.abs_diff(*y) as u64).sum();
        let mean = sum as f64 / a.as_raw().len() as f64;
        assert!(mean < 1.5, "{name}: {mean} levels apart on average");
    }
}

#[test]
fn helmet_is_small_and_whole() {
    let file = committed("helmet.glb");
    assert!(file.len() <= 3_000_000, "{} bytes", file.len());
    let g = Glb::new(&file);
    for name in ["visor", "shell", "strap", "rim"] {
        for key in ["nodes", "meshes", "materials"] {
            assert!(g.names(key).contains(&name), "{name} among {key}");
        }
    }
    let textured = |slot: &str| g.list("materials").iter().any(|m| m[slot].is_object());
    assert!(textured("normalTexture") && textured("occlusionTexture") && textured("emissiveTexture"));

    let drawn: usize = g
        .list("nodes")
        .iter()
        .filter_map(|n| n["mesh"].as_u64())
        .flat_map(|m| g.list("meshes")[m as usize]["primitives"].as_array().expect("primitives"))
        .map(|p| g.indices(&p["indices"]).len() / 3)
        .sum();
    println!("triangles with instances: {drawn}");
    assert!((15_000..=45_000).contains(&drawn), "{drawn} triangles");
}

#[test]
fn surfaces_face_outward_and_carry_sound_attributes() {
    let g = Glb::new(&committed("helmet.glb"));
    for (name, p) in g.primitives() {
        let at = |a: &str, n: usize| -> Vec<Vec<f32>> {
            g.floats(&p["attributes"][a]).chunks_exact(n).map(<[f32]>::to_vec).collect()
        };
        let (pos, nrm) = (at("POSITION", 3), at("NORMAL", 3));
        for n in &nrm {
            let length = n.iter().map(|c| c * c).sum::<f32>().sqrt();
            assert!((length - 1.0).abs() < 1e-4, "{name}: a normal of length {length}");
        }
        if p["attributes"]["TANGENT"].is_u64() {
            for (n, t) in nrm.iter().zip(&at("TANGENT", 4)) {
                let dot: f32 = n.iter().zip(t).map(|(a, b)| a * b).sum();
                assert!(dot.abs() < 1e-3 && t[3].abs() == 1.0, "{name}: tangent {t:?} on normal {n:?}");
            }
        }
        let (mut against, mut count) = (0, 0);
        for t in g.indices(&p["indices"]).chunks_exact(3) {
            let [a, b, c] = [0, 1, 2].map(|k| glam::Vec3::from_slice(&pos[t[k]]));
            let face = (b - a).cross(c - a);
            assert!(face.length() > 0.0, "{name}: a triangle without area");
            let sum: glam::Vec3 = t.iter().map(|k| glam::Vec3::from_slice(&nrm[*k])).sum();
            against += (face.dot(sum) <= 0.0) as u32;
            count += 1;
        }
        assert_eq!(against, 0, "{name}: of {count} triangles");
    }
}

/// Width, height and light of a Radiance file.
fn radiance(file: &[u8]) -> (usize, usize, Vec<[f64; 3]>) {
    let sky = etendue_image::decode_environment(file, &Default::default()).expect("a Radiance file").image;
    let etendue_image::Pixels::F32(p) = &sky.pixels else { panic!("light is floats") };
    let light = p.chunks_exact(3).map(|c| [c[0], c[1], c[2]].map(f64::from)).collect();
    (sky.width as usize, sky.height as usize, light)
}

#[test]
fn studio_is_what_the_generator_makes() {
    let (old, new) = (committed("studio.hdr"), etendue_builtin::studio());
    println!("studio.hdr: bytes {}", if old == new { "equal" } else { "differ" });
    let ((w, h, a), (w2, h2, b)) = (radiance(&old), radiance(&new));
    assert_eq!((w, h), (512, 256));
    assert_eq!((w, h), (w2, h2));
    for (p, q) in a.iter().zip(&b) {
        let (p, q) = (*p, *q);
        let largest = p.iter().chain(&q).fold(0.0f64, |m, v| m.max(*v));
        for c in 0..3 {
            assert!((p[c] - q[c]).abs() <= 0.01 * largest + 1e-6, "{p:?} and {q:?}");
        }
    }
}

#[test]
fn studio_lights_without_glare() {
    let file = committed("studio.hdr");
    assert!(file.len() <= 500_000, "{} bytes", file.len());
    let (_, _, pixels) = radiance(&file);
    let peak = pixels.iter().flatten().copied().fold(0.0f64, f64::max);
    assert!((10.0..60.0).contains(&peak), "peak radiance {peak}");
    assert!(pixels.iter().all(|p| p.iter().all(|c| *c > 0.0)), "no direction is black");
}
