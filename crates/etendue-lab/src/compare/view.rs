//! Sets of pictures on a page, and the viewer that shows one of them at a time.

use super::paint::{Painting, brightness_error, scale_end, values_uri};
use crate::draw::{DIVERGING, MAGMA, Rgb};
use crate::html::escape;
use core::fmt::Write;

/// The style of figures and viewer.
pub(crate) const STYLE: &str = include_str!("view.css");
/// What makes the viewer work.
pub(crate) const SCRIPT: &str = include_str!("view.js");

/// Pictures of the same thing: two, and maps of their difference.
pub(crate) struct Set<'a> {
    /// What they show, unique on the page.
    pub name: &'a str,
    /// What the two are called.
    pub titles: [&'a str; 2],
    pub reference: &'a Painting,
    pub test: &'a Painting,
    /// FLIP of each pixel, if it was computed.
    pub flip: Option<&'a [f32]>,
}

impl Set<'_> {
    /// Appends the figures.
    pub fn write(&self, out: &mut String) {
        let size = self.reference.size;
        // Writing to a string does not fail.
        let [name, reference, test] = [self.name, self.titles[0], self.titles[1]].map(escape);
        let _ = write!(
            out,
            "<div class=\"set\" data-name=\"{name}\" data-reference=\"{reference}\" data-test=\"{test}\">"
        );
        figure(out, "test", &self.test.uri(), &escape(self.titles[1]));
        figure(out, "reference", &self.reference.uri(), &escape(self.titles[0]));
        if let Some(map) = self.flip {
            let top = scale_end(map);
            let caption = format!("FLIP {}", legend(&MAGMA, "0", &format!("{top}")));
            figure(out, "flip", &Painting::flip(map, size, top).uri(), &caption);
            let _ =
                write!(out, "<img data-role=\"values\" src=\"{}\" alt=\"\" hidden>", values_uri(map, size));
        }
        let map = brightness_error(self.reference, self.test);
        let top = scale_end(&map);
        let ends = [format!("−{top} darker"), format!("brighter +{top}")];
        let caption = format!("signed error {}", legend(&DIVERGING, &ends[0], &ends[1]));
        figure(out, "signed", &Painting::signed(&map, size, top).uri(), &caption);
        out.push_str("</div>\n");
    }
}

fn figure(out: &mut String, role: &str, uri: &str, caption: &str) {
    let _ = writeln!(
        out,
        "<figure><img data-role=\"{role}\" src=\"{uri}\" alt=\"{role}\"><figcaption>{caption}</figcaption></figure>"
    );
}

/// The colours of a scale with the values of its ends.
fn legend(stops: &[Rgb], low: &str, high: &str) -> String {
    let colors: Vec<String> =
        stops.iter().map(|c| format!("#{:02x}{:02x}{:02x}", c[0], c[1], c[2])).collect();
    format!(
        "{} <span class=\"legend\" style=\"background:linear-gradient(90deg,{})\"></span> {}",
        escape(low),
        colors.join(","),
        escape(high)
    )
}

/// The viewer's place; it appears when the page's script runs.
pub(crate) fn viewer() -> String {
    let mut modes = String::new();
    for (value, label) in [
        ("slider", "slider"),
        ("both", "side by side"),
        ("test", "left"),
        ("reference", "right"),
        ("flip", "FLIP"),
        ("signed", "signed error"),
    ] {
        let checked = if value == "slider" { " checked" } else { "" };
        let _ = write!(
            modes,
            "<label><input type=\"radio\" name=\"mode\" value=\"{value}\"{checked}><span>{label}</span></label>"
        );
    }
    format!(
        "<section class=\"viewer\" aria-label=\"Viewer\" hidden>\n\
         <div class=\"bar\"><label>Show <select name=\"set\"></select></label>\n\
         <fieldset aria-label=\"Mode\">{modes}</fieldset>\n\
         <label>Zoom <select name=\"zoom\"><option value=\"fit\">fit</option><option value=\"1\">1</option>\
         <option value=\"2\">2</option><option value=\"4\">4</option><option value=\"8\">8</option></select></label></div>\n\
         <div class=\"stage\" tabindex=\"0\" aria-label=\"Picture; f flips between the two, arrows move the divide\">\
         <div class=\"panes\"></div></div>\n\
         <input class=\"cut\" type=\"range\" min=\"0\" max=\"1000\" value=\"500\" aria-label=\"Divide\">\n\
         <output class=\"read\">Point at a pixel for its values; f flips between the two.</output>\n</section>\n"
    )
}

/// Three enlarged pieces about a place: how the worst looks.
pub(crate) fn closeup(
    out: &mut String,
    place: [u32; 2],
    reference: &Painting,
    test: &Painting,
    titles: [&str; 2],
) {
    const SIDE: u32 = 48;
    out.push_str("<div class=\"set pixels\">");
    for (painting, title) in [(test, titles[1]), (reference, titles[0])] {
        let (piece, from) = painting.crop(place, SIDE);
        let [r, g, b] = painting.at(place);
        let caption = format!(
            "{}, {} × {} pixels from {}, {}; R G B in the middle of the error: {r} {g} {b}",
            escape(title),
            piece.size[0],
            piece.size[1],
            from[0],
            from[1]
        );
        figure(out, "closeup", &piece.uri(), &caption);
    }
    out.push_str("</div>\n");
}
