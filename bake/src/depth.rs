//! How far light probes see that have a wall between themselves and a neighbour: one ray for each node of their map
//! ([`engine::transport::depths`]).

use engine::transport::depths::{NODES, direction};
use engine::transport::probe_field::ProbeField;
use engine::transport::{Depths, Transport};
use glam::Vec3;
use rayon::prelude::*;

use crate::rays::Tracer;

/// Where the share of a ray that a half-transparent surface lets through is to be one or the other.
const CHANCE: f32 = 0.5;
/// A probe is at least this far from what it sees, in sizes of the scene.
const LEAST: f32 = 1e-6;

/// `unit`: metres in a unit of the rays' space.
pub fn depths(tracer: &Tracer, transport: &Transport, unit: f64) -> Depths {
    let probes = &tracer.scene.probes;
    let blocked = |[a, b]: [u32; 2]| {
        let [a, b] = [a, b].map(|probe| probes[probe as usize]);
        !tracer.bvh.free_between([a, Vec3::ZERO], [b, Vec3::ZERO], CHANCE, tracer.holes)
    };
    let edges = ProbeField::new(transport).edges();
    let mut beside: Vec<u32> =
        edges.iter().map(|edge| edge.probes).filter(|&pair| blocked(pair)).flatten().collect();
    beside.sort_unstable();
    beside.dedup();
    let nearness = |probe: &u32| -> Vec<f32> {
        let position = probes[*probe as usize];
        (0..NODES).map(|node| (nearness(tracer, position, direction(node)) / unit) as f32).collect()
    };
    Depths { nearness: beside.par_iter().flat_map_iter(nearness).collect(), probes: beside }
}

/// 1 / |hit - position|_1 in the rays' space.
fn nearness(tracer: &Tracer, position: Vec3, direction: Vec3) -> f64 {
    let hit = tracer.bvh.closest(position, Vec3::ZERO, direction.normalize(), CHANCE, tracer.holes);
    hit.map_or(0.0, |hit| {
        let [a, b, c] = tracer.scene.triangles[hit.triangle as usize];
        let [v, w] = hit.barycentric;
        let way = a + (b - a) * v + (c - a) * w - position;
        1.0 / f64::from(way.abs().element_sum().max(LEAST))
    })
}
