//! Sets of choices that someone makes.

use crate::choices::*;
use crate::names::names;
use etendue_color::ToneCurve;

names! {
    /// A named set of [`Choices`].
    pub enum Preset {
        /// The default: the most exact that a picture's time allows.
        Exact = "exact",
        /// The founding notes' helmet shader, mistakes included.
        Notes = "notes",
        /// Unity's built-in pipeline, its `Standard` shader ("BRDF1").
        Unity = "unity",
        /// Filament's standard model.
        Filament = "filament",
    }
}

impl Preset {
    /// What it chooses.
    ///
    /// | | notes | unity | filament |
    /// |---|---|---|---|
    /// | source | the seeds' `Unlit/MyHelmet` | `UnityStandardBRDF.cginc` (`BRDF1_Unity_PBS`), `UnityImageBasedLighting.cginc` of Unity 2017 and later | `shading_model_standard.fs`, `light_indirect.fs`, `brdf.fs` of Filament 1.x, desktop quality |
    /// | sky's diffuse | SH9 / π, divided by π again | SH9 | SH9, windowed |
    /// | sky's specular | 7 mips, r(1.7 − 0.7r), Karis' formula with the roughness-Fresnel | 7 mips, 1/(1+α²) with a grazing term | 256² faces, table, F0·A + F90·B, dominant direction |
    /// | lights | D, Schlick's masking with guards | D, cheap Smith | D, correlated Smith |
    /// | what diffuse loses | 1 − F, different for lights and sky | 1 − F0 | nothing for lights, 1 − reflectance for the sky |
    /// | energy compensation | none | none | Turquin's |
    /// | occlusion | on both | on both | diffuse, specular by Lagarde's formula |
    ///
    /// What these presets do not take over: Unity's lights are π times brighter for the same number (its shader divides neither part
    /// by π; one multiplies the lights by 1/π to get the same picture), its box-projected probes and its least α of 0.002; Filament's
    /// level of detail, maxLod · r(2 − r), which chooses the same roughness from differently spaced mips.
    pub fn choices(self) -> Choices {
        let split = Choices { specular: Specular::SplitSum, ..Choices::default() };
        match self {
            Self::Exact => Choices::default(),
            Self::Notes => Choices {
                diffuse: Diffuse::Sh9,
                mips: Mips::Notes,
                kernel: PrefilterKernel::Cosine,
                resolution: Resolution::R128,
                lobe: Lobe::Mirror,
                dfg: DfgSource::Karis,
                fresnel: SplitFresnel::Notes,
                compensation: Compensation::None,
                coupling: Coupling::OneMinusF,
                pi: Pi::Twice,
                occlusion: Occlusion::Both,
                shadows: Shadows::None,
                masking: Masking::Notes,
                area: Area::Representative,
                refraction: Refraction::Sky,
                ..split
            },
            Self::Unity => Choices {
                diffuse: Diffuse::Sh9,
                mips: Mips::Notes,
                kernel: PrefilterKernel::Cosine,
                resolution: Resolution::R128,
                lobe: Lobe::Mirror,
                dfg: DfgSource::Unity,
                compensation: Compensation::None,
                coupling: Coupling::OneMinusF0,
                matte: Matte::Disney,
                occlusion: Occlusion::Both,
                masking: Masking::Fast,
                area: Area::Representative,
                refraction: Refraction::Sky,
                ..split
            },
            Self::Filament => Choices {
                diffuse: Diffuse::Sh9Windowed,
                kernel: PrefilterKernel::Cosine,
                compensation: Compensation::Turquin,
                coupling: Coupling::Filament,
                least_roughness: LeastRoughness::Filament,
                area: Area::Representative,
                ..split
            },
        }
    }

    /// The tone curve that its pictures are meant for, if it says one. The notes draw the linear sum into a buffer of high range
    /// and apply Narkowicz' curve to the whole picture, before it is encoded: [`ToneCurve::Aces`].
    pub fn tone_curve(self) -> Option<ToneCurve> {
        match self {
            Self::Notes => Some(ToneCurve::Aces),
            _ => None,
        }
    }
}
