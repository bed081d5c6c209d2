//! Writes a model of the gigabyte class: ten million triangles and 64 textures of 4096² pixels, to measure what importing
//! and rendering take.
//!
//! ```text
//! cargo run --release -p etendue --example big_asset -- FOLDER [--side 8] [--grid 280] [--texture 4096]
//! etendue info FOLDER/big.gltf
//! ```
//!
//! `side`² bumpy spheres of 2 · `grid`² triangles stand in a square, each with a material and a base colour texture of its
//! own. Everything is a function of its number: the same arguments give the same bytes.
#![forbid(unsafe_code)]

use clap::Parser;
use etendue::image::{Image, Pixels, WriteOptions, write_picture};
use rayon::prelude::*;
use serde_json::{Value, json};
use std::error::Error;
use std::f32::consts::{PI, TAU};
use std::io::Write;
use std::path::PathBuf;

/// Writes `big.gltf`, `big.bin` and the textures.
#[derive(Parser)]
struct Args {
    /// Where they go; made if it is not there.
    folder: PathBuf,
    /// Spheres along an edge of the square.
    #[arg(long, default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..=64))]
    side: u32,
    /// Quads around and along a sphere.
    #[arg(long, default_value_t = 280, value_parser = clap::value_parser!(u32).range(3..=4096))]
    grid: u32,
    /// Width and height of a texture.
    #[arg(long, default_value_t = 4096, value_parser = clap::value_parser!(u32).range(1..=16384))]
    texture: u32,
}

/// A hash of three numbers (the finaliser of MurmurHash3 on their mix).
fn hash(a: u32, b: u32, c: u32) -> u32 {
    let mut h = a.wrapping_mul(0x9e37_79b9) ^ b.wrapping_mul(0x85eb_ca6b) ^ c.wrapping_mul(0xc2b2_ae35);
    h = (h ^ (h >> 16)).wrapping_mul(0x85eb_ca6b);
    h = (h ^ (h >> 13)).wrapping_mul(0xc2b2_ae35);
    h ^ (h >> 16)
}

/// Tiles of two colours with grain: compresses as photographs of surfaces do, to about a fifth.
fn texture(number: u32, size: u32) -> Image {
    let byte = |k: u32| (hash(number, k, 7) >> 24) as u8 / 2 + 64;
    let colors = [[byte(0), byte(1), byte(2)], [byte(3), byte(4), byte(5)]];
    let tile = size.div_ceil(16).max(1);
    let mut pixels = Vec::with_capacity(size as usize * size as usize * 3);
    for y in 0..size {
        for x in 0..size {
            let color = colors[((x / tile + y / tile) % 2) as usize];
            let grain = (hash(x, y, number) & 3) as u8;
            pixels.extend(color.map(|c| c + grain));
        }
    }
    Image { width: size, height: size, channels: 3, pixels: Pixels::U8(pixels) }
}

/// Positions, normals, texture coordinates and triangles of a sphere, as bytes one after another.
fn sphere(number: u32, grid: u32) -> Vec<u8> {
    let side = grid + 1;
    let mut floats: [Vec<f32>; 3] = Default::default();
    let waves = (3 + number % 5) as f32;
    for j in 0..side {
        for i in 0..side {
            let (u, v) = (i as f32 / grid as f32, j as f32 / grid as f32);
            let (theta, phi) = (v * PI, u * TAU);
            let n = [theta.sin() * phi.cos(), theta.cos(), -theta.sin() * phi.sin()];
            let radius = 0.4 * (1.0 + 0.05 * (waves * phi).sin() * (waves * theta).sin());
            floats[0].extend(n.map(|x| x * radius));
            floats[1].extend(n);
            floats[2].extend([u, v]);
        }
    }
    let corner = |i: u32, j: u32| j * side + i;
    let indices = (0..grid).flat_map(|j| (0..grid).map(move |i| (i, j))).flat_map(|(i, j)| {
        let [a, b, c, d] = [corner(i, j), corner(i, j + 1), corner(i + 1, j + 1), corner(i + 1, j)];
        [a, b, c, a, c, d]
    });
    let mut out: Vec<u8> = floats.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    out.extend(indices.flat_map(u32::to_le_bytes));
    out
}

fn document(args: &Args, length: u64) -> Value {
    let (count, triangles) = (u64::from((args.grid + 1).pow(2)), u64::from(2 * args.grid * args.grid));
    let each = count * 32 + triangles * 12;
    let spheres = u64::from(args.side * args.side);
    let (mut views, mut accessors, mut meshes, mut nodes) = (vec![], vec![], vec![], vec![]);
    for k in 0..spheres {
        let parts = [
            (0, 12, "VEC3", 5126, count),
            (count * 12, 12, "VEC3", 5126, count),
            (count * 24, 8, "VEC2", 5126, count),
            (count * 32, 4, "SCALAR", 5125, triangles * 3),
        ];
        for (offset, size, kind, component, n) in parts {
            views.push(json!({ "buffer": 0, "byteOffset": k * each + offset, "byteLength": n * size }));
            let mut a = json!({ "bufferView": views.len() - 1, "componentType": component, "count": n, "type": kind });
            if offset == 0 {
                (a["min"], a["max"]) = (json!([-0.42, -0.42, -0.42]), json!([0.42, 0.42, 0.42]));
            }
            accessors.push(a);
        }
        let attributes = json!({ "POSITION": 4 * k, "NORMAL": 4 * k + 1, "TEXCOORD_0": 4 * k + 2 });
        meshes.push(
            json!({ "primitives": [{ "attributes": attributes, "indices": 4 * k + 3, "material": k }] }),
        );
        let (x, z) = (k % u64::from(args.side), k / u64::from(args.side));
        nodes.push(json!({ "mesh": k, "translation": [x, 0.0, z] }));
    }
    let all: Vec<u64> = (0..spheres).collect();
    json!({
        "asset": { "version": "2.0", "generator": "big_asset" },
        "scene": 0, "scenes": [{ "nodes": all }], "nodes": nodes, "meshes": meshes,
        "materials": all.iter().map(|k| json!({ "pbrMetallicRoughness": {
            "baseColorTexture": { "index": k }, "metallicFactor": 0, "roughnessFactor": 0.6 } })).collect::<Vec<_>>(),
        "textures": all.iter().map(|k| json!({ "source": k })).collect::<Vec<_>>(),
        "images": all.iter().map(|k| json!({ "uri": format!("{k}.png") })).collect::<Vec<_>>(),
        "accessors": accessors, "bufferViews": views, "buffers": [{ "uri": "big.bin", "byteLength": length }],
    })
}

fn main() -> Result<(), Box<dyn Error + Send + Sync>> {
    let args = Args::parse();
    std::fs::create_dir_all(&args.folder)?;
    let spheres = args.side * args.side;
    let mut binary = std::io::BufWriter::new(std::fs::File::create(args.folder.join("big.bin"))?);
    let mut length = 0u64;
    for k in 0..spheres {
        let bytes = sphere(k, args.grid);
        length += bytes.len() as u64;
        binary.write_all(&bytes)?;
    }
    binary.flush()?;
    (0..spheres).into_par_iter().try_for_each(|k| {
        let path = args.folder.join(format!("{k}.png"));
        write_picture(&path, &texture(k, args.texture), &WriteOptions::default())
    })?;
    std::fs::write(args.folder.join("big.gltf"), document(&args, length).to_string())?;
    let triangles = u64::from(spheres) * 2 * u64::from(args.grid) * u64::from(args.grid);
    println!("{triangles} triangles, {spheres} textures");
    Ok(())
}
