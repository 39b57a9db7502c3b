//! What reflection probes take of a frame, before its picture is drawn.

use glam::Vec4;

use super::frame::{FrameUniform, Now, Renderer};
use super::reflections::Captured;
use super::reflections::capture::Set;
use super::surface::Scenery;
use super::view::View;
use crate::gpu::Gpu;

impl Renderer {
    /// Counts what captures show.
    pub(super) fn follow(&mut self, stirred: bool, sky_changed: bool) {
        let (seen, sky) = &mut self.seen;
        // The first sky is a change, too.
        *sky += u64::from(sky_changed || *sky == 0);
        seen.still += u64::from(stirred || sky_changed);
        let moved = self.instances.signature();
        seen.moving += u64::from(self.moved != moved);
        self.moved = moved;
    }

    /// Reflection probes: who reads which, and the captures that are due. `still`: light did not change.
    pub(super) fn reflect(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        now: &Now<'_>,
        frame: FrameUniform,
        still: bool,
    ) -> Captured {
        self.read_reflections(gpu, now);
        let variants = self.variants();
        let scenery = Scenery {
            scene: self.shadows.scene_group(),
            instances: &self.instances,
            still: &self.still,
            meshes: &self.meshes,
            materials: &self.materials,
            variants,
        };
        let mut set = Set {
            gpu,
            timer: &mut self.timer,
            surfaces: &mut self.surfaces,
            sky: &mut self.sky,
            scenery: &scenery,
            // Kept from picture to picture, however those are exposed.
            frame: FrameUniform {
                view: View::Composite as u32,
                pre_exposure: 1.0,
                cascade_ends: Vec4::ZERO,
                capture: 1,
                ..frame
            },
            brightest: self.steering.brightest().max(self.responses.brightest()),
        };
        let captured = self.reflections.capture(encoder, &mut set, self.seen, still);
        if captured.first {
            // Not before they are there may surfaces read them.
            let captures = std::mem::replace(encoder, gpu.device.create_command_encoder(&Default::default()));
            gpu.queue.submit([captures.finish()]);
            self.read_reflections(gpu, now);
        }
        captured
    }

    fn read_reflections(&mut self, gpu: &Gpu, now: &Now<'_>) {
        let still = (&*self.transport, &self.occluders);
        let drawn = (&self.instances, &self.materials);
        self.reflections.update(gpu, now, drawn, still);
        self.surfaces.bind(gpu, &self.spaces, &self.objects, &self.reflections);
    }
}
