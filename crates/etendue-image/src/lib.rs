//! Pictures: buffers, readers and writers, development, metrics.
#![forbid(unsafe_code)]

mod buffer;

pub use buffer::{Image, Pixels};
