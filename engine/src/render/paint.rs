//! The picture, once all light is where it is read: surfaces, sky and blended surfaces; then exposure, tone curve and
//! overlay.

use super::channels::Channels;
use super::frame::{Now, Renderer};
use super::probes;
use super::surface::{Look, Parts, Scenery, Variants, Which};
use super::targets::Targets;
use super::view::View;
use crate::gpu::{Gpu, pass};
use crate::scene::{Feature, Forced};

impl Renderer {
    /// Surfaces, sky and blended surfaces; exposure, tone curve, overlay. Returns the draws.
    pub(super) fn paint(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        now: &Now<'_>,
        display: &wgpu::Texture,
    ) -> u32 {
        let size = [display.width(), display.height()];
        if self.target.as_ref().is_none_or(|(targets, _)| targets.size != size) {
            let targets = Targets::new(gpu, size, self.samples);
            let group = self.tonemap.group(gpu, &targets);
            self.exposure.bind(gpu, &targets);
            self.target = Some((targets, group));
        }
        self.follow_wireframe(gpu, now);
        let mut draws = self.expose(gpu, encoder, now, size);
        let Some(target) = &self.target else { return draws };
        self.tonemap.draw(encoder, &mut self.timer, &self.frame_group, target, display);
        draws += self.draw_outline(gpu, encoder, now.scene, display);
        draws += 1 + self.overlay.draw(gpu, encoder, Some(&mut self.timer), display);
        draws
    }

    /// Draws radiance and settles how it is exposed. The first picture of an automatic exposure is drawn twice:
    /// nothing is known before of how bright it is. Returns the draws.
    fn expose(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        now: &Now<'_>,
        size: [u32; 2],
    ) -> u32 {
        let Some(auto) = now.eye.auto_exposure.filter(|_| now.view.shows_light()) else {
            self.exposure.forget();
            return self.radiance(gpu, encoder, now);
        };
        let first = self.exposure.begin(gpu, &auto, size, now.time, self.settings.wait);
        let mut draws = 0;
        for _ in 0..1 + u32::from(first) {
            self.exposure.set_pre_exposure(encoder, &self.frame);
            draws += self.radiance(gpu, encoder, now);
            pass::drawn_before_computed(gpu, encoder);
            let Some((targets, _)) = &self.target else { break };
            self.exposure.run(encoder, &mut self.timer, (&self.frame, &self.frame_group), targets);
        }
        self.exposure.report(encoder);
        draws
    }

    /// Surfaces, sky, blended surfaces. Returns the draws.
    fn radiance(&mut self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder, now: &Now<'_>) -> u32 {
        let Some(target) = &self.target else { return 0 };
        let size = target.0.size;
        let variants = self.variants();
        let scenery = Scenery {
            scene: self.shadows.scene_group(),
            instances: &self.instances,
            still: &self.still,
            meshes: &self.meshes,
            materials: &self.materials,
            variants,
        };
        let origin = self.transport.origin;
        let look = Look {
            frame: &self.frame_group,
            clip_from_world: now.eye.clip_from_world(origin, size[0] as f32 / size[1].max(1) as f32),
            eye: (now.eye.position - origin).as_vec3(),
            samples: self.samples,
            mirrored: false,
        };
        let mut pass = target.0.begin(encoder, self.timer.render("surface"));
        let mut draws = 0;
        if now.view.shows_patches() {
            let shown = |batch: usize| scenery.instances.draws[batch].shown;
            draws +=
                self.patches.draw(gpu, &mut pass, &self.frame_group, &self.transport, shown, self.samples);
        } else {
            let all = Which { blended: false, still: true, moving: true };
            draws += self.surfaces.draw(&mut pass, &scenery, &look, all);
            if now.view.shows_sky() {
                draws += self.sky.draw(&mut pass, &self.frame_group, self.samples);
            }
            draws += self.surfaces.draw(&mut pass, &scenery, &look, Which { blended: true, ..all });
        }
        if now.view == View::Probes {
            let probes = (&*self.transport, self.objects.field());
            draws += self.probes.draw(gpu, &mut pass, &self.frame_group, probes, &self.spaces, self.samples);
        }
        if now.view == View::Tetrahedra {
            self.tetrahedra.set(gpu, &probes::tetrahedra(&self.transport, self.objects.field()));
            draws += self.tetrahedra.draw(&mut pass, &self.frame_group, self.samples);
        }
        draws += self.wireframe.draw(&mut pass, &self.frame_group, &self.meshes, self.samples);
        draws += self.guides.draw(&mut pass, &self.frame_group, self.samples);
        draws
    }

    /// Parts of the surfaces' shader: lights and cubemaps where there are any, the rest as materials ask for it.
    pub(super) fn variants(&self) -> Variants {
        let forced = self.asked.said(Feature::MaterialVariants);
        let of_materials = forced != Some(Forced::Out);
        let there = Parts {
            normal_map: of_materials,
            mask: of_materials,
            blend: of_materials,
            unlit: of_materials,
            lights: !self.shadows.lights().is_empty(),
            cubemaps: self.reflections.any(),
            grey: self.spaces.channels == Channels::One,
        };
        let masks_with_cubemaps = self.gpu.software && self.gpu.info.backend == wgpu::Backend::Vulkan;
        Variants { there, alike: forced == Some(Forced::In), masks_with_cubemaps }
    }
}
