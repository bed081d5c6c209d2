//! Time and error of a bake at each halving of its samples, on one thread.
//!
//! `cargo run --release -p etendue-ibl --example bake_speed -- SKY`
//!
//! 256² faces, all mips, harmonics, irradiance cube and a 64² table; the error is the relMSE of all rough mips against a bake of 16384 samples at the same
//! resolution of the source (so of sampling alone) and, in the second column, against the direct sum at 100 texels of the first two rough mips.

use etendue_ibl::{
    BakeOptions, CubeMap, DfgMethod, DfgTable, ExactPrefilter, PrefilterOptions, SkyMap, bake, cube,
};
use etendue_image::read_environment;
use etendue_scene::Environment;
use std::sync::Arc;
use std::time::Instant;

fn rel_mse(a: &CubeMap, b: &CubeMap) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for mip in 1..a.mip_count() {
        for (x, y) in a.mip(mip).iter().zip(b.mip(mip)) {
            for c in 0..3 {
                sum += f64::from((x[c] - y[c]) / (y[c] + 0.01)).powi(2);
                count += 1.0;
            }
        }
    }
    sum / count
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let file = std::env::args().nth(1).ok_or("give a sky")?;
    let image = Arc::new(read_environment(file.as_ref())?.image);
    let sky = SkyMap::new(&Environment::LatLong { image, rotation: 0.0, intensity: 1.0 })?;
    let options = |samples| BakeOptions {
        prefilter: PrefilterOptions { samples, ..Default::default() },
        ..Default::default()
    };
    let reference = bake(&sky, &options(16384), &|_| ());
    let exact = ExactPrefilter::new(&sky, 1);
    let wanted: Vec<_> = (0..100u64)
        .map(|i| {
            let mip = 1 + (i % 2) as usize;
            let n = reference.specular.mip_size(mip);
            let texel = (i.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 33) as u32 % (6 * n * n);
            let c = |v| cube::texel_centre(v, n);
            let d =
                cube::face_direction((texel / (n * n)) as usize, c(texel % n), c(texel / n % n)).normalize();
            (mip, texel as usize, exact.at(d, reference.roughness[mip], Default::default()))
        })
        .collect();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    println!("samples   seconds   relMSE to 16384 samples   relMSE to the integral");
    let mut samples = 1024;
    while samples >= 16 {
        let start = Instant::now();
        let baked = pool.install(|| {
            let table = DfgTable::new(64, DfgMethod::Sampled(4096));
            std::hint::black_box(table);
            bake(&sky, &options(samples), &|_| ())
        });
        let seconds = start.elapsed().as_secs_f64();
        let mut direct = 0.0;
        for (mip, texel, want) in &wanted {
            let got = baked.specular.mip(*mip)[*texel];
            for c in 0..3 {
                direct += f64::from((got[c] - want[c]) / (want[c] + 0.01)).powi(2) / 300.0;
            }
        }
        println!(
            "{samples:>7} {seconds:>9.2} {:>25.1e} {direct:>24.1e}",
            rel_mse(&baked.specular, &reference.specular)
        );
        samples /= 2;
    }
    Ok(())
}
