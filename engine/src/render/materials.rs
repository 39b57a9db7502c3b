//! Materials on the GPU: one small uniform and one bind group each, written where the material changed.

use std::collections::HashMap;
use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

use super::pictures::Pictures;
use crate::gpu::pass::{self, Binding};
use crate::gpu::texture::Encoding;
use crate::gpu::{Gpu, buffer};
use crate::scene::assets::{Assets, Picture};
use crate::scene::{Alpha, ImageSource, Material, MaterialId, Scene, Texture};

/// `Map` in `scene/material.wgsl`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct MapUniform {
    pub u: [f32; 4],
    pub v: [f32; 4],
}

/// `Material` in `scene/material.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct MaterialUniform {
    pub base: [f32; 4],
    pub emission: Vec3,
    pub metallic: f32,
    pub roughness: f32,
    pub normal_scale: f32,
    pub cutoff: f32,
    pub flags: u32,
    pub base_map: MapUniform,
    pub metal_map: MapUniform,
    pub normal_map: MapUniform,
    pub emission_map: MapUniform,
}

const MASK: u32 = 1;
const BLEND: u32 = 2;
const UNLIT: u32 = 4;
const DOUBLE_SIDED: u32 = 8;

/// Of a material's pictures.
const ENCODINGS: [Encoding; 4] = [Encoding::Srgb, Encoding::Linear, Encoding::Linear, Encoding::Srgb];

pub struct Materials {
    layout: wgpu::BindGroupLayout,
    known: HashMap<MaterialId, usize>,
    entries: Vec<Entry>,
}

struct Entry {
    material: Material,
    uniform: wgpu::Buffer,
    group: wgpu::BindGroup,
    /// What the group shows: a picture that comes later, or changes, is bound anew.
    shown: [Option<Arc<Picture>>; 4],
    /// Counts changes of where the surface has holes: shadows depend on it.
    holes: u64,
}

impl Materials {
    pub fn new(gpu: &Gpu, assets: &Assets, pictures: &mut Pictures) -> Self {
        use Binding::{Picture, Sampler, Uniform};
        let layout = pass::layout(
            gpu,
            "material",
            wgpu::ShaderStages::FRAGMENT,
            &[Uniform, Picture, Picture, Picture, Picture, Sampler, Sampler, Sampler, Sampler],
        );
        let plain = entry(gpu, &layout, assets, pictures, Material::default());
        Self { layout, known: HashMap::new(), entries: vec![plain] }
    }

    pub fn layout(&self) -> &wgpu::BindGroupLayout {
        &self.layout
    }

    /// Follows the scene. Returns whether a material differs from the last frame's.
    pub fn update(&mut self, gpu: &Gpu, assets: &Assets, pictures: &mut Pictures, scene: &Scene) -> bool {
        let before = self.known.len();
        self.known.retain(|&id, _| scene.material(id).is_some());
        let mut changed = self.known.len() != before;
        for material in &scene.materials {
            let Some(&index) = self.known.get(&material.id) else {
                if !pictures.has_time(assets, images(material)) {
                    continue;
                }
                self.known.insert(material.id, self.entries.len());
                self.entries.push(entry(gpu, &self.layout, assets, pictures, material.clone()));
                changed = true;
                continue;
            };
            let entry = &mut self.entries[index];
            let repainted = !same_pictures(&entry.shown, material, assets);
            if entry.material == *material && !repainted || !pictures.has_time(assets, images(material)) {
                continue;
            }
            changed = true;
            let holes_differ = holes_differ(&entry.material, material);
            entry.holes += u64::from(holes_differ || repainted && material.alpha != Alpha::Opaque);
            if repainted || textures(&entry.material) != textures(material) {
                entry.group = group(gpu, &self.layout, assets, pictures, material, &entry.uniform);
                entry.shown = shown(material, assets);
            }
            entry.material = material.clone();
            gpu.queue.write_buffer(&entry.uniform, 0, bytemuck::bytes_of(&uniform(material)));
        }
        changed
    }

    /// All but the plain one go.
    pub fn forget(&mut self) {
        self.known.clear();
        self.entries.truncate(1);
    }

    /// The place of a material; 0, a plain white one, where the scene has none of this id.
    pub fn index(&self, id: MaterialId) -> usize {
        self.known.get(&id).copied().unwrap_or(0)
    }

    pub fn material(&self, index: usize) -> &Material {
        &self.entries[index].material
    }

    pub fn group(&self, index: usize) -> &wgpu::BindGroup {
        &self.entries[index].group
    }

    pub fn holes(&self, index: usize) -> u64 {
        self.entries[index].holes
    }
}

fn entry(
    gpu: &Gpu,
    layout: &wgpu::BindGroupLayout,
    assets: &Assets,
    pictures: &mut Pictures,
    material: Material,
) -> Entry {
    let usage = wgpu::BufferUsages::UNIFORM;
    let uniform = buffer::filled(gpu, "material", &[uniform(&material)], usage);
    let group = group(gpu, layout, assets, pictures, &material, &uniform);
    let shown = shown(&material, assets);
    Entry { material, uniform, group, shown, holes: 0 }
}

fn shown(material: &Material, assets: &Assets) -> [Option<Arc<Picture>>; 4] {
    textures(material).map(|texture| assets.images.get(&texture?.image).cloned())
}

fn images(material: &Material) -> impl Iterator<Item = (ImageSource, Encoding)> {
    let images = textures(material).into_iter().zip(ENCODINGS);
    images.filter_map(|(texture, encoding)| Some((texture?.image.clone(), encoding)))
}

fn same_pictures(shown: &[Option<Arc<Picture>>; 4], material: &Material, assets: &Assets) -> bool {
    let pairs = shown.iter().zip(textures(material));
    pairs.into_iter().all(|(shown, texture)| {
        let now = texture.and_then(|texture| assets.images.get(&texture.image));
        shown.as_ref().map(Arc::as_ptr) == now.map(Arc::as_ptr)
    })
}

fn textures(material: &Material) -> [Option<&Texture>; 4] {
    [
        material.albedo.texture.as_ref(),
        material.metallic_roughness_texture.as_ref(),
        material.normal_texture.as_ref(),
        material.emission.texture.as_ref(),
    ]
}

fn holes_differ(a: &Material, b: &Material) -> bool {
    a.alpha != b.alpha || a.opacity != b.opacity || a.albedo.texture != b.albedo.texture
}

fn group(
    gpu: &Gpu,
    layout: &wgpu::BindGroupLayout,
    assets: &Assets,
    pictures: &mut Pictures,
    material: &Material,
    uniform: &wgpu::Buffer,
) -> wgpu::BindGroup {
    let textures = textures(material);
    let views: Vec<_> = textures
        .iter()
        .zip(ENCODINGS)
        .map(|(texture, encoding)| {
            pictures.view(gpu, assets, texture.map(|texture| &texture.image), encoding)
        })
        .collect();
    let samplers: Vec<_> = textures.iter().map(|texture| pictures.sampler(gpu, *texture)).collect();
    let mut resources = vec![uniform.as_entire_binding()];
    resources.extend(views.iter().map(wgpu::BindingResource::TextureView));
    resources.extend(samplers.iter().map(wgpu::BindingResource::Sampler));
    pass::group(gpu, "material", layout, &resources)
}

fn uniform(material: &Material) -> MaterialUniform {
    let (alpha, cutoff) = match material.alpha {
        Alpha::Opaque => (0, 0.0),
        Alpha::Mask { cutoff } => (MASK, cutoff),
        Alpha::Blend => (BLEND, 0.0),
    };
    let [base_map, metal_map, normal_map, emission_map] = textures(material).map(map);
    MaterialUniform {
        base: material.albedo.color.extend(material.opacity).to_array(),
        emission: material.emission.radiance(),
        metallic: material.metallic,
        roughness: material.roughness,
        normal_scale: material.normal_scale,
        cutoff,
        flags: alpha
            | if material.unlit { UNLIT } else { 0 }
            | if material.double_sided { DOUBLE_SIDED } else { 0 },
        base_map,
        metal_map,
        normal_map,
        emission_map,
    }
}

/// [`Texture::picture_from_uv`] as two rows.
fn map(texture: Option<&Texture>) -> MapUniform {
    let Some(texture) = texture else { return MapUniform::default() };
    let (sin, cos) = texture.rotation.sin_cos();
    let (scale, offset) = (texture.scale, texture.offset);
    MapUniform {
        u: [cos * scale.x, sin * scale.y, offset.x, f32::from(texture.uv_set.min(1))],
        v: [-sin * scale.x, cos * scale.y, offset.y, 1.0],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::ImageSource;
    use glam::Vec2;

    #[test]
    fn the_map_is_the_textures_own_transform() {
        let mut texture = Texture::new(ImageSource { file: String::new(), image: None });
        texture.rotation = 0.7;
        texture.scale = Vec2::new(2.0, -3.0);
        texture.offset = Vec2::new(0.1, 0.4);
        let map = map(Some(&texture));
        let uv = Vec2::new(0.3, 0.9);
        let row = |row: [f32; 4]| row[0] * uv.x + row[1] * uv.y + row[2];
        let ours = Vec2::new(row(map.u), row(map.v));
        assert!(ours.abs_diff_eq(texture.picture_from_uv(uv), 1e-6));
    }
}
