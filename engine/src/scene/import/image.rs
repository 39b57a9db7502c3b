//! Pictures: PNG, JPEG, HDR, BMP and TGA, told by their content where it says so, else by the ending.

use std::io::Cursor;

use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};

use crate::scene::assets::{Picture, Pixels};

const MOST_PIXELS_ACROSS: u32 = 16384;
const MOST_BYTES: u64 = 512 << 20;

/// Decodes a picture. 16-bit values are rounded to 8 bits; HDR stays as it is, linear. `name` is what its
/// file is called (for the ending), or empty. Errors: an unknown or broken format, or a picture larger
/// than 16384 pixels across or 512 MiB.
pub fn decode(bytes: &[u8], name: &str) -> Result<Picture, String> {
    let unread = |error: image::ImageError| format!("cannot be read as a picture: {error}");
    let mut reader = ImageReader::new(Cursor::new(bytes));
    let format = image::guess_format(bytes).ok().or_else(|| ImageFormat::from_path(name).ok());
    reader.set_format(format.ok_or("is no picture of a known format (PNG, JPEG, HDR, BMP, TGA)")?);
    reader.limits(limits());
    let mut decoder = reader.into_decoder().map_err(unread)?;
    let (width, height) = decoder.dimensions();
    let float = matches!(format, Some(ImageFormat::Hdr));
    let bytes = u64::from(width) * u64::from(height) * if float { 12 } else { 4 };
    if width.max(height) > MOST_PIXELS_ACROSS || bytes > MOST_BYTES || decoder.total_bytes() > MOST_BYTES {
        return Err(format!("is {width} x {height} pixels: too large to be read; make it smaller"));
    }
    if width == 0 || height == 0 {
        return Err("has no pixels".to_owned());
    }
    decoder.set_limits(limits()).map_err(unread)?;
    let decoded = DynamicImage::from_decoder(decoder).map_err(unread)?;
    Ok(Picture { width, height, pixels: pixels_of(decoded, float) })
}

fn pixels_of(decoded: DynamicImage, float: bool) -> Pixels {
    if float {
        let values = decoded.into_rgb32f().into_raw();
        Pixels::Rgb32f(values.as_chunks().0.iter().map(|rgb| rgb.map(finite)).collect())
    } else {
        Pixels::Rgba8(decoded.into_rgba8().into_raw().as_chunks().0.to_vec())
    }
}

/// No light is infinite, negative or none.
fn finite(value: f32) -> f32 {
    if value.is_nan() { 0.0 } else { value.clamp(0.0, f32::MAX) }
}

fn limits() -> Limits {
    let mut limits = Limits::default();
    limits.max_image_width = Some(MOST_PIXELS_ACROSS);
    limits.max_image_height = Some(MOST_PIXELS_ACROSS);
    limits.max_alloc = Some(MOST_BYTES);
    limits
}
