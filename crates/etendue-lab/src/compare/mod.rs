//! Comparisons: how far a picture is from its reference, as figures, maps and a page.
//!
//! | item | what it holds |
//! |---|---|
//! | [`compare`] | figures of two pictures: FLIP, RMSE, relMSE, bias |
//! | [`PictureReport`] | two picture files as a page and as JSON |

mod figures;
mod paint;
mod pictures;
mod view;

pub use figures::{CompareError, Comparison, Figures, FlipFigures, Metric, compare};
pub use pictures::PictureReport;
