//! Fibres on a surface: cloth, velvet, dust.
//!
//! | module | what it holds |
//! |---|---|
//! | [`charlie`] | glTF's sheen: fibres as microfacets (Estevez, Kulla 2017) |
//! | [`albedo`] | how much of the light that sheen takes, as a table, and the scaling of what lies below |
//! | [`sampler`] | how glTF's sheen is sampled |
//! | [`fuzz`] | OpenPBR's fuzz: fibres as a volume (Zeltner, Burley, Chiang 2022) |

pub mod albedo;
pub mod charlie;
pub mod fuzz;
pub mod sampler;

pub use albedo::SheenRow;
pub use charlie::{Sheen, SheenParams};
pub use fuzz::{Fuzz, FuzzParams};
