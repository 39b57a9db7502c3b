//! The patches that a bake would make of the scene as it stands, found beside the editing: while densities are painted
//! their outlines are drawn and their number is told. One division goes on at a time; when it is there and the scene has
//! changed since, the next one begins.

use std::collections::HashMap;
use std::sync::Arc;

use bake::{BakeError, Settings, Silent};
use engine::scene::EntityId;
use engine::scene::assets::Assets;
use engine::transport::Transport;
use glam::{DVec3, Vec3};

use crate::document::Document;
use crate::edit::Stale;
use crate::job::Job;

/// Of its own patch's length: how far an outline is drawn before its surface, so that it is seen.
const LIFT: f32 = 0.012;

/// What a bake would make.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Patches {
    pub count: usize,
    pub of: HashMap<EntityId, Outlines>,
}

/// The patches of one entity.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outlines {
    pub count: usize,
    /// Sides between patches, and of the whole; metres, world.
    pub sides: Vec<[DVec3; 2]>,
}

type Divided = (u64, Result<Patches, BakeError>);

/// Follows the document.
#[derive(Default)]
pub struct Patching {
    job: Option<Job<Divided>>,
    /// The last that was found, and the document's revision that it is of.
    found: Option<(u64, Arc<Patches>)>,
    /// Why there is none, and of which revision.
    pub refused: Option<(u64, String)>,
}

impl Patching {
    /// The last that was found; what it is of may have changed since.
    pub fn patches(&self) -> Option<&Arc<Patches>> {
        self.found.as_ref().map(|(_, patches)| patches)
    }

    /// Another division is on its way.
    pub fn is_busy(&self) -> bool {
        self.job.is_some()
    }

    /// To be called with every picture while patches are shown. Waits for nothing.
    pub fn follow(&mut self, document: &Document, assets: &Arc<Assets>) {
        if let Some(divided) = self.job.as_mut().and_then(Job::poll) {
            self.job = None;
            self.take(divided, document.revision());
        }
        let known = self.found.as_ref().map(|(revision, _)| *revision);
        let known = known.max(self.refused.as_ref().map(|(revision, _)| *revision));
        let is_known = known.is_some_and(|known| document.stale_since(known) < Stale::Transport);
        if self.job.is_some() || is_known {
            return;
        }
        let (project, name) = (document.project().to_owned(), document.name().to_owned());
        let (scene, assets, revision) = (document.scene().clone(), assets.clone(), document.revision());
        let divide = move || {
            let divided = bake::divide(&project, &name, &scene, &assets, &Settings::default(), &Silent);
            (revision, divided.map(|transport| patches(&transport)))
        };
        // Without a thread there is nothing to show.
        self.job = Job::start("patches", divide).ok();
    }

    fn take(&mut self, divided: Result<Divided, String>, now: u64) {
        match divided {
            Ok((revision, Ok(patches))) => {
                (self.found, self.refused) = (Some((revision, Arc::new(patches))), None);
            }
            Ok((revision, Err(error))) => self.refused = Some((revision, bake::chain::told(&error))),
            Err(panicked) => self.refused = Some((now, panicked)),
        }
    }
}

/// Of a triangle.
struct Side {
    patch: u32,
    lifted: [Vec3; 2],
    /// Its second triangle is of the same patch.
    is_inside: bool,
}

/// A side lies between patches where its two triangles are of different ones, or where it has only one.
fn patches(transport: &Transport) -> Patches {
    let surface = &transport.surface;
    let mut patches = Patches { count: transport.patches.len(), ..Patches::default() };
    for batch in &surface.batches {
        let own = patches.of.entry(batch.entity()).or_default();
        let range = batch.first as usize..(batch.first + batch.count) as usize;
        let mut sides: HashMap<[[u32; 3]; 2], Side> = HashMap::new();
        for triangle in range {
            let (corners, patch) = (surface.positions(triangle), surface.patches[triangle][0]);
            let area = transport.patches.get(patch as usize).map_or(0.0, |patch| patch.area);
            let lift = normal(corners) * LIFT * area.sqrt();
            for k in 0..3 {
                let ends = [corners[k], corners[(k + 1) % 3]];
                let lifted = ends.map(|end| end + lift);
                let first = Side { patch, lifted, is_inside: false };
                let again = |side: &mut Side| side.is_inside = side.patch == patch;
                sides.entry(key(ends)).and_modify(again).or_insert(first);
            }
        }
        let drawn = sides.into_values().filter(|side| !side.is_inside);
        own.sides.extend(drawn.map(|side| side.lifted.map(|end| transport.origin + end.as_dvec3())));
    }
    for patch in &transport.patches {
        let batch = surface.batches.get(patch.batch as usize);
        let own = batch.and_then(|batch| patches.of.get_mut(&batch.entity()));
        own.into_iter().for_each(|own| own.count += 1);
    }
    patches
}

fn normal([a, b, c]: [Vec3; 3]) -> Vec3 {
    (b - a).cross(c - a).normalize_or_zero()
}

/// The same from both sides.
fn key(ends: [Vec3; 2]) -> [[u32; 3]; 2] {
    let mut key = ends.map(|end| end.to_array().map(f32::to_bits));
    key.sort_unstable();
    key
}

#[cfg(test)]
mod tests {
    use engine::transport::surface::{Batch, Surface, Vertex};
    use engine::transport::{NONE, Patch};

    use super::*;

    /// A square of two triangles: the same patch, or one each.
    fn square(patches: [u32; 2]) -> Transport {
        let corners = [Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y];
        let vertices = corners.map(|position| Vertex { position, ..Vertex::default() }).to_vec();
        let surface = Surface {
            vertices,
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            patches: patches.map(|patch| [patch, NONE]).to_vec(),
            batches: vec![Batch { entity: [7, 0], count: 2, ..Batch::default() }],
            ..Surface::default()
        };
        let count = patches[1] as usize + 1;
        let patches = vec![Patch { area: 1.0 / count as f32, ..Patch::default() }; count];
        Transport { surface, patches, origin: DVec3::Z, ..Transport::default() }
    }

    #[test]
    fn outlines_run_between_patches_and_around_them() {
        let one = patches(&square([0, 0]));
        assert_eq!((one.count, one.of[&EntityId(7)].count, one.of[&EntityId(7)].sides.len()), (1, 1, 4));
        let two = patches(&square([0, 1]));
        assert_eq!((two.count, two.of[&EntityId(7)].count, two.of[&EntityId(7)].sides.len()), (2, 2, 5));
        let heights = two.of[&EntityId(7)].sides.iter().flatten().map(|end| end.z);
        assert!(heights.into_iter().all(|z| z > 1.0 && z < 1.02), "before their surface");
    }
}
