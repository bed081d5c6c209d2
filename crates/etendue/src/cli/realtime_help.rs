//! Long help texts about real-time shading, written from its own lists.

use crate::realtime::passes::Pass;
use crate::realtime::{Choices, Preset};
use crate::render;

/// What `--passes` takes.
pub(crate) fn passes() -> String {
    let paths: Vec<_> = render::Pass::ALL.iter().map(|p| p.name()).collect();
    let mut text = format!(
        "Record passes, separated by commas\n\nOf traced paths, as layers of an .exr: {}; `parts` for those that add up to the picture, or `all`.\n\nIn real time, as layers of an .exr, or as pictures beside a .png, .jpg or .webp (rt.png, rt.normal.png …): `all`, `parts` (those that add up to the picture), or\n",
        paths.join(", ")
    );
    let width = Pass::ALL.iter().map(|p| p.name().len()).max().unwrap_or(0);
    for p in Pass::ALL {
        text += &format!("  {:width$}  {}\n", p.name(), p.about());
    }
    text + "The founding notes' N, TBN, NL, NV, HV, D, F, G, Ks, Kd, SH and AO are understood. As pictures: light is developed as the picture is, colour encoded as sRGB, other numbers are proportional to the sample (vectors −1..1 to 0..1; depth, D and mip over their largest value, which the file's metadata tell)"
}

/// What `--preset` takes.
pub(crate) fn presets() -> String {
    let names: Vec<_> = Preset::ALL.iter().map(|p| p.name()).collect();
    let mut text = format!(
        "In real time: whose approximations to make: {} [default: exact]\n\nWhat each changes of the default:\n",
        names.join(", ")
    );
    for p in Preset::ALL.iter().filter(|p| **p != Preset::Exact) {
        let changed = p.choices().difference(&Choices::default()).replace(',', ", ");
        text += &format!("  {}: {changed}\n", p.name());
    }
    text
}

/// What `--choice` takes.
pub(crate) fn choices() -> String {
    let mut text = String::from(
        "In real time: one approximation or another, as KEY=VALUE, several with commas (repeatable), over what --preset chooses\n\nThe default is the first value.\n",
    );
    let default = Choices::default();
    for k in Choices::KEYS {
        let first = default.get(k.name).unwrap_or_default();
        let others = k.values.iter().filter(|v| **v != first);
        let values: Vec<_> = std::iter::once(&first).chain(others).copied().collect();
        text += &format!("  {}: {} ({})\n", k.name, values.join(", "), k.about);
    }
    text
}
