//! What is asked before a scene or a project is opened, made or saved anew: which one, or under which name.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, Receiver};
use std::time::Duration;

use eframe::egui;
use egui::{Button, Key, RichText, ScrollArea, TextEdit, Ui, vec2};
use engine::scene::file::scene_names;

use super::folder::Folder;
use crate::command::Command;
use crate::document::is_name;
use crate::recent::Preferences;
use crate::theme;

/// What was chosen.
#[derive(Clone, Debug, PartialEq)]
pub enum Chosen {
    Project(PathBuf),
    /// The folder that it is to be, which need not be there.
    NewProject(PathBuf),
    /// Of this project.
    Scene(String),
    NewScene(String),
    SaveAs(String),
}

/// At most one question at a time.
#[derive(Default)]
pub struct FileDialog {
    asked: Option<Asked>,
}

struct Asked {
    question: Command,
    folder: Folder,
    name: String,
    /// Of the project that is open.
    scene: String,
    found: Found,
    /// The disk is read on a thread of its own.
    finding: Option<Receiver<Found>>,
    /// The field has the keyboard from the first picture on.
    is_new: bool,
}

#[derive(Default)]
struct Found {
    projects: Vec<PathBuf>,
    scenes: Vec<String>,
}

impl FileDialog {
    /// `question`: the command that has to know. `scene`: the one that is open.
    pub fn ask(&mut self, question: Command, preferences: &Preferences, project: &Path, scene: &str) {
        let (sender, receiver) = mpsc::channel();
        let (remembered, own) = (preferences.clone(), project.to_owned());
        std::thread::spawn(move || {
            let projects = remembered.existing_projects().map(PathBuf::from).collect();
            let scenes = scene_names(&own).unwrap_or_default();
            // Nobody waits any more where the dialog was closed.
            let _ = sender.send(Found { projects, scenes });
        });
        let folder = match question {
            Command::NewProject => {
                std::path::absolute(project).ok().and_then(|own| Some(Folder::of(own.parent()?)))
            }
            _ => None,
        };
        let name = if question == Command::SaveAs { format!("{scene} 2") } else { String::new() };
        self.asked = Some(Asked {
            question,
            folder: folder.unwrap_or_default(),
            name,
            scene: scene.to_owned(),
            found: Found::default(),
            finding: Some(receiver),
            is_new: true,
        });
    }

    pub fn is_open(&self) -> bool {
        self.asked.is_some()
    }

    pub fn show(&mut self, ui: &Ui) -> Option<Chosen> {
        let asked = self.asked.as_mut()?;
        asked.take_found(ui);
        let modal = theme::dialog(ui, "file dialog").show(ui.ctx(), |ui| {
            ui.set_width(480.0);
            ui.label(RichText::new(asked.question.name()).heading());
            ui.add_space(8.0);
            asked.body(ui)
        });
        let is_closed = modal.should_close();
        let (chosen, is_cancelled) = modal.inner;
        asked.is_new = false;
        if chosen.is_some() || is_cancelled || is_closed {
            self.asked = None;
        }
        chosen
    }
}

impl Asked {
    fn take_found(&mut self, ui: &Ui) {
        let Some(finding) = &self.finding else { return };
        match finding.try_recv() {
            Ok(found) => (self.found, self.finding) = (found, None),
            Err(mpsc::TryRecvError::Disconnected) => self.finding = None,
            Err(mpsc::TryRecvError::Empty) => ui.ctx().request_repaint_after(Duration::from_millis(20)),
        }
    }

    /// What was chosen, and whether nothing is to be.
    fn body(&mut self, ui: &mut Ui) -> (Option<Chosen>, bool) {
        let mut chosen = None;
        let (is_entered, why_not) = match self.question {
            Command::OpenProject => {
                let field = self.folder.show(ui, "Folder of the project", "Folder that holds project.ron");
                self.first_focus(&field);
                chosen = self.recent(ui);
                (entered(&field, ui), self.folder.is_empty().then_some("Type or browse for a folder"))
            }
            Command::NewProject => self.new_project(ui),
            Command::OpenScene => {
                chosen = self.scenes(ui);
                (false, Some("Choose a scene"))
            }
            _ => {
                let field = self.name_field(ui, "Name of the scene");
                (entered(&field, ui), self.name_is_wrong())
            }
        };
        ui.add_space(12.0);
        let (is_given, is_cancelled) = self.buttons(ui, why_not);
        if why_not.is_none() && (is_entered || is_given) {
            chosen = Some(self.chosen());
        }
        (chosen, is_cancelled)
    }

    fn chosen(&self) -> Chosen {
        let name = self.name.trim().to_owned();
        match self.question {
            Command::NewProject => Chosen::NewProject(self.folder.path().join(name)),
            Command::NewScene => Chosen::NewScene(name),
            Command::SaveAs => Chosen::SaveAs(name),
            _ => Chosen::Project(self.folder.path()),
        }
    }

    fn buttons(&self, ui: &mut Ui, why_not: Option<&str>) -> (bool, bool) {
        let verb = match self.question {
            Command::OpenProject => "Open",
            Command::SaveAs => "Save",
            Command::OpenScene => "",
            _ => "Create",
        };
        ui.horizontal(|ui| {
            let button = |name: &str| Button::new(name.to_owned()).min_size(vec2(84.0, 24.0));
            let is_given = !verb.is_empty() && ui.add_enabled(why_not.is_none(), button(verb)).clicked();
            let is_cancelled = ui.add(button("Cancel")).clicked();
            if let Some(why_not) = why_not.filter(|_| !verb.is_empty()) {
                ui.add_space(6.0);
                ui.weak(why_not);
            }
            (is_given, is_cancelled)
        })
        .inner
    }

    fn first_focus(&self, field: &egui::Response) {
        if self.is_new {
            field.request_focus();
        }
    }

    fn name_field(&mut self, ui: &mut Ui, name: &str) -> egui::Response {
        let field = TextEdit::singleline(&mut self.name).hint_text("Name").desired_width(f32::INFINITY);
        let field = ui.add(field.min_size(vec2(0.0, 22.0)));
        field.ctx.accesskit_node_builder(field.id, |node| node.set_label(name));
        self.first_focus(&field);
        field
    }

    /// Of a scene that is not there yet.
    fn name_is_wrong(&self) -> Option<&'static str> {
        let name = self.name.trim();
        match name {
            "" => Some("Type a name"),
            _ if !is_name(name) => Some("No file can be called that"),
            _ if self.found.scenes.iter().any(|scene| scene == name) => Some("There is one of that name"),
            _ => None,
        }
    }

    fn new_project(&mut self, ui: &mut Ui) -> (bool, Option<&'static str>) {
        ui.weak("A folder of its name is made in");
        let place = self.folder.show(ui, "Folder in which it is made", "Folder");
        ui.add_space(4.0);
        let name = self.name_field(ui, "Name of the project");
        let why_not = match self.name.trim() {
            "" => Some("Type a name"),
            name if !is_name(name) => Some("No folder can be called that"),
            _ => self.folder.is_empty().then_some("Type or browse for a folder"),
        };
        (entered(&place, ui) || entered(&name, ui), why_not)
    }

    fn recent(&self, ui: &mut Ui) -> Option<Chosen> {
        if self.found.projects.is_empty() {
            return None;
        }
        ui.add_space(10.0);
        ui.weak("Opened before");
        let mut chosen = None;
        for project in &self.found.projects {
            let name = project.file_name().unwrap_or_default().to_string_lossy();
            let button = Button::selectable(false, name.as_ref()).right_text(project.display().to_string());
            if ui.add(button.min_size(vec2(ui.available_width(), 22.0))).clicked() {
                chosen = Some(Chosen::Project(project.clone()));
            }
        }
        chosen
    }

    fn scenes(&self, ui: &mut Ui) -> Option<Chosen> {
        let mut chosen = None;
        if self.finding.is_some() {
            ui.weak("Reading the project");
        }
        ScrollArea::vertical().max_height(320.0).auto_shrink([false, true]).show(ui, |ui| {
            for scene in &self.found.scenes {
                let is_open = *scene == self.scene;
                let button = Button::selectable(is_open, scene).min_size(vec2(ui.available_width(), 22.0));
                let button = if is_open { button.right_text("open") } else { button };
                if ui.add(button).clicked() {
                    chosen = Some(Chosen::Scene(scene.clone()));
                }
            }
        });
        chosen
    }
}

fn entered(field: &egui::Response, ui: &Ui) -> bool {
    field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter))
}
