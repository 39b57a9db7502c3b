//! The bake that is played: what of it is on disk, whether it fits the scene, and what it lacks where it does not.
//!
//! The light file holds what the scene needed when it was baked. Each thing that it leaves out it leaves out on grounds
//! that may have gone since: a lamp that may change now, a project that forces a feature in. Then the full transport
//! beside it is played, whole, and one message says why. A stale omission is never played: where the full transport is
//! missing, there is no baked light at all, and that is said.

use std::path::Path;

use super::PlayError;
use crate::scene::assets::Assets;
use crate::scene::file::{Project, Quality};
use crate::scene::{Entity, Feature, Forced, Scene};
use crate::transport::file;
use crate::transport::key::{BakeWith, inputs};
use crate::transport::needs::{grounds, needs_of_scene};
use crate::transport::stale::Stale;
use crate::transport::{Omission, Transport};

/// A bake that fits the scene.
#[derive(Default)]
pub struct Found {
    pub transport: Transport,
    /// What the scene has no baked light for, and why.
    pub lacks: Option<String>,
    /// Why more is loaded than the light file.
    pub grown: Option<String>,
}

/// The bake of a scene on disk, as far as it fits.
pub fn find(
    project: &Path,
    name: &str,
    (scene, assets): (&Scene, &Assets),
    settings: &Project,
    force: bool,
) -> Result<Found, PlayError> {
    let path = file::path(project, name);
    if !path.is_file() {
        let to_bake = |entity: &Entity| entity.is_static && entity.mesh.is_some() && !scene.is_hidden(entity);
        let any = scene.entities.iter().any(to_bake);
        return Ok(Found::nothing(any.then(|| "it has no bake, only direct light is shown".to_owned())));
    }
    let load = if force { file::load_uncertified } else { file::load };
    let light = load(&path)?;
    let Some(why) = gone(&light, scene, assets, settings) else {
        return Ok(fitted(light, scene, assets, settings));
    };
    let beside = file::full_path(project, name);
    if !beside.is_file() {
        let lacks =
            format!("{why}, and {} with the rest is missing: only direct light is shown", name_of(&beside));
        return Ok(Found::nothing(Some(lacks)));
    }
    let full = whole(load(&beside)?, &light);
    let other = if file::belong(&light, &full) { "" } else { ", which is of another bake" };
    let grown = format!("{why}: all of its bake is loaded from {}{other}", name_of(&beside));
    Ok(Found { grown: Some(grown), ..fitted(full, scene, assets, settings) })
}

/// With the certificate of the light file, which is the newer one.
fn whole(full: Transport, light: &Transport) -> Transport {
    if !file::belong(light, &full) {
        return full;
    }
    Transport { certificate: light.certificate.clone(), ..full }
}

/// Which grounds of leaving something out have gone, in a sentence without its end; `None` where all hold.
fn gone(light: &Transport, scene: &Scene, assets: &Assets, settings: &Project) -> Option<String> {
    let is_gone = |omission: &&Omission| {
        let Omission { feature, relied_on: was } = omission;
        settings.features.get(feature) == Some(&Forced::In)
            || *was != grounds(*feature, scene, assets)
            || (*feature == Feature::Matrix
                && light.certificate.unlimited_gain != settings.bake.unlimited_gain)
    };
    let gone: Vec<&Omission> = light.omissions.iter().filter(is_gone).collect();
    let first = gone.first()?;
    let needs = needs_of_scene(scene, assets, &settings.features);
    let verdict = needs.verdict(first.feature);
    let because = match (verdict.forced, verdict.is_in) {
        (Some(Forced::In), _) => "the project asks for it now".to_owned(),
        (_, true) => verdict.why.clone(),
        _ => "what it rests on has changed since".to_owned(),
    };
    let names: Vec<&str> = gone.iter().map(|omission| omission.feature.name()).collect();
    Some(format!("it was baked without {} ({because})", names.join(", ")))
}

/// Without what does not fit.
fn fitted(mut transport: Transport, scene: &Scene, assets: &Assets, settings: &Project) -> Found {
    let certificate = &transport.certificate;
    if certificate.inputs.is_empty() {
        let lacks = "its bake is of an older baker, all of it is stale and only direct light is shown";
        return Found::nothing(Some(lacks.to_owned()));
    }
    let with = BakeWith {
        quality: Quality::default(), // a name for rays and length
        rays: certificate.rays_per_row,
        length: certificate.base_length,
    };
    let stale = Stale::between(&certificate.inputs, &inputs(scene, assets, &with, &settings.features));
    if stale.is_empty() {
        return Found { transport, ..Found::default() };
    }
    transport.leave_out(&stale);
    let lacks = format!("its bake is stale ({stale}), the rest keeps its baked light");
    Found { transport, lacks: Some(lacks), grown: None }
}

impl Found {
    fn nothing(lacks: Option<String>) -> Self {
        Self { lacks, ..Self::default() }
    }
}

fn name_of(path: &Path) -> String {
    path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}
