//! Light that was solved at the bake ([`crate::transport::solved`]): responses are added up where the intensity of a
//! source has changed, and uploaded. No row, no product, no gather.

use std::cell::OnceCell;

use super::channels::is_grey;
use super::drawn::Drawn;
use super::frame::Renderer;
use super::gather::Source;
use super::spaces::Spaces;
use crate::gpu::Gpu;
use crate::scene::Scene;
use crate::transport::Solved;
use crate::transport::solved::Spread;

#[derive(Default)]
pub struct Responses {
    /// Intensities of all sources, as they were added up last.
    scale: Option<Vec<f32>>,
    pub spread: Spread,
    /// Whether none has a colour, once somebody has asked.
    grey: OnceCell<bool>,
}

impl Responses {
    /// Returns whether the light is another one now.
    fn follow(&mut self, solved: &Solved, scene: &Scene) -> bool {
        let scale = solved.scale(scene);
        if self.scale.as_ref() == Some(&scale) {
            return false;
        }
        self.spread = solved.combine(&scale);
        self.scale = Some(scale);
        true
    }

    /// They are all uploaded anew.
    pub fn forget(&mut self) {
        self.scale = None;
    }

    /// Whether no source gives light of a colour, however bright it is.
    pub fn is_grey(&self, solved: &Solved) -> bool {
        let grey = |spread: &Spread| spread.arrays().into_iter().flatten().all(is_grey);
        *self.grey.get_or_init(|| solved.responses.iter().all(|response| grey(&response.spread)))
    }

    fn upload(&self, gpu: &Gpu, spaces: &Spaces, probes_read: bool) {
        let Spread { receivers, probes, directional, .. } = &self.spread;
        for (which, (light, terms)) in receivers.iter().zip(directional).enumerate() {
            spaces.fill_receivers(gpu, which, light, terms);
        }
        if probes_read {
            spaces.probes.iter().zip(probes).for_each(|(buffer, light)| spaces.fill(gpu, buffer, light));
        }
    }

    /// The largest radiosity or irradiance [W/m2].
    pub fn brightest(&self) -> f32 {
        let [direct, bounced] = &self.spread.receivers;
        let all = self.spread.radiosity.iter().chain(direct).chain(bounced);
        all.map(|light| light.max_element()).fold(0.0, f32::max)
    }
}

impl Renderer {
    /// Whether light was solved at the bake.
    pub fn is_solved_for(&self) -> bool {
        self.transport.solved.is_some()
    }

    /// Light where all of it was solved at the bake, and whether it is another one than in the last frame.
    pub(super) fn responded(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        solved: &Solved,
        scene: &Scene,
        probes_read: bool,
    ) -> (Drawn, bool) {
        let changed = self.responses.follow(solved, scene);
        let probes_late = probes_read && !self.probes_current;
        if changed || probes_late {
            self.responses.upload(&self.gpu, &self.spaces, probes_read);
        }
        self.probes_current = probes_read;
        let gathered = probes_read && (changed || probes_late);
        let mut dispatches = 0;
        if gathered {
            dispatches += self.gather.mean_of_receivers(encoder, &mut self.timer);
            for source in [Source::Emitted, Source::Bounced] {
                dispatches += self.dering.run(encoder, &mut self.timer, source);
            }
        }
        dispatches += self.objects.run(encoder, &mut self.timer, gathered);
        (Drawn { transport_dispatches: dispatches, ..Drawn::default() }, changed)
    }
}
