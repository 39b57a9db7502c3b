//! MTL, the materials of OBJ, by the crate tobj. Kd is the albedo, Ke the radiance; what cannot be read is a
//! warning.

use glam::{Vec2, Vec3};

use crate::scene::material::Wrap;
use crate::scene::{Albedo, Alpha, Emission, ImageSource, Material, Texture};

/// A material as the library has it: the pictures' paths are as written.
pub struct Authored {
    pub material: Material,
    /// Why something is not as the library says.
    pub lost: Vec<String>,
}

/// What has no Kd is light grey, as most programs show it: white would keep the light of a closed room for
/// ever.
pub fn unpainted(name: &str) -> Material {
    let albedo = Albedo { color: Vec3::splat(0.8), ..Albedo::default() };
    Material { name: name.to_owned(), albedo, ..Material::default() }
}

/// The statements that are read, as tobj writes their names.
const READ: &[&str] = &[
    "newmtl", "Kd", "Ke", "d", "Tr", "Pm", "Pr", "map_Kd", "map_Ke", "norm", "map_d", "map_Bump", "bump",
    "map_Pr", "map_Pm",
];

/// The materials of a library, in its order. `locate` turns a path as written into one of the project.
pub fn materials(text: &str, locate: impl Fn(&str) -> Result<String, String>) -> Vec<Authored> {
    let (text, lost) = straightened(text);
    let authored = tobj::load_mtl_buf(&mut text.as_bytes()).map_or_else(|_| Vec::new(), |(found, _)| found);
    authored.into_iter().zip(lost).map(|(found, lost)| material(found, lost, &locate)).collect()
}

/// tobj refuses a library for one statement: here each one is tried alone. Also why those of each material
/// were left out.
fn straightened(text: &str) -> (String, Vec<Vec<String>>) {
    let mut kept = String::new();
    let mut lost: Vec<Vec<String>> = Vec::new();
    for line in text.lines().map(str::trim) {
        let (written, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let Some(keyword) = READ.iter().find(|keyword| keyword.eq_ignore_ascii_case(written)) else {
            continue;
        };
        let line = format!("{keyword} {}\n", operands(keyword, rest.trim()));
        match tried(keyword, &line) {
            Ok(()) if *keyword == "newmtl" => lost.push(Vec::new()),
            Ok(()) if lost.is_empty() => continue,
            Ok(()) => {}
            Err(error) => {
                lost.last_mut()
                    .into_iter()
                    .for_each(|lost| lost.push(format!("`{keyword}` {error}: {rest}")));
                continue;
            }
        }
        kept.push_str(&line);
    }
    (kept, lost)
}

/// One number stands for all three of a colour.
fn operands(keyword: &str, rest: &str) -> String {
    let is_grey = keyword.starts_with('K') && !rest.is_empty() && !rest.contains(char::is_whitespace);
    match keyword {
        _ if is_grey => [rest; 3].join(" "),
        "d" => rest.trim_start_matches("-halo").to_owned(),
        _ => rest.to_owned(),
    }
}

fn tried(keyword: &str, line: &str) -> Result<(), tobj::LoadError> {
    // tobj panics at fewer than three numbers.
    if keyword.starts_with('K') && line.split_whitespace().count() < 4 {
        return Err(tobj::LoadError::MaterialParseError);
    }
    tobj::load_mtl_buf(&mut line.as_bytes()).map(drop)
}

fn material(
    found: tobj::Material,
    mut lost: Vec<String>,
    locate: &impl Fn(&str) -> Result<String, String>,
) -> Authored {
    let grey = unpainted(&found.name);
    let other = |keyword: &str| found.unknown_param.get(keyword).map(String::as_str);
    for keyword in ["map_Pr", "map_Pm"].into_iter().filter(|keyword| other(keyword).is_some()) {
        lost.push(format!("`{keyword}` is not read"));
    }
    if found.normal_texture.is_some() {
        lost.push("`bump` is not read".to_owned());
    }
    let mut read = Lost(&mut lost);
    let albedo = Albedo {
        color: read.color("Kd", found.diffuse).unwrap_or(grey.albedo.color),
        texture: read.texture("map_Kd", found.diffuse_texture.as_deref(), locate),
        ..grey.albedo
    };
    let glow = read.texture("map_Ke", other("map_Ke"), locate);
    let unlit = if glow.is_some() { Vec3::ONE } else { Vec3::ZERO };
    let color = read.color("Ke", found.emissive).filter(|&color| color != Vec3::ZERO).unwrap_or(unlit);
    let opaque = 1.0 - read.fraction("Tr", other("Tr")).unwrap_or(0.0);
    let opacity = found.dissolve.filter(|&d| d < 1.0).map_or(opaque, |d| d.max(0.0));
    let alpha_map = read.texture("map_d", found.dissolve_texture.as_deref(), locate);
    let mut material = Material {
        emission: Emission { color, texture: glow, sampled: color != Vec3::ZERO, ..grey.emission },
        metallic: read.fraction("Pm", other("Pm")).unwrap_or(grey.metallic),
        roughness: read.fraction("Pr", other("Pr")).unwrap_or(grey.roughness),
        normal_texture: read.texture("norm", other("norm"), locate),
        alpha: if opacity < 1.0 { Alpha::Blend } else { Alpha::Opaque },
        opacity,
        albedo,
        ..grey
    };
    let picture = material.albedo.texture.as_ref().map(|texture| &texture.image.file);
    match alpha_map.map(|texture| texture.image.file) {
        Some(map) if picture == Some(&map) => material.alpha = Alpha::Mask { cutoff: 0.5 },
        Some(map) => {
            lost.push(format!("`map_d` {map} is not read: put its alpha into the picture of `map_Kd`"));
        }
        None => {}
    }
    Authored { material, lost }
}

/// Reads operands, or says why not.
struct Lost<'a>(&'a mut Vec<String>);

impl Lost<'_> {
    fn unless<T>(&mut self, keyword: &str, read: Result<T, String>) -> Option<T> {
        read.map_err(|message| self.0.push(format!("`{keyword}` {message}"))).ok()
    }

    fn color(&mut self, keyword: &str, found: Option<[f32; 3]>) -> Option<Vec3> {
        let color = Vec3::from(found?);
        let finite = color.is_finite().then_some(color);
        self.unless(keyword, finite.ok_or_else(|| format!("is not finite: {color}")))
    }

    fn fraction(&mut self, keyword: &str, text: Option<&str>) -> Option<f32> {
        let text = text?;
        let value = text.split_whitespace().next().and_then(|word| word.parse::<f32>().ok());
        let finite = value.filter(|value| value.is_finite()).map(|value| value.clamp(0.0, 1.0));
        self.unless(keyword, finite.ok_or_else(|| format!("is no number: {text}")))
    }

    fn texture(
        &mut self,
        keyword: &str,
        text: Option<&str>,
        locate: &impl Fn(&str) -> Result<String, String>,
    ) -> Option<Texture> {
        self.unless(keyword, texture(text?, locate))
    }
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
