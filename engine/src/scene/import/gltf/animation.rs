//! Animations: which nodes they move, and the key frames of one node.

use std::collections::{HashMap, HashSet};

use gltf::Document;
use gltf::animation::util::ReadOutputs;
use gltf::animation::{Animation, Interpolation as Authored, Property};

use super::accessor::{ROTATIONS, SCALARS, VECTORS, bytes_of, read};
use super::{Gltf, find};
use crate::scene::assets::{Channel, Clip, Interpolation};

/// The first animation that moves each node.
pub fn animation_of_node(document: &Document) -> HashMap<usize, u32> {
    let mut first = HashMap::new();
    for animation in document.animations() {
        for target in animation.channels().map(|channel| channel.target()) {
            if target.property() != Property::MorphTargetWeights {
                first.entry(target.node().index()).or_insert(animation.index() as u32);
            }
        }
    }
    first
}

/// The animated nodes and all that stands below them.
pub fn moving_nodes(document: &Document, animated: impl Iterator<Item = usize>) -> HashSet<usize> {
    let mut moving = HashSet::new();
    let mut stack: Vec<usize> = animated.collect();
    while let Some(node) = stack.pop() {
        if moving.insert(node) {
            let children = document.nodes().nth(node).into_iter().flat_map(|node| node.children());
            stack.extend(children.map(|child| child.index()));
        }
    }
    moving
}

/// Whether an animation changes shapes, which is not shown.
pub fn morphs(document: &Document) -> bool {
    let mut channels = document.animations().flat_map(|animation| animation.channels());
    channels.any(|channel| channel.target().property() == Property::MorphTargetWeights)
}

/// What the n-th animation of the file does to a node.
pub fn clip(gltf: &Gltf, animation: usize, node: usize) -> Result<Clip, String> {
    let authored = find(gltf.document.animations(), animation, "animation")?;
    let named = |message: String| format!("animation {animation}, node {node}: {message}");
    Ok(Clip {
        seconds: seconds(gltf, &authored).map_err(named)?,
        translation: channel(gltf, &authored, (node, Property::Translation), vectors).map_err(named)?,
        rotation: channel(gltf, &authored, (node, Property::Rotation), rotations).map_err(named)?,
        scale: channel(gltf, &authored, (node, Property::Scale), vectors).map_err(named)?,
    })
}

/// The latest key of all channels.
fn seconds(gltf: &Gltf, animation: &Animation) -> Result<f32, String> {
    let mut latest = 0f32;
    for channel in animation.channels() {
        latest = times(gltf, &channel)?.into_iter().fold(latest, f32::max);
    }
    Ok(latest)
}

fn channel<T: From<[f32; N]>, const N: usize>(
    gltf: &Gltf,
    animation: &Animation,
    (node, property): (usize, Property),
    values: impl Fn(&Gltf, &gltf::animation::Channel) -> Result<Vec<[f32; N]>, String>,
) -> Result<Option<Channel<T>>, String> {
    let moves =
        |target: gltf::animation::Target| target.node().index() == node && target.property() == property;
    let Some(channel) = animation.channels().find(|channel| moves(channel.target())) else {
        return Ok(None);
    };
    let interpolation = match channel.sampler().interpolation() {
        Authored::Linear => Interpolation::Linear,
        Authored::Step => Interpolation::Step,
        Authored::CubicSpline => Interpolation::CubicSpline,
    };
    let times = times(gltf, &channel)?;
    let values = values(gltf, &channel)?;
    let wanted = if interpolation == Interpolation::CubicSpline { 3 * times.len() } else { times.len() };
    if values.len() != wanted || !values.as_flattened().iter().all(|value| value.is_finite()) {
        let len = values.len();
        return Err(format!("{len} values of {property:?} where {wanted} finite ones belong"));
    }
    Ok(Some(Channel { times, values: values.into_iter().map(T::from).collect(), interpolation }))
}

fn times(gltf: &Gltf, channel: &gltf::animation::Channel) -> Result<Vec<f32>, String> {
    let reader = channel.reader(bytes_of(gltf));
    let times = read(gltf, &channel.sampler().input(), SCALARS, 0.0, || reader.read_inputs())?;
    let ordered = times.iter().all(|time| time.is_finite()) && times.is_sorted();
    if ordered { Ok(times) } else { Err("the times of its keys are not finite and ascending".to_owned()) }
}

fn vectors(gltf: &Gltf, channel: &gltf::animation::Channel) -> Result<Vec<[f32; 3]>, String> {
    let reader = channel.reader(bytes_of(gltf));
    read(gltf, &channel.sampler().output(), VECTORS, [0.0; 3], || match reader.read_outputs()? {
        ReadOutputs::Translations(vectors) | ReadOutputs::Scales(vectors) => Some(vectors),
        _ => None,
    })
}

fn rotations(gltf: &Gltf, channel: &gltf::animation::Channel) -> Result<Vec<[f32; 4]>, String> {
    let reader = channel.reader(bytes_of(gltf));
    read(gltf, &channel.sampler().output(), ROTATIONS, [0.0; 4], || match reader.read_outputs()? {
        ReadOutputs::Rotations(rotations) => Some(rotations.into_f32()),
        _ => None,
    })
}
