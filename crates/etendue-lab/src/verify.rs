//! The laws over many models in parallel, and what came of it as a page and as JSON.

use crate::html::{escape, page};
use core::fmt::Write;
use core::sync::atomic::{AtomicUsize, Ordering};
use etendue_bxdf::{
    laws::{
        cases::{Settings, cases},
        verify::{CaseReport, Cell, Law, Report, Verdict, judge, measure},
    },
    model::Model,
};
use rayon::prelude::*;
use serde_json::{Value, json};

/// Puts all `models` to every law, on all threads of the current rayon pool.
///
/// `progress` is told how many of how many cases are done; it is called from several threads.
pub fn run(models: &[Model], settings: &Settings, progress: &(dyn Fn(usize, usize) + Sync)) -> Report {
    let work: Vec<_> = models.iter().flat_map(|m| cases(m, settings)).collect();
    let (done, total) = (AtomicUsize::new(0), work.len());
    progress(0, total);
    let measured = work
        .into_par_iter()
        .with_max_len(1)
        .map(|case| {
            let cells = measure(&case, settings);
            progress(done.fetch_add(1, Ordering::Relaxed) + 1, total);
            CaseReport { case, cells }
        })
        .collect();
    judge(measured, settings.significance)
}

/// What is printed at the end: counts by law, then each broken cell.
pub fn summary(report: &Report) -> String {
    let mut out = String::new();
    for law in Law::ALL {
        let of =
            |v: fn(&Verdict) -> bool| report.cells().filter(|(_, c)| c.law == law && v(&c.verdict)).count();
        let (holds, fails, waived) = (
            of(|v| *v == Verdict::Holds),
            of(|v| *v == Verdict::Fails),
            of(|v| matches!(v, Verdict::Waived(_))),
        );
        let _ = writeln!(
            out,
            "{:20} {holds:6} hold {fails:6} fail {waived:6} not claimed   {}",
            law.name(),
            law.about()
        );
    }
    for (case, cell) in report.failures() {
        let angle = cell.angle.map_or(String::new(), |a| format!(", wo at {a}°"));
        let _ = writeln!(
            out,
            "FAILS  {}{angle}: {} {:.3e}, bound {:.3e}; {}",
            case.label(),
            cell.law.name(),
            cell.value,
            cell.bound,
            cell.note
        );
    }
    out
}

/// The whole report as JSON: an array `cells` and the run's settings.
pub fn to_json(report: &Report, settings: &Settings, command: &str) -> Value {
    // JSON has no infinity: what is not finite becomes text.
    let number = |v: f64| if v.is_finite() { json!(v) } else { json!(v.to_string()) };
    let cells: Vec<Value> = report
        .cells()
        .map(|(case, c)| {
            let (verdict, why) = match c.verdict {
                Verdict::Holds => ("holds", None),
                Verdict::Fails => ("fails", None),
                Verdict::Waived(why) => ("not claimed", Some(why)),
            };
            json!({
                "model": case.model.name(), "case": case.label(), "parameters": case.parameters(),
                "roughness": case.roughness, "anisotropy": case.anisotropy, "front": case.front,
                "transport": format!("{:?}", case.transport).to_lowercase(), "angle": c.angle,
                "law": c.law.name(), "value": number(c.value), "bound": number(c.bound), "verdict": verdict,
                "why": why, "seed": c.seed.to_string(), "note": c.note,
            })
        })
        .collect();
    json!({
        "command": command, "samples": settings.samples, "seed": settings.seed,
        "significance": settings.significance, "statistical_cells": report.statistical, "level": report.level,
        "failures": report.failures().count(), "cells": cells,
    })
}

/// The whole report as one page that needs nothing else: a grid of verdicts by model, case and law.
pub fn to_html(report: &Report, settings: &Settings, command: &str) -> String {
    let mut body = String::new();
    // Writing to a string does not fail.
    let _ = head(&mut body, report, settings, command);
    let mut from = 0;
    while from < report.cases.len() {
        let name = report.cases[from].case.model.name();
        let to = report.cases[from..].iter().position(|c| c.case.model.name() != name);
        let to = to.map_or(report.cases.len(), |n| from + n);
        let _ = model(&mut body, &report.cases[from..to]);
        from = to;
    }
    let style = ".g{border-spacing:0}.g td{border-top:1px solid var(--line)}.g th{font-size:.85em}.g td+td{white-space:nowrap}p b{margin-right:5px}\
                 b{display:inline-block;width:13px;height:13px;margin-right:2px;border-radius:2px}\
                 .h{background:#0072b2}.f{background:#d55e00;outline:2px solid var(--ink)}.w{background:#bbb}\
                 .o{opacity:.45}";
    page("Laws of scattering", style, &body)
}

fn head(out: &mut String, report: &Report, settings: &Settings, command: &str) -> core::fmt::Result {
    let failures = report.failures().count();
    let all = report.cells().count();
    let waived = report.cells().filter(|(_, c)| matches!(c.verdict, Verdict::Waived(_))).count();
    let verdict = if failures == 0 {
        "<b class=\"h\"></b> every claimed law holds".to_string()
    } else {
        format!("<span class=\"bad\">{failures} cells fail</span>")
    };
    write!(
        out,
        "<p>{verdict}: {all} cells in {} cases, {waived} of them not claimed. {} samples per χ² test, seed {}. The {} \
         statistical cells are judged together at significance {}: each at the level {:.2e} (Šidák).</p>\n\
         <p><code>{}</code></p>\n\
         <p><b class=\"h\"></b>holds &nbsp; <b class=\"h o\"></b>holds, within a factor of two of its bound &nbsp; \
         <b class=\"f\"></b>fails &nbsp; <b class=\"w\"></b>not claimed by the model, measured all the same. One square \
         per angle of wo, from the normal outwards; point at it for its figures.</p>\n",
        report.cases.len(),
        settings.samples,
        settings.seed,
        report.statistical,
        settings.significance,
        report.level,
        escape(command)
    )?;
    out.push_str("<table><tr><th>law</th><th>cells</th><th>fail</th><th>worst</th><th></th></tr>\n");
    for law in Law::ALL {
        let cells: Vec<_> = report.cells().filter(|(_, c)| c.law == law).collect();
        let worst = cells
            .iter()
            .filter(|(_, c)| !matches!(c.verdict, Verdict::Waived(_)))
            .max_by(|a, b| badness(a.1).total_cmp(&badness(b.1)));
        let fail = cells.iter().filter(|(_, c)| c.verdict == Verdict::Fails).count();
        writeln!(
            out,
            "<tr><td><code>{}</code></td><td>{}</td><td>{}</td><td class=\"n\">{}</td><td>{}{}</td></tr>",
            law.name(),
            cells.len(),
            if fail > 0 { format!("<span class=\"bad\">{fail}</span>") } else { "0".into() },
            worst.map_or(String::new(), |w| format!("{:.3e}", w.1.value)),
            escape(law.about()),
            worst.map_or(String::new(), |w| format!(
                " <span class=\"dim\">— worst: {}{}</span>",
                escape(&w.0.label()),
                w.1.angle.map_or(String::new(), |a| format!(", {a}°"))
            ))
        )?;
    }
    out.push_str("</table>\n");
    if failures > 0 {
        out.push_str("<h2>What fails</h2>\n<ul>\n");
        for (case, c) in report.failures() {
            let angle = c.angle.map_or(String::new(), |a| format!(", wo at {a}°"));
            writeln!(
                out,
                "<li>{}{angle}: <code>{}</code> {:.3e}, bound {:.3e}. {} <code>{}</code></li>",
                escape(&case.label()),
                c.law.name(),
                c.value,
                c.bound,
                escape(&c.note),
                escape(&case.parameters())
            )?;
        }
        out.push_str("</ul>\n");
    }
    Ok(())
}

/// How near a cell is to its bound, or how far beyond: larger is worse.
fn badness(c: &Cell) -> f64 {
    if c.value.is_nan() {
        f64::INFINITY
    } else if c.law.is_statistical() {
        -c.value
    } else {
        c.value
    }
}

fn model(out: &mut String, cases: &[CaseReport]) -> core::fmt::Result {
    let m = &cases[0].case.model;
    let fails = cases.iter().flat_map(|c| &c.cells).filter(|c| c.verdict == Verdict::Fails).count();
    let text = if fails > 0 { format!(" <span class=\"bad\">{fails} fail</span>") } else { String::new() };
    writeln!(out, "<h2>{}{text}</h2>\n<p>{}</p>", m.name(), escape(m.about()))?;
    let mut reasons: Vec<(Law, &str)> = Vec::new();
    for c in cases.iter().flat_map(|c| &c.cells) {
        if let Verdict::Waived(why) = c.verdict
            && !reasons.contains(&(c.law, why))
        {
            reasons.push((c.law, why));
        }
    }
    for (law, why) in reasons {
        writeln!(out, "<p class=\"dim\">{} is not claimed: {}</p>", law.name(), escape(why))?;
    }
    out.push_str("<table class=\"g\"><tr><th>case</th>");
    for law in Law::ALL {
        write!(out, "<th>{}</th>", law.name())?;
    }
    out.push_str("</tr>\n");
    for c in cases {
        let label = c.case.label();
        let short = label.strip_prefix(m.name()).unwrap_or(&label).trim();
        write!(out, "<tr><td title=\"{}\">{}</td>", escape(&c.case.parameters()), escape(short))?;
        for law in Law::ALL {
            out.push_str("<td>");
            for cell in c.cells.iter().filter(|x| x.law == law) {
                square(out, cell)?;
            }
            out.push_str("</td>");
        }
        out.push_str("</tr>\n");
    }
    out.push_str("</table>\n");
    Ok(())
}

fn square(out: &mut String, c: &Cell) -> core::fmt::Result {
    let near = if c.law.is_statistical() {
        c.value < 2.0 * c.bound
    } else {
        c.law != Law::Furnace && c.bound > 0.0 && c.value > 0.5 * c.bound
    };
    let class = match c.verdict {
        Verdict::Holds if near => "h o",
        Verdict::Holds => "h",
        Verdict::Fails => "f",
        Verdict::Waived(_) => "w",
    };
    let angle = c.angle.map_or(String::new(), |a| format!("wo at {a}°: "));
    write!(
        out,
        "<b class=\"{class}\" title=\"{angle}{:.4e} (bound {:.2e}). {} Seed {}.\"></b>",
        c.value,
        c.bound,
        escape(&c.note),
        c.seed
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_report_says_what_fails_and_why() {
        let model = Model::by_name("lambert").expect("listed");
        let settings = Settings { samples: 2_000, random: 0, ..Settings::quick() };
        let mut report = run(&[model], &settings, &|_, _| ());
        assert_eq!(report.failures().count(), 0);
        let page = to_html(&report, &settings, "etendue lab verify <x>");
        assert!(page.contains("every claimed law holds") && page.contains("&lt;x&gt;"));
        let cell = &mut report.cases[0].cells[0];
        (cell.value, cell.verdict) = (f64::INFINITY, Verdict::Fails);
        let page = to_html(&report, &settings, "");
        assert!(page.contains("1 cells fail") && page.contains("What fails"));
        let json = to_json(&report, &settings, "");
        assert_eq!(json["failures"], 1);
        assert_eq!(json["cells"][0]["value"], "inf");
        assert!(summary(&report).contains("FAILS  lambert grid"));
    }
}
