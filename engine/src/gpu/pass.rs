//! Bind groups, pipelines and dispatches, said shortly. Bindings are numbered in the order of their list.

use super::{Gpu, GpuError};

/// Threads of a compute workgroup, in every shader.
pub const GROUP: u32 = 64;

/// One binding of a layout.
#[derive(Clone, Copy, Debug)]
pub enum Binding {
    Uniform,
    /// A slot of a uniform buffer, chosen by a dynamic offset.
    UniformSlot,
    Read,
    Write,
    Picture,
    /// A picture that is read texel by texel.
    Texels,
    MultisampledTexels,
    DepthLayers,
    Cube,
    Cubes,
    Sampler,
    Comparison,
}

/// A layout whose bindings are all seen by these stages.
pub fn layout(
    gpu: &Gpu,
    label: &str,
    stages: wgpu::ShaderStages,
    bindings: &[Binding],
) -> wgpu::BindGroupLayout {
    let entries: Vec<_> = (0..)
        .zip(bindings)
        .map(|(binding, kind)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: stages,
            ty: binding_type(*kind),
            count: None,
        })
        .collect();
    gpu.device
        .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries: &entries })
}

fn binding_type(binding: Binding) -> wgpu::BindingType {
    let buffer =
        |ty, has_dynamic_offset| wgpu::BindingType::Buffer { ty, has_dynamic_offset, min_binding_size: None };
    let texture = |sample_type, view_dimension, multisampled| wgpu::BindingType::Texture {
        sample_type,
        view_dimension,
        multisampled,
    };
    let float = |filterable| wgpu::TextureSampleType::Float { filterable };
    let (d2, layers) = (wgpu::TextureViewDimension::D2, wgpu::TextureViewDimension::D2Array);
    match binding {
        Binding::Uniform => buffer(wgpu::BufferBindingType::Uniform, false),
        Binding::UniformSlot => buffer(wgpu::BufferBindingType::Uniform, true),
        Binding::Read => buffer(wgpu::BufferBindingType::Storage { read_only: true }, false),
        Binding::Write => buffer(wgpu::BufferBindingType::Storage { read_only: false }, false),
        Binding::Picture => texture(float(true), d2, false),
        Binding::Texels => texture(float(false), d2, false),
        Binding::MultisampledTexels => texture(float(false), d2, true),
        Binding::DepthLayers => texture(wgpu::TextureSampleType::Depth, layers, false),
        Binding::Cube => texture(float(true), wgpu::TextureViewDimension::Cube, false),
        Binding::Cubes => texture(float(true), wgpu::TextureViewDimension::CubeArray, false),
        Binding::Sampler => wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
        Binding::Comparison => wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Comparison),
    }
}

pub fn group(
    gpu: &Gpu,
    label: &str,
    layout: &wgpu::BindGroupLayout,
    resources: &[wgpu::BindingResource<'_>],
) -> wgpu::BindGroup {
    let entries: Vec<_> = (0..)
        .zip(resources)
        .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource: resource.clone() })
        .collect();
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor { label: Some(label), layout, entries: &entries })
}

/// A group of whole buffers.
pub fn buffers(
    gpu: &Gpu,
    label: &str,
    layout: &wgpu::BindGroupLayout,
    buffers: &[&wgpu::Buffer],
) -> wgpu::BindGroup {
    let resources: Vec<_> = buffers.iter().map(|buffer| buffer.as_entire_binding()).collect();
    group(gpu, label, layout, &resources)
}

/// Groups 0 view and time, 1 scene, 2 transport, 3 the pass's own; `None` where a pass has none.
pub type Groups<'a> = [Option<&'a wgpu::BindGroupLayout>];

pub fn pipeline_layout(gpu: &Gpu, groups: &Groups<'_>) -> wgpu::PipelineLayout {
    gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: None,
        bind_group_layouts: groups,
        immediate_size: 0,
    })
}

pub fn compute(
    gpu: &Gpu,
    module: &wgpu::ShaderModule,
    entry: &str,
    layout: &wgpu::PipelineLayout,
) -> wgpu::ComputePipeline {
    gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(entry),
        layout: Some(layout),
        module,
        entry_point: Some(entry),
        compilation_options: Default::default(),
        cache: None,
    })
}

/// Workgroups in x and y for this many groups: a dimension holds 65535. Shaders count
/// `id.y * groups.x + id.x`.
pub fn grid(groups: u32) -> (u32, u32) {
    const MOST: u32 = 65535;
    (groups.clamp(1, MOST), groups.div_ceil(MOST).max(1))
}

/// One thread an item.
pub fn dispatch(pass: &mut wgpu::ComputePass<'_>, items: u32) {
    let (x, y) = grid(items.div_ceil(GROUP));
    pass.dispatch_workgroups(x, y, 1);
}

/// What was drawn so far is there for what computes next. Graphics interfaces see to that by themselves; Mesa's software
/// OpenGL computes at once and draws later, and is waited for.
pub fn drawn_before_computed(gpu: &Gpu, encoder: &mut wgpu::CommandEncoder) {
    if !(gpu.software && gpu.info.backend == wgpu::Backend::Gl) {
        return;
    }
    let drawn = std::mem::replace(encoder, gpu.device.create_command_encoder(&Default::default()));
    gpu.queue.submit([drawn.finish()]);
    // An error is kept, and told at the end of the frame.
    let _ = gpu.device.poll(wgpu::PollType::wait_indefinitely());
}

/// Catches what the device says against everything made inside `make`.
pub fn checked<T>(gpu: &Gpu, make: impl FnOnce() -> T) -> Result<T, GpuError> {
    let scope = gpu.device.push_error_scope(wgpu::ErrorFilter::Validation);
    let made = make();
    match pollster::block_on(scope.pop()) {
        Some(error) => Err(GpuError::Reported(error.to_string())),
        None => Ok(made),
    }
}

/// A pipeline that draws one triangle over the whole of a picture: vertices `corner`, no depth.
pub fn over_picture(
    gpu: &Gpu,
    module: &wgpu::ShaderModule,
    entry: &str,
    layout: &wgpu::PipelineLayout,
    target: impl Into<wgpu::ColorTargetState>,
) -> wgpu::RenderPipeline {
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(entry),
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some("corner"),
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: Default::default(),
        depth_stencil: None,
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some(entry),
            compilation_options: Default::default(),
            targets: &[Some(target.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}

/// A pass that draws over a whole picture, whatever was there.
pub fn draw_into<'a>(
    encoder: &'a mut wgpu::CommandEncoder,
    label: &str,
    view: &wgpu::TextureView,
    timestamp_writes: Option<wgpu::RenderPassTimestampWrites<'_>>,
) -> wgpu::RenderPass<'a> {
    draw(encoder, label, view, wgpu::LoadOp::Clear(wgpu::Color::BLACK), timestamp_writes)
}

/// A pass that draws onto what is there.
pub fn draw_over<'a>(
    encoder: &'a mut wgpu::CommandEncoder,
    label: &str,
    view: &wgpu::TextureView,
    timestamp_writes: Option<wgpu::RenderPassTimestampWrites<'_>>,
) -> wgpu::RenderPass<'a> {
    draw(encoder, label, view, wgpu::LoadOp::Load, timestamp_writes)
}

fn draw<'a>(
    encoder: &'a mut wgpu::CommandEncoder,
    label: &str,
    view: &wgpu::TextureView,
    load: wgpu::LoadOp<wgpu::Color>,
    timestamp_writes: Option<wgpu::RenderPassTimestampWrites<'_>>,
) -> wgpu::RenderPass<'a> {
    let ops = wgpu::Operations { load, store: wgpu::StoreOp::Store };
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some(label),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view,
            depth_slice: None,
            resolve_target: None,
            ops,
        })],
        timestamp_writes,
        ..Default::default()
    })
}
