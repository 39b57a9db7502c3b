//! Lights, cameras and the sky: what a node carries besides a mesh. None is invented.

use glam::Vec3;

use super::Gltf;
use super::json::{self, Node, Root, extension, get};
use crate::scene::{Camera, Light, LightKind, Projection, Sky, SkyKind};

const LIGHTS: &str = "KHR_lights_punctual";

/// The node's light. Of an unknown kind: none, and a line in `lost`.
pub fn light(gltf: &Gltf, node: &Node, lost: &mut Vec<String>) -> Result<Option<Light>, String> {
    let Some(json::LightOfNode { light }) = extension(&node.extensions, LIGHTS)? else { return Ok(None) };
    let lights: json::Lights = extension(&gltf.root.extensions, LIGHTS)?.unwrap_or_default();
    let authored = get(&lights.lights, light, "light")?;
    let Some(kind) = kind(authored) else {
        lost.push(format!("light {light} is of the unknown kind `{}` and was left out", authored.r#type));
        return Ok(None);
    };
    Ok(Some(Light {
        kind,
        color: authored.color.map_or(Vec3::ONE, Vec3::from),
        intensity: authored.intensity.unwrap_or(1.0),
        range: authored.range.filter(|&range| range > 0.0),
        ..Light::default()
    }))
}

fn kind(authored: &json::Light) -> Option<LightKind> {
    match authored.r#type.as_str() {
        "directional" => Some(LightKind::Sun),
        "point" => Some(LightKind::Point),
        "spot" => {
            let outer = authored.spot.outer_cone_angle.unwrap_or(std::f32::consts::FRAC_PI_4);
            let outer = outer.clamp(0.0, std::f32::consts::FRAC_PI_2);
            let inner = authored.spot.inner_cone_angle.unwrap_or(0.0).clamp(0.0, outer);
            Some(LightKind::Spot { inner, outer })
        }
        _ => None,
    }
}

/// The node's camera. One that sees nothing: none, and a line in `lost`.
pub fn camera(gltf: &Gltf, node: &Node, lost: &mut Vec<String>) -> Result<Option<Camera>, String> {
    let Some(index) = node.camera else { return Ok(None) };
    let authored = get(&gltf.root.cameras, index, "camera")?;
    let (projection, near, far) = match (&authored.perspective, &authored.orthographic) {
        (Some(p), _) => (Projection::Perspective { fov_y: p.yfov }, p.znear, p.zfar),
        (_, Some(o)) => (Projection::Orthographic { half_height: o.ymag.abs() }, o.znear, Some(o.zfar)),
        (None, None) => (Projection::Perspective { fov_y: 0.0 }, 0.0, None),
    };
    let camera = Camera { projection, near, far, exposure: 0.0 };
    match camera.validate() {
        Ok(()) => Ok(Some(camera)),
        Err(message) => {
            lost.push(format!("camera {index} was left out: {message}"));
            Ok(None)
        }
    }
}

/// Scenes may say in their extras what radiance [W/m2/sr] surrounds them: `"sky_radiance": [r, g, b]`.
pub fn sky(root: &Root, lost: &mut Vec<String>) -> Sky {
    let scene = root.scenes.get(root.scene.unwrap_or(0));
    let Some(value) = scene.and_then(|scene| scene.extras.get("sky_radiance")) else { return Sky::default() };
    let radiance = <[f32; 3] as serde::Deserialize>::deserialize(value).map(Vec3::from).unwrap_or(Vec3::NAN);
    if !radiance.is_finite() || radiance.min_element() < 0.0 {
        lost.push(
            "extras.sky_radiance is not three finite numbers of which none is negative: no sky".to_owned(),
        );
    } else if radiance != Vec3::ZERO {
        return Sky { kind: SkyKind::Constant { radiance }, ..Sky::default() };
    }
    Sky::default()
}
