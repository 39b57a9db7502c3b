//! Which captures may wait: those of probes that nothing in view reads, at first hand or in what another probe shows;
//! and what of all that changes a probe sees.

use std::hash::{DefaultHasher, Hasher};

use glam::Vec3;

use super::super::instances::{Draw, Instances};
use super::super::shadow_view::in_sight;
use super::capture::Set;
use super::{Probe, Reflections, Seen};

/// Rays all around may miss a gap: what moves is seen from somewhat farther than the farthest that they meet.
const FARTHER: f32 = 1.5;

impl Reflections {
    /// Probe by probe: whether anything in view reads it, at first hand or in what another one shows. Where nobody does,
    /// it may show what was.
    pub(super) fn read_in_view(&self, set: &Set<'_>) -> Vec<bool> {
        if self.asked.unseen {
            return vec![true; self.probes.len()];
        }
        let draws = &set.scenery.instances.draws;
        let mut read = vec![false; self.probes.len()];
        let mut waiting = Vec::new();
        let mut take = |draw: usize, waiting: &mut Vec<usize>| {
            for probe in self.reads[draw].all() {
                if !std::mem::replace(&mut read[probe], true) {
                    waiting.push(probe);
                }
            }
        };
        let clip_from_world = &set.frame.clip_from_world;
        let in_view = |draw: &Draw| draw.shown && in_sight(clip_from_world, draw.centre, draw.radius);
        (0..draws.len()).filter(|&draw| in_view(&draws[draw])).for_each(|draw| take(draw, &mut waiting));
        while let Some(probe) = waiting.pop() {
            let batches = self.probes[probe].batches.iter().copied();
            let moving = (0..draws.len()).filter(|&draw| draws[draw].mesh.is_some());
            batches.chain(moving).for_each(|draw| take(draw, &mut waiting));
        }
        read
    }
}

impl Probe {
    /// Changes of what it shows: of what moves only where that is as near as what it sees.
    pub(super) fn sees(&mut self, all: Seen, at: Vec3, instances: &Instances, again: bool) -> Seen {
        let range = self.sight.map_or(f32::INFINITY, |(_, sight)| sight.farthest * FARTHER);
        let near = |draw: &&Draw| draw.mesh.is_some() && draw.centre.distance(at) <= range + draw.radius;
        let mut hasher = DefaultHasher::new();
        instances.draws.iter().filter(near).for_each(|draw| instances.stamp(draw, &mut hasher));
        let number = hasher.finish();
        self.moving.1 += u64::from(self.moving.0 != number);
        self.moving.0 = number;
        self.again += u64::from(again);
        Seen { still: all.still + self.again, moving: self.moving.1 }
    }
}
