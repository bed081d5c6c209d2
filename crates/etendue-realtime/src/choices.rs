//! The model's approximations, each by name.
//!
//! A real-time shader is a row of decisions about what to leave out. Here each is a value of an enumeration, so that a
//! report can change one at a time and say what it costs. The default is the most exact of what a picture's time allows;
//! [`crate::Preset`] names the decisions that engines and the founding notes make.

use crate::names::names;

names! {
    /// Where indirect diffuse light comes from.
    pub enum Diffuse {
        /// A cosine-convolved cube of 32² faces; the part that the specular layer changes about the cosine, by harmonics.
        Cube = "cube",
        /// Nine spherical harmonics as they are; may ring below zero.
        Sh9 = "sh9",
        /// Nine spherical harmonics damped as little as keeps irradiance from falling below zero, clamped at zero.
        Sh9Windowed = "sh9-windowed",
        /// The sum over the whole sky at each pixel: slow, the measure of the others.
        Exact = "exact",
    }
}

names! {
    /// How indirect specular light is found.
    pub enum Specular {
        /// Thirty-two filtered importance samples of the real lobe (Křivánek, Colbert 2008), each from a mip of the sky that is as
        /// coarse as its share of the lobe.
        Sampled = "sampled",
        /// Eight of them, for slow machines.
        SampledFew = "sampled-8",
        /// The split sum (Karis 2013): prefiltered light × the lobe's reflectance.
        SplitSum = "split-sum",
        /// A thousand and twenty-four samples: slow, the measure of the others.
        Exact = "exact",
    }
}

names! {
    /// Split sum: which mip stands for which roughness.
    pub enum Mips {
        /// Level = roughness × steps, five steps.
        Linear = "linear",
        /// Level = roughness (1.7 − 0.7 roughness) × 6: the founding notes' and Unity's.
        Notes = "notes",
    }
}

names! {
    /// Split sum: what beside the distribution of normals weighs the light when it is prefiltered.
    pub enum PrefilterKernel {
        /// The rest of the lobe: light × reflectance is then exact at normal incidence.
        Lobe = "lobe",
        /// The cosine, as engines do (Karis 2013).
        Cosine = "cosine",
    }
}

names! {
    /// Split sum: texels along an edge of the prefiltered cube's faces.
    pub enum Resolution {
        /// 64².
        R64 = "64",
        /// 128², the default of engines' reflection probes.
        R128 = "128",
        /// 256².
        R256 = "256",
        /// 512².
        R512 = "512",
    }
}

names! {
    /// Split sum: where in the prefiltered cube is looked.
    pub enum Lobe {
        /// Along the lobe's middle, between the mirror direction and the normal (Lagarde, de Rousiers 2014, section 4.9.3).
        Dominant = "dominant",
        /// In the mirror direction, as if the lobe were round about it.
        Mirror = "mirror",
        /// Five looks across the lobe's width, which is narrower beside the plane of incidence than along it.
        Stretched = "stretched",
    }
}

names! {
    /// Split sum: the lobe's reflectance, F0 · A + F90 · B.
    pub enum DfgSource {
        /// A table by quadrature.
        Table = "table",
        /// Two thousand samples at each pixel: slow, the measure of the others.
        Exact = "exact",
        /// Our formula ([`etendue_ibl::dfg_fit::ours`]).
        Fit = "fit",
        /// Karis' mobile formula (2014).
        Karis = "karis",
        /// Lazarov's formula (2013).
        Lazarov = "lazarov",
        /// Unity's built-in pipeline: 1 / (1 + α²) · mix(F0, smoothness + reflectivity, (1 − N·V)⁵).
        Unity = "unity",
    }
}

names! {
    /// Split sum: the Fresnel term that multiplies the lobe's reflectance.
    pub enum SplitFresnel {
        /// F0 · A + F90 · B: the table has Fresnel's curve in it.
        F0Ab = "f0ab",
        /// Fr · A + B with Fr = F0 + (max(1 − roughness, F0) − F0)(1 − N·V)⁵, as in the founding notes: Fresnel's curve counted
        /// twice.
        Notes = "notes",
    }
}

names! {
    /// What is done about light that meets several microfacets.
    pub enum Compensation {
        /// A second lobe with the energy that is missing (Kulla, Conty 2017), as the reference has it.
        KullaConty = "kulla-conty",
        /// The lobe scaled by 1 + F0 (1 − E) / E (Turquin 2019; Filament).
        Turquin = "turquin",
        /// F0's and F90's parts scaled each by its own series of bounces.
        Endpoint = "endpoint",
        /// Nothing: it is lost.
        None = "none",
    }
}

names! {
    /// How much light the diffuse part gets, given what the specular part took.
    pub enum Coupling {
        /// By the mean Fresnel terms of both directions, as the reference has it: conserves energy.
        Albedo = "albedo",
        /// (1 − F)(1 − metallic), F by the half vector for lights and the notes' roughness-Fresnel for the sky.
        OneMinusF = "one-minus-f",
        /// All for lights, 1 − the lobe's reflectance for the sky (Filament).
        Filament = "filament",
        /// 1 − F0, at each angle (Unity's built-in pipeline).
        OneMinusF0 = "one-minus-f0",
        /// All: as if the specular part were added from nothing.
        Whole = "whole",
    }
}

names! {
    /// The diffuse lobe's shape for lights; the sky always meets Lambert's.
    pub enum Matte {
        /// The same in all directions.
        Lambert = "lambert",
        /// Disney's retro-reflection (Burley 2012), as Unity's built-in pipeline has it.
        Disney = "disney",
    }
}

names! {
    /// How often the diffuse part is divided by π in the sky's light.
    pub enum Pi {
        /// Once, by the law.
        Once = "once",
        /// Twice, as the founding notes do: `ShadeSH9` has divided already.
        Twice = "twice",
    }
}

names! {
    /// How often the diffuse part is divided by π in the lights' light.
    pub enum DirectPi {
        /// Once, by the law.
        Once = "once",
        /// Not at all ("unity's built-in PBR is a little brighter"): the diffuse part is π times too bright beside the specular one.
        Never = "never",
    }
}

names! {
    /// What the ambient occlusion texture darkens.
    pub enum Occlusion {
        /// Diffuse light by the texture, specular light by what of its lobe the cone that the texture stands for leaves open.
        Specular = "ao+specular",
        /// Diffuse light only.
        Diffuse = "ao",
        /// Diffuse and specular light alike, as the founding notes do.
        Both = "ao-both",
        /// Nothing.
        None = "none",
    }
}

names! {
    /// Shadows of lights.
    pub enum Shadows {
        /// By rays.
        Rays = "rays",
        /// None: a surface is only turned away from a light.
        None = "none",
    }
}

names! {
    /// Masking and shadowing between microfacets, for lights.
    pub enum Masking {
        /// Smith's, heights correlated, as the reference has it.
        Smith = "smith",
        /// Its cheap form without roots: ½ / mix(2 NL NV, NL + NV, α) (Hammon 2017; Unity's, Filament's on mobile).
        Fast = "fast",
        /// Schlick's form of Smith's with k = (roughness + 1)² / 8 for both directions (Karis 2013).
        Schlick = "schlick",
        /// The same with the founding notes' guards: D over at least 1e-5, the whole over at least 1e-4.
        Notes = "notes",
    }
}

names! {
    /// Light from rectangles, disks and spheres.
    pub enum Area {
        /// Linearly transformed cosines (Heitz, Dupuy, Hill, Neubelt 2016).
        Ltc = "ltc",
        /// A point of the light that lies nearest to the mirror direction (Karis 2013), the diffuse part from its middle.
        Representative = "representative-point",
    }
}

names! {
    /// What is seen through transmissive surfaces.
    pub enum Refraction {
        /// The scene behind, where something knows it, else the sky.
        Scene = "scene",
        /// The sky alone.
        Sky = "sky",
    }
}

names! {
    /// The least perceptual roughness.
    pub enum LeastRoughness {
        /// None: a mirror is a mirror.
        Zero = "0",
        /// 0.045 (Filament).
        Filament = "0.045",
    }
}

/// A key of [`Choices`], for help texts and reports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Key {
    /// As users write it.
    pub name: &'static str,
    /// What it decides.
    pub about: &'static str,
    /// The values that it may have, the default first.
    pub values: &'static [&'static str],
}

/// Why choices could not be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ChoiceError {
    /// No choice or preset has this name.
    #[error("there is no choice or preset {name:?}; presets are {presets}, choices {keys}")]
    UnknownKey {
        /// What was asked for.
        name: String,
        /// The presets that there are.
        presets: String,
        /// The keys that there are.
        keys: String,
    },
    /// The key has no such value.
    #[error("{key} = {value:?}: give one of {values}")]
    UnknownValue {
        /// The key.
        key: &'static str,
        /// What was asked for.
        value: String,
        /// The values that there are.
        values: String,
    },
}

macro_rules! choices {
    ($( $(#[$doc:meta])* $field:ident: $type:ident = $default:ident, $key:literal, $about:literal; )*) => {
        /// Which approximation stands where. `Default` is the most exact that a picture's time allows.
        ///
        /// ```
        /// use etendue_realtime::{Choices, DfgSource};
        /// let choices: Choices = "filament,dfg=karis".parse()?;
        /// assert_eq!(choices.dfg, DfgSource::Karis);
        /// # Ok::<(), etendue_realtime::ChoiceError>(())
        /// ```
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub struct Choices { $( $(#[$doc])* pub $field: $type, )* }

        impl Default for Choices {
            fn default() -> Self {
                Self { $( $field: $type::$default, )* }
            }
        }

        impl Choices {
            /// Every key, in order of declaration.
            pub const KEYS: &'static [Key] =
                &[$( Key { name: $key, about: $about, values: $type::NAMES }, )*];

            /// The value of a key by its word; `None` if there is no such key.
            pub fn get(&self, key: &str) -> Option<&'static str> {
                match key {
                    $( $key => Some(self.$field.name()), )*
                    _ => None,
                }
            }

            /// Sets a key by its word.
            ///
            /// # Errors
            /// The key or the value does not exist.
            pub fn set(&mut self, key: &str, value: &str) -> Result<(), ChoiceError> {
                match key {
                    $( $key => match value.parse() {
                        Ok(v) => self.$field = v,
                        Err(_) => return Err(ChoiceError::UnknownValue {
                            key: $key,
                            value: value.into(),
                            values: $type::NAMES.join(", "),
                        }),
                    }, )*
                    _ => return Err(Self::unknown(key)),
                }
                Ok(())
            }
        }
    };
}

choices! {
    /// Indirect diffuse light.
    diffuse: Diffuse = Cube, "diffuse", "where indirect diffuse light comes from";
    /// Indirect specular light.
    specular: Specular = Sampled, "specular", "how indirect specular light is found";
    /// Split sum: roughness to mip.
    mips: Mips = Linear, "prefilter", "split sum: which mip stands for which roughness";
    /// Split sum: what the prefiltered cube is weighted by.
    kernel: PrefilterKernel = Lobe, "kernel", "split sum: what weighs the light when it is prefiltered";
    /// Split sum: how fine the prefiltered cube is.
    resolution: Resolution = R256, "resolution", "split sum: texels along an edge of the prefiltered cube";
    /// Split sum: where the prefiltered cube is looked up.
    lobe: Lobe = Dominant, "lobe", "split sum: where in the prefiltered cube is looked";
    /// Split sum: reflectance of the lobe.
    dfg: DfgSource = Table, "dfg", "split sum: the lobe's reflectance by roughness and angle";
    /// Split sum: Fresnel's term.
    fresnel: SplitFresnel = F0Ab, "fresnel", "split sum: the Fresnel term that multiplies the reflectance";
    /// Light of several bounces between microfacets.
    compensation: Compensation = KullaConty, "compensation", "light that meets several microfacets";
    /// What the specular part leaves for the diffuse one.
    coupling: Coupling = Albedo, "diffuse-coupling", "what the specular part leaves for the diffuse one";
    /// Shape of the diffuse lobe.
    matte: Matte = Lambert, "diffuse-shape", "the diffuse lobe's shape for lights";
    /// Divisions by π in the sky's light.
    pi: Pi = Once, "pi", "divisions of the sky's diffuse light by pi";
    /// Divisions by π in the lights' light.
    direct_pi: DirectPi = Once, "direct-pi", "divisions of the lights' diffuse light by pi";
    /// Ambient occlusion.
    occlusion: Occlusion = Specular, "occlusion", "what the ambient occlusion texture darkens";
    /// Shadows.
    shadows: Shadows = Rays, "shadows", "shadows of lights";
    /// Masking between microfacets.
    masking: Masking = Smith, "masking", "masking between microfacets, for lights";
    /// Lights with an extent.
    area: Area = Ltc, "area-lights", "light from rectangles, disks and spheres";
    /// What is seen through a surface.
    refraction: Refraction = Scene, "refraction", "what is seen through transmissive surfaces";
    /// The smoothest that surfaces may be.
    least_roughness: LeastRoughness = Zero, "least-roughness", "the smoothest that surfaces may be";
}

/// One choice made otherwise.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Ablation {
    /// The key that changes.
    pub key: &'static str,
    /// Its other value.
    pub value: &'static str,
    /// All choices, with that one changed. A key of the split sum turns the split sum on where it was off.
    pub choices: Choices,
}

impl Choices {
    fn unknown(name: &str) -> ChoiceError {
        ChoiceError::UnknownKey {
            name: name.into(),
            presets: crate::Preset::NAMES.join(", "),
            keys: Self::KEYS.iter().map(|k| k.name).collect::<Vec<_>>().join(", "),
        }
    }

    /// True if the key matters only with [`Specular::SplitSum`].
    pub fn is_of_split_sum(key: &str) -> bool {
        matches!(key, "prefilter" | "kernel" | "resolution" | "lobe" | "dfg" | "fresnel")
    }

    /// For each key each of its other values.
    pub fn ablations(&self) -> Vec<Ablation> {
        let mut out = Vec::new();
        for key in Self::KEYS {
            for &value in key.values {
                let mut choices = *self;
                if Self::is_of_split_sum(key.name) {
                    choices.specular = Specular::SplitSum;
                }
                if self.get(key.name) != Some(value) && choices.set(key.name, value).is_ok() {
                    out.push(Ablation { key: key.name, value, choices });
                }
            }
        }
        out
    }

    /// The keys in which two sets of choices differ, as `key=value` of this one, joined by commas; empty if they are equal.
    pub fn difference(&self, from: &Self) -> String {
        let changed = Self::KEYS.iter().filter(|k| self.get(k.name) != from.get(k.name));
        changed
            .map(|k| format!("{}={}", k.name, self.get(k.name).unwrap_or("")))
            .collect::<Vec<_>>()
            .join(",")
    }

    /// Applies a preset's name or `key=value`, several joined by commas, from left to right.
    ///
    /// # Errors
    /// A name that does not exist; what stood before it has been applied.
    pub fn apply(&mut self, text: &str) -> Result<(), ChoiceError> {
        for part in text.split(',').map(str::trim).filter(|p| !p.is_empty()) {
            match part.split_once('=') {
                Some((key, value)) => self.set(key.trim(), value.trim())?,
                None => {
                    *self = part.parse::<crate::Preset>().map_err(|_| Self::unknown(part))?.choices();
                }
            }
        }
        Ok(())
    }
}

impl std::str::FromStr for Choices {
    type Err = ChoiceError;

    fn from_str(s: &str) -> Result<Self, ChoiceError> {
        let mut choices = Self::default();
        choices.apply(s)?;
        Ok(choices)
    }
}

impl std::fmt::Display for Choices {
    /// Each key with its value, as [`Choices::apply`] reads it.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for (i, k) in Self::KEYS.iter().enumerate() {
            let comma = if i == 0 { "" } else { "," };
            write!(f, "{comma}{}={}", k.name, self.get(k.name).unwrap_or(""))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_is_the_first_value_of_each_key_but_where_a_finer_one_is_slow() {
        let c = Choices::default();
        for key in Choices::KEYS {
            let default = c.get(key.name).expect("a key");
            assert!(key.values.contains(&default), "{}", key.name);
            assert!(default == key.values[0] || key.name == "resolution", "{}", key.name);
        }
    }

    #[test]
    fn text_there_and_back() {
        for preset in crate::Preset::ALL {
            let c = preset.choices();
            assert_eq!(c.to_string().parse::<Choices>(), Ok(c));
            assert_eq!(preset.name().parse::<Choices>(), Ok(c));
        }
        let c: Choices = " notes , pi = once ".parse().expect("sound");
        assert_eq!((c.pi, c.masking), (Pi::Once, Masking::Notes));
        assert_eq!(c.difference(&crate::Preset::Notes.choices()), "pi=once");
        for (bad, what) in
            [("pi=thrice", "once, twice"), ("pie=once", "compensation"), ("exacter", "filament")]
        {
            let e = bad.parse::<Choices>().expect_err("no such thing").to_string();
            assert!(e.contains(what), "{e}");
        }
    }

    #[test]
    fn ablations_change_one_thing() {
        let base = Choices::default();
        let all = base.ablations();
        let values: usize = Choices::KEYS.iter().map(|k| k.values.len() - 1).sum();
        assert_eq!(all.len(), values);
        for a in all {
            let changed = a.choices.difference(&base);
            let split = Choices::is_of_split_sum(a.key);
            assert!(changed.contains(&format!("{}={}", a.key, a.value)), "{changed}");
            assert_eq!(changed.split(',').count(), 1 + usize::from(split), "{changed}");
        }
    }
}
