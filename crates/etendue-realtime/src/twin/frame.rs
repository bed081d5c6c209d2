//! What the twin has drawn, and the pictures that it becomes.

use crate::passes::{Display, Pass, PassSet};
use etendue_image::{ChannelData, Development, Image, Layer, Pixels, develop};

/// R, G, B of the picture and the coverage by surfaces.
pub(super) const BEAUTY: usize = 4;

/// A drawn picture with its passes: means over each pixel's samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// What was recorded beside the picture.
    pub passes: PassSet,
    /// Samples that were NaN or infinite and count as black (a defect that is reported, never hidden).
    pub rejected: u64,
    /// By pixel: picture, coverage, then the passes' channels in their order.
    pub(super) values: Vec<f32>,
}

impl Frame {
    /// Numbers per pixel.
    pub(super) fn stride(passes: PassSet) -> usize {
        BEAUTY + passes.planes()
    }

    /// Number of pixels.
    pub fn pixels(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Linear radiance R, G, B and coverage A of each pixel, top row first. Radiance is premultiplied by coverage where the sky was
    /// left out.
    pub fn beauty(&self) -> impl Iterator<Item = [f32; 4]> + '_ {
        self.values.chunks_exact(Self::stride(self.passes)).map(|p| [p[0], p[1], p[2], p[3]])
    }

    /// The picture: linear Rec.709 floats; four channels with premultiplied alpha if `transparent`, else three.
    pub fn picture(&self, transparent: bool) -> Image {
        let n = if transparent { 4 } else { 3 };
        self.image(n, self.beauty().flat_map(|p| p.into_iter().take(n)).collect())
    }

    /// A recorded pass's channels by pixel; `None` if it was not recorded. The developed picture needs to know how: `development`.
    pub fn pass(&self, pass: Pass, development: &Development) -> Option<Vec<f32>> {
        if !self.passes.has(pass) {
            return None;
        }
        let rgb = || self.beauty().flat_map(|[r, g, b, _]| [r, g, b]);
        match pass {
            Pass::Linear => return Some(rgb().collect()),
            Pass::ToneMapped => {
                let gain = development.exposure_ev.exp2();
                let toned = self.beauty().flat_map(|p| {
                    let toned = development.curve.apply([p[0], p[1], p[2]].map(|v| v * gain));
                    toned.map(|v| v.clamp(0.0, 1.0))
                });
                return Some(toned.collect());
            }
            _ => {}
        }
        let before: usize = self.passes.iter().take_while(|p| *p != pass).map(Pass::planes).sum();
        let (at, n) = (BEAUTY + before, pass.planes());
        let pixels = self.values.chunks_exact(Self::stride(self.passes));
        let share = |p: &[f32]| match pass.is_of_surface() && p[3] > 0.0 {
            true => 1.0 / p[3],
            false => 1.0,
        };
        Some(pixels.flat_map(|p| p[at..at + n].iter().map(move |v| v * share(p))).collect())
    }

    /// The picture (with alpha if `transparent`) and every recorded pass as layers; light and colour as half floats where the file
    /// is written so, geometry and numbers as floats.
    pub fn layers(&self, transparent: bool, development: &Development) -> Vec<Layer> {
        let channel =
            |values: &[f32], n: usize, c: usize| values.iter().skip(c).step_by(n).copied().collect();
        let n = if transparent { 4 } else { 3 };
        let picture: Vec<f32> = self.beauty().flat_map(|p| p.into_iter().take(n)).collect();
        let channels =
            (0..n).map(|c| (["R", "G", "B", "A"][c].into(), ChannelData::Color(channel(&picture, n, c))));
        let mut layers = vec![Layer { name: String::new(), channels: channels.collect() }];
        for pass in self.passes.iter() {
            let Some(values) = self.pass(pass, development) else { continue };
            let names = pass.channels();
            let color = matches!(pass.display(), Display::Light | Display::Color);
            let data = |c| {
                let values = channel(&values, names.len(), c);
                if color { ChannelData::Color(values) } else { ChannelData::F32(values) }
            };
            let channels = names.iter().enumerate().map(|(c, name)| (name.to_string(), data(c))).collect();
            layers.push(Layer { name: pass.name().into(), channels });
        }
        layers
    }

    /// A recorded pass as it is shown on a display (see [`Display`]), and what white stands for where that depends on the picture.
    /// `None` if it was not recorded. Light is developed by `development`; `Linear` without its tone curve.
    pub fn display(&self, pass: Pass, development: &Development) -> Option<(Image, Option<String>)> {
        let values = self.pass(pass, development)?;
        let n = pass.channels().len();
        // The depth of the file; neither exposure nor curve nor encoding.
        let data = Development { linear: true, depth: development.depth, ..Development::default() };
        let encoded = Development { linear: false, ..data };
        let mut note = None;
        let mut by = data;
        let values: Vec<f32> = match pass.display() {
            Display::Light => {
                by = match pass {
                    Pass::Linear => Development { curve: Default::default(), ..*development },
                    _ => *development,
                };
                values
            }
            Display::Color => {
                by = encoded;
                values
            }
            Display::Share => values,
            // Where there is no surface there is no direction either.
            Display::Vector => {
                let there = |v: &[f32]| v.iter().any(|x| *x != 0.0);
                values
                    .chunks_exact(n)
                    .flat_map(|v| v.iter().map(move |x| if there(v) { x * 0.5 + 0.5 } else { 0.0 }))
                    .collect()
            }
            Display::Fraction => values.iter().map(|v| v - v.floor()).collect(),
            Display::Range => {
                let largest = values.iter().copied().fold(0.0, f32::max);
                note = Some(format!("{largest}"));
                values.iter().map(|v| if largest > 0.0 { v / largest } else { 0.0 }).collect()
            }
            Display::Position => {
                let covered: Vec<bool> = self.beauty().map(|p| p[3] > 0.0).collect();
                let mut bounds = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
                for (p, _) in values.chunks_exact(n).zip(&covered).filter(|(_, c)| **c) {
                    for c in 0..3 {
                        bounds[0][c] = bounds[0][c].min(p[c]);
                        bounds[1][c] = bounds[1][c].max(p[c]);
                    }
                }
                note = covered.contains(&true).then(|| format!("{:?} to {:?}", bounds[0], bounds[1]));
                let place = |c: usize, v: f32| (v - bounds[0][c]) / (bounds[1][c] - bounds[0][c]).max(1e-30);
                let shown = values.chunks_exact(n).zip(&covered).flat_map(|(p, there)| {
                    (0..n).map(move |c| if *there { place(c, p[c]) } else { 0.0 }).collect::<Vec<_>>()
                });
                shown.collect()
            }
        };
        Some((develop(&self.picture_of(n, values), &by), note))
    }

    /// A recorded pass as a float picture of three channels, or one: for files of light. `None` if it was not recorded.
    pub fn pass_picture(&self, pass: Pass, development: &Development) -> Option<Image> {
        let values = self.pass(pass, development)?;
        Some(self.picture_of(pass.channels().len(), values))
    }

    /// Two channels would be grey and alpha: they get an empty third.
    fn picture_of(&self, channels: usize, values: Vec<f32>) -> Image {
        match channels {
            2 => self.image(3, values.chunks_exact(2).flat_map(|v| [v[0], v[1], 0.0]).collect()),
            n => self.image(n, values),
        }
    }

    fn image(&self, channels: usize, values: Vec<f32>) -> Image {
        Image {
            width: self.width,
            height: self.height,
            channels: channels as u8,
            pixels: Pixels::F32(values),
        }
    }
}
