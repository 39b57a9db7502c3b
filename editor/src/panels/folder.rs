//! A folder: typed, or looked for with the desktop's own dialog.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, Receiver};
use std::time::Duration;

use eframe::egui;
use egui::{Button, Response, TextEdit, Ui, vec2};

#[derive(Default)]
pub struct Folder {
    text: String,
    /// The desktop's own dialog is open.
    browsing: Option<Receiver<Option<PathBuf>>>,
}

impl Folder {
    pub fn of(path: &Path) -> Self {
        Self { text: path.display().to_string(), browsing: None }
    }

    pub fn path(&self) -> PathBuf {
        PathBuf::from(self.text.trim())
    }

    pub fn is_empty(&self) -> bool {
        self.text.trim().is_empty()
    }

    /// `name`: what screen readers say. Gives the field.
    pub fn show(&mut self, ui: &mut Ui, name: &str, hint: &str) -> Response {
        ui.horizontal(|ui| {
            let width = ui.available_width() - 80.0;
            let field = ui.add_sized(vec2(width, 22.0), TextEdit::singleline(&mut self.text).hint_text(hint));
            field.ctx.accesskit_node_builder(field.id, |node| node.set_label(name));
            self.browse(ui, name);
            field
        })
        .inner
    }

    /// The desktop's dialog, on a thread of its own, as it blocks.
    fn browse(&mut self, ui: &mut Ui, name: &str) {
        let button = Button::new("Browse").min_size(vec2(70.0, 22.0));
        if ui.add_enabled(self.browsing.is_none(), button).clicked() {
            let (sender, receiver) = mpsc::channel();
            self.browsing = Some(receiver);
            let title = name.to_owned();
            std::thread::spawn(move || {
                // Nobody waits any more where the dialog was closed.
                let _ = sender.send(rfd::FileDialog::new().set_title(title).pick_folder());
            });
        }
        let Some(receiver) = &self.browsing else { return };
        match receiver.try_recv() {
            Ok(Some(path)) => self.text = path.display().to_string(),
            Err(mpsc::TryRecvError::Empty) => {
                return ui.ctx().request_repaint_after(Duration::from_millis(100));
            }
            _ => {}
        }
        self.browsing = None;
    }
}
