//! Comparisons: how far a picture is from its reference, as figures, maps and a page.
//!
//! | item | what it holds |
//! |---|---|
//! | [`compare`] | figures of two pictures: FLIP, RMSE, relMSE, bias |
//! | [`PictureReport`] | two picture files as a page and as JSON |
//! | [`model_report`] | real-time shading beside the path tracer, term by term and choice by choice, as a page and as JSON |

mod figures;
mod model;
mod paint;
mod pictures;
mod view;

pub use figures::{CompareError, Comparison, Figures, FlipFigures, Metric, compare};
pub use model::{Against, Job, ModelError, ModelReport, Side, TermError, Unknown, Variant, model_report};
pub use pictures::PictureReport;
