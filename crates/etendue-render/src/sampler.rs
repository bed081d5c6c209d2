//! Random numbers as a pure function of (seed, pixel, sample index, dimension).
//!
//! Sobol points of four dimensions at a time, Owen-scrambled by hashing, padded to any number of dimensions by
//! shuffling the index with another hash for each set of four (Burley 2020, "Practical Hash-based Owen Scrambling",
//! JCGT 9(4), section 5). There is no state: sample 17 of a pixel is the same whoever computes it, in any order.
//! The hash that scrambles is Laine and Karras' with the constants that Vegdahl found ("Building a Better LK Hash",
//! 2021).

/// One sample of one pixel.
#[derive(Clone, Copy, Debug)]
pub struct Sampler {
    seed: u32,
    index: u32,
}

/// Sobol direction numbers of the first four dimensions, bit-reversed, folded into a table per byte of the index.
static SOBOL: [[[u32; 4]; 256]; 4] = byte_tables();

/// Joe and Kuo's `new-joe-kuo-6` parameters (2008) of dimensions 2 to 4: degree, coefficients, initial m.
const JOE_KUO: [(u32, u32, [u32; 3]); 3] = [(1, 0, [1, 0, 0]), (2, 1, [1, 3, 0]), (3, 1, [1, 3, 1])];

const fn direction_numbers() -> [[u32; 4]; 32] {
    let mut v = [[0u32; 4]; 32];
    let mut i = 0;
    while i < 32 {
        v[i][0] = 1 << (31 - i);
        i += 1;
    }
    let mut d = 1;
    while d < 4 {
        let (s, a, m) = JOE_KUO[d - 1];
        let s = s as usize;
        let mut i = 0;
        while i < 32 {
            if i < s {
                v[i][d] = m[i] << (31 - i);
            } else {
                let mut x = v[i - s][d] ^ (v[i - s][d] >> s);
                let mut k = 1;
                while k < s {
                    if (a >> (s - 1 - k)) & 1 == 1 {
                        x ^= v[i - k][d];
                    }
                    k += 1;
                }
                v[i][d] = x;
            }
            i += 1;
        }
        d += 1;
    }
    v
}

const fn byte_tables() -> [[[u32; 4]; 256]; 4] {
    let v = direction_numbers();
    let mut t = [[[0u32; 4]; 256]; 4];
    let mut byte = 0;
    while byte < 4 {
        let mut value = 0;
        while value < 256 {
            let mut bit = 0;
            while bit < 8 {
                if (value >> bit) & 1 == 1 {
                    let mut d = 0;
                    while d < 4 {
                        t[byte][value][d] ^= v[byte * 8 + bit][d].reverse_bits();
                        d += 1;
                    }
                }
                bit += 1;
            }
            value += 1;
        }
        byte += 1;
    }
    t
}

/// Owen scrambling of a bit-reversed value: each bit is flipped by a hash of the bits below it.
#[inline(always)]
fn laine_karras(mut x: u32, seed: u32) -> u32 {
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^ x.wrapping_mul(0x53a2_2864)
}

/// A 32-bit mixer (Wellons' `lowbias32`).
#[inline(always)]
pub(crate) fn hash(mut x: u32) -> u32 {
    x ^= x >> 16;
    x = x.wrapping_mul(0x7feb_352d);
    x ^= x >> 15;
    x = x.wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

/// The upper 24 bits as a float in [0, 1).
#[inline(always)]
pub(crate) fn unit(x: u32) -> f32 {
    (x >> 8) as f32 * (1.0 / 16_777_216.0)
}

/// A moment for the sample `index`, as a part of the time that the shutter is open, in [0, 1): van der Corput's
/// sequence, Owen-scrambled by `seed`. Of the first 2^k samples, as of every later block of 2^k that begins at a multiple,
/// each of 2^k equal parts of the time holds one.
///
/// The dimensions of [`Sampler::get4`] take the index in an order of their own in each pixel, so that they are independent of
/// this one.
pub fn moment(seed: u32, index: u32) -> f64 {
    f64::from(moment_bits(seed, index)) / 4_294_967_296.0
}

/// The same as a binary fraction.
pub(crate) fn moment_bits(seed: u32, index: u32) -> u32 {
    laine_karras(index, hash(seed ^ 0x7f4a_7c15)).reverse_bits()
}

impl Sampler {
    /// Sample `index` of the pixel at (`x`, `y`) of the picture with this `seed`. The width of the picture is not part
    /// of the identity: a crop draws the same numbers as the whole.
    #[inline(always)]
    pub fn new(seed: u32, x: u32, y: u32, index: u32) -> Self {
        Self { seed: hash(x ^ hash(y ^ hash(seed.wrapping_add(0x9e37_79b9)))), index }
    }

    /// Four dimensions, jointly stratified over the samples of a pixel; `set` numbers the padding.
    #[inline(always)]
    pub fn get4(&self, set: u32) -> [f32; 4] {
        let key = hash(self.seed ^ set.wrapping_mul(0x9e37_79b9));
        let i = laine_karras(self.index.reverse_bits(), key).reverse_bits();
        let t = |b: usize| &SOBOL[b][(i >> (8 * b)) as usize & 255];
        let (a, b, c, d) = (t(0), t(1), t(2), t(3));
        let mut out = [0.0; 4];
        for k in 0..4 {
            let x = a[k] ^ b[k] ^ c[k] ^ d[k];
            let scramble = hash(key.wrapping_add(0x632b_e59b_u32.wrapping_mul(k as u32 + 1)));
            out[k] = unit(laine_karras(x, scramble).reverse_bits());
        }
        out
    }

    /// A number that is random over pixels, samples and `key` (not stratified), for choices that are made a data-dependent
    /// number of times, such as a ray's alpha tests.
    #[inline(always)]
    pub fn hash(&self, key: u32) -> u32 {
        hash(self.seed ^ hash(self.index ^ hash(key)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every elementary interval of area 1/N holds one of N = 2^k points: the definition of a (0, k, 2)-net in base 2,
    /// which Owen scrambling preserves. Breaks if a direction number, the reversal or the scramble is wrong.
    #[test]
    fn first_pair_is_a_net() {
        for (set, seed) in [(0, 0), (3, 1), (17, 99)] {
            let n = 256u32;
            let points: Vec<_> = (0..n).map(|i| Sampler::new(seed, 5, 9, i).get4(set)).collect();
            for log_w in 0..=8u32 {
                let (w, h) = (1 << log_w, n >> log_w);
                let mut seen = vec![0; n as usize];
                for p in &points {
                    let (x, y) = ((p[0] * w as f32) as u32, (p[1] * h as f32) as u32);
                    seen[(y * w + x) as usize] += 1;
                }
                assert!(seen.iter().all(|&c| c == 1), "set {set}: {w} × {h} cells are not hit once each");
            }
        }
    }

    /// Moments are stratified in every aligned block of 2^k samples, each seed has its own, and none is 1.
    #[test]
    fn moments_are_stratified() {
        for (seed, first) in [(0, 0), (1, 64), (9, 640)] {
            let mut seen = [false; 64];
            (first..first + 64).for_each(|i| seen[(moment(seed, i) * 64.0) as usize] = true);
            assert!(seen.iter().all(|&s| s), "seed {seed}, from {first}");
        }
        assert_ne!(moment(0, 0), moment(1, 0));
        assert!((0..100_000).all(|i| (0.0..1.0).contains(&moment(3, i))));
    }

    /// Each dimension alone is stratified, in every aligned block of 2^k samples.
    #[test]
    fn every_dimension_is_stratified() {
        for block in 0..3u32 {
            for d in 0..4 {
                let mut seen = [false; 64];
                for i in 0..64 {
                    let v = Sampler::new(7, 1, 2, block * 64 + i).get4(5)[d];
                    seen[(v * 64.0) as usize] = true;
                }
                assert!(seen.iter().all(|&s| s), "dimension {d}, block {block}");
            }
        }
    }

    /// Different sets, pixels and seeds are uncorrelated: |r| of 4096 pairs stays under 4σ = 4/√4096.
    #[test]
    fn sets_pixels_and_seeds_are_independent() {
        let n = 4096;
        let series =
            |seed, x, set| (0..n).map(move |i| Sampler::new(seed, x, 3, i).get4(set)[0] as f64 - 0.5);
        let correlation = |a: Vec<f64>, b: Vec<f64>| {
            let dot: f64 = a.iter().zip(&b).map(|(x, y)| x * y).sum();
            12.0 * dot / n as f64
        };
        let base: Vec<f64> = series(0, 3, 1).collect();
        for other in [series(0, 3, 2), series(0, 4, 1), series(1, 3, 1)] {
            let r = correlation(base.clone(), other.collect());
            assert!(r.abs() < 4.0 / 64.0, "correlation {r}");
        }
        assert!(correlation(base.clone(), base) > 0.9);
    }
}
