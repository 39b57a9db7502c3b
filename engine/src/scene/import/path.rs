//! What a file refers to: URIs, data inside URIs, and paths that stay inside the project.

use std::borrow::Cow;

use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use base64::{Engine, alphabet};
use percent_encoding::percent_decode_str;

/// What a URI stands for.
pub enum Reference {
    /// Bytes inside the URI itself.
    Data(Vec<u8>),
    /// A file, relative to the project, with forward slashes.
    File(String),
}

/// What `uri`, written in `file` (relative to the project), refers to. Percent escapes are decoded.
pub fn resolve(file: &str, uri: &str) -> Result<Reference, String> {
    if let Some(data) = strip_scheme(uri, "data:") {
        return data_of(data).map(Reference::Data);
    }
    if ["http:", "https:", "file:", "ftp:"].iter().any(|scheme| strip_scheme(uri, scheme).is_some()) {
        return Err(format!("refers to `{}`: only files of the project can be read", shortened(uri)));
    }
    beside(file, &percent_decoded(uri)).map(Reference::File)
}

/// The path of `name`, which `file` refers to, relative to the project. Backslashes count as slashes.
pub fn beside(file: &str, name: &str) -> Result<String, String> {
    let folder = file.rfind('/').map_or("", |end| &file[..end]);
    let absolute = name.starts_with(['/', '\\']) || name.as_bytes().get(1) == Some(&b':');
    if absolute {
        return Err(format!("refers to `{}`, which is no path relative to the file", shortened(name)));
    }
    inside(&format!("{folder}/{name}"))
        .ok_or_else(|| format!("refers to `{}`, which is outside the project", shortened(name)))
}

/// The path without `.` and `..`, or `None` where it leads out of the project or names nothing.
pub fn inside(path: &str) -> Option<String> {
    let mut names = Vec::new();
    for name in path.split(['/', '\\']) {
        match name {
            "" | "." => {}
            ".." => drop(names.pop()?),
            _ => names.push(name),
        }
    }
    let has_drive = names.first().is_some_and(|name| name.as_bytes().get(1) == Some(&b':'));
    let usable = !names.is_empty() && !has_drive && names.iter().all(|name| !name.contains('\0'));
    usable.then(|| names.join("/"))
}

/// The path `to` (relative to the project) as seen from the folder of `file`.
pub fn seen_from(file: &str, to: &str) -> String {
    let folder: Vec<&str> = file.split('/').collect();
    let names: Vec<&str> = to.split('/').collect();
    let depth = folder.len() - 1;
    let shared = folder[..depth].iter().zip(&names[..names.len() - 1]).take_while(|(a, b)| a == b).count();
    let up = std::iter::repeat_n("..", depth - shared);
    up.chain(names[shared..].iter().copied()).collect::<Vec<_>>().join("/")
}

/// Escapes that are none stay as they are, as do those that would make no UTF-8.
pub fn percent_decoded(uri: &str) -> String {
    percent_decode_str(uri).decode_utf8().map_or_else(|_| uri.to_owned(), Cow::into_owned)
}

fn strip_scheme<'a>(uri: &'a str, scheme: &str) -> Option<&'a str> {
    let head = uri.get(..scheme.len())?;
    head.eq_ignore_ascii_case(scheme).then(|| &uri[scheme.len()..])
}

/// `[media type][;base64],data`. The media type is not believed: pictures tell their own format.
fn data_of(data: &str) -> Result<Vec<u8>, String> {
    let (head, body) = data.split_once(',').ok_or("holds a data URI without a comma")?;
    if head.to_ascii_lowercase().ends_with(";base64") {
        base64_decoded(body).ok_or_else(|| "holds a data URI whose base64 is broken".to_owned())
    } else {
        Ok(percent_decode_str(body).collect())
    }
}

/// Either alphabet; blanks are skipped and padding may be missing.
fn base64_decoded(text: &str) -> Option<Vec<u8>> {
    const LENIENT: GeneralPurpose = GeneralPurpose::new(
        &alphabet::STANDARD,
        GeneralPurposeConfig::new()
            .with_decode_padding_mode(DecodePaddingMode::Indifferent)
            .with_decode_allow_trailing_bits(true),
    );
    let standard = |c: u8| match c {
        b'-' => b'+',
        b'_' => b'/',
        _ => c,
    };
    let digits: Vec<u8> = text.bytes().filter(|c| !c.is_ascii_whitespace()).map(standard).collect();
    LENIENT.decode(digits).ok()
}

/// Short enough for a message.
pub fn shortened(text: &str) -> String {
    if text.chars().count() <= 80 {
        text.to_owned()
    } else {
        text.chars().take(77).collect::<String>() + "..."
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_stay_inside_the_project() {
        assert_eq!(beside("assets/a.gltf", "b c.bin").as_deref(), Ok("assets/b c.bin"));
        assert_eq!(beside("assets/a.gltf", "../t/./x.png").as_deref(), Ok("t/x.png"));
        assert_eq!(beside("a.obj", r"maps\x.png").as_deref(), Ok("maps/x.png"));
        for out in ["../../x", "/etc/passwd", r"C:\x.png", r"\\host\x", ""] {
            assert!(beside("assets/a.gltf", out).is_err() || out.is_empty(), "{out}");
        }
        assert_eq!(seen_from("assets/kit/a.gltf", "assets/kit/t/x.png"), "t/x.png");
        assert_eq!(seen_from("assets/kit/a.gltf", "assets/t/x.png"), "../t/x.png");
    }

    #[test]
    fn uris_are_decoded() {
        assert_eq!(percent_decoded("a%20b%C3%A9%zz%"), "a bé%zz%");
        let Ok(Reference::Data(bytes)) = resolve("a", "data:application/x-odd;Base64,aGk_IQ") else {
            panic!()
        };
        assert_eq!(bytes, b"hi?!");
        let Ok(Reference::Data(bytes)) = resolve("a", "data:,a%20b") else { panic!() };
        assert_eq!(bytes, b"a b");
        assert!(resolve("a", "data:;base64,!!").is_err());
        assert!(resolve("a", "https://x/y.png").is_err());
    }
}
