//! `--material`: other models in place of a file's materials.

use super::CliError;
use crate::bxdf::model::Model;
use crate::scene::{Material, Scene};

/// One replacement: which materials, and by what.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Replacement {
    /// The material's name; `None` for all.
    of: Option<String>,
    model: Model,
}

impl std::str::FromStr for Replacement {
    type Err = CliError;

    /// `[NAME=]MODEL[:PARAMETER=VALUE]…`
    fn from_str(text: &str) -> Result<Self, CliError> {
        let head = text.split(':').next().unwrap_or_default();
        let (of, model) = match head.rsplit_once('=') {
            Some((name, _)) => (Some(name.to_owned()), &text[name.len() + 1..]),
            None => (None, text),
        };
        let model = model.parse().map_err(|e| CliError::Usage(format!("--material {text}: {e}")))?;
        Ok(Self { of, model })
    }
}

impl Replacement {
    /// Puts the model in place; later replacements go over earlier ones.
    pub fn apply(&self, scene: &mut Scene) -> Result<(), CliError> {
        let Some(name) = &self.of else {
            if scene.instances.iter().any(|i| i.material.is_none()) {
                let default = scene.materials.len() as u32;
                scene.materials.push(Material::default());
                scene.instances.iter_mut().for_each(|i| i.material = Some(i.material.unwrap_or(default)));
            }
            scene.materials.iter_mut().for_each(|m| m.model = Some(Box::new(self.model)));
            return Ok(());
        };
        let mut found = false;
        for m in scene.materials.iter_mut().filter(|m| m.name == *name) {
            m.model = Some(Box::new(self.model));
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
        assert!(scene.materials[0].model.is_some() && scene.materials[1].model.is_none());
        let missing = apply("strap=lambert", &mut scene).expect_err("not there").to_string();
        assert!(missing.contains("shell, visor"), "{missing}");
        apply("metal-rough", &mut scene).expect("there");
        assert_eq!(scene.materials[0].model.as_ref().map(|m| m.name()), Some("metal-rough"));
    }
}
