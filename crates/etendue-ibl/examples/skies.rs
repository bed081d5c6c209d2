//! How far the baked forms of real skies are from the integrals: harmonics with and without window, and each mip of the prefiltered cube.
//!
//! `cargo run --release -p etendue-ibl --example skies -- FOLDER|FILE... [--mips]`
//!
//! For each sky: mean and worst relative error of SH9's irradiance over 400 directions (in units of the mean irradiance), its least value, both
//! undamped and with the automatic window; with `--mips` the relMSE of each mip at 200 random texels against the direct sum over all texels, and
//! the largest ratio of a texel to it.

use etendue_ibl::{
    CubeLookup, ExactIrradiance, ExactPrefilter, PrefilterOptions, Sh9, SkyMap, Window, bake::source_size,
    prefilter, to_cube,
};
use etendue_image::read_environment;
use etendue_scene::Environment;
use glam::{Vec3, Vec3A};
use std::path::{Path, PathBuf};
use std::sync::Arc;

fn directions(n: usize) -> impl Iterator<Item = Vec3> {
    (0..n).map(move |i| {
        let z = 1.0 - 2.0 * (i as f32 + 0.5) / n as f32;
        let (r, phi) = ((1.0 - z * z).sqrt(), i as f32 * 2.399_963);
        Vec3::new(r * phi.cos(), r * phi.sin(), z)
    })
}

fn harmonics(name: &str, sky: &SkyMap) {
    let (raw, exact) = (Sh9::project(sky), ExactIrradiance::new(sky));
    let damped = Window::Auto.apply(&raw);
    let want: Vec<f32> = directions(400).map(|n| exact.at(n).luminance()).collect();
    let mean = want.iter().sum::<f32>() / want.len() as f32;
    let figures = |sh: &Sh9| {
        let (mut sum, mut worst, mut least) = (0.0f32, 0.0f32, f32::INFINITY);
        for (n, w) in directions(400).zip(&want) {
            let e = sh.irradiance(n);
            let error = (e.luminance() - w).abs() / mean;
            sum += error;
            worst = worst.max(error);
            least = least.min(e.to_rgb().into_iter().fold(f32::INFINITY, f32::min) / mean);
        }
        format!("{:6.3} % {:6.2} % {least:7.3}", 100.0 * sum / 400.0, 100.0 * worst)
    };
    let f = Window::Auto.factors(&raw);
    println!("{name:<34} {}    {}    {:.3} {:.3}", figures(&raw), figures(&damped), f[1], f[2]);
}

fn mips(sky: &SkyMap) {
    let options = PrefilterOptions::default();
    let source = CubeLookup::new(&to_cube(sky, source_size(sky.height(), options.size)).with_mips());
    let cube = prefilter(&source, &options, &|_| ());
    let exact = ExactPrefilter::new(sky, 1);
    let mut line = String::new();
    for mip in 1..cube.mip_count() {
        let n = cube.mip_size(mip);
        let roughness = options.mapping.roughness(mip as u32, options.steps);
        let (mut error, mut ratio) = (0.0f64, 0.0f32);
        for i in 0..200u64 {
            let texel = (i.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 33) as u32 % (6 * n * n);
            let c = |v| etendue_ibl::cube::texel_centre(v, n);
            let d =
                etendue_ibl::cube::face_direction((texel / (n * n)) as usize, c(texel % n), c(texel / n % n));
            let want = exact.at(Vec3A::normalize(d), roughness, options.kernel);
            let got = cube.mip(mip)[texel as usize];
            for k in 0..3 {
                error += f64::from((got[k] - want[k]) / (want[k] + 0.01)).powi(2) / 600.0;
                ratio = ratio.max(got[k] / (want[k] + 0.01));
            }
        }
        line += &format!("  r {roughness:.2}: {error:.1e} (≤ ×{ratio:.2})");
    }
    println!("    relMSE{line}");
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut files: Vec<PathBuf> = Vec::new();
    let mut with_mips = false;
    for arg in std::env::args().skip(1) {
        let path = Path::new(&arg);
        if arg == "--mips" {
            with_mips = true;
        } else if path.is_dir() {
            let inside = std::fs::read_dir(path)?.filter_map(|e| e.ok().map(|e| e.path()));
            files.extend(inside.filter(|p| p.extension().is_some_and(|e| e == "hdr" || e == "exr")));
        } else {
            files.push(path.to_path_buf());
        }
    }
    files.sort();
    println!("{:<34} undamped: mean, worst, least    automatic window: mean, worst, least    factors", "sky");
    for file in files {
        let image = Arc::new(read_environment(&file)?.image);
        let sky = SkyMap::new(&Environment::LatLong { image, rotation: 0.0, intensity: 1.0 })?;
        harmonics(&file.file_name().unwrap_or_default().to_string_lossy(), &sky);
        if with_mips {
            mips(&sky);
        }
    }
    Ok(())
}
