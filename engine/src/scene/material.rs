//! Metallic-roughness materials, as glTF 2.0 defines them, and what they do to diffuse light.

use glam::{Vec2, Vec3};
use serde::{Deserialize, Serialize};

use super::Changes;
use super::entity::{is_false, yes};

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct MaterialId(pub u32);

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Material {
    pub id: MaterialId,
    pub name: String,
    #[serde(default)]
    pub albedo: Albedo,
    #[serde(default)]
    pub metallic: f32,
    #[serde(default = "one")]
    pub roughness: f32,
    /// Roughness in green, metallic in blue; multiplies the two factors.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub metallic_roughness_texture: Option<Texture>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub normal_texture: Option<Texture>,
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub normal_scale: f32,
    #[serde(default)]
    pub emission: Emission,
    #[serde(default)]
    pub alpha: Alpha,
    /// 0..1, times the alpha of the albedo texture and of the vertex colour.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub opacity: f32,
    #[serde(default, skip_serializing_if = "is_false")]
    pub double_sided: bool,
    /// Shows its albedo whatever the light; it neither reflects nor emits in the transport.
    #[serde(default, skip_serializing_if = "is_false")]
    pub unlit: bool,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            id: MaterialId(0),
            name: String::new(),
            albedo: Albedo::default(),
            metallic: 0.0,
            roughness: 1.0,
            metallic_roughness_texture: None,
            normal_texture: None,
            normal_scale: 1.0,
            emission: Emission::default(),
            alpha: Alpha::Opaque,
            opacity: 1.0,
            double_sided: false,
            unlit: false,
        }
    }
}

/// The colour that multiplies the albedo texture and the vertex colour.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Albedo {
    pub color: Vec3,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub texture: Option<Texture>,
    #[serde(default)]
    pub changes: Changes,
}

impl Default for Albedo {
    fn default() -> Self {
        Self { color: Vec3::ONE, texture: None, changes: Changes::Anything }
    }
}

/// Light that the surface gives off: radiance = color * strength * texture [W/m2/sr].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Emission {
    pub color: Vec3,
    #[serde(default = "one")]
    pub strength: f32,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub texture: Option<Texture>,
    #[serde(default)]
    pub changes: Changes,
    /// The bake sends rays towards this surface, so that its light is smooth even where it is small. This is
    /// part of the transport: changing it bakes anew, while changing colour or strength does not.
    #[serde(default, skip_serializing_if = "is_false")]
    pub sampled: bool,
}

impl Default for Emission {
    fn default() -> Self {
        Self { color: Vec3::ZERO, strength: 1.0, texture: None, changes: Changes::Anything, sampled: false }
    }
}

impl Emission {
    /// Without the texture [W/m2/sr].
    pub fn radiance(&self) -> Vec3 {
        self.color * self.strength
    }
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Alpha {
    #[default]
    Opaque,
    /// A hole where alpha is below the cutoff.
    Mask { cutoff: f32 },
    /// Light passes with probability 1 - alpha.
    Blend,
}

/// A picture on a surface.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Texture {
    pub image: ImageSource,
    #[serde(default, skip_serializing_if = "is_default")]
    pub wrap_u: Wrap,
    #[serde(default, skip_serializing_if = "is_default")]
    pub wrap_v: Wrap,
    #[serde(default, skip_serializing_if = "is_false")]
    pub nearest: bool,
    #[serde(default = "yes", skip_serializing_if = "super::entity::is_true")]
    pub mipmaps: bool,
    /// Which of the mesh's texture coordinates: 0 or 1.
    #[serde(default, skip_serializing_if = "is_default")]
    pub uv_set: u8,
    /// KHR_texture_transform: uv' = offset + rotate(rotation) * (scale * uv).
    #[serde(default, skip_serializing_if = "is_default")]
    pub offset: Vec2,
    /// Radians, counter-clockwise.
    #[serde(default, skip_serializing_if = "is_default")]
    pub rotation: f32,
    #[serde(default = "one2", skip_serializing_if = "is_one2")]
    pub scale: Vec2,
}

impl Texture {
    pub fn new(image: ImageSource) -> Self {
        Self {
            image,
            wrap_u: Wrap::Repeat,
            wrap_v: Wrap::Repeat,
            nearest: false,
            mipmaps: true,
            uv_set: 0,
            offset: Vec2::ZERO,
            rotation: 0.0,
            scale: Vec2::ONE,
        }
    }

    /// Where in the picture (0..1 across it, v downwards) a mesh's texture coordinate falls, before wrapping.
    pub fn picture_from_uv(&self, uv: Vec2) -> Vec2 {
        let (sin, cos) = self.rotation.sin_cos();
        let scaled = uv * self.scale;
        self.offset + Vec2::new(cos * scaled.x + sin * scaled.y, cos * scaled.y - sin * scaled.x)
    }
}

/// Where a picture is: a file of the project, or the n-th picture inside a glTF file of the project.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ImageSource {
    /// Relative to the project's folder, with forward slashes.
    pub file: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub image: Option<u32>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Wrap {
    #[default]
    Repeat,
    Mirror,
    Clamp,
}

fn one() -> f32 {
    1.0
}

fn one2() -> Vec2 {
    Vec2::ONE
}

fn is_one(value: &f32) -> bool {
    *value == 1.0
}

fn is_one2(value: &Vec2) -> bool {
    *value == Vec2::ONE
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}
