//! The whole models by name: what a user, a plot and a scene may ask for.
//!
//! A model is a set of parameters (made by [`crate::parameters!`]) that becomes a closure at each point of a surface.
//! [`Model`] is any of them, chosen by name; [`Closure`] is any of their closures, on the stack and without `dyn`. A new
//! model is one line in the list at this file's end.

mod incidence;
mod parameter;

pub use incidence::{Incidence, Interior, Scatter, Transport};
pub use parameter::{Field, Parameter, ParameterError, Parameters, Value};

use crate::{
    Lambert,
    bsdf::{Bsdf, BsdfSample, DeltaPart, Eval},
    bssrdf::SubsurfaceParams,
    classic::{
        BlinnPhongParams, BlinnPhongSurface, CookTorrance, CookTorranceParams, PhongParams, PhongSurface,
    },
    dielectric::{DielectricParams, ThinSheet, ThinSheetParams},
    diffuse::{
        LambertParams,
        disney::{DisneyDiffuse, DisneyDiffuseParams},
        eon::{Eon, EonParams},
        oren_nayar::{OrenNayar, OrenNayarParams},
    },
    disney::{DisneyBrdf, DisneyBrdfParams, DisneyBsdf, DisneyBsdfParams},
    gltf::{Gltf, GltfParams},
    hair::{Hair, HairParams},
    ior_table,
    metal_rough::{MetalRough, MetalRoughParams},
    multiscatter::{CompensatedDielectric, CompensatedGgx},
    openpbr::{OpenPbr, OpenPbrParams},
    rough_conductor::{ConductorParams, MetalFresnel},
    sheen::{Fuzz, FuzzParams, Sheen, SheenParams},
};
use etendue_color::Spectrum;
use glam::Vec3A;

/// What a model says of itself, which the laws hold it to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Claim {
    /// The law holds for every value of the parameters.
    Holds,
    /// The law does not hold, and why.
    Breaks(&'static str),
}

/// The laws that a model claims to keep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Claims {
    /// f(wo, wi) = f(wi, wo) for reflection; for transmission the same after division by the squared index of the side
    /// that the light goes to ([`crate::laws::reciprocity`]).
    pub reciprocal: Claim,
    /// Never returns more than comes in (albedo ≤ 1 + 0.001).
    pub conserves: Claim,
}

impl Claims {
    /// Both laws hold.
    pub const ALL: Self = Self { reciprocal: Claim::Holds, conserves: Claim::Holds };
}

/// A model's parameters: what becomes a closure.
pub trait ModelParams: Parameters {
    /// The closure at a point.
    type Closure: Bsdf;
    /// What the model is, in a sentence, with its source.
    const ABOUT: &'static str;
    /// The laws that it claims.
    const CLAIMS: Claims = Claims::ALL;

    /// The closure for light that arrives as `at` says.
    fn closure(&self, at: &Incidence) -> Self::Closure;

    /// The laws that these parameters claim, where a choice among them gives one up.
    fn claims(&self) -> Claims {
        Self::CLAIMS
    }

    /// What fills the space behind the surface; `None` if nothing passes through or the surface is a thin sheet.
    fn interior(&self) -> Option<Interior> {
        None
    }

    /// Radiance that the surface sends out along its normal, of its own.
    fn emission(&self) -> Spectrum {
        Spectrum::ZERO
    }

    /// How light travels under the surface; `None` if it leaves where it entered.
    fn subsurface(&self) -> Option<SubsurfaceParams> {
        None
    }
}

macro_rules! models {
    ($( $name:literal => $variant:ident($params:ty, $closure:ty), )*) => {
        /// Any model, with its parameters.
        ///
        /// ```
        /// use etendue_bxdf::{Bsdf, model::{Incidence, Model}};
        ///
        /// let mut model = Model::by_name("metal-rough")?;
        /// model.set_text("roughness", "0.3")?;
        /// let closure = model.closure(&Incidence::default());
        /// assert!(closure.albedo(glam::Vec3A::Z).max_element() <= 1.0);
        /// # Ok::<(), etendue_bxdf::model::ParameterError>(())
        /// ```
        #[derive(Clone, Copy, Debug, PartialEq)]
        #[non_exhaustive]
        pub enum Model {
            $( #[doc = concat!("`", $name, "`")] $variant($params), )*
        }

        /// Any model's closure.
        #[derive(Clone, Copy, Debug, PartialEq)]
        #[non_exhaustive]
        // A closure lives on the stack for one vertex of a path: boxing the large ones would cost an allocation there.
        #[allow(clippy::large_enum_variant)]
        pub enum Closure {
            $( #[doc = concat!("Of the model `", $name, "`.")] $variant($closure), )*
        }

        impl Model {
            /// The names of all models.
            pub const NAMES: &'static [&'static str] = &[$( $name, )*];

            /// The model of that name with its default parameters.
            ///
            /// # Errors
            /// [`ParameterError::UnknownModel`], with the names that there are.
            pub fn by_name(name: &str) -> Result<Self, ParameterError> {
                match name {
                    $( $name => Ok(Self::$variant(Default::default())), )*
                    _ => {
                    let known: Vec<_> = Self::NAMES.iter().copied().chain(ior_table::names()).collect();
                    Err(ParameterError::UnknownModel { name: name.into(), known: known.join(", ") })
                }
                }
            }

            /// Its name.
            pub fn name(&self) -> &'static str {
                match self { $( Self::$variant(_) => $name, )* }
            }

            /// What it is, in a sentence.
            pub fn about(&self) -> &'static str {
                match self { $( Self::$variant(_) => <$params as ModelParams>::ABOUT, )* }
            }

            /// The laws that it claims.
            pub fn claims(&self) -> Claims {
                match self { $( Self::$variant(p) => p.claims(), )* }
            }

            /// Its parameters.
            pub fn parameters(&self) -> Vec<Parameter> {
                match self { $( Self::$variant(_) => <$params as Parameters>::table(), )* }
            }

            /// The value of a parameter; `None` if there is none of that name.
            pub fn get(&self, name: &str) -> Option<Value> {
                match self { $( Self::$variant(p) => p.get(name), )* }
            }

            /// Sets a parameter; false if there is none of that name or the value is of another kind.
            pub fn set(&mut self, name: &str, value: Value) -> bool {
                match self { $( Self::$variant(p) => p.set(name, value), )* }
            }

            /// The closure at a point.
            #[inline]
            pub fn closure(&self, at: &Incidence) -> Closure {
                match self { $( Self::$variant(p) => Closure::$variant(p.closure(at)), )* }
            }

            /// Radiance that the surface sends out along its normal, of its own.
            pub fn emission(&self) -> Spectrum {
                match self { $( Self::$variant(p) => p.emission(), )* }
            }

            /// How light travels under the surface; see [`ModelParams::subsurface`].
            pub fn subsurface(&self) -> Option<SubsurfaceParams> {
                match self { $( Self::$variant(p) => p.subsurface(), )* }
            }

            /// What fills the space behind the surface; see [`ModelParams::interior`].
            pub fn interior(&self) -> Option<Interior> {
                match self { $( Self::$variant(p) => p.interior(), )* }
            }
        }

        impl Bsdf for Closure {
            #[inline]
            fn eval_pdf(&self, wo: Vec3A, wi: Vec3A) -> Eval {
                match self { $( Self::$variant(c) => c.eval_pdf(wo, wi), )* }
            }
            #[inline]
            fn sample(&self, wo: Vec3A, uc: f32, u: [f32; 2]) -> Option<BsdfSample> {
                match self { $( Self::$variant(c) => c.sample(wo, uc, u), )* }
            }
            #[inline]
            fn albedo(&self, wo: Vec3A) -> Spectrum {
                match self { $( Self::$variant(c) => c.albedo(wo), )* }
            }
            #[inline]
            fn eval(&self, wo: Vec3A, wi: Vec3A) -> Spectrum {
                match self { $( Self::$variant(c) => c.eval(wo, wi), )* }
            }
            #[inline]
            fn pdf(&self, wo: Vec3A, wi: Vec3A) -> f32 {
                match self { $( Self::$variant(c) => c.pdf(wo, wi), )* }
            }
            #[inline]
            fn deltas(&self, wo: Vec3A) -> [Option<DeltaPart>; 2] {
                match self { $( Self::$variant(c) => c.deltas(wo), )* }
            }
            #[inline]
            fn narrowest_alpha(&self) -> [f32; 2] {
                match self { $( Self::$variant(c) => c.narrowest_alpha(), )* }
            }
            #[inline]
            fn refraction(&self) -> Option<f32> {
                match self { $( Self::$variant(c) => c.refraction(), )* }
            }
        }
    };
}

impl std::str::FromStr for Model {
    type Err = ParameterError;

    /// A model with parameters: `NAME[:PARAMETER=VALUE]…`, such as `metal-rough:roughness=0.2:base_color=0.9,0.5,0.1`. The
    /// name may be a measured material's ([`Model::measured`]): `gold:roughness=0.1`.
    fn from_str(text: &str) -> Result<Self, ParameterError> {
        let mut parts = text.split(':');
        let name = parts.next().unwrap_or_default().trim();
        // A model goes before a material of the same name (`hair`).
        let mut model = match (Self::by_name(name), Self::measured(name)) {
            (Ok(model), _) | (Err(_), Some(model)) => model,
            (Err(unknown), None) => return Err(unknown),
        };
        for part in parts {
            let (name, value) = part.split_once('=').ok_or_else(|| ParameterError::NotAValue {
                name: model.name().into(),
                text: part.into(),
                expected: "PARAMETER=VALUE".into(),
            })?;
            model.set_text(name.trim(), value)?;
        }
        Ok(model)
    }
}

impl Model {
    /// A measured material of [`crate::ior_table`] by name: a metal as `conductor`, anything else as `dielectric` with its
    /// index and dispersion.
    pub fn measured(name: &str) -> Option<Self> {
        match ior_table::by_name(name)? {
            ior_table::Measured::Metal(metal) => {
                let mut model = Self::Conductor(ConductorParams::default());
                let known =
                    model.parameters().iter().find_map(|p| p.choices.iter().find(|c| **c == metal.name));
                known.is_some_and(|c| model.set("material", Value::Choice(c))).then_some(model)
            }
            ior_table::Measured::Dielectric(d) => Some(Self::Dielectric(DielectricParams {
                ior: d.ior,
                // As KHR_materials_dispersion writes the Abbe number.
                dispersion: d.abbe.map_or(0.0, |v| 20.0 / v),
                ..DielectricParams::default()
            })),
        }
    }

    /// Sets a parameter from text; see [`Parameter::parse`].
    ///
    /// # Errors
    /// [`ParameterError`] if there is no such parameter or the text is not a value of its kind.
    pub fn set_text(&mut self, name: &str, text: &str) -> Result<(), ParameterError> {
        let parameters = self.parameters();
        let Some(p) = parameters.iter().find(|p| p.name == name) else {
            let known: Vec<_> = parameters.iter().map(|p| p.name).collect();
            return Err(ParameterError::UnknownParameter {
                model: self.name(),
                name: name.into(),
                known: known.join(", "),
            });
        };
        self.set(name, p.parse(text)?);
        Ok(())
    }
}

models! {
    "blinn-phong" => BlinnPhong(BlinnPhongParams, BlinnPhongSurface),
    "conductor" => Conductor(ConductorParams, CompensatedGgx<MetalFresnel>),
    "cook-torrance" => CookTorrance(CookTorranceParams, CookTorrance),
    "dielectric" => Dielectric(DielectricParams, CompensatedDielectric),
    "disney-brdf" => DisneyBrdf(DisneyBrdfParams, DisneyBrdf),
    "disney-bsdf" => DisneyBsdf(DisneyBsdfParams, DisneyBsdf),
    "disney-diffuse" => DisneyDiffuse(DisneyDiffuseParams, DisneyDiffuse),
    "eon" => Eon(EonParams, Eon),
    "fuzz" => Fuzz(FuzzParams, Fuzz),
    "gltf" => Gltf(GltfParams, Gltf),
    "hair" => Hair(HairParams, Hair),
    "lambert" => Lambert(LambertParams, Lambert),
    "metal-rough" => MetalRough(MetalRoughParams, MetalRough),
    "openpbr" => OpenPbr(OpenPbrParams, OpenPbr),
    "oren-nayar" => OrenNayar(OrenNayarParams, OrenNayar),
    "phong" => Phong(PhongParams, PhongSurface),
    "sheen" => Sheen(SheenParams, Sheen),
    "subsurface" => Subsurface(SubsurfaceParams, MetalRough),
    "thin-sheet" => ThinSheet(ThinSheetParams, ThinSheet),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_model_is_found_by_its_name_and_takes_its_own_values() {
        for name in Model::NAMES {
            let mut model = Model::by_name(name).expect("listed");
            assert_eq!(model.name(), *name);
            assert!(!model.about().is_empty(), "{name} says nothing of itself");
            for p in model.parameters() {
                assert!(!p.about.trim().is_empty(), "{name}: {} has no documentation", p.name);
                assert_eq!(model.get(p.name), Some(p.default), "{name}: {}", p.name);
                assert!(model.set(p.name, p.default), "{name}: {}", p.name);
            }
            assert!(!model.set("no such parameter", Value::Number(0.0)));
        }
    }

    #[test]
    fn values_are_read_from_text() {
        let mut model = Model::by_name("metal-rough").expect("listed");
        model.set_text("base_color", "#ff8000").expect("a colour");
        let Some(Value::Color([r, g, b])) = model.get("base_color") else { panic!("a colour") };
        assert!((r - 1.0).abs() < 1e-6 && (g - 0.215_86).abs() < 1e-4 && b == 0.0, "{r} {g} {b}");
        model.set_text("base_color", "0.1, 0.2, 0.3").expect("a colour");
        assert_eq!(model.get("base_color"), Some(Value::Color([0.1, 0.2, 0.3])));
        assert!(model.set_text("roughness", "rough").is_err());
        assert!(model.set_text("roughness", "NaN").is_err());
        let unknown = model.set_text("roughnes", "1").expect_err("no such name").to_string();
        assert!(unknown.contains("roughness"), "{unknown}");
        let gold: Model = "metal-rough:metallic=1:base_color=0.9,0.5,0.1".parse().expect("a model");
        assert_eq!(gold.get("metallic"), Some(Value::Number(1.0)));
        for name in ior_table::names() {
            assert!(Model::measured(name).is_some(), "{name}");
        }
        let gold: Model = "gold:roughness=0.1".parse().expect("a metal");
        assert_eq!(gold.get("material"), Some(Value::Choice("gold")));
        assert!(matches!("hair:beta_m=0.5".parse(), Ok(Model::Hair(_))));
        assert!("metal-rough:metallic".parse::<Model>().is_err());
        assert!(Model::by_name("plastic").expect_err("no such model").to_string().contains("lambert"));
    }
}
