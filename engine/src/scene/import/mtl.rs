//! MTL, the materials of OBJ. Kd is the albedo, Ke the radiance; what cannot be read is a warning.

use glam::{Vec2, Vec3};

use crate::scene::material::Wrap;
use crate::scene::{Albedo, Alpha, ImageSource, Material, Texture};

/// A material as the library has it: the pictures' paths are as written.
pub struct Authored {
    pub material: Material,
    /// Why something is not as the library says.
    pub lost: Vec<String>,
    /// map_d where it is not the albedo's picture.
    alpha_map: Option<String>,
}

/// What has no Kd is light grey, as most programs show it: white would keep the light of a closed room for
/// ever.
pub fn unpainted(name: &str) -> Material {
    let albedo = Albedo { color: Vec3::splat(0.8), ..Albedo::default() };
    Material { name: name.to_owned(), albedo, ..Material::default() }
}

/// The materials of a library, in its order. `locate` turns a path as written into one of the project.
pub fn materials(text: &str, locate: impl Fn(&str) -> Result<String, String>) -> Vec<Authored> {
    let mut materials: Vec<Authored> = Vec::new();
    for line in text.lines().map(str::trim) {
        let (keyword, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let rest = rest.trim();
        if keyword == "newmtl" {
            materials.push(Authored { material: unpainted(rest), lost: Vec::new(), alpha_map: None });
        } else if let Some(authored) = materials.last_mut()
            && let Err(message) = statement(authored, &keyword.to_ascii_lowercase(), rest, &locate)
        {
            authored.lost.push(format!("`{keyword}` {message}"));
        }
    }
    materials.iter_mut().for_each(finish);
    materials
}

fn statement(
    authored: &mut Authored,
    keyword: &str,
    rest: &str,
    locate: &impl Fn(&str) -> Result<String, String>,
) -> Result<(), String> {
    let material = &mut authored.material;
    match keyword {
        "kd" => material.albedo.color = color(rest)?,
        "ke" => material.emission.color = color(rest)?,
        "d" => material.opacity = number(rest.trim_start_matches("-halo"))?.clamp(0.0, 1.0),
        "tr" if material.opacity == 1.0 => material.opacity = 1.0 - number(rest)?.clamp(0.0, 1.0),
        "pm" => material.metallic = number(rest)?.clamp(0.0, 1.0),
        "pr" => material.roughness = number(rest)?.clamp(0.0, 1.0),
        "map_kd" => material.albedo.texture = Some(texture(rest, locate)?),
        "map_ke" => material.emission.texture = Some(texture(rest, locate)?),
        "norm" => material.normal_texture = Some(texture(rest, locate)?),
        "map_d" => authored.alpha_map = Some(texture(rest, locate)?.image.file),
        "map_bump" | "bump" | "map_pr" | "map_pm" => return Err("is not read".to_owned()),
        _ => {}
    }
    Ok(())
}

fn finish(authored: &mut Authored) {
    let material = &mut authored.material;
    if material.emission.texture.is_some() && material.emission.color == Vec3::ZERO {
        material.emission.color = Vec3::ONE;
    }
    material.emission.sampled = material.emission.color != Vec3::ZERO;
    if material.opacity < 1.0 {
        material.alpha = Alpha::Blend;
    }
    let Some(map) = authored.alpha_map.take() else { return };
    if material.albedo.texture.as_ref().is_some_and(|texture| texture.image.file == map) {
        material.alpha = Alpha::Mask { cutoff: 0.5 };
    } else {
        authored.lost.push(format!("`map_d` {map} is not read: put its alpha into the picture of `map_Kd`"));
    }
}

/// One number stands for all three.
fn color(text: &str) -> Result<Vec3, String> {
    let values: Vec<f32> = text.split_whitespace().take(3).map_while(|word| word.parse().ok()).collect();
    let color = match values[..] {
        [r, g, b] => Vec3::new(r, g, b),
        [grey] => Vec3::splat(grey),
        _ => return Err(format!("is no colour: {text}")),
    };
    if color.is_finite() { Ok(color) } else { Err(format!("is not finite: {text}")) }
}

fn number(text: &str) -> Result<f32, String> {
    let value = text.split_whitespace().next().and_then(|word| word.parse().ok());
    value.filter(|value: &f32| value.is_finite()).ok_or_else(|| format!("is no number: {text}"))
}

/// Options, then a path that may hold blanks. OBJ's v goes up, a picture's rows go down.
fn texture(text: &str, locate: &impl Fn(&str) -> Result<String, String>) -> Result<Texture, String> {
    let mut texture = Texture::new(ImageSource { file: String::new(), image: None });
    let (mut offset, mut scale) = (Vec2::ZERO, Vec2::ONE);
    let mut rest = text;
    while let Some((option, after)) =
        rest.strip_prefix('-').and_then(|rest| rest.split_once(char::is_whitespace))
    {
        let (values, remaining) = option_values(option, after);
        let number = |n: usize, or: f32| values.get(n).and_then(|word| word.parse().ok()).unwrap_or(or);
        match option {
            "s" => scale = Vec2::new(number(0, 1.0), number(1, 1.0)),
            "o" => offset = Vec2::new(number(0, 0.0), number(1, 0.0)),
            "clamp" if values == ["on"] => (texture.wrap_u, texture.wrap_v) = (Wrap::Clamp, Wrap::Clamp),
            _ => {}
        }
        rest = remaining;
    }
    texture.scale = scale;
    texture.offset = Vec2::new(offset.x, 1.0 - offset.y - scale.y);
    texture.image.file = locate(rest.trim().trim_matches('"'))?;
    Ok(texture)
}

/// The words that belong to an option, and what follows them.
fn option_values<'a>(option: &str, text: &'a str) -> (Vec<&'a str>, &'a str) {
    let (most, numbers_only) = match option {
        "o" | "s" | "t" => (3, true),
        "mm" => (2, true),
        _ => (1, false),
    };
    let mut values = Vec::new();
    let mut rest = text.trim_start();
    while values.len() < most {
        let Some((word, after)) = rest.split_once(char::is_whitespace) else { break };
        if numbers_only && word.parse::<f32>().is_err() {
            break;
        }
        values.push(word);
        rest = after.trim_start();
    }
    (values, rest)
}
