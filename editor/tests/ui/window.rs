//! The editor in a window that nobody sees: driven by mouse and keyboard, found by what screen readers are told.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use editor::app::{Editor, wgpu_setup_headless};
use editor::gizmo::Stand;
use editor::intents::Intent;
use editor::lens::Lens;
use editor::log::Level;
use editor::opened::Opened;
use editor::theme;
use eframe::egui_wgpu::{RenderState, RendererOptions, WgpuConfiguration};
use egui::accesskit::Role;
use egui::{Key, Modifiers, Pos2, Rect, Vec2};
use egui_kittest::kittest::Queryable;
use egui_kittest::wgpu::WgpuTestRenderer;
use egui_kittest::{Harness, Node};
use engine::render::Eye;
use engine::scene::file::text_of_scene;
use engine::scene::{Entity, EntityId};
use glam::{DQuat, DVec3};

pub struct Window {
    pub harness: Harness<'static, Editor>,
    /// Where its project lies, unless that is another's.
    folder: Option<tempfile::TempDir>,
}

/// The Cornell box, not baked. `None`, with a line, where there is no GPU.
pub fn open() -> Option<Window> {
    open_sized(Vec2::new(1280.0, 720.0))
}

pub fn open_sized(size: Vec2) -> Option<Window> {
    let folder = tempfile::tempdir().unwrap();
    let project = cornell(folder.path());
    let mut window = open_project(&project, None, size)?;
    window.folder = Some(folder);
    Some(window)
}

/// `home`: where preferences are kept; `None`: nowhere.
pub fn open_project(project: &Path, home: Option<&Path>, size: Vec2) -> Option<Window> {
    let state = gpu()?;
    let opened = Opened::load(project, None).unwrap();
    let home = home.map(Path::to_owned);
    let editor = Editor::new(&egui::Context::default(), &state, opened, home).unwrap();
    let harness = Harness::builder()
        .with_size(size)
        // Half as fine: software draws these pictures, too.
        .with_pixels_per_point(0.5)
        .with_context_setup(theme::install)
        .renderer(WgpuTestRenderer::from_render_state(state))
        .build_ui_state(|ui, editor: &mut Editor| editor.ui(ui), editor);
    // The window is made after the editor here.
    harness.state().apply_preferences(&harness.ctx);
    let mut window = Window { harness, folder: None };
    window.settle();
    Some(window)
}

fn gpu() -> Option<RenderState> {
    let wgpu_setup = wgpu_setup_headless();
    let instance = pollster::block_on(wgpu_setup.new_instance());
    let config = WgpuConfiguration { wgpu_setup, ..Default::default() };
    let state = RenderState::create(&config, &instance, None, RendererOptions::PREDICTABLE);
    let state = pollster::block_on(state).ok();
    if state.is_none() {
        println!("not run: no GPU adapter");
    }
    state
}

pub fn cornell(folder: &Path) -> PathBuf {
    let sample = Path::new(env!("CARGO_MANIFEST_DIR")).join("../projects/cornell");
    let project = folder.join("cornell");
    for file in ["project.ron", "scenes/cornell.ron", "assets/cornell.obj", "assets/cornell.mtl"] {
        let to = project.join(file);
        std::fs::create_dir_all(to.parent().unwrap()).unwrap();
        std::fs::copy(sample.join(file), to).unwrap();
    }
    project
}

impl Window {
    /// A few pictures go by: what was asked for is done and seen.
    pub fn settle(&mut self) {
        self.harness.run_steps(4);
        // The GPU answers clicks when it comes to it.
        let since = Instant::now();
        while self.editor().is_seeking() {
            assert!(since.elapsed() < Duration::from_secs(100), "a click was never answered");
            std::thread::sleep(Duration::from_millis(1));
            self.harness.run_steps(2);
        }
    }

    /// Pictures go by until it is so: a thread beside has work to do.
    pub fn until(&mut self, what: &str, is_so: impl Fn(&Self) -> bool) {
        let since = Instant::now();
        while !is_so(self) {
            assert!(since.elapsed() < Duration::from_secs(400), "never came about: {what}");
            self.settle();
            std::thread::sleep(Duration::from_millis(5));
        }
        // What came stands where it will be clicked.
        self.settle();
    }

    pub fn is_shown(&self, name: &str) -> bool {
        self.harness.query_all_by_label(name).next().is_some()
    }

    pub fn type_text(&mut self, text: &str) {
        self.harness.event(egui::Event::Text(text.to_owned()));
        self.settle();
    }

    /// As its file would be.
    pub fn scene_text(&self) -> String {
        text_of_scene(Path::new("scene"), self.editor().session.document.scene()).unwrap()
    }

    /// The row of the tree.
    pub fn row(&self, name: &str) -> Rect {
        self.harness.get_by_role_and_label(Role::TreeItem, name).rect()
    }

    pub fn click_at(&mut self, at: Pos2, modifiers: Modifiers) {
        self.harness.hover_at(at);
        self.harness.step();
        for pressed in [true, false] {
            let button = egui::PointerButton::Primary;
            let event = egui::Event::PointerButton { pos: at, button, pressed, modifiers };
            self.harness.event_modifiers(event, modifiers);
            self.harness.step();
        }
        self.settle();
    }

    /// Into a number field, as a person does: click, type, Enter.
    pub fn enter(&mut self, field: &str, text: &str) {
        self.harness.get_by_role_and_label(Role::SpinButton, field).scroll_to_me();
        self.settle();
        self.harness.get_by_role_and_label(Role::SpinButton, field).click();
        self.settle();
        self.press(Modifiers::COMMAND, Key::A);
        self.harness.event(egui::Event::Text(text.to_owned()));
        self.press(Modifiers::NONE, Key::Enter);
    }

    pub fn editor(&self) -> &Editor {
        self.harness.state()
    }

    pub fn editor_mut(&mut self) -> &mut Editor {
        self.harness.state_mut()
    }

    pub fn node<'a>(&'a self, name: &'a str) -> Node<'a> {
        self.harness.get_by_label(name)
    }

    pub fn click(&mut self, name: &str) {
        self.node(name).click();
        self.settle();
    }

    pub fn choose(&mut self, menu: &str, entry: &str) {
        self.click(menu);
        self.click(entry);
    }

    pub fn press(&mut self, modifiers: Modifiers, key: Key) {
        self.harness.key_press_modifiers(modifiers, key);
        self.settle();
    }

    pub fn selected(&self) -> Vec<EntityId> {
        self.editor().session.selection.ids().to_vec()
    }

    pub fn entity(&self, id: EntityId) -> &Entity {
        self.editor().session.document.entity(id).unwrap()
    }

    /// The entity that is there and selected after `make`.
    pub fn made(&mut self, make: impl FnOnce(&mut Self)) -> EntityId {
        let before = self.editor().session.document.scene().entities.len();
        make(self);
        assert_eq!(self.editor().session.document.scene().entities.len(), before + 1);
        let selected = self.selected();
        assert_eq!(selected.len(), 1);
        selected[0]
    }

    pub fn scene_view(&self) -> Rect {
        self.node("Scene view").rect()
    }

    /// As the scene view sees.
    pub fn lens(&self) -> Lens {
        let plain = Eye::looking(DVec3::Z, DVec3::ZERO);
        Lens { eye: self.editor().scene.camera.eye(&plain), rect: self.scene_view() }
    }

    /// Where a place of the world is seen.
    pub fn seen_at(&self, place: DVec3) -> Pos2 {
        self.lens().project(place).unwrap().0
    }

    /// Where the handles of what is selected stand, along the world's axes.
    pub fn stand(&self) -> Stand {
        let active = self.editor().session.selection.active().unwrap();
        let origin = self.editor().session.document.world_from_local(active).translation;
        Stand { origin, axes: DQuat::IDENTITY }
    }

    /// How many steps undo knows.
    pub fn steps(&self) -> usize {
        self.editor().session.document.history().undo_names().count()
    }

    /// The mouse goes there with the left button, held keys and all, and stays down.
    pub fn hold(&mut self, from: Pos2, through: &[Pos2]) {
        self.harness.hover_at(from);
        self.harness.step();
        self.harness.drag_at(from);
        self.harness.step();
        for to in through {
            self.harness.hover_at(*to);
            self.harness.step();
        }
    }

    pub fn release(&mut self, at: Pos2) {
        self.harness.drop_at(at);
        self.settle();
    }

    /// The first entity of that name.
    pub fn named(&self, name: &str) -> EntityId {
        let mut entities = self.editor().session.document.scene().entities.iter();
        entities.find(|entity| entity.name == name).unwrap().id
    }

    pub fn select(&mut self, ids: &[EntityId]) {
        self.editor_mut().session.carry_out([Intent::Select(ids.to_vec())]);
        self.settle();
    }

    /// With the left button, in a few steps.
    pub fn drag(&mut self, from: Pos2, to: Pos2) {
        self.harness.hover_at(from);
        self.harness.step();
        self.harness.drag_at(from);
        self.harness.step();
        for share in [0.3, 0.6, 1.0] {
            self.harness.hover_at(from + (to - from) * share);
            self.harness.step();
        }
        self.harness.drop_at(to);
        self.settle();
    }

    /// For files that lie outside the project.
    pub fn folder(&self) -> &Path {
        self.folder.as_ref().unwrap().path()
    }

    pub fn project(&self) -> PathBuf {
        self.editor().session.document.project().to_owned()
    }

    /// All that the console says.
    pub fn told(&self) -> String {
        let lines = self.editor().session.log.filtered(&[Level::Info, Level::Warning, Level::Error], "");
        lines.iter().map(|line| format!("{:?}: {}\n", line.level, line.text)).collect()
    }

    pub fn errors(&self) -> Vec<String> {
        let lines = self.editor().session.log.filtered(&[Level::Error], "");
        lines.into_iter().map(|line| line.text).collect()
    }

    /// From the desktop, in one picture; it is not waited for what comes of it.
    pub fn drop_files(&mut self, files: &[PathBuf], at: Pos2) {
        self.harness.hover_at(at);
        self.settle();
        self.queue_files(files);
        self.harness.step();
    }

    /// They are dropped where the mouse is, in the next picture.
    pub fn queue_files(&mut self, files: &[PathBuf]) {
        let dropped = files.iter().map(|file| Arc::new(Dropped(file.clone())) as egui::DroppedFileHandle);
        let dropped: Vec<_> = dropped.collect();
        self.harness.input_mut().dropped_files.extend(dropped);
    }
}

#[derive(Debug)]
struct Dropped(PathBuf);

impl egui::DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        std::fs::read(&self.0).map_err(|error| error.to_string())
    }
}
