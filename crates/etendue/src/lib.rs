//! `etendue`: a physically based renderer that shows its own correctness.
//!
//! This crate is the door to the house: it re-exports the rooms under short names and holds the command line. Rendering a
//! picture of the built-in model takes three steps, each of which is one of the rooms':
//!
//! ```
//! use etendue::{builtin, render, scene};
//! let model = builtin::helmet()?;
//! let camera = scene::Camera::framing(&model, 1.0, 0.6);
//! let world = render::World::new(model)?;
//! let settings = render::Settings { width: 16, height: 16, ..Default::default() };
//! let renderer = render::Renderer::new(&world, camera, settings);
//! let mut film = renderer.film();
//! renderer.render(&mut film, 0, 4, &Default::default());
//! assert!(film.picture(false).sample(8, 8, 1) > 0.0);
//! # Ok::<(), Box<dyn std::error::Error + Send + Sync>>(())
//! ```
#![forbid(unsafe_code)]

pub use etendue_bxdf as bxdf;
pub use etendue_color as color;
pub use etendue_ibl as ibl;
pub use etendue_image as image;
pub use etendue_import as import;
pub use etendue_lab as lab;
pub use etendue_realtime as realtime;
pub use etendue_render as render;
pub use etendue_scene as scene;
pub use etendue_trace as trace;

pub mod builtin;
pub mod cli;
pub mod probe;
