//! A drawing as SVG.

use super::{Anchor, Drawing, Item, Rgb};
use base64::{Engine, engine::general_purpose::STANDARD};
use core::fmt::Write;

pub(super) fn write(d: &Drawing) -> String {
    let (w, h) = (d.width, d.height);
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w}\" height=\"{h}\" viewBox=\"0 0 {w} {h}\" \
         font-family=\"ui-monospace,'Noto Sans Mono','DejaVu Sans Mono',Menlo,Consolas,monospace\">\n\
         <rect width=\"{w}\" height=\"{h}\" fill=\"#ffffff\"/>\n"
    );
    for item in &d.items {
        // Writing to a string does not fail.
        let _ = write_item(&mut out, item);
    }
    out.push_str("</svg>\n");
    out
}

fn write_item(out: &mut String, item: &Item) -> core::fmt::Result {
    match item {
        Item::Line { points, width, color, dash } => {
            write!(
                out,
                "<polyline fill=\"none\" stroke=\"{}\" stroke-width=\"{width}\" stroke-linejoin=\"round\"",
                hex(*color)
            )?;
            if let Some([a, b]) = dash {
                write!(out, " stroke-dasharray=\"{a} {b}\"")?;
            }
            writeln!(out, " points=\"{}\"/>", list(points))
        }
        Item::Fill { points, color, opacity } => {
            write!(out, "<polygon fill=\"{}\"", hex(*color))?;
            if *opacity < 1.0 {
                write!(out, " fill-opacity=\"{opacity}\"")?;
            }
            writeln!(out, " points=\"{}\"/>", list(points))
        }
        Item::Text { at: [x, y], text, large, color, anchor, upright } => {
            let size = if *large { 18.0 } else { 13.3 };
            let weight = if *large { " font-weight=\"bold\"" } else { "" };
            let anchor = match anchor {
                Anchor::Start => "start",
                Anchor::Middle => "middle",
                Anchor::End => "end",
            };
            let turn = if *upright { format!(" transform=\"rotate(-90 {x} {y})\"") } else { String::new() };
            writeln!(
                out,
                "<text x=\"{x}\" y=\"{y}\" dy=\"0.35em\" font-size=\"{size}\"{weight} fill=\"{}\" \
                 text-anchor=\"{anchor}\"{turn}>{}</text>",
                hex(*color),
                escape(text)
            )
        }
        Item::Picture { at: [x, y], size: [w, h], cells: [nx, ny], pixels } => {
            let bytes: Vec<u8> = pixels
                .iter()
                .flat_map(|p| p.map_or([255, 255, 255, 0], |[r, g, b]| [r, g, b, 255]))
                .collect();
            let Ok(png) = super::encode(*nx as u32, *ny as u32, png::ColorType::Rgba, &bytes) else {
                return Ok(());
            };
            writeln!(
                out,
                "<image x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\" preserveAspectRatio=\"none\" \
                 image-rendering=\"pixelated\" href=\"data:image/png;base64,{}\"/>",
                STANDARD.encode(png)
            )
        }
    }
}

fn hex([r, g, b]: Rgb) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

fn list(points: &[[f32; 2]]) -> String {
    let mut out = String::new();
    for (i, [x, y]) in points.iter().enumerate() {
        let gap = if i == 0 { "" } else { " " };
        let _ = write!(out, "{gap}{x:.2},{y:.2}");
    }
    out
}

/// Text for SVG and HTML.
pub(crate) fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
