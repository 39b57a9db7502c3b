//! Which project to open: one of the last, one that is looked for, or a path that is typed.

use std::path::PathBuf;
use std::sync::mpsc::{self, Receiver};

use eframe::egui;
use egui::{Button, Modal, RichText, TextEdit, Ui, vec2};
use engine::scene::file::project_path;

use crate::recent::Preferences;

#[derive(Default)]
pub struct OpenDialog {
    shown: Option<Shown>,
}

struct Shown {
    path: String,
    recent: Vec<PathBuf>,
    /// The desktop's own dialog is open.
    browsing: Option<Receiver<Option<PathBuf>>>,
}

impl OpenDialog {
    pub fn open(&mut self, preferences: &Preferences) {
        let recent: Vec<PathBuf> = preferences.existing_projects().map(PathBuf::from).collect();
        self.shown = Some(Shown { path: String::new(), recent, browsing: None });
    }

    pub fn is_open(&self) -> bool {
        self.shown.is_some()
    }

    /// The project that was chosen.
    pub fn show(&mut self, ui: &Ui) -> Option<PathBuf> {
        let shown = self.shown.as_mut()?;
        let mut chosen = None;
        let modal = Modal::new(egui::Id::unique("open project")).show(ui.ctx(), |ui| {
            ui.set_width(460.0);
            ui.label(RichText::new("Open project").heading());
            ui.add_space(8.0);
            chosen = shown.field(ui).or_else(|| shown.recent(ui));
            ui.add_space(10.0);
            ui.button("Cancel").clicked()
        });
        let close = modal.inner || modal.should_close();
        if chosen.is_some() || close {
            self.shown = None;
        }
        chosen
    }
}

impl Shown {
    fn field(&mut self, ui: &mut Ui) -> Option<PathBuf> {
        ui.horizontal(|ui| {
            let field = TextEdit::singleline(&mut self.path).hint_text("Folder that holds project.ron");
            let field = ui.add_sized(vec2(300.0, 22.0), field);
            field.ctx.accesskit_node_builder(field.id, |node| node.set_label("Folder of the project"));
            self.browse(ui);
            let path = PathBuf::from(self.path.trim());
            let is_project = project_path(&path).is_file();
            let open = ui.add_enabled(is_project, Button::new("Open")).clicked();
            let entered = field.lost_focus() && ui.input(|input| input.key_pressed(egui::Key::Enter));
            (is_project && (open || entered)).then_some(path)
        })
        .inner
    }

    /// The desktop's dialog, on a thread of its own, as it blocks.
    fn browse(&mut self, ui: &mut Ui) {
        if ui.add_enabled(self.browsing.is_none(), Button::new("Browse")).clicked() {
            let (sender, receiver) = mpsc::channel();
            self.browsing = Some(receiver);
            std::thread::spawn(move || {
                // Nobody waits any more where the dialog was closed.
                let _ = sender.send(rfd::FileDialog::new().set_title("Open project").pick_folder());
            });
        }
        let Some(receiver) = &self.browsing else { return };
        match receiver.try_recv() {
            Ok(Some(path)) => self.path = path.display().to_string(),
            Err(mpsc::TryRecvError::Empty) => {
                return ui.ctx().request_repaint_after(std::time::Duration::from_millis(100));
            }
            _ => {}
        }
        self.browsing = None;
    }

    fn recent(&self, ui: &mut Ui) -> Option<PathBuf> {
        if self.recent.is_empty() {
            return None;
        }
        ui.add_space(10.0);
        ui.weak("Opened before");
        let mut chosen = None;
        for project in &self.recent {
            let name = project.file_name().unwrap_or_default().to_string_lossy();
            let button = Button::selectable(false, name.as_ref()).right_text(project.display().to_string());
            if ui.add(button.min_size(vec2(ui.available_width(), 22.0))).clicked() {
                chosen = Some(project.clone());
            }
        }
        chosen
    }
}
