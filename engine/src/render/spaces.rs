//! The light on its spaces: one vector of four floats (rgb and nothing) a patch, receiver or probe coefficient; or one
//! float, where light has one channel ([`super::channels`]).
//! Columns are patches, then sky patches, which hold pi times their radiance. Columns are in units of 2^k W/m2
//! ([`super::unit`]), receivers and probes in W/m2.

use glam::Vec3;
use wgpu::BufferUsages as Usage;

use super::channels::Channels;
use crate::gpu::{Gpu, GpuError, buffer};
use crate::transport::sh;
use crate::transport::{Patch, Transport};

/// A binding begins at a multiple of so many bytes.
const ALIGNED: u64 = 256;
/// Of a probe.
const COEFFICIENTS: u64 = sh::COEFFICIENTS as u64;

/// All buffers of light, and the patches that it lives on.
pub struct Spaces {
    pub patch_count: u32,
    pub sample_count: u32,
    pub receiver_count: u32,
    /// Of valid receivers.
    pub valid_receivers: u32,
    pub probe_count: u32,
    /// Of all light here.
    pub channels: Channels,
    /// Where directional terms begin behind the receivers; 0 where there are none.
    pub directional: u32,
    pub patches: wgpu::Buffer,
    pub samples: wgpu::Buffer,
    /// By patch.
    pub albedo: wgpu::Buffer,
    /// By column: what patches emit and what the sky sends [W/m2].
    pub emitted: wgpu::Buffer,
    /// By patch: emitted and reflected once from punctual lights.
    pub exitance: wgpu::Buffer,
    /// By column: B.
    pub radiosity: wgpu::Buffer,
    /// By patch: B after the product at hand.
    pub next: wgpu::Buffer,
    /// By column: B without what is emitted; the sky's is 0.
    pub bounced: wgpu::Buffer,
    /// By receiver: irradiance from `emitted`, and from `bounced`. Behind them, from `directional` on, the directional
    /// terms of the first of them, three each.
    pub receivers: [wgpu::Buffer; 2],
    /// Nine a probe, and nine more for where no probe is: likewise. Nothing while nobody reads them.
    pub probes: [wgpu::Buffer; 2],
    has_probes: bool,
    /// Of light.
    pub bytes: u64,
    /// Of the patches that it lives on, with their samples.
    pub patch_bytes: u64,
}

impl Spaces {
    pub fn new(gpu: &Gpu, transport: &Transport, channels: Channels) -> Result<Self, GpuError> {
        // Where light was solved at the bake, it does not move: only what is read is there.
        let stride = channels.stride();
        let moves = u64::from(transport.solved.is_none());
        let (patches, receivers) = (transport.patches.len() as u64 * moves, transport.receivers.len() as u64);
        let (columns, probes) = (transport.columns() as u64 * moves, transport.probes.len() as u64);
        let terms = transport.directional_terms() as u64;
        let directional = if terms > 0 { receivers.next_multiple_of(ALIGNED / stride) } else { 0 };
        let receivers_and_terms = if terms > 0 { directional + terms } else { receivers };
        let samples = &transport.samples;
        let of_patches = patches * size_of::<Patch>() as u64;
        let of_samples = size_of_val(samples.as_slice()) as u64;
        let sizes = [
            ("patches", of_patches),
            ("sky", columns * stride),
            ("samples", of_samples),
            ("receivers", receivers_and_terms * stride),
            ("probes", (probes + 1) * COEFFICIENTS * stride),
        ];
        for (what, bytes) in sizes {
            gpu.fits(what, bytes)?;
        }
        let light = |label, count: u64| buffer::empty(gpu, label, count * stride, Usage::STORAGE);
        let both = |label, count: u64| [light(label, count), light(label, count)];
        Ok(Self {
            patch_count: patches as u32,
            sample_count: samples.len() as u32,
            receiver_count: receivers as u32,
            valid_receivers: transport.receivers.iter().filter(|receiver| receiver.valid > 0.5).count()
                as u32,
            probe_count: probes as u32,
            channels,
            patches: buffer::filled(gpu, "patches", &transport.patches[..patches as usize], Usage::STORAGE),
            samples: buffer::filled(gpu, "samples", samples, Usage::STORAGE),
            albedo: light("albedo", patches),
            emitted: light("emitted", columns),
            exitance: light("exitance", patches),
            radiosity: light("radiosity", columns),
            next: light("next", patches),
            bounced: light("bounced", columns),
            directional: directional as u32,
            receivers: both("receivers", receivers_and_terms),
            probes: both("probes", 0),
            has_probes: false,
            bytes: (3 * patches + 3 * columns + 2 * receivers_and_terms) * stride,
            patch_bytes: of_patches + of_samples,
        })
    }

    /// Whether there is light of probes.
    pub fn has_probes(&self) -> bool {
        self.has_probes
    }

    /// Makes room for the light of probes, or gives it back.
    pub fn hold_probes(&mut self, gpu: &Gpu, held: bool) {
        self.has_probes = held;
        let bytes = self.probe_bytes() / 2;
        self.probes = [0, 1].map(|_| buffer::empty(gpu, "probes", bytes, Usage::STORAGE));
    }

    /// Bytes of the light of probes.
    pub fn probe_bytes(&self) -> u64 {
        let probes = if self.has_probes { u64::from(self.probe_count) + 1 } else { 0 };
        probes * 2 * COEFFICIENTS * self.channels.stride()
    }

    /// No light anywhere.
    pub fn darken(&self, encoder: &mut wgpu::CommandEncoder) {
        let columns = [&self.exitance, &self.radiosity, &self.next, &self.bounced];
        for buffer in columns.into_iter().chain(&self.receivers).chain(&self.probes) {
            encoder.clear_buffer(buffer, 0, None);
        }
    }

    /// No light that bounced.
    pub fn forget_bounced(&self, encoder: &mut wgpu::CommandEncoder) {
        // Behind the patches lies the sky.
        encoder.clear_buffer(
            &self.radiosity,
            0,
            Some(u64::from(self.patch_count.max(1)) * self.channels.stride()),
        );
        for buffer in [&self.bounced, &self.receivers[1], &self.probes[1]] {
            encoder.clear_buffer(buffer, 0, None);
        }
    }

    /// B = E: what patches emit, and nothing that bounced.
    pub fn reflect_nothing(&self, encoder: &mut wgpu::CommandEncoder) {
        self.forget_bounced(encoder);
        if self.patch_count > 0 {
            let bytes = u64::from(self.patch_count) * self.channels.stride();
            encoder.copy_buffer_to_buffer(&self.exitance, 0, &self.radiosity, 0, bytes);
        }
    }

    /// What was solved elsewhere [W/m2]; nothing is dark.
    pub fn fill(&self, gpu: &Gpu, buffer: &wgpu::Buffer, light: &[Vec3]) {
        let room = (buffer.size() / self.channels.stride()) as usize;
        let dark = vec![Vec3::ZERO; room];
        self.write(gpu, buffer, 0, if light.is_empty() { &dark } else { &light[..light.len().min(room)] });
    }

    /// The same for receivers, with the directional terms of the first ones, from emitted light or from what bounced.
    pub fn fill_receivers(&self, gpu: &Gpu, which: usize, light: &[Vec3], terms: &[Vec3]) {
        let buffer = &self.receivers[which];
        let mut all = vec![Vec3::ZERO; (buffer.size() / self.channels.stride()) as usize];
        all.iter_mut().zip(light).for_each(|(into, light)| *into = *light);
        let behind = all.iter_mut().skip(self.directional as usize);
        behind.zip(terms).for_each(|(into, term)| *into = *term);
        self.write(gpu, buffer, 0, &all);
    }

    pub fn set_albedo(&self, gpu: &Gpu, albedo: &[Vec3]) {
        self.write(gpu, &self.albedo, 0, albedo);
    }

    /// Emitted exitance M of each patch [W/m2], stored in the unit.
    pub fn set_emission(&self, gpu: &Gpu, exitance: &[Vec3], unit: f32) {
        let columns: Vec<Vec3> = exitance.iter().map(|exitance| *exitance / unit).collect();
        self.write(gpu, &self.emitted, 0, &columns);
    }

    /// Radiance of each sky patch [W/m2/sr], stored in the unit.
    pub fn set_sky(&self, gpu: &Gpu, radiance: &[Vec3], unit: f32) {
        let columns: Vec<Vec3> =
            radiance.iter().map(|radiance| *radiance / unit * std::f32::consts::PI).collect();
        self.write(gpu, &self.emitted, u64::from(self.patch_count), &columns);
        self.write(gpu, &self.radiosity, u64::from(self.patch_count), &columns);
    }

    fn write(&self, gpu: &Gpu, buffer: &wgpu::Buffer, first: u64, light: &[Vec3]) {
        let bytes = self.channels.bytes_of(light.iter().copied());
        gpu.queue.write_buffer(buffer, first * self.channels.stride(), &bytes);
    }
}
