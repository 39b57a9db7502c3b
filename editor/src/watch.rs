//! Whether another program changed a file: by its time and length, and where these differ by what it holds.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// When a file was written, and what it holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Stamp {
    modified: Option<SystemTime>,
    length: u64,
    hash: blake3::Hash,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Changed {
    Written,
    Gone,
    /// It was not there before.
    New,
}

impl Stamp {
    /// Of a file that holds this, as it was just read or written.
    pub fn of(path: &Path, bytes: &[u8]) -> Self {
        let modified = path.metadata().and_then(|metadata| metadata.modified()).ok();
        Self { modified, length: bytes.len() as u64, hash: blake3::hash(bytes) }
    }

    /// `None`: it is not there.
    pub fn read(path: &Path) -> Option<Self> {
        // The time first: what is written between the two is seen as a change later.
        let modified = path.metadata().and_then(|metadata| metadata.modified()).ok();
        let bytes = std::fs::read(path).ok()?;
        Some(Self { modified, ..Self::of(path, &bytes) })
    }

    /// What became of the file since. A file that was written anew with the same bytes has not changed.
    pub fn changed(&self, path: &Path) -> Option<Changed> {
        let Ok(metadata) = path.metadata() else { return Some(Changed::Gone) };
        if metadata.len() == self.length && metadata.modified().ok() == self.modified {
            return None;
        }
        let now = Self::read(path);
        now.is_none_or(|now| now.hash != self.hash).then_some(Changed::Written)
    }
}

/// Files that are looked at again and again.
#[derive(Debug, Default)]
pub struct Watch {
    known: HashMap<PathBuf, Option<Stamp>>,
}

impl Watch {
    /// These from now on, and no others. What a file held when it was first named is what it is compared with.
    pub fn follow(&mut self, files: impl IntoIterator<Item = PathBuf>) {
        let mut before = std::mem::take(&mut self.known);
        for file in files {
            let known = before.remove(&file).unwrap_or_else(|| Stamp::read(&file));
            self.known.insert(file, known);
        }
    }

    /// What a file held when it was read, if it is not followed yet: what happened to it since is a change.
    pub fn expect(&mut self, file: PathBuf, stamp: Stamp) {
        self.known.entry(file).or_insert(Some(stamp));
    }

    /// What changed since the last look, each change told once; in the order of paths.
    pub fn look(&mut self) -> Vec<(PathBuf, Changed)> {
        let mut changes = Vec::new();
        for (file, known) in &mut self.known {
            let change = match known {
                Some(stamp) => stamp.changed(file),
                None => file.is_file().then_some(Changed::New),
            };
            if let Some(change) = change {
                *known = Stamp::read(file);
                changes.push((file.clone(), change));
            }
        }
        changes.sort_by(|a, b| a.0.cmp(&b.0));
        changes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_changes_goes_or_comes_is_told_once() {
        let folder = tempfile::tempdir().unwrap();
        let [a, b] = ["a", "b"].map(|name| folder.path().join(name));
        std::fs::write(&a, "one").unwrap();
        let mut watch = Watch::default();
        watch.follow([a.clone(), b.clone()]);
        assert!(watch.look().is_empty());
        std::fs::write(&a, "longer").unwrap();
        std::fs::write(&b, "new").unwrap();
        assert_eq!(watch.look(), [(a.clone(), Changed::Written), (b.clone(), Changed::New)]);
        assert!(watch.look().is_empty());
        std::fs::remove_file(&a).unwrap();
        assert_eq!(watch.look(), [(a, Changed::Gone)]);
        assert!(watch.look().is_empty());
    }

    #[test]
    fn the_same_bytes_written_again_are_no_change() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a");
        std::fs::write(&file, "same").unwrap();
        let stamp = Stamp::read(&file).unwrap();
        let later = SystemTime::now() + std::time::Duration::from_secs(100);
        std::fs::File::options().write(true).open(&file).unwrap().set_modified(later).unwrap();
        assert_eq!(stamp.changed(&file), None);
        std::fs::write(&file, "diff").unwrap();
        assert_eq!(stamp.changed(&file), Some(Changed::Written));
    }
}
