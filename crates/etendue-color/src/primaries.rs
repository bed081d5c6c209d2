//! RGB spaces by their primaries, and the matrices between them.
//!
//! All matrices are derived here from chromaticities, in double precision: the normalised primary matrix of SMPTE RP
//! 177-1993, section 3.3, and the Bradford adaptation of Lam (1985) as given by ICC.1:2022, annex E.

/// A matrix of three rows.
pub type Matrix3 = [[f64; 3]; 3];

/// CIE 1931 (x, y) chromaticities of an RGB space's primaries and white.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Primaries {
    /// Red.
    pub red: [f64; 2],
    /// Green.
    pub green: [f64; 2],
    /// Blue.
    pub blue: [f64; 2],
    /// White: what (1, 1, 1) looks like.
    pub white: [f64; 2],
}

/// Rec. ITU-R BT.709-6, items 1.3 and 1.4 (and sRGB, IEC 61966-2-1): the space of all linear RGB in this program. White is D65.
pub const REC709: Primaries =
    Primaries { red: [0.640, 0.330], green: [0.300, 0.600], blue: [0.150, 0.060], white: [0.3127, 0.3290] };

/// ACES2065-1 (SMPTE ST 2065-1:2021, table 2): primaries AP0 that enclose all visible colours.
pub const ACES_AP0: Primaries = Primaries {
    red: [0.7347, 0.2653],
    green: [0.0, 1.0],
    blue: [0.0001, -0.0770],
    white: [0.32168, 0.33767],
};

/// ACEScg (Academy S-2014-004, table 1): primaries AP1, for rendering and grading.
pub const ACES_AP1: Primaries =
    Primaries { red: [0.713, 0.293], green: [0.165, 0.830], blue: [0.128, 0.044], white: [0.32168, 0.33767] };

/// XYZ of a chromaticity at Y = 1; `None` where y is zero or not finite.
fn xyz_of(c: [f64; 2]) -> Option<[f64; 3]> {
    let [x, y] = c;
    (x.is_finite() && y.is_finite() && y.abs() > 1e-12).then(|| [x / y, 1.0, (1.0 - x - y) / y])
}

/// The matrix that takes RGB with these primaries to CIE XYZ, (1, 1, 1) to the white at Y = 1.
///
/// `None` when the primaries span no space (they lie on a line, or the white's y is zero).
pub fn rgb_to_xyz(p: &Primaries) -> Option<Matrix3> {
    // Columns are the primaries as (x, y, z); SMPTE RP 177-1993, equation 3.3.5 scales them so that they sum up to white.
    let column = |c: [f64; 2]| [c[0], c[1], 1.0 - c[0] - c[1]];
    let (r, g, b) = (column(p.red), column(p.green), column(p.blue));
    let m = [[r[0], g[0], b[0]], [r[1], g[1], b[1]], [r[2], g[2], b[2]]];
    let scale = matrix_apply(&matrix_inverse(&m)?, xyz_of(p.white)?);
    Some(m.map(|row| [row[0] * scale[0], row[1] * scale[1], row[2] * scale[2]]))
}

/// The inverse of [`rgb_to_xyz`].
pub fn xyz_to_rgb(p: &Primaries) -> Option<Matrix3> {
    matrix_inverse(&rgb_to_xyz(p)?)
}

/// The Bradford adaptation of XYZ colours from one white to another, both as (x, y).
pub fn bradford(from: [f64; 2], to: [f64; 2]) -> Option<Matrix3> {
    const CONE: Matrix3 = [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]];
    let (a, b) = (matrix_apply(&CONE, xyz_of(from)?), matrix_apply(&CONE, xyz_of(to)?));
    if a.iter().any(|v| v.abs() < 1e-9) {
        return None;
    }
    let mut scaled = CONE;
    for (i, row) in scaled.iter_mut().enumerate() {
        row.iter_mut().for_each(|v| *v *= b[i] / a[i]);
    }
    Some(matrix_mul(&matrix_inverse(&CONE)?, &scaled))
}

/// The matrix between two linear RGB spaces that keeps white white (Bradford adaptation where the whites differ).
///
/// ```
/// use etendue_color::{ACES_AP1, REC709, matrix_apply, rgb_to_rgb};
/// let m = rgb_to_rgb(&REC709, &ACES_AP1).unwrap();
/// let white = matrix_apply(&m, [1.0; 3]);
/// assert!(white.iter().all(|v| (v - 1.0).abs() < 1e-9));
/// ```
pub fn rgb_to_rgb(from: &Primaries, to: &Primaries) -> Option<Matrix3> {
    let mut m = rgb_to_xyz(from)?;
    if from.white != to.white {
        m = matrix_mul(&bradford(from.white, to.white)?, &m);
    }
    Some(matrix_mul(&xyz_to_rgb(to)?, &m))
}

/// `m · v`.
pub fn matrix_apply(m: &Matrix3, v: [f64; 3]) -> [f64; 3] {
    m.map(|r| r[0] * v[0] + r[1] * v[1] + r[2] * v[2])
}

/// `a · b`.
pub fn matrix_mul(a: &Matrix3, b: &Matrix3) -> Matrix3 {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
}

/// The inverse by the adjugate; `None` if the determinant is zero or not finite.
pub fn matrix_inverse(m: &Matrix3) -> Option<Matrix3> {
    let minor = |r: [usize; 2], c: [usize; 2]| m[r[0]][c[0]] * m[r[1]][c[1]] - m[r[0]][c[1]] * m[r[1]][c[0]];
    let others = |i: usize| [[1, 2], [0, 2], [0, 1]][i];
    let sign = |i: usize, j: usize| if (i + j).is_multiple_of(2) { 1.0 } else { -1.0 };
    let det: f64 = (0..3).map(|j| sign(0, j) * m[0][j] * minor([1, 2], others(j))).sum();
    if !det.is_finite() || det.abs() < 1e-12 {
        return None;
    }
    Some(std::array::from_fn(|i| std::array::from_fn(|j| sign(i, j) * minor(others(j), others(i)) / det)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: &Matrix3, b: &Matrix3, eps: f64) {
        for (x, y) in a.iter().flatten().zip(b.iter().flatten()) {
            assert!((x - y).abs() < eps, "{a:?}\n{b:?}");
        }
    }

    #[test]
    fn rec709_is_the_matrix_of_the_srgb_standard() {
        // IEC 61966-2-1, 5.2, printed to four digits.
        let m = rgb_to_xyz(&REC709).unwrap();
        close(&m, &[[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]], 5.1e-5);
    }

    #[test]
    fn ap0_and_ap1_are_the_matrices_of_the_academy() {
        // SMPTE ST 2065-1:2021, 4.3 (AP0 to XYZ) and Academy S-2014-004, 4.3 (AP1 to AP0).
        close(
            &rgb_to_xyz(&ACES_AP0).unwrap(),
            &[
                [0.952_552_395_9, 0.0, 0.000_093_678_6],
                [0.343_966_449_8, 0.728_166_096_6, -0.072_132_546_4],
                [0.0, 0.0, 1.008_825_184_4],
            ],
            1e-9,
        );
        close(
            &rgb_to_rgb(&ACES_AP1, &ACES_AP0).unwrap(),
            &[
                [0.695_452_241_4, 0.140_678_696_5, 0.163_869_062_2],
                [0.044_794_563_4, 0.859_671_118_5, 0.095_534_318_2],
                [-0.005_525_882_6, 0.004_025_210_3, 1.001_500_672_3],
            ],
            1e-9,
        );
    }

    #[test]
    fn degenerate_primaries_have_no_matrix() {
        let line = Primaries { red: [0.1, 0.1], green: [0.2, 0.2], blue: [0.3, 0.3], white: [0.3, 0.3] };
        assert_eq!(rgb_to_xyz(&line), None);
        assert_eq!(rgb_to_xyz(&Primaries { white: [0.3, 0.0], ..REC709 }), None);
        assert_eq!(rgb_to_xyz(&Primaries { red: [f64::NAN, 0.3], ..REC709 }), None);
    }

    #[test]
    fn there_and_back_is_identity() {
        let m =
            matrix_mul(&rgb_to_rgb(&REC709, &ACES_AP0).unwrap(), &rgb_to_rgb(&ACES_AP0, &REC709).unwrap());
        close(&m, &[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], 1e-12);
    }
}
