//! The reference: path-traced pictures in parts, and how noisy they still are.

use etendue_image::{Image, Pixels};
use etendue_render::{Counters, Film, Pass, PassSet, PathOptions, Renderer, Settings, World};
use etendue_scene::Camera;

/// A path-traced picture with its parts, and the same from half of the samples.
#[derive(Clone, Debug)]
pub(crate) struct Truth {
    film: Film,
    half: Image,
}

impl Truth {
    /// Takes `samples` (at least 2) samples of each pixel in a few batches; `progress` gets the share that is done.
    pub fn render(
        world: &World,
        camera: &Camera,
        settings: &Settings,
        light_only: bool,
        samples: u32,
        progress: &dyn Fn(f64),
    ) -> Self {
        let path = PathOptions { light_only, ..settings.path };
        let settings = Settings { path, passes: PassSet::parts(), ..settings.clone() };
        let renderer = Renderer::new(world, camera.clone(), settings);
        let mut film = renderer.film();
        let (samples, counters) = (samples.max(2), Counters::default());
        let middle = samples / 2;
        let mut half = None;
        let mut done = 0;
        while done < samples {
            let end = if done < middle { middle } else { samples };
            let next = (done + samples.div_ceil(16)).min(end);
            renderer.render(&mut film, done, next, &counters);
            done = next;
            if done == middle {
                half = Some(film.picture(false));
            }
            progress(f64::from(done) / f64::from(samples));
        }
        let half = half.unwrap_or_else(|| film.picture(false));
        Self { film, half }
    }

    /// The picture from all samples.
    pub fn picture(&self) -> Image {
        self.film.picture(false)
    }

    /// The picture from the first half of the samples. It differs from the whole by half the difference of the two halves, whose
    /// variance is that of the whole: comparing both tells what noise alone makes.
    pub fn half(&self) -> &Image {
        &self.half
    }

    /// The sum of some parts.
    pub fn parts(&self, passes: &[Pass]) -> Image {
        let mut sum = self.film.picture(false);
        if let Pixels::F32(p) = &mut sum.pixels {
            p.fill(0.0);
        }
        passes.iter().filter_map(|p| self.film.pass(*p)).for_each(|part| add(&mut sum, &part, 1.0));
        sum
    }

    /// True where the camera sees a surface in any sample.
    pub fn covered(&self) -> Vec<bool> {
        self.film.beauty().iter().map(|p| p[3] > 0.0).collect()
    }

    /// Samples that were not numbers.
    pub fn rejected(&self) -> u64 {
        self.film.rejected
    }
}

/// `to += scale · from`, of float pictures of one size.
pub(crate) fn add(to: &mut Image, from: &Image, scale: f32) {
    if let (Pixels::F32(to), Pixels::F32(from)) = (&mut to.pixels, &from.pixels) {
        to.iter_mut().zip(from).for_each(|(t, f)| *t += scale * f);
    }
}

/// Mean of each of three float channels.
pub(crate) fn mean(image: &Image) -> [f64; 3] {
    let Pixels::F32(p) = &image.pixels else { return [0.0; 3] };
    let mut sum = [0.0; 3];
    p.chunks_exact(3).for_each(|c| (0..3).for_each(|i| sum[i] += f64::from(c[i])));
    sum.map(|s| s / (p.len() / 3).max(1) as f64)
}
