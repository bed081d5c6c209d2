//! The sky made ready for shading.

use crate::choices::{Choices, Diffuse, Mips, PrefilterKernel, Resolution, Specular};
use crate::zonal::Bands;
use etendue_color::Spectrum;
use etendue_ibl::sh::{BAND, COSINE, basis};
use etendue_ibl::{
    BadSky, CubeLookup, ExactIrradiance, Kernel, MipMapping, PrefilterOptions, Sh9, SkyMap, Window,
    bake::source_size, prefilter, to_cube,
};
use etendue_scene::Environment;
use glam::{Vec3, Vec3A};

/// Texels along an edge of the irradiance cube.
const IRRADIANCE_SIZE: u32 = 32;
/// The finest cube that samples are taken from.
const FINEST_SOURCE: u32 = 512;
/// Samples for each texel of the prefiltered cube.
const PREFILTER_SAMPLES: u32 = 512;

/// The sky as shading asks it: only what the choices need is made.
#[derive(Clone, Debug)]
pub struct SkyLight {
    map: SkyMap,
    /// Coefficients of radiance, damped if the choice says so.
    sh: Sh9,
    /// Irradiance, for [`Diffuse::Cube`].
    irradiance: Option<CubeLookup>,
    /// Radiance with mips of box means.
    source: CubeLookup,
    /// Solid angle of a texel of `source`'s largest mip, on average.
    texel: f32,
    prefiltered: Option<Prefiltered>,
    cells: Option<Cells>,
}

#[derive(Clone, Debug)]
struct Prefiltered {
    cube: CubeLookup,
    mapping: MipMapping,
    steps: u32,
}

impl SkyLight {
    /// Integrates what `choices` ask for; `None` for a sky without light.
    ///
    /// # Errors
    /// [`BadSky`] when a radiance is not finite or negative, or the picture is no picture.
    pub fn new(environment: &Environment, choices: &Choices) -> Result<Option<Self>, BadSky> {
        let map = SkyMap::new(environment)?;
        if map.is_black() {
            return Ok(None);
        }
        let constant = map.width() * map.height() == 1;
        let mut sh = Sh9::project(&map);
        if choices.diffuse == Diffuse::Sh9Windowed {
            sh = Window::Auto.apply(&sh);
        }
        let size = if constant { 4 } else { source_size(map.height(), 64).min(FINEST_SOURCE) };
        let source = CubeLookup::new(&to_cube(&map, size).with_mips());
        let irradiance = (choices.diffuse == Diffuse::Cube).then(|| {
            // A sky of one colour is the same everywhere: few texels, each the more exact.
            let (rows, size) = if constant { (256, 1) } else { (64, IRRADIANCE_SIZE) };
            CubeLookup::new(&ExactIrradiance::with_rows(&map, rows).cube(size))
        });
        let prefiltered = (choices.specular == Specular::SplitSum).then(|| {
            let size = match choices.resolution {
                Resolution::R64 => 64,
                Resolution::R128 => 128,
                Resolution::R256 => 256,
                Resolution::R512 => 512,
            };
            let (mapping, steps) = match choices.mips {
                Mips::Linear => (MipMapping::Linear, PrefilterOptions::steps_for(size)),
                Mips::Notes => (MipMapping::Notes, MipMapping::NOTES_STEPS),
            };
            let kernel = match choices.kernel {
                PrefilterKernel::Lobe => Kernel::Lobe,
                PrefilterKernel::Cosine => Kernel::Cosine,
            };
            let options =
                PrefilterOptions { size, steps, samples: PREFILTER_SAMPLES, mapping, kernel, lod_bias: 0.0 };
            let cube = prefilter(&source, &options, &|_| ());
            let steps = cube.mip_count() as u32 - 1;
            Prefiltered { cube: CubeLookup::new(&cube), mapping, steps }
        });
        let cells = (choices.diffuse == Diffuse::Exact).then(|| Cells::new(&source));
        let texel = 4.0 * std::f32::consts::PI / (6.0 * (size * size) as f32);
        Ok(Some(Self { map, sh, irradiance, source, texel, prefiltered, cells }))
    }

    /// Radiance from the direction `d` (unit), at the picture's own resolution.
    #[inline]
    pub fn radiance(&self, d: Vec3A) -> Spectrum {
        self.map.radiance(d)
    }

    /// Radiance from about `d`, averaged over a solid angle (steradians), and the level of detail at which it was found.
    #[inline(always)]
    pub fn averaged(&self, d: Vec3A, solid_angle: f32) -> (Spectrum, f32) {
        // log4 of the number of texels.
        let lod = 0.5 * log2(solid_angle / self.texel);
        (self.source.trilinear(d, lod), lod.max(0.0))
    }

    /// The prefiltered cube of the split sum, a mip for each step of roughness.
    pub fn specular_cube(&self) -> Option<&CubeLookup> {
        self.prefiltered.as_ref().map(|p| &p.cube)
    }

    /// The harmonics of radiance that the diffuse choice uses.
    pub fn sh(&self) -> &Sh9 {
        &self.sh
    }

    /// ∫ L cos dω about the unit normal `n`, by what was made for the diffuse choice.
    #[inline]
    pub fn irradiance(&self, n: Vec3A) -> Spectrum {
        match &self.irradiance {
            Some(cube) => cube.bilinear(n, 0),
            None => self.sh.irradiance(n.into()),
        }
    }

    /// ∫ L(ω) k(n·ω) dω for a kernel given by its bands: what the kernel has in common with the cosine from the irradiance, the
    /// rest from the harmonics. Not below zero.
    #[inline]
    pub fn zonal(&self, n: Vec3A, irradiance: Spectrum, bands: &Bands) -> Spectrum {
        let share = bands[0] / COSINE[0] as f32;
        let mut sum = irradiance * share;
        for ((c, b), band) in self.sh.0.iter().zip(basis(Vec3::from(n))).zip(BAND).skip(1) {
            sum += *c * (b * (bands[band] - share * COSINE[band] as f32));
        }
        sum.max(Spectrum::ZERO)
    }

    /// ∫ L(ω) cos k(cos) dω over the upper hemisphere of `n`, summed over the whole sky; `None` unless the diffuse choice is exact.
    #[inline]
    pub fn exactly(&self, n: Vec3A, k: impl Fn(f32) -> f32) -> Option<Spectrum> {
        self.cells.as_ref().map(|c| c.integrate(n, k))
    }

    /// Prefiltered radiance for a perceptual roughness, and the level of detail; the sky itself unless the specular choice is the
    /// split sum.
    #[inline]
    pub fn prefiltered(&self, d: Vec3A, roughness: f32) -> (Spectrum, f32) {
        match &self.prefiltered {
            Some(p) => {
                let lod = p.mapping.lod(roughness, p.steps);
                (p.cube.trilinear(d, lod), lod)
            }
            None => (self.radiance(d), 0.0),
        }
    }
}

/// log₂ of a positive number.
#[inline(always)]
fn log2(x: f32) -> f32 {
    etendue_bxdf::math::ln(x) * std::f32::consts::LOG2_E
}

/// The sky in cells, each with its first moment ∫ L ω dω.
#[derive(Clone, Debug)]
struct Cells(Vec<[Spectrum; 3]>);

impl Cells {
    /// One cell for each texel of a mip of 64² faces or less.
    fn new(source: &CubeLookup) -> Self {
        let mip = (source.size() / 64).max(1).ilog2();
        let n = (source.size() >> mip).max(1);
        let mut cells = Vec::with_capacity(6 * (n * n) as usize);
        // A texel of a coarse source is cut into parts, so that the horizon is fine.
        let parts = (32 / n).max(1);
        let m = n * parts;
        for i in 0..6 * m * m {
            let (face, y, x) = ((i / (m * m)) as usize, i / m % m, i % m);
            let c = |v| etendue_ibl::cube::texel_centre(v, m);
            let d = etendue_ibl::cube::face_direction(face, c(x), c(y)).normalize();
            let power =
                source.bilinear(d, mip as usize) * etendue_ibl::cube::texel_solid_angle(x, y, m) as f32;
            cells.push([power * d.x, power * d.y, power * d.z]);
        }
        Self(cells)
    }

    #[inline]
    fn integrate(&self, n: Vec3A, k: impl Fn(f32) -> f32) -> Spectrum {
        let mut total = [0.0f64; 3];
        for part in self.0.chunks(256) {
            let mut sum = Spectrum::ZERO;
            for m in part {
                let flux = m[0] * n.x + m[1] * n.y + m[2] * n.z;
                if !(flux.max_element() > 0.0) {
                    continue;
                }
                // All lanes of a moment point along the cell's direction.
                let [x, y, z] = [0, 1, 2].map(|axis: usize| m[axis][0] + m[axis][1] + m[axis][2]);
                let all = Vec3A::new(x, y, z);
                let cos = all.dot(n) / all.length();
                sum += flux.max(Spectrum::ZERO) * k(cos);
            }
            (0..3).for_each(|i| total[i] += f64::from(sum[i]));
        }
        Spectrum::from_rgb(total.map(|v| v as f32))
    }
}
