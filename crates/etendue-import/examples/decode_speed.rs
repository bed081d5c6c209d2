//! Time to import models: `cargo run --release -p etendue-import --example decode_speed FILE…`
//!
//! Each file is imported several times; the fastest counts.
use etendue_import::{ImportOptions, import};
use std::time::Instant;

fn main() {
    for file in std::env::args().skip(1) {
        let mut best = f64::INFINITY;
        let mut said = String::new();
        for _ in 0..7 {
            let start = Instant::now();
            match import(file.as_ref(), &ImportOptions::default()) {
                Ok(i) => {
                    best = best.min(start.elapsed().as_secs_f64());
                    let c = &i.info.counts;
                    said = format!(
                        "{} bytes, {} triangles, {} vertices, {} bytes of images",
                        i.info.bytes + i.info.external_bytes,
                        c.triangles,
                        c.vertices,
                        c.image_bytes
                    );
                }
                Err(e) => said = e.to_string(),
            }
        }
        println!("{:8.2} ms  {file}: {said}", 1e3 * best);
    }
}
