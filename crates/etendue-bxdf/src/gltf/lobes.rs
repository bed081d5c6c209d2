//! Which lobe a sample is drawn from.

/// Lobes by number.
pub(super) const COAT: usize = 0;
pub(super) const SHEEN: usize = 1;
pub(super) const SPECULAR: usize = 2;
pub(super) const DIFFUSE: usize = 3;
pub(super) const THROUGH: usize = 4;
pub(super) const FUZZ: usize = 5;
pub(super) const LOBES: usize = 6;

/// Probabilities in proportion to `weights`; a part of less than a millionth is never picked: one over its probability
/// could leave `f32`.
#[inline(always)]
pub(super) fn probabilities(mut weights: [f32; LOBES]) -> [f32; LOBES] {
    let total: f32 = weights.iter().sum();
    let least = 1e-6 * total;
    for w in &mut weights {
        if !(*w > least) {
            *w = 0.0;
        }
    }
    let total: f32 = weights.iter().sum();
    if total > 0.0 && total < f32::INFINITY {
        weights.map(|w| w / total)
    } else {
        let mut only = [0.0; LOBES];
        only[SPECULAR] = 1.0;
        only
    }
}

/// The lobe that `uc` picks, and `uc` stretched to 0..1 within it.
#[inline(always)]
pub(super) fn pick(p: &[f32; LOBES], uc: f32) -> (usize, f32) {
    let mut left = uc.max(0.0);
    let mut last = SPECULAR;
    for (i, &p) in p.iter().enumerate() {
        if p > 0.0 {
            if left < p {
                return (i, (left / p).min(1.0));
            }
            left -= p;
            last = i;
        }
    }
    // Rounding at the upper end.
    (last, 1.0)
}
