//! Passes: what can be recorded beside the beauty picture.

use std::fmt;

/// A quantity recorded for every pixel. Geometric passes are of the first surface that the camera sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Pass {
    /// Reflectance of the surface, linear RGB.
    Albedo,
    /// Shading normal, world space.
    Normal,
    /// Hit point, world space, metres.
    Position,
    /// Distance along the camera's axis, metres.
    Depth,
    /// First texture coordinate.
    Uv,
    /// Light that was scattered once on its way from a light to the camera.
    Direct,
    /// Light that was scattered more than once.
    Indirect,
    /// Light whose last scattering before the camera was diffuse.
    Diffuse,
    /// Light whose last scattering before the camera was specular.
    Specular,
    /// Light that the seen surface itself sends out.
    Emission,
    /// The sky, seen directly.
    Environment,
    /// Light of directional, point and spot lights, scattered once, diffusely.
    LightDiffuse,
    /// Light of directional, point and spot lights, scattered once, specularly.
    LightSpecular,
    /// Light of the sky, scattered once, diffusely.
    SkyDiffuse,
    /// Light of the sky, scattered once, specularly.
    SkySpecular,
    /// Light of other surfaces, which shine or scatter, scattered diffusely here.
    BounceDiffuse,
    /// Light of other surfaces, which shine or scatter, scattered specularly here.
    BounceSpecular,
    /// Light that came through the seen surface. Emission, environment, this and the six before add up to the picture.
    Transmission,
    /// Which instance: Cryptomatte hash of its name.
    ObjectId,
    /// Which material: Cryptomatte hash of its name.
    MaterialId,
}

impl Pass {
    /// All passes, in the order in which a film stores them.
    pub const ALL: [Self; 20] = [
        Self::Albedo,
        Self::Normal,
        Self::Position,
        Self::Depth,
        Self::Uv,
        Self::Direct,
        Self::Indirect,
        Self::Diffuse,
        Self::Specular,
        Self::Emission,
        Self::Environment,
        Self::LightDiffuse,
        Self::LightSpecular,
        Self::SkyDiffuse,
        Self::SkySpecular,
        Self::BounceDiffuse,
        Self::BounceSpecular,
        Self::Transmission,
        Self::ObjectId,
        Self::MaterialId,
    ];

    /// The passes that add up to the picture, by where light comes from and how the seen surface scatters it.
    pub const PARTS: [Self; 9] = [
        Self::LightDiffuse,
        Self::LightSpecular,
        Self::SkyDiffuse,
        Self::SkySpecular,
        Self::BounceDiffuse,
        Self::BounceSpecular,
        Self::Transmission,
        Self::Emission,
        Self::Environment,
    ];

    /// The name on the command line and of the layer in the file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Albedo => "albedo",
            Self::Normal => "normal",
            Self::Position => "position",
            Self::Depth => "depth",
            Self::Uv => "uv",
            Self::Direct => "direct",
            Self::Indirect => "indirect",
            Self::Diffuse => "diffuse",
            Self::Specular => "specular",
            Self::Emission => "emission",
            Self::Environment => "environment",
            Self::LightDiffuse => "light-diffuse",
            Self::LightSpecular => "light-specular",
            Self::SkyDiffuse => "sky-diffuse",
            Self::SkySpecular => "sky-specular",
            Self::BounceDiffuse => "bounce-diffuse",
            Self::BounceSpecular => "bounce-specular",
            Self::Transmission => "transmission",
            Self::ObjectId => "object",
            Self::MaterialId => "material",
        }
    }

    /// The channels' names in a layered file; empty for ids, which are stored as ranked coverage.
    pub fn channels(self) -> &'static [&'static str] {
        match self {
            Self::Normal | Self::Position => &["X", "Y", "Z"],
            Self::Depth => &["Z"],
            Self::Uv => &["U", "V"],
            Self::ObjectId | Self::MaterialId => &[],
            _ => &["R", "G", "B"],
        }
    }
}

/// A set of passes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PassSet(u32);

impl PassSet {
    /// Every pass.
    pub fn all() -> Self {
        Pass::ALL.into_iter().fold(Self::default(), Self::with)
    }

    /// From names separated by commas; `all` is every pass, `parts` those of [`Pass::PARTS`].
    ///
    /// # Errors
    /// The name that is no pass, with the list of those that are.
    pub fn parse(names: &str) -> Result<Self, String> {
        let mut set = Self::default();
        for name in names.split(',').map(str::trim).filter(|n| !n.is_empty()) {
            if name == "all" {
                set = Self::all();
                continue;
            }
            if name == "parts" {
                set = Self::parts().iter().fold(set, Self::with);
                continue;
            }
            let pass = Pass::ALL.into_iter().find(|p| p.name() == name).ok_or_else(|| {
                let known: Vec<_> = Pass::ALL.iter().map(|p| p.name()).collect();
                format!("no pass is called {name:?}; there are {}, parts and all", known.join(", "))
            })?;
            set = set.with(pass);
        }
        Ok(set)
    }

    /// The passes that add up to the picture: [`Pass::PARTS`].
    pub fn parts() -> Self {
        Pass::PARTS.into_iter().fold(Self::default(), Self::with)
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

    /// True if nothing is recorded beside the beauty picture.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// The passes of the set, in film order.
    pub fn iter(self) -> impl Iterator<Item = Pass> {
        Pass::ALL.into_iter().filter(move |p| self.has(*p))
    }

    /// Planes that they take in a film.
    pub fn planes(self) -> usize {
        self.iter().map(|p| p.channels().len()).sum()
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
        assert_eq!(PassSet::parse(" depth, normal ").unwrap().to_string(), "normal,depth");
        assert!(PassSet::parse("colour").unwrap_err().contains("albedo"));
        assert_eq!(PassSet::all().planes(), 51);
    }
}
