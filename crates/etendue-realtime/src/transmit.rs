//! Light through a surface: `KHR_materials_transmission`, `KHR_materials_volume`, `KHR_materials_dispersion`.
//!
//! A surface without thickness is a sheet: light goes on in its direction, blurred by the lobe turned over to the far side. One with
//! thickness is refracted as by a sphere of that diameter, in at the point and out on its far side, because a rasteriser does not
//! know the body's form: exact for spheres, near for what is round. What is scattered in it (`KHR_materials_scatter`) comes out as
//! from a plate of that thickness ([`crate::slab`]). Where something knows the scene behind ([`crate::Around`]) it is asked with the ray
//! that leaves; the sky is seen by samples.

use crate::around::{Around, Behind};
use crate::choices::{Choices, Masking, Refraction};
use crate::gloss::{Draws, Gloss, lattice, samples, to_world};
use crate::inputs::Inputs;
use crate::lighting::Lighting;
use crate::slab::{inner_reflectance, plate};
use crate::surface::{Surface, table, unit};
use etendue_bxdf::GltfParams;
use etendue_bxdf::dielectric::absorption::{coefficient, transmittance};
use etendue_bxdf::fresnel::schlick_weight;
use etendue_bxdf::sampling::Frame;
use etendue_color::Spectrum;
use glam::Vec3A;

/// The least and the largest index that is told from 1 and from infinity.
const IORS: [f32; 2] = [1.0, 1e3];

/// What lets light through.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Passing {
    /// Of what passes a sheet; its α is less than that of what is reflected.
    gloss: Gloss,
    roughness: f32,
    tint: Spectrum,
    /// Metres; 0 for a sheet.
    thickness: f32,
    /// For each lane.
    iors: [f32; 3],
    absorption: Spectrum,
    front: bool,
}

/// A ray that has gone through.
struct Out {
    point: Vec3A,
    direction: Vec3A,
    length: f32,
}

impl Passing {
    /// `None` if nothing passes. `gloss` is the reflected lobe's, `roughness` perceptual.
    #[inline]
    pub fn new(p: &GltfParams, roughness: f32, gloss: &Gloss, front: bool) -> Option<Self> {
        let part = unit(p.transmission) * (1.0 - unit(p.metallic));
        if !(part > 0.0) {
            return None;
        }
        let ior = if p.ior == 0.0 {
            IORS[1]
        } else if p.ior >= 0.0 {
            p.ior.max(IORS[0]).min(IORS[1])
        } else {
            1.5
        };
        // The lanes' indices: ior ∓ (ior − 1) · 0.025 · dispersion.
        let strength = if p.ior == 0.0 { 0.0 } else { p.dispersion.max(0.0).min(1e3) };
        let iors = [-0.025, 0.0, 0.025].map(|k| (ior + (ior - 1.0) * strength * k).max(1.0));
        // Prisms bend less the nearer the index is to 1: nothing at 1, all at 1.5.
        let scale = unit(2.0 * ior - 2.0);
        let alpha = gloss.ggx.alpha().map(|a| if gloss.mirror { 0.0 } else { a * scale * scale });
        let thickness = if p.thickness > 0.0 { p.thickness } else { 0.0 };
        Some(Self {
            gloss: Gloss::new(gloss.wo, alpha),
            roughness: roughness * scale,
            tint: p.base_color.map(unit) * (part * (1.0 - p.sheet_scatter())),
            thickness,
            iors,
            absorption: coefficient(p.attenuation_color, p.attenuation_distance),
            front,
        })
    }

    /// The boundary of a volume.
    #[inline]
    pub fn is_solid(&self) -> bool {
        self.thickness > 0.0
    }

    /// What of the light that enters the body comes out diffusely at the point and on the far side: colours and shares. `None` if
    /// nothing is scattered in it, or it is seen from inside.
    pub fn scattered(&self, p: &GltfParams) -> Option<[(Spectrum, f32); 2]> {
        let scatter = p.scatter().filter(|_| self.front && self.is_solid() && !self.absorption.is_black())?;
        let k = inner_reflectance(self.iors[1]);
        let mut out = [Spectrum::ZERO; 2];
        for lane in 0..3 {
            let color = unit(p.scatter_strength) * unit(p.multiscatter_color[lane]);
            let optical = self.absorption[lane] * self.thickness;
            let scattering = optical * scatter.albedo[lane] * (1.0 - scatter.anisotropy);
            let [near, far] = plate(color, scattering, k);
            // What comes out has passed the surface's colour twice; what is not scattered is seen through the body.
            let tint = unit(p.base_color[lane]) * unit(p.base_color[lane]);
            [out[0][lane], out[1][lane]] = [near * tint, (far - (-optical).exp()).max(0.0) * tint];
        }
        Some(out.map(|c| {
            let share = c.max_element();
            if share > 0.0 { (c * (1.0 / share), share) } else { (c, 0.0) }
        }))
    }

    /// The lobe of what passes a sheet, turned over to the near side.
    #[inline]
    pub fn gloss(&self) -> &Gloss {
        &self.gloss
    }

    /// What passes, of the light from the viewer: the tint × the facets' mean of 1 − F.
    #[inline]
    pub fn reflectance(&self, s: &Surface) -> Spectrum {
        let d = table(&self.gloss);
        let passes = match &s.film {
            None => (1.0 - s.under[0]) * d.scale + (1.0 - s.under[1]) * d.bias,
            Some(film) => (1.0 - film.under(self.gloss.wo.z)) * d.energy(),
        };
        self.tint * passes.max(0.0)
    }

    /// What is seen through the surface.
    pub fn seen<A: Around>(
        &self,
        s: &Surface,
        inputs: &Inputs,
        lighting: &Lighting,
        choices: &Choices,
        around: &A,
    ) -> Spectrum {
        let veil = s.veil()[0];
        let factor = self.reflectance(s) * veil * s.below_layers();
        if self.is_solid() {
            return factor * self.through_volume(s, inputs, lighting, choices, around);
        }
        if choices.refraction == Refraction::Scene {
            let at = Behind { point: inputs.position, direction: -inputs.view, roughness: self.roughness };
            if let Some(light) = around.behind(&at) {
                return factor * light;
            }
        }
        let Some(sky) = &lighting.sky else { return Spectrum::ZERO };
        // The lobe is turned over with its frame.
        let f = &inputs.frame;
        let over = Frame { x: f.x, y: f.y, z: -f.z };
        match samples(choices.specular) {
            None => factor * self.gloss.prefiltered(&over, sky, choices).0,
            Some(n) => {
                let lit =
                    self.gloss.sampled(&over, sky, Draws::new(n, s.part), None, |wi| s.specular_below(wi));
                let [passes, grazing] = match &s.film {
                    None => [1.0 - s.under[0], 1.0 - s.under[1]],
                    Some(film) => [1.0 - film.under(self.gloss.wo.z); 2],
                };
                self.tint * veil * (lit.straight * passes + lit.grazing * grazing)
            }
        }
    }

    fn through_volume<A: Around>(
        &self,
        s: &Surface,
        inputs: &Inputs,
        lighting: &Lighting,
        choices: &Choices,
        around: &A,
    ) -> Spectrum {
        let dispersive = self.iors[0] != self.iors[2];
        let mut all = Spectrum::ZERO;
        for lane in 0..3 {
            let light = self.through_index(s, inputs, lighting, choices, around, self.iors[lane]);
            if !dispersive {
                return light;
            }
            all[lane] = light[lane];
        }
        all
    }

    fn through_index<A: Around>(
        &self,
        s: &Surface,
        inputs: &Inputs,
        lighting: &Lighting,
        choices: &Choices,
        around: &A,
        ior: f32,
    ) -> Spectrum {
        let f = &inputs.frame;
        if choices.refraction == Refraction::Scene {
            let out = self.path(inputs, f.z, ior);
            let at = Behind { point: out.point, direction: out.direction, roughness: self.roughness };
            if let Some(light) = around.behind(&at) {
                return light * transmittance(self.absorption, out.length);
            }
        }
        let Some(sky) = &lighting.sky else { return Spectrum::ZERO };
        if s.gloss.mirror {
            let out = self.path(inputs, f.z, ior);
            return sky.radiance(out.direction) * transmittance(self.absorption, out.length);
        }
        // Facets as the lobe shows them; each bends the ray by about ior − 1 times its own turn.
        let n = samples(choices.specular).unwrap_or(32).min(256);
        let inv = 1.0 / n as f32;
        let bend = (ior - 1.0) * (ior - 1.0);
        let mut sum = Spectrum::ZERO;
        for i in 0..n {
            let h = s.gloss.ggx.sample_half(s.gloss.wo, lattice(i, inv));
            let out = self.path(inputs, to_world(f, h), ior);
            let share = bend * inv / s.gloss.ggx.pdf_half(s.gloss.wo, h).max(1e-20);
            sum += sky.averaged(out.direction, share).0 * transmittance(self.absorption, out.length);
        }
        sum * inv
    }

    /// Through a facet of normal `n` into the sphere that stands for the body and out of it.
    fn path(&self, inputs: &Inputs, n: Vec3A, ior: f32) -> Out {
        let along = -inputs.view;
        let straight = Out { point: inputs.position, direction: along, length: 0.0 };
        if !self.front {
            // Seen from inside: out at once; what is totally reflected is taken to come from the mirror direction.
            let direction = refract(along, n, ior).unwrap_or(along - n * (2.0 * along.dot(n)));
            return Out { direction, ..straight };
        }
        let Some(inside) = refract(along, n, 1.0 / ior) else { return straight };
        let cos = -n.dot(inside);
        let length = self.thickness * cos.max(0.0);
        // The sphere's normal where the chord ends, towards its middle.
        let exit = -(inside * cos + n * 0.5).normalize_or_zero();
        let direction = refract(inside, exit, ior).unwrap_or(inside);
        Out { point: inputs.position + inside * length, direction, length }
    }

    /// Value of a sheet for light from the far side, from `up`, which is its direction turned over to the near side.
    #[inline]
    pub fn eval(&self, s: &Surface, up: Vec3A) -> Spectrum {
        if self.is_solid() {
            return Spectrum::ZERO;
        }
        let (_, value) = self.gloss.lobe(up, Masking::Smith);
        let cos = 0.5 * (self.gloss.wo + up).length();
        let under = match &s.film {
            None => s.under[0] + (s.under[1] - s.under[0]) * schlick_weight(cos),
            Some(film) => film.under(cos),
        };
        self.tint * (value * (1.0 - under) * s.specular_below(up))
    }
}

/// Snell's law: the unit direction `along`, refracted at a facet of normal `n` that faces it (n · along < 0), with `eta` the index on
/// the near side over that on the far side; `None` for total reflection.
#[inline]
fn refract(along: Vec3A, n: Vec3A, eta: f32) -> Option<Vec3A> {
    let cos = -n.dot(along);
    let k = 1.0 - eta * eta * (1.0 - cos * cos);
    (k >= 0.0).then(|| (along * eta + n * (eta * cos - k.sqrt())).normalize_or_zero())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A glass sphere of diameter 2 met at a height of h: by geometry, with angles.
    #[test]
    fn a_sphere_is_gone_through_as_a_sphere() {
        let ior = 1.5f32;
        let mut p =
            GltfParams { transmission: 1.0, thickness: 2.0, ior, roughness: 0.0, ..Default::default() };
        p.attenuation_distance = 1.0;
        for h in [0.0f32, 0.3, 0.7, 0.95] {
            // The ray goes along −z at x = h; the sphere is about the origin.
            let point = Vec3A::new(h, 0.0, (1.0 - h * h).sqrt());
            let mut inputs = Inputs::new(point, Vec3A::Z, point);
            inputs.surface = p;
            let gloss = Gloss::new(Vec3A::Z, [0.0; 2]);
            let out = Passing::new(&p, 0.0, &gloss, true).expect("passes").path(&inputs, point, ior);
            let (i, t) = (h.asin(), (h / ior).asin());
            // Turned by i − t at each face, towards the axis.
            let angle = 2.0 * (i - t);
            let want = Vec3A::new(-angle.sin(), 0.0, -angle.cos());
            assert!((out.direction - want).length() < 1e-3, "{h}: {} {want}", out.direction);
            assert!((out.length - 2.0 * t.cos()).abs() < 1e-4);
            assert!((out.point.length() - 1.0).abs() < 1e-4);
        }
    }
}
