//! `etendue bench`: how fast, on fixed scenes. It prints figures; nothing here passes or fails.

use super::args::BenchArgs;
use super::bench_models::{self, Cost};
use super::bench_scenes::{BenchScene, all};
use super::output::{count, peak_memory};
use super::{CliError, say};
use crate::render::{Counters, Film, Renderer, Sampler, Settings, World};
use crate::trace::Ray;
use glam::Vec3A;
use rayon::prelude::*;
use serde_json::{Value, json};
use std::f32::consts::TAU;
use std::time::Instant;

/// Side of the square of camera rays.
const SIDE: u32 = 512;

pub(crate) fn run(args: &BenchArgs) -> Result<(), CliError> {
    let filter = args.filter.as_deref().unwrap_or("");
    let scenes = all(filter)?;
    let costs = models(filter, f64::from(args.seconds), args.json);
    if scenes.is_empty() && costs.is_empty() {
        return Err(CliError::Usage(
            "no scene or model has that name; there are helmet, room, soup, lights, forest, models and each model".into(),
        ));
    }
    let mut report = Vec::new();
    for scene in scenes {
        let name = scene.name;
        let row = measure(scene, f64::from(args.seconds), args.json)?;
        report.push(json!({ "scene": name, "figures": row }));
    }
    let memory = peak_memory();
    if args.json {
        say(&json!({ "threads": rayon::current_num_threads(), "scenes": report, "models": costs, "peak_memory_bytes": memory }).to_string());
    } else if let Some(m) = memory {
        say(&format!("\npeak memory {} MiB", m >> 20));
    }
    Ok(())
}

/// The models' costs: all of them for `models` or no filter.
fn models(filter: &str, seconds: f64, quiet: bool) -> Vec<Cost> {
    let filter = if filter == "models" { "" } else { filter };
    // A tenth: there are many, and each call takes little.
    let costs = bench_models::measure(filter, seconds * 0.1);
    if !quiet && !costs.is_empty() {
        say("\nmodels, one thread, over random parameters   closure   eval+pdf     sample      bytes");
        for c in &costs {
            let row =
                format!("{:>7.1} ns {:>7.1} ns {:>7.1} ns {:>10}", c.closure, c.eval_pdf, c.sample, c.bytes);
            say(&format!("  {:<42}{row}", c.model));
        }
    }
    costs
}

fn measure(mut b: BenchScene, seconds: f64, quiet: bool) -> Result<Value, CliError> {
    let print = |text: &str| {
        if !quiet {
            say(text);
        }
    };
    let triangles = b.scene.triangle_count();
    let world = World::new(std::mem::take(&mut b.scene))?;
    print(&format!(
        "\n{} ({}): {} triangles, {} lights",
        b.name,
        b.what,
        count(triangles as f64),
        world.light_count()
    ));
    let build = world.accel_seconds();
    let memory = world.accel().bytes();
    print(&format!(
        "  build {build:.3} s, lights and layout {:.3} s; tree {} MiB",
        world.light_seconds(),
        memory >> 20
    ));

    let sets = RaySets::new(&world, &b.camera);
    let mut rays = serde_json::Map::new();
    for (name, any, set) in [
        ("closest, coherent", false, &sets.primary),
        ("closest, incoherent", false, &sets.bounce),
        ("any, coherent", true, &sets.shadow),
        ("any, incoherent", true, &sets.bounce),
    ] {
        let one = rate(seconds * 0.5, || trace(&world, set, any)) * set.len() as f64;
        let all = rate(seconds * 0.5, || set.par_chunks(1 << 12).map(|c| trace(&world, c, any)).sum())
            * set.len() as f64;
        print(&format!("  {name:<20} {:>10}rays/s on 1 thread, {:>10}rays/s on all", count(one), count(all)));
        rays.insert(name.into(), json!({ "one": one, "all": all }));
    }

    let (samples, relvar) = to_equal_error(&world, &b, seconds);
    print(&format!(
        "  path tracing         {:>10}samples/s; relvar × seconds {:.3e} at 512 × 512",
        count(samples),
        relvar
    ));
    Ok(json!({
        "triangles": triangles, "lights": world.light_count(), "build_seconds": build, "tree_bytes": memory,
        "rays_per_second": rays, "samples_per_second": samples, "relvar_seconds": relvar,
    }))
}

/// Ray sets of a camera: its own rays, uniformly random ones from what they hit, and those from there to one far point.
struct RaySets {
    primary: Vec<Ray>,
    bounce: Vec<Ray>,
    shadow: Vec<Ray>,
}

impl RaySets {
    fn new(world: &World, camera: &crate::scene::Camera) -> Self {
        let bounds = world.accel().bounds();
        let lamp = bounds.center() + Vec3A::new(0.1, 0.45, 0.15) * (bounds.max - bounds.min);
        let rays = camera.rays(1.0);
        let mut sets = Self { primary: Vec::new(), bounce: Vec::new(), shadow: Vec::new() };
        for i in 0..SIDE * SIDE {
            let [a, b, c, d] = Sampler::new(1, i % SIDE, i / SIDE, 0).get4(0);
            let at = |p: u32, u: f32| (p as f32 + u) / SIDE as f32 * 2.0 - 1.0;
            let (origin, direction) = rays.ray([at(i % SIDE, a), -at(i / SIDE, b)]);
            let ray = Ray::new(origin, direction);
            sets.primary.push(ray);
            if let Some(hit) = world.accel().closest(&ray, &|_, _, _, _| true) {
                // A little before the surface, on the side that was seen.
                let from = origin + direction * (hit.t * (1.0 - 1e-4));
                let (z, phi) = (1.0 - 2.0 * c, TAU * d);
                let r = (1.0 - z * z).max(0.0).sqrt();
                sets.bounce.push(Ray::new(from, Vec3A::new(r * phi.cos(), r * phi.sin(), z)));
                sets.shadow.push(Ray { t_max: 1.0, ..Ray::new(from, lamp - from) });
            }
        }
        sets
    }
}

fn trace(world: &World, rays: &[Ray], any: bool) -> u64 {
    let accept = |_, _, _, _| true;
    let hit = |r: &&Ray| {
        if any { world.accel().any(r, &accept) } else { world.accel().closest(r, &accept).is_some() }
    };
    rays.iter().filter(hit).count() as u64
}

/// Runs per second of `work`, the best of the repetitions that fit into `seconds`.
fn rate(seconds: f64, mut work: impl FnMut() -> u64) -> f64 {
    let begun = Instant::now();
    let mut best = f64::INFINITY;
    let mut hits = 0;
    while best.is_infinite() || begun.elapsed().as_secs_f64() < seconds {
        let start = Instant::now();
        hits += work();
        best = best.min(start.elapsed().as_secs_f64());
    }
    std::hint::black_box(hits);
    1.0 / best
}

/// Samples per second, and variance × time: two renders with different seeds, as `bench/peers.py` does for other programs;
/// relvar = mean of ((a − b)² / 2) / (((a + b) / 2)² + 0.01) over pixels and channels.
fn to_equal_error(world: &World, b: &BenchScene, seconds: f64) -> (f64, f64) {
    let settings = Settings { filter: crate::render::Filter::Box, ..Settings::default() };
    let pixels = f64::from(settings.width * settings.height);
    let render = |seed: u32, n: u32| -> (Film, f64) {
        let r = Renderer::new(world, b.camera.clone(), Settings { seed, ..settings.clone() });
        let mut film = r.film();
        let start = Instant::now();
        r.render(&mut film, 0, n, &Counters::default());
        (film, start.elapsed().as_secs_f64())
    };
    let (_, one) = render(9, 1);
    let n = ((seconds * 0.5 / one) as u32).clamp(2, 1024).next_power_of_two() / 2;
    let n = n.max(2);
    let ((x, tx), (y, ty)) = (render(1, n), render(2, n));
    let mut relvar = 0.0;
    for (p, q) in x.beauty().iter().zip(y.beauty()) {
        for c in 0..3 {
            let (d, m) = (f64::from(p[c] - q[c]), f64::from(p[c] + q[c]) * 0.5);
            relvar += d * d * 0.5 / (m * m + 0.01) / (3.0 * pixels);
        }
    }
    let time = (tx + ty) * 0.5;
    (f64::from(n) * pixels / time, relvar * time)
}
