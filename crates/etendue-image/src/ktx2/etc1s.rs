//! ETC1S under BasisLZ: codebooks of colours and of patterns, and per picture the numbers of each block's two entries (KTX
//! 2.0, section 5).

use super::descriptor::Descriptor;
use super::huffman::{BitReader, Huffman, damaged};
use super::{Channel, F, Texels};
use crate::{ImageError, Pixels};

/// A colour of five bits per channel and which of eight contrasts go with it.
#[derive(Clone, Copy, Default)]
struct Endpoint {
    color: [u8; 3],
    contrast: u8,
}

/// Which of the four shades each texel has, two bits each: bytes are rows.
type Selector = [u8; 4];

/// What lightens and darkens a colour (ETC1's table).
const CONTRASTS: [[i16; 4]; 8] = [
    [-8, -2, 2, 8],
    [-17, -5, 5, 17],
    [-29, -9, 9, 29],
    [-42, -13, 13, 42],
    [-60, -18, 18, 60],
    [-80, -24, 24, 80],
    [-106, -33, 33, 106],
    [-183, -47, 47, 183],
];

/// Where a picture's streams are in its mip.
#[derive(Clone, Copy)]
struct Slices {
    /// Offset and length of the colours, then of the second stream.
    parts: [(u32, u32); 2],
}

/// The global data: codebooks and codes.
pub(super) struct Codebooks {
    endpoints: Vec<Endpoint>,
    selectors: Vec<Selector>,
    predictor: Huffman,
    delta: Huffman,
    selector: Huffman,
    run: Huffman,
    /// Number of selectors that are remembered.
    history: usize,
    slices: Vec<Slices>,
}

impl Codebooks {
    /// Reads the global data of a file with `images` pictures (KTX 2.0, 3.9.1).
    pub fn read(bytes: &[u8], images: u64) -> Result<Self, ImageError> {
        let cut = || damaged("the codebooks are cut off");
        let (head, rest) = bytes.split_first_chunk::<20>().ok_or_else(cut)?;
        let short = |i: usize| usize::from(u16::from_le_bytes([head[i], head[i + 1]]));
        let long = |i: usize| u32::from_le_bytes([head[i], head[i + 1], head[i + 2], head[i + 3]]) as usize;
        let described = images.checked_mul(20).and_then(|n| usize::try_from(n).ok()).ok_or_else(cut)?;
        let (descriptions, rest) = rest.split_at_checked(described).ok_or_else(cut)?;
        let (endpoints, rest) = rest.split_at_checked(long(4)).ok_or_else(cut)?;
        let (selectors, rest) = rest.split_at_checked(long(8)).ok_or_else(cut)?;
        let tables = rest.get(..long(12)).ok_or_else(cut)?;
        if rest.len() != tables.len() || long(16) != 0 {
            return Err(damaged("the codebooks have not the sizes that they say"));
        }
        let slices = descriptions.as_chunks::<20>().0.iter().map(Slices::read).collect::<Result<_, _>>()?;
        let mut r = BitReader::new(tables);
        let mut code = || -> Result<Huffman, ImageError> {
            let h = Huffman::read(&mut r)?;
            if h.is_empty() { Err(damaged("an empty code")) } else { Ok(h) }
        };
        let (predictor, delta, selector, run) = (code()?, code()?, code()?, code()?);
        let history = r.take(13) as usize;
        r.check()?;
        if history == 0 {
            return Err(damaged("no room for earlier selectors"));
        }
        let endpoints = read_endpoints(endpoints, short(0))?;
        let selectors = read_selectors(selectors, short(2))?;
        Ok(Self { endpoints, selectors, predictor, delta, selector, run, history, slices })
    }

    /// Refuses pictures whose streams are outside of their mips (of so many `bytes`, one for each picture) or are not as many as `samples`.
    pub fn check(&self, bytes: impl Iterator<Item = usize>, samples: usize) -> Result<(), ImageError> {
        for (slices, bytes) in self.slices.iter().zip(bytes) {
            for (i, (offset, length)) in slices.parts.into_iter().enumerate() {
                let there = length > 0;
                if there != (i < samples) || u64::from(offset) + u64::from(length) > bytes as u64 {
                    return Err(damaged("a stream is outside of its mip, missing, or one too many"));
                }
            }
        }
        Ok(())
    }

    /// Decodes picture `index` from its mip's bytes.
    pub fn image(
        &self,
        index: usize,
        level: &[u8],
        width: u32,
        height: u32,
        d: &Descriptor,
    ) -> Result<Texels, ImageError> {
        let slices = self.slices.get(index).ok_or_else(|| damaged("a picture without a description"))?;
        let stream = |i: usize| {
            let (offset, length) = slices.parts[i];
            let end = u64::from(offset) + u64::from(length);
            let part = usize::try_from(end).ok().and_then(|end| level.get(offset as usize..end));
            part.filter(|p| !p.is_empty()).ok_or_else(|| damaged("a stream is outside of its mip"))
        };
        let c = Channel::From;
        let first = d.samples[0].channel;
        let second = d.samples.get(1).map(|s| s.channel);
        // What the one or two streams hold (table 5.29).
        let map = match (first, second) {
            (0, None) => [c(0), c(1), c(2), Channel::One],
            (0, Some(15)) => [c(0), c(1), c(2), c(3)],
            (3, None) => [c(0), c(0), c(0), Channel::One],
            (3, Some(15)) => [c(0), c(0), c(0), c(3)],
            (3, Some(4)) => [c(0), c(3), Channel::Zero, Channel::One],
            _ => return Err(ImageError::unsupported(F, "ETC1S in unusual channels")),
        };
        let (w, h) = (width as usize, height as usize);
        let mut out = vec![255; w * h * 4];
        self.blocks(stream(0)?, w, h, |x, y, colors, selector| {
            texels(&mut out, (w, h), (x, y), selector, |texel, shade| {
                texel[..3].copy_from_slice(&colors[shade])
            });
        })?;
        if second.is_some() {
            self.blocks(stream(1)?, w, h, |x, y, colors, selector| {
                texels(&mut out, (w, h), (x, y), selector, |texel, shade| texel[3] = colors[shade][1]);
            })?;
        }
        Ok(Texels { width, height, channels: 4, pixels: Pixels::U8(out), map })
    }

    /// Walks the blocks of a stream (5.4): gives the place, the four shades and the pattern of each.
    fn blocks(
        &self,
        bytes: &[u8],
        width: usize,
        height: usize,
        mut put: impl FnMut(usize, usize, &[[u8; 3]; 4], Selector),
    ) -> Result<(), ImageError> {
        let (across, down) = (width.div_ceil(4), height.div_ceil(4));
        let mut r = BitReader::new(bytes);
        let mut recent = Recent::new(self.history);
        // Endpoints of the row above and of this one; predictors of a row that go with the one above.
        let mut above = vec![0u32; across];
        let mut row = vec![0u32; across];
        let mut kept = vec![0u8; across];
        let (mut last, mut last_pair, mut pair_runs, mut runs) = (0, 0u32, 0u32, 0u32);
        let outside = || damaged("a block refers to one outside of the picture");
        for y in 0..down {
            let mut pair = 0;
            for x in 0..across {
                // Predictors come for two by two blocks at once.
                if x % 2 == 0 {
                    pair = if y % 2 == 1 {
                        kept[x].into()
                    } else {
                        if pair_runs > 0 {
                            pair_runs -= 1;
                        } else {
                            match self.predictor.symbol(&mut r)? {
                                // The last pair again, several times.
                                256 => pair_runs = r.variable(4).saturating_add(2),
                                n => last_pair = n,
                            }
                        }
                        kept[x] = (last_pair >> 4) as u8;
                        last_pair
                    };
                }
                last = match pair & 3 {
                    0 if x > 0 => last,
                    1 if y > 0 => above[x],
                    2 if x > 0 && y > 0 => above[x - 1],
                    3 => {
                        let n = last + self.delta.symbol(&mut r)?;
                        let all = self.endpoints.len() as u32;
                        if n >= all { n - all } else { n }
                    }
                    _ => return Err(outside()),
                };
                pair >>= 2;
                row[x] = last;
                let selector = if runs > 0 {
                    runs -= 1;
                    recent.newest()
                } else {
                    self.next_selector(&mut r, &mut recent, &mut runs)?
                };
                let endpoint = self.endpoints.get(last as usize);
                let endpoint = endpoint.ok_or_else(|| damaged("a colour that is not in the codebook"))?;
                let selector = self.selectors.get(selector as usize);
                let selector = selector.ok_or_else(|| damaged("a pattern that is not in the codebook"))?;
                put(x, y, &endpoint.shades(), *selector);
            }
            std::mem::swap(&mut above, &mut row);
        }
        r.check()
    }

    /// The number of the next pattern: its own, or that of an earlier one.
    #[inline(always)]
    fn next_selector(
        &self,
        r: &mut BitReader<'_>,
        recent: &mut Recent,
        runs: &mut u32,
    ) -> Result<u32, ImageError> {
        let symbol = self.selector.symbol(r)?;
        let Some(back) = symbol.checked_sub(self.selectors.len() as u32) else {
            recent.add(symbol);
            return Ok(symbol);
        };
        if back as usize == self.history {
            // The newest remembered one, several times.
            let n = match self.run.symbol(r)? {
                63 => r.variable(7).saturating_add(3),
                n => n + 3,
            };
            *runs = n - 1;
            return Ok(recent.newest());
        }
        recent.promote(back as usize).ok_or_else(|| damaged("an earlier pattern that there is not"))
    }
}

impl Slices {
    fn read(b: &[u8; 20]) -> Result<Self, ImageError> {
        let word = |i: usize| u32::from_le_bytes([b[i], b[i + 1], b[i + 2], b[i + 3]]);
        if word(0) & 2 != 0 {
            return Err(ImageError::unsupported(F, "frames of a video"));
        }
        if word(0) != 0 {
            return Err(damaged("a picture has flags that are not known"));
        }
        Ok(Self { parts: [(word(4), word(8)), (word(12), word(16))] })
    }
}

impl Endpoint {
    /// The four colours, darkest first.
    #[inline(always)]
    fn shades(&self) -> [[u8; 3]; 4] {
        let base = self.color.map(|c| i16::from(c << 3 | c >> 2));
        CONTRASTS[usize::from(self.contrast)].map(|d| base.map(|c| (c + d).clamp(0, 255) as u8))
    }
}

/// Hands the texels of a block that lie within the picture to `put`, with their shades.
#[inline(always)]
fn texels(
    out: &mut [u8],
    (width, height): (usize, usize),
    (x, y): (usize, usize),
    selector: Selector,
    put: impl Fn(&mut [u8], usize),
) {
    for (dy, row) in selector.iter().enumerate().take(height - 4 * y) {
        let line = &mut out[4 * ((4 * y + dy) * width + 4 * x)..];
        for (dx, texel) in line.chunks_exact_mut(4).enumerate().take(4.min(width - 4 * x)) {
            put(texel, usize::from(row >> (2 * dx) & 3));
        }
    }
}

/// Patterns that were used lately, the often used in front (5.4.3).
struct Recent {
    items: Vec<u32>,
    /// Where the next new one goes: always in the second half.
    next: usize,
}

impl Recent {
    fn new(size: usize) -> Self {
        Self { items: vec![0; size], next: size / 2 }
    }

    fn add(&mut self, n: u32) {
        self.items[self.next] = n;
        self.next += 1;
        if self.next == self.items.len() {
            self.next = self.items.len() / 2;
        }
    }

    /// The one in front.
    fn newest(&self) -> u32 {
        self.items[0]
    }

    /// The `i`th, which moves half the way to the front.
    fn promote(&mut self, i: usize) -> Option<u32> {
        let n = *self.items.get(i)?;
        self.items.swap(i, i / 2);
        Some(n)
    }
}

/// The codebook of colours (5.3.1).
fn read_endpoints(bytes: &[u8], count: usize) -> Result<Vec<Endpoint>, ImageError> {
    let mut r = BitReader::new(bytes);
    // Which code a difference has depends on the value before it.
    let (low, middle, high, contrast) =
        (Huffman::read(&mut r)?, Huffman::read(&mut r)?, Huffman::read(&mut r)?, Huffman::read(&mut r)?);
    let grey = r.take(1) == 1;
    let mut last = Endpoint { color: [16; 3], contrast: 0 };
    let mut out = Vec::with_capacity(count);
    for _ in 0..count {
        last.contrast = ((u32::from(last.contrast) + contrast.symbol(&mut r)?) & 7) as u8;
        for c in &mut last.color[..if grey { 1 } else { 3 }] {
            let code = match *c {
                0..=9 => &low,
                10..=21 => &middle,
                _ => &high,
            };
            *c = ((u32::from(*c) + code.symbol(&mut r)?) & 31) as u8;
        }
        let [red, ..] = last.color;
        out.push(if grey { Endpoint { color: [red; 3], ..last } } else { last });
    }
    r.check()?;
    Ok(out)
}

/// The codebook of patterns (5.3.2).
fn read_selectors(bytes: &[u8], count: usize) -> Result<Vec<Selector>, ImageError> {
    let mut r = BitReader::new(bytes);
    if r.take(2) != 0 {
        return Err(damaged("codebooks of patterns that files do not hold"));
    }
    let raw = r.take(1) == 1;
    let code = if raw { None } else { Some(Huffman::read(&mut r)?) };
    let mut out: Vec<Selector> = Vec::with_capacity(count);
    for i in 0..count {
        let mut rows = [0; 4];
        for (k, row) in rows.iter_mut().enumerate() {
            *row = match (&code, i.checked_sub(1)) {
                // Exclusive or with the pattern before.
                (Some(code), Some(last)) => out[last][k] ^ code.symbol(&mut r)? as u8,
                _ => r.take(8) as u8,
            };
        }
        out.push(rows);
        r.check()?;
    }
    Ok(out)
}
