//! Every command: its name, its shortcut, and when it can be given. Menus, the palette and the keyboard read this
//! table, and a shortcut is a word in it.

mod bindings;
mod shortcut;
mod table;

pub use bindings::{Bindings, Conflict};
pub use shortcut::{Key, Shortcut};
pub use table::{Command, ROWS};

/// One row of the table.
#[derive(Debug)]
pub struct Row {
    pub command: Command,
    /// In preferences and logs; never changes.
    pub id: &'static str,
    /// In menus.
    pub name: &'static str,
    pub category: Category,
    /// The usual ones, the first shown in menus.
    pub shortcuts: &'static [&'static str],
    pub needs: Needs,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Category {
    File,
    Edit,
    Create,
    Hierarchy,
    Tool,
    View,
    Draw,
    Assets,
    Play,
    Light,
    Console,
    Window,
    /// Of panels. In no menu: there the mark before a panel is taken away.
    Close,
}

impl Category {
    pub fn name(self) -> &'static str {
        match self {
            Self::File => "File",
            Self::Edit => "Edit",
            Self::Create => "Create",
            Self::Hierarchy => "Hierarchy",
            Self::Tool => "Tool",
            Self::View => "View",
            Self::Draw => "Draw mode",
            Self::Assets => "Assets",
            Self::Play => "Play",
            Self::Light => "Light",
            Self::Console => "Console",
            Self::Window => "Window",
            Self::Close => "Close panel",
        }
    }
}

/// What has to be there for a command to make sense.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Needs {
    Nothing,
    /// An open scene, in play or not.
    Scene,
    /// An open scene that is authored, not played.
    Authoring,
    /// Something selected in it.
    Selected,
    /// Two selected or more.
    SeveralSelected,
    Undo,
    Redo,
    /// Something to paste.
    Clipboard,
    Playing,
    /// No bake going on.
    NotBaking,
    Baking,
    /// An asset selected.
    Asset,
}

/// What is the case at the moment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct State {
    pub has_scene: bool,
    pub is_playing: bool,
    pub is_baking: bool,
    /// Entities that are selected.
    pub selected: usize,
    pub asset_selected: bool,
    pub can_undo: bool,
    pub can_redo: bool,
    pub can_paste: bool,
}

impl Needs {
    pub fn are_met(self, state: &State) -> bool {
        let authoring = state.has_scene && !state.is_playing;
        match self {
            Self::Nothing => true,
            Self::Scene => state.has_scene,
            Self::Authoring => authoring,
            Self::Selected => authoring && state.selected > 0,
            Self::SeveralSelected => authoring && state.selected > 1,
            Self::Undo => authoring && state.can_undo,
            Self::Redo => authoring && state.can_redo,
            Self::Clipboard => authoring && state.can_paste,
            Self::Playing => state.has_scene && state.is_playing,
            Self::NotBaking => authoring && !state.is_baking,
            Self::Baking => state.is_baking,
            Self::Asset => authoring && state.asset_selected,
        }
    }
}

impl Command {
    pub fn row(self) -> &'static Row {
        &ROWS[self as usize]
    }

    pub fn id(self) -> &'static str {
        self.row().id
    }

    pub fn name(self) -> &'static str {
        self.row().name
    }

    pub fn by_id(id: &str) -> Option<Self> {
        ROWS.iter().find(|row| row.id == id).map(|row| row.command)
    }

    pub fn is_enabled(self, state: &State) -> bool {
        self.row().needs.are_met(state)
    }
}

/// What the palette shows: commands whose name or category holds the letters in this order, the closest first.
pub fn search(letters: &str) -> Vec<&'static Row> {
    let wanted: Vec<char> = letters.to_lowercase().chars().filter(|c| !c.is_whitespace()).collect();
    let rank = |row: &'static Row| {
        let name = row.name.to_lowercase();
        let whole = format!("{name} {}", row.category.name().to_lowercase());
        gaps(&wanted, &name).map(|gaps| (0, gaps)).or(gaps(&wanted, &whole).map(|gaps| (1, gaps)))
    };
    let mut found: Vec<_> = ROWS.iter().filter_map(|row| Some((rank(row)?, row))).collect();
    found.sort_by_key(|(rank, _)| *rank); // stable: equals stay in the table's order
    found.into_iter().map(|(_, row)| row).collect()
}

/// Letters left out between those that are found, from the first of a word on. `None`: not all are there.
fn gaps(wanted: &[char], text: &str) -> Option<usize> {
    let text: Vec<char> = text.chars().collect();
    let starts = (0..text.len()).filter(|&at| at == 0 || text[at - 1] == ' ');
    starts
        .filter_map(|start| gaps_from(wanted, &text[start..]).map(|gaps| gaps + usize::from(start > 0)))
        .min()
}

fn gaps_from(wanted: &[char], text: &[char]) -> Option<usize> {
    let mut gaps = 0;
    let mut at = 0;
    for letter in wanted {
        let step = text[at..].iter().position(|c| c == letter)?;
        gaps += step;
        at += step + 1;
    }
    Some(gaps)
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    #[test]
    fn the_table_holds_each_command_once_and_in_order() {
        for (n, row) in ROWS.iter().enumerate() {
            assert_eq!(row.command as usize, n, "{}", row.id);
            assert_eq!(Command::by_id(row.id), Some(row.command));
            assert!(row.shortcuts.iter().all(|text| text.parse::<Shortcut>().is_ok()), "{}", row.id);
        }
        let names: HashSet<_> = ROWS.iter().map(|row| (row.category, row.name)).collect();
        assert_eq!(names.len(), ROWS.len());
    }

    #[test]
    fn commands_are_enabled_by_what_is_there() {
        let nothing = State::default();
        assert!(Command::OpenProject.is_enabled(&nothing) && !Command::Save.is_enabled(&nothing));
        let scene = State { has_scene: true, ..nothing };
        assert!(Command::Save.is_enabled(&scene) && !Command::Delete.is_enabled(&scene));
        let selected = State { selected: 1, ..scene };
        assert!(Command::Delete.is_enabled(&selected) && !Command::ParentToActive.is_enabled(&selected));
        let playing = State { is_playing: true, ..selected };
        assert!(!Command::Delete.is_enabled(&playing) && Command::Pause.is_enabled(&playing));
        assert!(Command::Play.is_enabled(&playing) && Command::Play.is_enabled(&scene));
    }

    #[test]
    fn the_readme_tells_keys_that_give_what_it_says() {
        let readme = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../README.md");
        let readme = std::fs::read_to_string(readme).unwrap();
        let table = readme.split("| keys | command |\n|---|---|\n").nth(1).unwrap();
        let rows: Vec<&str> = table.lines().take_while(|line| line.starts_with('|')).collect();
        assert!(rows.len() > 15);
        for row in rows {
            let cells: Vec<&str> = row.trim_matches('|').split('|').map(str::trim).collect();
            let given = Bindings::default().command(cells[0].parse().unwrap());
            assert_eq!(given.map(Command::name), Some(cells[1]), "{row}");
        }
    }

    #[test]
    fn the_palette_finds_commands_by_their_letters() {
        let first = |letters: &str| search(letters)[0].command;
        assert_eq!(first("save"), Command::Save);
        assert_eq!(first("dup"), Command::Duplicate);
        assert_eq!(first("crcube"), Command::CreateCube);
        assert_eq!(first("BAKE"), Command::Bake);
        assert_eq!(search("").len(), ROWS.len());
        assert!(search("xyzzyq").is_empty());
    }
}
