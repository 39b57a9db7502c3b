//! The punctual lights that shine now, as shaders read them.

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3};

use super::frame::Now;
use super::instances::Instances;
use crate::scene::LightKind;
use crate::transport::direct::{PlacedLight, placed_lights};

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

/// In place of a layer: it casts shadows, but there is no map for it.
pub const UNMAPPED: i32 = -2;

/// Without a shadow map yet.
pub fn on_gpu(placed: &PlacedLight) -> GpuLight {
    let light = &placed.light;
    let (scale, offset) = light.cone();
    GpuLight {
        position: placed.position,
        kind: match light.kind {
            LightKind::Sun => 0,
            LightKind::Point => 1,
            LightKind::Spot { .. } => 2,
        },
        direction: placed.direction,
        range: light.range.unwrap_or(0.0),
        power: light.power().max(Vec3::ZERO),
        layer: -1,
        cone: [scale, offset],
        first_view: 0,
        texel: 0.0,
    }
}

/// Whether nothing bounds how far it shines: suns, and what has no range.
pub fn is_everywhere(placed: &PlacedLight) -> bool {
    placed.light.kind == LightKind::Sun || placed.light.range.is_none()
}

pub fn shines(placed: &PlacedLight) -> bool {
    let power = placed.light.power();
    power.is_finite() && power.max_element() > 0.0
}

/// At a distance of 1 m [W/m2]; 0 where none shines.
pub fn brightest(placed: &[PlacedLight]) -> f32 {
    let shining = placed.iter().filter(|light| shines(light));
    shining.map(|light| light.light.power().max_element()).fold(0.0, f32::max)
}

/// All lights that are not hidden, dark ones too: which shadow map is whose does not change when a light is
/// switched.
pub fn placed(now: &Now<'_>, instances: &Instances, origin: DVec3) -> Vec<PlacedLight> {
    let mut lights = placed_lights(now.scene, now.world_from_local, origin);
    lights.retain(|light| !instances.is_hidden(light.entity));
    lights
}
