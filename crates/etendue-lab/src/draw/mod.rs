//! Drawings: a list of shapes that can be written as SVG or as pixels, so that both show the same.
//!
//! Coordinates are pixels of the PNG and user units of the SVG, the origin at the upper left.

mod chart;
mod palette;
mod raster;
pub(crate) mod svg;

pub use chart::{Axis, Chart, Series};
pub use palette::{DIVERGING, HEAT, LINES, MAGMA, Rgb, scale};

/// Where a text's given point lies in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// At its left end.
    Start,
    /// In its middle.
    Middle,
    /// At its right end.
    End,
}

/// One shape.
#[derive(Clone, Debug, PartialEq)]
pub enum Item {
    /// A line through points.
    Line {
        /// Its corners.
        points: Vec<[f32; 2]>,
        /// Thickness in pixels.
        width: f32,
        /// Colour.
        color: Rgb,
        /// Lengths of dash and gap in pixels; none for a whole line.
        dash: Option<[f32; 2]>,
    },
    /// A filled polygon.
    Fill {
        /// Its corners.
        points: Vec<[f32; 2]>,
        /// Colour.
        color: Rgb,
        /// 0 invisible to 1 opaque.
        opacity: f32,
    },
    /// A line of text; its given height is the middle of the small letters.
    Text {
        /// Where.
        at: [f32; 2],
        /// What.
        text: String,
        /// True for headings.
        large: bool,
        /// Colour.
        color: Rgb,
        /// How it lies about `at`.
        anchor: Anchor,
        /// Turned a quarter to the left, to be read from below upwards.
        upright: bool,
    },
    /// A picture, scaled without smoothing.
    Picture {
        /// Left and upper edge.
        at: [f32; 2],
        /// Width and height on the drawing.
        size: [f32; 2],
        /// Columns and rows.
        cells: [usize; 2],
        /// Row by row from above; `None` leaves the background.
        pixels: Vec<Option<Rgb>>,
    },
}

/// A drawing on white.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawing {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Shapes, the first undermost.
    pub items: Vec<Item>,
}

/// Text.
pub const INK: Rgb = [0x22, 0x22, 0x22];
/// Lines that only help the eye.
pub const FAINT: Rgb = [0xdd, 0xdd, 0xdd];
/// Axes and secondary text.
pub const GREY: Rgb = [0x66, 0x66, 0x66];

/// Width of a letter of small text.
pub const LETTER: f32 = 8.0;

impl Drawing {
    /// An empty one.
    pub fn new(width: u32, height: u32) -> Self {
        Self { width, height, items: Vec::new() }
    }

    /// A line.
    pub fn line(&mut self, points: Vec<[f32; 2]>, width: f32, color: Rgb) {
        self.items.push(Item::Line { points, width, color, dash: None });
    }

    /// A filled rectangle.
    pub fn rectangle(&mut self, at: [f32; 2], size: [f32; 2], color: Rgb) {
        let [x, y] = at;
        let [w, h] = size;
        let points = vec![[x, y], [x + w, y], [x + w, y + h], [x, y + h]];
        self.items.push(Item::Fill { points, color, opacity: 1.0 });
    }

    /// A circle's line.
    pub fn circle(&mut self, centre: [f32; 2], radius: f32, width: f32, color: Rgb) {
        let points = (0..=96)
            .map(|i| {
                let (s, c) = (i as f32 / 96.0 * core::f32::consts::TAU).sin_cos();
                [centre[0] + radius * c, centre[1] + radius * s]
            })
            .collect();
        self.line(points, width, color);
    }

    /// Small text.
    pub fn text(&mut self, at: [f32; 2], text: impl Into<String>, color: Rgb, anchor: Anchor) {
        self.items.push(Item::Text { at, text: text.into(), large: false, color, anchor, upright: false });
    }

    /// A heading.
    pub fn heading(&mut self, at: [f32; 2], text: impl Into<String>) {
        let text = text.into();
        self.items.push(Item::Text {
            at,
            text,
            large: true,
            color: INK,
            anchor: Anchor::Start,
            upright: false,
        });
    }

    /// Title above, caption below: what every plot says of itself. The caption is broken into lines.
    pub fn frame(&mut self, title: &str, caption: &str) {
        self.heading([16.0, 24.0], title);
        let most = ((self.width as f32 - 32.0) / LETTER) as usize;
        let lines = wrap(caption, most);
        let first = self.height as f32 - 14.0 - 19.0 * (lines.len() as f32 - 1.0);
        for (i, line) in lines.into_iter().enumerate() {
            self.text([16.0, first + 19.0 * i as f32], line, GREY, Anchor::Start);
        }
    }

    /// A bar of colours with its values, upright, from `low` below to `high` above.
    pub fn color_bar(
        &mut self,
        at: [f32; 2],
        height: f32,
        scale_of: &[Rgb],
        labels: [String; 3],
        unit: &str,
    ) {
        let n = 128;
        let pixels = (0..n).map(|i| Some(scale(scale_of, 1.0 - (i as f32 + 0.5) / n as f32))).collect();
        self.items.push(Item::Picture { at, size: [18.0, height], cells: [1, n], pixels });
        let [low, middle, high] = labels;
        for (t, label) in [(1.0, low), (0.5, middle), (0.0, high)] {
            self.text([at[0] + 26.0, at[1] + t * height], label, INK, Anchor::Start);
        }
        let item = Item::Text {
            at: [at[0] - 14.0, at[1] + 0.5 * height],
            text: unit.into(),
            large: false,
            color: GREY,
            anchor: Anchor::Middle,
            upright: true,
        };
        self.items.push(item);
    }

    /// As an SVG document.
    pub fn to_svg(&self) -> String {
        svg::write(self)
    }

    /// As a PNG file, sRGB, eight bits.
    ///
    /// # Errors
    /// What the encoder says, which it only does for a picture without pixels.
    pub fn to_png(&self) -> Result<Vec<u8>, png::EncodingError> {
        let pixels = raster::draw(self);
        encode(self.width, self.height, png::ColorType::Rgb, &pixels)
    }
}

/// A PNG file of sRGB bytes.
fn encode(
    width: u32,
    height: u32,
    kind: png::ColorType,
    bytes: &[u8],
) -> Result<Vec<u8>, png::EncodingError> {
    let mut out = Vec::new();
    let mut encoder = png::Encoder::new(&mut out, width, height);
    encoder.set_color(kind);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(bytes)?;
    writer.finish()?;
    Ok(out)
}

/// Lines of at most `most` letters, broken between words.
fn wrap(text: &str, most: usize) -> Vec<String> {
    let mut lines: Vec<String> = vec![String::new()];
    for word in text.split_whitespace() {
        let line = lines.len() - 1;
        let length = lines[line].chars().count();
        if length > 0 && length + 1 + word.chars().count() > most {
            lines.push(word.into());
        } else {
            if length > 0 {
                lines[line].push(' ');
            }
            lines[line].push_str(word);
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_faces_show_the_same_shapes() {
        let mut d = Drawing::new(60, 40);
        d.rectangle([10.0, 10.0], [20.0, 20.0], [255, 0, 0]);
        d.line(vec![[0.0, 35.0], [59.0, 35.0]], 2.0, [0, 0, 255]);
        d.text([5.0, 5.0], "α < β", INK, Anchor::Start);
        let svg = d.to_svg();
        assert!(svg.contains("α &lt; β") && svg.contains("#ff0000") && svg.contains("#0000ff"));
        let bytes = d.to_png().expect("has pixels");
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().expect("a PNG");
        let mut pixels = vec![0; reader.output_buffer_size().expect("small")];
        reader.next_frame(&mut pixels).expect("a frame");
        let at = |x: usize, y: usize| &pixels[3 * (y * 60 + x)..][..3];
        assert_eq!(at(20, 20), [255, 0, 0]);
        assert_eq!(at(30, 34), [0, 0, 255]);
        assert_eq!(at(55, 20), [255, 255, 255]);
        // The text leaves ink, but only near its place.
        let dark = |y: usize| (0..60).any(|x| at(x, y)[0] < 128);
        assert!((0..10).any(dark) && !dark(38));
    }

    #[test]
    fn captions_break_between_words() {
        assert_eq!(wrap("one two three", 7), ["one two", "three"]);
        assert_eq!(wrap("", 7), [""]);
        assert_eq!(wrap("unbreakable x", 3), ["unbreakable", "x"]);
    }
}
