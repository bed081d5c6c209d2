//! What the samples add up to.

use crate::{Fixed, Pass, PassSet};
use etendue_image::{Image, Pixels};
use std::collections::BTreeMap;

/// Which samples of each pixel a film holds: disjoint, sorted, non-adjacent half-open ranges.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SampleRanges(Vec<(u32, u32)>);

impl SampleRanges {
    /// From any list of half-open ranges.
    ///
    /// # Errors
    /// The first sample that two of them hold.
    pub fn new(ranges: impl IntoIterator<Item = (u32, u32)>) -> Result<Self, u32> {
        let mut v: Vec<_> = ranges.into_iter().filter(|r| r.0 < r.1).collect();
        v.sort_unstable();
        let mut out: Vec<(u32, u32)> = Vec::with_capacity(v.len());
        for (a, b) in v {
            match out.last_mut() {
                Some(last) if a < last.1 => return Err(a),
                Some(last) if a == last.1 => last.1 = b,
                _ => out.push((a, b)),
            }
        }
        Ok(Self(out))
    }

    /// The ranges in ascending order.
    pub fn as_slice(&self) -> &[(u32, u32)] {
        &self.0
    }

    /// Number of samples held.
    pub fn count(&self) -> u64 {
        self.0.iter().map(|r| u64::from(r.1 - r.0)).sum()
    }

    /// The part of `from..to` that is missing here, as ranges.
    pub fn missing(&self, from: u32, to: u32) -> Vec<(u32, u32)> {
        let mut out = Vec::new();
        let mut at = from;
        for &(a, b) in &self.0 {
            if at < to && a > at {
                out.push((at, a.min(to)));
            }
            at = at.max(b);
        }
        if at < to {
            out.push((at, to));
        }
        out
    }

    /// Both together.
    ///
    /// # Errors
    /// The first sample that both hold.
    pub fn union(&self, o: &Self) -> Result<Self, u32> {
        Self::new(self.0.iter().chain(&o.0).copied())
    }
}

/// How many samples of a pixel saw each object (or material): hash → count.
pub type Coverage = BTreeMap<u32, u32>;

/// The beauty picture's planes before those of the passes: R, G, B, alpha, luminance².
pub const BEAUTY_PLANES: usize = 5;

/// Exact sums per pixel: beauty, and the passes that were asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// What is recorded beside the beauty picture.
    pub passes: PassSet,
    /// Samples that each pixel holds.
    pub ranges: SampleRanges,
    /// Samples that were NaN or infinite and count as black (a defect that is reported, never hidden).
    pub rejected: u64,
    /// Interleaved by pixel: [`Film::stride`] sums each.
    pub(crate) sums: Vec<Fixed>,
    /// Per pixel, if asked for: objects, then materials.
    pub(crate) ids: [Vec<Coverage>; 2],
}

impl Film {
    /// An empty film.
    pub fn new(width: u32, height: u32, passes: PassSet) -> Self {
        let pixels = width as usize * height as usize;
        let ids = [Pass::ObjectId, Pass::MaterialId]
            .map(|p| if passes.has(p) { vec![Coverage::new(); pixels] } else { Vec::new() });
        Self {
            width,
            height,
            passes,
            ranges: SampleRanges::default(),
            rejected: 0,
            sums: vec![Fixed::default(); pixels * Self::stride_of(passes)],
            ids,
        }
    }

    /// Sums per pixel with these passes.
    pub fn stride_of(passes: PassSet) -> usize {
        BEAUTY_PLANES + passes.planes()
    }

    /// Sums per pixel.
    pub fn stride(&self) -> usize {
        Self::stride_of(self.passes)
    }

    /// Samples per pixel.
    pub fn samples(&self) -> u64 {
        self.ranges.count()
    }

    /// Number of pixels.
    pub fn pixels(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Bytes that the sums take in memory.
    pub fn bytes(&self) -> usize {
        self.sums.len() * size_of::<Fixed>()
    }

    /// Plane `plane` of pixel `i`, divided by the number of samples.
    pub fn mean(&self, i: usize, plane: usize) -> f32 {
        let n = self.samples().max(1);
        (self.sums[i * self.stride() + plane].to_f64() / n as f64) as f32
    }

    /// A recorded pass of colours, as a picture of three floats per pixel; `None` if it was not recorded or holds something else.
    pub fn pass(&self, pass: Pass) -> Option<Image> {
        if !self.passes.has(pass) || pass.channels() != ["R", "G", "B"] {
            return None;
        }
        let before = self.passes.iter().take_while(|p| *p != pass).map(|p| p.channels().len()).sum::<usize>();
        let plane = BEAUTY_PLANES + before;
        let pixels = (0..self.pixels()).flat_map(|i| (0..3).map(move |c| self.mean(i, plane + c))).collect();
        Some(Image { width: self.width, height: self.height, channels: 3, pixels: Pixels::F32(pixels) })
    }

    /// Mean linear radiance R, G, B and coverage A of every pixel, top row first. Radiance is premultiplied by coverage.
    pub fn beauty(&self) -> Vec<[f32; 4]> {
        (0..self.pixels()).map(|i| std::array::from_fn(|p| self.mean(i, p))).collect()
    }

    /// Standard error of each pixel's luminance: √(sample variance / n).
    ///
    /// It takes the samples as independent. They are stratified, so the true error is lower; the figure is an upper
    /// estimate, by a factor that grows with smoothness.
    pub fn standard_error(&self) -> Vec<f32> {
        let n = self.samples() as f64;
        if n < 2.0 {
            return vec![f32::INFINITY; self.pixels()];
        }
        let s = self.stride();
        (0..self.pixels())
            .map(|i| {
                let v = |p: usize| self.sums[i * s + p].to_f64() / n;
                let mean = 0.2126 * v(0) + 0.7152 * v(1) + 0.0722 * v(2);
                ((v(4) - mean * mean).max(0.0) / (n - 1.0)).sqrt() as f32
            })
            .collect()
    }

    /// Relative error of the whole picture: √ of the mean over pixels of `error² / (luminance² + 0.01)`.
    pub fn relative_error(&self) -> f64 {
        let errors = self.standard_error();
        let mut sum = 0.0;
        for (i, e) in errors.iter().enumerate() {
            let l = 0.2126 * self.mean(i, 0) + 0.7152 * self.mean(i, 1) + 0.0722 * self.mean(i, 2);
            sum += f64::from(e * e) / (f64::from(l * l) + 0.01);
        }
        (sum / errors.len().max(1) as f64).sqrt()
    }

    /// Adds a film that holds other samples of the same picture.
    ///
    /// # Errors
    /// What differs: size, passes, or a sample that both hold. `self` is then unchanged.
    pub fn merge(&mut self, o: &Self) -> Result<(), MergeError> {
        if (self.width, self.height) != (o.width, o.height) {
            return Err(MergeError::Size(self.width, self.height, o.width, o.height));
        }
        if self.passes != o.passes {
            return Err(MergeError::Passes(self.passes.to_string(), o.passes.to_string()));
        }
        self.ranges = self.ranges.union(&o.ranges).map_err(MergeError::Overlap)?;
        self.rejected += o.rejected;
        for (a, b) in self.sums.iter_mut().zip(&o.sums) {
            a.add(*b);
        }
        for (mine, theirs) in self.ids.iter_mut().zip(&o.ids) {
            for (a, b) in mine.iter_mut().zip(theirs) {
                for (id, n) in b {
                    *a.entry(*id).or_default() += n;
                }
            }
        }
        Ok(())
    }
}

/// Why two films do not add.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MergeError {
    /// Different numbers of pixels.
    #[error("one film is {0} × {1} pixels, the other {2} × {3}")]
    Size(u32, u32, u32, u32),
    /// Different passes.
    #[error("one film records the passes [{0}], the other [{1}]")]
    Passes(String, String),
    /// The same sample in both: adding would count it twice.
    #[error("both films hold sample {0}; each sample may be counted once")]
    Overlap(u32),
    /// Different scenes, cameras or settings.
    #[error("the films show different pictures (scene, camera or settings differ): {0} and {1}")]
    Picture(String, String),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_add_and_say_what_is_missing() {
        let r = SampleRanges::new([(8, 12), (0, 4), (4, 6)]).unwrap();
        assert_eq!(r.as_slice(), [(0, 6), (8, 12)]);
        assert_eq!(r.count(), 10);
        assert_eq!(r.missing(0, 16), [(6, 8), (12, 16)]);
        assert_eq!(r.missing(2, 5), []);
        assert_eq!(r.missing(7, 10), [(7, 8)]);
        assert_eq!(SampleRanges::new([(0, 4), (3, 5)]), Err(3));
        assert_eq!(r.union(&SampleRanges::new([(6, 8)]).unwrap()).unwrap().as_slice(), [(0, 12)]);
    }

    #[test]
    fn refuses_what_does_not_add() {
        let mut a = Film::new(2, 2, PassSet::default());
        a.ranges = SampleRanges::new([(0, 4)]).unwrap();
        let b = a.clone();
        assert_eq!(a.merge(&b), Err(MergeError::Overlap(0)));
        assert!(matches!(a.merge(&Film::new(2, 3, PassSet::default())), Err(MergeError::Size(..))));
        let other = Film::new(2, 2, PassSet::default().with(Pass::Depth));
        assert!(matches!(a.merge(&other), Err(MergeError::Passes(..))));
    }
}
