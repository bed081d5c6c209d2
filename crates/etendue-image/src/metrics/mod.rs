//! How far a picture is from its reference, as numbers.

mod flip;
mod rmse;

pub use flip::{DEFAULT_PPD, Flip, hdr_flip, ldr_flip};
pub use rmse::{psnr, rel_mse, rmse};

use crate::{Image, ImageError, Pixels};

/// Refuses pictures that cannot be compared: other sizes, or sample buffers that do not fit them.
fn comparable(a: &Image, b: &Image) -> Result<(), ImageError> {
    let bad = |cause: String| Err(ImageError::Unwritable { format: "comparison", cause });
    if (a.width, a.height) != (b.width, b.height) {
        return bad(format!("{} × {} against {} × {} pixels", a.width, a.height, b.width, b.height));
    }
    for i in [a, b] {
        let have = match &i.pixels {
            Pixels::U8(p) => p.len(),
            Pixels::U16(p) => p.len(),
            Pixels::F32(p) => p.len(),
        };
        if i.is_empty() || have != i.len() || !(1..=4).contains(&i.channels) {
            return bad("a picture without pixels".into());
        }
    }
    Ok(())
}

/// Colour of pixel (`x`, `y`) as the samples stand (integers over their maximum), grey repeated, alpha left out.
fn color(image: &Image, x: u32, y: u32) -> [f32; 3] {
    let c = |i| image.sample(x, y, if image.channels < 3 { 0 } else { i });
    [c(0), c(1), c(2)]
}
