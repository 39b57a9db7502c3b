//! Lights, cameras and the sky: what a node carries besides a mesh. None is invented.

use glam::Vec3;
use gltf::json::extensions::scene::khr_lights_punctual as authored;
use gltf::json::validation::Checked;
use gltf::khr_lights_punctual::Kind;
use gltf::{Document, Node};

use super::Gltf;
use crate::scene::{Camera, Light, LightKind, Projection, Sky, SkyKind};

/// The node's light. Of an unknown kind: none, and a line in `lost`.
pub fn light(gltf: &Gltf, node: &Node, lost: &mut Vec<String>) -> Option<Light> {
    let light = node.light()?;
    let authored: &[authored::Light] = gltf.document.as_json().as_ref();
    if authored[light.index()].type_ == Checked::Invalid {
        lost.push(format!("light {} is of an unknown kind and was left out", light.index()));
        return None;
    }
    Some(Light {
        kind: kind(light.kind()),
        color: Vec3::from(light.color()),
        intensity: light.intensity(),
        range: light.range().filter(|&range| range > 0.0),
        ..Light::default()
    })
}

fn kind(authored: Kind) -> LightKind {
    match authored {
        Kind::Directional => LightKind::Sun,
        Kind::Point => LightKind::Point,
        Kind::Spot { inner_cone_angle, outer_cone_angle } => {
            let outer = outer_cone_angle.clamp(0.0, std::f32::consts::FRAC_PI_2);
            LightKind::Spot { inner: inner_cone_angle.clamp(0.0, outer), outer }
        }
    }
}

/// The node's camera. One that sees nothing: none, and a line in `lost`.
pub fn camera(gltf: &Gltf, node: &Node, lost: &mut Vec<String>) -> Option<Camera> {
    let index = node.camera()?.index();
    let authored = &gltf.document.as_json().cameras[index]; // its type may belie what it holds
    let (projection, near, far) = match (&authored.perspective, &authored.orthographic) {
        (Some(p), _) => (Projection::Perspective { fov_y: p.yfov }, p.znear, p.zfar),
        (_, Some(o)) => (Projection::Orthographic { half_height: o.ymag.abs() }, o.znear, Some(o.zfar)),
        (None, None) => return None,
    };
    let camera = Camera { projection, near, far, ..Camera::default() };
    match camera.validate() {
        Ok(()) => Some(camera),
        Err(message) => {
            lost.push(format!("camera {index} was left out: {message}"));
            None
        }
    }
}

/// Scenes may say in their extras what radiance [W/m2/sr] surrounds them: `"sky_radiance": [r, g, b]`.
pub fn sky(document: &Document, lost: &mut Vec<String>) -> Sky {
    let scene = document.default_scene().or_else(|| document.scenes().next());
    let extras = scene.and_then(|scene| scene.extras().as_ref());
    let extras: Option<serde_json::Value> = extras.and_then(|extras| serde_json::from_str(extras.get()).ok());
    let Some(value) = extras.as_ref().and_then(|extras| extras.get("sky_radiance")) else {
        return Sky::default();
    };
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
