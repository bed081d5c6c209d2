//! Bits and symbols of BasisLZ (KTX 2.0, section 5.2).

use super::F;
use crate::ImageError;

/// Bits from the lowest of each byte up. Past the end come zeros; that too many were read is said by [`BitReader::check`].
pub(super) struct BitReader<'a> {
    bytes: &'a [u8],
    /// Bits that were read from the bytes and are not used yet, and how many.
    window: u64,
    held: u32,
    /// Zeros that were made up.
    missing: u32,
}

impl<'a> BitReader<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, window: 0, held: 0, missing: 0 }
    }

    /// Makes at least 32 bits available.
    #[inline(always)]
    fn fill(&mut self) {
        if self.held < 32 {
            let word = match self.bytes.split_first_chunk::<4>() {
                Some((w, rest)) => {
                    self.bytes = rest;
                    u32::from_le_bytes(*w)
                }
                None => {
                    let mut w = [0; 4];
                    w[..self.bytes.len()].copy_from_slice(self.bytes);
                    self.missing = self.missing.saturating_add(32 - 8 * self.bytes.len() as u32);
                    self.bytes = &[];
                    u32::from_le_bytes(w)
                }
            };
            self.window |= u64::from(word) << self.held;
            self.held += 32;
        }
    }

    /// The next `n` bits, 0 to 16.
    #[inline(always)]
    pub fn take(&mut self, n: u32) -> u32 {
        self.fill();
        let v = self.window as u32 & ((1 << n) - 1);
        self.skip(n);
        v
    }

    #[inline(always)]
    fn skip(&mut self, n: u32) {
        self.window >>= n;
        self.held -= n;
    }

    /// A number in groups of `n` bits, the lowest first, each followed by a bit that says whether more come; what does not
    /// fit into 32 bits is lost.
    pub fn variable(&mut self, n: u32) -> u32 {
        let (mut v, mut shift) = (0u32, 0);
        while shift < 32 {
            v |= self.take(n) << shift;
            shift += n;
            if self.take(1) == 0 {
                break;
            }
        }
        v
    }

    /// Whether more bits were used than there were.
    fn overrun(&self) -> bool {
        self.missing > self.held
    }

    /// An error if more bits were used than there were.
    pub fn check(&self) -> Result<(), ImageError> {
        if self.overrun() { Err(damaged("a stream ends too early")) } else { Ok(()) }
    }
}

pub(super) fn damaged(cause: &str) -> ImageError {
    ImageError::damaged(F, format!("ETC1S: {cause}"))
}

/// Longest code, bits.
const LONGEST: usize = 16;
/// Codes up to this length are looked up at once.
const QUICK: u32 = 10;
const CODE_LENGTHS: usize = 21;

/// The order in which the lengths of the code lengths' own codes are given.
const ORDER: [u8; CODE_LENGTHS] = [17, 18, 19, 20, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15, 16];

/// A canonical Huffman code.
pub(super) struct Huffman {
    /// By the next bits: symbol and length; a length of 0 stands for longer codes.
    quick: Vec<(u16, u8)>,
    /// Per length: its first code, the number of its codes, and where its symbols start.
    lengths: [(u32, u32, u32); LONGEST + 1],
    /// By length, then by number.
    symbols: Vec<u16>,
}

impl Huffman {
    /// The code whose symbol `i` has `lengths[i]` bits (0: it does not occur).
    fn new(of: &[u8]) -> Result<Self, ImageError> {
        let mut lengths = [(0u32, 0u32, 0u32); LONGEST + 1];
        for &n in of {
            lengths[usize::from(n)].1 += 1;
        }
        lengths[0].1 = 0;
        let (mut code, mut start) = (0, 0);
        for l in &mut lengths[1..] {
            code <<= 1;
            (l.0, l.2) = (code, start);
            code += l.1;
            start += l.1;
        }
        // Complete, but for a code of a single symbol (or of none, which decodes nothing).
        if start > 1 && code != 1 << LONGEST {
            return Err(damaged("a code whose lengths do not fit together"));
        }
        let mut symbols: Vec<u16> = (0..of.len()).filter(|&i| of[i] > 0).map(|i| i as u16).collect();
        symbols.sort_by_key(|&i| of[usize::from(i)]);
        let mut quick = vec![(0, 0); 1 << QUICK];
        for n in 1..=QUICK {
            let (first, count, start) = lengths[n as usize];
            for i in 0..count {
                // The stream has a code's highest bit first.
                let reversed = (first + i).reverse_bits() >> (32 - n);
                for slot in (reversed as usize..quick.len()).step_by(1 << n) {
                    quick[slot] = (symbols[(start + i) as usize], n as u8);
                }
            }
        }
        Ok(Self { quick, lengths, symbols })
    }

    /// Reads the lengths of a code, which are themselves coded.
    pub fn read(r: &mut BitReader<'_>) -> Result<Self, ImageError> {
        let count = r.take(14) as usize;
        if count == 0 {
            return Self::new(&[]);
        }
        let given = r.take(5) as usize;
        if given == 0 || given > CODE_LENGTHS {
            return Err(damaged("a code without lengths"));
        }
        let mut own = [0; CODE_LENGTHS];
        for &i in &ORDER[..given] {
            own[usize::from(i)] = r.take(3) as u8;
        }
        let own = Self::new(&own)?;
        let mut lengths: Vec<u8> = Vec::with_capacity(count);
        while lengths.len() < count {
            let (value, times) = match own.symbol(r)? {
                n @ 0..=16 => (n as u8, 1),
                17 => (0, 3 + r.take(3)),
                18 => (0, 11 + r.take(7)),
                n => {
                    let last = lengths.last().copied().filter(|&l| l > 0);
                    let last = last.ok_or_else(|| damaged("a repeated length without one before"))?;
                    (last, if n == 19 { 3 + r.take(2) } else { 7 + r.take(7) })
                }
            };
            lengths.extend(std::iter::repeat_n(value, times as usize));
        }
        if lengths.len() > count {
            return Err(damaged("more lengths than symbols"));
        }
        r.check()?;
        Self::new(&lengths)
    }

    /// Whether there are any symbols.
    pub fn is_empty(&self) -> bool {
        self.symbols.is_empty()
    }

    /// The next symbol.
    #[inline(always)]
    pub fn symbol(&self, r: &mut BitReader<'_>) -> Result<u32, ImageError> {
        r.fill();
        let (symbol, n) = self.quick[r.window as usize & ((1 << QUICK) - 1)];
        if n > 0 {
            r.skip(n.into());
            return if r.overrun() { Err(damaged("a stream ends too early")) } else { Ok(symbol.into()) };
        }
        self.long(r)
    }

    /// A symbol with a long code.
    fn long(&self, r: &mut BitReader<'_>) -> Result<u32, ImageError> {
        let mut code = 0;
        for &(first, count, start) in &self.lengths[1..] {
            code = code << 1 | r.take(1);
            // Shorter codes lie below `first`.
            if let Some(i) = code.checked_sub(first).filter(|&i| i < count) {
                r.check()?;
                return Ok(self.symbols[(start + i) as usize].into());
            }
        }
        Err(damaged("bits that are no code"))
    }
}
