//! What is asked before files are read, relinked or deleted.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, Receiver};

use eframe::egui;
use egui::{Button, ComboBox, DragValue, RichText, ScrollArea, TextEdit, Ui, vec2};
use engine::scene::import::settings::{self, ImportSettings, Normals, Structure, Up};

use super::AssetList;
use super::sources::Sources;
use crate::ask::Asks;
use crate::assets::{self, Place, Wish};
use crate::document::Document;
use crate::theme;

pub enum Dialog {
    Delete {
        file: String,
        /// References to it, or to what lies in it.
        users: usize,
    },
    Relink {
        from: String,
        search: String,
        /// The desktop's own dialog is open.
        browsing: Option<Receiver<Option<PathBuf>>>,
    },
    Import {
        sources: Sources,
        settings: ImportSettings,
        place: bool,
    },
    Settings {
        file: String,
        settings: ImportSettings,
        /// Those that lie beside the file, being read.
        read: Option<Receiver<ImportSettings>>,
    },
}

impl Dialog {
    pub fn relink(file: &str) -> Self {
        Self::Relink { from: file.to_owned(), search: String::new(), browsing: None }
    }

    pub fn import() -> Self {
        Self::Import { sources: Sources::default(), settings: ImportSettings::default(), place: true }
    }

    pub fn settings(project: &Path, file: &str) -> Self {
        let (sender, read) = mpsc::channel();
        let path = project.join(file);
        std::thread::spawn(move || {
            // Nobody waits any more where the dialog was closed; what cannot be read is told when it is imported.
            let _ = sender.send(settings::load(&path).unwrap_or_default());
        });
        let settings = ImportSettings::default();
        Self::Settings { file: file.to_owned(), settings, read: Some(read) }
    }

    /// Whether it stays open.
    pub fn show(&mut self, ui: &Ui, list: &AssetList, document: &Document, asks: &mut Asks) -> bool {
        let modal = theme::dialog(ui, "assets dialog").show(ui.ctx(), |ui| {
            ui.set_width(380.0);
            ui.label(RichText::new(self.title()).heading());
            ui.add_space(8.0);
            let closes = self.body(ui, list, document, asks);
            closes || ui.input(|input| input.key_pressed(egui::Key::Escape))
        });
        !modal.inner && !modal.should_close()
    }

    fn title(&self) -> String {
        match self {
            Self::Delete { file, .. } => format!("Delete `{}`?", assets::name(file)),
            Self::Relink { from, .. } => format!("Relink `{}`", assets::name(from)),
            Self::Import { sources, .. } => format!("Import {}", sources.told()),
            Self::Settings { file, .. } => format!("Import settings of `{}`", assets::name(file)),
        }
    }

    /// Whether it is over.
    fn body(&mut self, ui: &mut Ui, list: &AssetList, document: &Document, asks: &mut Asks) -> bool {
        match self {
            Self::Delete { file, users } => delete(ui, file, *users, asks),
            Self::Relink { from, search, browsing } => {
                relink(ui, from, search, list, asks) || from_elsewhere(ui, from, browsing, document, asks)
            }
            Self::Import { sources, settings, place } => {
                let is_entered = sources.show(ui);
                ui.add_space(8.0);
                fields(ui, settings);
                ui.checkbox(place, "Place in the scene").on_hover_text("In the middle of the scene view");
                ui.add_space(10.0);
                let pressed = buttons(ui, "Import", !sources.files().is_empty());
                let files = if is_entered || pressed == Some(true) { sources.files() } else { Vec::new() };
                if files.is_empty() {
                    return pressed.is_some();
                }
                let place = place.then_some(Place::At(list.pivot));
                asks.push(Wish::Bring { sources: files, settings: Some(*settings), place });
                true
            }
            Self::Settings { file, settings, read } => {
                if let Some(known) = read.as_ref().and_then(|read| read.try_recv().ok()) {
                    (*settings, *read) = (known, None);
                }
                ui.add_enabled_ui(read.is_none(), |ui| fields(ui, settings));
                ui.weak("All objects made of it follow, except where they were edited since.");
                ui.add_space(10.0);
                let pressed = buttons(ui, "Apply", true);
                if pressed == Some(true) {
                    asks.push(Wish::Again { file: file.clone(), settings: Some(*settings) });
                }
                pressed.is_some()
            }
        }
    }
}

fn delete(ui: &mut Ui, file: &str, users: usize, asks: &mut Asks) -> bool {
    let text = match users {
        0 => "Nothing in this scene uses it.".to_owned(),
        1 => "It is used once in this scene: what uses it will show nothing.".to_owned(),
        users => format!("It is used {users} times in this scene: what uses it will show nothing."),
    };
    ui.label(text);
    ui.label("The file goes from the disk. This cannot be undone.");
    ui.add_space(10.0);
    let pressed = buttons(ui, "Delete", true);
    if pressed == Some(true) {
        asks.push(Wish::Delete { file: file.to_owned() });
    }
    pressed.is_some()
}

/// Files of the project of the same kind, those of the same name first.
fn relink(ui: &mut Ui, from: &str, search: &mut String, list: &AssetList, asks: &mut Asks) -> bool {
    ui.label(format!("{from} is missing. Choose the file that stands for it:"));
    let field = TextEdit::singleline(search).hint_text("Search").desired_width(f32::INFINITY);
    let field = ui.add(field);
    field.ctx.accesskit_node_builder(field.id, |node| node.set_label("Search for a file"));
    let kind = assets::kind(from);
    let is_alike = |asset: &&assets::Asset| asset.kind == kind && asset.file != from;
    let mut found: Vec<&str> =
        assets::search(list.assets(), search).into_iter().filter(is_alike).map(|a| a.file.as_str()).collect();
    found.sort_by_key(|file| (assets::name(file) != assets::name(from), *file));
    let mut chosen = None;
    ScrollArea::vertical().max_height(180.0).auto_shrink([false, true]).show(ui, |ui| {
        for file in &found {
            let button = Button::selectable(false, *file).min_size(vec2(ui.available_width(), 20.0));
            let response = ui.add(button);
            response.ctx.accesskit_node_builder(response.id, |node| node.set_label(format!("Use {file}")));
            if response.clicked() {
                chosen = Some((*file).to_owned());
            }
        }
        if found.is_empty() {
            ui.weak("The project has no other such file");
        }
    });
    ui.add_space(8.0);
    let Some(to) = chosen else { return false };
    asks.push(Wish::Relink { from: from.to_owned(), to });
    true
}

/// The desktop's dialog blocks: it is on a thread of its own.
fn from_elsewhere(
    ui: &mut Ui,
    from: &str,
    browsing: &mut Option<Receiver<Option<PathBuf>>>,
    document: &Document,
    asks: &mut Asks,
) -> bool {
    let (browse, cancel) = ui
        .horizontal(|ui| {
            let browse = ui.add_enabled(browsing.is_none(), Button::new("From disk\u{2026}"));
            (browse.clicked(), ui.button("Cancel").clicked())
        })
        .inner;
    if browse {
        let (sender, receiver) = mpsc::channel();
        let folder = document.project().to_owned();
        *browsing = Some(receiver);
        std::thread::spawn(move || {
            let dialog = rfd::FileDialog::new().set_title("Relink").set_directory(folder);
            let _ = sender.send(dialog.pick_file());
        });
    }
    match browsing.as_ref().map(Receiver::try_recv) {
        Some(Ok(Some(source))) => {
            asks.push(Wish::RelinkFrom { from: from.to_owned(), source });
            return true;
        }
        Some(Err(mpsc::TryRecvError::Empty)) => {
            ui.ctx().request_repaint_after(std::time::Duration::from_millis(100));
        }
        Some(_) => *browsing = None,
        None => {}
    }
    cancel
}

fn fields(ui: &mut Ui, settings: &mut ImportSettings) {
    egui::Grid::new("import settings").num_columns(2).spacing(vec2(16.0, 7.0)).show(ui, |ui| {
        let label = ui.label("Scale");
        let scale = DragValue::new(&mut settings.scale).speed(0.01).range(1e-6..=1e6).max_decimals(6);
        ui.add_sized(vec2(180.0, 20.0), scale)
            .labelled_by(label.id)
            .on_hover_text("Metres of one unit of the file");
        ui.end_row();
        let tooltip = "Which axis of the file points up: glTF says Y, many OBJ files mean Z";
        choice(ui, ("Up axis", tooltip), &mut settings.up, &[(Up::Y, "Y"), (Up::Z, "Z")]);
        let normals = [(Normals::File, "The file's"), (Normals::Flat, "Flat"), (Normals::Smooth, "Smooth")];
        let tooltip = "The file's own, or made of its faces: each face flat, or smooth over their edges";
        choice(ui, ("Normals", tooltip), &mut settings.normals, &normals);
        let structures =
            [(Structure::Hierarchy, "As in the file"), (Structure::One, "One object of all meshes")];
        let tooltip = "One object for each of the file, under each other as there, or a single one";
        choice(ui, ("Objects", tooltip), &mut settings.structure, &structures);
    });
    ui.add_space(4.0);
}

fn choice<T: PartialEq + Copy>(
    ui: &mut Ui,
    (name, tooltip): (&str, &str),
    value: &mut T,
    choices: &[(T, &str)],
) {
    ui.label(name).on_hover_text(tooltip);
    let said = choices.iter().find(|(choice, _)| choice == value).map_or("", |(_, said)| said);
    let shown = ComboBox::from_id_salt(name).selected_text(said).width(180.0).show_ui(ui, |ui| {
        for (choice, said) in choices {
            ui.selectable_value(value, *choice, *said);
        }
    });
    let id = shown.response.on_hover_text(tooltip).id;
    ui.ctx().accesskit_node_builder(id, |node| node.set_label(name));
    ui.end_row();
}

/// `Some(true)`: it is to be done; `Some(false)`: it is not.
fn buttons(ui: &mut Ui, does: &str, can: bool) -> Option<bool> {
    let button = |ui: &mut Ui, name: &str, can: bool| {
        ui.add_enabled(can, Button::new(name).min_size(vec2(84.0, 24.0))).clicked()
    };
    ui.horizontal(|ui| {
        let (yes, no) = (button(ui, does, can), button(ui, "Cancel", true));
        (yes || no).then_some(yes)
    })
    .inner
}
