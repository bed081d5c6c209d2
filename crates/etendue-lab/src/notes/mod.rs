//! The formulas that the founding notes got wrong, beside the right ones, with the size of the error.
//!
//! The notes are three texts on physically based shading with which this project began. What they state is right for the
//! greater part; what is listed here is not, or is an approximation that a user should know the price of. Every error is
//! computed when the page is made, from the formulas as they stand there and from this project's functions.

mod diffuse;
mod environment;
mod microfacet;

use crate::{
    draw::{Chart, Drawing},
    html::{escape, page},
};
use core::fmt::Write;

/// One formula.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// What it is about.
    pub title: &'static str,
    /// What is wrong, in a sentence or two.
    pub fault: &'static str,
    /// As the notes have it.
    pub noted: &'static str,
    /// As it should be.
    pub right: &'static str,
    /// Where the right form comes from.
    pub source: &'static str,
    /// What the error is measured in and over which range.
    pub measure: &'static str,
    /// The largest error.
    pub max: f64,
    /// Its root mean square over the range.
    pub rms: f64,
    /// Both forms.
    pub chart: Chart,
}

/// Largest and root mean square of differences.
pub(crate) fn error(pairs: impl Iterator<Item = (f64, f64)>) -> (f64, f64) {
    let (mut max, mut sum, mut n) = (0.0f64, 0.0, 0usize);
    for (a, b) in pairs {
        let d = (a - b).abs();
        max = max.max(d);
        sum += d * d;
        n += 1;
    }
    (max, (sum / n.max(1) as f64).sqrt())
}

/// All formulas, in the order of the notes' subjects. Takes a second.
pub fn entries() -> Vec<Entry> {
    let mut out = diffuse::entries();
    out.extend(microfacet::entries());
    out.extend(environment::entries());
    out
}

/// One line for each.
pub fn summary(entries: &[Entry]) -> String {
    let mut out = String::new();
    for e in entries {
        // Writing to a string does not fail.
        let _ = writeln!(out, "{:44} max {:>9.3e}  RMS {:>9.3e}  ({})", e.title, e.max, e.rms, e.measure);
    }
    out
}

/// One page that needs nothing else.
pub fn to_html(entries: &[Entry]) -> String {
    let mut body = String::from(
        "<p>Each formula as the founding notes have it and as it should be, with the error computed live. \
         Made by: <code>etendue lab notes</code></p>\n\
         <table><tr><th>formula</th><th>largest error</th><th>RMS</th><th>measured as</th></tr>\n",
    );
    for (i, e) in entries.iter().enumerate() {
        let _ = writeln!(
            body,
            "<tr><td><a href=\"#n{i}\">{}</a></td><td class=\"n\">{:.3e}</td><td class=\"n\">{:.3e}</td><td>{}</td></tr>",
            escape(e.title),
            e.max,
            e.rms,
            escape(e.measure)
        );
    }
    body.push_str("</table>\n");
    for (i, e) in entries.iter().enumerate() {
        let mut d = Drawing::new(900, 460);
        e.chart.draw(&mut d, [8.0, 8.0], [880.0, 440.0]);
        let _ = writeln!(
            body,
            "<h2 id=\"n{i}\">{}</h2>\n<p>{}</p>\n<table><tr><th>the notes</th><td><pre>{}</pre></td></tr>\n\
             <tr><th>right</th><td><pre>{}</pre></td></tr>\n<tr><th>source</th><td>{}</td></tr>\n\
             <tr><th>error</th><td>largest <b>{:.4}</b>, root mean square <b>{:.4}</b>: {}</td></tr></table>\n{}",
            escape(e.title),
            escape(e.fault),
            escape(e.noted),
            escape(e.right),
            escape(e.source),
            e.max,
            e.rms,
            escape(e.measure),
            d.to_svg()
        );
    }
    page("Formulas of the founding notes", "pre{margin:0}", &body)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_error_is_there_and_on_the_page() {
        let all = entries();
        let page = to_html(&all);
        for e in &all {
            assert!(e.max > 0.0 && e.rms > 0.0 && e.max >= e.rms && e.max.is_finite(), "{}: {e:?}", e.title);
            assert!(e.chart.series.len() >= 2 && page.contains(&escape(e.title)));
            let all_there = e.chart.series.iter().all(|s| s.points.iter().all(|p| p[1].is_finite()));
            assert!(all_there, "{}", e.title);
        }
    }
}
