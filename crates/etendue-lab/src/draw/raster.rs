//! A drawing as pixels.
//!
//! Lines are distance fields with a pixel's soft edge, areas are sampled sixteen times per pixel, letters come from a font
//! rasterised beforehand: no system fonts, and the same picture on every machine.

use super::{Anchor, Drawing, Item, Rgb};
use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster};

struct Canvas {
    width: usize,
    height: usize,
    rgb: Vec<f32>,
    /// How much of a pixel the shape at hand covers.
    cover: Vec<f32>,
}

/// RGB bytes row by row.
pub(super) fn draw(d: &Drawing) -> Vec<u8> {
    let (width, height) = (d.width as usize, d.height as usize);
    let n = width * height;
    let mut c = Canvas { width, height, rgb: vec![255.0; 3 * n], cover: vec![0.0; n] };
    for item in &d.items {
        match item {
            Item::Line { points, width, color, dash } => {
                for part in dashes(points, *dash) {
                    for s in part.windows(2) {
                        c.segment(s[0], s[1], 0.5 * width);
                    }
                    c.blend(&part, *width + 1.0, *color, 1.0);
                }
            }
            Item::Fill { points, color, opacity } => {
                c.polygon(points);
                c.blend(points, 1.0, *color, *opacity);
            }
            Item::Text { at, text, large, color, anchor, upright } => {
                c.text(*at, text, *large, *color, *anchor, *upright);
            }
            Item::Picture { at, size, cells, pixels } => c.picture(*at, *size, *cells, pixels),
        }
    }
    c.rgb.iter().map(|v| v.round() as u8).collect()
}

/// A line cut into its dashes.
fn dashes(points: &[[f32; 2]], dash: Option<[f32; 2]>) -> Vec<Vec<[f32; 2]>> {
    let Some([on, off]) = dash.filter(|d| d[0] > 0.0 && d[1] > 0.0) else { return vec![points.to_vec()] };
    let mut out = Vec::new();
    let mut part: Vec<[f32; 2]> = points.first().copied().into_iter().collect();
    let (mut drawing, mut left) = (true, on);
    for s in points.windows(2) {
        let [a, b] = [s[0], s[1]];
        let length = (b[0] - a[0]).hypot(b[1] - a[1]);
        let mut done = 0.0;
        while length - done > left {
            done += left;
            let t = done / length;
            let p = [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])];
            if drawing {
                part.push(p);
                out.push(core::mem::take(&mut part));
            } else {
                part = vec![p];
            }
            drawing = !drawing;
            left = if drawing { on } else { off };
        }
        left -= length - done;
        if drawing {
            part.push(b);
        }
    }
    if part.len() > 1 {
        out.push(part);
    }
    out
}

impl Canvas {
    /// Pixels that the box of `points`, grown by `by`, touches.
    fn bounds(&self, points: &[[f32; 2]], by: f32) -> [usize; 4] {
        let range = |k: usize, most: usize| {
            let low = points.iter().map(|p| p[k]).fold(f32::INFINITY, f32::min) - by;
            let high = points.iter().map(|p| p[k]).fold(f32::NEG_INFINITY, f32::max) + by;
            // Casts saturate: what lies outside, and NaN, becomes an edge.
            [(low.floor() as usize).min(most), (high.ceil() as usize).min(most)]
        };
        let ([x0, x1], [y0, y1]) = (range(0, self.width), range(1, self.height));
        [x0, x1, y0, y1]
    }

    /// Covers a segment of half thickness `radius`.
    fn segment(&mut self, a: [f32; 2], b: [f32; 2], radius: f32) {
        if !(a.iter().chain(&b).all(|v| v.is_finite())) {
            return;
        }
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        let length2 = (dx * dx + dy * dy).max(1e-12);
        let [x0, x1, y0, y1] = self.bounds(&[a, b], radius + 1.0);
        for y in y0..y1 {
            for x in x0..x1 {
                let (px, py) = (x as f32 + 0.5 - a[0], y as f32 + 0.5 - a[1]);
                let t = ((px * dx + py * dy) / length2).clamp(0.0, 1.0);
                let distance = (px - t * dx).hypot(py - t * dy);
                let cover = (radius + 0.5 - distance).clamp(0.0, 1.0).min(2.0 * radius);
                let here = &mut self.cover[y * self.width + x];
                *here = here.max(cover);
            }
        }
    }

    /// Covers the inside of a polygon (even-odd).
    fn polygon(&mut self, points: &[[f32; 2]]) {
        let [_, _, y0, y1] = self.bounds(points, 1.0);
        for y in y0..y1 {
            for sub in 0..4 {
                let level = y as f32 + (sub as f32 + 0.5) / 4.0;
                let mut crossings: Vec<f32> = (0..points.len())
                    .filter_map(|i| {
                        let (a, b) = (points[i], points[(i + 1) % points.len()]);
                        ((a[1] <= level) != (b[1] <= level))
                            .then(|| a[0] + (level - a[1]) / (b[1] - a[1]) * (b[0] - a[0]))
                    })
                    .collect();
                crossings.sort_by(f32::total_cmp);
                for pair in crossings.chunks_exact(2) {
                    let (from, to) = (pair[0].max(0.0), pair[1].min(self.width as f32));
                    for x in from.floor() as usize..(to.ceil().max(0.0) as usize).min(self.width) {
                        let part = (to.min(x as f32 + 1.0) - from.max(x as f32)).clamp(0.0, 1.0);
                        self.cover[y * self.width + x] += 0.25 * part;
                    }
                }
            }
        }
    }

    /// Lays the covered pixels over the picture and clears the cover.
    fn blend(&mut self, points: &[[f32; 2]], by: f32, color: Rgb, opacity: f32) {
        let [x0, x1, y0, y1] = self.bounds(points, by + 1.0);
        for y in y0..y1 {
            for x in x0..x1 {
                let i = y * self.width + x;
                let a = core::mem::take(&mut self.cover[i]).min(1.0) * opacity;
                self.over(i, color, a);
            }
        }
    }

    fn over(&mut self, i: usize, color: Rgb, a: f32) {
        for k in 0..3 {
            let v = &mut self.rgb[3 * i + k];
            *v += (color[k] as f32 - *v) * a;
        }
    }

    fn text(&mut self, at: [f32; 2], text: &str, large: bool, color: Rgb, anchor: Anchor, upright: bool) {
        let (weight, height) = if large {
            (FontWeight::Bold, RasterHeight::Size20)
        } else {
            (FontWeight::Regular, RasterHeight::Size16)
        };
        let glyphs: Vec<_> = spell(text)
            .chars()
            .filter_map(|c| get_raster(c, weight, height).or_else(|| get_raster('?', weight, height)))
            .collect();
        let total: usize = glyphs.iter().map(|g| g.width()).sum();
        let back = match anchor {
            Anchor::Start => 0.0,
            Anchor::Middle => 0.5 * total as f32,
            Anchor::End => total as f32,
        };
        let mut along = -back;
        for g in &glyphs {
            for (row, line) in g.rows().enumerate() {
                for (column, &cover) in line.iter().enumerate() {
                    let u = along + column as f32;
                    let v = row as f32 - 0.5 * g.height() as f32;
                    let (x, y) = if upright { (at[0] + v, at[1] - u) } else { (at[0] + u, at[1] + v) };
                    let (x, y) = (x.round(), y.round());
                    if cover > 0
                        && x >= 0.0
                        && y >= 0.0
                        && (x as usize) < self.width
                        && (y as usize) < self.height
                    {
                        self.over(y as usize * self.width + x as usize, color, cover as f32 / 255.0);
                    }
                }
            }
            along += g.width() as f32;
        }
    }

    fn picture(&mut self, at: [f32; 2], size: [f32; 2], cells: [usize; 2], pixels: &[Option<Rgb>]) {
        let [x0, x1, y0, y1] = self.bounds(&[at, [at[0] + size[0], at[1] + size[1]]], 0.0);
        for y in y0..y1 {
            for x in x0..x1 {
                let u = (x as f32 + 0.5 - at[0]) / size[0];
                let v = (y as f32 + 0.5 - at[1]) / size[1];
                if !((0.0..1.0).contains(&u) && (0.0..1.0).contains(&v)) {
                    continue;
                }
                let i = (v * cells[1] as f32) as usize * cells[0] + (u * cells[0] as f32) as usize;
                if let Some(Some(color)) = pixels.get(i) {
                    self.over(y * self.width + x, *color, 1.0);
                }
            }
        }
    }
}

/// Letters that the font does not have, in letters that it has.
fn spell(text: &str) -> String {
    let mut out = String::new();
    for c in text.chars() {
        match c {
            'α' => out += "alpha",
            'β' => out += "beta",
            'θ' => out += "theta",
            'φ' => out += "phi",
            'χ' => out += "chi",
            'σ' => out += "sigma",
            'η' => out += "eta",
            'Λ' => out += "Lambda",
            'π' => out += "pi",
            'ω' => out += "w",
            '−' | '–' => out.push('-'),
            '≤' => out += "<=",
            '≥' => out += ">=",
            '→' => out += "->",
            '∫' => out += "int ",
            '√' => out += "sqrt ",
            '₀' => out.push('0'),
            '⁰'..='⁹' => out.push('^'),
            '’' => out.push('\''),
            c => out.push(c),
        }
    }
    out
}
