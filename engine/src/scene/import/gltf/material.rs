//! Materials, textures and samplers.

use std::path::Path;

use glam::{Vec2, Vec3};
use gltf::json::extensions::texture::TextureTransform;
use gltf::json::material as json;
use gltf::json::texture::Info;
use gltf::material::AlphaMode;
use gltf::texture::{MagFilter, MinFilter, Sampler, WrappingMode};
use serde::Deserialize;

use super::{Gltf, find};
use crate::scene::import::path::{Reference, resolve};
use crate::scene::material::Wrap;
use crate::scene::{Albedo, Alpha, Emission, ImageSource, Material, MaterialId, Texture, Warning};

/// All materials of the file; the id is the index.
pub fn materials(project: &Path, gltf: &Gltf, warnings: &mut Vec<Warning>) -> Result<Vec<Material>, String> {
    let authored = &gltf.document.as_json().materials;
    let mut materials = Vec::with_capacity(authored.len());
    for (n, authored) in authored.iter().enumerate() {
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

/// What a primitive without a material is drawn with: ours, not glTF's, whose metal would swallow the light
/// of a scene that nobody painted.
pub fn default_material(id: MaterialId) -> Material {
    Material { id, name: "default".to_owned(), ..Material::default() }
}

fn material(
    project: &Path,
    gltf: &Gltf,
    authored: &json::Material,
    lost: &mut Vec<String>,
) -> Result<Material, String> {
    let glossy = specular_glossiness(authored);
    let pbr = glossy.as_ref().unwrap_or(&authored.pbr_metallic_roughness);
    let normal = authored.normal_texture.as_ref();
    let normal_info = normal.map(normal_info).transpose()?;
    let mut texture = |info: Option<&Info>| info.and_then(|info| texture(project, gltf, info, lost));
    let [r, g, b, a] = pbr.base_color_factor.0;
    let alpha = match authored.alpha_mode.unwrap() {
        AlphaMode::Mask => Alpha::Mask { cutoff: authored.alpha_cutoff.unwrap_or_default().0 },
        AlphaMode::Blend => Alpha::Blend,
        AlphaMode::Opaque => Alpha::Opaque,
    };
    Ok(Material {
        albedo: Albedo {
            color: Vec3::new(r, g, b),
            texture: texture(pbr.base_color_texture.as_ref()),
            ..Albedo::default()
        },
        metallic: pbr.metallic_factor.0,
        roughness: pbr.roughness_factor.0,
        metallic_roughness_texture: texture(pbr.metallic_roughness_texture.as_ref()),
        normal_texture: texture(normal_info.as_ref()),
        normal_scale: normal.map_or(1.0, |normal| normal.scale),
        emission: emission(authored, texture(authored.emissive_texture.as_ref())),
        alpha,
        opacity: if alpha == Alpha::Opaque { 1.0 } else { a },
        double_sided: authored.double_sided,
        unlit: authored.extensions.as_ref().is_some_and(|extensions| extensions.unlit.is_some()),
        ..Material::default()
    })
}

/// The older model's diffuse part is ours; its coloured mirror is not.
fn specular_glossiness(authored: &json::Material) -> Option<json::PbrMetallicRoughness> {
    let found = authored.extensions.as_ref()?.pbr_specular_glossiness.as_ref()?;
    Some(json::PbrMetallicRoughness {
        base_color_factor: json::PbrBaseColorFactor(found.diffuse_factor.0),
        base_color_texture: found.diffuse_texture.clone(),
        metallic_factor: json::StrengthFactor(0.0),
        roughness_factor: json::StrengthFactor(1.0 - found.glossiness_factor.0),
        ..Default::default()
    })
}

fn emission(authored: &json::Material, texture: Option<Texture>) -> Emission {
    let extension = authored.extensions.as_ref().and_then(|extensions| extensions.emissive_strength.as_ref());
    let strength = extension.map_or(1.0, |extension| extension.emissive_strength.0);
    let color = Vec3::from(authored.emissive_factor.0);
    let sampled = color * strength != Vec3::ZERO;
    Emission { color, strength, texture, sampled, ..Emission::default() }
}

/// The crate does not read the transform of a normal texture.
fn normal_info(normal: &json::NormalTexture) -> Result<Info, String> {
    const NAME: &str = "KHR_texture_transform";
    let transform = normal.extensions.as_ref().and_then(|extensions| extensions.others.get(NAME));
    let transform = transform.map(TextureTransform::deserialize).transpose();
    let texture_transform = transform.map_err(|error| format!("{NAME}: {error}"))?;
    let extensions = gltf::json::extensions::texture::Info { texture_transform, others: Default::default() };
    let (index, tex_coord) = (normal.index, normal.tex_coord);
    Ok(Info { index, tex_coord, extensions: Some(extensions), extras: None })
}

/// `None`, and a line in `lost`, where the picture cannot be had.
fn texture(project: &Path, gltf: &Gltf, info: &Info, lost: &mut Vec<String>) -> Option<Texture> {
    let texture = gltf.document.textures().nth(info.index.value())?;
    let Some(source) = texture.source().map(|image| image.index()) else {
        lost.push(format!("texture {} has no picture that can be read and was left out", info.index));
        return None;
    };
    let image = match image_source(gltf, source) {
        Ok(image) => image,
        Err(message) => {
            lost.push(format!("picture {source} {message}; the texture was left out"));
            return None;
        }
    };
    if image.image.is_none() && !project.join(&image.file).is_file() {
        lost.push(format!("the picture {} is missing", image.file));
    }
    let extensions = info.extensions.as_ref();
    let transform =
        extensions.and_then(|extensions| extensions.texture_transform.clone()).unwrap_or_default();
    let set = transform.tex_coord.unwrap_or(info.tex_coord);
    if set > 1 {
        lost.push(format!("a texture uses texture coordinates {set}; only 0 and 1 are read, 0 is taken"));
    }
    Some(Texture {
        uv_set: if set == 1 { 1 } else { 0 },
        offset: Vec2::from(transform.offset.0),
        rotation: transform.rotation.0,
        scale: Vec2::from(transform.scale.0),
        ..sampled(&texture.sampler(), image)
    })
}

fn sampled(sampler: &Sampler, image: ImageSource) -> Texture {
    Texture {
        wrap_u: wrap(sampler.wrap_s()),
        wrap_v: wrap(sampler.wrap_t()),
        nearest: sampler.mag_filter() == Some(MagFilter::Nearest),
        mipmaps: !matches!(sampler.min_filter(), Some(MinFilter::Nearest | MinFilter::Linear)),
        ..Texture::new(image)
    }
}

fn wrap(mode: WrappingMode) -> Wrap {
    match mode {
        WrappingMode::ClampToEdge => Wrap::Clamp,
        WrappingMode::MirroredRepeat => Wrap::Mirror,
        WrappingMode::Repeat => Wrap::Repeat,
    }
}

/// Where the n-th picture is: beside the file, or in it.
fn image_source(gltf: &Gltf, n: usize) -> Result<ImageSource, String> {
    let image = find(gltf.document.as_json().images.iter(), n, "picture")?;
    let external = match &image.uri {
        Some(uri) if !uri.starts_with("data:") => Some(resolve(&gltf.file, uri)?),
        _ => None,
    };
    Ok(match external {
        Some(Reference::File(file)) => ImageSource { file, image: None },
        _ => ImageSource { file: gltf.file.clone(), image: Some(n as u32) },
    })
}
