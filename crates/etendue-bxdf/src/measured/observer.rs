//! From spectra to the three colours of Rec.709.

/// The CIE 1931 2° observer x̄, ȳ, z̄ and the illuminant D65, each 10 nm from 380 to 780 nm (CIE 015:2018).
const OBSERVER: [[f64; 4]; 41] = [
    [0.001368, 0.000039, 0.006450, 49.9755],
    [0.004243, 0.000120, 0.020050, 54.6482],
    [0.014310, 0.000396, 0.067850, 82.7549],
    [0.043510, 0.001210, 0.207400, 91.4860],
    [0.134380, 0.004000, 0.645600, 93.4318],
    [0.283900, 0.011600, 1.385600, 86.6823],
    [0.348280, 0.023000, 1.747060, 104.8650],
    [0.336200, 0.038000, 1.772110, 117.0080],
    [0.290800, 0.060000, 1.669200, 117.8120],
    [0.195360, 0.090980, 1.287640, 114.8610],
    [0.095640, 0.139020, 0.812950, 115.9230],
    [0.032010, 0.208020, 0.465180, 108.8110],
    [0.004900, 0.323000, 0.272000, 109.3540],
    [0.009300, 0.503000, 0.158200, 107.8020],
    [0.063270, 0.710000, 0.078250, 104.7900],
    [0.165500, 0.862000, 0.042160, 107.6890],
    [0.290400, 0.954000, 0.020300, 104.4050],
    [0.433450, 0.994950, 0.008750, 104.0460],
    [0.594500, 0.995000, 0.003900, 100.0000],
    [0.762100, 0.952000, 0.002100, 96.3342],
    [0.916300, 0.870000, 0.001650, 95.7880],
    [1.026300, 0.757000, 0.001100, 88.6856],
    [1.062200, 0.631000, 0.000800, 90.0062],
    [1.002600, 0.503000, 0.000340, 89.5991],
    [0.854450, 0.381000, 0.000190, 87.6987],
    [0.642400, 0.265000, 0.000050, 83.2886],
    [0.447900, 0.175000, 0.000020, 83.6992],
    [0.283500, 0.107000, 0.000000, 80.0268],
    [0.164900, 0.061000, 0.000000, 80.2146],
    [0.087400, 0.032000, 0.000000, 82.2778],
    [0.046770, 0.017000, 0.000000, 78.2842],
    [0.022700, 0.008210, 0.000000, 69.7213],
    [0.011359, 0.004102, 0.000000, 71.6091],
    [0.005790, 0.002091, 0.000000, 74.3490],
    [0.002899, 0.001047, 0.000000, 61.6040],
    [0.001440, 0.000520, 0.000000, 69.8856],
    [0.000690, 0.000249, 0.000000, 75.0870],
    [0.000332, 0.000120, 0.000000, 63.5927],
    [0.000166, 0.000060, 0.000000, 46.4182],
    [0.000083, 0.000030, 0.000000, 66.8054],
    [0.000042, 0.000015, 0.000000, 63.3828],
];
const FIRST: f64 = 380.0;
const STEP: f64 = 10.0;

/// CIE XYZ to linear Rec.709 (ITU-R BT.709-6's primaries and white); the scale of each row falls out of the weights.
const TO_REC709: [[f64; 3]; 3] = [
    [3.240_454_2, -1.537_138_5, -0.498_531_4],
    [-0.969_266_0, 1.876_010_8, 0.041_556_0],
    [0.055_643_4, -0.204_025_9, 1.057_225_2],
];

/// For each of increasing `wavelengths` (nanometres) the weights by which its reflectance counts in linear Rec.709 red, green
/// and blue.
///
/// A reflectance is linear between the wavelengths and held beyond them; it is seen by the CIE 1931 observer under D65,
/// relative to a perfect reflector: each colour's weights sum to one. They may be negative, for colours outside Rec.709.
pub(super) fn rec709_weights(wavelengths: &[f32]) -> Vec<[f64; 3]> {
    let mut weights = vec![[0.0f64; 3]; wavelengths.len()];
    // One nanometre at a time, the observer linear between its rows.
    for n in 0..=400 {
        let at = n as f64 / STEP;
        let (i, t) =
            ((at as usize).min(OBSERVER.len() - 2), at - (at as usize).min(OBSERVER.len() - 2) as f64);
        let [x, y, z, light] = core::array::from_fn(|c| OBSERVER[i][c] * (1.0 - t) + OBSERVER[i + 1][c] * t);
        let rgb = TO_REC709.map(|[a, b, c]| (a * x + b * y + c * z) * light);
        let (k, t) = super::warp::interval(wavelengths, (FIRST + n as f64) as f32);
        for c in 0..3 {
            weights[k][c] += rgb[c] * (1.0 - t as f64);
            if let Some(next) = weights.get_mut(k + 1) {
                next[c] += rgb[c] * t as f64;
            }
        }
    }
    for c in 0..3 {
        let sum: f64 = weights.iter().map(|w| w[c]).sum();
        weights.iter_mut().for_each(|w| w[c] /= sum);
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_is_white_and_narrow_bands_have_their_hues() {
        let wavelengths: Vec<f32> = (0..=54).map(|i| 360.0 + 10.0 * i as f32).collect();
        let weights = rec709_weights(&wavelengths);
        let seen = |f: &dyn Fn(f32) -> f64| -> [f64; 3] {
            core::array::from_fn(|c| weights.iter().zip(&wavelengths).map(|(w, &l)| w[c] * f(l)).sum())
        };
        let white = seen(&|_| 1.0);
        assert!(white.iter().all(|v| (v - 1.0).abs() < 1e-12), "{white:?}");
        let [r, g, b] = seen(&|l| if l > 600.0 { 1.0 } else { 0.0 });
        assert!(r > 0.6 && g < 0.3 && b < 0.05 && r > 4.0 * g.abs(), "{r} {g} {b}");
        let [r, g, b] = seen(&|l| if l < 480.0 { 1.0 } else { 0.0 });
        assert!(b > 0.6 && r < 0.3 && g < 0.1, "{r} {g} {b}");
        // The coordinates of D65 from the same rows: x = 0.3127, y = 0.3290.
        let sum = |c: usize| OBSERVER.iter().map(|row| row[c] * row[3]).sum::<f64>();
        let (x, y, z) = (sum(0), sum(1), sum(2));
        assert!((x / (x + y + z) - 0.3127).abs() < 1e-3 && (y / (x + y + z) - 0.3290).abs() < 1e-3);
        // Few bands, held beyond their ends, still make white of white; one band makes grey.
        assert_eq!(rec709_weights(&[550.0]), [[1.0; 3]]);
        let few = rec709_weights(&[450.0, 500.0, 550.0, 600.0, 650.0]);
        for c in 0..3 {
            assert!((few.iter().map(|w| w[c]).sum::<f64>() - 1.0).abs() < 1e-12);
        }
    }
}
