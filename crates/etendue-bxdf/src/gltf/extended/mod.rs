//! The closure of a surface that uses extensions.

mod bsdf;
mod view;

use super::{
    body::{Base, Body},
    coat::Coat,
    facet::Facet,
    fibres::Fibres,
    matte::Matte,
    params::GltfParams,
    shape::Shape,
};
use crate::{
    dielectric::{GgxDielectric, Interface, ThinGgx},
    fresnel::f0_from_ior,
    model::{Incidence, Transport},
    multiscatter::Further,
    sheen::Sheen,
    thin_film::Lanes,
};
use core::f32::consts::{FRAC_1_PI, FRAC_PI_2, TAU};
use etendue_color::Spectrum;
use glam::{Vec3A, vec3a};

/// A surface with extensions, at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Extended {
    fuzz: Option<Fibres>,
    coat: Option<Coat>,
    sheen: Option<Sheen>,
    /// The sheen's largest lane.
    sheen_max: f32,
    /// Whether the layers lie on the side of `wo`, and on the other.
    layers: [bool; 2],
    base: Base,
    /// The roughness of what passes a thin sheet, if it is another than that of what is reflected.
    through_shape: Option<Shape>,
    /// What is scattered diffusely on the near and on the far side.
    matte: Matte,
    /// One over what a white surface returns of [`Extended::entering`] straight up, on the near and on the far side; 0 where total
    /// reflection is in it.
    inv_entering: [f32; 2],
    /// Sums over lanes, for the choice of lobe.
    sum_diffuse: [f32; 2],
    sum_f0: f32,
    sum_f90: f32,
}

/// 0..1, NaN to 0.
#[inline(always)]
pub(super) fn unit(x: f32) -> f32 {
    x.max(0.0).min(1.0)
}

#[inline(always)]
pub(super) fn sum(s: Spectrum) -> f32 {
    let [a, b, c, d] = s.0;
    (a + b) + (c + d)
}

/// `w` on the upper side.
#[inline(always)]
fn up(w: Vec3A) -> Vec3A {
    vec3a(w.x, w.y, w.z.abs())
}

/// How much smaller the roughness of light that passes a thin sheet is than the surface's: the two faces' facets are
/// prisms, which bend light the less the nearer their index is to 1. As Khronos' sample renderer has it: nothing at ior 1, all at
/// 1.5 (also for the infinite index, 0).
#[inline(always)]
fn thin_roughness_scale(ior: f32) -> f32 {
    if ior == 0.0 { 1.0 } else { unit(2.0 * ior - 2.0) }
}

impl Extended {
    pub fn new(p: &GltfParams, at: &Incidence, lanes: Lanes) -> Self {
        let roughness = unit(p.roughness);
        let alpha = roughness * roughness;
        let strength = unit(p.anisotropy_strength);
        let alpha = [alpha + (1.0 - alpha) * (strength * strength), alpha];
        let metallic = unit(p.metallic);
        let dielectric = 1.0 - metallic;
        let specular = unit(p.specular);
        let base = p.base_color.map(unit);
        let transmission = unit(p.transmission);
        let passes = transmission * dielectric > 0.0;
        let solid = passes && p.thickness > 0.0;
        let relative = super::ior_in_lane(p, at.lane, lanes) / at.exterior_ior.max(1.0).min(1e3);
        let normal = if solid && p.ior != 0.0 { f0_from_ior(relative) } else { f0_from_ior(p.ior) };
        let dielectric_f0 = (p.specular_color * normal).map(unit) * specular;

        let mut facet = Facet::new(dielectric_f0, specular, base, metallic);
        let coverage = unit(p.iridescence);
        if coverage > 0.0 {
            facet = facet.with_film(coverage, p.iridescence_ior, p.iridescence_thickness, lanes);
        }
        if solid {
            facet = facet.with_eta(if at.front { relative } else { 1.0 / relative });
        }
        let shape = Shape::new(alpha);
        let tint = base * (transmission * dielectric * (1.0 - p.sheet_scatter()));
        let mut through_shape = None;
        let body = if solid {
            Body::Solid(GgxDielectric::new(alpha, facet, at.transport).tinted(Spectrum::ONE, tint))
        } else if passes {
            let scale = thin_roughness_scale(p.ior);
            let through = alpha.map(|a| a * (scale * scale));
            if through != alpha {
                through_shape = Some(Shape::new(through));
            }
            let sheet = ThinGgx::new(alpha, facet).with_transmission_alpha(through);
            Body::Thin(sheet.tinted(Spectrum::ONE, tint))
        } else {
            Body::Opaque
        };

        // Diffuse light that enters a volume is compressed as refracted light is.
        let squeeze = match at.transport {
            Transport::Radiance => 1.0 / (facet.eta() * facet.eta()),
            Transport::Importance => 1.0,
        };
        let [(near, near_share), (far, far_share)] = p.matte(p.scattered_by_sheet());
        let share = [near_share * FRAC_1_PI, far_share * FRAC_1_PI * squeeze];
        let matte = Matte::new([near, far], share, unit(p.diffuse_roughness));

        let further =
            Further::worthwhile(shape.ggx.alpha(), facet.average(), facet.reflect(1.0), p.compensation);

        let mut coat = Coat::new(p);
        let sheen_color = p.sheen_color.map(unit);
        let sheen_max = sheen_color.max_element();
        let (f0, f90) = facet.ends();
        let mut out = Self {
            fuzz: Fibres::new(p),
            coat: None,
            sheen: (sheen_max > 0.0).then(|| Sheen::new(sheen_color, p.sheen_roughness)),
            sheen_max,
            layers: if solid { [at.front, !at.front] } else { [true, true] },
            base: Base { facet, shape, body, further },
            through_shape,
            matte,
            inv_entering: [1.0; 2],
            sum_diffuse: matte.sums(),
            sum_f0: sum(f0),
            // Lanes that take no part are zero in the colours: three stand for all.
            sum_f90: 3.0 * f90,
        };
        // There is one place for a perfectly specular reflection: of two in different directions the coat's gives way.
        if let Some(c) = &mut coat
            && c.is_mirror()
            && c.has_own_normal()
            && out.base.deltas(Vec3A::Z)[0].is_some()
        {
            *c = c.blurred();
        }
        out.coat = coat;
        let traps =
            [out.base.facet.may_trap(), out.base.facet.may_trap() || out.base.facet.reversed().may_trap()];
        for side in 0..2 {
            if !out.matte.is_black(side) {
                out.inv_entering[side] =
                    if traps[side] { 0.0 } else { 1.0 / out.mean_entering(side).max(1e-6) };
            }
        }
        out
    }

    /// What coat and sheen let through of light from `w` above them: the coat alone, and both.
    #[inline(always)]
    fn layers_at(&self, w: Vec3A) -> [f32; 2] {
        let coat = self.coat.as_ref().map_or(1.0, |c| c.through(w));
        [coat, coat * self.under_sheen(w)]
    }

    #[inline(always)]
    fn under_sheen(&self, w: Vec3A) -> f32 {
        self.sheen.as_ref().map_or(1.0, |s| s.row().below_view(self.sheen_max, w.z))
    }

    /// Both layers on a side (0 the near, 1 the far), for `w` turned to the upper side.
    #[inline(always)]
    fn layers_on(&self, side: usize, w: Vec3A) -> f32 {
        if self.layers[side] { self.layers_at(w)[1] } else { 1.0 }
    }

    /// The part of the light from `w` (turned to the upper side) on a side that enters the base, below all layers.
    #[inline(always)]
    fn entering(&self, side: usize, w: Vec3A) -> f32 {
        let facet = if side == 0 { self.base.facet } else { self.base.facet.reversed() };
        self.base.shape.enters(&facet, w) * self.layers_on(side, w)
    }

    /// ∫ entering · f · cos over the hemisphere for the white lobe f seen from straight up: six Gauss-Legendre nodes in the
    /// cosine, exact for a mirror on Schlick's curve under another over Lambert's lobe, times azimuths where these matter.
    ///
    /// Lambert's lobe returns as much from everywhere; a rough one most from straight up, where it prefers the light that layers
    /// let through best. Over that greatest share the coupling never returns more than enters.
    fn mean_entering(&self, side: usize) -> f32 {
        const NODES: [[f32; 2]; 6] = [
            [0.033_765_24, 0.085_662_25],
            [0.169_395_31, 0.180_380_79],
            [0.380_690_4, 0.233_956_97],
            [0.619_309_6, 0.233_956_97],
            [0.830_604_7, 0.180_380_79],
            [0.966_234_8, 0.085_662_25],
        ];
        // A tilted or turned coat has no symmetry; an anisotropic base repeats each quarter.
        let tilted = self.layers[side] && self.coat.as_ref().is_some_and(Coat::has_azimuths);
        let (count, range) = match (tilted, self.base.shape.is_isotropic()) {
            (true, _) => (8, TAU),
            (false, false) => (3, FRAC_PI_2),
            (false, true) => (1, 0.0),
        };
        let mut mean = 0.0;
        for i in 0..count {
            let turns = (i as f32 + 0.5) / count as f32 * (range / TAU);
            let (y, x) = crate::math::sin_cos_tau(turns);
            for [z, weight] in NODES {
                let r = ((1.0 - z) * (1.0 + z)).sqrt();
                let lobe = self.matte.straight_up(z);
                mean += 2.0 * z * weight * lobe * self.entering(side, vec3a(r * x, r * y, z));
            }
        }
        mean / count as f32
    }
}
