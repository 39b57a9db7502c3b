//! The patches' rows as their rays counted them: the shipped layout and rays traced again, before anything is balanced.
//!
//! Each row closes, as receivers' rows do; nothing ties what goes one way to what comes back.

use engine::transport::Rows;

use super::bakes::Recipe;
use crate::cache::Cache;
use crate::emitter::Emitters;
use crate::emitter::patches_towards_emitters;
use crate::holes::AlphaHoles;
use crate::layout::{Layout, layout};
use crate::pipeline::{receiver_rows, sampled};
use crate::rays::Tracer;
use crate::{BakeError, Opened, Watcher};
use engine::transport::bvh::Bvh;

pub fn rows(opened: &Opened, recipe: Recipe, watcher: &dyn Watcher) -> Result<Rows, BakeError> {
    let (scene, assets) = (&opened.scene, &opened.assets);
    let Layout { transport, rays, .. } = layout(scene, assets, &opened.surface, recipe.length, watcher)?;
    let holes = AlphaHoles::new(&transport.surface, scene, assets);
    let bvh = Bvh::new(&rays.triangles, holes.holed());
    let emitters = Emitters::choose(&rays, &sampled(scene, &transport));
    let tracer = Tracer { scene: &rays, bvh: &bvh, holes: &holes, watcher };
    let hits = tracer.patch_rows(recipe.rays, &Cache::none())?;
    let towards = patches_towards_emitters(&tracer, &emitters)?;
    Ok(receiver_rows(&hits, recipe.rays, &emitters, &towards))
}
