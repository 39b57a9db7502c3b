//! Rows that are traced already: a bake that is stopped goes on from there.
//!
//! A file a stage, `cache/STAGE-KEY.hits`: chunks of rows as they were finished, each with a checksum, so that a
//! file that ends in the middle of one loses that one alone. A finished bake deletes it.

use std::collections::HashMap;
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use crate::rays::Row;

pub struct Cache {
    path: Option<PathBuf>,
    file: Mutex<Option<File>>,
    kept: HashMap<usize, Vec<Row>>,
}

impl Cache {
    /// Keeps nothing.
    pub fn none() -> Self {
        Self { path: None, file: Mutex::new(None), kept: HashMap::new() }
    }

    /// `key` names everything that the rows depend on. What cannot be opened is done without.
    pub fn open(folder: &Path, stage: &str, key: &str) -> Self {
        let path = folder.join(format!("{stage}-{key}.hits"));
        let bytes = std::fs::read(&path).unwrap_or_default();
        let (kept, valid) = parse(&bytes);
        let open = || {
            std::fs::create_dir_all(folder).ok()?;
            let file = File::options().create(true).append(true).open(&path).ok()?;
            // What follows the last whole chunk was cut off.
            file.set_len(valid as u64).ok()?;
            Some(file)
        };
        Self { file: Mutex::new(open()), path: Some(path), kept }
    }

    pub fn chunk(&self, chunk: usize) -> Option<Vec<Row>> {
        self.kept.get(&chunk).cloned()
    }

    pub fn kept_rows(&self) -> usize {
        self.kept.values().map(Vec::len).sum()
    }

    pub fn keep(&self, chunk: usize, rows: &[Row]) {
        let mut record: Vec<u32> = vec![0, chunk as u32, rows.len() as u32];
        for row in rows {
            record.extend([row.lost, row.escaped, row.hits.len() as u32]);
            record.extend(row.hits.iter().flat_map(|&(column, count)| [column, count]));
        }
        record[0] = record.len() as u32;
        let sum = blake3::hash(bytemuck::cast_slice(&record));
        let Ok(mut file) = self.file.lock() else { return };
        let written = file.as_mut().map(|file| {
            file.write_all(bytemuck::cast_slice(&record))?;
            file.write_all(&sum.as_bytes()[..8])
        });
        if written.is_some_and(|written| written.is_err()) {
            *file = None; // a full disk costs the cache, not the bake
        }
    }

    /// The bake is done: what it was made of goes.
    pub fn delete(&self) {
        if let Some(path) = &self.path {
            let _ = std::fs::remove_file(path);
        }
    }
}

/// Whole chunks, and where the last one ends.
fn parse(bytes: &[u8]) -> (HashMap<usize, Vec<Row>>, usize) {
    let mut kept = HashMap::new();
    let mut at = 0;
    let word = |at: usize| bytes.get(at..at + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    while let Some(words) = word(at) {
        let end = at + words as usize * 4;
        let Some(record) = bytes.get(at..end).filter(|_| words >= 3) else { break };
        let Some(sum) = bytes.get(end..end + 8) else { break };
        if blake3::hash(record).as_bytes()[..8] != *sum {
            break;
        }
        let Some((chunk, rows)) = read(&bytemuck::pod_collect_to_vec(record)) else { break };
        kept.insert(chunk, rows);
        at = end + 8;
    }
    (kept, at)
}

fn read(record: &[u32]) -> Option<(usize, Vec<Row>)> {
    let mut words = record[1..].iter().copied();
    let chunk = words.next()? as usize;
    let rows = (0..words.next()?)
        .map(|_| {
            let (lost, escaped, n) = (words.next()?, words.next()?, words.next()?);
            let hits = (0..n).map(|_| Some((words.next()?, words.next()?))).collect::<Option<_>>()?;
            Some(Row { hits, lost, escaped })
        })
        .collect::<Option<_>>()?;
    Some((chunk, rows))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_was_cut_off_keeps_its_whole_chunks() {
        let folder = tempfile::tempdir().unwrap();
        let rows = |n: u32| vec![Row { hits: vec![(n, 2), (n + 5, 7)], lost: n, escaped: 1 }, Row::default()];
        let cache = Cache::open(folder.path(), "patch", "k");
        cache.keep(3, &rows(3));
        cache.keep(9, &rows(9));
        drop(cache);
        let path = folder.path().join("patch-k.hits");
        let whole = std::fs::read(&path).unwrap();
        std::fs::write(&path, &whole[..whole.len() - 5]).unwrap();
        let cache = Cache::open(folder.path(), "patch", "k");
        assert_eq!((cache.chunk(3), cache.chunk(9)), (Some(rows(3)), None));
        cache.keep(9, &rows(9));
        drop(cache);
        assert_eq!(Cache::open(folder.path(), "patch", "k").chunk(9), Some(rows(9)));
    }
}
