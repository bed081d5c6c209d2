//! OpenPBR Surface 1.1 (Academy Software Foundation 2024, the specification; Portsmouth, Kutz, Hill, Harrysson,
//! Georgiev, Andersson, Saito 2025, "OpenPBR: Novel Features and Implementation Details").
//!
//! Fuzz over coat over a mix of metal, opaque dielectric (diffuse or subsurface) and translucent dielectric, the base
//! under a thin film; each slab and formula is the specification's, its layers are laid by albedo as in its section
//! "Reduction to a mixture of lobes":
//!
//! ```text
//! surface    = F fuzz + (1 − F Efuzz) coated
//! coated     = C coat + lerp(1, T (1 − Ecoat), C) · darkening · base
//! base       = lerp(dielectric, metal, M)
//! dielectric = specular + (1 − Especular) lerp(lerp(diffuse, subsurface, S), transmission, T)
//! ```
//!
//! The E are albedos seen from `wo` alone, so that a lossless base keeps a white furnace white under any layers; the price
//! is reciprocity. They are exact for each lobe's own Fresnel term, thin films among them ([`crate::fresnel_average`]), and
//! contain the light that single scattering loses between microfacets, which goes back to its lobe: of metals and reflections
//! by a geometric series of bounces, of the boundary of a volume by sending it into the denser medium
//! ([`GgxDielectric::whole_eval_pdf`](crate::GgxDielectric::whole_eval_pdf)).
//!
//! # What the specification leaves open, and where this departs from it
//! - **Darkening, roughening, view-dependent absorption** are its recommended formulas. K's smooth part F(ωo) makes the
//!   darkening depend on `wo`.
//! - **Index under a coat.** Reflection takes the ratio to the coat, turned over where the coat is denser. Refraction
//!   into the translucent base takes the ratio to the *surroundings*: a coat with parallel faces does not change the
//!   direction behind it, so that coated glass bends light as bare glass does. (The text asks for one ratio in both; that
//!   would let light go nearly straight through coated glass.)
//! - **Opaque bases of a smaller index than their surroundings** do not reflect totally: their ratio is turned over too.
//! - **A light path crosses the coat once where it passes the translucent base**, twice where it is reflected.
//! - **`specular_color`** tints the first reflection; what is not reflected enters as if it were white. From inside it tints
//!   nothing.
//! - **From inside** a volume the boundary's own internal reflection and refraction is all; of the coat only the absorption is
//!   seen. Opaque parts look from behind as they do from the front.
//! - **Subsurface** is its slab form: a Lambert lobe that returns `subsurface_color` of what enters. Its medium and the
//!   one behind a translucent base come from [`OpenPbrParams::subsurface_medium`] and
//!   [`OpenPbrParams::transmission_medium`]; [`crate::model::ModelParams::interior`] has the latter's absorption, as if
//!   light that `transmission_scatter` scatters went straight on.
//! - **A sheet** (`geometry_thin_walled`) of translucent base is a pane with light to and fro between its faces; what passes
//!   is blurred by two refractions in place of one reflection: α (η − 1) / √2. Coat and fuzz lie on the near side.
//! - **A film on metal** needs a complex index, which F82-tint has not: the real part is the least that `base_color` allows.
//! - **Black** `coat_color` and `transmission_color` let a millionth through, so that logarithms are finite.

mod closure;
mod coat;
mod facet;
pub mod index;
mod lobe;
mod medium;
mod params;

pub use closure::OpenPbr;
pub use medium::{Medium, single_scattering_albedo};
pub use params::OpenPbrParams;

use crate::model::{Claim, Claims, Incidence, Interior, ModelParams};
use etendue_color::Spectrum;
use glam::Vec3A;

impl ModelParams for OpenPbrParams {
    type Closure = OpenPbr;
    const ABOUT: &'static str = "OpenPBR Surface 1.1 (Academy Software Foundation 2024): metal, diffuse, subsurface and glass under film, coat and fuzz";
    const CLAIMS: Claims = Claims {
        reciprocal: Claim::Breaks(
            "each layer dims what lies below by one minus its albedo seen from wo alone, which keeps white surfaces white",
        ),
        conserves: Claim::Holds,
    };

    #[inline]
    fn closure(&self, at: &Incidence) -> OpenPbr {
        OpenPbr::new(self, at)
    }

    fn emission(&self) -> Spectrum {
        self.closure(&Incidence::default()).emission(Vec3A::Z)
    }

    fn interior(&self) -> Option<Interior> {
        let passes =
            !self.geometry_thin_walled && self.transmission_weight > 0.0 && !(self.base_metalness >= 1.0);
        passes.then(|| Interior {
            ior: self.interior_ior(1.0, None),
            absorption: self.transmission_medium().absorption,
            scatter: None,
            priority: 0,
            dispersive: self.is_dispersive(),
        })
    }
}
