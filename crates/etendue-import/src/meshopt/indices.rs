//! Mode 2: indices of any kind, as differences to one of two that went before.

use super::{MeshoptError, MeshoptError::Damaged, parts, push, unzigzag};

pub(super) fn decode(bytes: &[u8], count: usize, stride: usize) -> Result<Vec<u8>, MeshoptError> {
    let (header, mut data, _) = parts(bytes, 4)?;
    if header != 0xd1 {
        return Err(Damaged("the first byte is not that of indices"));
    }
    if count > data.0.len() {
        return Err(Damaged("it is too short for its elements"));
    }
    let mut out = Vec::with_capacity(count * stride);
    let mut last = [0u32; 2];
    for _ in 0..count {
        let v = data.varint()?;
        let base = &mut last[(v & 1) as usize];
        *base = base.wrapping_add(unzigzag(v >> 1));
        push(&mut out, *base, stride);
    }
    data.finish()?;
    Ok(out)
}
