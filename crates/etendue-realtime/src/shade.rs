//! The shading of a point.

use crate::around::{Around, Toward};
use crate::choices::{Choices, Occlusion, Shadows};
use crate::direct::pair;
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
/// below zero.
pub fn shade<A: Around>(inputs: &Inputs, lighting: &Lighting, choices: &Choices, around: &A) -> Shaded {
    let s = Surface::new(inputs, choices);
    let mut out = Shaded { terms: Terms::default(), values: values(inputs, &s) };
    if inputs.unlit {
        out.terms.emission = s.base_color;
        return out;
    }
    out.terms.emission = inputs.emission;
    direct_light(&mut out, &s, inputs, lighting, choices, around);
    if let Some(sky) = &lighting.sky {
        let i = indirect(&s, &inputs.frame, sky, lighting, choices);
        let ao = unit(inputs.occlusion);
        let alpha = s.roughness * s.roughness;
        let [diffuse, specular] = match choices.occlusion {
            Occlusion::None => [1.0, 1.0],
            Occlusion::Diffuse => [ao, 1.0],
            Occlusion::Both => [ao, ao],
            Occlusion::Specular => [ao, specular_occlusion(s.wo.z, ao, alpha)],
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
        nv: s.wo.z,
        base_color: s.base_color,
        metallic: s.metallic,
        roughness: s.roughness,
        f0: s.f0,
        ..Values::default()
    }
}

/// Adds the lights without an extent.
#[inline]
fn direct_light<A: Around>(
    out: &mut Shaded,
    s: &Surface,
    inputs: &Inputs,
    lighting: &Lighting,
    choices: &Choices,
    around: &A,
) {
    let f = &inputs.frame;
    let mut brightest = 0.0;
    for (number, light) in lighting.lights.iter().enumerate() {
        let Some(incoming) = light.at(inputs.position) else { continue };
        let w = incoming.wi;
        let Some(p) = pair(s, Vec3A::new(f.x.dot(w), f.y.dot(w), f.z.dot(w)), choices) else { continue };
        let brightness = incoming.irradiance.luminance();
        if brightness > brightest {
            brightest = brightness;
            let v = &mut out.values;
            (v.nl, v.hv, v.d, v.f, v.g, v.ks, v.kd) = (p.nl, p.hv, p.d, p.f, p.g, p.f, p.kd);
        }
        let toward = Toward { light: number, direction: w, distance: incoming.distance };
        let visible = match choices.shadows {
            Shadows::Rays => around.visible(&toward),
            Shadows::None => 1.0,
        };
        if visible > 0.0 {
            let lit: Spectrum = incoming.irradiance * (p.nl * visible);
            out.terms.direct_diffuse += p.diffuse * lit;
            out.terms.direct_specular += p.specular * lit;
        }
    }
}
