//! Lines over two axes.

use super::{Anchor, Drawing, FAINT, GREY, INK, Item, LETTER, LINES, Rgb};

/// One axis: what it says and what it spans.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Quantity and unit.
    pub label: String,
    /// Least and largest value.
    pub range: [f64; 2],
    /// True for logarithmic division; the range must then be above zero.
    pub log: bool,
}

impl Axis {
    /// A linear axis.
    pub fn linear(label: &str, low: f64, high: f64) -> Self {
        Self { label: label.into(), range: [low, if high > low { high } else { low + 1.0 }], log: false }
    }

    /// A logarithmic axis.
    pub fn log(label: &str, low: f64, high: f64) -> Self {
        let low = low.max(1e-300);
        Self { label: label.into(), range: [low, if high > low { high } else { 10.0 * low }], log: true }
    }

    /// Place of a value, 0..1 within the range.
    fn place(&self, v: f64) -> f64 {
        let [a, b] = self.range;
        if self.log { (v.max(1e-300) / a).ln() / (b / a).ln() } else { (v - a) / (b - a) }
    }

    /// Round values within the range: linear at 1, 2 or 5 times a power of ten, logarithmic at powers of ten.
    fn ticks(&self, most: usize) -> Vec<f64> {
        let [a, b] = self.range;
        if self.log {
            let (low, high) = (a.log10().ceil() as i32, b.log10().floor() as i32);
            let every = ((high - low) as usize / most.max(1) + 1) as i32;
            return (low..=high).filter(|p| p.rem_euclid(every) == 0).map(|p| 10f64.powi(p)).collect();
        }
        let rough = (b - a) / most.max(1) as f64;
        let power = 10f64.powf(rough.log10().floor());
        let step =
            [1.0, 2.0, 5.0, 10.0].into_iter().map(|s| s * power).find(|s| *s >= rough).unwrap_or(rough);
        // Degrees are best cut into thirties.
        let step = if b - a == 90.0 || b - a == 180.0 { (b - a) / 6.0 } else { step };
        let first = (a / step - 1e-9).ceil() as i64;
        (first..).map(|i| i as f64 * step).take_while(|v| *v <= b + 1e-9 * step).collect()
    }
}

/// A tick's text: as short as it can be.
fn number(v: f64) -> String {
    let a = v.abs();
    if a == 0.0 {
        return "0".into();
    }
    if !(1e-3..1e5).contains(&a) {
        return format!("{v:.0e}");
    }
    let text = format!("{v:.4}");
    text.trim_end_matches('0').trim_end_matches('.').into()
}

/// A line of a chart.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// What the legend calls it.
    pub name: String,
    /// x and y; values that are not finite interrupt the line.
    pub points: Vec<[f64; 2]>,
    /// Its colour.
    pub color: Rgb,
    /// True for a dashed line.
    pub dashed: bool,
    /// True to draw symbols instead of a line.
    pub dots: bool,
}

impl Series {
    /// A whole line in the `index`-th colour.
    pub fn new(name: impl Into<String>, index: usize, points: Vec<[f64; 2]>) -> Self {
        Self { name: name.into(), points, color: LINES[index % LINES.len()], dashed: false, dots: false }
    }

    /// The same, dashed.
    pub fn dashed(self) -> Self {
        Self { dashed: true, ..self }
    }

    /// The same as dots.
    pub fn dots(self) -> Self {
        Self { dots: true, ..self }
    }
}

/// Lines over two axes, with a legend above.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// What it shows.
    pub title: String,
    /// Across.
    pub x: Axis,
    /// Up.
    pub y: Axis,
    /// Its lines.
    pub series: Vec<Series>,
}

impl Chart {
    /// The largest y of all series, for an axis; 0 if there is none.
    pub fn top(series: &[Series]) -> f64 {
        series.iter().flat_map(|s| &s.points).map(|p| p[1]).filter(|v| v.is_finite()).fold(0.0, f64::max)
    }

    /// Draws it into the rectangle that begins at `at` and is `size` wide and high, labels included.
    pub fn draw(&self, d: &mut Drawing, at: [f32; 2], size: [f32; 2]) {
        let legend_rows = self.legend_rows(size[0] - 80.0);
        let top = at[1] + 26.0 + 20.0 * legend_rows.len() as f32 + 8.0;
        let (left, right, bottom) = (at[0] + 76.0, at[0] + size[0] - 16.0, at[1] + size[1] - 52.0);
        let x = |v: f64| left + self.x.place(v) as f32 * (right - left);
        let y = |v: f64| bottom - self.y.place(v) as f32 * (bottom - top);

        d.text([left, at[1] + 10.0], self.title.clone(), INK, Anchor::Start);
        for v in self.x.ticks(((right - left) / 64.0) as usize) {
            d.line(vec![[x(v), top], [x(v), bottom]], 1.0, FAINT);
            d.text([x(v), bottom + 13.0], number(v), INK, Anchor::Middle);
        }
        for v in self.y.ticks(((bottom - top) / 36.0) as usize) {
            d.line(vec![[left, y(v)], [right, y(v)]], 1.0, FAINT);
            d.text([left - 7.0, y(v)], number(v), INK, Anchor::End);
        }
        d.line(vec![[left, top], [left, bottom], [right, bottom]], 1.0, GREY);
        d.text([0.5 * (left + right), bottom + 34.0], self.x.label.clone(), GREY, Anchor::Middle);
        d.items.push(Item::Text {
            at: [at[0] + 12.0, 0.5 * (top + bottom)],
            text: self.y.label.clone(),
            large: false,
            color: GREY,
            anchor: Anchor::Middle,
            upright: true,
        });
        for s in &self.series {
            self.draw_series(d, s, &x, &y, [top, bottom]);
        }
        for (row, names) in legend_rows.iter().enumerate() {
            let mut across = left;
            let height = at[1] + 32.0 + 20.0 * row as f32;
            for &i in names {
                let s = &self.series[i];
                self.symbol(d, s, [across, height]);
                d.text([across + 32.0, height], s.name.clone(), INK, Anchor::Start);
                across += 32.0 + LETTER * (s.name.chars().count() as f32 + 3.0);
            }
        }
    }

    /// Which series stand in which row of the legend.
    fn legend_rows(&self, width: f32) -> Vec<Vec<usize>> {
        let mut rows: Vec<Vec<usize>> = Vec::new();
        let mut used = f32::INFINITY;
        for (i, s) in self.series.iter().enumerate().filter(|(_, s)| !s.name.is_empty()) {
            let need = 32.0 + LETTER * (s.name.chars().count() as f32 + 3.0);
            if used + need > width {
                rows.push(Vec::new());
                used = 0.0;
            }
            used += need;
            if let Some(row) = rows.last_mut() {
                row.push(i);
            }
        }
        rows
    }

    fn symbol(&self, d: &mut Drawing, s: &Series, at: [f32; 2]) {
        if s.dots {
            dot(d, [at[0] + 13.0, at[1]], s.color);
        } else {
            let points = vec![at, [at[0] + 26.0, at[1]]];
            d.items.push(Item::Line {
                points,
                width: 2.0,
                color: s.color,
                dash: s.dashed.then_some([6.0, 4.0]),
            });
        }
    }

    fn draw_series(
        &self,
        d: &mut Drawing,
        s: &Series,
        x: &dyn Fn(f64) -> f32,
        y: &dyn Fn(f64) -> f32,
        [top, bottom]: [f32; 2],
    ) {
        let inside = |p: &[f64; 2]| p[0] >= self.x.range[0] - 1e-9 && p[0] <= self.x.range[1] + 1e-9;
        if s.dots {
            for p in s.points.iter().filter(|p| p[1].is_finite() && inside(p)) {
                let at = [x(p[0]), y(p[1])];
                if (top..=bottom).contains(&at[1]) {
                    dot(d, at, s.color);
                }
            }
            return;
        }
        let mut run: Vec<[f32; 2]> = Vec::new();
        let mut flush = |run: &mut Vec<[f32; 2]>| {
            if run.len() > 1 {
                let dash = s.dashed.then_some([6.0, 4.0]);
                let points = core::mem::take(run);
                d.items.push(Item::Line { points, width: 2.0, color: s.color, dash });
            }
            run.clear();
        };
        for p in &s.points {
            if p[1].is_finite() && inside(p) {
                // A line that leaves the frame runs along its edge.
                run.push([x(p[0]), y(p[1]).clamp(top, bottom)]);
            } else {
                flush(&mut run);
            }
        }
        flush(&mut run);
    }
}

fn dot(d: &mut Drawing, [x, y]: [f32; 2], color: Rgb) {
    let r = 2.2;
    let points = (0..12)
        .map(|i| {
            let (s, c) = (i as f32 / 12.0 * core::f32::consts::TAU).sin_cos();
            [x + r * c, y + r * s]
        })
        .collect();
    d.items.push(Item::Fill { points, color, opacity: 1.0 });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_within() {
        assert_eq!(Axis::linear("", 0.0, 1.0).ticks(5), [0.0, 0.2, 0.4, 0.6000000000000001, 0.8, 1.0]);
        assert_eq!(Axis::linear("", 0.0, 90.0).ticks(5), [0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 90.0]);
        assert_eq!(Axis::log("", 0.05, 200.0).ticks(9), [0.1, 1.0, 10.0, 100.0]);
        assert_eq!([0.6000000000000001, 1e-5, 250000.0, 0.0].map(number), ["0.6", "1e-5", "2e5", "0"]);
    }
}
