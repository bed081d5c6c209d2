//! The report on a model: its figures hang together.

use etendue_image::{DEFAULT_PPD, Development};
use etendue_lab::compare::{Against, Job, ModelReport, model_report};
use etendue_realtime::Choices;
use etendue_render::{Filter, Settings, World};
use etendue_scene::{Camera, Environment, Instance, Light, LightKind, Material, Mesh, Scene};
use glam::{Affine3A, Vec3};

fn add(scene: &mut Scene, mesh: Mesh, material: Material) {
    scene.materials.push(material);
    scene.meshes.push(mesh.into());
    scene.instances.push(Instance {
        name: String::new(),
        mesh: scene.meshes.len() as u32 - 1,
        material: Some(scene.materials.len() as u32 - 1),
        transform: Affine3A::IDENTITY,
    });
}

/// A floor and a block that stands on it.
fn yard() -> World {
    let mut s = Scene { environment: Environment::Constant(Vec3::new(0.4, 0.5, 0.6)), ..Scene::default() };
    s.lights.push(Light {
        name: String::new(),
        kind: LightKind::Directional,
        position: Vec3::ZERO,
        direction: Vec3::new(-0.6, -1.0, -0.3).normalize(),
        intensity: Vec3::splat(2.0),
        range: None,
    });
    let quad = |a: Vec3, u: Vec3, v: Vec3| Mesh {
        positions: vec![a, a + u, a + u + v, a + v],
        indices: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    };
    let matte = |c: Vec3| Material {
        base_color: c,
        metallic: 0.0,
        roughness: 0.6,
        double_sided: true,
        ..Material::default()
    };
    add(&mut s, quad(Vec3::new(-2.0, 0.0, 2.0), Vec3::X * 4.0, Vec3::Z * -4.0), matte(Vec3::splat(0.7)));
    add(&mut s, quad(Vec3::new(-0.5, 0.0, 0.2), Vec3::X, Vec3::Y), matte(Vec3::new(0.8, 0.3, 0.2)));
    let lamp = Material { emissive: Vec3::splat(0.8), ..matte(Vec3::ZERO) };
    add(&mut s, quad(Vec3::new(0.9, 0.0, 0.5), Vec3::X * 0.4, Vec3::Y * 0.4), lamp);
    World::new(s).expect("a sound scene")
}

fn report(keys: &[&str]) -> ModelReport {
    let world = yard();
    let ablate = |key: &str| keys.contains(&key);
    let job = Job {
        world: &world,
        camera: Camera::look_at(Vec3::new(0.3, 1.4, 3.4), Vec3::new(0.0, 0.3, 0.0), Vec3::Y, 0.8),
        settings: Settings { width: 40, height: 32, filter: Filter::Box, ..Settings::default() },
        choices: Choices::default(),
        samples: 32,
        twin_samples: 32,
        ablation_samples: 2,
        presets: false,
        ablate: &ablate,
        development: Development::default(),
        pixels_per_degree: DEFAULT_PPD,
    };
    model_report(&job, &|_, _| ()).expect("a sound sky")
}

#[test]
fn figures_hang_together() {
    let r = report(&["diffuse-coupling", "area-lights", "occlusion"]);
    assert_eq!(r.rejected, 0);
    // The terms' errors add up to the picture's.
    for c in 0..3 {
        let sum: f64 = r.terms.iter().map(|t| t.model[c] - t.reference[c]).sum();
        assert!((sum - r.shading.light.bias[c]).abs() < 2e-6, "{sum} {:?}", r.shading.light.bias);
    }
    // What the model cannot know is what lies between the two references.
    let means = [Against::Whole, Against::LightOnly].map(|a| r.side(a).light.bias);
    let change: f64 = r.unknowns.iter().map(|u| u.change[1]).sum();
    // bias = model − reference; the model's two pictures differ by its shadows alone.
    assert!(change < 0.0 && means[0][1] > means[1][1] - 1e-3, "{change} {means:?}");
    let effect = |name: &str| r.unknowns.iter().find(|u| u.name == name).expect("listed");
    assert!(effect("shadows").change[1] < -1e-3 && effect("occlusion of the sky").change[1] < -1e-3);
    assert!(effect("interreflection").change[1] > 1e-3 && effect("the way through").effect == 0.0);

    let term = |name: &str| r.terms.iter().find(|t| t.name == name).expect("listed");
    // The same rays see the same sky and the same lamp.
    for name in ["environment", "emission"] {
        let t = term(name);
        assert!(t.reference[1] > 1e-3 && t.rmse < 1e-6 && t.effect < 1e-3, "{name}: {t:?}");
    }
    // The reference draws between the sun and the lamp, which lights nothing here: it has noise, and the same mean.
    let sun = term("direct diffuse");
    assert!((sun.model[1] - sun.reference[1]).abs() < 0.03 * sun.reference[1], "{sun:?}");
    assert!(term("transmission").is_absent());
    // Under an even sky and without shadows the shading is nearly the truth; the picture is not.
    println!("FLIP {} {} noise {}", r.shading.flip.mean, r.whole.flip.mean, r.shading.noise);
    assert!(r.shading.flip.mean < 0.02 + r.shading.noise, "{}", r.shading.flip.mean);
    assert!(r.whole.flip.mean > r.shading.flip.mean && r.shading.noise < 0.05);

    // Keys in turn, each beside its base; what cannot matter does not.
    let rows = |key: &str| r.ablations.iter().filter(|v| v.key == key).collect::<Vec<_>>();
    assert!(!rows("diffuse-coupling").is_empty() && rows("area-lights").iter().all(|v| v.no_effect));
    assert!(rows("occlusion").iter().all(|v| v.against == Against::Whole && v.base == 1));
    let whole = rows("diffuse-coupling").into_iter().find(|v| v.value == "whole").expect("a choice");
    assert!(whole.flip > r.ablations[whole.base].flip, "light from nothing is an error");
}

#[test]
fn page_and_json_say_the_same() {
    let mut r = report(&[]);
    r.title = "yard <1>".into();
    assert!(r.passes() && r.ablations.is_empty());
    r.max_flip = Some((0.0, Against::Whole));
    assert!(!r.passes());
    let json: serde_json::Value = serde_json::from_str(&r.to_json().to_string()).expect("JSON");
    // Reading numbers may lose the last bit.
    let mean = json["whole"]["flip"]["mean"].as_f64().expect("a number");
    assert!((mean - r.whole.flip.mean).abs() < 1e-12, "{mean} {}", r.whole.flip.mean);
    assert_eq!((&json["kind"], &json["passes"]), (&"model".into(), &false.into()));
    assert_eq!(json["terms"].as_array().map(Vec::len), Some(7));
    let page = r.to_html();
    assert!(page.contains("yard &lt;1&gt;") && page.contains("indirect specular") && page.contains("Fails"));
    assert!(!page.contains("http") && page.contains("data:image/png;base64,"));
    for needed in ["data-name=\"the picture\"", "data-name=\"the shading\"", "data-open=\"direct diffuse\""] {
        assert!(page.contains(needed), "{needed}");
    }
}
