//! The shading of a point.

use crate::area::{Patch, patch};
use crate::around::{Around, Toward};
use crate::choices::{Choices, Occlusion, Shadows};
use crate::direct::{Pair, from_behind, pair};
use crate::indirect::{indirect, specular_occlusion};
use crate::inputs::Inputs;
use crate::lighting::Lighting;
use crate::surface::{Surface, unit};
use crate::terms::{Shaded, Terms, Values};
use etendue_color::Spectrum;
use glam::Vec3A;

/// The radiance that a point of a surface sends to the viewer, term by term.
///
/// `around` answers what a point cannot know by itself: whether a light is hidden, and what lies behind a transmissive surface; `()`
/// knows nothing. Any input gives finite radiance that is not negative, except that [`crate::choices::Diffuse::Sh9`] may ring
/// below zero, and Karis' and Lazarov's reflectances dip below it by some thousandths where F0 is next to nothing.
pub fn shade<A: Around>(inputs: &Inputs, lighting: &Lighting, choices: &Choices, around: &A) -> Shaded {
    let s = Surface::new(inputs, choices);
    let mut out = Shaded { terms: Terms::default(), values: values(inputs, &s) };
    if inputs.unlit {
        out.terms.emission = s.base_color;
        return out;
    }
    out.terms.emission = inputs.emission;
    let lights = Lights { s: &s, inputs, choices, around };
    lights.punctual(&mut out, lighting);
    lights.areas(&mut out, lighting);
    if let Some(sky) = &lighting.sky {
        let i = indirect(&s, &inputs.frame, sky, lighting, choices);
        let ao = unit(inputs.occlusion);
        let alpha = s.gloss.roughness * s.gloss.roughness;
        let [diffuse, specular] = match choices.occlusion {
            Occlusion::None => [1.0, 1.0],
            Occlusion::Diffuse => [ao, 1.0],
            Occlusion::Both => [ao, ao],
            Occlusion::Specular => [ao, specular_occlusion(s.gloss.wo.z, ao, alpha)],
        };
        out.terms.indirect_diffuse = i.diffuse * diffuse;
        out.terms.indirect_specular = i.specular * specular;
        let v = &mut out.values;
        v.irradiance = i.irradiance;
        v.kd_indirect = i.kd;
        v.prefiltered = i.prefiltered;
        v.mip = i.mip;
        v.env_brdf = [i.dfg.scale, i.dfg.bias];
        v.occlusion = diffuse;
        v.specular_occlusion = specular;
    }
    if let Some(passing) = &s.passing {
        out.terms.transmission += passing.seen(&s, inputs, lighting, choices, around);
    }
    out
}

fn values(inputs: &Inputs, s: &Surface) -> Values {
    let n = inputs.frame.z;
    Values {
        normal: n,
        tangent: inputs.tangent_frame.x,
        bitangent: inputs.tangent_frame.y,
        vertex_normal: inputs.tangent_frame.z,
        reflection: n * (2.0 * n.dot(inputs.view)) - inputs.view,
        nv: s.gloss.wo.z,
        base_color: s.base_color,
        metallic: s.metallic,
        roughness: s.gloss.roughness,
        f0: s.f0,
        ..Values::default()
    }
}

/// What the lights other than the sky need.
struct Lights<'a, A> {
    s: &'a Surface,
    inputs: &'a Inputs,
    choices: &'a Choices,
    around: &'a A,
}

impl<A: Around> Lights<'_, A> {
    fn visible(&self, toward: &Toward) -> f32 {
        match self.choices.shadows {
            Shadows::Rays => self.around.visible(toward),
            Shadows::None => 1.0,
        }
    }

    /// Adds the lights without an extent.
    #[inline]
    fn punctual(&self, out: &mut Shaded, lighting: &Lighting) {
        let mut brightest = 0.0;
        for number in 0..lighting.lights.len() {
            let Some(incoming) = lighting.incoming(number, self.inputs.position) else { continue };
            let toward = Toward { light: number, direction: incoming.wi, distance: incoming.distance };
            let wi = self.inputs.frame.to_local(incoming.wi);
            if let Some(p) = pair(self.s, wi, self.choices) {
                let brightness = incoming.irradiance.luminance();
                if brightness > brightest {
                    brightest = brightness;
                    keep(&mut out.values, &p);
                }
                let lit: Spectrum = incoming.irradiance * (p.nl * self.visible(&toward));
                out.terms.direct_diffuse += p.diffuse * lit;
                out.terms.direct_specular += p.specular * lit;
            } else if let Some([diffuse, passing]) = from_behind(self.s, wi, self.choices) {
                let lit = incoming.irradiance * (-wi.z * self.visible(&toward));
                out.terms.direct_diffuse += diffuse * lit;
                out.terms.transmission += passing * lit;
            }
        }
    }

    /// Adds the lights with an extent.
    #[inline]
    fn areas(&self, out: &mut Shaded, lighting: &Lighting) {
        for (number, light) in lighting.areas.iter().enumerate() {
            let Some(Patch { diffuse, specular, passing }) =
                patch(self.s, self.inputs, light, &lighting.ltc, self.choices)
            else {
                continue;
            };
            let to = Vec3A::from(light.center) - self.inputs.position;
            let distance = to.length();
            let toward = Toward {
                light: lighting.lights.len() + number,
                direction: to / distance.max(1e-20),
                distance,
            };
            let visible = self.visible(&toward);
            out.terms.direct_diffuse += light.radiance * diffuse * visible;
            out.terms.direct_specular += light.radiance * specular * visible;
            out.terms.transmission += light.radiance * passing * visible;
        }
    }
}

fn keep(v: &mut Values, p: &Pair) {
    (v.nl, v.hv, v.d, v.f, v.g, v.ks, v.kd) = (p.nl, p.hv, p.d, p.f, p.g, p.f, p.kd);
}
