//! The report on two picture files.

use super::figures::{CompareError, Comparison, compare};
use super::paint::Painting;
use super::view::{SCRIPT, STYLE, Set, closeup, viewer};
use crate::html::{escape, page_with_script};
use core::fmt::Write;
use etendue_image::{Development, Image, Pixels};
use serde_json::{Value, json};

/// Two pictures, and how far they are apart.
#[derive(Clone, Debug)]
pub struct PictureReport {
    /// Names of the reference and of the picture that is compared with it, and the pictures.
    pub sides: [(String, Image); 2],
    /// The outcome.
    pub comparison: Comparison,
    /// Mean FLIP up to which they count as alike.
    pub max_flip: Option<f64>,
    /// How light is shown on the page; figures do not depend on it.
    pub development: Development,
    /// The command that made the report.
    pub command: String,
}

impl PictureReport {
    /// Compares `test` with `reference`, each with its name.
    ///
    /// # Errors
    /// Those of [`compare`].
    pub fn new(
        reference: (String, Image),
        test: (String, Image),
        pixels_per_degree: f32,
    ) -> Result<Self, CompareError> {
        let comparison = compare(&reference.1, &test.1, pixels_per_degree)?;
        Ok(Self {
            sides: [reference, test],
            comparison,
            max_flip: None,
            development: Development::default(),
            command: String::new(),
        })
    }

    /// False if the mean FLIP is above [`PictureReport::max_flip`].
    pub fn passes(&self) -> bool {
        self.max_flip.is_none_or(|max| self.comparison.figures.flip.mean <= max)
    }

    /// The figures as JSON:
    ///
    /// | key | value |
    /// |---|---|
    /// | `kind` | `"pictures"` |
    /// | `command` | text |
    /// | `reference`, `test` | objects: `path`, `width`, `height`, `channels`, `samples` (`"display"` or `"light"`) |
    /// | `flip` | object: `metric` (`"LDR-FLIP"` or `"HDR-FLIP"`), `pixels_per_degree`, `mean`, `median`, `p75`, `p95`, `p99`, `max`, `worst` (column, row) |
    /// | `rmse`, `psnr` (dB; `null` for light or equal pictures), `rel_mse`, `bias` (R, G, B), `alpha_rmse` (`null` without alpha), `not_finite` (pixels of either) | see [`super::Figures`] |
    /// | `max_flip` | the limit, or `null` |
    /// | `passes` | true unless the mean FLIP is above the limit |
    pub fn to_json(&self) -> Value {
        let side = |(path, image): &(String, Image)| {
            let samples = if matches!(image.pixels, Pixels::F32(_)) { "light" } else { "display" };
            json!({
                "path": path, "width": image.width, "height": image.height, "channels": image.channels,
                "samples": samples,
            })
        };
        let mut out = json!({
            "kind": "pictures", "command": self.command, "reference": side(&self.sides[0]),
            "test": side(&self.sides[1]), "max_flip": self.max_flip, "passes": self.passes(),
        });
        if let (Value::Object(out), Value::Object(figures)) = (&mut out, self.comparison.figures.to_json()) {
            out.extend(figures);
        }
        out
    }

    /// The report as one page that needs nothing else.
    pub fn to_html(&self) -> String {
        let titles = ["reference", "picture"];
        let [reference, test] =
            [&self.sides[0].1, &self.sides[1].1].map(|i| Painting::of(i, &self.development));
        let f = &self.comparison.figures;
        let mut body = String::new();
        // Writing to a string does not fail.
        let _ = write!(
            body,
            "<p>Reference <code>{}</code>, picture <code>{}</code>, {} × {} pixels. {}</p>\n<p><code>{}</code></p>\n",
            escape(&self.sides[0].0),
            escape(&self.sides[1].0),
            reference.size[0],
            reference.size[1],
            verdict(f.flip.mean, self.max_flip),
            escape(&self.command)
        );
        let _ = writeln!(body, "<pre>{}</pre>", escape(f.to_text().trim_end()));
        body += &viewer();
        body += "<h2>Pictures</h2>\n";
        let set = Set {
            name: "picture",
            titles,
            reference: &reference,
            test: &test,
            flip: Some(&self.comparison.map),
        };
        set.write(&mut body);
        if f.flip.max > 0.0 {
            let [x, y] = f.flip.worst;
            let _ = writeln!(body, "<h2>The worst place: FLIP {:.3} at {x}, {y}</h2>", f.flip.max);
            closeup(&mut body, f.flip.worst, &reference, &test, titles);
        }
        page_with_script("Comparison", STYLE, &body, SCRIPT)
    }
}

/// What a limit says of a mean, for a page.
pub(crate) fn verdict(mean: f64, limit: Option<f64>) -> String {
    match limit {
        None => String::new(),
        Some(max) if mean <= max => {
            format!("<span class=\"good\">Passes: mean FLIP {mean:.5} is at most {max}.</span>")
        }
        Some(max) => format!("<span class=\"bad\">Fails: mean FLIP {mean:.5} is above {max}.</span>"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue_image::DEFAULT_PPD;

    #[test]
    fn page_and_json_hold_the_figures_and_nothing_from_elsewhere() {
        let image = |v: u8| Image {
            width: 12,
            height: 9,
            channels: 3,
            pixels: Pixels::U8((0..324).map(|i| v.wrapping_mul(i as u8)).collect()),
        };
        let (a, b) = (("a<1>.png".to_string(), image(3)), ("b.png".to_string(), image(5)));
        let mut report = PictureReport::new(a, b, DEFAULT_PPD).unwrap();
        assert!(report.passes());
        report.max_flip = Some(0.01);
        assert!(!report.passes());
        let json = report.to_json();
        assert_eq!(json["flip"]["mean"], report.comparison.figures.flip.mean);
        assert_eq!((&json["passes"], &json["reference"]["samples"]), (&json!(false), &json!("display")));
        let page = report.to_html();
        assert!(page.contains("a&lt;1&gt;.png") && page.contains("Fails: mean FLIP"));
        // Two pictures, two maps, the map's values, two close-ups: all inside.
        assert_eq!(page.matches("src=\"data:image/png;base64,").count(), 7);
        assert!(!page.contains("http") && !page.contains("src=\"/"));
    }
}
