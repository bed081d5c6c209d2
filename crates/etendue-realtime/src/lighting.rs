//! Lights and sky together.

use crate::choices::Choices;
use crate::light::{AreaLight, Incoming, PunctualLight};
use crate::ltc::LtcTable;
use crate::sky_light::SkyLight;
use crate::zonal::ZonalTable;
use etendue_ibl::BadSky;
use etendue_scene::{AimedProfile, Light, Scene};
use glam::Vec3A;

/// All light of a scene, ready for [`crate::shade()`].
///
/// What is made of the sky depends on the choices: shade with those that it was made for, or with others that differ only in
/// keys that are not about the sky. (With others the next best that is there stands in.)
#[derive(Clone, Debug, Default)]
pub struct Lighting {
    /// Directional, point and spot lights.
    pub lights: Vec<PunctualLight>,
    /// How each of `lights` shines, for those that were measured; may be shorter.
    pub profiles: Vec<Option<AimedProfile>>,
    /// Rectangles, disks and spheres; numbered after `lights` in [`crate::Toward::light`].
    pub areas: Vec<AreaLight>,
    /// `None` if the sky is black.
    pub sky: Option<SkyLight>,
    /// Kernels about a normal.
    pub zonal: ZonalTable,
    /// Lobes as stretched cosines.
    pub ltc: LtcTable,
}

impl Lighting {
    /// Takes over the scene's lights (those without light are left out) and integrates its sky for `choices`.
    ///
    /// # Errors
    /// [`BadSky`] when the environment is no picture of light.
    pub fn new(scene: &Scene, choices: &Choices) -> Result<Self, BadSky> {
        Ok(Self {
            lights: lights(scene),
            profiles: profiles(scene),
            areas: Vec::new(),
            sky: SkyLight::new(&scene.environment, choices)?,
            zonal: ZonalTable::new(),
            ltc: LtcTable::default(),
        })
    }

    /// The same sky, integrated once, with the lights of another scene.
    pub fn with_lights_of(&self, scene: &Scene) -> Self {
        Self { lights: lights(scene), profiles: profiles(scene), areas: Vec::new(), ..self.clone() }
    }

    /// What the light `number` sends to `point`; `None` where it does not reach.
    #[inline]
    pub(crate) fn incoming(&self, number: usize, point: Vec3A) -> Option<Incoming> {
        let mut incoming = self.lights.get(number)?.at(point)?;
        if let Some(Some(profile)) = self.profiles.get(number) {
            let candela = profile.candela(-incoming.wi);
            if candela <= 0.0 {
                return None;
            }
            incoming.irradiance *= candela;
        }
        Some(incoming)
    }
}

/// The scene's lights that give light.
fn shining(scene: &Scene) -> impl Iterator<Item = &Light> {
    scene.lights.iter().filter(|l| l.intensity.max_element() > 0.0)
}

fn lights(scene: &Scene) -> Vec<PunctualLight> {
    shining(scene).map(PunctualLight::from).collect()
}

fn profiles(scene: &Scene) -> Vec<Option<AimedProfile>> {
    let mut all: Vec<_> = shining(scene).map(|l| scene.aimed_profile(l)).collect();
    if all.iter().all(Option::is_none) {
        all.clear();
    }
    all
}
