//! Light on its way in a frame: onto patches, from patch to patch, to receivers and probes. What did not change is not
//! done again; once the light is solved, nothing is done at all.

use super::frame::{Drawn, Renderer};
use super::gather::Source;
use super::sources::Changed;

impl Renderer {
    /// Direct light, bounce and gather: what of them is needed.
    pub(super) fn light(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        lit: bool,
        emitted: Changed,
        dark: bool,
    ) -> Drawn {
        if dark {
            // The solution is 0. What moves finds it in every probe.
            if self.steering.put_out() {
                self.spaces.darken(encoder);
            }
            self.probes_current = true;
            return Drawn::default();
        }
        let (timer, mut dispatches) = (&mut self.timer, 0);
        if let Some(factor) = emitted.rescaled {
            dispatches += self.rescale.run(&self.gpu, encoder, factor);
        }
        if lit || emitted.albedo || emitted.emission || emitted.rescaled.is_some() {
            self.steering.change();
            dispatches += self.direct.run(encoder, timer, &self.frame_group, self.shadows.scene_group());
        }
        if !self.sources.sky_shines() && self.steering.has_faded() {
            self.steering.put_out();
            self.spaces.forget_bounced(encoder);
        }
        let gain = self.sources.cavity_gain(self.settings.wait);
        let products = self.steering.products(gain);
        let tag = (self.steering.version(), self.sources.unit());
        dispatches += self.bounce.run(encoder, timer, &self.coarse, products, tag);
        let moving = self.instances.any_moving();
        let probes_late = moving && !self.probes_current;
        if emitted.emission || emitted.rescaled.is_some() || probes_late {
            dispatches += self.gather.run(encoder, timer, &self.frame_group, Source::Emitted, moving);
        }
        if products > 0 || probes_late {
            dispatches += self.gather.run(encoder, timer, &self.frame_group, Source::Bounced, moving);
        }
        // What moves no longer may come back after the light has changed.
        self.probes_current = moving;
        Drawn { transport_dispatches: dispatches, products, ..Drawn::default() }
    }
}
