//! Animations: which nodes they move, and the key frames of one node.

use std::collections::{HashMap, HashSet};

use glam::{Vec3, Vec4};

use super::Gltf;
use super::accessor::floats;
use super::json::{Animation, Root, get};
use crate::scene::assets::{Channel, Clip, Interpolation};

/// The first animation that moves each node.
pub fn animation_of_node(root: &Root) -> HashMap<usize, u32> {
    let mut first = HashMap::new();
    for (n, animation) in root.animations.iter().enumerate() {
        for target in animation.channels.iter().map(|channel| &channel.target) {
            if let Some(node) = target.node.filter(|_| is_movement(&target.path)) {
                first.entry(node).or_insert(n as u32);
            }
        }
    }
    first
}

/// The animated nodes and all that stands below them.
pub fn moving_nodes(root: &Root, animated: impl Iterator<Item = usize>) -> HashSet<usize> {
    let mut moving = HashSet::new();
    let mut stack: Vec<usize> = animated.collect();
    while let Some(node) = stack.pop() {
        if moving.insert(node) {
            stack.extend(root.nodes.get(node).iter().flat_map(|node| &node.children));
        }
    }
    moving
}

/// Whether an animation changes shapes, which is not shown.
pub fn morphs(root: &Root) -> bool {
    root.animations
        .iter()
        .flat_map(|animation| &animation.channels)
        .any(|channel| channel.target.path == "weights")
}

fn is_movement(path: &str) -> bool {
    matches!(path, "translation" | "rotation" | "scale")
}

/// What the n-th animation of the file does to a node.
pub fn clip(gltf: &Gltf, animation: usize, node: usize) -> Result<Clip, String> {
    let authored = get(&gltf.root.animations, animation, "animation")?;
    let named = |message: String| format!("animation {animation}, node {node}: {message}");
    Ok(Clip {
        seconds: seconds(gltf, authored).map_err(named)?,
        translation: channel(gltf, authored, node, "translation", (3, vec3)).map_err(named)?,
        rotation: channel(gltf, authored, node, "rotation", (4, vec4)).map_err(named)?,
        scale: channel(gltf, authored, node, "scale", (3, vec3)).map_err(named)?,
    })
}

/// The latest key of all channels.
fn seconds(gltf: &Gltf, animation: &Animation) -> Result<f32, String> {
    let mut latest = 0f32;
    for channel in &animation.channels {
        let sampler = get(&animation.samplers, channel.sampler, "sampler")?;
        latest = times(gltf, sampler.input)?.into_iter().fold(latest, f32::max);
    }
    Ok(latest)
}

fn channel<T>(
    gltf: &Gltf,
    animation: &Animation,
    node: usize,
    path: &str,
    make: (usize, impl Fn(&[f32]) -> T),
) -> Result<Option<Channel<T>>, String> {
    let of_node = |target: &super::json::Target| target.node == Some(node) && target.path == path;
    let Some(channel) = animation.channels.iter().find(|channel| of_node(&channel.target)) else {
        return Ok(None);
    };
    let sampler = get(&animation.samplers, channel.sampler, "sampler")?;
    let interpolation = match sampler.interpolation.as_deref() {
        Some("STEP") => Interpolation::Step,
        Some("CUBICSPLINE") => Interpolation::CubicSpline,
        _ => Interpolation::Linear,
    };
    let times = times(gltf, sampler.input)?;
    let rows = floats(gltf, sampler.output, &[make.0])?;
    let wanted = if interpolation == Interpolation::CubicSpline { 3 * times.len() } else { times.len() };
    if rows.len() != wanted || rows.values.iter().any(|value| !value.is_finite()) {
        return Err(format!("{} values of {path} where {wanted} finite ones belong", rows.len()));
    }
    let values = rows.values.chunks_exact(rows.width).map(make.1).collect();
    Ok(Some(Channel { times, values, interpolation }))
}

fn times(gltf: &Gltf, accessor: usize) -> Result<Vec<f32>, String> {
    let times = floats(gltf, accessor, &[1])?.values;
    let ordered = times.iter().all(|time| time.is_finite()) && times.is_sorted();
    if ordered { Ok(times) } else { Err("the times of its keys are not finite and ascending".to_owned()) }
}

fn vec3(row: &[f32]) -> Vec3 {
    Vec3::from_slice(row)
}

fn vec4(row: &[f32]) -> Vec4 {
    Vec4::from_slice(row)
}
