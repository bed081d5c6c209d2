//! What is said at the end of a run.

use super::output::{FRAME, TIME, count, peak_memory};
use super::progress::clock;
use super::say;
use super::work::Job;
use crate::render::{Film, World};
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// When the run began, and how long after that each part was done.
pub(crate) struct Times {
    pub started: Instant,
    pub loaded: Duration,
    pub built: Duration,
    pub rendered: Duration,
}

/// Prints the report: two lines for people, or one of JSON.
pub(crate) fn report(
    job: &Job,
    film: &Film,
    triangles: u64,
    warnings: &[String],
    times: &Times,
    finished: bool,
) {
    let total = times.started.elapsed().as_secs_f64();
    let load = times.loaded.as_secs_f64();
    let build = (times.built - times.loaded).as_secs_f64();
    let render = (times.rendered - times.built).as_secs_f64();
    let write = total - times.rendered.as_secs_f64();
    let load_counter = |c: &std::sync::atomic::AtomicU64| c.load(Ordering::Relaxed);
    let rays_per_second = job.counters.rays() as f64 / render.max(1e-9);
    let error = film.relative_error();
    if job.args.json {
        let mut mean = [0.0f64; 3];
        for p in film.beauty() {
            (0..3).for_each(|c| mean[c] += f64::from(p[c]) / film.pixels() as f64);
        }
        let mut report = serde_json::json!({
            "version": env!("CARGO_PKG_VERSION"),
            "output": job.output.to_string_lossy(),
            "film": job.explicit_film.as_ref().map(|f| f.to_string_lossy()),
            "picture": job.info.picture,
            "finished": finished,
            "width": film.width,
            "height": film.height,
            "samples": film.samples(),
            "seed": job.args.seed,
            "seconds": { "load": load, "build": build, "render": render, "write": write, "total": total },
            "triangles": triangles,
            "lights": job.shot.world().map_or(0, World::light_count),
            "threads": rayon::current_num_threads(),
            "rays": {
                "closest": load_counter(&job.counters.closest_rays),
                "any": load_counter(&job.counters.any_rays),
            },
            "rays_per_second": rays_per_second,
            "paths_per_second": load_counter(&job.counters.samples) as f64 / render.max(1e-9),
            "relative_error": error.is_finite().then_some(error),
            "mean": mean,
            "rejected_samples": film.rejected,
            "peak_memory_bytes": peak_memory(),
            "warnings": warnings,
        });
        for (key, name) in [("frame", FRAME), ("time", TIME)] {
            if let Some(v) = job.info.notes.get(name) {
                report[key] = v.parse::<f64>().map_or(serde_json::Value::Null, Into::into);
            }
        }
        say(&report.to_string());
        return;
    }
    if job.args.quiet {
        return;
    }
    let estimate = if error.is_finite() { format!(", error {:.2} %", error * 100.0) } else { String::new() };
    let mut text = format!(
        "{}: {} × {}, {} samples{estimate}\n{}: load {}, build {}, render {}, write {}; {}rays/s",
        job.output.display(),
        film.width,
        film.height,
        film.samples(),
        clock(total),
        clock(load),
        clock(build),
        clock(render),
        clock(write),
        count(rays_per_second),
    );
    if film.rejected > 0 {
        text +=
            &format!("\n{} samples were not numbers and count as black: please report this", film.rejected);
    }
    say(&text);
}
