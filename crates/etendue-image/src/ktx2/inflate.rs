//! The bytes of a mip under the schemes that pack all kinds of data (KTX 2.0, 3.9.2 and 3.9.3).

use super::F;
use super::container::{Level, Scheme};
use crate::ImageError;
use crate::decode::DEFLATE_RATIO;
use ruzstd::decoding::StreamingDecoder;
use std::borrow::Cow;
use std::io::Read;

/// A decoder of Zstandard has to allow windows of this size (RFC 8878, 3.1.1.1.2).
const WINDOW: u64 = 8 << 20;

/// The level's bytes, which have to be `size`. What is allocated grows with what comes out.
pub(super) fn level<'a>(level: &Level<'a>, scheme: Scheme, size: u64) -> Result<Cow<'a, [u8]>, ImageError> {
    let bad = |cause: String| ImageError::damaged(F, cause);
    if scheme != Scheme::None && level.size != size {
        return Err(bad(format!("a mip of {} bytes where {size} belong", level.size)));
    }
    let bytes = match scheme {
        Scheme::None | Scheme::BasisLz => Cow::Borrowed(level.bytes),
        Scheme::Zstandard => {
            let window = size.next_power_of_two().max(WINDOW);
            let decoder = StreamingDecoder::new_with_max_window_size(level.bytes, window)
                .map_err(|e| bad(format!("a mip does not unpack: {e}")))?;
            let mut out = Vec::new();
            // One more than belongs there tells that there is too much.
            let read = decoder.take(size + 1).read_to_end(&mut out);
            read.map_err(|e| bad(format!("a mip does not unpack: {e}")))?;
            Cow::Owned(out)
        }
        Scheme::Zlib => {
            if size > (level.bytes.len() as u64).saturating_mul(DEFLATE_RATIO) {
                return Err(bad("a mip is too short for what it unpacks to".into()));
            }
            let out = miniz_oxide::inflate::decompress_to_vec_zlib_with_limit(level.bytes, size as usize);
            Cow::Owned(out.map_err(|e| bad(format!("a mip does not unpack: {e}")))?)
        }
    };
    if bytes.len() as u64 != size {
        return Err(bad(format!("a mip of {} bytes where {size} belong", bytes.len())));
    }
    Ok(bytes)
}
