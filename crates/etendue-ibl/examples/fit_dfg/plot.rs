//! The frontier as a picture.

use std::fmt::Write;

/// A formula on the plot; those with a label are in the library.
pub struct Point {
    pub label: Option<&'static str>,
    pub operations: usize,
    pub score: f64,
}

const WIDTH: f64 = 720.0;
const HEIGHT: f64 = 440.0;
const MOST: f64 = 46.0;

/// Cost against error, the error logarithmic, as an SVG picture.
pub fn svg(points: &[Point]) -> String {
    let x = |ops: usize| 70.0 + (WIDTH - 100.0) * ops as f64 / MOST;
    let (high, low) = (60.0f64.log10(), 0.4f64.log10());
    let y = |e: f64| 40.0 + (HEIGHT - 90.0) * (high - e.log10()) / (high - low);
    let mut s = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" font-family=\"sans-serif\" font-size=\"12\">\n\
         <rect width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"white\"/>\n\
         <text x=\"70\" y=\"20\">error in units of the target (worst 0.01, RMS 0.003, at F0 = 0.04 and 1; whichever is most), logarithmic</text>\n"
    );
    for e in [0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0] {
        let dash = if e == 1.0 { "" } else { " stroke-dasharray=\"2 4\"" };
        let _ = writeln!(
            s,
            "<line x1=\"70\" x2=\"{}\" y1=\"{2:.1}\" y2=\"{2:.1}\" stroke=\"#999\"{dash}/><text x=\"62\" y=\"{3:.1}\" text-anchor=\"end\">{1}</text>",
            WIDTH - 30.0,
            e,
            y(e),
            y(e) + 4.0
        );
    }
    for ops in (0..=45).step_by(5) {
        let _ = writeln!(
            s,
            "<text x=\"{:.1}\" y=\"{}\" text-anchor=\"middle\">{ops}</text>",
            x(ops),
            HEIGHT - 32.0
        );
    }
    // Twice Karis' arithmetic.
    let _ = writeln!(
        s,
        "<line x1=\"{0:.1}\" x2=\"{0:.1}\" y1=\"40\" y2=\"{1}\" stroke=\"#999\" stroke-dasharray=\"2 4\"/>\n\
         <text x=\"{2}\" y=\"{3}\" text-anchor=\"middle\">operations (dashed: twice Karis')</text>",
        x(22),
        HEIGHT - 50.0,
        WIDTH / 2.0,
        HEIGHT - 10.0
    );
    let mut line: Vec<&Point> = points.iter().filter(|p| p.label.is_none()).collect();
    line.sort_by_key(|p| p.operations);
    let path: Vec<String> =
        line.iter().map(|p| format!("{:.1},{:.1}", x(p.operations), y(p.score))).collect();
    let _ = writeln!(s, "<polyline points=\"{}\" fill=\"none\" stroke=\"#06c\"/>", path.join(" "));
    for p in points {
        let (cx, cy) = (x(p.operations), y(p.score));
        let colour = if p.label.is_some() { "#c00" } else { "#06c" };
        let r = if p.label.is_some() { 5.0 } else { 3.0 };
        let _ = writeln!(s, "<circle cx=\"{cx:.1}\" cy=\"{cy:.1}\" r=\"{r}\" fill=\"{colour}\"/>");
        if let Some(label) = p.label {
            let _ = writeln!(
                s,
                "<text x=\"{:.1}\" y=\"{:.1}\" fill=\"{colour}\">{label}</text>",
                cx + 8.0,
                cy + 4.0
            );
        }
    }
    s + "</svg>\n"
}
