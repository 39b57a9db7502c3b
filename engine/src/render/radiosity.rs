//! Light on its way in a frame: onto patches, from patch to patch, to receivers and probes. What did not change is not
//! done again; once the light is solved, nothing is done at all.

use super::RenderError;
use super::drawn::Drawn;
use super::frame::{Renderer, layout_of_rows};
use super::gather::Source;
use super::rows::PagedRows;
use super::sources::Changed;
use super::view::View;
use crate::scene::Feature;

impl Renderer {
    /// The light of probes is there while something reads it. Returns whether it is.
    pub(super) fn follow_probes(&mut self, view: View) -> Result<bool, RenderError> {
        let reads = self.instances.any_moving() || view.shows_probes();
        let read = self.asked.has(Feature::LightProbes, reads) || reads;
        if read != self.spaces.has_probes() {
            let gpu = &*self.gpu;
            self.spaces.hold_probes(gpu, read);
            let transport = &self.transport;
            let rows = (&transport.probe_from_patch, transport.columns());
            let layout = layout_of_rows(&self.asked);
            let upload = |page: &wgpu::BindGroupLayout| PagedRows::new(gpu, page, "probe", rows, layout);
            self.gather.hold_probes(gpu, upload, &self.spaces, read)?;
            self.dering.bind(gpu, &self.spaces);
            self.objects.bind(gpu, &self.spaces);
            self.probes_current = false;
        }
        Ok(read)
    }

    /// Direct light, bounce and gather: what of them is needed.
    pub(super) fn light(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        lit: bool,
        emitted: Changed,
        dark: bool,
        probes_read: bool,
    ) -> Drawn {
        let (timer, mut dispatches) = (&mut self.timer, 0);
        if dark {
            // The solution is 0. What moves finds it in every probe.
            if self.steering.put_out() || probes_read && !self.probes_current {
                self.spaces.darken(encoder);
                dispatches += self.objects.run(encoder, timer, true);
            }
            self.probes_current = probes_read;
            return Drawn { transport_dispatches: dispatches, ..Drawn::default() };
        }
        if let Some(factor) = emitted.rescaled {
            dispatches += self.rescale.run(&self.gpu, encoder, timer, factor);
        }
        let changed = lit || emitted.albedo || emitted.emission;
        if changed {
            self.steering.change();
        }
        // In another unit the light is the same: it is as near to its solution as it was.
        if changed || emitted.rescaled.is_some() {
            let groups = [&self.frame_group, self.shadows.scene_group()];
            dispatches += self.direct.run(encoder, timer, groups, &self.spaces);
        }
        let mut probes_changed = false;
        if self.sources.is_black() {
            if self.steering.put_out() {
                self.spaces.reflect_nothing(encoder);
                probes_changed = probes_read;
            }
        } else if !self.sources.sky_shines() && self.steering.has_faded() {
            self.steering.put_out();
            self.spaces.forget_bounced(encoder);
            probes_changed = probes_read;
        }
        let (gain, choice) = (self.sources.cavity_gain(), self.sources.choice());
        // Where there are no patches nothing is measured, and nothing is to be solved.
        let asked = self.settings.products.unwrap_or_else(|| self.steering.products(gain, &choice));
        let products = if self.spaces.patch_count == 0 { 0 } else { asked };
        let tag = (self.steering.version(), self.sources.unit());
        dispatches += self.bounce.run(encoder, timer, &self.coarse, products, tag);
        let probes_late = probes_read && !self.probes_current;
        let emission = emitted.emission || emitted.rescaled.is_some();
        for (source, is_new) in [(Source::Emitted, emission), (Source::Bounced, products > 0)] {
            if is_new || probes_late {
                dispatches += self.gather.run(encoder, timer, &self.frame_group, source);
            }
            if probes_read && (is_new || probes_late) {
                dispatches += self.dering.run(encoder, timer, source);
                probes_changed = true;
            }
        }
        dispatches += self.objects.run(encoder, timer, probes_changed);
        // What moves no longer may come back after the light has changed.
        self.probes_current = probes_read;
        Drawn { transport_dispatches: dispatches, products, ..Drawn::default() }
    }
}
