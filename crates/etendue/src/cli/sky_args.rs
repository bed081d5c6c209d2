//! What can be said of the sky and of lamps.

use super::values::{finite, non_negative};
use crate::image::SkyLayout;
use clap::Args;
use serde::{Deserialize, Serialize};

#[derive(Clone, Debug, Default, Args, Serialize, Deserialize)]
pub(crate) struct SkyArgs {
    /// Sky: a .hdr, .exr, .ktx2 or .dds file, `studio` (built in), `none`, or a colour as R,G,B (linear) [default: studio]
    #[arg(long, value_name = "SKY", help_heading = "Scene")]
    pub env: Option<String>,
    /// How the sky's file shows all directions: latlong, strip (six faces as graphics processors take them), strip-exr (as OpenEXR turns them), cross (seen from inside), cross-texture [default: what the file says or looks like]
    #[arg(long, value_name = "LAYOUT", help_heading = "Scene")]
    #[serde(default, with = "layout")]
    pub env_layout: Option<SkyLayout>,
    /// Turn the sky about the vertical, degrees, counter-clockwise from above
    #[arg(
        long,
        value_name = "DEG",
        default_value_t = 0.0,
        allow_negative_numbers = true,
        value_parser = finite,
        help_heading = "Scene"
    )]
    pub env_rotation: f32,
    /// Multiply the sky
    #[arg(long, value_name = "X", default_value_t = 1.0, allow_negative_numbers = true, value_parser = non_negative, help_heading = "Scene")]
    pub env_intensity: f32,
    /// Hang up a lamp with a measured profile (.ies), metres; it shines downwards unless it is turned (repeatable), e.g. spot.ies@0,2.5,0:scale=0.1
    #[arg(
        long,
        value_name = "FILE@X,Y,Z[:toward=X,Y,Z][:scale=N]",
        allow_hyphen_values = true,
        help_heading = "Scene"
    )]
    #[serde(default)]
    pub light: Vec<String>,
}

/// Layouts as their names.
mod layout {
    use crate::image::SkyLayout;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub fn serialize<S: Serializer>(v: &Option<SkyLayout>, s: S) -> Result<S::Ok, S::Error> {
        v.map(|l| l.to_string()).serialize(s)
    }

    pub fn deserialize<'a, D: Deserializer<'a>>(d: D) -> Result<Option<SkyLayout>, D::Error> {
        let name = Option::<String>::deserialize(d)?;
        name.map(|n| n.parse().map_err(serde::de::Error::custom)).transpose()
    }
}
