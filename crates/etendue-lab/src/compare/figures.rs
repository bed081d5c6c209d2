//! How far one picture is from another, as figures.

use etendue_color::srgb_decode;
use etendue_image::{Image, ImageError, Pixels, hdr_flip, ldr_flip, rel_mse, rmse};
use serde_json::{Value, json};

/// Why two pictures cannot be compared.
#[derive(Debug, thiserror::Error)]
pub enum CompareError {
    /// They have different sizes.
    #[error("the reference has {} × {} pixels and the other picture {} × {}", .0[0], .0[1], .1[0], .1[1])]
    Size([u32; 2], [u32; 2]),
    /// One holds light, the other what a display is sent.
    #[error(
        "{} holds linear light and {} display values; they differ by exposure and tone curve",
        if *.reference_is_light { "the reference" } else { "the other picture" },
        if *.reference_is_light { "the other picture" } else { "the reference" }
    )]
    Kind {
        /// Which of the two holds light.
        reference_is_light: bool,
    },
    /// A picture is not sound.
    #[error(transparent)]
    Image(#[from] ImageError),
}

/// Which FLIP was computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Metric {
    /// Of pictures as a display shows them.
    Ldr,
    /// Of linear light: the largest LDR-FLIP over a range of exposures.
    Hdr,
}

impl Metric {
    /// As it is called.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ldr => "LDR-FLIP",
            Self::Hdr => "HDR-FLIP",
        }
    }
}

/// FLIP over all pixels of a picture, 0 for equal ones, at most 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlipFigures {
    /// Which one.
    pub metric: Metric,
    /// Resolution at which it is looked at.
    pub pixels_per_degree: f32,
    /// Mean over the pixels.
    pub mean: f64,
    /// Half of the pixels have at most this.
    pub median: f32,
    /// Three quarters of the pixels have at most this.
    pub p75: f32,
    /// 95 % of the pixels have at most this.
    pub p95: f32,
    /// 99 % of the pixels have at most this.
    pub p99: f32,
    /// The largest.
    pub max: f32,
    /// Where the largest stands: column and row from the upper left.
    pub worst: [u32; 2],
}

impl FlipFigures {
    /// Figures of a map of `width` columns, which must not be empty.
    pub fn of(map: &[f32], width: u32, metric: Metric, pixels_per_degree: f32) -> Self {
        let mut sorted = map.to_vec();
        sorted.sort_unstable_by(f32::total_cmp);
        // Nearest rank.
        let at = |p: f64| sorted[((p * sorted.len() as f64).ceil() as usize).clamp(1, sorted.len()) - 1];
        let max = at(1.0);
        let worst = map.iter().position(|v| *v == max).unwrap_or(0) as u32;
        Self {
            metric,
            pixels_per_degree,
            mean: map.iter().map(|v| f64::from(*v)).sum::<f64>() / map.len() as f64,
            median: at(0.5),
            p75: at(0.75),
            p95: at(0.95),
            p99: at(0.99),
            max,
            worst: [worst % width, worst / width],
        }
    }

    /// As a JSON object.
    pub fn to_json(&self) -> Value {
        json!({
            "metric": self.metric.name(), "pixels_per_degree": self.pixels_per_degree, "mean": self.mean,
            "median": self.median, "p75": self.p75, "p95": self.p95, "p99": self.p99, "max": self.max,
            "worst": self.worst,
        })
    }
}

/// How far a picture is from its reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figures {
    /// What a viewer sees.
    pub flip: FlipFigures,
    /// Root mean square of the samples' difference, as they stand in the files (display values 0..1, or light), over R, G, B.
    pub rmse: f64,
    /// Relative mean squared error of the light; see [`rel_mse`].
    pub rel_mse: f64,
    /// Mean difference of the light, picture − reference, of R, G and B: brighter is positive.
    pub bias: [f64; 3],
    /// Root mean square of the alphas' difference, if one of the pictures has alpha.
    pub alpha_rmse: Option<f64>,
    /// Pixels with a sample that is NaN or infinite, in the reference and in the picture. They count as black.
    pub not_finite: [usize; 2],
}

impl Figures {
    /// Peak signal-to-noise ratio in dB, for display values; `None` for equal pictures.
    pub fn psnr(&self) -> Option<f64> {
        (self.rmse > 0.0).then(|| -20.0 * self.rmse.log10())
    }

    /// As a JSON object.
    pub fn to_json(&self) -> Value {
        let psnr = if self.flip.metric == Metric::Ldr { self.psnr() } else { None };
        json!({
            "flip": self.flip.to_json(), "rmse": self.rmse, "psnr": psnr, "rel_mse": self.rel_mse,
            "bias": self.bias, "alpha_rmse": self.alpha_rmse, "not_finite": self.not_finite,
        })
    }

    /// A few lines for a terminal.
    pub fn to_text(&self) -> String {
        let (f, [r, g, b]) = (&self.flip, self.bias);
        let samples = match (f.metric, self.psnr()) {
            (Metric::Ldr, Some(db)) => format!("of the display values; PSNR {db:.1} dB"),
            (Metric::Ldr, None) => "of the display values".into(),
            (Metric::Hdr, _) => "of the light".into(),
        };
        let mut out = format!(
            "FLIP    {:.5}  mean ({}, {:.1} pixels per degree); median {:.4}, 95 % {:.4}, largest {:.4} at {},{}\n\
             RMSE    {:.5}  {samples}\n\
             relMSE  {:.3e}  of the light\n\
             bias    {r:+.2e} {g:+.2e} {b:+.2e}  of the light, R G B\n",
            f.mean,
            f.metric.name(),
            f.pixels_per_degree,
            f.median,
            f.p95,
            f.max,
            f.worst[0],
            f.worst[1],
            self.rmse,
            self.rel_mse
        );
        if let Some(a) = self.alpha_rmse {
            out += &format!("alpha   {a:.5}  RMSE\n");
        }
        if self.not_finite != [0, 0] {
            let [r, t] = self.not_finite;
            out += &format!(
                "not finite: {r} pixels of the reference, {t} of the other picture; they count as black\n"
            );
        }
        out
    }
}

/// Figures, and the FLIP of each pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// The figures.
    pub figures: Figures,
    /// FLIP of each pixel, row by row.
    pub map: Vec<f32>,
}

/// Compares `test` with `reference`: both display values (integer samples, sRGB) or both linear light (floats).
///
/// Pictures with alpha are compared as they look on black and on white: a pixel's FLIP is the larger of the two, all other
/// figures are of the pictures on black.
///
/// # Errors
/// When they differ in size or in kind.
pub fn compare(reference: &Image, test: &Image, pixels_per_degree: f32) -> Result<Comparison, CompareError> {
    let sizes = [reference, test].map(|i| [i.width, i.height]);
    if sizes[0] != sizes[1] {
        return Err(CompareError::Size(sizes[0], sizes[1]));
    }
    let light = [reference, test].map(|i| matches!(i.pixels, Pixels::F32(_)));
    if light[0] != light[1] {
        return Err(CompareError::Kind { reference_is_light: light[0] });
    }
    let has_alpha = [reference, test].iter().any(|i| i.channels.is_multiple_of(2));
    let (metric, flip): (_, fn(&Image, &Image, f32) -> _) =
        if light[0] { (Metric::Hdr, hdr_flip) } else { (Metric::Ldr, ldr_flip) };
    let (r, t) = (on(reference, 0.0), on(test, 0.0));
    let mut map = flip(&r, &t, pixels_per_degree)?.map;
    if has_alpha {
        let white = flip(&on(reference, 1.0), &on(test, 1.0), pixels_per_degree)?;
        map.iter_mut().zip(white.map).for_each(|(m, w)| *m = m.max(w));
    }
    let (lr, lt) = (light_of(&r), light_of(&t));
    let figures = Figures {
        flip: FlipFigures::of(&map, reference.width, metric, pixels_per_degree),
        rmse: rmse(&r, &t)?,
        rel_mse: rel_mse(&lr, &lt)?,
        bias: bias(&lr, &lt),
        alpha_rmse: has_alpha.then(|| alpha_rmse(reference, test)),
        not_finite: [not_finite(reference), not_finite(test)],
    };
    Ok(Comparison { figures, map })
}

fn not_finite(image: &Image) -> usize {
    match &image.pixels {
        Pixels::F32(p) => {
            p.chunks_exact(image.channels as usize).filter(|c| c.iter().any(|v| !v.is_finite())).count()
        }
        _ => 0,
    }
}

/// Three channels on a grey background of `value`. Display values are straight and mixed as they stand, which is what
/// browsers do; light is premultiplied. What is not finite becomes 0.
pub(crate) fn on(image: &Image, value: f32) -> Image {
    let n = image.channels;
    let colors: [u8; 3] = if n < 3 { [0; 3] } else { [0, 1, 2] };
    let has_alpha = n.is_multiple_of(2);
    let places = || (0..image.height).flat_map(|y| (0..image.width).map(move |x| (x, y)));
    let alpha = |x, y| if has_alpha { image.sample(x, y, n - 1) } else { 1.0 };
    let straight = |x, y, c| {
        let a = alpha(x, y);
        image.sample(x, y, c) * a + value * (1.0 - a)
    };
    let each = |f: &dyn Fn(u32, u32, u8) -> f32| -> Vec<f32> {
        places().flat_map(|(x, y)| colors.map(|c| f(x, y, c))).collect()
    };
    let pixels = match &image.pixels {
        Pixels::U8(p) if n == 3 => Pixels::U8(p.clone()),
        Pixels::U8(_) => Pixels::U8(each(&straight).into_iter().map(|v| (v * 255.0 + 0.5) as u8).collect()),
        Pixels::U16(_) => {
            Pixels::U16(each(&straight).into_iter().map(|v| (v * 65535.0 + 0.5) as u16).collect())
        }
        Pixels::F32(_) => Pixels::F32(each(&|x, y, c| {
            let v = image.sample(x, y, c) + value * (1.0 - alpha(x, y));
            if v.is_finite() { v } else { 0.0 }
        })),
    };
    Image { channels: 3, pixels, ..*image }
}

/// A three-channel picture as linear light.
fn light_of(image: &Image) -> Image {
    let decode = |p: Vec<f32>| Pixels::F32(p.into_iter().map(srgb_decode).collect());
    let pixels = match &image.pixels {
        Pixels::U8(p) => decode(p.iter().map(|v| f32::from(*v) / 255.0).collect()),
        Pixels::U16(p) => decode(p.iter().map(|v| f32::from(*v) / 65535.0).collect()),
        Pixels::F32(p) => Pixels::F32(p.clone()),
    };
    Image { pixels, ..*image }
}

/// Mean of `test` − `reference` for each of three float channels.
fn bias(reference: &Image, test: &Image) -> [f64; 3] {
    let (Pixels::F32(r), Pixels::F32(t)) = (&reference.pixels, &test.pixels) else { return [0.0; 3] };
    let mut sum = [0.0; 3];
    for (r, t) in r.chunks_exact(3).zip(t.chunks_exact(3)) {
        (0..3).for_each(|c| sum[c] += f64::from(t[c]) - f64::from(r[c]));
    }
    sum.map(|s| s / (r.len() / 3) as f64)
}

fn alpha_rmse(reference: &Image, test: &Image) -> f64 {
    let alpha = |i: &Image, x, y| {
        let v = if i.channels.is_multiple_of(2) { i.sample(x, y, i.channels - 1) } else { 1.0 };
        if v.is_finite() { f64::from(v) } else { 0.0 }
    };
    let mut sum = 0.0;
    for y in 0..reference.height {
        for x in 0..reference.width {
            let d = alpha(test, x, y) - alpha(reference, x, y);
            sum += d * d;
        }
    }
    (sum / (f64::from(reference.width) * f64::from(reference.height))).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue_image::DEFAULT_PPD;

    fn bytes(channels: u8, p: Vec<u8>) -> Image {
        Image { width: 16, height: 8, channels, pixels: Pixels::U8(p) }
    }

    fn floats(channels: u8, p: Vec<f32>) -> Image {
        Image { width: 16, height: 8, channels, pixels: Pixels::F32(p) }
    }

    #[test]
    fn percentiles_and_the_worst_place() {
        let map: Vec<f32> = (0..200).map(|i| ((i * 7) % 200) as f32 / 200.0).collect();
        let f = FlipFigures::of(&map, 20, Metric::Ldr, 67.0);
        assert_eq!([f.median, f.p75, f.p95, f.p99, f.max], [0.495, 0.745, 0.945, 0.985, 0.995]);
        assert_eq!(map[(f.worst[1] * 20 + f.worst[0]) as usize], f.max);
        assert!((f.mean - 0.4975).abs() < 1e-6);
    }

    #[test]
    fn equal_pictures_have_no_error() {
        for p in [bytes(4, (0..512).map(|i| (i % 251) as u8).collect()), floats(3, vec![0.3; 384])] {
            let f = compare(&p, &p, DEFAULT_PPD).unwrap().figures;
            assert_eq!((f.flip.mean, f.flip.max, f.rmse, f.rel_mse, f.bias), (0.0, 0.0, 0.0, 0.0, [0.0; 3]));
            assert_eq!((f.psnr(), f.alpha_rmse.unwrap_or(0.0)), (None, 0.0));
        }
    }

    #[test]
    fn figures_by_hand() {
        let mut p = vec![100u8; 384];
        let r = bytes(3, p.clone());
        p[3 * 37 + 1] = 200;
        let f = compare(&r, &bytes(3, p), DEFAULT_PPD).unwrap().figures;
        assert!((f.rmse - ((100.0f64 / 255.0).powi(2) / 384.0).sqrt()).abs() < 1e-7);
        let (a, b) = (f64::from(srgb_decode(100.0 / 255.0)), f64::from(srgb_decode(200.0 / 255.0)));
        assert!((f.rel_mse - (b - a) * (b - a) / (a * a + 0.01) / 384.0).abs() < 1e-6);
        assert!((f.bias[1] - (b - a) / 128.0).abs() < 1e-6 && f.bias[0] == 0.0);
        assert!(f.flip.max > 0.1 && f.flip.metric == Metric::Ldr);
        // The eye's blur spreads the spot over its neighbours, and its middle stays the worst.
        assert_eq!(f.flip.worst, [5, 2]);
    }

    #[test]
    fn a_hidden_colour_is_no_difference_but_a_hole_is() {
        let with = |c: u8, a: u8| bytes(4, (0..128).flat_map(|_| [c, c, c, a]).collect());
        assert_eq!(compare(&with(200, 0), &with(10, 0), DEFAULT_PPD).unwrap().figures.flip.max, 0.0);
        // Black on black is not seen; on white it is.
        let f = compare(&with(0, 255), &with(0, 0), DEFAULT_PPD).unwrap().figures;
        assert!(f.flip.mean > 0.9 && f.rmse == 0.0 && f.alpha_rmse == Some(1.0), "{f:?}");
        let opaque = bytes(3, vec![0; 384]);
        assert_eq!(compare(&with(0, 255), &opaque, DEFAULT_PPD).unwrap().figures.flip.max, 0.0);
    }

    #[test]
    fn what_does_not_compare_says_why() {
        let a = bytes(3, vec![0; 384]);
        let b = Image { width: 8, height: 16, ..a.clone() };
        let e = compare(&a, &b, DEFAULT_PPD).unwrap_err().to_string();
        assert!(e.contains("16 × 8") && e.contains("8 × 16"), "{e}");
        let e = compare(&a, &floats(3, vec![0.0; 384]), DEFAULT_PPD).unwrap_err().to_string();
        assert!(e.starts_with("the other picture holds linear light"), "{e}");
    }

    #[test]
    fn broken_samples_are_counted_and_black() {
        let mut p = vec![0.5; 384];
        let r = floats(3, p.clone());
        (p[0], p[30]) = (f32::NAN, f32::INFINITY);
        let f = compare(&r, &floats(3, p), DEFAULT_PPD).unwrap().figures;
        assert_eq!(f.not_finite, [0, 2]);
        assert!((f.rmse - (0.5 / 384.0f64).sqrt()).abs() < 1e-6 && f.flip.max > 0.0);
    }
}
