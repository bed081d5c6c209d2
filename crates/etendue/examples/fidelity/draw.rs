//! Our pictures of a scene.

use crate::suite::{Golden, Scenario, on_grey};
use etendue::bxdf::multiscatter::Compensation;
use etendue::color::ToneCurve;
use etendue::image::{Depth, Development, Image, Pixels, develop, read_environment, rmse};
use etendue::import::{ImportOptions, import};
use etendue::realtime::{Choices, Lighting, Twin, TwinSettings};
use etendue::render::{Filter, PathOptions, Renderer, Settings, World};
use etendue::scene::Environment;
use std::error::Error;
use std::path::Path;
use std::sync::Arc;

/// Glass in front of glass takes more than the default.
const BOUNCES: u32 = 16;

/// Samples per pixel of the real-time picture, which has twice the width and height.
const REALTIME_SAMPLES: u32 = 8;

/// Both of our pictures of a scene, as displays show them on grey.
pub struct Ours {
    pub path: Image,
    /// Root of the mean squared noise of the traced paths, as estimated from two halves of their samples, which have seeds of their own.
    pub noise: f64,
    pub realtime: Image,
}

/// Draws a scene both ways.
pub fn render(
    scenario: &Scenario,
    assets: &Path,
    (width, height): (u32, u32),
    spp: u32,
    compensation: Compensation,
) -> Result<Ours, Box<dyn Error>> {
    let imported = import(&scenario.model(assets)?, &ImportOptions::default())?;
    imported.warnings.iter().for_each(|w| println!("  warning: {w}"));
    let mut scene = imported.scene;
    scene.materials.iter_mut().for_each(|m| m.compensation = compensation);
    let sky = read_environment(&scenario.sky(assets)?)?;
    scene.environment = Environment::LatLong { image: Arc::new(sky.image), rotation: 0.0, intensity: 1.0 };
    let world = World::new(scene)?;
    let filter = Filter::Box;
    let sky_visible = scenario.render_skybox;
    let half = |seed: u32| {
        let path = PathOptions { sky_visible, bounces: BOUNCES, ..PathOptions::default() };
        let settings = Settings { width, height, filter, seed, path, ..Settings::default() };
        let renderer = Renderer::new(&world, scenario.camera(), settings);
        let mut film = renderer.film();
        renderer.render(&mut film, 0, spp.div_ceil(2), &Default::default());
        film
    };
    let halves = [half(0), half(1)];
    let choices = Choices::default();
    let lighting = Lighting::new(world.scene(), &choices).map_err(|e| format!("the sky: {e}"))?;
    // The others were drawn at twice the size, developed and averaged, which makes bright edges thinner than averaged light
    // does. Paths have too much noise in a few samples to be developed before they are averaged.
    let settings = TwinSettings {
        width: 2 * width,
        height: 2 * height,
        samples: REALTIME_SAMPLES,
        filter,
        sky_visible,
        ..TwinSettings::default()
    };
    let frame =
        Twin::new(&world, &scenario.camera(), &lighting, choices, settings).render(&Default::default());
    let of_paths = halves.iter().map(|f| f.rejected).sum::<u64>();
    for (what, rejected) in [("paths", of_paths), ("real time", frame.rejected)] {
        if rejected > 0 {
            println!("  {rejected} samples of {what} were not numbers");
        }
    }
    let development = Development {
        // three.js divides by 0.6 before the curve.
        exposure_ev: (1.0f32 / 0.6).log2(),
        curve: ToneCurve::AcesFitted,
        depth: Depth::Sixteen,
        ..Development::default()
    };
    let shown = |picture: Image| on_grey(&develop(&picture, &development));
    let light = halves.map(|film| film.picture(!sky_visible));
    let whole = mean(&light[0], &light[1]);
    // They are independent: the variance of their difference is four times that of their mean.
    let [a, b] = light.map(shown);
    let noise = 0.5 * rmse(&a, &b)?;
    Ok(Ours { path: shown(whole), noise, realtime: halved(&shown(frame.picture(!sky_visible))) })
}

/// A picture of half the width and height.
fn halved(a: &Image) -> Image {
    let (width, height, n) = (a.width / 2, a.height / 2, a.channels);
    let mut out = Vec::with_capacity(a.len() / 4);
    for y in 0..height {
        for x in 0..width {
            let four = [[0, 0], [1, 0], [0, 1], [1, 1]];
            let mean = |c| four.iter().map(|[u, v]| a.sample(2 * x + u, 2 * y + v, c)).sum::<f32>() * 0.25;
            out.extend((0..n).map(mean));
        }
    }
    Image { width, height, channels: n, pixels: Pixels::F32(out) }
}

/// The mean of two pictures of one size.
fn mean(a: &Image, b: &Image) -> Image {
    let (n, width) = (u32::from(a.channels), a.width);
    let sample = |i: u32| {
        let (x, y, c) = (i / n % width, i / n / width, (i % n) as u8);
        0.5 * (a.sample(x, y, c) + b.sample(x, y, c))
    };
    Image { pixels: Pixels::F32((0..a.len() as u32).map(sample).collect()), ..*a }
}

/// A picture of eight bits.
pub fn eight_bits(picture: &Image) -> Image {
    let n = picture.channels;
    let mut bytes = Vec::with_capacity(picture.len());
    for y in 0..picture.height {
        for x in 0..picture.width {
            bytes.extend((0..n).map(|c| (picture.sample(x, y, c) * 255.0 + 0.5) as u8));
        }
    }
    Image { pixels: Pixels::U8(bytes), ..*picture }
}

/// Above our path-traced picture, the path tracers' and our real-time one in a row; below each of the others, what our
/// path-traced one has more or less, four times, about grey.
pub fn side_by_side(both: &Ours, goldens: &[Golden]) -> Image {
    let ours = &both.path;
    let others = goldens.iter().filter(|g| g.path_traced || g.name == "model-viewer").map(|g| &g.picture);
    let shown: Vec<&Image> = others.chain([&both.realtime]).collect();
    let (w, h) = (ours.width, ours.height);
    let width = w * (shown.len() as u32 + 1);
    let mut out = Vec::with_capacity(width as usize * h as usize * 6);
    for y in 0..2 * h {
        for x in 0..width {
            let other = (x / w).checked_sub(1).map(|k| shown[k as usize]);
            for c in 0..3 {
                let v = match (other, y < h) {
                    (None, true) => ours.sample(x, y, c),
                    (Some(o), true) => o.sample(x % w, y, c),
                    (None, false) => 0.5,
                    (Some(o), false) => {
                        0.5 + 4.0 * (ours.sample(x % w, y - h, c) - o.sample(x % w, y - h, c))
                    }
                };
                out.push((v.clamp(0.0, 1.0) * 255.0 + 0.5) as u8);
            }
        }
    }
    Image { width, height: 2 * h, channels: 3, pixels: Pixels::U8(out) }
}
