//! Groups of patches that a row may name in place of their patches: clusters of a tree over the sources of light.
//!
//! ```text
//! B_t = Sum_{j in t} A_j B_j / Sum_{j in t} A_j        value of node t: the area's mean of B [W/m2]
//! H_i = Sum_j G_ij B_j  ~  Sum_{t in C_i} G_it B_t      G_it = Sum_{j in t} G_ij
//! |error of H_i| <= Sum_t Sum_{j in t} |G_ij - G_it A_j / A_t| osc_t(B) / 2
//! ```
//! C_i is a *cut*: nodes, single patches and sky patches that together hold every patch the row saw, each once. What
//! is constant over a node loses nothing, and rows sum to what they did (Hanrahan, Salzman and Aupperle 1991; here
//! one-sided, with receivers that are points).
//!
//! Nodes are runs of patches in one order, so that their values need no levels: each is a sum of its own.

use bytemuck::{Pod, Zeroable};
use glam::DVec3;
use rayon::prelude::*;

use super::Patch;

/// Which nodes there are. Columns of cut rows are patches, sky patches, then these nodes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tree {
    /// Patches, each at most once; those of a node lie side by side.
    pub order: Vec<u32>,
    pub nodes: Vec<Node>,
}

/// The patches `order[first .. first + count]`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Node {
    pub first: u32,
    pub count: u32,
}

impl Tree {
    /// How many nodes.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    pub fn bytes(&self) -> usize {
        self.order.len() * size_of::<u32>() + self.nodes.len() * size_of::<Node>()
    }

    /// The patches of a node.
    pub fn members(&self, node: usize) -> &[u32] {
        let Node { first, count } = self.nodes[node];
        &self.order[first as usize..(first + count) as usize]
    }

    /// Area means of radiosity, by node; `values` may hold more than patches.
    pub fn values(&self, patches: &[Patch], values: &[DVec3]) -> Vec<DVec3> {
        (0..self.len()).into_par_iter().map(|node| self.value(node, patches, values)).collect()
    }

    fn value(&self, node: usize, patches: &[Patch], values: &[DVec3]) -> DVec3 {
        let (mut light, mut area) = (DVec3::ZERO, 0.0);
        for &patch in self.members(node) {
            let own = f64::from(patches[patch as usize].area);
            light += values[patch as usize] * own;
            area += own;
        }
        light / area
    }

    /// Every node has patches, every patch exists, and none is there twice.
    pub fn validate(&self, patches: usize) -> Result<(), String> {
        let mut seen = vec![false; patches];
        for &patch in &self.order {
            match seen.get_mut(patch as usize) {
                Some(seen) if !*seen => *seen = true,
                Some(_) => return Err(format!("patch {patch} is in the order twice")),
                None => return Err(format!("the order names patch {patch}, which does not exist")),
            }
        }
        let fits = |node: &Node| {
            node.count > 0 && u64::from(node.first) + u64::from(node.count) <= self.order.len() as u64
        };
        match self.nodes.iter().position(|node| !fits(node)) {
            Some(node) => Err(format!("node {node} has no patches, or such as do not exist")),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tree(order: &[u32], nodes: &[(u32, u32)]) -> Tree {
        let nodes = nodes.iter().map(|&(first, count)| Node { first, count }).collect();
        Tree { order: order.to_vec(), nodes }
    }

    #[test]
    fn a_nodes_value_is_the_mean_by_area() {
        let patches = [1.0, 3.0, 4.0].map(|area| Patch { area, ..Patch::default() });
        let values = [DVec3::splat(8.0), DVec3::splat(4.0), DVec3::ONE, DVec3::splat(77.0)];
        let tree = tree(&[2, 0, 1], &[(1, 2), (0, 3)]);
        let means = tree.values(&patches, &values);
        assert_eq!(means, [DVec3::splat(5.0), DVec3::splat(3.0)]);
        assert_eq!(tree.members(0), [0, 1]);
    }

    #[test]
    fn trees_that_name_what_is_not_there_are_refused() {
        assert_eq!(tree(&[1, 0], &[(0, 2)]).validate(2), Ok(()));
        for broken in [
            tree(&[1, 1], &[]),
            tree(&[2, 0], &[]),
            tree(&[0, 1], &[(0, 0)]),
            tree(&[0, 1], &[(1, 2)]),
            tree(&[0, 1], &[(u32::MAX, 2)]),
        ] {
            assert!(broken.validate(2).is_err(), "{broken:?}");
        }
    }
}
