//! `--material`: other models in place of a file's materials.

use super::CliError;
use crate::bxdf::model::{Field, Model, Value};
use crate::bxdf::multiscatter::Compensation;
use crate::scene::{Material, MeasuredMaterial, Scene, Substitute};
use glam::Vec3;
use std::path::Path;

/// One replacement: which materials, and by what.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Replacement {
    /// The material's name; `None` for all.
    of: Option<String>,
    by: Substitute,
    /// What the surface sends out of its own, if the replacement says so.
    emission: Vec3,
}

impl std::str::FromStr for Replacement {
    type Err = CliError;

    /// `[NAME=]MODEL[:PARAMETER=VALUE]…`, or `[NAME=]FILE` of a measured material, which ends in `.bsdf` or `.pbsdf`.
    fn from_str(text: &str) -> Result<Self, CliError> {
        let head = text.split(':').next().unwrap_or_default();
        let (of, model) = match head.rsplit_once('=') {
            Some((name, _)) => (Some(name.to_owned()), &text[name.len() + 1..]),
            None => (None, text),
        };
        let fail = |e: &dyn std::fmt::Display| CliError::Usage(format!("--material {text}: {e}"));
        if [".bsdf", ".pbsdf"].iter().any(|ending| text.ends_with(ending)) {
            // A file's name may hold any sign but the first `=`, which ends the material's.
            let (of, file) = match text.split_once('=') {
                Some((name, file)) => (Some(name.to_owned()), file),
                None => (None, text),
            };
            let path = Path::new(file);
            let bytes =
                std::fs::read(path).map_err(|source| CliError::Read { path: path.to_path_buf(), source })?;
            let measured = MeasuredMaterial::from_bytes(&bytes).map_err(|e| fail(&e))?;
            return Ok(Self { of, by: Substitute::Measured(measured), emission: Vec3::ZERO });
        }
        let model: Model = model.parse().map_err(|e| fail(&e))?;
        let emission = Vec3::from(model.emission().to_rgb());
        Ok(Self { of, by: Substitute::Model(Box::new(model)), emission })
    }
}

/// Gives a material of its own to what has none, so that it can be changed.
fn spell_out_the_default(scene: &mut Scene) {
    if scene.instances.iter().any(|i| i.material.is_none()) {
        let default = scene.materials.len() as u32;
        scene.materials.push(Material::default());
        scene.instances.iter_mut().for_each(|i| i.material = Some(i.material.unwrap_or(default)));
    }
}

/// `--compensation`: for all of the scene's glTF surfaces.
pub(crate) fn compensate(scene: &mut Scene, way: &str) {
    let way = Compensation::CHOICES.iter().find(|c| **c == way);
    if let Some(way) = way.and_then(|w| Compensation::from_value(Value::Choice(w))) {
        spell_out_the_default(scene);
        scene.materials.iter_mut().for_each(|m| m.compensation = way);
    }
}

impl Replacement {
    /// Puts the model in place; later replacements go over earlier ones.
    pub fn apply(&self, scene: &mut Scene) -> Result<(), CliError> {
        let Some(name) = &self.of else {
            spell_out_the_default(scene);
            scene.materials.iter_mut().for_each(|m| self.put(m));
            return Ok(());
        };
        let mut found = false;
        for m in scene.materials.iter_mut().filter(|m| m.name == *name) {
            self.put(m);
            found = true;
        }
        if found {
            return Ok(());
        }
        let mut names: Vec<_> = scene.materials.iter().map(|m| m.name.as_str()).collect();
        names.sort_unstable();
        names.dedup();
        Err(CliError::Usage(format!("there is no material {name:?}; the model has {}", names.join(", "))))
    }
}

impl Replacement {
    fn put(&self, m: &mut Material) {
        m.substitute = Some(self.by.clone());
        if self.emission != Vec3::ZERO {
            (m.emissive, m.emissive_texture) = (self.emission, None);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_replacement_says_which_and_what() {
        let r: Replacement = "lambert:base_color=0.5".parse().expect("for all");
        assert_eq!(r.of, None);
        let r: Replacement = "a=b=metal-rough:roughness=0.5".parse().expect("a name with a sign");
        assert_eq!(r.of.as_deref(), Some("a=b"));
        for wrong in ["", "visor=", "visor=nothing", "metal-rough:roughness", "metal-rough:shine=1"] {
            assert!(wrong.parse::<Replacement>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn all_materials_or_the_named_one_are_replaced() {
        let named = |name: &str| Material { name: name.into(), ..Material::default() };
        let mut scene = Scene { materials: vec![named("visor"), named("shell")], ..Scene::default() };
        let apply = |text: &str, scene: &mut Scene| text.parse::<Replacement>().expect("sound").apply(scene);
        apply("visor=lambert", &mut scene).expect("there");
        assert!(scene.materials[0].substitute.is_some() && scene.materials[1].substitute.is_none());
        let missing = apply("strap=lambert", &mut scene).expect_err("not there").to_string();
        assert!(missing.contains("shell, visor"), "{missing}");
        apply("metal-rough", &mut scene).expect("there");
        assert!(
            matches!(&scene.materials[0].substitute, Some(Substitute::Model(m)) if m.name() == "metal-rough")
        );
        apply("shell=openpbr:emission_luminance=2:emission_color=1,0.5,0", &mut scene).expect("there");
        assert_eq!(scene.materials[1].emissive, Vec3::new(2.0, 1.0, 0.0));
        assert!("missing.bsdf".parse::<Replacement>().is_err());
    }
}
