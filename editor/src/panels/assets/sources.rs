//! The files that an import is asked for: one that is typed, or those that were chosen in the desktop's own dialog. Not
//! every desktop has one, and a path can be pasted.

use std::path::PathBuf;
use std::sync::mpsc::{self, Receiver, TryRecvError};
use std::time::Duration;

use eframe::egui;
use egui::{Button, Key, TextEdit, Ui, vec2};

#[derive(Default)]
pub struct Sources {
    typed: String,
    /// Where it is not empty, nothing is typed.
    chosen: Vec<PathBuf>,
    browsing: Option<Receiver<Vec<PathBuf>>>,
    /// The field has had the keyboard.
    was_shown: bool,
}

/// Dialogs tell large letters from small ones.
const ENDINGS: [&str; 18] = [
    "gltf", "glb", "obj", "png", "jpg", "jpeg", "hdr", "bmp", "tga", "GLTF", "GLB", "OBJ", "PNG", "JPG",
    "JPEG", "HDR", "BMP", "TGA",
];

impl Sources {
    pub fn files(&self) -> Vec<PathBuf> {
        // As other programs put a path into the clipboard.
        let typed = self.typed.trim().trim_matches(['"', '\'']);
        let typed = Some(PathBuf::from(typed)).filter(|path| !path.as_os_str().is_empty());
        if self.chosen.is_empty() { typed.into_iter().collect() } else { self.chosen.clone() }
    }

    /// In a title.
    pub fn told(&self) -> String {
        match self.files().as_slice() {
            [] => "files".to_owned(),
            [one] => format!("`{}`", one.file_name().unwrap_or_default().to_string_lossy()),
            many => format!("{} files", many.len()),
        }
    }

    /// Whether Enter said that these are it.
    pub fn show(&mut self, ui: &mut Ui) -> bool {
        self.take_browsed(ui);
        let entered = ui.horizontal(|ui| {
            let width = ui.available_width() - 80.0;
            let entered = match self.chosen.is_empty() {
                true => self.field(ui, width),
                false => self.several(ui, width),
            };
            self.browse(ui);
            entered
        });
        entered.inner
    }

    fn field(&mut self, ui: &mut Ui, width: f32) -> bool {
        let hint = "A glTF, GLB or OBJ file, or a picture";
        let field = ui.add_sized(vec2(width, 22.0), TextEdit::singleline(&mut self.typed).hint_text(hint));
        field.ctx.accesskit_node_builder(field.id, |node| node.set_label("File to import"));
        if !std::mem::replace(&mut self.was_shown, true) {
            field.request_focus();
        }
        field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter))
    }

    fn several(&mut self, ui: &mut Ui, width: f32) -> bool {
        let names = self.chosen.iter().filter_map(|file| Some(file.file_name()?.to_string_lossy()));
        let names = names.collect::<Vec<_>>().join(", ");
        ui.add_sized(vec2(width, 22.0), egui::Label::new(&names).truncate()).on_hover_text(names);
        false
    }

    /// The desktop's dialog blocks: it is on a thread of its own.
    fn browse(&mut self, ui: &mut Ui) {
        let button = Button::new("Browse").min_size(vec2(70.0, 22.0));
        if !ui.add_enabled(self.browsing.is_none(), button).clicked() {
            return;
        }
        let (sender, receiver) = mpsc::channel();
        self.browsing = Some(receiver);
        std::thread::spawn(move || {
            let dialog = rfd::FileDialog::new()
                .set_title("Import")
                .add_filter("Models and pictures", &ENDINGS)
                .add_filter("All files", &["*"]);
            // Nobody waits any more where the dialog was closed.
            let _ = sender.send(dialog.pick_files().unwrap_or_default());
        });
    }

    fn take_browsed(&mut self, ui: &Ui) {
        let Some(browsing) = &self.browsing else { return };
        match browsing.try_recv() {
            Err(TryRecvError::Empty) => {
                return ui.ctx().request_repaint_after(Duration::from_millis(100));
            }
            // One can be mended by hand.
            Ok(files) if files.len() == 1 => {
                (self.typed, self.chosen) = (files[0].display().to_string(), Vec::new());
            }
            Ok(files) if !files.is_empty() => self.chosen = files,
            _ => {}
        }
        self.browsing = None;
    }
}
