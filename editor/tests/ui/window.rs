//! The editor in a window that nobody sees: driven by mouse and keyboard, found by what screen readers are told.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use editor::app::{Editor, wgpu_setup};
use editor::gizmo::Stand;
use editor::lens::Lens;
use editor::opened::Opened;
use editor::theme;
use eframe::egui_wgpu::{RenderState, RendererOptions, WgpuConfiguration, WgpuSetupCreateNew};
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
    _folder: Option<tempfile::TempDir>,
}

/// The Cornell box, not baked. `None`, with a line, where there is no GPU.
pub fn open() -> Option<Window> {
    open_sized(Vec2::new(1280.0, 720.0))
}

pub fn open_sized(size: Vec2) -> Option<Window> {
    let folder = tempfile::tempdir().unwrap();
    let project = cornell(folder.path());
    let mut window = open_project(&project, None, size)?;
    window._folder = Some(folder);
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
    let mut window = Window { harness, _folder: None };
    window.settle();
    Some(window)
}

fn gpu() -> Option<RenderState> {
    let wgpu_setup = wgpu_setup(WgpuSetupCreateNew::without_display_handle());
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
    }

    /// Pictures go by until it is so: a thread beside has work to do.
    pub fn until(&mut self, what: &str, is_so: impl Fn(&Self) -> bool) {
        let since = Instant::now();
        while !is_so(self) {
            assert!(since.elapsed() < Duration::from_secs(120), "never came about: {what}");
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
}
