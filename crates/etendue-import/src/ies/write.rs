//! Profiles as text.

use etendue_scene::{LightProfile, Web};
use std::fmt::Write;

/// A profile as LM-63-2002 text, absolute photometry (lumens −1), without symmetries.
pub fn write_ies(profile: &LightProfile) -> String {
    let mut out = String::from(
        "IESNA:LM-63-2002\n[TEST] unknown\n[TESTLAB] unknown\n[ISSUEDATE] unknown\n[MANUFAC] unknown\nTILT=NONE\n",
    );
    let (v, h) = (profile.vertical(), profile.horizontal());
    let web = match profile.web() {
        Web::C => 1,
        Web::B => 2,
        Web::A => 3,
    };
    let _ = writeln!(out, "1 -1 1 {} {} {web} 2 0 0 0\n1 1 0", v.len(), h.len());
    let mut list = |values: &[f32]| {
        for row in values.chunks(10) {
            let row: Vec<String> = row.iter().map(f32::to_string).collect();
            let _ = writeln!(out, "{}", row.join(" "));
        }
    };
    list(v);
    list(h);
    profile.intensities().chunks(v.len()).for_each(list);
    out
}
