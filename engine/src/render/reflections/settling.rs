//! Whether captures still change: the harmonics of a cubemap against those of the capture before, read back without
//! a stall.

use glam::Vec4;

use super::schedule::Seen;
use crate::gpu::Gpu;
use crate::gpu::buffer::Readback;

/// Of a cubemap's largest coefficient: less is no change.
const TOLERANCE: f32 = 2e-4;

pub struct Settling {
    /// Probes that were captured, and what each saw.
    readback: Readback<Vec<(usize, Seen)>>,
    sending: Option<usize>,
    /// By probe: what its last capture came to.
    last: Vec<Option<[Vec4; 9]>>,
}

impl Settling {
    pub fn new(gpu: &Gpu, cubes: u32) -> Self {
        let readback = Readback::new(gpu, (u64::from(cubes) * 144).max(256));
        Self { readback, sending: None, last: vec![None; cubes as usize] }
    }

    pub fn copy(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        harmonics: &wgpu::Buffer,
        tag: Vec<(usize, Seen)>,
    ) {
        self.sending = self.readback.copy(encoder, harmonics, tag);
    }

    /// After the submit.
    pub fn sent(&mut self) {
        self.readback.send(self.sending.take());
    }

    /// Probes whose last two captures are the same, with what they saw.
    pub fn settled(&mut self) -> Vec<(usize, Seen)> {
        let mut settled = Vec::new();
        for (probes, harmonics) in self.readback.receive::<Vec4>() {
            for (probe, seen) in probes {
                // Cubemap 0 is the sky's.
                let found = harmonics.get((probe + 1) * 9..).and_then(|rest| rest.first_chunk::<9>());
                let (Some(found), Some(last)) = (found, self.last.get_mut(probe)) else { continue };
                if last.replace(*found).is_some_and(|last| same(&last, found)) {
                    settled.push((probe, seen));
                }
            }
        }
        settled
    }
}

fn same(a: &[Vec4; 9], b: &[Vec4; 9]) -> bool {
    let largest = b.iter().map(|b| b.abs().max_element()).fold(0.0, f32::max);
    a.iter().zip(b).all(|(a, b)| (*a - *b).abs().max_element() <= TOLERANCE * largest)
}
