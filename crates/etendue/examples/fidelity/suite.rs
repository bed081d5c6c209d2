//! What the suite holds: scenes, and pictures of other renderers.

use etendue::image::{DecodeLimits, Image, Pixels, decode};
use etendue::scene::Camera;
use glam::Vec3;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::error::Error;
use std::path::{Path, PathBuf};

/// Renderers of the suite that trace paths; the others shade in real time.
const PATH_TRACERS: [&str; 5] = ["blender-cycles", "three-gpu-pathtracer", "stellar", "vray", "dspbr-pt"];

/// A scene of `scenarios.json`.
#[derive(Deserialize)]
pub struct Scenario {
    pub target: [f32; 3],
    pub orbit: Orbit,
    pub lighting: String,
    pub render_skybox: bool,
    pub vertical_fov_deg: f32,
    pub model_dir: String,
}

/// Where the camera is: degrees, metres.
#[derive(Deserialize)]
pub struct Orbit {
    pub radius: f32,
    pub theta_deg: f32,
    pub phi_deg: f32,
}

impl Scenario {
    /// The scene's camera.
    pub fn camera(&self) -> Camera {
        let (theta, phi) = (self.orbit.theta_deg.to_radians(), self.orbit.phi_deg.to_radians());
        let away = Vec3::new(phi.sin() * theta.sin(), phi.cos(), phi.sin() * theta.cos());
        let eye = Vec3::from(self.target) + away * self.orbit.radius;
        Camera::look_at(eye, eye - away, Vec3::Y, self.vertical_fov_deg.to_radians())
    }

    /// The file of its model.
    pub fn model(&self, assets: &Path) -> Result<PathBuf, Box<dyn Error>> {
        // The folders are named from the parent of the assets.
        let name =
            Path::new(&self.model_dir).file_name().ok_or("scenarios.json: a scene without a folder")?;
        let folder = assets.join("models").join(name);
        files(&folder, |n| n.ends_with(".glb") || n.ends_with(".gltf"))?
            .into_iter()
            .next()
            .ok_or_else(|| format!("{}: there is no glTF file in it", folder.display()).into())
    }

    /// The file of its sky.
    pub fn sky(&self, assets: &Path) -> Result<PathBuf, Box<dyn Error>> {
        let folder = assets.join("env/fidelity");
        // One of the skies comes from another source and carries that in its name.
        files(&folder, |n| n.starts_with(&self.lighting) && n.ends_with(".hdr"))?
            .into_iter()
            .min_by_key(|p| p.as_os_str().len())
            .ok_or_else(|| format!("{}: there is no sky {} in it", folder.display(), self.lighting).into())
    }
}

/// Files of `folder` whose names `wanted` likes, sorted.
fn files(folder: &Path, wanted: impl Fn(&str) -> bool) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let entries = std::fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut out: Vec<PathBuf> = entries
        .filter_map(|e| Some(e.ok()?.path()))
        .filter(|p| p.file_name().and_then(|n| n.to_str()).is_some_and(&wanted))
        .collect();
    out.sort();
    Ok(out)
}

/// A picture of one renderer, on grey, three channels of display values.
pub struct Golden {
    pub name: String,
    pub path_traced: bool,
    pub picture: Image,
}

/// The reference pictures of a scene that have the size of most of them, and the names of the rest.
pub fn goldens(folder: &Path) -> Result<(Vec<Golden>, Vec<String>), Box<dyn Error>> {
    const ENDING: &str = "-golden.thumb.webp";
    let mut all = Vec::new();
    for path in files(folder, |n| n.ends_with(ENDING))? {
        let bytes = std::fs::read(&path)?;
        let picture = decode(&bytes, &DecodeLimits::default()).map_err(|e| e.in_file(&path))?;
        let name = path.file_name().unwrap_or_default().to_string_lossy().replace(ENDING, "");
        let path_traced = PATH_TRACERS.contains(&name.as_str());
        all.push(Golden { name, path_traced, picture: on_grey(&picture) });
    }
    let size = |g: &Golden| (g.picture.width, g.picture.height);
    let mut count = BTreeMap::new();
    all.iter().for_each(|g| *count.entry(size(g)).or_insert(0) += 1);
    let usual = count.into_iter().max_by_key(|c| c.1).map(|c| c.0);
    let (same, odd): (Vec<_>, Vec<_>) = all.into_iter().partition(|g| Some(size(g)) == usual);
    Ok((same, odd.into_iter().map(|g| g.name).collect()))
}

/// Three channels of a developed picture with straight alpha, over display grey 0.5.
pub fn on_grey(image: &Image) -> Image {
    let channels = image.channels;
    let mut out = Vec::with_capacity(image.width as usize * image.height as usize * 3);
    for y in 0..image.height {
        for x in 0..image.width {
            let alpha = if channels.is_multiple_of(2) { image.sample(x, y, channels - 1) } else { 1.0 };
            for c in 0..3 {
                let v = image.sample(x, y, if channels < 3 { 0 } else { c });
                out.push(v * alpha + 0.5 * (1.0 - alpha));
            }
        }
    }
    Image { width: image.width, height: image.height, channels: 3, pixels: Pixels::F32(out) }
}
