//! The editor as a whole: what it holds, how a picture of it comes about, and how what panels asked for is done.

use std::sync::Arc;

use eframe::egui;
use eframe::egui_wgpu::{RenderState, WgpuConfiguration, WgpuSetup, WgpuSetupCreateNew};
use egui::{CentralPanel, Key, Panel, Ui, ViewportCommand};
use engine::gpu::Gpu;
use engine::render::{RenderError, Settings};
use engine::scene::EntityId;
use engine::scene::assets::Assets;

use crate::ask::{Ask, Asks, PlayAsk};
use crate::camera::ViewCamera;
use crate::document::Document;
use crate::inspector::Inspector;
use crate::layout::{self, Docks, Layout, Pane};
use crate::opened::Opened;
use crate::panels::game::GameView;
use crate::panels::hierarchy::Hierarchy;
use crate::panels::scene::{SceneView, Seen};
use crate::panels::toolbar::{self, Playing};
use crate::play::Play;
use crate::scenery::{AsBaked, Placed, Scenery};
use crate::selection::Selection;
use crate::theme;
use crate::viewport::Stage;

pub struct Editor {
    pub document: Document,
    pub selection: Selection,
    assets: Assets,
    baked: AsBaked,
    placed: Placed,
    play: Option<Play>,
    stage: Stage,
    layout: Layout,
    pub scene: SceneView,
    game: GameView,
    hierarchy: Hierarchy,
    inspector: Inspector,
    asks: Asks,
    title: String,
}

impl Editor {
    pub fn new(ctx: &egui::Context, state: &RenderState, opened: Opened) -> Result<Self, RenderError> {
        theme::install(ctx);
        let Opened { document, assets, transport, cubemaps, unlimited_gain, .. } = opened;
        let settings = Settings { unlimited_gain, ..Settings::default() };
        let mut stage = Stage::new(state, transport.clone(), &assets, settings)?;
        stage.renderer.give_cubemaps(cubemaps);
        let baked = AsBaked::of(document.scene(), &assets, &transport);
        let mut editor = Self {
            document,
            selection: Selection::default(),
            assets,
            baked,
            placed: Placed::default(),
            play: None,
            stage,
            layout: layout::default_layout(),
            scene: SceneView::default(),
            game: GameView::default(),
            hierarchy: Hierarchy::default(),
            inspector: Inspector::default(),
            asks: Asks::default(),
            title: String::new(),
        };
        editor.look_at_all();
        Ok(editor)
    }

    fn look_at_all(&mut self) {
        self.placed.follow(&self.document, &self.assets, &self.baked);
        let scenery = Scenery::of(&self.document, &self.assets, &self.placed, None);
        if let Some((low, high)) = scenery.extent(|entity| entity.mesh.is_some()) {
            self.scene.camera = ViewCamera::framing(low, high);
        }
    }

    /// A picture of the editor.
    pub fn ui(&mut self, ui: &mut Ui) {
        self.shortcuts(ui);
        self.placed.follow(&self.document, &self.assets, &self.baked);
        if let Some(play) = &mut self.play {
            play.advance(&self.assets);
            ui.ctx().request_repaint();
        }
        let playing = self.playing();
        Panel::top("toolbar").exact_size(32.0).frame(theme::bar(ui.style())).show_separator_line(false).show(
            ui,
            |ui| toolbar::show(ui, &mut self.scene.handling, playing, &mut self.asks),
        );
        let frame = egui::Frame::new().fill(theme::bars(ui.visuals()));
        CentralPanel::no_frame().frame(frame).show(ui, |ui| self.docks(ui));
        self.do_what_was_asked(ui);
        self.tell_title(ui);
    }

    fn docks(&mut self, ui: &mut Ui) {
        let mut layout = std::mem::replace(&mut self.layout, Layout::empty("none"));
        layout.ui(&mut Docks { show: &mut |ui, pane| self.pane(ui, pane) }, ui);
        self.layout = layout;
    }

    fn pane(&mut self, ui: &mut Ui, pane: Pane) {
        let scenery = Scenery::of(&self.document, &self.assets, &self.placed, self.play.as_ref());
        let framed = |ui: &mut Ui, add: &mut dyn FnMut(&mut Ui)| {
            theme::panel(ui.style()).show(ui, |ui| {
                ui.set_min_size(ui.available_size());
                add(ui);
            });
        };
        match pane {
            Pane::Scene => {
                let seen = Seen { document: &self.document, scenery, selection: &self.selection };
                self.scene.show(ui, &mut self.stage, &seen, &mut self.asks);
            }
            Pane::Game => self.game.show(ui, &mut self.stage, &scenery),
            Pane::Hierarchy => framed(ui, &mut |ui| {
                self.hierarchy.show(ui, &self.document, &self.selection, &mut self.asks);
            }),
            Pane::Inspector => framed(ui, &mut |ui| {
                self.inspector.show(ui, &self.document, &self.selection, scenery.is_playing, &mut self.asks);
            }),
            Pane::Console | Pane::Statistics => framed(ui, &mut |ui| {
                ui.weak("");
            }),
        }
    }

    fn playing(&self) -> Playing {
        match &self.play {
            None => Playing::No,
            Some(play) if play.is_paused() => Playing::Paused,
            Some(_) => Playing::Runs,
        }
    }

    fn shortcuts(&mut self, ui: &Ui) {
        let _ = (ui, Key::F);
    }

    fn do_what_was_asked(&mut self, ui: &Ui) {
        let asked = self.asks.take();
        if !asked.is_empty() {
            ui.ctx().request_repaint();
        }
        for ask in asked {
            self.do_one(ask);
        }
        self.selection.retain_existing(self.document.indexed());
    }

    fn do_one(&mut self, ask: Ask) {
        match ask {
            Ask::Commit(edit) => {
                if let Err(error) = self.document.commit(edit) {
                    eprintln!("{error}");
                }
            }
            Ask::Preview(edit) => self.document.preview(edit),
            Ask::End => {
                if let Err(error) = self.document.end() {
                    eprintln!("{error}");
                }
            }
            Ask::Cancel => self.document.cancel(),
            Ask::Select(ids) => {
                self.selection.set(ids);
                if let Some(active) = self.selection.active() {
                    self.hierarchy.reveal(&self.document, active);
                }
            }
            Ask::Selection(selection) => self.selection = selection,
            Ask::Frame(ids) => self.frame(&ids),
            Ask::Rename(id) => self.hierarchy.rename(&self.document, id),
            Ask::Tool(tool) => self.scene.handling.tool = tool,
            Ask::Play(play) => self.do_play(play),
        }
    }

    fn frame(&mut self, ids: &[EntityId]) {
        let scenery = Scenery::of(&self.document, &self.assets, &self.placed, self.play.as_ref());
        let indexed = self.document.indexed();
        let below: std::collections::HashSet<EntityId> =
            ids.iter().flat_map(|id| indexed.subtree(*id)).collect();
        if let Some((low, high)) = scenery.extent(|entity| below.contains(&entity.id)) {
            self.scene.camera.frame(low, high);
        }
    }

    fn do_play(&mut self, ask: PlayAsk) {
        match (ask, &mut self.play) {
            (PlayAsk::Start, None) => {
                self.document.cancel();
                self.play = Some(Play::of(self.document.scene(), &self.assets));
                layout::reveal(&mut self.layout, Pane::Game);
            }
            (PlayAsk::Stop, Some(_)) => {
                self.play = None;
                layout::reveal(&mut self.layout, Pane::Scene);
            }
            (PlayAsk::Pause(paused), Some(play)) => play.pause(paused),
            (PlayAsk::Step, Some(play)) => play.step(),
            _ => {}
        }
    }

    fn tell_title(&mut self, ui: &Ui) {
        let dirty = if self.document.is_dirty() { "*" } else { "" };
        let project = self.document.project().file_name().unwrap_or_default().to_string_lossy();
        let title = format!("{}{dirty} \u{2013} {project} \u{2013} Hohlraum", self.document.name());
        if title != self.title {
            ui.ctx().send_viewport_cmd(ViewportCommand::Title(title.clone()));
            self.title = title;
        }
    }
}

impl eframe::App for Editor {
    fn ui(&mut self, ui: &mut Ui, _: &mut eframe::Frame) {
        Editor::ui(self, ui);
    }
}

/// A device as the engine needs it; all that eframe asks for by itself is a part of that.
pub fn wgpu_setup(mut setup: WgpuSetupCreateNew) -> WgpuSetup {
    setup.device_descriptor = Arc::new(Gpu::descriptor);
    WgpuSetup::CreateNew(setup)
}

/// Opens a window and stays until it is closed.
pub fn run(opened: Opened) -> eframe::Result {
    let mut wgpu_options = WgpuConfiguration::default();
    if let WgpuSetup::CreateNew(setup) = wgpu_options.wgpu_setup {
        wgpu_options.wgpu_setup = wgpu_setup(setup);
    }
    let viewport = egui::ViewportBuilder::default()
        .with_title("Hohlraum")
        .with_app_id("hohlraum")
        .with_inner_size([1440.0, 860.0])
        .with_min_inner_size([720.0, 420.0]);
    let options = eframe::NativeOptions { viewport, wgpu_options, ..Default::default() };
    let create = |cc: &eframe::CreationContext<'_>| {
        let state = cc.wgpu_render_state.as_ref().ok_or("the window has no GPU")?;
        Ok(Box::new(Editor::new(&cc.egui_ctx, state, opened)?) as Box<dyn eframe::App>)
    };
    eframe::run_native("hohlraum", options, Box::new(create))
}
