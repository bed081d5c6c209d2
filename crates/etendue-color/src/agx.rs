//! The AgX tone curve, with its sigmoid evaluated exactly.
//!
//! Troy Sobotka, "AgX" (2022, <https://github.com/sobotka/AgX>), base look, Rec.709 display:
//!
//! 1. light is desaturated towards the inside of the gamut by the inset matrix;
//! 2. its logarithm is taken: from 10 stops below middle grey (0.18) to 6.5 stops above, mapped to 0..1;
//! 3. a sigmoid with slope 2 at middle grey (which it takes to one half), toe power 3 and shoulder power 3.25 is applied;
//! 4. the inverse of the inset brings saturation back, and the result is what a display of gamma 2.2 is sent.
//!
//! Benjamin Wrensch, "Minimal AgX Implementation" (2023, <https://iolite-engine.com/blog_posts/minimal_agx_implementation>)
//! replaces the sigmoid by a polynomial of sixth degree; the test below measures how far that is.

/// Step 1, rows; the numbers of Wrensch's listing (there in columns).
const INSET: [[f32; 3]; 3] = [
    [0.842_479_06, 0.078_433_6, 0.079_223_745],
    [0.042_328_242, 0.878_468_64, 0.079_166_13],
    [0.042_375_655, 0.078_433_6, 0.879_142_97],
];

/// Step 4, the inverse of [`INSET`].
const OUTSET: [[f32; 3]; 3] = [
    [1.196_879, -0.098_020_88, -0.099_029_74],
    [-0.052_896_85, 1.151_903_1, -0.098_961_18],
    [-0.052_971_635, -0.098_043_45, 1.151_073_7],
];

/// log₂ 0.18 − 10 and log₂ 0.18 + 6.5.
const MIN_EV: f32 = -12.473_931;
const MAX_EV: f32 = 4.026_069;

/// Where the sigmoid pivots: middle grey, 10 of 16.5 stops up, comes out at one half.
const PIVOT: [f32; 2] = [10.0 / 16.5, 0.5];
const SLOPE: f32 = 2.0;
const TOE_POWER: f32 = 3.0;
const SHOULDER_POWER: f32 = 3.25;

/// Sobotka's sigmoid on 0..1: on each side of the pivot a generalised hyperbola `t / (1 + tᵖ)^(1/p)`, scaled so that
/// it leaves the pivot with the given slope and ends exactly in the corner (0, 0) or (1, 1).
fn sigmoid(x: f32) -> f32 {
    let upper = x >= PIVOT[0];
    let (room_x, room_y, power, sign) = if upper {
        (1.0 - PIVOT[0], 1.0 - PIVOT[1], SHOULDER_POWER, 1.0)
    } else {
        (PIVOT[0], PIVOT[1], TOE_POWER, -1.0)
    };
    let a = (SLOPE * room_x).powf(-power);
    let b = (SLOPE * room_x / room_y).powf(power) - 1.0;
    let scale = (a * b).powf(-1.0 / power);
    let t = (SLOPE * (x - PIVOT[0])).abs() / scale;
    PIVOT[1] + sign * scale * t / (1.0 + t.powf(power)).powf(1.0 / power)
}

fn mul(m: &[[f32; 3]; 3], v: [f32; 3]) -> [f32; 3] {
    m.map(|r| r[0] * v[0] + r[1] * v[1] + r[2] * v[2])
}

/// Non-negative finite scene light to display light, not yet clamped.
pub(crate) fn agx(c: [f32; 3]) -> [f32; 3] {
    let c = mul(&INSET, c).map(|v| {
        let ev = v.max(1e-10).log2().clamp(MIN_EV, MAX_EV);
        sigmoid((ev - MIN_EV) / (MAX_EV - MIN_EV))
    });
    mul(&OUTSET, c).map(|v| v.max(0.0).powf(2.2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sigmoid_ends_in_the_corners_and_pivots_at_grey() {
        assert!(sigmoid(0.0).abs() < 1e-6 && (sigmoid(1.0) - 1.0).abs() < 1e-6);
        assert!((sigmoid(PIVOT[0]) - 0.5).abs() < 1e-6);
        let slope = (sigmoid(PIVOT[0] + 1e-3) - sigmoid(PIVOT[0] - 1e-3)) / 2e-3;
        assert!((slope - 2.0).abs() < 1e-3, "{slope}");
    }

    #[test]
    fn near_the_published_polynomial() {
        // Wrensch's fit, "mean error² 3.67e-6", coefficients from his listing.
        let mut sum = 0.0;
        for i in 0..=1000 {
            let x = i as f32 / 1000.0;
            let (x2, x4) = (x * x, x * x * x * x);
            let fit =
                15.5 * x4 * x2 - 40.14 * x4 * x + 31.96 * x4 - 6.868 * x2 * x + 0.4298 * x2 + 0.1191 * x
                    - 0.00232;
            assert!((fit - sigmoid(x)).abs() < 0.006, "{x}: {fit} and {}", sigmoid(x));
            sum += (fit - sigmoid(x)).powi(2) / 1001.0;
        }
        assert!(sum < 1e-5, "{sum}");
    }

    #[test]
    fn outset_inverts_inset() {
        for i in 0..3 {
            let mut e = [0.0; 3];
            e[i] = 1.0;
            let back = mul(&OUTSET, mul(&INSET, e));
            assert!((0..3).all(|j| (back[j] - e[j]).abs() < 2e-6), "{back:?}");
        }
    }
}
