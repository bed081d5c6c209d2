//! How light scatters at a point.
#![forbid(unsafe_code)]
