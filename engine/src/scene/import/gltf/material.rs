//! Materials, textures and samplers.

use std::path::Path;

use glam::{Vec2, Vec3};

use super::Gltf;
use super::json::{self, MetallicRoughness, Sampler, TextureInfo, TextureTransform, extension, get};
use crate::scene::import::path::{Reference, resolve};
use crate::scene::material::Wrap;
use crate::scene::{Albedo, Alpha, Emission, ImageSource, Material, MaterialId, Texture, Warning};

/// All materials of the file; the id is the index.
pub fn materials(project: &Path, gltf: &Gltf, warnings: &mut Vec<Warning>) -> Result<Vec<Material>, String> {
    let mut materials = Vec::with_capacity(gltf.root.materials.len());
    for (n, authored) in gltf.root.materials.iter().enumerate() {
        let name = authored.name.clone().unwrap_or_else(|| format!("material {n}"));
        let mut lost = Vec::new();
        let made = material(project, gltf, authored, &mut lost)
            .map_err(|message| format!("material {n} `{name}`: {message}"))?;
        let about_this = |message| Warning::new(&gltf.file, format!("material {n} `{name}`: {message}"));
        warnings.extend(lost.into_iter().map(about_this));
        materials.push(Material { id: MaterialId(n as u32), name: name.clone(), ..made });
    }
    Ok(materials)
}

/// What a primitive without a material is drawn with.
pub fn default_material(id: MaterialId) -> Material {
    Material { id, name: "default".to_owned(), metallic: 1.0, ..Material::default() }
}

fn material(
    project: &Path,
    gltf: &Gltf,
    authored: &json::Material,
    lost: &mut Vec<String>,
) -> Result<Material, String> {
    let glossy = specular_glossiness(authored)?;
    let pbr = glossy.as_ref().unwrap_or(&authored.pbr_metallic_roughness);
    let [r, g, b, a] = pbr.base_color_factor;
    let mut texture = |info: &Option<TextureInfo>| match info {
        Some(info) => texture(project, gltf, info, lost),
        None => Ok(None),
    };
    let alpha = match authored.alpha_mode.as_deref() {
        Some("MASK") => Alpha::Mask { cutoff: authored.alpha_cutoff.unwrap_or(0.5) },
        Some("BLEND") => Alpha::Blend,
        _ => Alpha::Opaque,
    };
    Ok(Material {
        albedo: Albedo {
            color: Vec3::new(r, g, b),
            texture: texture(&pbr.base_color_texture)?,
            ..Albedo::default()
        },
        metallic: pbr.metallic_factor,
        roughness: pbr.roughness_factor,
        metallic_roughness_texture: texture(&pbr.metallic_roughness_texture)?,
        normal_texture: texture(&authored.normal_texture)?,
        normal_scale: authored.normal_texture.as_ref().and_then(|info| info.scale).unwrap_or(1.0),
        emission: emission(authored, texture(&authored.emissive_texture)?)?,
        alpha,
        opacity: if alpha == Alpha::Opaque { 1.0 } else { a },
        double_sided: authored.double_sided,
        unlit: authored.extensions.contains_key("KHR_materials_unlit"),
        ..Material::default()
    })
}

/// The older model's diffuse part is ours; its coloured mirror is not.
fn specular_glossiness(authored: &json::Material) -> Result<Option<MetallicRoughness>, String> {
    const NAME: &str = "KHR_materials_pbrSpecularGlossiness";
    let Some(found): Option<json::SpecularGlossiness> = extension(&authored.extensions, NAME)? else {
        return Ok(None);
    };
    Ok(Some(MetallicRoughness {
        base_color_factor: found.diffuse_factor.unwrap_or([1.0; 4]),
        base_color_texture: found.diffuse_texture,
        metallic_factor: 0.0,
        roughness_factor: 1.0 - found.glossiness_factor.unwrap_or(1.0),
        metallic_roughness_texture: None,
    }))
}

fn emission(authored: &json::Material, texture: Option<Texture>) -> Result<Emission, String> {
    let strength: Option<json::EmissiveStrength> =
        extension(&authored.extensions, "KHR_materials_emissive_strength")?;
    let strength = strength.and_then(|strength| strength.emissive_strength).unwrap_or(1.0);
    let color = Vec3::from(authored.emissive_factor);
    let sampled = color * strength != Vec3::ZERO;
    Ok(Emission { color, strength, texture, sampled, ..Emission::default() })
}

/// `None`, and a line in `lost`, where the picture cannot be had.
fn texture(
    project: &Path,
    gltf: &Gltf,
    info: &TextureInfo,
    lost: &mut Vec<String>,
) -> Result<Option<Texture>, String> {
    let texture = get(&gltf.root.textures, info.index, "texture")?;
    let Some(source) = texture.source else {
        lost.push(format!("texture {} has no picture that can be read and was left out", info.index));
        return Ok(None);
    };
    let image = match image_source(gltf, source) {
        Ok(image) => image,
        Err(message) => {
            lost.push(format!("picture {source} {message}; the texture was left out"));
            return Ok(None);
        }
    };
    if image.image.is_none() && !project.join(&image.file).is_file() {
        lost.push(format!("the picture {} is missing", image.file));
    }
    let sampler = texture.sampler.map(|sampler| get(&gltf.root.samplers, sampler, "sampler")).transpose()?;
    let transform: Option<TextureTransform> = extension(&info.extensions, "KHR_texture_transform")?;
    let transform = transform.unwrap_or_default();
    let set = transform.tex_coord.unwrap_or(info.tex_coord);
    if set > 1 {
        lost.push(format!("a texture uses texture coordinates {set}; only 0 and 1 are read, 0 is taken"));
    }
    Ok(Some(Texture {
        uv_set: if set == 1 { 1 } else { 0 },
        offset: Vec2::from(transform.offset),
        rotation: transform.rotation,
        scale: transform.scale.map_or(Vec2::ONE, Vec2::from),
        ..sampled(sampler, image)
    }))
}

fn sampled(sampler: Option<&Sampler>, image: ImageSource) -> Texture {
    let Some(sampler) = sampler else { return Texture::new(image) };
    Texture {
        wrap_u: wrap(sampler.wrap_s),
        wrap_v: wrap(sampler.wrap_t),
        nearest: sampler.mag_filter == Some(9728),
        mipmaps: !matches!(sampler.min_filter, Some(9728 | 9729)), // NEAREST, LINEAR
        ..Texture::new(image)
    }
}

fn wrap(mode: Option<u32>) -> Wrap {
    match mode {
        Some(33071) => Wrap::Clamp,
        Some(33648) => Wrap::Mirror,
        _ => Wrap::Repeat,
    }
}

/// Where the n-th picture is: beside the file, or in it.
fn image_source(gltf: &Gltf, n: usize) -> Result<ImageSource, String> {
    let image = get(&gltf.root.images, n, "picture")?;
    let external = match &image.uri {
        Some(uri) if !uri.starts_with("data:") => Some(resolve(&gltf.file, uri)?),
        _ => None,
    };
    Ok(match external {
        Some(Reference::File(file)) => ImageSource { file, image: None },
        _ => ImageSource { file: gltf.file.clone(), image: Some(n as u32) },
    })
}
