//! The program as a user meets it: files in, files, messages and exit codes out.
//!
//! Everything runs the built binary in a folder of its own, on the built-in model or a model of a few lines, at sizes that
//! take a moment.

mod baking;
mod comparing;
mod errors;
mod films;
mod frames;
mod lab;
mod laboratory;
mod models;
mod pictures;
mod probes;
mod realtime;
mod scenes;
mod stop;
mod tools;
