//! Mode 0: elements of any kind, as differences to the element before, byte planes apart.

use super::{Input, MeshoptError, MeshoptError::Damaged, parts};

/// Elements of a block at most; a group has 16.
const BLOCK: usize = 256;
const GROUP: usize = 16;

/// Bits per difference, by the two bits that a group has in the header: version 0, and version 1's control modes 0 and 1.
const BITS: [[u32; 4]; 3] = [[0, 2, 4, 8], [0, 1, 2, 4], [1, 2, 4, 8]];

/// Four byte planes of a block.
type Planes = [[u8; BLOCK]; 4];

/// How a channel of four bytes was made into differences.
#[derive(Clone, Copy)]
enum Channel {
    /// Each byte for itself.
    Bytes,
    /// Two numbers of 16 bits.
    Words,
    /// Exclusive or of 32 bits, which the encoder has rotated to the left by so many.
    Xor(u32),
}

pub(super) fn decode(bytes: &[u8], count: usize, stride: usize) -> Result<Vec<u8>, MeshoptError> {
    let version = match bytes.first() {
        Some(0xa0) => 0,
        Some(0xa1) => 1,
        _ => return Err(Damaged("the first byte is not that of attributes of version 0 or 1")),
    };
    let channels = stride / 4;
    let (used, least) = if version == 0 { (stride, 32) } else { (stride + channels, 24) };
    let (_, mut data, tail) = parts(bytes, used.max(least))?;
    let tail = &tail[tail.len() - used..];
    let (mut last, modes) = (tail[..stride].to_vec(), &tail[stride..]);
    let modes = (0..channels).map(|c| modes.get(c).map_or(Ok(Channel::Bytes), |&m| channel(m)));
    let modes = modes.collect::<Result<Vec<_>, _>>()?;

    let block = ((8192 / stride) & !15).min(BLOCK);
    // Version 1 spends a control byte per channel of a block, version 0 two bits per group of each byte.
    let spent = count.div_ceil(block).checked_mul(if version == 0 { stride } else { channels });
    if spent.is_none_or(|n| n > data.0.len()) {
        return Err(Damaged("it is too short for its elements"));
    }
    let mut out = vec![0; count * stride];
    let mut planes: Planes = [[0; BLOCK]; 4];
    for part in out.chunks_mut(block * stride) {
        let elements = part.len() / stride;
        let control = if version == 0 { &[][..] } else { data.take(channels)? };
        for (c, &mode) in modes.iter().enumerate() {
            for (k, plane) in planes.iter_mut().enumerate() {
                let control = control.get(c).map(|&b| b >> (2 * k) & 3);
                read_plane(&mut data, control, plane, elements)?;
            }
            let at = 4 * c;
            let start = [last[at], last[at + 1], last[at + 2], last[at + 3]];
            let end = add_up(&planes, mode, start, part, stride, at);
            last[at..at + 4].copy_from_slice(&end);
        }
    }
    data.finish()?;
    Ok(out)
}

fn channel(mode: u8) -> Result<Channel, MeshoptError> {
    match (mode & 15, mode >> 4) {
        (0, 0) => Ok(Channel::Bytes),
        (1, 0) => Ok(Channel::Words),
        (2, r) => Ok(Channel::Xor(r.into())),
        _ => Err(Damaged("an unknown channel mode")),
    }
}

/// Reads the differences of one byte of a block's elements.
fn read_plane(
    data: &mut Input<'_>,
    control: Option<u8>,
    plane: &mut [u8; BLOCK],
    elements: usize,
) -> Result<(), MeshoptError> {
    let bits = match control {
        None => &BITS[0],
        Some(0) => &BITS[1],
        Some(1) => &BITS[2],
        Some(2) => {
            plane.fill(0);
            return Ok(());
        }
        Some(_) => {
            plane[..elements].copy_from_slice(data.take(elements)?);
            return Ok(());
        }
    };
    let groups = elements.div_ceil(GROUP);
    let header = data.take(groups.div_ceil(4))?;
    for (g, group) in plane.as_chunks_mut::<GROUP>().0[..groups].iter_mut().enumerate() {
        match bits[usize::from(header[g / 4] >> (2 * (g % 4)) & 3)] {
            0 => group.fill(0),
            1 => {
                let code = data.take(2)?;
                unpack(group, data, 1, |i| code[i / 8] >> (i % 8) & 1)?;
            }
            2 => {
                let code = data.take(4)?;
                unpack(group, data, 3, |i| code[i / 4] >> (6 - 2 * (i % 4)) & 3)?;
            }
            4 => {
                let code = data.take(8)?;
                unpack(group, data, 15, |i| code[i / 2] >> (4 - 4 * (i % 2)) & 15)?;
            }
            _ => group.copy_from_slice(data.take(GROUP)?),
        }
    }
    Ok(())
}

/// Sixteen small codes; one that equals `escape` stands for a byte that follows.
#[inline(always)]
fn unpack(
    group: &mut [u8; GROUP],
    data: &mut Input<'_>,
    escape: u8,
    code: impl Fn(usize) -> u8,
) -> Result<(), MeshoptError> {
    for (i, v) in group.iter_mut().enumerate() {
        let c = code(i);
        *v = if c == escape { data.byte()? } else { c };
    }
    Ok(())
}

/// Adds the differences up into bytes `at..at + 4` of a block's elements; returns those of the last.
fn add_up(
    planes: &Planes,
    mode: Channel,
    start: [u8; 4],
    part: &mut [u8],
    stride: usize,
    at: usize,
) -> [u8; 4] {
    let element = |i: usize| planes.each_ref().map(|p| p[i]);
    match mode {
        Channel::Bytes => write(start, part, stride, at, |i, last| {
            let d = element(i);
            std::array::from_fn(|k| last[k].wrapping_add(d[k] >> 1 ^ (d[k] & 1).wrapping_neg()))
        }),
        Channel::Words => write(start, part, stride, at, |i, last| {
            let d = element(i);
            let word = |k: usize| {
                let d = u16::from_le_bytes([d[k], d[k + 1]]);
                let last = u16::from_le_bytes([last[k], last[k + 1]]);
                last.wrapping_add(d >> 1 ^ (d & 1).wrapping_neg()).to_le_bytes()
            };
            let ([a, b], [c, d]) = (word(0), word(2));
            [a, b, c, d]
        }),
        Channel::Xor(r) => write(start, part, stride, at, |i, last| {
            (u32::from_le_bytes(last) ^ u32::from_le_bytes(element(i)).rotate_right(r)).to_le_bytes()
        }),
    }
}

#[inline(always)]
fn write(
    start: [u8; 4],
    part: &mut [u8],
    stride: usize,
    at: usize,
    next: impl Fn(usize, [u8; 4]) -> [u8; 4],
) -> [u8; 4] {
    let mut last = start;
    for (i, e) in part.chunks_exact_mut(stride).enumerate() {
        last = next(i, last);
        e[at..at + 4].copy_from_slice(&last);
    }
    last
}
