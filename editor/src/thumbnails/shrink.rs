//! A picture made small: each pixel is the mean of a few of those that it stands for.

use eframe::egui::ColorImage;
use engine::scene::assets::{Picture, Pixels};
use glam::Vec3;

use super::SIDE;

/// Of a pixel's side.
const SAMPLES: u32 = 4;

/// At most [`SIDE`] pixels across; the larger side has all of them.
pub fn shrunk(picture: &Picture) -> ColorImage {
    let longest = picture.width.max(picture.height).max(1);
    let side = |length: u32| (length * SIDE.min(longest) / longest).max(1);
    let [width, height] = [side(picture.width), side(picture.height)];
    let mut bytes = Vec::with_capacity((width * height * 4) as usize);
    for y in 0..height {
        for x in 0..width {
            bytes.extend(mean(picture, [x, y], [width, height]));
        }
    }
    ColorImage::from_rgba_unmultiplied([width as usize, height as usize], &bytes)
}

fn mean(picture: &Picture, at: [u32; 2], of: [u32; 2]) -> [u8; 4] {
    let mut sum = [0.0; 4];
    for sample in 0..SAMPLES * SAMPLES {
        let off = [sample % SAMPLES, sample / SAMPLES];
        let along = |axis: usize, length: u32| {
            (u64::from(at[axis] * SAMPLES + off[axis]) * u64::from(length) / u64::from(of[axis] * SAMPLES))
                as u32
        };
        let texel = texel(picture, along(0, picture.width), along(1, picture.height));
        sum.iter_mut().zip(texel).for_each(|(sum, part)| *sum += part);
    }
    sum.map(|sum| (sum / (SAMPLES * SAMPLES) as f32 * 255.0).round().clamp(0.0, 255.0) as u8)
}

/// For a display: what is brighter than it can show goes to white by x / (1 + x).
fn texel(picture: &Picture, x: u32, y: u32) -> [f32; 4] {
    let at = y as usize * picture.width as usize + x as usize;
    match &picture.pixels {
        Pixels::Rgba8(pixels) => pixels[at].map(|part| f32::from(part) / 255.0),
        Pixels::Rgb32f(pixels) => {
            let color = Vec3::from(pixels[at]);
            let shown = color / (Vec3::ONE + color);
            shown.map(|part| part.max(0.0).powf(1.0 / 2.2)).extend(1.0).to_array()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_picture_stays_and_a_large_one_becomes_its_mean() {
        let pixels = (0..512 * 256).map(|at| if at % 2 == 0 { [200, 0, 0, 255] } else { [0, 100, 0, 255] });
        let large = Picture { width: 512, height: 256, pixels: Pixels::Rgba8(pixels.collect()) };
        let small = shrunk(&large);
        assert_eq!(small.size, [128, 64]);
        assert!(
            small.pixels.iter().all(|pixel| pixel.to_array() == [100, 50, 0, 255]),
            "{:?}",
            small.pixels[0]
        );
        let two =
            Picture { width: 2, height: 1, pixels: Pixels::Rgba8(vec![[9, 8, 7, 255], [1, 2, 3, 255]]) };
        let same = shrunk(&two);
        assert_eq!((same.size, same.pixels[1].to_array()), ([2, 1], [1, 2, 3, 255]));
    }
}
