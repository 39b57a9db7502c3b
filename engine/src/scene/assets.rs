//! What a scene's entities refer to, read once: meshes, pictures, animation clips.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{Vec2, Vec3, Vec4};

use super::material::Wrap;
use super::{ImageSource, Mesh, MeshSource, Texture};

/// Meshes, pictures and clips by the name under which a scene knows them.
#[derive(Clone, Debug, Default)]
pub struct Assets {
    pub meshes: HashMap<MeshSource, Arc<Mesh>>,
    pub images: HashMap<ImageSource, Arc<Picture>>,
    pub clips: HashMap<ClipSource, Arc<Clip>>,
}

/// Pixels in rows from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    pub width: u32,
    pub height: u32,
    pub pixels: Pixels,
}

#[derive(Clone, Debug, PartialEq)]
pub enum Pixels {
    /// As stored: sRGB for colours, linear for everything else, whatever the reader takes it for.
    Rgba8(Vec<[u8; 4]>),
    /// Linear.
    Rgb32f(Vec<[f32; 3]>),
}

/// Animation `animation` of `file`, the part that moves `node`.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct ClipSource {
    pub file: String,
    pub animation: u32,
    pub node: u32,
}

/// Key frames of one node; a channel that is absent leaves the authored value.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Clip {
    /// Of the whole animation, seconds.
    pub seconds: f32,
    pub translation: Option<Channel<Vec3>>,
    /// Quaternions xyzw.
    pub rotation: Option<Channel<Vec4>>,
    pub scale: Option<Channel<Vec3>>,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Channel<T> {
    pub times: Vec<f32>,
    /// One a time; cubic splines: in-tangent, value, out-tangent a time.
    pub values: Vec<T>,
    pub interpolation: Interpolation,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    Step,
    Linear,
    CubicSpline,
}

impl Picture {
    /// The texel at x, y (inside the picture) as stored, 0..1 for 8 bits.
    pub fn texel(&self, x: u32, y: u32) -> Vec4 {
        let at = y as usize * self.width as usize + x as usize;
        match &self.pixels {
            Pixels::Rgba8(pixels) => Vec4::from(pixels[at].map(f32::from)) / 255.0,
            Pixels::Rgb32f(pixels) => Vec3::from(pixels[at]).extend(1.0),
        }
    }

    /// The texel at x, y with colours made linear (sRGB decoded where it has 8 bits).
    pub fn linear_texel(&self, x: u32, y: u32) -> Vec4 {
        let texel = self.texel(x, y);
        match self.pixels {
            Pixels::Rgba8(_) => Vec4::new(linear(texel.x), linear(texel.y), linear(texel.z), texel.w),
            Pixels::Rgb32f(_) => texel,
        }
    }

    /// Bilinear, at texture coordinates before the texture's transform and wrapping; colours linear.
    pub fn sample_color(&self, texture: &Texture, uv: Vec2) -> Vec4 {
        self.sample(texture, uv, Self::linear_texel)
    }

    /// Bilinear, values as stored: roughness, metallic, normals, alpha.
    pub fn sample_data(&self, texture: &Texture, uv: Vec2) -> Vec4 {
        self.sample(texture, uv, Self::texel)
    }

    fn sample(&self, texture: &Texture, uv: Vec2, texel: impl Fn(&Self, u32, u32) -> Vec4) -> Vec4 {
        let uv = texture.picture_from_uv(uv);
        if !uv.is_finite() || self.width == 0 || self.height == 0 {
            return Vec4::ONE;
        }
        let size = Vec2::new(self.width as f32, self.height as f32);
        let wrapped = |x: f32, y: f32| {
            texel(self, wrap(x, self.width, texture.wrap_u), wrap(y, self.height, texture.wrap_v))
        };
        if texture.nearest {
            let at = (uv * size).floor();
            return wrapped(at.x, at.y);
        }
        let at = uv * size - 0.5;
        let low = at.floor();
        let t = at - low;
        let row = |y: f32| wrapped(low.x, y).lerp(wrapped(low.x + 1.0, y), t.x);
        row(low.y).lerp(row(low.y + 1.0), t.y)
    }
}

/// The texel that a whole coordinate falls on.
fn wrap(x: f32, size: u32, wrap: Wrap) -> u32 {
    let size = i64::from(size);
    let x = x as i64;
    let x = match wrap {
        Wrap::Repeat => x.rem_euclid(size),
        Wrap::Clamp => x.clamp(0, size - 1),
        Wrap::Mirror => {
            let x = x.rem_euclid(2 * size);
            if x < size { x } else { 2 * size - 1 - x }
        }
    };
    x as u32
}

/// sRGB decoded (IEC 61966-2-1).
pub fn linear(encoded: f32) -> f32 {
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}
