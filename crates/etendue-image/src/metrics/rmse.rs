//! Errors that weigh numbers, not perception.

use rayon::prelude::*;

use super::{color, comparable};
use crate::{Image, ImageError};

/// Mean of `f(reference, test)` over pixels and the three colour channels, in double precision. Rows are summed one by
/// one and then in order, so the result does not depend on the number of threads.
fn mean(reference: &Image, test: &Image, f: impl Fn(f64, f64) -> f64 + Sync) -> Result<f64, ImageError> {
    comparable(reference, test)?;
    let rows: Vec<f64> = (0..reference.height)
        .into_par_iter()
        .map(|y| {
            let mut sum = 0.0;
            for x in 0..reference.width {
                let (r, t) = (color(reference, x, y), color(test, x, y));
                sum += (0..3).map(|c| f(f64::from(r[c]), f64::from(t[c]))).sum::<f64>();
            }
            sum
        })
        .collect();
    let count = 3.0 * f64::from(reference.width) * f64::from(reference.height);
    Ok(rows.iter().sum::<f64>() / count)
}

/// Root of the mean squared difference of the samples, colour channels only (alpha is not compared).
///
/// # Errors
/// When the pictures differ in size.
pub fn rmse(reference: &Image, test: &Image) -> Result<f64, ImageError> {
    Ok(mean(reference, test, |r, t| (t - r) * (t - r))?.sqrt())
}

/// Relative mean squared error: mean over pixels and colour channels of `(t − r)² / (r² + 0.01)`, for linear light.
///
/// Rousselle, Knaus, Zwicker, "Adaptive Sampling and Reconstruction using Greedy Error Minimization" (2011), section 6, with their
/// ε = 0.01, which keeps black pixels from ruling the sum.
///
/// # Errors
/// When the pictures differ in size.
pub fn rel_mse(reference: &Image, test: &Image) -> Result<f64, ImageError> {
    mean(reference, test, |r, t| (t - r) * (t - r) / (r * r + 0.01))
}

/// Peak signal-to-noise ratio in decibels for samples whose peak is 1: `−20 log₁₀ RMSE`; infinite for equal pictures.
///
/// # Errors
/// When the pictures differ in size.
pub fn psnr(reference: &Image, test: &Image) -> Result<f64, ImageError> {
    Ok(-20.0 * rmse(reference, test)?.log10())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Pixels;

    fn image(channels: u8, p: &[f32]) -> Image {
        Image {
            width: (p.len() / channels as usize) as u32,
            height: 1,
            channels,
            pixels: Pixels::F32(p.to_vec()),
        }
    }

    #[test]
    fn by_hand() {
        let r = image(3, &[1.0, 0.0, 0.5, 0.0, 0.0, 0.0]);
        let t = image(3, &[0.9, 0.0, 0.5, 0.0, 0.3, 0.0]);
        assert!((rmse(&r, &t).unwrap() - (0.1f64 / 6.0).sqrt()).abs() < 1e-7);
        assert!((rel_mse(&r, &t).unwrap() - (0.01 / 1.01 + 0.09 / 0.01) / 6.0).abs() < 1e-6);
        assert!((psnr(&r, &t).unwrap() - 17.781_513).abs() < 1e-5);
        assert_eq!(psnr(&r, &r).unwrap(), f64::INFINITY);
        // Alpha is not compared; grey stands for three channels.
        let (a, b) = (image(4, &[0.5, 0.5, 0.5, 1.0]), image(4, &[0.5, 0.5, 0.5, 0.0]));
        assert_eq!(rmse(&a, &b).unwrap(), 0.0);
        assert_eq!(rmse(&a, &image(1, &[0.5])).unwrap(), 0.0);
        assert!(rmse(&r, &a).is_err());
    }
}
