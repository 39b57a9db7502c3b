//! Automatic exposure: a picture is metered by a histogram of log2 luminance, and the exposure goes towards what
//! makes its trimmed mean middle grey, e^(-speed t) of the way being left after t seconds (frame rates do not
//! matter).
//!
//! All of it stays on the GPU: what was metered is copied into the frame's uniform before the next pass reads it.
//! So is the *pre-exposure*: half floats hold radiance from 6e-8 to 65504, and a scene may be a thousand times
//! brighter, so radiance is drawn times the power of two that is nearest to the exposure. The tone curve takes it
//! off again.

use std::mem::offset_of;
use std::sync::Arc;
use std::time::Instant;

use bytemuck::{Pod, Zeroable};

use super::frame::FrameUniform;
use super::shaders;
use super::targets::Targets;
use crate::gpu::buffer::Readback;
use crate::gpu::pass::{self, Binding};
use crate::gpu::pipeline::{Compiler, Compute};
use crate::gpu::timing::Timer;
use crate::gpu::{Gpu, buffer};
use crate::scene::AutoExposure;

/// `Meter` in `exposure.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct MeterUniform {
    pub size: [u32; 2],
    /// Every so manieth texel of a row and of a column is looked at.
    pub step: u32,
    /// What is left of the difference to the last exposure.
    pub kept: f32,
    pub compensation: f32,
    pub least: f32,
    pub most: f32,
    pub padding: u32,
}

/// `Exposure` in `exposure.wgsl`: what the next picture is drawn with.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct ExposureState {
    /// log2 of `exposure`.
    pub stops: f32,
    /// Display = exposure * radiance.
    pub exposure: f32,
    pub pre_exposure: f32,
    pub padding: u32,
}

const BINS: u64 = 256;
/// About so many texels are looked at.
const LOOKED_AT: f32 = 65536.0;
/// Stops, up and down.
const MOST: f32 = 100.0;
/// By one thread, one after the other.
const A_THREAD: u32 = 16;

/// Display = this * radiance: a number, whatever the camera says.
pub fn exposure(stops: f32) -> f32 {
    stops.clamp(-MOST, MOST).exp2()
}

/// Radiance is drawn times this, where the exposure is known beforehand.
pub fn pre_exposure(stops: f32) -> f32 {
    exposure(stops.round())
}

pub struct Exposure {
    layout: [wgpu::BindGroupLayout; 2],
    /// For one sample a pixel, and for more.
    pipelines: Arc<[Compute; 2]>,
    meter: wgpu::Buffer,
    bins: wgpu::Buffer,
    state: wgpu::Buffer,
    group: Option<wgpu::BindGroup>,
    /// Of the last picture that was metered: its time and when it was drawn. `None`: the next one is the first.
    last: Option<(f64, Instant)>,
    readback: Readback<()>,
    sending: Option<usize>,
    /// What was metered last and has come back, for people to see.
    pub stops: Option<f32>,
}

impl Exposure {
    pub fn new(gpu: &Gpu, compiler: &Arc<Compiler>, frame_layout: &wgpu::BindGroupLayout) -> Self {
        let layout = [Binding::Texels, Binding::MultisampledTexels].map(|texels| {
            let bindings = [Binding::Uniform, Binding::Write, Binding::Write, texels];
            pass::layout(gpu, "exposure", wgpu::ShaderStages::COMPUTE, &bindings)
        });
        let pipelines = layout.each_ref().map(|layout| {
            let groups = [Some(frame_layout), None, None, Some(layout)];
            Compute::new(compiler, shaders::EXPOSURE, &groups)
        });
        Self::with(gpu, layout, Arc::new(pipelines))
    }

    /// The eye of another picture.
    pub fn another(&self, gpu: &Gpu) -> Self {
        Self::with(gpu, self.layout.clone(), self.pipelines.clone())
    }

    fn with(gpu: &Gpu, layout: [wgpu::BindGroupLayout; 2], pipelines: Arc<[Compute; 2]>) -> Self {
        let bytes = size_of::<ExposureState>() as u64;
        Self {
            pipelines,
            meter: buffer::filled(gpu, "meter", &[MeterUniform::zeroed()], wgpu::BufferUsages::UNIFORM),
            bins: buffer::empty(gpu, "exposure bins", BINS * 4, wgpu::BufferUsages::STORAGE),
            state: buffer::empty(gpu, "exposure", bytes, wgpu::BufferUsages::STORAGE),
            group: None,
            last: None,
            readback: Readback::new(gpu, bytes.max(64)),
            sending: None,
            stops: None,
            layout,
        }
    }

    /// Targets are others.
    pub fn bind(&mut self, gpu: &Gpu, targets: &Targets) {
        let resources = [
            self.meter.as_entire_binding(),
            self.bins.as_entire_binding(),
            self.state.as_entire_binding(),
            wgpu::BindingResource::TextureView(&targets.radiance_view),
        ];
        let layout = &self.layout[usize::from(targets.samples_read() > 1)];
        self.group = Some(pass::group(gpu, "exposure", layout, &resources));
    }

    /// The next picture is a first one: it is shown as if the eye had long been used to it.
    pub fn forget(&mut self) {
        self.last = None;
        self.stops = None;
    }

    /// Says how the picture at hand is to be metered, before any of the frame's commands run. `by_scene`: by the
    /// scene's time and not by the clock, so that pictures repeat. Returns whether it is the first.
    pub fn begin(
        &mut self,
        gpu: &Gpu,
        auto: &AutoExposure,
        size: [u32; 2],
        time: f64,
        by_scene: bool,
    ) -> bool {
        let seconds =
            self.last.map(|(last, drawn)| if by_scene { time - last } else { drawn.elapsed().as_secs_f64() });
        self.last = Some((time, Instant::now()));
        let texels = size[0] as f32 * size[1] as f32;
        let uniform = MeterUniform {
            size,
            step: (texels / LOOKED_AT).sqrt().ceil().max(1.0) as u32,
            kept: seconds.map_or(0.0, |seconds| kept(auto.speed, seconds)),
            compensation: auto.compensation.clamp(-MOST, MOST),
            least: auto.least.clamp(-MOST, MOST),
            most: auto.most.clamp(-MOST, MOST),
            padding: 0,
        };
        gpu.queue.write_buffer(&self.meter, 0, bytemuck::bytes_of(&uniform));
        if seconds.is_none() {
            let plain = ExposureState { stops: 0.0, exposure: 1.0, pre_exposure: 1.0, padding: 0 };
            gpu.queue.write_buffer(&self.state, 0, bytemuck::bytes_of(&plain));
        }
        seconds.is_none()
    }

    /// What is drawn from here on is drawn with this pre-exposure; lines, which are to look the same in any
    /// light, with the last exposure.
    pub fn set_pre_exposure(&self, encoder: &mut wgpu::CommandEncoder, frame: &wgpu::Buffer) {
        let from = offset_of!(ExposureState, pre_exposure) as u64;
        let to = offset_of!(FrameUniform, pre_exposure) as u64;
        encoder.copy_buffer_to_buffer(&self.state, from, frame, to, 4);
        self.set_exposure(encoder, frame);
    }

    fn set_exposure(&self, encoder: &mut wgpu::CommandEncoder, frame: &wgpu::Buffer) {
        let from = offset_of!(ExposureState, exposure) as u64;
        let to = offset_of!(FrameUniform, exposure) as u64;
        encoder.copy_buffer_to_buffer(&self.state, from, frame, to, 4);
    }

    /// Meters what is drawn; it is shown with this exposure.
    pub fn run(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        timer: &mut Timer,
        frame: (&wgpu::Buffer, &wgpu::BindGroup),
        targets: &Targets,
    ) {
        let Some(group) = &self.group else { return };
        let many = usize::from(targets.samples_read() > 1);
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("exposure"),
            timestamp_writes: timer.compute("exposure"),
        });
        pass.set_bind_group(0, frame.1, &[]);
        pass.set_bind_group(3, group, &[]);
        if self.pipelines[many].set(&mut pass, ["count", "count_samples"][many], &[]) {
            pass::dispatch(&mut pass, looked_at(targets.size).div_ceil(A_THREAD));
        }
        if self.pipelines[many].set(&mut pass, "adapt", &[]) {
            pass.dispatch_workgroups(1, 1, 1);
        }
        drop(pass);
        self.set_exposure(encoder, frame.0);
    }

    /// Sends what was metered on its way back, to be seen some frames later.
    pub fn report(&mut self, encoder: &mut wgpu::CommandEncoder) {
        if self.sending.is_none() {
            self.sending = self.readback.copy(encoder, &self.state, ());
        }
    }

    /// After the submit.
    pub fn sent(&mut self) {
        self.readback.send(self.sending.take());
    }

    /// Takes in what has come back.
    pub fn receive(&mut self) {
        if let Some((_, state)) = self.readback.receive::<f32>().pop() {
            self.stops = state.first().copied();
        }
    }
}

/// e^(-speed t), and nothing of what would be no number.
fn kept(speed: f32, seconds: f64) -> f32 {
    let kept = (-f64::from(speed) * seconds.max(0.0)).exp();
    if kept.is_finite() { kept as f32 } else { 0.0 }
}

/// Texels that a picture of this size is metered by.
fn looked_at(size: [u32; 2]) -> u32 {
    let step = (size[0] as f32 * size[1] as f32 / LOOKED_AT).sqrt().ceil().max(1.0) as u32;
    size[0].div_ceil(step) * size[1].div_ceil(step)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pre_exposure_is_a_power_of_two_near_the_exposure() {
        for (stops, found) in [(0.0, 1.0), (0.4, 1.0), (0.6, 2.0), (-23.2, 2f32.powi(-23)), (17.0, 131_072.0)]
        {
            assert_eq!(pre_exposure(stops), found);
        }
        assert!(pre_exposure(1e9).is_finite() && pre_exposure(-1e9) > 0.0);
    }

    #[test]
    fn adaptation_does_not_depend_on_the_frame_rate() {
        let (once, often) = (kept(2.0, 0.5), (0..50).map(|_| kept(2.0, 0.01)).product::<f32>());
        assert!((once - often).abs() < 1e-5, "{once} {often}");
        assert_eq!((kept(f32::INFINITY, 0.1), kept(f32::INFINITY, 0.0), kept(2.0, -1.0)), (0.0, 0.0, 1.0));
    }

    #[test]
    fn large_pictures_are_looked_at_in_parts() {
        assert_eq!(looked_at([64, 64]), 4096);
        for size in [[1280, 720], [3840, 2160], [1, 1], [32768, 1]] {
            assert!((1..=65536).contains(&looked_at(size)), "{size:?}");
        }
    }
}
