//! Which keys give which command: the table's, and what the user bound instead.

use std::collections::BTreeMap;

use super::{Command, ROWS, Shortcut};

/// Shortcuts that differ from the table's.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Bindings {
    bound: BTreeMap<Command, Vec<Shortcut>>,
}

/// A shortcut that belongs to another command already.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{shortcut} is bound to `{}` already", with.name())]
pub struct Conflict {
    pub shortcut: Shortcut,
    pub with: Command,
}

impl Bindings {
    /// As preferences hold them. What they do not know, or what is no shortcut, is left out and told.
    pub fn from_preferences(texts: &BTreeMap<String, Vec<String>>) -> (Self, Vec<String>) {
        let (mut bindings, mut told) = (Self::default(), Vec::new());
        for (id, shortcuts) in texts {
            let Some(command) = Command::by_id(id) else {
                told.push(format!("preferences bind `{id}`, which is no command"));
                continue;
            };
            let parsed: Result<Vec<Shortcut>, String> = shortcuts.iter().map(|text| text.parse()).collect();
            match parsed {
                Ok(parsed) => drop(bindings.bound.insert(command, parsed)),
                Err(error) => told.push(format!("`{}`: {error}", command.name())),
            }
        }
        (bindings, told)
    }

    pub fn to_preferences(&self) -> BTreeMap<String, Vec<String>> {
        let texts = |shortcuts: &Vec<Shortcut>| shortcuts.iter().map(Shortcut::to_string).collect();
        self.bound.iter().map(|(command, shortcuts)| (command.id().to_owned(), texts(shortcuts))).collect()
    }

    /// The first is the one to show.
    pub fn shortcuts(&self, command: Command) -> Vec<Shortcut> {
        let usual = || command.row().shortcuts.iter().filter_map(|text| text.parse().ok()).collect();
        self.bound.get(&command).cloned().unwrap_or_else(usual)
    }

    pub fn command(&self, shortcut: Shortcut) -> Option<Command> {
        let has = |command: &Command| self.shortcuts(*command).contains(&shortcut);
        ROWS.iter().map(|row| row.command).find(has)
    }

    /// Refused, and nothing changed, where another command has one of them.
    pub fn bind(&mut self, command: Command, shortcuts: Vec<Shortcut>) -> Result<(), Conflict> {
        let other = |shortcut: &Shortcut| self.command(*shortcut).filter(|other| *other != command);
        let taken = shortcuts.iter().find_map(|shortcut| Some((*shortcut, other(shortcut)?)));
        if let Some((shortcut, with)) = taken {
            return Err(Conflict { shortcut, with });
        }
        if shortcuts == Self::default().shortcuts(command) {
            self.bound.remove(&command);
        } else {
            self.bound.insert(command, shortcuts);
        }
        Ok(())
    }

    /// The same, taken away from whom they belonged to.
    pub fn take_over(&mut self, command: Command, shortcuts: Vec<Shortcut>) {
        while let Err(Conflict { shortcut, with }) = self.bind(command, shortcuts.clone()) {
            let left = self.shortcuts(with).into_iter().filter(|other| *other != shortcut).collect();
            self.bound.insert(with, left);
        }
    }

    /// The table's again. What others took over meanwhile stays with them, see [`Self::conflicts`].
    pub fn reset(&mut self, command: Command) {
        self.bound.remove(&command);
    }

    pub fn reset_all(&mut self) {
        self.bound.clear();
    }

    /// Shortcuts that two commands have: the second gets nothing from them.
    pub fn conflicts(&self) -> Vec<(Command, Conflict)> {
        let mut owner: BTreeMap<Shortcut, Command> = BTreeMap::new();
        let mut found = Vec::new();
        for command in ROWS.iter().map(|row| row.command) {
            for shortcut in self.shortcuts(command) {
                match owner.get(&shortcut) {
                    Some(with) => found.push((command, Conflict { shortcut, with: *with })),
                    None => drop(owner.insert(shortcut, command)),
                }
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn keys(text: &str) -> Shortcut {
        text.parse().unwrap()
    }

    #[test]
    fn the_table_has_no_conflicts() {
        let told: Vec<String> = Bindings::default()
            .conflicts()
            .iter()
            .map(|(command, conflict)| format!("{}: {conflict}", command.name()))
            .collect();
        assert!(told.is_empty(), "{told:?}");
        assert_eq!(Bindings::default().command(keys("Ctrl+Y")), Some(Command::Redo));
    }

    #[test]
    fn a_shortcut_that_is_taken_is_refused_or_taken_over() {
        let mut bindings = Bindings::default();
        let error = bindings.bind(Command::Bake, vec![keys("Ctrl+D")]).unwrap_err();
        assert_eq!(error.to_string(), "Ctrl+D is bound to `Duplicate` already");
        assert_eq!(bindings, Bindings::default());
        bindings.take_over(Command::Bake, vec![keys("Ctrl+D")]);
        assert_eq!(bindings.command(keys("Ctrl+D")), Some(Command::Bake));
        assert!(bindings.shortcuts(Command::Duplicate).is_empty() && bindings.conflicts().is_empty());
        bindings.reset(Command::Duplicate);
        assert_eq!(bindings.conflicts().len(), 1);
        bindings.reset_all();
        assert_eq!(bindings, Bindings::default());
    }

    #[test]
    fn bindings_come_back_from_preferences_and_nonsense_is_told() {
        let mut bindings = Bindings::default();
        bindings.bind(Command::Bake, vec![keys("Ctrl+F5"), keys("F9")]).unwrap();
        bindings.bind(Command::Save, vec![]).unwrap();
        let mut texts = bindings.to_preferences();
        assert_eq!(Bindings::from_preferences(&texts), (bindings, vec![]));
        texts.insert("no.such".to_owned(), vec![]);
        texts.insert("edit.undo".to_owned(), vec!["Ctrl+Nothing".to_owned()]);
        let (read, told) = Bindings::from_preferences(&texts);
        assert_eq!(told.len(), 2, "{told:?}");
        assert_eq!(read.command(keys("Ctrl+Z")), Some(Command::Undo));
    }
}
