//! A reflection probe's camera: six faces of a quarter turn each, seen as a cubemap is read, which is mirrored.

use glam::Vec3;

use super::super::frame::FrameUniform;
use super::super::sky::SkyPass;
use super::super::surface::{Look, Scenery, Surfaces, Which};
use super::super::view::{perspective, view_from_world};
use crate::gpu::timing::Timer;
use crate::gpu::{Gpu, buffer, pass, texture};
use crate::transport::reflection::cube::FACES;

/// What faces are drawn with and into.
pub struct Set<'a> {
    pub gpu: &'a Gpu,
    pub timer: &'a mut Timer,
    pub surfaces: &'a mut Surfaces,
    pub sky: &'a mut SkyPass,
    pub scenery: &'a Scenery<'a>,
    /// What all faces of a frame share.
    pub frame: FrameUniform,
    /// The largest radiosity [W/m2].
    pub brightest: f32,
}

/// Uniforms of the faces that are taken in one frame.
pub struct Views {
    layout: wgpu::BindGroupLayout,
    pool: Vec<(wgpu::Buffer, wgpu::BindGroup)>,
    used: usize,
}

impl Views {
    pub fn new(frame_layout: &wgpu::BindGroupLayout) -> Self {
        Self { layout: frame_layout.clone(), pool: Vec::new(), used: 0 }
    }

    /// A new frame begins.
    pub fn clear(&mut self) {
        self.used = 0;
    }

    fn take(&mut self, gpu: &Gpu, uniform: &FrameUniform) -> &wgpu::BindGroup {
        if self.used == self.pool.len() {
            let made = buffer::filled(gpu, "capture", &[*uniform], wgpu::BufferUsages::UNIFORM);
            let group = pass::buffers(gpu, "capture", &self.layout, &[&made]);
            self.pool.push((made, group));
        }
        let (held, group) = &self.pool[self.used];
        gpu.queue.write_buffer(held, 0, bytemuck::bytes_of(uniform));
        self.used += 1;
        group
    }
}

/// Depth of one face, and what static surfaces alone look like, once that is worth keeping.
pub struct Room {
    depth: wgpu::Texture,
    depth_view: wgpu::TextureView,
    still: Option<Still>,
}

struct Still {
    color: wgpu::Texture,
    depth: wgpu::Texture,
    /// By face.
    drawn: [bool; 6],
}

/// What a face shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shown {
    All,
    /// Static surfaces and sky: what is baked.
    Still,
    Sky,
    /// Static surfaces as they were kept, everything that moves on top.
    MovingOnTop,
}

impl Room {
    pub fn new(gpu: &Gpu, size: u32) -> Self {
        let depth = depth(gpu, size, 1);
        Self { depth_view: texture::layer(&depth, 0), depth, still: None }
    }

    pub fn bytes(&self) -> u64 {
        let texels = u64::from(self.depth.width()) * u64::from(self.depth.height());
        texels * if self.still.is_some() { 4 + 6 * 12 } else { 4 }
    }

    /// Static surfaces look otherwise now.
    pub fn forget(&mut self) {
        if let Some(still) = &mut self.still {
            still.drawn = [false; 6];
        }
    }

    /// Takes one face of a cubemap at `position` into `color`. Returns the draws.
    #[allow(clippy::too_many_arguments)] // one capture, told in full
    pub fn take(
        &mut self,
        set: &mut Set<'_>,
        views: &mut Views,
        encoder: &mut wgpu::CommandEncoder,
        face: usize,
        (position, near): (Vec3, f32),
        into: (&wgpu::Texture, &wgpu::TextureView),
        shown: Shown,
    ) -> u32 {
        let uniform = face_uniform(&set.frame, face, position, near);
        let group = views.take(set.gpu, &uniform).clone();
        let look = Look {
            frame: &group,
            clip_from_world: uniform.clip_from_world,
            eye: position,
            samples: 1,
            mirrored: true,
        };
        let mut drawer = Drawer { set, encoder, look: &look };
        let mut all =
            |still, moving| drawer.draw(into.1, &self.depth_view, Layers { still, moving, keep: false });
        match shown {
            Shown::All => all(true, true),
            Shown::Still => all(true, false),
            Shown::Sky => all(false, false),
            Shown::MovingOnTop => {
                let still = self.still.get_or_insert_with(|| Still::new(drawer.set.gpu, into.0.width()));
                let mut draws = 0;
                if !still.drawn[face] {
                    still.drawn[face] = true;
                    let (color, depth) = still.views(face);
                    draws += drawer.draw(&color, &depth, Layers { still: true, moving: false, keep: false });
                }
                still.copy(drawer.encoder, face, into.0, &self.depth);
                draws
                    + drawer.draw(into.1, &self.depth_view, Layers { still: false, moving: true, keep: true })
            }
        }
    }
}

impl Still {
    fn new(gpu: &Gpu, size: u32) -> Self {
        Self {
            color: texture::cubes(gpu, "static capture", size, 1, 1),
            depth: depth(gpu, size, 6),
            drawn: [false; 6],
        }
    }

    fn views(&self, face: usize) -> (wgpu::TextureView, wgpu::TextureView) {
        (texture::layer(&self.color, face as u32), texture::layer(&self.depth, face as u32))
    }

    fn copy(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        face: usize,
        color: &wgpu::Texture,
        depth: &wgpu::Texture,
    ) {
        let size = wgpu::Extent3d { width: color.width(), height: color.height(), depth_or_array_layers: 1 };
        let layer = |texture, layer| wgpu::TexelCopyTextureInfo {
            texture,
            mip_level: 0,
            origin: wgpu::Origin3d { x: 0, y: 0, z: layer },
            aspect: wgpu::TextureAspect::All,
        };
        encoder.copy_texture_to_texture(layer(&self.color, face as u32), layer(color, face as u32), size);
        encoder.copy_texture_to_texture(layer(&self.depth, face as u32), layer(depth, 0), size);
    }
}

/// Which surfaces are drawn, and whether onto what is there.
#[derive(Clone, Copy)]
struct Layers {
    still: bool,
    moving: bool,
    keep: bool,
}

struct Drawer<'a, 'b> {
    set: &'a mut Set<'b>,
    encoder: &'a mut wgpu::CommandEncoder,
    look: &'a Look<'a>,
}

impl Drawer<'_, '_> {
    fn draw(&mut self, color: &wgpu::TextureView, depth: &wgpu::TextureView, layers: Layers) -> u32 {
        let Set { timer, surfaces, sky, scenery, .. } = self.set;
        let mut pass = begin(self.encoder, color, depth, layers.keep, timer.render("capture"));
        let Layers { still, moving, keep } = layers;
        let mut draws = surfaces.draw(&mut pass, scenery, self.look, Which { blended: false, still, moving });
        if !keep {
            draws += sky.draw(&mut pass, self.look.frame, 1);
        }
        draws + surfaces.draw(&mut pass, scenery, self.look, Which { blended: true, still, moving })
    }
}

fn face_uniform(shared: &FrameUniform, face: usize, position: Vec3, near: f32) -> FrameUniform {
    let [forward, right, up] = FACES[face];
    let view = view_from_world(position, [right, up, -forward]);
    FrameUniform {
        clip_from_world: perspective(1.0, 1.0, near, None) * view,
        eye: position.extend(1.0),
        forward,
        right,
        up,
        ..*shared
    }
}

fn depth(gpu: &Gpu, size: u32, layers: u32) -> wgpu::Texture {
    texture::copied_depth(gpu, "capture depth", size, layers)
}

fn begin<'a>(
    encoder: &'a mut wgpu::CommandEncoder,
    color: &wgpu::TextureView,
    depth: &wgpu::TextureView,
    keep: bool,
    timestamp_writes: Option<wgpu::RenderPassTimestampWrites<'_>>,
) -> wgpu::RenderPass<'a> {
    let store = wgpu::StoreOp::Store;
    let load = if keep { wgpu::LoadOp::Load } else { wgpu::LoadOp::Clear(wgpu::Color::BLACK) };
    let load_depth = if keep { wgpu::LoadOp::Load } else { wgpu::LoadOp::Clear(0.0) };
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("capture"),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: color,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load, store },
        })],
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: depth,
            depth_ops: Some(wgpu::Operations { load: load_depth, store }),
            stencil_ops: None,
        }),
        timestamp_writes,
        ..Default::default()
    })
}
