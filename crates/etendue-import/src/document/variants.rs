//! `KHR_materials_variants`: other materials for the same geometry. Nothing in it touches the picture that is made
//! without choosing a variant, so what is broken is left out with a warning.

use crate::error::Fault;
use crate::extensions::VARIANTS;
use crate::json::{Object, Reader};
use std::collections::HashSet;

/// The material that a primitive has in a variant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Mapping {
    pub variant: u32,
    pub material: u32,
    /// Which entry of the primitive's `mappings` says so.
    pub entry: u32,
}

/// The names of the document's variants. One without a name has an empty one: others are counted from it.
pub(super) fn names<'v>(r: &mut Reader<'v>, root: &'v Object) -> Result<Vec<&'v str>, Fault> {
    let names = r.extension(root, VARIANTS, |r, o| {
        Ok(r.soft(o, "variants", |r, v| {
            r.array(v, |r, v| {
                let name = r.harmless(|r| {
                    let o = r.object(v)?;
                    r.req(o, "name", Reader::string)
                });
                Ok(name.unwrap_or_default())
            })
        }))
    })?;
    Ok(names.flatten().unwrap_or_default())
}

/// The mappings of a primitive, each variant once.
pub(super) fn mappings<'v>(r: &mut Reader<'v>, primitive: &'v Object) -> Result<Vec<Mapping>, Fault> {
    let entries = r.extension(primitive, VARIANTS, |r, o| {
        Ok(r.soft(o, "mappings", |r, v| {
            r.array(v, |r, v| {
                Ok(r.harmless(|r| {
                    let o = r.object(v)?;
                    let material = r.req(o, "material", Reader::index)?;
                    Ok((material, r.req(o, "variants", |r, v| r.array(v, Reader::index))?))
                }))
            })
        }))
    })?;
    let entries = entries.flatten().unwrap_or_default();
    let mut seen = HashSet::new();
    let mut out = Vec::new();
    for (entry, mapping) in (0..).zip(entries) {
        let Some((material, variants)) = mapping else { continue };
        for variant in variants {
            if seen.insert(variant) {
                out.push(Mapping { variant, material, entry });
            } else {
                r.warn("a variant is mapped more than once; its first material is taken");
            }
        }
    }
    Ok(out)
}
