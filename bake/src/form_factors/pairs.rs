//! All pairs of flat patches that see each other, and whether anything may stand between them.
//!
//! Two trees of patches are walked against each other with a list of what could be in the way, which only ever gets
//! shorter (Teller and Hanrahan 1993). Where nothing is left on it, all pairs below are free; where two patches
//! could not exchange as much as asks for attention, the walk ends.

use glam::DVec3;
use rayon::prelude::*;

use super::facet::{Facet, exchange};
use super::shaft::{Box3, BoxShaft, Shaft};
use crate::{BakeError, Watcher};

/// Two patches, the first with the lower number, and A_i F_ij if nothing is between.
#[derive(Clone, Copy, Debug)]
pub struct Pair {
    pub patches: [u32; 2],
    pub exchange: f64,
    /// Surely nothing is.
    pub is_free: bool,
}

/// What the walk reads.
pub struct Sights<'a> {
    pub facets: &'a [Facet],
    /// Patches that may be in the way: one for each piece of surface.
    pub things: Vec<u32>,
    /// What is nearer to a surface than this does not hide it.
    pub slack: f64,
    /// By patch, what an exchange is multiplied by, summed over both, for how many rays it is worth.
    pub density: Vec<f64>,
    /// Pairs worth fewer rays are left out.
    pub least: f64,
}

/// In a fixed order, each handed to `each`, which may leave it out.
pub fn pairs<T: Send>(
    sights: &Sights,
    watcher: &dyn Watcher,
    each: impl Fn(Pair) -> Option<T> + Sync,
) -> Result<Vec<T>, BakeError> {
    let patches = (0..sights.facets.len() as u32).filter(|&i| sights.facets[i as usize].flat.is_some());
    let tree = Tree::new(sights, patches.collect());
    let found: Result<Vec<Vec<T>>, BakeError> = tree
        .tasks(sights)
        .into_par_iter()
        .map(|task| {
            let mut found = Vec::new();
            tree.walk(sights, task, &mut |pair| {
                found.extend(each(pair));
                !watcher.cancelled()
            });
            if watcher.cancelled() { Err(BakeError::Cancelled) } else { Ok(found) }
        })
        .collect();
    Ok(found?.into_iter().flatten().collect())
}

struct Node {
    bounds: Box3,
    density: f64,
    area: f64,
    patches: std::ops::Range<usize>,
    halves: Option<[usize; 2]>,
}

struct Tree {
    nodes: Vec<Node>,
    order: Vec<u32>,
}

/// Two nodes and what could be between them.
struct Task {
    nodes: [usize; 2],
    things: Vec<u32>,
}

/// Enough for any number of threads.
const TASKS: usize = 512;

impl Tree {
    fn new(sights: &Sights, order: Vec<u32>) -> Self {
        let mut tree = Self { nodes: Vec::new(), order };
        if !tree.order.is_empty() {
            tree.divide(sights, 0..tree.order.len());
        }
        tree
    }

    /// The node of a range of patches, halved across its longest side.
    fn divide(&mut self, sights: &Sights, range: std::ops::Range<usize>) -> usize {
        let facet = |i: u32| &sights.facets[i as usize];
        let patches = &mut self.order[range.clone()];
        let bounds = patches.iter().map(|&i| Box3::of(facet(i))).reduce(Box3::union);
        let bounds = bounds.unwrap_or(Box3 { low: DVec3::ZERO, high: DVec3::ZERO });
        let axis = (bounds.high - bounds.low).max_position();
        let most = |of: &dyn Fn(u32) -> f64| patches.iter().map(|&i| of(i)).fold(0.0, f64::max);
        let density = most(&|i| sights.density[i as usize]);
        let area = most(&|i| facet(i).flat.as_ref().map_or(0.0, |flat| flat.area()));
        let node = self.nodes.len();
        self.nodes.push(Node { bounds, density, area, patches: range.clone(), halves: None });
        if range.len() > 1 {
            let middle = |i: u32| facet(i).low[axis] + facet(i).high[axis];
            patches.sort_by(|&a, &b| middle(a).total_cmp(&middle(b)).then(a.cmp(&b)));
            let half = range.start + range.len() / 2;
            let first = self.divide(sights, range.start..half);
            let second = self.divide(sights, half..range.end);
            self.nodes[node].halves = Some([first, second]);
        }
        node
    }

    fn tasks(&self, sights: &Sights) -> Vec<Task> {
        let mut tasks = Vec::new();
        if !self.nodes.is_empty() {
            tasks.push(Task { nodes: [0, 0], things: sights.things.clone() });
        }
        while tasks.len() < TASKS {
            let before = tasks.len();
            let parts = |task: Task| match self.parts(task.nodes) {
                parts if parts.is_empty() => vec![task],
                parts => {
                    parts.into_iter().filter_map(|nodes| self.task(sights, nodes, &task.things)).collect()
                }
            };
            tasks = tasks.into_iter().flat_map(parts).collect();
            if tasks.len() <= before {
                break;
            }
        }
        tasks
    }

    /// The next pairs of nodes below; none under a pair of single patches.
    fn parts(&self, [a, b]: [usize; 2]) -> Vec<[usize; 2]> {
        let extent = |node: usize| (self.nodes[node].bounds.high - self.nodes[node].bounds.low).length();
        match (self.nodes[a].halves, self.nodes[b].halves) {
            (Some([p, q]), _) if a == b => vec![[p, p], [p, q], [q, q]],
            (Some(halves), other) if other.is_none() || extent(a) >= extent(b) => {
                halves.map(|p| [p, b]).to_vec()
            }
            (_, Some(halves)) => halves.map(|p| [a, p]).to_vec(),
            _ => Vec::new(),
        }
    }

    /// `None` where no pair below is worth it.
    fn task(&self, sights: &Sights, nodes: [usize; 2], things: &[u32]) -> Option<Task> {
        let [a, b] = nodes.map(|node| &self.nodes[node]);
        let distance = a.bounds.distance(&b.bounds);
        let most = a.area * b.area / (std::f64::consts::PI * distance * distance);
        if nodes[0] != nodes[1] && most * (a.density + b.density) < sights.least {
            return None;
        }
        if things.is_empty() {
            return Some(Task { nodes, things: Vec::new() });
        }
        let shaft = BoxShaft::new(a.bounds, b.bounds, sights.slack);
        let is_between = |&thing: &u32| !shaft.is_beside(&sights.facets[thing as usize]);
        Some(Task { nodes, things: things.iter().copied().filter(is_between).collect() })
    }

    /// All pairs below, until `each` says no.
    fn walk(&self, sights: &Sights, task: Task, each: &mut impl FnMut(Pair) -> bool) -> bool {
        let [a, b] = task.nodes.map(|node| &self.nodes[node]);
        // Where some may not be worth it, only a few at once.
        let is_small = sights.least == 0.0 || a.patches.len() * b.patches.len() <= 64;
        if task.nodes[0] != task.nodes[1] && task.things.is_empty() && is_small {
            let pairs = a
                .patches
                .clone()
                .flat_map(|k| b.patches.clone().map(move |l| [self.order[k], self.order[l]]));
            return pairs.into_iter().all(|pair| pair_of(sights, pair, &[]).is_none_or(&mut *each));
        }
        let parts = self.parts(task.nodes);
        if parts.is_empty() && task.nodes[0] != task.nodes[1] {
            let pair = [a, b].map(|node| self.order[node.patches.start]);
            return pair_of(sights, pair, &task.things).is_none_or(each);
        }
        let below = parts.into_iter().filter_map(|nodes| self.task(sights, nodes, &task.things));
        for task in below {
            if !self.walk(sights, task, each) {
                return false;
            }
        }
        true
    }
}

fn pair_of(sights: &Sights, [i, j]: [u32; 2], things: &[u32]) -> Option<Pair> {
    let patches = [i.min(j), i.max(j)];
    let facets = patches.map(|i| &sights.facets[i as usize]);
    let exchange = exchange(facets[0], facets[1], sights.slack);
    let density: f64 = patches.iter().map(|&i| sights.density[i as usize]).sum();
    if exchange <= 0.0 || exchange * density < sights.least {
        return None;
    }
    let flats = [facets[0].flat.as_ref()?, facets[1].flat.as_ref()?];
    let mut shaft = Shaft::new(facets, flats, sights.slack);
    let is_free = things.iter().all(|&thing| shaft.is_beside(&sights.facets[thing as usize]));
    Some(Pair { patches, exchange, is_free })
}
