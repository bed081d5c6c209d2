//! Which sample is taken when: moments of the time that the shutter is open, stratified for each pixel and among neighbours.
//!
//! Time is cut into as many parts as a [`Shutter`] has moments, M. A block of M samples has one moment in each part, the same
//! for all pixels: van der Corput's sequence (see [`crate::moment`]). Which sample of the block a pixel takes at which of
//! them is its own: it takes the parts in the sequence's order, with the bits of the pixel's class exclusive-ored to their
//! numbers. So a world is needed for M moments, not for M moments a pixel; each pixel's samples are stratified (of its first
//! 2^k, one is in each of 2^k equal parts of the time, since exclusive or permutes these parts); and pixels of different
//! classes see different moments, so that few samples show noise where all pixels at the same moments would show steps.
//!
//! Classes are stratified too: of the four pixels of a square, each begins in another quarter of the time, of sixteen each in
//! another sixteenth, and so on (by scrambled Morton order, as Ahmed and Wonka 2020, "Screen-Space Blue-Noise Diffusion of
//! Monte Carlo Sampling Error via Hierarchical Ordering of Pixels", hand on the points of one sequence to pixels).

use crate::sampler::{hash, moment_bits};

/// The time during which light falls on the film, seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shutter {
    /// When it opens.
    pub open: f64,
    /// When it closes; not before it opens.
    pub close: f64,
    /// How many moments a block of as many samples has, however few of them are taken: a power of two from 1 (all pixels see a
    /// sample at the same moment) to [`Shutter::MOST_MOMENTS`]. Other numbers stand for the next power of two.
    pub moments: u32,
}

impl Shutter {
    /// Enough that their steps are not seen.
    pub const MOMENTS: u32 = 64;
    /// Largest number of moments in a block.
    pub const MOST_MOMENTS: u32 = 4096;

    /// Open for `seconds`, half of them before `middle`, with [`Shutter::MOMENTS`] moments.
    pub fn around(middle: f64, seconds: f64) -> Self {
        Self { open: middle - 0.5 * seconds, close: middle + 0.5 * seconds, moments: Self::MOMENTS }
    }

    /// When the sample `index` of the pixel at (`x`, `y`) of a picture with this `seed` is taken.
    pub fn time(&self, seed: u32, x: u32, y: u32, index: u32) -> f64 {
        let block = Block::new(self, seed, index);
        let part = block.part_of[(index - block.first) as usize] ^ self.class(seed, x, y);
        self.time_of(seed, block.first + block.index_of[part as usize])
    }

    /// When the sample `index` of pixels of the class 0 is taken.
    pub(crate) fn time_of(&self, seed: u32, index: u32) -> f64 {
        self.open + (self.close - self.open) * crate::moment(seed, index)
    }

    /// Samples in a block.
    pub(crate) fn block(&self) -> u32 {
        self.moments.clamp(1, Self::MOST_MOMENTS).next_power_of_two()
    }
}

/// A block of samples.
pub(crate) struct Block {
    /// Its first sample.
    pub first: u32,
    bits: u32,
    /// Per sample of the block, the part of the time in which class 0 takes it.
    part_of: Vec<u32>,
    /// The other way: per part, the number of the sample within the block.
    index_of: Vec<u32>,
}

impl Block {
    /// The block of the sample `index`.
    pub fn new(shutter: &Shutter, seed: u32, index: u32) -> Self {
        let size = shutter.block();
        let bits = size.trailing_zeros();
        let first = index & !(size - 1);
        let part = |i: u32| moment_bits(seed, first + i).checked_shr(32 - bits).unwrap_or(0);
        let part_of: Vec<u32> = (0..size).map(part).collect();
        let mut index_of = vec![0; size as usize];
        (0u32..).zip(&part_of).for_each(|(i, part)| index_of[*part as usize] = i);
        Self { first, bits, part_of, index_of }
    }

    /// Number of samples, and of parts of the time.
    pub fn size(&self) -> u32 {
        1 << self.bits
    }

    /// The sample that class 0 takes in a `part` of the time; its moment is that of all classes.
    pub fn sample_of(&self, part: u32) -> u32 {
        self.first + self.index_of[part as usize]
    }

    /// The sample that pixels of `class` take in a `part` of the time.
    pub fn sample(&self, part: u32, class: u32) -> u32 {
        self.sample_of(part ^ class)
    }
}

impl Shutter {
    /// The class of a pixel of the picture with this `seed`.
    pub(crate) fn class(&self, seed: u32, x: u32, y: u32) -> u32 {
        let mut class = 0;
        let mut left = self.block().trailing_zeros();
        let mut level = 0;
        while left > 0 {
            let above = hash((x >> level >> 1) ^ hash((y >> level >> 1) ^ hash(seed ^ (level + 1))));
            let (a, b) = ((x >> level) & 1, (y >> level) & 1);
            let two = if above & 4 == 0 { a << 1 | b } else { b << 1 | a } ^ (above & 3);
            let taken = left.min(2);
            left -= taken;
            class |= (two >> (2 - taken)) << left;
            level += 1;
        }
        class
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each pixel's samples are stratified over the time, whatever power of two is taken; blocks share their moments.
    #[test]
    fn pixels_are_stratified_and_share_moments() {
        for moments in [1u32, 2, 8, 64] {
            let s = Shutter { open: 0.0, close: 1.0, moments };
            let mut all = std::collections::BTreeSet::new();
            for (x, y) in [(0, 0), (5, 3), (1000, 77), (6, 3), (7, 7)] {
                let times: Vec<f64> = (0..128).map(|i| s.time(9, x, y, i)).collect();
                for n in [1usize, 2, 4, 16, 64, 128] {
                    for chunk in times.chunks(n) {
                        let mut parts: Vec<usize> = chunk.iter().map(|t| (t * n as f64) as usize).collect();
                        parts.sort_unstable();
                        assert!(parts.into_iter().eq(0..n), "{moments} moments, {n} samples at {x}, {y}");
                    }
                }
                all.extend(times.iter().map(|t| t.to_bits()));
            }
            assert_eq!(all.len(), 128, "{moments} moments: as many worlds as samples");
        }
    }

    /// The pixels of each aligned square of 2 × 2, 4 × 4 and 8 × 8 take their first samples in as many parts of the time.
    #[test]
    fn neighbours_are_stratified() {
        let s = Shutter::around(0.5, 1.0);
        for n in [2u32, 4, 8] {
            for (cx, cy) in [(0, 0), (16, 8), (24, 104)] {
                let time = |k: u32| s.time(3, cx + k % n, cy + k / n, 0);
                let mut parts: Vec<u32> = (0..n * n).map(|k| (time(k) * f64::from(n * n)) as u32).collect();
                parts.sort_unstable();
                assert!(parts.into_iter().eq(0..n * n), "{n} × {n} at {cx}, {cy}");
            }
        }
    }
}
