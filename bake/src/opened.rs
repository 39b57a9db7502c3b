//! A project's scene as the bake takes it, and with the bake on disk.

use std::collections::BTreeMap;
use std::path::Path;

use engine::scene::assets::Assets;
use engine::scene::file::{Project, load_project, load_scene};
use engine::scene::import::load_assets;
use engine::scene::{Feature, Forced, Scene, Warning};
use engine::transport::file::TransportError;
use engine::transport::key::{BakeWith, inputs};
use engine::transport::needs::{as_baked, needs_of_scene};
use engine::transport::stale::Stale;
use engine::transport::{Transport, file};

use crate::surface::{self, Surface};
use crate::{BakeError, Settings, Watcher, pipeline};

/// A scene with all that it refers to, and its static surface.
pub struct Opened {
    pub settings: Project,
    pub name: String,
    pub scene: Scene,
    /// With what the bake leaves out before any ray; `scene` is without.
    pub authored: Scene,
    pub assets: Assets,
    pub surface: Surface,
    pub warnings: Vec<Warning>,
}

impl Opened {
    pub fn open(project: &Path, scene: Option<&str>) -> Result<Self, BakeError> {
        let settings = load_project(project)?;
        let name = scene.unwrap_or(&settings.default_scene).to_owned();
        let authored = load_scene(project, &name)?;
        Self::of(project, settings, name, authored)
    }

    pub fn of(project: &Path, settings: Project, name: String, authored: Scene) -> Result<Self, BakeError> {
        let (assets, mut warnings) = load_assets(project, &authored)?;
        let scene = as_baked(&authored, &assets, &settings.features);
        let surface = surface::sanitise(&scene, &assets)?;
        warnings.extend(surface.warnings.iter().cloned());
        Ok(Self { settings, name, scene, authored, assets, surface, warnings })
    }

    /// As authored, and as it is baked.
    pub fn scenes(&self) -> [&Scene; 2] {
        [&self.authored, &self.scene]
    }

    /// What the author says of features.
    pub fn forced(&self) -> &BTreeMap<Feature, Forced> {
        &self.settings.features
    }

    /// The same transport with the light probes that the scene needs now, and a line that says so. None where its places
    /// are not those of the scene.
    pub fn make_probes(
        &self,
        transport: Transport,
        with: &BakeWith,
        watcher: &dyn Watcher,
    ) -> Result<Option<(Transport, Vec<Warning>)>, BakeError> {
        let before = transport.probes.len();
        let made =
            pipeline::make_probes((&self.scene, &self.assets), &self.surface, with, transport, watcher)?;
        let told = |(transport, mut warnings): (Transport, Vec<Warning>)| {
            let needs = needs_of_scene(&self.authored, &self.assets, self.forced());
            let verdict = needs.verdict(Feature::LightProbes);
            let message = format!(
                "{}: {} where there were {before}, and no other row was traced",
                verdict.why,
                transport.probes.len()
            );
            warnings.push(Warning::new(verdict.feature.name(), message));
            (transport, warnings)
        };
        Ok(made.map(told))
    }
}

/// A scene with the bake on disk, which is current.
pub struct Solvable {
    pub opened: Opened,
    pub transport: Transport,
}

impl Solvable {
    /// To be asked: its certificate holds, or it is forced.
    pub fn certified(project: &Path, scene: Option<&str>, settings: &Settings) -> Result<Self, BakeError> {
        let load = if settings.force { file::load_full_uncertified } else { file::load_full };
        Self::open(project, scene, settings, load)
    }

    pub fn open(
        project: &Path,
        scene: Option<&str>,
        settings: &Settings,
        load: fn(&Path, &str) -> Result<Transport, TransportError>,
    ) -> Result<Self, BakeError> {
        let opened = Opened::open(project, scene)?;
        let file = file::path(project, &opened.name);
        let project_name = project.display().to_string();
        let quality = settings.quality.map(|quality| quality.to_string());
        if !file.is_file() {
            let quality = quality.unwrap_or_else(|| opened.settings.bake.quality.to_string());
            return Err(BakeError::Missing { project: project_name, scene: opened.name, quality });
        }
        let transport = load(project, &opened.name)?;
        let certificate = &transport.certificate;
        let stale = |why: &str| {
            Err(BakeError::Stale { project: project_name, scene: opened.name.clone(), why: why.to_owned() })
        };
        if quality.is_some_and(|quality| quality != certificate.quality) {
            return stale(&format!("it was made at quality {}", certificate.quality));
        }
        let with = BakeWith {
            quality: settings.quality.unwrap_or_default(),
            rays: certificate.rays_per_row,
            length: certificate.base_length,
        };
        let now = inputs(&opened.scene, &opened.assets, &with, opened.forced());
        let differs = Stale::between(&certificate.inputs, &now);
        if !differs.is_empty() {
            return stale(&differs.to_string());
        }
        Ok(Self { opened, transport })
    }
}
