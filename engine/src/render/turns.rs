//! Several pictures of one scene, drawn in turn: what belongs to one of them alone is put aside while another is drawn.
//! Each has targets of its own size, so that none are made anew from picture to picture, and an eye of its own that
//! adapts to what it sees.

use std::collections::HashMap;

use super::exposure::Exposure;
use super::frame::Renderer;
use super::targets::Targets;

/// What one picture has for itself.
pub struct Own {
    target: Option<(Targets, wgpu::BindGroup)>,
    exposure: Exposure,
    mask: Option<(wgpu::Texture, wgpu::BindGroup)>,
}

#[derive(Default)]
pub struct Turns {
    now: u32,
    aside: HashMap<u32, Own>,
}

impl Turns {
    /// Of targets that wait.
    pub fn bytes(&self) -> u64 {
        self.aside.values().filter_map(|own| own.target.as_ref()).map(|(targets, _)| targets.bytes()).sum()
    }
}

impl Renderer {
    /// What is drawn next is this picture, until another is turned to. Without a word it is picture 0.
    pub fn turn_to(&mut self, picture: u32) {
        if picture == self.turns.now {
            return;
        }
        let next = self.turns.aside.remove(&picture).unwrap_or_else(|| Own {
            target: None,
            exposure: self.exposure.another(&self.gpu),
            mask: None,
        });
        let last = Own {
            target: std::mem::replace(&mut self.target, next.target),
            exposure: std::mem::replace(&mut self.exposure, next.exposure),
            mask: std::mem::replace(&mut self.outline.mask, next.mask),
        };
        self.turns.aside.insert(std::mem::replace(&mut self.turns.now, picture), last);
    }
}
