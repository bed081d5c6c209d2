//! meshopt's streams: any bytes are as many elements as were asked for, or an error. The first four bytes choose the layout.

use etendue_import::meshopt::{Filter, Layout, Mode, decode};

/// One input.
pub fn run(data: &[u8]) {
    let Some((&[kind, stride, low, high], stream)) = data.split_first_chunk::<4>() else { return };
    let layout = Layout {
        mode: [Mode::Attributes, Mode::Triangles, Mode::Indices][usize::from(kind % 3)],
        filter: [Filter::None, Filter::Octahedral, Filter::Quaternion, Filter::Exponential, Filter::Color]
            [usize::from(kind / 3 % 5)],
        count: u64::from(u16::from_le_bytes([low, high])),
        stride: u64::from(stride) + 1,
    };
    if let Ok(out) = decode(stream, &layout) {
        assert_eq!(out.len() as u64, layout.count * layout.stride);
    }
}
