//! Passes: every term and every value on the way to it as a picture, by name.
//!
//! They are the debug returns of the founding notes' helmet shader, one line commented in after another, all at once.

use std::fmt;

/// How a pass is shown on a display, and what its numbers are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Display {
    /// Radiance: developed as the picture is.
    Light,
    /// A share of light by colour, 0..1: sRGB.
    Color,
    /// 0..1: black to white in even steps, without encoding.
    Share,
    /// Unit vectors: −1..1 to 0..1, without encoding.
    Vector,
    /// Texture coordinates: their fractions, without encoding.
    Fraction,
    /// Any number ≥ 0: over the largest of the picture, without encoding.
    Range,
    /// Points: from the least to the greatest of each coordinate in the picture, without encoding.
    Position,
}

macro_rules! passes {
    ($( $(#[$doc:meta])* $variant:ident = $name:literal $(| $alias:literal)* [$($channel:literal)*] $display:ident, $about:literal; )*) => {
        /// A quantity recorded for every pixel: the mean over the pixel's samples, of surface quantities over those that met a
        /// surface. Values of one light are those of the light that is brightest at the point.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        #[repr(u8)]
        pub enum Pass { $( $(#[$doc])* #[doc = $about] $variant, )* }

        impl Pass {
            /// All passes, in the order of shading.
            pub const ALL: &'static [Self] = &[$( Self::$variant, )*];

            /// The name on the command line, of the layer and in the file's name.
            pub const fn name(self) -> &'static str {
                match self { $( Self::$variant => $name, )* }
            }

            /// What it shows.
            pub const fn about(self) -> &'static str {
                match self { $( Self::$variant => $about, )* }
            }

            /// The names of its channels in a layered file.
            pub const fn channels(self) -> &'static [&'static str] {
                match self { $( Self::$variant => &[$($channel),*], )* }
            }

            /// How it is shown.
            pub const fn display(self) -> Display {
                match self { $( Self::$variant => Display::$display, )* }
            }

            /// The passes of a name: one, or the three of `tbn`. The notes' short names count in any case.
            fn by_name(name: &str) -> Option<Vec<Self>> {
                let lower = name.to_ascii_lowercase();
                match lower.as_str() {
                    $( $name $(| $alias)* => Some(vec![Self::$variant]), )*
                    "tbn" => Some(vec![Self::Tangent, Self::Bitangent, Self::VertexNormal]),
                    _ => None,
                }
            }
        }
    };
}

passes! {
    Position = "position" ["X" "Y" "Z"] Position, "point, world space, metres";
    Depth = "depth" ["Z"] Range, "distance along the camera's axis, metres";
    Uv = "uv" ["U" "V"] Fraction, "first texture coordinate";
    Tangent = "tangent" | "t" ["X" "Y" "Z"] Vector, "T of the TBN matrix, world space";
    Bitangent = "bitangent" | "b" ["X" "Y" "Z"] Vector, "B of the TBN matrix";
    VertexNormal = "vertex-normal" ["X" "Y" "Z"] Vector, "N of the TBN matrix: the normal before the normal map";
    Normal = "normal" | "n" ["X" "Y" "Z"] Vector, "N: the shading normal";
    Reflection = "reflection" | "r" ["X" "Y" "Z"] Vector, "R: the view mirrored at N";
    BaseColor = "base-color" | "albedo" ["R" "G" "B"] Color, "base colour after its texture, linear";
    Metallic = "metallic" ["Y"] Share, "metalness";
    Roughness = "roughness" ["Y"] Share, "perceptual roughness as used";
    F0 = "f0" ["R" "G" "B"] Color, "reflectance at normal incidence";
    Nv = "nv" ["Y"] Share, "N·V";
    Nl = "nl" ["Y"] Share, "N·L of the brightest light";
    Hv = "hv" | "vh" ["Y"] Share, "H·V of the brightest light";
    D = "d" ["Y"] Range, "D: density of the microfacets that mirror the brightest light, 1/sr";
    F = "f" ["R" "G" "B"] Color, "F: Fresnel's term for the brightest light";
    G = "g" ["Y"] Share, "G: masking and shadowing for the brightest light";
    Ks = "ks" ["R" "G" "B"] Color, "Ks: part of the brightest light that is mirrored";
    Kd = "kd" ["R" "G" "B"] Color, "Kd: factor of base colour / π for the brightest light";
    DirectDiffuse = "direct-diffuse" ["R" "G" "B"] Light, "light of the lights, scattered";
    DirectSpecular = "direct-specular" ["R" "G" "B"] Light, "light of the lights, mirrored";
    Irradiance = "irradiance" | "sh" ["R" "G" "B"] Light, "the sky's irradiance over π, as the diffuse choice has it";
    KdIndirect = "kd-indirect" ["R" "G" "B"] Color, "Kd for the sky: factor of base colour × irradiance";
    IndirectDiffuse = "indirect-diffuse" ["R" "G" "B"] Light, "light of the sky, scattered";
    Prefiltered = "prefiltered" ["R" "G" "B"] Light, "the sky's radiance over the mirrored lobe";
    Mip = "mip" ["Y"] Range, "level of detail at which the sky was looked up";
    EnvBrdf = "env-brdf" | "dfg" ["R" "G"] Color, "A and B of the lobe's reflectance, F0 · A + F90 · B";
    IndirectSpecular = "indirect-specular" ["R" "G" "B"] Light, "light of the sky, mirrored";
    Occlusion = "occlusion" | "ao" ["Y"] Share, "what ambient occlusion leaves of diffuse light";
    SpecularOcclusion = "specular-occlusion" ["Y"] Share, "what it leaves of specular light";
    Transmission = "transmission" ["R" "G" "B"] Light, "light from behind the surface";
    Emission = "emission" ["R" "G" "B"] Light, "light that the surface itself sends out";
    Environment = "environment" ["R" "G" "B"] Light, "the sky, seen directly";
    Linear = "linear" ["R" "G" "B"] Light, "the picture before tone mapping: the sum of all light";
    ToneMapped = "tone-mapped" ["R" "G" "B"] Color, "the picture after exposure and tone mapping, before encoding";
}

impl Pass {
    /// The passes that add up to the picture: those of light, without what they are made from.
    pub const TERMS: [Self; 7] = [
        Self::DirectDiffuse,
        Self::DirectSpecular,
        Self::IndirectDiffuse,
        Self::IndirectSpecular,
        Self::Transmission,
        Self::Emission,
        Self::Environment,
    ];

    /// True if it is of the surface that is seen, and means nothing where none is.
    pub fn is_of_surface(self) -> bool {
        !(Self::TERMS.contains(&self) || matches!(self, Self::Linear | Self::ToneMapped))
    }

    /// Channels that are recorded; the developed picture is made from the picture.
    pub(crate) fn planes(self) -> usize {
        if matches!(self, Self::Linear | Self::ToneMapped) { 0 } else { self.channels().len() }
    }
}

impl fmt::Display for Pass {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A set of passes.
///
/// ```
/// use etendue_realtime::passes::{Pass, PassSet};
/// let set = PassSet::parse("N, TBN, direct-specular")?;
/// assert!(set.has(Pass::Normal) && set.has(Pass::Bitangent) && !set.has(Pass::D));
/// # Ok::<(), String>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PassSet(u64);

impl PassSet {
    /// Every pass.
    pub fn all() -> Self {
        Pass::ALL.iter().fold(Self::default(), |s, p| s.with(*p))
    }

    /// From names separated by commas; `all` is every pass, `parts` those that add up to the picture.
    ///
    /// # Errors
    /// The name that is no pass, with the list of those that are.
    pub fn parse(names: &str) -> Result<Self, String> {
        let mut set = Self::default();
        for name in names.split(',').map(str::trim).filter(|n| !n.is_empty()) {
            set = match name {
                "all" => Self::all(),
                "parts" => Pass::TERMS.iter().fold(set, |s, p| s.with(*p)),
                _ => {
                    let passes = Pass::by_name(name).ok_or_else(|| {
                        let known: Vec<_> = Pass::ALL.iter().map(|p| p.name()).collect();
                        format!(
                            "no pass of real-time shading is called {name:?}; there are {}, parts and all",
                            known.join(", ")
                        )
                    })?;
                    passes.into_iter().fold(set, Self::with)
                }
            };
        }
        Ok(set)
    }

    /// This set and `pass`.
    #[must_use]
    pub fn with(self, pass: Pass) -> Self {
        Self(self.0 | 1 << pass as u8)
    }

    /// True if `pass` is in the set.
    #[inline]
    pub fn has(self, pass: Pass) -> bool {
        self.0 >> pass as u8 & 1 == 1
    }

    /// True if nothing is recorded beside the picture.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// The passes of the set, in the order of [`Pass::ALL`].
    pub fn iter(self) -> impl Iterator<Item = Pass> {
        Pass::ALL.iter().copied().filter(move |p| self.has(*p))
    }

    /// Numbers that they take per pixel.
    pub(crate) fn planes(self) -> usize {
        self.iter().map(Pass::planes).sum()
    }
}

impl fmt::Display for PassSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<_> = self.iter().map(Pass::name).collect();
        f.write_str(&names.join(","))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_round_trip() {
        assert_eq!(PassSet::parse(&PassSet::all().to_string()), Ok(PassSet::all()));
        assert_eq!(PassSet::parse("all"), Ok(PassSet::all()));
        for (short, long) in [("N", "normal"), ("AO", "occlusion"), ("Ks", "ks"), ("vh", "hv")] {
            assert_eq!(PassSet::parse(short), PassSet::parse(long));
        }
        assert_eq!(PassSet::parse("TBN").map(|s| s.iter().count()), Ok(3));
        assert_eq!(PassSet::parse("parts").map(|s| s.iter().count()), Ok(Pass::TERMS.len()));
        assert!(PassSet::parse("colour").expect_err("no pass").contains("env-brdf"));
    }
}
