//! The tree that rows are cut through, and the best cut of one row.

use std::collections::BTreeMap;

use engine::transport::tree::Node;
use engine::transport::{NONE, Patch, Rows, Tree};
use glam::Vec3;

/// Every node that a cut may name.
///
/// Binary, in preorder with single patches as leaves: below a node of k patches lie 2k - 2 others, its left half next to
/// it. A forest of as many trees as there are groups that must not be merged.
pub struct Forest {
    pub(super) order: Vec<u32>,
    pub(super) nodes: Vec<Node>,
    /// By node [m2].
    pub(super) areas: Vec<f64>,
    roots: Vec<u32>,
    /// By patch: where in the order it is; [`NONE`] for those that stay single.
    position: Vec<u32>,
}

impl Forest {
    /// `single`: by patch, whether it is an entry of its own in every row.
    pub fn new(patches: &[Patch], single: &[bool]) -> Self {
        let mut groups: BTreeMap<[u32; 3], Vec<u32>> = BTreeMap::new();
        for (i, patch) in patches.iter().enumerate().filter(|(i, _)| !single[*i]) {
            groups.entry([patch.batch, patch.back, patch.component]).or_default().push(i as u32);
        }
        let mut forest = Self {
            order: Vec::new(),
            nodes: Vec::new(),
            areas: Vec::new(),
            roots: Vec::new(),
            position: vec![NONE; patches.len()],
        };
        for mut group in groups.into_values() {
            forest.roots.push(forest.nodes.len() as u32);
            forest.grow(patches, &mut group);
        }
        for (at, &patch) in (0..).zip(&forest.order) {
            forest.position[patch as usize] = at;
        }
        forest
    }

    fn grow(&mut self, patches: &[Patch], group: &mut [u32]) {
        self.nodes.push(Node { first: self.order.len() as u32, count: group.len() as u32 });
        self.areas.push(group.iter().map(|&i| f64::from(patches[i as usize].area)).sum());
        if let [patch] = *group {
            self.order.push(patch);
            return;
        }
        let (left, right) = halves(patches, group);
        self.grow(patches, left);
        self.grow(patches, right);
    }

    pub(super) fn children(&self, node: u32) -> [u32; 2] {
        let left = node + 1;
        [left, left + 2 * self.nodes[left as usize].count - 1]
    }

    /// The patch of a node that has but one.
    pub(super) fn only(&self, node: u32) -> Option<u32> {
        let Node { first, count } = self.nodes[node as usize];
        (count == 1).then(|| self.order[first as usize])
    }

    /// Entries (column, K weights: one for irradiance, nine for a light probe) to those of the best cut, ascending;
    /// `first`: the column of the first node.
    pub fn cut<const K: usize>(
        &self,
        entries: impl Iterator<Item = (u32, [f64; K])>,
        first: u32,
        tolerance: f64,
    ) -> Cut<K> {
        let place = |column: u32| self.position.get(column as usize).copied().unwrap_or(NONE);
        let (mut inside, mut cut) = (Vec::new(), Vec::new());
        for (column, weights) in entries {
            match place(column) {
                NONE => cut.push((column, weights)),
                place => inside.push((place, weights)),
            }
        }
        inside.sort_unstable_by_key(|entry| entry.0);
        let (mut error, mut rest) = (0.0, inside.as_slice());
        let walk = Walk { forest: self, first, price: tolerance * tolerance };
        for &root in &self.roots {
            let Node { first, count } = self.nodes[root as usize];
            let own;
            (own, rest) = rest.split_at(rest.partition_point(|entry| entry.0 < first + count));
            if !own.is_empty() {
                error += walk.best(root, own, &mut cut).error;
            }
        }
        cut.sort_unstable_by_key(|entry| entry.0);
        Cut { entries: cut, error }
    }

    /// Only the nodes that rows name, in the forest's order; the rows then name them by their new numbers.
    pub fn prune(self, first: u32, rows: &mut Rows) -> Tree {
        let mut number = vec![NONE; self.nodes.len()];
        for column in rows.columns.iter().filter(|column| **column >= first) {
            number[(column - first) as usize] = 0;
        }
        let mut nodes = Vec::new();
        for (node, number) in self.nodes.into_iter().zip(&mut number).filter(|(_, number)| **number == 0) {
            *number = nodes.len() as u32;
            nodes.push(node);
        }
        for column in rows.columns.iter_mut().filter(|column| **column >= first) {
            *column = first + number[(*column - first) as usize];
        }
        Tree { order: if nodes.is_empty() { Vec::new() } else { self.order }, nodes }
    }
}

/// Bisects the longest extent at half of the area. Normals count as extents too, with half the group's diagonal as their
/// length: walls that face apart part before they are cut into pieces.
fn halves<'a>(patches: &[Patch], group: &'a mut [u32]) -> (&'a mut [u32], &'a mut [u32]) {
    let of = |i: u32| &patches[i as usize];
    let bounds = |value: &dyn Fn(&Patch) -> Vec3| {
        let ends = group.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), &i| {
            (low.min(value(of(i))), high.max(value(of(i))))
        });
        ends.1 - ends.0
    };
    let places = bounds(&|patch| patch.centre);
    let turns = bounds(&|patch| patch.normal) * (0.5 * places.length());
    let extents: [f32; 6] = std::array::from_fn(|axis| if axis < 3 { places[axis] } else { turns[axis - 3] });
    let longest = (0..6).max_by(|&a, &b| extents[a].total_cmp(&extents[b]).then(b.cmp(&a))).unwrap_or(0);
    let along = |i: u32| if longest < 3 { of(i).centre[longest] } else { of(i).normal[longest - 3] };
    group.sort_unstable_by(|&a, &b| along(a).total_cmp(&along(b)).then(a.cmp(&b)));
    let half: f64 = 0.5 * group.iter().map(|&i| f64::from(of(i).area)).sum::<f64>();
    let mut sum = 0.0;
    let before = group.iter().take_while(|&&i| {
        sum += f64::from(of(i).area);
        sum <= half
    });
    let at = before.count().clamp(1, group.len() - 1);
    group.split_at_mut(at)
}

pub struct Cut<const K: usize> {
    pub entries: Vec<(u32, [f64; K])>,
    /// The sum of (2).
    pub error: f64,
}

/// From the leaves up: what is cheaper, a node or what is best below it.
struct Walk<'a> {
    forest: &'a Forest,
    first: u32,
    price: f64,
}

/// What the walk knows of a node.
struct Seen<const K: usize> {
    sum: [f64; K],
    /// (2) of the node.
    apart: f64,
    /// (2) and (3) of the best cut below it.
    error: f64,
    cost: f64,
}

impl Walk<'_> {
    /// Adds the best cut of a node to `cut`; `entries`: what the row saw of it, by place, not empty.
    fn best<const K: usize>(
        &self,
        node: u32,
        entries: &[(u32, [f64; K])],
        cut: &mut Vec<(u32, [f64; K])>,
    ) -> Seen<K> {
        if let Some(patch) = self.forest.only(node) {
            cut.push((patch, entries[0].1));
            return Seen { sum: entries[0].1, apart: 0.0, error: 0.0, cost: self.price };
        }
        let [left, right] = self.forest.children(node);
        let middle = entries.partition_point(|entry| entry.0 < self.forest.nodes[right as usize].first);
        let before = cut.len();
        let mut half = |half: u32, entries: &[(u32, [f64; K])]| {
            if entries.is_empty() { Seen::nothing() } else { self.best(half, entries, cut) }
        };
        let (l, r) = (half(left, &entries[..middle]), half(right, &entries[middle..]));
        let sum: [f64; K] = std::array::from_fn(|k| l.sum[k] + r.sum[k]);
        let share = self.forest.areas[left as usize] / self.forest.areas[node as usize];
        let own: f64 = (0..K).map(|k| (l.sum[k] - sum[k] * share).powi(2)).sum();
        let apart = own + l.apart + r.apart;
        if apart + self.price <= l.cost + r.cost {
            cut.truncate(before);
            cut.push((self.first + node, sum));
            return Seen { sum, apart, error: apart, cost: apart + self.price };
        }
        Seen { sum, apart, error: l.error + r.error, cost: l.cost + r.cost }
    }
}

impl<const K: usize> Seen<K> {
    fn nothing() -> Self {
        Self { sum: [0.0; K], apart: 0.0, error: 0.0, cost: 0.0 }
    }
}
