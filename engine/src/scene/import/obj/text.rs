//! What tobj trips over, straightened beforehand.
//!
//! tobj reads numbers, faces, objects and materials. It takes a polyline for a polygon, gives a corner
//! without a normal that of the corner before, refuses the file for a texture coordinate that nobody needs,
//! mixes up the colours where only some vertices have any, and forgets the names of materials that are in
//! no library. So each line becomes one that it reads as it is meant: corners are counted from the start,
//! and those that lack something refer to [`NOTHING`].

use crate::scene::import::path::shortened;

/// Before the file's own lines: the names of the materials (whatever file that is), that of the object, and
/// as the first texture coordinate and the first normal those of corners that have none.
const NOTHING: &str = "mtllib .\no unnamed\nvt nan nan\nvn nan nan nan\n";

/// The lines of [`NOTHING`].
pub const LINES_BEFORE: usize = 4;

/// A file as tobj is to see it, line by line.
#[derive(Default)]
pub struct Straightened {
    pub text: String,
    /// As `usemtl` names them, in the order of first use.
    pub materials: Vec<String>,
    /// As `mtllib` names them.
    pub libraries: Vec<String>,
    /// Points, lines and faces of fewer than three corners.
    pub left_out: usize,
    /// Corners whose texture coordinate or normal is not there: they go without.
    pub lacking: usize,
    /// Positions, texture coordinates and normals so far.
    counts: [usize; 3],
}

/// Errors name the line.
pub fn straightened(text: &str) -> Result<Straightened, String> {
    let mut made = Straightened { text: NOTHING.to_owned(), ..Straightened::default() };
    // A backslash continues a line; the line numbers of messages count what was joined as one.
    let joined = text.replace("\\\r\n", " ").replace("\\\n", " ");
    let lines =
        || joined.lines().map(|line| line.trim().split_once(char::is_whitespace).unwrap_or((line, "")));
    let has_colors = lines().any(|(keyword, rest)| keyword == "v" && color(&words(rest)).is_some());
    for (n, (keyword, rest)) in lines().enumerate() {
        statement(&mut made, keyword, rest.trim(), has_colors)
            .map_err(|message| format!("line {}: {message}", n + 1))?;
        made.text.push('\n');
    }
    Ok(made)
}

/// Of a statement of numbers, up to a comment.
fn words(rest: &str) -> Vec<&str> {
    rest.split('#').next().unwrap_or(rest).split_whitespace().collect()
}

/// x y z, x y z w, or x y z r g b.
fn color<'a>(words: &[&'a str]) -> Option<[&'a str; 3]> {
    let color: [&str; 3] = words.get(3..6)?.try_into().ok()?;
    color.iter().all(|word| word.parse::<f32>().is_ok()).then_some(color)
}

fn statement(made: &mut Straightened, keyword: &str, rest: &str, has_colors: bool) -> Result<(), String> {
    let words = words(rest);
    match keyword {
        "v" => {
            made.counts[0] += 1;
            let color = if has_colors { color(&words).unwrap_or(["1"; 3]) } else { [""; 3] };
            push(made, keyword, &words.get(..3).map_or_else(|| words.clone(), |xyz| [xyz, &color].concat()));
        }
        "vt" => {
            made.counts[1] += 1;
            push(made, keyword, &[words.first().copied().unwrap_or_default(), words.get(1).unwrap_or(&"0")]);
        }
        "vn" => {
            made.counts[2] += 1;
            push(made, keyword, &words);
        }
        "f" if words.len() >= 3 => {
            let corners: Result<Vec<String>, String> = words.iter().map(|word| corner(made, word)).collect();
            push(made, keyword, &corners?);
        }
        "f" | "l" | "p" => made.left_out += 1,
        "o" | "g" => push(made, keyword, &[if rest.is_empty() { "unnamed" } else { rest }]),
        "usemtl" if !rest.is_empty() => {
            if !made.materials.iter().any(|known| known == rest) {
                made.materials.push(rest.to_owned());
            }
            push(made, keyword, &[rest]);
        }
        "mtllib" => made.libraries.push(rest.to_owned()),
        _ => {}
    }
    Ok(())
}

fn push(made: &mut Straightened, keyword: &str, words: &[impl AsRef<str>]) {
    made.text.push_str(keyword);
    for word in words {
        made.text.push(' ');
        made.text.push_str(word.as_ref());
    }
}

/// `v`, `v/vt`, `v//vn` or `v/vt/vn` as v/vt/vn, counted from 1, where 1 is [`NOTHING`].
fn corner(made: &mut Straightened, word: &str) -> Result<String, String> {
    let mut fields = word.split('/');
    let mut place = |n: usize| match fields.next().filter(|field| !field.is_empty()) {
        Some(field) => place(field, made.counts[n]).map(Some),
        None => Ok(None),
    };
    let (position, uv, normal) = (place(0)?, place(1)?, place(2)?);
    let position = position.ok_or_else(|| format!("`{}` names no position", shortened(word)))?;
    let position = position.ok_or_else(|| {
        let there = made.counts[0];
        format!("`{}` refers to a position that is not there: {there} are", shortened(word))
    })?;
    made.lacking += [uv, normal].iter().filter(|found| matches!(found, Some(None))).count();
    let [uv, normal] = [uv, normal].map(|found| found.flatten().map_or(1, |at| at + 2));
    Ok(format!("{}/{uv}/{normal}", position + 1))
}

/// Where an index points to, if there is something. They count from 1; negative ones from the latest
/// backwards.
fn place(field: &str, count: usize) -> Result<Option<usize>, String> {
    let place: i64 = field.parse().map_err(|_| format!("`{}` is no index", shortened(field)))?;
    let from_start = if place < 0 { place + count as i64 } else { place - 1 };
    Ok(usize::try_from(from_start).ok().filter(|&at| at < count))
}
