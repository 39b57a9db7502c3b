//! The tetrahedra between light probes as they stand in the scene now, baked or not: found by what the player itself asks
//! ([`engine::transport::probe_field`]), so that what is drawn while a probe is dragged is what a bake would give.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Arc;

use engine::scene::EntityId;
use engine::transport::probe_field::ProbeField;
use engine::transport::{Probe, Transport};
use glam::DVec3;

use crate::job::Job;
use crate::scenery::Scenery;

/// So many probes are joined while the picture waits: less than a picture takes. More are joined beside it.
const AT_ONCE: usize = 600;

#[derive(Clone, Debug, Default)]
pub struct Web {
    /// Metres, world.
    pub positions: Vec<DVec3>,
    /// Pairs of probes, and whether they are on the hull.
    pub edges: Vec<([usize; 2], bool)>,
    /// Corners of tetrahedra.
    pub cells: Vec<[usize; 4]>,
}

impl Web {
    pub fn between(positions: Vec<DVec3>) -> Self {
        let middle = positions.iter().sum::<DVec3>() / positions.len().max(1) as f64;
        let probe = |position: &DVec3| Probe {
            position: (*position - middle).as_vec3(),
            valid: 1.0,
            ..Probe::default()
        };
        let transport = Transport { probes: positions.iter().map(probe).collect(), ..Transport::default() };
        let field = ProbeField::new(&transport);
        let edge = |edge: engine::transport::probe_field::Edge| {
            (edge.probes.map(|probe| probe as usize), edge.on_hull)
        };
        Self {
            edges: field.edges().into_iter().map(edge).collect(),
            cells: field.cells().into_iter().map(|cell| cell.map(|probe| probe as usize)).collect(),
            positions,
        }
    }
}

/// Of all groups that are shown, in the scene's order.
pub fn probes(scenery: &Scenery<'_>) -> Vec<(EntityId, usize, DVec3)> {
    let groups = scenery.placed().filter_map(|(entity, world)| {
        let group = entity.light_probes.as_ref().filter(|_| !entity.hidden)?;
        let place = |position: &glam::Vec3| world.transform_point3(position.as_dvec3());
        Some(group.positions.iter().enumerate().map(move |(at, position)| (entity.id, at, place(position))))
    });
    groups.flatten().collect()
}

/// Follows the scene.
#[derive(Default)]
pub struct Webs {
    shown: Arc<Web>,
    /// A number for the positions that it is of.
    of: Option<u64>,
    job: Option<Job<(u64, Web)>>,
}

impl Webs {
    pub fn web(&self) -> &Arc<Web> {
        &self.shown
    }

    /// Another is on its way.
    pub fn is_busy(&self) -> bool {
        self.job.is_some()
    }

    pub fn follow(&mut self, scenery: &Scenery<'_>) {
        if let Some(joined) = self.job.as_mut().and_then(Job::poll) {
            self.job = None;
            if let Ok((number, web)) = joined {
                (self.of, self.shown) = (Some(number), Arc::new(web));
            }
        }
        let positions: Vec<DVec3> = probes(scenery).into_iter().map(|(.., place)| place).collect();
        let number = number(&positions);
        if self.of == Some(number) || self.job.is_some() {
            return;
        }
        if positions.len() <= AT_ONCE {
            (self.of, self.shown) = (Some(number), Arc::new(Web::between(positions)));
        } else {
            // Without a thread the last one stays.
            self.job = Job::start("tetrahedra", move || (number, Web::between(positions))).ok();
        }
    }
}

fn number(positions: &[DVec3]) -> u64 {
    let mut hasher = DefaultHasher::new();
    positions.iter().for_each(|place| place.to_array().map(f64::to_bits).hash(&mut hasher));
    hasher.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_corners_of_a_box_are_joined_far_from_the_origin_too() {
        let far = DVec3::new(1e6, -3e5, 7e5);
        let corner = |n: u32| far + DVec3::new(f64::from(n & 1), f64::from(n >> 1 & 1), f64::from(n >> 2));
        let web = Web::between((0..8).map(corner).collect());
        assert!((5..=6).contains(&web.cells.len()), "{}", web.cells.len());
        let hull = web.edges.iter().filter(|(_, on_hull)| *on_hull).count();
        assert!(hull >= 18, "twelve sides and a diagonal on each face: {hull}");
    }

    #[test]
    fn fewer_than_four_probes_have_edges_and_no_tetrahedra() {
        assert!(Web::between(Vec::new()).edges.is_empty());
        assert!(Web::between(vec![DVec3::ONE]).edges.is_empty());
        let row = Web::between((0..3).map(|x| DVec3::X * f64::from(x)).collect());
        assert_eq!((row.edges.len(), row.cells.len()), (2, 0));
    }
}
