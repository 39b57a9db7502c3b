//! The light of moving objects: for each, nine coefficients blended of the light probes about the middle of its bounding
//! sphere ([`crate::transport::probe_field`]), for light seen directly and for light that bounced.

use std::collections::HashMap;
use std::sync::{Arc, OnceLock};

use super::channels::Channels;
use super::instances::Instances;
use super::shaders;
use super::spaces::Spaces;
use crate::gpu::Gpu;
use crate::gpu::buffer::{self, Held};
use crate::gpu::pass::{self, Binding};
use crate::gpu::pipeline::{Compiler, Compute};
use crate::gpu::timing::Timer;
use crate::scene::EntityId;
use crate::transport::Transport;
use crate::transport::probe_field::{Cell, ProbeField, Weights};

pub struct Objects {
    transport: Arc<Transport>,
    /// Once something moves.
    field: OnceLock<ProbeField>,
    /// Where each was in the last frame.
    cells: HashMap<EntityId, Cell>,
    /// One an instance.
    weights: Held<Weights>,
    /// Nine an instance.
    light: [wgpu::Buffer; 2],
    channels: Channels,
    pipeline: Compute,
    layout: wgpu::BindGroupLayout,
    group: wgpu::BindGroup,
    /// Holds the mean of all receivers.
    mean_probe: u32,
    changed: bool,
}

impl Objects {
    pub fn new(gpu: &Gpu, compiler: &Arc<Compiler>, transport: Arc<Transport>, spaces: &Spaces) -> Self {
        let compute = wgpu::ShaderStages::COMPUTE;
        let [read, write] = [Binding::Read, Binding::Write];
        let layout = pass::layout(gpu, "objects", compute, &[read, read, read, write, write]);
        let weights = Held::new(gpu, "objects", wgpu::BufferUsages::STORAGE);
        let channels = spaces.channels;
        let light = light_for(gpu, &weights, channels);
        Self {
            transport,
            field: OnceLock::new(),
            cells: HashMap::new(),
            pipeline: Compute::new(compiler, shaders::OBJECTS, &[None, None, Some(&layout)]),
            group: group(gpu, &layout, spaces, &weights, &light),
            weights,
            light,
            channels,
            layout,
            mean_probe: spaces.probe_count,
            changed: false,
        }
    }

    pub fn field(&self) -> &ProbeField {
        self.field.get_or_init(|| ProbeField::new(&self.transport))
    }

    /// The light of probes lies elsewhere. Whoever bound [`Self::light`] binds it anew where its channels are others.
    pub fn bind(&mut self, gpu: &Gpu, spaces: &Spaces) {
        if self.channels != spaces.channels {
            self.channels = spaces.channels;
            self.light = light_for(gpu, &self.weights, self.channels);
        }
        self.group = group(gpu, &self.layout, spaces, &self.weights, &self.light);
        self.changed = true;
    }

    /// Nine coefficients an instance: seen directly, and bounced.
    pub fn light(&self) -> &[wgpu::Buffer; 2] {
        &self.light
    }

    pub fn weights(&self) -> &[Weights] {
        self.weights.items()
    }

    /// Counts up when [`Self::light`] lies in new buffers.
    pub fn generation(&self) -> u64 {
        self.weights.generation
    }

    pub fn bytes(&self) -> u64 {
        let held = self.weights.buffer().size() + self.light.iter().map(wgpu::Buffer::size).sum::<u64>();
        if self.weights.items().is_empty() { 0 } else { held }
    }

    /// Follows what moves.
    pub fn update(&mut self, gpu: &Gpu, instances: &Instances, spaces: &Spaces) {
        let mean = Weights { probes: [self.mean_probe; 4], weights: [1.0, 0.0, 0.0, 0.0] };
        let mut cells = HashMap::with_capacity(self.cells.len());
        let field = |centre, cell: &mut Cell| self.field().weights(centre, cell);
        let weights: Vec<Weights> = instances
            .placed
            .iter()
            .map(|&(entity, centre)| {
                let cell =
                    cells.entry(entity).or_insert(self.cells.get(&entity).copied().unwrap_or_default());
                let weights = field(centre, cell);
                if weights.is_none() { mean } else { weights }
            })
            .collect();
        self.cells = cells;
        let generation = self.weights.generation;
        self.changed |= self.weights.write(gpu, &weights);
        if self.weights.generation != generation {
            self.light = light_for(gpu, &self.weights, self.channels);
            self.group = group(gpu, &self.layout, spaces, &self.weights, &self.light);
        }
    }

    /// Where weights or probes have changed. Returns the dispatches.
    pub fn run(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        timer: &mut Timer,
        probes_changed: bool,
    ) -> u32 {
        let count = self.weights.items().len() as u32;
        if count == 0 || !(std::mem::take(&mut self.changed) || probes_changed) {
            return 0;
        }
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("objects"),
            timestamp_writes: timer.compute("objects"),
        });
        if !self.pipeline.set(&mut pass, "objects_light", self.channels.defines()) {
            return 0;
        }
        pass.set_bind_group(2, &self.group, &[]);
        pass::dispatch(&mut pass, count * 9);
        1
    }
}

/// Room for as many objects as there is room for weights.
fn light_for(gpu: &Gpu, weights: &Held<Weights>, channels: Channels) -> [wgpu::Buffer; 2] {
    let objects = weights.buffer().size() / size_of::<Weights>() as u64;
    let bytes = objects * 9 * channels.stride();
    let light = |label| buffer::empty(gpu, label, bytes, wgpu::BufferUsages::STORAGE);
    [light("objects, direct"), light("objects, indirect")]
}

fn group(
    gpu: &Gpu,
    layout: &wgpu::BindGroupLayout,
    spaces: &Spaces,
    weights: &Held<Weights>,
    light: &[wgpu::Buffer; 2],
) -> wgpu::BindGroup {
    let [probes_direct, probes_indirect] = &spaces.probes;
    let buffers = [probes_direct, probes_indirect, weights.buffer(), &light[0], &light[1]];
    pass::buffers(gpu, "objects", layout, &buffers)
}
