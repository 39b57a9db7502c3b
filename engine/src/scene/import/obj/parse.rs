//! The lines of an OBJ file.

use glam::{Vec2, Vec3, Vec4};

use super::{Corner, Obj, Object, Run};
use crate::scene::import::path::shortened;

/// Parses a file. Errors name the line.
pub fn open(file: &str, bytes: &[u8]) -> Result<Obj, String> {
    let text = text(bytes)?;
    let mut obj = Obj {
        file: file.to_owned(),
        positions: Vec::new(),
        colors: Vec::new(),
        uvs: Vec::new(),
        normals: Vec::new(),
        objects: Vec::new(),
        materials: Vec::new(),
        libraries: Vec::new(),
        left_out: 0,
        lacking: 0,
    };
    let mut current = Current { name: "unnamed".to_owned(), material: None, is_new: true };
    // A backslash continues a line; the line numbers of messages count what was joined as one.
    let joined = text.replace("\\\r\n", " ").replace("\\\n", " ");
    for (n, line) in joined.lines().enumerate() {
        statement(&mut obj, &mut current, line.trim())
            .map_err(|message| format!("line {}: {message}", n + 1))?;
    }
    obj.objects.retain(|object| !object.runs.is_empty());
    Ok(obj)
}

fn text(bytes: &[u8]) -> Result<&str, String> {
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        return Err("is UTF-16 text: save it as UTF-8".to_owned());
    }
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    std::str::from_utf8(bytes)
        .map_err(|error| format!("is not UTF-8 text (byte {}): save it as UTF-8", error.valid_up_to()))
}

/// What the next face belongs to.
struct Current {
    name: String,
    material: Option<usize>,
    /// The next face begins an object.
    is_new: bool,
}

fn statement(obj: &mut Obj, current: &mut Current, line: &str) -> Result<(), String> {
    let (keyword, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
    match keyword {
        "v" => vertex(obj, rest)?,
        "vt" => {
            let [u, v, ..] = numbers(rest, 1)?;
            obj.uvs.push(Vec2::new(u, 1.0 - v)); // OBJ's v goes up, a picture's rows go down
        }
        "vn" => {
            let [x, y, z, ..] = numbers(rest, 3)?;
            obj.normals.push(Vec3::new(x, y, z));
        }
        "f" | "fo" => face(obj, current, rest)?,
        "o" | "g" => {
            let name = if rest.trim().is_empty() { "unnamed" } else { rest.trim() };
            current.is_new |= current.name != name;
            current.name = name.to_owned();
        }
        "usemtl" => current.material = material_index(obj, rest.trim()),
        "mtllib" => obj.libraries.push(rest.trim().to_owned()),
        "l" | "p" => obj.left_out += 1,
        _ => {}
    }
    Ok(())
}

fn material_index(obj: &mut Obj, name: &str) -> Option<usize> {
    if name.is_empty() {
        return None;
    }
    let found = obj.materials.iter().position(|known| known == name);
    Some(found.unwrap_or_else(|| {
        obj.materials.push(name.to_owned());
        obj.materials.len() - 1
    }))
}

/// x y z, x y z w, or x y z r g b.
fn vertex(obj: &mut Obj, rest: &str) -> Result<(), String> {
    let [x, y, z, r, g, b, _] = numbers(rest, 3)?;
    obj.positions.push(Vec3::new(x, y, z));
    let colored = before_comment(rest).split_whitespace().count() >= 6;
    if colored && obj.colors.is_empty() {
        obj.colors = vec![Vec4::ONE; obj.positions.len() - 1];
    }
    if colored || !obj.colors.is_empty() {
        obj.colors.push(if colored { Vec4::new(r, g, b, 1.0) } else { Vec4::ONE });
    }
    Ok(())
}

/// At least `least` numbers; those that are not there are 0.
fn numbers(text: &str, least: usize) -> Result<[f32; 7], String> {
    let mut values = [0.0; 7];
    let mut count = 0;
    for (to, word) in values.iter_mut().zip(before_comment(text).split_whitespace()) {
        *to = word.parse().map_err(|_| format!("`{}` is no number", shortened(word)))?;
        count += 1;
    }
    if count < least { Err(format!("{least} numbers are needed, {count} are there")) } else { Ok(values) }
}

fn before_comment(text: &str) -> &str {
    text.split('#').next().unwrap_or(text)
}

fn face(obj: &mut Obj, current: &mut Current, rest: &str) -> Result<(), String> {
    let words = before_comment(rest).split_whitespace();
    let corners = words.map(|word| corner(obj, word)).collect::<Result<Vec<_>, _>>()?;
    if corners.len() < 3 {
        obj.left_out += 1;
        return Ok(());
    }
    if current.is_new || obj.objects.is_empty() {
        current.is_new = false;
        obj.objects.push(Object { name: current.name.clone(), runs: Vec::new() });
    }
    let Some(object) = obj.objects.last_mut() else { return Ok(()) };
    let at = object.runs.iter().position(|run| run.material == current.material).unwrap_or_else(|| {
        object.runs.push(Run { material: current.material, corners: Vec::new(), ends: Vec::new() });
        object.runs.len() - 1
    });
    let run = &mut object.runs[at];
    run.corners.extend(corners);
    run.ends.push(run.corners.len());
    Ok(())
}

/// `v`, `v/vt`, `v//vn` or `v/vt/vn`.
fn corner(obj: &mut Obj, word: &str) -> Result<Corner, String> {
    let mut fields = word.split('/').map(|field| if field.is_empty() { None } else { Some(field) });
    let mut next = |count: usize| fields.next().flatten().map(|field| place(field, count)).transpose();
    let position =
        next(obj.positions.len())?.ok_or_else(|| format!("`{}` names no position", shortened(word)))?;
    let (uv, normal) = (next(obj.uvs.len())?, next(obj.normals.len())?);
    obj.lacking += [uv, normal].iter().filter(|found| matches!(found, Some(None))).count();
    let there = obj.positions.len();
    let position = position.ok_or_else(|| {
        format!("`{}` refers to a position that is not there: {there} are", shortened(word))
    })?;
    Ok(Corner { position, uv: uv.flatten(), normal: normal.flatten() })
}

/// Where an index points to, if there is something. They count from 1; negative ones from the latest
/// backwards.
fn place(field: &str, count: usize) -> Result<Option<usize>, String> {
    let place: i64 = field.parse().map_err(|_| format!("`{}` is no index", shortened(field)))?;
    let from_start = if place < 0 { place + count as i64 } else { place - 1 };
    Ok(usize::try_from(from_start).ok().filter(|&at| at < count))
}
