//! What a renderer says of itself: bound, bytes, what it leaves out; and its light, for tests and reports.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DVec3, Vec3};

use super::RenderError;
use super::channels::Channels;
use super::direct::PatchShadows;
use super::frame::{FrameUniform, Renderer};
use super::objects::Objects;
use super::reflections::sight::Sight;
use super::spaces::Spaces;
use super::targets::Targets;
use crate::gpu::{Gpu, GpuError, buffer};
use crate::scene::EntityId;
use crate::transport::reflection::Cube;
use crate::transport::{Occluders, Transport};

/// How a picture was exposed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exposed {
    pub exposure: f32,
    pub pre_exposure: f32,
}

/// The light of the last frame [W/m2], one vector an element.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Solved {
    /// E by patch: emitted, and reflected once from punctual lights.
    pub exitance: Vec<Vec3>,
    /// B by patch; then, by sky patch, pi times its radiance.
    pub radiosity: Vec<Vec3>,
    /// By receiver, without what comes straight from punctual lights.
    pub irradiance: Vec<Vec3>,
    /// Three for each receiver that has directional terms ([`crate::transport::directional`]).
    pub directional: Vec<Vec3>,
    /// Nine coefficients a probe [W/m2/sr]; none where nothing reads probes.
    pub probes: Vec<Vec3>,
}

impl Renderer {
    /// The error of B is at most this share of the largest B.
    pub fn bound(&self) -> Option<f32> {
        Some(self.steering.measured()?.bound(self.sources.cavity_gain()))
    }

    /// Cubemaps of baked reflection probes, from disk.
    pub fn give_cubemaps(&mut self, cubes: HashMap<EntityId, Cube>) {
        self.reflections.give(cubes);
    }

    /// Cubemaps of baked reflection probes that were captured for good.
    pub fn finished_cubemaps(&self) -> Result<Vec<(EntityId, Cube)>, RenderError> {
        Ok(self.reflections.finished(&self.gpu)?)
    }

    /// Reflection probes that show nothing, as they stand inside a solid: entity, and a better place.
    pub fn misplaced_probes(&self) -> Vec<(EntityId, String)> {
        let said = |(entity, sight, better): (EntityId, Sight, Option<DVec3>)| {
            let seen = sight.backs * 100.0;
            let remedy = better.map_or("move it out".to_owned(), |at| {
                format!("move it, for instance to {:.2}, {:.2}, {:.2}", at.x, at.y, at.z)
            });
            (entity, format!("it stands inside a solid ({seen:.0} % of what it sees are backs): {remedy}"))
        };
        self.reflections.misplaced(self.transport.origin).map(said).collect()
    }

    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    pub fn transport(&self) -> &Arc<Transport> {
        &self.transport
    }

    /// The static surface, to be asked by rays.
    pub fn occluders(&self) -> &Occluders {
        &self.occluders
    }

    /// What told patches in the last frame whether a light reaches them.
    pub fn patch_shadows(&self) -> PatchShadows {
        self.direct.used()
    }

    /// W/m2 of one stored unit of radiosity.
    pub fn light_unit(&self) -> f32 {
        self.sources.unit()
    }

    /// The light as it lies on the GPU.
    pub fn spaces(&self) -> &Spaces {
        &self.spaces
    }

    /// The same, read back. Blocks.
    pub fn solved(&self) -> Result<Solved, GpuError> {
        let (spaces, unit) = (&self.spaces, self.sources.unit());
        let baked = self.responses.spread.radiosity.clone();
        let read = |buffer: &wgpu::Buffer, count: usize, unit: f32| -> Result<Vec<Vec3>, GpuError> {
            let values = spaces.channels.read(&self.gpu, buffer)?;
            Ok(values.into_iter().take(count).map(|value| value * unit).collect())
        };
        // What is emitted and what bounced lie apart.
        let sum = |[emitted, bounced]: &[wgpu::Buffer; 2], count| -> Result<Vec<Vec3>, GpuError> {
            let both = read(emitted, count, 1.0)?.into_iter().zip(read(bounced, count, 1.0)?);
            Ok(both.map(|(emitted, bounced)| emitted + bounced).collect())
        };
        let (patches, receivers) = (spaces.patch_count as usize, spaces.receiver_count as usize);
        let terms = self.transport.directional_terms();
        let first = spaces.directional as usize;
        let arrived = sum(&spaces.receivers, receivers.max(first + terms))?;
        let probes =
            if self.probes_current && spaces.has_probes() { 9 * spaces.probe_count as usize } else { 0 };
        Ok(Solved {
            exitance: read(&spaces.exitance, patches, unit)?,
            radiosity: if self.is_solved_for() {
                baked
            } else {
                read(&spaces.radiosity, self.transport.columns(), unit)?
            },
            irradiance: arrived[..receivers].to_vec(),
            directional: arrived[first..][..terms].to_vec(),
            probes: sum(&spaces.probes, probes)?,
        })
    }

    /// The light of what moves.
    pub fn objects(&self) -> &Objects {
        &self.objects
    }

    /// What the last frame was drawn into before the tonemap.
    pub fn targets(&self) -> Option<&Targets> {
        self.target.as_ref().map(|(targets, _)| targets)
    }

    /// Lights that a point has to add up, on average over the scene.
    pub fn mean_lights(&self) -> f32 {
        self.shadows.light_grid().mean_lights()
    }

    /// Of the last picture: display = `exposure` * radiance, and it was drawn times `pre_exposure`. Blocks.
    pub fn exposed(&self) -> Result<Exposed, GpuError> {
        let frame: Vec<FrameUniform> = buffer::read(&self.gpu, &self.frame)?;
        let FrameUniform { exposure, pre_exposure, .. } = frame[0];
        Ok(Exposed { exposure, pre_exposure })
    }

    /// Writes lines over a picture that is drawn.
    pub fn lay_over(&mut self, lines: Vec<String>, display: &wgpu::Texture) {
        self.overlay.show(lines, 1);
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        self.overlay.draw(&self.gpu, &mut encoder, None, display);
        self.gpu.queue.submit([encoder.finish()]);
        self.overlay.show(Vec::new(), 1);
    }

    /// Stops of the automatic exposure, as metered a few frames ago.
    pub fn metered(&self) -> Option<f32> {
        self.exposure.stops
    }

    /// Pages of patch rows.
    pub fn pages(&self) -> usize {
        self.bounce.pages()
    }

    /// Bytes on the GPU by kind.
    pub fn bytes(&self) -> [(&'static str, u64); 14] {
        let [receiver_rows, probe_rows] = self.gather.bytes();
        [
            ("rows", self.bounce.bytes() + receiver_rows),
            ("rows of probes", probe_rows),
            ("patches", self.spaces.patch_bytes),
            ("light", self.spaces.bytes),
            ("light of probes", self.spaces.probe_bytes() + self.objects.bytes()),
            ("coarse correction", self.coarse.bytes),
            ("surface", self.still.bytes),
            ("shadow rays", self.direct.bytes()),
            ("meshes", self.meshes.bytes()),
            ("pictures", self.pictures.bytes),
            ("shadow maps", self.shadows.bytes()),
            ("cubemaps", self.reflections.bytes()),
            ("targets", self.targets().map_or(0, Targets::bytes) + self.turns.bytes()),
            ("overlay", self.overlay.bytes()),
        ]
    }

    /// What is not done, and why.
    pub fn left_out(&self) -> Vec<String> {
        let mut left_out = Vec::new();
        left_out.extend(self.shadows.left_out());
        if self.transport.sky_patches == 0 {
            left_out.push("sky patches: no sky".to_owned());
        }
        if self.transport.directional_receivers() == 0 {
            left_out.push("directional terms: no normal map on a baked surface".to_owned());
        }
        if self.spaces.channels == Channels::One {
            left_out
                .push("two channels of light: nothing that it comes from or meets has a colour".to_owned());
        }
        if !self.instances.any_moving() {
            left_out.push("light probes: nothing moves".to_owned());
        }
        if self.reflections.left_out > 0 {
            left_out.push(format!("{} reflection probes: too many", self.reflections.left_out));
        }
        if !self.reflections.any() {
            left_out.push("reflection cubemaps: nothing smooth, or no probe and no sky".to_owned());
        }
        if self.is_solved_for() {
            left_out.push("matrix: light was solved at the bake".to_owned());
        }
        if self.reflections.unread > 0 {
            left_out
                .push(format!("{} reflection probes: nothing in view reads them", self.reflections.unread));
        }
        if self.coarse.bytes == 0 && !self.is_solved_for() {
            left_out.push(format!("coarse correction: {}", self.sources.choice().why));
        }
        left_out
    }
}
