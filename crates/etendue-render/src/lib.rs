//! Samplers, light sampling, integrators, film.
//!
//! [`World`] is a scene made ready for rays, [`Renderer`] takes samples of a picture of it, [`Film`] adds them up exactly.
//! A sample is a pure function of (seed, pixel, index) and the film adds integers, so a picture has the same bits however
//! its samples are divided over threads, processes, machines or interrupted runs.
#![forbid(unsafe_code)]

mod body;
mod checkpoint;
mod distribution;
mod emission_map;
mod extended;
mod film;
mod filter;
mod fingerprint;
mod fixed;
mod ids;
mod kept;
mod light_tree;
mod lights;
mod lookup;
mod media;
mod medium;
mod mesh_data;
mod moments;
mod motion;
mod output;
mod pass;
mod path;
mod pixel_rays;
mod renderer;
mod sampler;
mod scattering;
mod shading_point;
mod skin;
mod sky;
mod surface;
mod texels;
mod world;

pub use checkpoint::{FilmError, FilmInfo};
pub use distribution::{Distribution1, Distribution2};
pub use film::{BEAUTY_PLANES, Coverage, Film, MergeError, SampleRanges};
pub use filter::{Filter, FilterSampler};
pub use fingerprint::picture_id;
pub use fixed::Fixed;
pub use ids::name_hash;
pub use moments::Shutter;
pub use motion::{Moment, MovingRenderer, Series};
pub use output::id_names;
pub use pass::{Pass, PassSet};
pub use path::PathOptions;
pub use pixel_rays::PixelRays;
pub use renderer::{Counters, Renderer, Settings};
pub use sampler::{Sampler, moment};
pub use shading_point::ShadingPoint;
pub use sky::{Sky, SkySample};
pub use world::World;
