//! The punctual lights that shine now, as shaders read them.

use bytemuck::{Pod, Zeroable};
use glam::{DAffine3, DVec3, Vec3};

use crate::scene::{EntityId, LightKind, Scene};

/// `Light` in `scene/light.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct GpuLight {
    pub position: Vec3,
    pub kind: u32,
    pub direction: Vec3,
    pub range: f32,
    pub power: Vec3,
    pub layer: i32,
    pub cone: [f32; 2],
    pub first_view: u32,
    pub texel: f32,
}

/// A light at its place; relative to the transport's origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlacedLight {
    pub entity: EntityId,
    pub kind: LightKind,
    pub position: Vec3,
    /// Along which it shines, unit.
    pub direction: Vec3,
    pub power: Vec3,
    pub range: Option<f32>,
    pub cone: (f32, f32),
    pub casts_shadows: bool,
}

impl PlacedLight {
    pub fn shines(&self) -> bool {
        self.power.is_finite() && self.power.max_element() > 0.0
    }

    /// Without a shadow map yet.
    pub fn on_gpu(&self) -> GpuLight {
        GpuLight {
            position: self.position,
            kind: match self.kind {
                LightKind::Sun => 0,
                LightKind::Point => 1,
                LightKind::Spot { .. } => 2,
            },
            direction: self.direction,
            range: self.range.unwrap_or(0.0),
            power: self.power.max(Vec3::ZERO),
            layer: -1,
            cone: [self.cone.0, self.cone.1],
            first_view: 0,
            texel: 0.0,
        }
    }
}

/// All lights of the scene that are not hidden, dark ones too: which shadow map is whose does not change when
/// a light is switched.
pub fn placed(
    scene: &Scene,
    world_from_local: &[DAffine3],
    hidden: &[bool],
    origin: DVec3,
) -> Vec<PlacedLight> {
    let mut lights = Vec::new();
    for ((entity, world), hidden) in scene.entities.iter().zip(world_from_local).zip(hidden) {
        let Some(light) = entity.light.as_ref().filter(|_| !hidden) else { continue };
        lights.push(PlacedLight {
            entity: entity.id,
            kind: light.kind,
            position: (world.translation - origin).as_vec3(),
            direction: (-world.matrix3.z_axis).normalize_or(DVec3::NEG_Y).as_vec3(),
            power: light.power(),
            range: light.range,
            cone: light.cone(),
            casts_shadows: light.casts_shadows,
        });
    }
    lights
}
