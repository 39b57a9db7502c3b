//! What happened, for the console: any thread writes, the console reads. It holds so many lines and no more; where it
//! is full, what matters least and is oldest goes first, so that an error is not washed away by remarks.

use std::collections::VecDeque;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::SystemTime;

use engine::scene::{EntityId, MaterialId, Scene, SceneError, Warning};

/// Lines that are kept.
pub const MOST_LINES: usize = 10_000;

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Level {
    Info,
    Warning,
    Error,
}

/// What a line is about, so that a click leads there.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub enum Source {
    #[default]
    Nothing,
    Entity(EntityId),
    Material(MaterialId),
    File(PathBuf),
}

impl Source {
    /// The entity or material of that name, or the file.
    pub fn named(name: &str, scene: &Scene) -> Self {
        let entity = scene.entities.iter().find(|entity| entity.name == name);
        let material = scene.materials.iter().find(|material| material.name == name);
        match (entity, material) {
            (Some(entity), _) => Self::Entity(entity.id),
            (None, Some(material)) => Self::Material(material.id),
            (None, None) if name.contains(['/', '.']) => Self::File(name.into()),
            (None, None) => Self::Nothing,
        }
    }

    pub fn of(error: &SceneError, scene: &Scene) -> Self {
        match error {
            SceneError::Io { path, .. } | SceneError::File { path, .. } => Self::File(path.clone()),
            SceneError::Entity { entity: name, .. } | SceneError::Material { material: name, .. } => {
                Self::named(name, scene)
            }
            SceneError::Scene(_) => Self::Nothing,
        }
    }
}

#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// Ascends and is never given again.
    pub number: u64,
    pub level: Level,
    pub source: Source,
    pub text: String,
    /// When it was said last.
    pub at: SystemTime,
    /// How often it was said in a row.
    pub times: u32,
}

/// A handle; its clones write into the same lines.
#[derive(Clone, Default)]
pub struct Log(Arc<Mutex<Lines>>);

#[derive(Default)]
struct Lines {
    lines: VecDeque<Line>,
    /// Of each level.
    counts: [usize; 3],
    next: u64,
    /// Counts every change.
    revision: u64,
}

impl Log {
    pub fn push(&self, level: Level, source: Source, text: impl Into<String>) {
        self.lines().push(level, source, text.into());
    }

    pub fn info(&self, text: impl Into<String>) {
        self.push(Level::Info, Source::Nothing, text);
    }

    pub fn warning(&self, source: Source, text: impl Into<String>) {
        self.push(Level::Warning, source, text);
    }

    pub fn error(&self, source: Source, text: impl Into<String>) {
        self.push(Level::Error, source, text);
    }

    pub fn warnings(&self, warnings: &[Warning], scene: &Scene) {
        for warning in warnings {
            self.warning(Source::named(&warning.about, scene), warning.to_string());
        }
    }

    /// The error with its causes, about what it names.
    pub fn scene_error(&self, error: &SceneError, scene: &Scene) {
        self.error(Source::of(error, scene), bake::chain::told(error));
    }

    pub fn clear(&self) {
        let mut lines = self.lines();
        lines.lines.clear();
        lines.counts = [0; 3];
        lines.revision += 1;
    }

    /// Another number: something was written or cleared.
    pub fn revision(&self) -> u64 {
        self.lines().revision
    }

    /// Of these levels, that hold the text in any case of letters; the oldest first.
    pub fn filtered(&self, levels: &[Level], text: &str) -> Vec<Line> {
        let text = text.to_lowercase();
        let shown = |line: &&Line| levels.contains(&line.level) && line.text.to_lowercase().contains(&text);
        self.lines().lines.iter().filter(shown).cloned().collect()
    }

    /// How many lines there are of a level.
    pub fn count(&self, level: Level) -> usize {
        self.lines().counts[level as usize]
    }

    /// A thread that panicked while it wrote leaves the lines as they are.
    fn lines(&self) -> MutexGuard<'_, Lines> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Lines {
    fn push(&mut self, level: Level, source: Source, text: String) {
        self.revision += 1;
        let at = SystemTime::now();
        if let Some(last) = self
            .lines
            .back_mut()
            .filter(|last| last.level == level && last.source == source && last.text == text)
        {
            (last.at, last.times) = (at, last.times.saturating_add(1));
            return;
        }
        if self.lines.len() >= MOST_LINES {
            self.drop_one();
        }
        self.counts[level as usize] += 1;
        self.lines.push_back(Line { number: self.next, level, source, text, at, times: 1 });
        self.next += 1;
    }

    /// The oldest of the lowest level that is there.
    fn drop_one(&mut self) {
        let Some(least) = self.counts.iter().position(|count| *count > 0) else { return };
        let oldest = self.lines.iter().position(|line| line.level as usize == least);
        oldest.map(|at| self.lines.remove(at));
        self.counts[least] -= 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_all_threads_come_in_and_none_is_torn() {
        let log = Log::default();
        std::thread::scope(|threads| {
            for thread in 0..4 {
                let log = log.clone();
                threads.spawn(move || (0..100).for_each(|n| log.info(format!("{thread} {n}"))));
            }
        });
        let lines = log.filtered(&[Level::Info], "");
        assert_eq!(lines.len(), 400);
        assert!(lines.windows(2).all(|pair| pair[0].number < pair[1].number));
        assert_eq!(log.filtered(&[Level::Info], "3 9").len(), 11);
        assert!(log.filtered(&[Level::Error], "").is_empty());
    }

    #[test]
    fn errors_outlive_remarks_and_repeats_are_counted() {
        let log = Log::default();
        log.error(Source::File("a.glb".into()), "Broken file");
        for n in 0..2 * MOST_LINES {
            log.info(n.to_string());
        }
        log.info("twice");
        log.info("twice");
        let lines = log.filtered(&[Level::Info, Level::Error], "");
        assert_eq!(lines.len(), MOST_LINES);
        assert_eq!((lines[0].level, lines[MOST_LINES - 1].times), (Level::Error, 2));
        assert_eq!(log.filtered(&[Level::Error], "broken").len(), 1);
        let before = log.revision();
        log.clear();
        assert!(log.count(Level::Error) == 0 && log.revision() > before);
    }
}
