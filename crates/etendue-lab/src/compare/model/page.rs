//! The report on a model as one page.

use super::{Against, ModelReport, Side, TermError, Variant, brightness};
use crate::compare::paint::Painting;
use crate::compare::pictures::verdict;
use crate::compare::view::{SCRIPT, STYLE, Set, closeup, viewer};
use crate::html::{escape, page_with_script};
use core::fmt::Write;

const TITLES: [&str; 2] = ["path tracer", "real time"];
const ALONE: [&str; 2] = ["lights alone", "real time"];
const MORE: &str = "\
.bar1{display:inline-block;height:.6rem;background:var(--accent);margin-left:.4rem;vertical-align:baseline}
.same td{color:var(--dim)}tr.basis td{border-top:1px solid var(--line);font-weight:600}
button{font:inherit;font-size:.85em;color:inherit;background:var(--paper);border:1px solid var(--line);border-radius:4px;cursor:pointer}
button:focus-visible{outline:3px solid var(--focus)}
td.r{white-space:nowrap}
";

impl ModelReport {
    /// The report as one page that needs nothing else.
    pub fn to_html(&self) -> String {
        let mut out = String::new();
        // Writing to a string does not fail.
        let _ = self.head(&mut out);
        out += &viewer();
        let _ = self.term_table(&mut out);
        let _ = self.unknown_table(&mut out);
        let _ = self.preset_table(&mut out);
        let _ = self.ablation_table(&mut out);
        self.pictures(&mut out);
        let _ = self.made(&mut out);
        let title = format!("Real time beside the path tracer: {}", self.title);
        page_with_script(&title, &format!("{STYLE}{MORE}"), &out, SCRIPT)
    }

    fn head(&self, out: &mut String) -> core::fmt::Result {
        writeln!(out, "<p><code>{}</code></p>", escape(&self.command))?;
        if let Some((max, against)) = self.max_flip {
            let what = if against == Against::Whole { "the path tracer" } else { "lights alone" };
            writeln!(out, "<p>{} (beside {what})</p>", verdict(self.side(against).flip.mean, Some(max)))?;
        }
        out.push_str(
            "<div class=\"wide\"><table class=\"f\"><tr><th></th><th class=\"r\">FLIP</th><th class=\"r\">of surfaces</th>\
             <th class=\"r\">95 %</th><th class=\"r\">largest</th><th class=\"r\">HDR-FLIP</th><th class=\"r\">relMSE</th>\
             <th class=\"r\">bias</th><th class=\"r\">noise of the reference</th></tr>\n",
        );
        let row = |out: &mut String, name: &str, s: &Side| {
            writeln!(
                out,
                "<tr><td>{name}</td><td class=\"r\"><b>{:.4}</b></td><td class=\"r\">{:.4}</td><td class=\"r\">{:.4}</td>\
                 <td class=\"r\">{:.3}</td><td class=\"r\">{:.4}</td><td class=\"r\">{:.2e}</td><td class=\"r\">{:+.2e}</td>\
                 <td class=\"r\">{:.4}</td></tr>",
                s.flip.mean,
                s.flip_of_surfaces,
                s.flip.p95,
                s.flip.max,
                s.hdr_flip,
                s.light.rel_mse,
                brightness(s.light.bias),
                s.noise
            )
        };
        row(out, "the shading, beside lights and sky alone", &self.shading)?;
        row(out, "the picture, beside the path tracer", &self.whole)?;
        out.push_str(
            "</table></div>\n<p class=\"dim\">The first row is the error of the shading model: both sides without shadows, \
             occlusion and interreflection. The second row is the error of the picture. FLIP is the mean over all pixels of \
             the developed pictures, 0 to 1; noise is the FLIP that the reference's own noise makes: no figure is known more \
             closely than that.</p>\n",
        );
        if self.rejected > 0 {
            writeln!(
                out,
                "<p class=\"bad\">{} samples were not numbers and count as black.</p>",
                self.rejected
            )?;
        }
        Ok(())
    }

    fn term_table(&self, out: &mut String) -> core::fmt::Result {
        out.push_str(
            "<h2>The shading, term by term</h2>\n<p>Each term of the model beside the same part of the light, without shadows, \
             occlusion and interreflection. FLIP in the picture is what this term's error alone would make.</p>\n\
             <div class=\"wide\"><table class=\"f\"><tr><th>term</th><th class=\"r\">lights alone</th><th class=\"r\">real time</th>\
             <th class=\"r\">differs by</th><th class=\"r\">RMSE</th><th class=\"r\">relMSE</th><th class=\"r\">FLIP of the term</th>\
             <th>FLIP in the picture</th><th></th></tr>\n",
        );
        let most = self.terms.iter().map(|t| t.effect).fold(1e-9, f64::max);
        for t in self.terms.iter().filter(|t| !t.is_absent()) {
            let (r, m) = (brightness(t.reference), brightness(t.model));
            let differs = if r > 0.0 { format!("{:+.2} %", 100.0 * (m - r) / r) } else { "new".into() };
            writeln!(
                out,
                "<tr><td>{}</td><td class=\"r\">{r:.5}</td><td class=\"r\">{m:.5}</td><td class=\"r\">{differs}</td>\
                 <td class=\"r\">{:.2e}</td><td class=\"r\">{:.2e}</td><td class=\"r\">{:.4}</td><td>{}</td><td>{}</td></tr>",
                t.name,
                t.rmse,
                t.rel_mse,
                t.flip,
                bar(t.effect, most),
                if shown(t) { button(t.name) } else { String::new() }
            )?;
        }
        let absent: Vec<&str> = self.terms.iter().filter(|t| t.is_absent()).map(|t| t.name).collect();
        out.push_str("</table></div>\n");
        if !absent.is_empty() {
            writeln!(out, "<p class=\"dim\">Not in this picture: {}.</p>", absent.join(", "))?;
        }
        Ok(())
    }

    fn unknown_table(&self, out: &mut String) -> core::fmt::Result {
        out.push_str(
            "<h2>What the model cannot know</h2>\n<p>The path tracer's picture beside its own without shadows, occlusion and \
             interreflection: what a shading model that sees one point at a time has no way to find.</p>\n\
             <div class=\"wide\"><table class=\"f\"><tr><th>what</th><th></th><th class=\"r\">changes the mean light by</th>\
             <th>FLIP in the picture</th></tr>\n",
        );
        let most = self.unknowns.iter().map(|u| u.effect).fold(1e-9, f64::max);
        for u in self.unknowns.iter().filter(|u| u.change != [0.0; 3]) {
            writeln!(
                out,
                "<tr><td>{}</td><td>{}</td><td class=\"r\">{:+.5}</td><td>{}</td></tr>",
                u.name,
                u.about,
                brightness(u.change),
                bar(u.effect, most)
            )?;
        }
        writeln!(out, "</table></div>\n<p>{}</p>", button("what the model cannot know"))
    }

    fn preset_table(&self, out: &mut String) -> core::fmt::Result {
        if self.presets.is_empty() {
            return Ok(());
        }
        writeln!(
            out,
            "<h2>Presets</h2>\n<p>Each set of choices beside both references; beside lights alone without shadows and \
             occlusion. {} samples to a pixel.</p>\n<div class=\"wide\"><table class=\"f\"><tr><th>preset</th>\
             <th>FLIP, shading</th><th class=\"r\">relMSE</th><th>FLIP, picture</th><th class=\"r\">relMSE</th>\
             <th class=\"r\">cost, ns per sample</th><th class=\"r\">sky, s</th></tr>",
            self.samples[1]
        )?;
        let most = self.presets.iter().map(|v| v.flip).fold(1e-9, f64::max);
        for pair in self.presets.chunks_exact(2) {
            let (a, b) = (&pair[0], &pair[1]);
            writeln!(
                out,
                "<tr><td>{}</td><td>{}</td><td class=\"r\">{:.2e}</td><td>{}</td><td class=\"r\">{:.2e}</td>\
                 <td class=\"r\">{:.0}</td><td class=\"r\">{:.2}</td></tr>",
                a.value,
                bar(a.flip, most),
                a.rel_mse,
                bar(b.flip, most),
                b.rel_mse,
                b.nanoseconds,
                b.bake_seconds
            )?;
        }
        out.push_str("</table></div>\n");
        Ok(())
    }

    fn ablation_table(&self, out: &mut String) -> core::fmt::Result {
        if self.ablations.len() < 3 {
            return Ok(());
        }
        writeln!(
            out,
            "<h2>Ablations</h2>\n<p>Each choice changed in turn, the others kept. Occlusion and shadows are judged beside \
             the path tracer, all others beside lights alone; choices of the split sum with the split sum. Differences are to \
             the row in bold above. Costs are thread time per sample of a pixel, camera ray included, measured once: differences \
             of a tenth mean nothing. Samples to a pixel: {}; with few of them all figures are a little higher than above.</p>\n\
             <div class=\"wide\"><table class=\"f\"><tr><th>choice</th><th>value</th><th class=\"r\">FLIP</th><th class=\"r\">buys</th>\
             <th class=\"r\">relMSE</th><th class=\"r\">×</th><th class=\"r\">cost, ns</th><th class=\"r\">×</th><th class=\"r\">sky, s</th>\
             <th></th></tr>",
            self.samples[2]
        )?;
        for (i, basis) in self.ablations.iter().enumerate().filter(|(i, v)| v.is_basis(*i, &self.ablations)) {
            let what = match basis.against {
                Against::LightOnly => "shading",
                Against::Whole => "picture",
            };
            let name = if basis.key.is_empty() { "as chosen" } else { basis.value };
            writeln!(
                out,
                "<tr class=\"basis\"><td>{name}</td><td>{what}</td><td class=\"r\">{:.4}</td><td></td>\
                 <td class=\"r\">{:.2e}</td><td></td><td class=\"r\">{:.0}</td><td></td><td class=\"r\">{:.2}</td><td></td></tr>",
                basis.flip, basis.rel_mse, basis.nanoseconds, basis.bake_seconds
            )?;
            for (_, v) in self
                .ablations
                .iter()
                .enumerate()
                .filter(|(j, v)| *j != i && v.base == i && !v.is_basis(*j, &self.ablations))
            {
                ablation(out, v, basis)?;
            }
        }
        out.push_str("</table></div>\n");
        Ok(())
    }

    fn pictures(&self, out: &mut String) {
        let paint = |p: &etendue_image::Image| Painting::of(p, &self.development);
        let whole = self.whole.pictures.each_ref().map(paint);
        let alone = self.shading.pictures.each_ref().map(paint);
        out.push_str("<h2>Pictures</h2>\n<h3>The picture, beside the path tracer</h3>\n");
        let set = |name, titles, pair: &[Painting; 2], flip: Option<&[f32]>, out: &mut String| {
            Set { name, titles, reference: &pair[0], test: &pair[1], flip }.write(out);
        };
        set("the picture", TITLES, &whole, Some(&self.whole.map), out);
        if self.whole.flip.max > 0.0 {
            let [x, y] = self.whole.flip.worst;
            let _ = writeln!(out, "<h3>The worst place: FLIP {:.3} at {x}, {y}</h3>", self.whole.flip.max);
            closeup(out, [x, y], &whole[0], &whole[1], TITLES);
        }
        out.push_str("<h3>The shading, beside lights and sky alone</h3>\n");
        set("the shading", ALONE, &alone, Some(&self.shading.map), out);
        for t in self.terms.iter().filter(|t| shown(t)) {
            let _ = writeln!(out, "<h3>{}</h3>", t.name);
            set(t.name, ALONE, &t.pictures.each_ref().map(paint), None, out);
        }
        out.push_str("<h3>What the model cannot know</h3>\n");
        let [truth, _] = whole;
        let [without, _] = alone;
        set("what the model cannot know", ["path tracer", "lights alone"], &[truth, without], None, out);
    }

    fn made(&self, out: &mut String) -> core::fmt::Result {
        let [reference, realtime, _] = self.samples;
        writeln!(
            out,
            "<h2>How it was made</h2>\n<p>{} × {} pixels, {reference} samples for each reference and {realtime} for the \
             real-time picture, seed {}; exposure {} EV, tone curve {}; FLIP at {:.1} pixels per degree. Real-time choices: \
             <code>{}</code></p>",
            self.size[0],
            self.size[1],
            self.seed,
            self.development.exposure_ev,
            self.development.curve,
            self.whole.flip.pixels_per_degree,
            self.choices
        )
    }
}

impl Variant {
    /// True if other rows are compared with this one.
    fn is_basis(&self, index: usize, all: &[Variant]) -> bool {
        self.base == index || (self.key == "specular" && all.iter().any(|v| v.base == index))
    }
}

fn ablation(out: &mut String, v: &Variant, basis: &Variant) -> core::fmt::Result {
    let exact = if v.exact { " (exact)" } else { "" };
    if v.no_effect {
        return writeln!(
            out,
            "<tr class=\"same\"><td>{}</td><td>{}{exact}</td><td colspan=\"8\">nothing changes in this scene</td></tr>",
            v.key, v.value
        );
    }
    writeln!(
        out,
        "<tr><td>{}</td><td>{}{exact}</td><td class=\"r\">{:.4}</td><td class=\"r\">{:+.4}</td><td class=\"r\">{:.2e}</td>\
         <td class=\"r\">{:.2}</td><td class=\"r\">{:.0}</td><td class=\"r\">{:.2}</td><td class=\"r\">{:.2}</td><td>{}</td></tr>",
        v.key,
        v.value,
        v.flip,
        basis.flip - v.flip,
        v.rel_mse,
        v.rel_mse / basis.rel_mse.max(1e-30),
        v.nanoseconds,
        v.nanoseconds / basis.nanoseconds.max(1e-9),
        v.bake_seconds,
        if v.flip < basis.flip - 5e-4 { "<span class=\"good\">better</span>" } else { "" }
    )
}

/// True if the term has pictures on the page.
fn shown(t: &TermError) -> bool {
    !t.is_absent() && t.name != "environment" && t.name != "emission"
}

fn bar(value: f64, most: f64) -> String {
    let width = (6.0 * value / most).max(0.0);
    format!("{value:.4}<span class=\"bar1\" style=\"width:{width:.2}rem\"></span>")
}

fn button(set: &str) -> String {
    format!("<button data-open=\"{}\" hidden>look</button>", escape(set))
}
