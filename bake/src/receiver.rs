//! Receivers: the points at which irradiance is known. One for each vertex and smoothing group of the refined
//! mesh; where a mesh is finer than the receivers' spacing, its vertices share the receivers of their own
//! surface, near along it.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};

use engine::transport::Batch;
use engine::transport::Transport;
use engine::transport::surface::Blend;
use glam::{DVec3, Vec3};

use crate::patch::Links;
use crate::pipeline::INSIDE;
use crate::rays::Hits;
use crate::split::{Fine, FineTriangle, Side};

/// A receiver's place, in scaled space.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    pub position: DVec3,
    pub normal: Vec3,
    /// Names it whatever else is in the scene: seeds its rays.
    pub key: u64,
}

pub struct Receivers {
    pub places: Vec<Place>,
    /// By triangle and corner: the node (vertex and smoothing group) there.
    pub node_of: Vec<[u32; 3]>,
    /// By node: which receivers it blends; front side.
    pub blends: Vec<Blend>,
    /// By node, for the back side; empty where nothing is double-sided.
    pub back_blends: Vec<Blend>,
}

/// A vertex of one smoothing group: triangles around it that meet without an edge or a cut.
struct Node {
    position: DVec3,
    normal: Vec3,
    /// Of the triangles around, the middle.
    middle: DVec3,
    size: f64,
    double_sided: bool,
    entity: u64,
}

/// `length`: the spacing where the density is 1.
pub fn receivers(fine: &Fine, links: &Links, batches: &[Batch], length: f64) -> Receivers {
    let (node_of, nodes) = nodes(fine, links, batches, length);
    let ways = ways(fine, links, &nodes, &node_of);
    let chosen = choose(&nodes, &ways);
    let places: Vec<Place> = chosen.iter().map(|&node| place(&nodes[node as usize], false)).collect();
    let blends = blend(&nodes, &ways, &chosen);
    let mut receivers = Receivers { places, node_of, blends, back_blends: Vec::new() };
    add_backs(&nodes, &chosen, &mut receivers);
    receivers
}

fn place(node: &Node, back: bool) -> Place {
    // Off the outline and off the cuts, into its own surface; never behind it, which a tangent to a hollow is.
    let inward = (node.middle - node.position) * 0.01;
    let normal = node.normal.as_dvec3();
    let position = node.position + inward - normal * inward.dot(normal).min(0.0);
    let words = position.as_vec3().to_array().map(|x| u64::from(x.to_bits()));
    let key = crate::directions::hash_of([node.entity, words[0], words[1], words[2], u64::from(back)]);
    Place { position, normal: if back { -node.normal } else { node.normal }, key }
}

fn nodes(fine: &Fine, links: &Links, batches: &[Batch], length: f64) -> (Vec<[u32; 3]>, Vec<Node>) {
    let mut sets = Sets::new(fine.triangles.len() * 3);
    for (t, beyond) in links.beyond.iter().enumerate() {
        for (k, &other) in beyond.iter().enumerate() {
            if other == u32::MAX || !links.smooth[t][k] {
                continue;
            }
            let other = other as usize;
            let Some(side) = (0..3)
                .find(|&side| links.beyond[other][side] == t as u32 && same_side(fine, t, k, other, side))
            else {
                continue;
            };
            sets.join(t * 3 + k, other * 3 + (side + 1) % 3);
            sets.join(t * 3 + (k + 1) % 3, other * 3 + side);
        }
    }
    let mut id_of: HashMap<usize, u32> = HashMap::new();
    let mut sums: Vec<(Node, f64)> = Vec::new();
    let mut node_of = vec![[0; 3]; fine.triangles.len()];
    for (t, triangle) in fine.triangles.iter().enumerate() {
        let corners = triangle.corners.map(|corner| fine.corners[corner as usize]);
        let [a, b, c] = corners.map(|corner| corner.position);
        let area = (b - a).cross(c - a).length() * 0.5;
        let batch = &batches[triangle.batch as usize];
        for k in 0..3 {
            let root = sets.root(t * 3 + k);
            let id = *id_of.entry(root).or_insert_with(|| {
                let corner = &corners[k];
                let size = length / f64::from(corner.density).max(1e-3);
                sums.push((
                    Node {
                        position: corner.position,
                        normal: Vec3::ZERO,
                        middle: DVec3::ZERO,
                        size,
                        double_sided: false,
                        entity: batch.entity().0,
                    },
                    0.0,
                ));
                sums.len() as u32 - 1
            });
            let (node, weight) = &mut sums[id as usize];
            node.normal += corners[k].normal * area as f32;
            node.middle += (a + b + c) / 3.0 * area;
            node.double_sided |= batch.double_sided != 0;
            node.size = node.size.min(width_beside_a_gap(triangle, [a, b, c]));
            *weight += area;
            node_of[t][k] = id;
        }
    }
    let finished = sums.into_iter().map(|(mut node, area)| {
        node.middle /= area;
        node.normal = node.normal.normalize_or(Vec3::Y);
        node
    });
    (node_of, finished.collect())
}

/// Where patches end beside a gap, light changes over its width, a strip of triangles: their height on the longest side.
fn width_beside_a_gap(triangle: &FineTriangle, [a, b, c]: [DVec3; 3]) -> f64 {
    if !triangle.sides.contains(&Side::Smooth) {
        return f64::INFINITY;
    }
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    (b - a).cross(c - a).length() / longest
}

/// Two triangles may share two sides; this is the one.
fn same_side(fine: &Fine, t: usize, k: usize, other: usize, side: usize) -> bool {
    let at = |t: usize, k: usize| fine.corners[fine.triangles[t].corners[k % 3] as usize].position.as_vec3();
    at(t, k) == at(other, side + 1) && at(t, k + 1) == at(other, side)
}

/// By node: its neighbours and how far they are.
type Ways = Vec<Vec<(u32, f64)>>;

/// Along the sides of triangles, and across edges that are hardly bent.
fn ways(fine: &Fine, links: &Links, nodes: &[Node], node_of: &[[u32; 3]]) -> Ways {
    let mut ways: Ways = vec![Vec::new(); nodes.len()];
    let mut join = |a: u32, b: u32| {
        let [from, to] = [&nodes[a as usize], &nodes[b as usize]];
        if a != b && from.normal.dot(to.normal) > 0.9 {
            let way = from.position.distance(to.position);
            ways[a as usize].push((b, way));
            ways[b as usize].push((a, way));
        }
    };
    for t in 0..fine.triangles.len() {
        for k in 0..3 {
            join(node_of[t][k], node_of[t][(k + 1) % 3]);
            let other = links.beyond[t][k];
            if other != u32::MAX && !links.smooth[t][k] && other > t as u32 {
                let other = other as usize;
                let Some(side) = (0..3).find(|&side| same_side(fine, t, k, other, side)) else { continue };
                join(node_of[t][k], node_of[other][(side + 1) % 3]);
                join(node_of[t][(k + 1) % 3], node_of[other][side]);
            }
        }
    }
    for way in &mut ways {
        way.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        way.dedup_by_key(|way| way.0);
    }
    ways
}

/// How near to a receiver a node must be to do without one of its own, in spacings.
const COVERED: f64 = 0.35;

/// Nodes that become receivers: each that no earlier one covers.
fn choose(nodes: &[Node], ways: &Ways) -> Vec<u32> {
    let mut covered = vec![false; nodes.len()];
    let mut chosen = Vec::new();
    for node in 0..nodes.len() as u32 {
        if covered[node as usize] {
            continue;
        }
        chosen.push(node);
        for (near, _) in within(ways, node, COVERED * nodes[node as usize].size, nodes) {
            covered[near as usize] = true;
        }
    }
    chosen
}

/// Nodes within a distance along the surface, whose normals are alike, nearest first.
fn within(ways: &Ways, start: u32, reach: f64, nodes: &[Node]) -> Vec<(u32, f64)> {
    let mut found: Vec<(u32, f64)> = Vec::new();
    let mut queue = BinaryHeap::from([Reverse((ordered(0.0), start))]);
    let mut seen: HashMap<u32, ()> = HashMap::new();
    while let Some(Reverse((bits, node))) = queue.pop() {
        if seen.insert(node, ()).is_some() {
            continue;
        }
        let distance = f64::from_bits(bits);
        found.push((node, distance));
        for &(next, way) in &ways[node as usize] {
            let far = distance + way;
            if far <= reach && nodes[start as usize].normal.dot(nodes[next as usize].normal) > 0.85 {
                queue.push(Reverse((ordered(far), next)));
            }
        }
    }
    found
}

/// Distances >= 0 in an order that integers have.
fn ordered(distance: f64) -> u64 {
    distance.to_bits()
}

fn blend(nodes: &[Node], ways: &Ways, chosen: &[u32]) -> Vec<Blend> {
    let mut near: Vec<Vec<(u32, f64)>> = vec![Vec::new(); nodes.len()];
    for (receiver, &node) in chosen.iter().enumerate() {
        let size = nodes[node as usize].size;
        // Wide enough that what lies between receivers blends several of them.
        for (other, distance) in within(ways, node, 2.5 * COVERED * size, nodes) {
            near[other as usize].push((receiver as u32, distance / (2.5 * COVERED * size)));
        }
    }
    near.into_iter()
        .map(|mut near| {
            near.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
            if near.first().is_some_and(|first| first.1 == 0.0) {
                return Blend::one(near[0].0);
            }
            let mut blend = Blend::default();
            for (slot, &(receiver, distance)) in near.iter().take(4).enumerate() {
                blend.receivers[slot] = receiver;
                blend.weights[slot] = ((1.0 - distance).max(0.0).powi(2) + 1e-4) as f32;
            }
            let sum: f32 = blend.weights.iter().sum();
            blend.weights = blend.weights.map(|weight| weight / sum);
            blend
        })
        .collect()
}

/// The same points again, looking the other way, where a surface has two sides.
fn add_backs(nodes: &[Node], chosen: &[u32], receivers: &mut Receivers) {
    if !nodes.iter().any(|node| node.double_sided) {
        return;
    }
    let mut back_of = HashMap::new();
    for (receiver, &node) in chosen.iter().enumerate() {
        if nodes[node as usize].double_sided {
            back_of.insert(receiver as u32, receivers.places.len() as u32);
            receivers.places.push(place(&nodes[node as usize], true));
        }
    }
    let turned = receivers.blends.iter().map(|blend| {
        let mut blend = *blend;
        for receiver in &mut blend.receivers {
            *receiver = back_of.get(receiver).copied().unwrap_or(*receiver);
        }
        blend
    });
    receivers.back_blends = turned.collect();
}

/// Disjoint sets with path halving.
struct Sets {
    parent: Vec<u32>,
}

impl Sets {
    fn new(n: usize) -> Self {
        Self { parent: (0..n as u32).collect() }
    }

    fn root(&mut self, mut at: usize) -> usize {
        while self.parent[at] as usize != at {
            self.parent[at] = self.parent[self.parent[at] as usize];
            at = self.parent[at] as usize;
        }
        at
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.parent[a.max(b)] = a.min(b) as u32;
    }
}

/// By receiver: is it outside of all solids?
pub fn valid(hits: &Hits, rays: u32) -> Vec<bool> {
    hits.lost.iter().map(|&lost| f64::from(lost) <= INSIDE * f64::from(rays)).collect()
}

/// Receivers inside a solid light nothing: vertices that blend them take their neighbours' receivers instead.
pub fn mark_receivers(transport: &mut Transport, valid: &[bool]) {
    for (receiver, &valid) in transport.receivers.iter_mut().zip(valid) {
        receiver.valid = f32::from(u8::from(valid));
    }
    let triangles = &transport.surface.triangles;
    let positions: Vec<Vec3> = transport.surface.vertices.iter().map(|vertex| vertex.position).collect();
    for blends in [&mut transport.surface.blends, &mut transport.surface.back_blends] {
        let mut lit: Vec<bool> = blends.iter_mut().map(|blend| keep_valid(blend, valid)).collect();
        for _ in 0..3 {
            spread(blends, &mut lit, triangles, &positions);
        }
    }
}

/// Drops invalid receivers from a blend; false where none is left.
fn keep_valid(blend: &mut Blend, valid: &[bool]) -> bool {
    let mut kept = *blend;
    for slot in 0..4 {
        if kept.weights[slot] > 0.0 && !valid[kept.receivers[slot] as usize] {
            (kept.receivers[slot], kept.weights[slot]) = (0, 0.0);
        }
    }
    let sum: f32 = kept.weights.iter().sum();
    if sum > 0.0 {
        kept.weights = kept.weights.map(|weight| weight / sum);
        *blend = kept;
    }
    sum > 0.0
}

/// A vertex without light takes that of the nearest lit vertex of its triangles.
fn spread(blends: &mut [Blend], lit: &mut [bool], triangles: &[[u32; 3]], positions: &[Vec3]) {
    if blends.is_empty() {
        return;
    }
    let mut found: std::collections::BTreeMap<u32, (f32, u32)> = std::collections::BTreeMap::new();
    for triangle in triangles {
        for &to in triangle.iter().filter(|&&to| !lit[to as usize]) {
            for &from in triangle.iter().filter(|&&from| lit[from as usize]) {
                let way = (positions[from as usize].distance(positions[to as usize]), from);
                let best = found.entry(to).or_insert(way);
                if way < *best {
                    *best = way;
                }
            }
        }
    }
    for (to, (_, from)) in found {
        blends[to as usize] = blends[from as usize];
        lit[to as usize] = true;
    }
}
