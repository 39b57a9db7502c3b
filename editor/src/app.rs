//! The editor as a whole: what it holds, how a picture of it comes about, and how what panels asked for is done.

mod beside;
mod bring;
mod checks;
mod drops;
mod in_turn;
mod leave;
mod open;
mod seek;
mod window;

use std::collections::VecDeque;
use std::path::PathBuf;
use std::sync::Arc;

use eframe::egui;
use eframe::egui_wgpu::RenderState;
use egui::{CentralPanel, Panel, Ui, ViewportCommand};
use engine::render::RenderError;
use engine::scene::EntityId;
use engine::scene::assets::Assets;

use crate::ask::{Ask, Asks};
use crate::baking::Baking;
use crate::camera::ViewCamera;
use crate::command::{Bindings, Command};
use crate::inspector::{Files, Inspector};
use crate::intents::Session;
use crate::keys;
use crate::layout::{self, Docks, Layout, Pane};
use crate::log::{Log, Source};
use crate::opened::Opened;
use crate::panels::assets::AssetList;
use crate::panels::console::Console;
use crate::panels::files::FileDialog;
use crate::panels::game::GameView;
use crate::panels::hierarchy::{Hierarchy, Tree};
use crate::panels::palette::Palette;
use crate::panels::preferences::Settings;
use crate::panels::scene::{SceneView, Seen};
use crate::panels::status::Status;
use crate::panels::toolbar::{self, Light, Playing};
use crate::panels::{menu, statistics};
use crate::play::Play;
use crate::recent::{Preferences, Theme};
use crate::scenery::{AsBaked, Placed, Scenery};
use crate::theme;
use crate::thumbnails::Thumbnails;
use crate::viewport::Stage;
pub use window::{run, wgpu_setup_headless};

pub struct Editor {
    pub session: Session,
    pub(crate) assets: Arc<Assets>,
    pub(crate) baking: Baking,
    baked: AsBaked,
    pub(crate) placed: Placed,
    pub(crate) play: Option<Play>,
    stage: Stage,
    pub layout: Layout,
    pub scene: SceneView,
    game: GameView,
    pub(crate) hierarchy: Hierarchy,
    inspector: Inspector,
    pub(crate) files: AssetList,
    pub thumbnails: Thumbnails,
    pub(crate) bring: bring::Bring,
    pub(crate) console: Console,
    pub(crate) palette: Palette,
    status: Status,
    asking: FileDialog,
    pub(crate) settings: Settings,
    bindings: Bindings,
    pub(crate) preferences: Preferences,
    /// Where preferences are kept; `None`: nowhere.
    home: Option<PathBuf>,
    /// What was copied last.
    pub(crate) copied: Option<String>,
    asks: Asks,
    /// Asked in pictures before: a click's answer is waited for.
    due: VecDeque<Ask>,
    seeking: Option<seek::Seeking>,
    /// Asked before the document is left: what comes then.
    leaving: Option<leave::Leaving>,
    opening: Option<open::Opening>,
    closing: open::Closing,
    title: String,
    /// Another program wrote the scene's file.
    is_outdated: bool,
    in_turn: in_turn::InTurn,
    /// As the user left it, or for the window as wide as it came.
    is_laid_out: bool,
    /// Points, of all panels; 0 before the first picture.
    width: f32,
}

impl Editor {
    /// `home`: where preferences are kept; `None`: nowhere.
    pub fn new(
        ctx: &egui::Context,
        state: &RenderState,
        opened: Opened,
        home: Option<PathBuf>,
    ) -> Result<Self, RenderError> {
        theme::install(ctx);
        // A size of its own, which preferences keep.
        ctx.options_mut(|options| options.zoom_with_keyboard = false);
        let log = Log::default();
        let (preferences, broken) = home.as_deref().map_or_else(Default::default, Preferences::load);
        log.warnings(broken.as_slice(), opened.document.scene());
        let (bindings, odd) = Bindings::from_preferences(&preferences.shortcuts);
        odd.into_iter().for_each(|odd| log.warning(Source::Nothing, odd));
        let layout = preferences.layout.as_deref().and_then(layout::read);
        let Opened { document, assets, shown, baked, cubemaps, settings, features, warnings } = opened;
        log.warnings(&warnings, document.scene());
        let mut stage = Stage::new(state, shown.clone(), &assets, (settings, features))?;
        stage.renderer.give_cubemaps(cubemaps);
        let mut baking = Baking::default();
        baked.into_iter().for_each(|baked| baking.show(baked));
        let mut editor = Self {
            baked: AsBaked::of(document.scene(), &assets, &shown),
            session: Session::new(document, log),
            assets,
            baking,
            placed: Placed::default(),
            play: None,
            stage,
            is_laid_out: layout.is_some(),
            width: 0.0,
            layout: layout.unwrap_or_else(|| layout::default_layout(1280.0)),
            scene: SceneView::default(),
            game: GameView::default(),
            hierarchy: Hierarchy::default(),
            inspector: Inspector::default(),
            files: AssetList::default(),
            thumbnails: Thumbnails::default(),
            bring: bring::Bring::default(),
            console: Console::default(),
            palette: Palette::default(),
            status: Status::default(),
            asking: FileDialog::default(),
            settings: Settings::default(),
            bindings,
            preferences,
            home,
            copied: None,
            asks: Asks::default(),
            due: VecDeque::default(),
            seeking: None,
            leaving: None,
            opening: None,
            closing: open::Closing::default(),
            title: String::new(),
            is_outdated: false,
            in_turn: in_turn::InTurn::default(),
        };
        editor.arrived(ctx);
        Ok(editor)
    }

    /// After a document was opened.
    fn arrived(&mut self, ctx: &egui::Context) {
        let project = self.session.document.project().to_owned();
        self.preferences.opened(&project);
        self.apply_preferences(ctx);
        self.placed.follow(&self.session.document, &self.assets, &self.baked);
        if let Some((low, high)) = self.scenery().extent(|entity| entity.mesh.is_some()) {
            // The scene's own camera knows best where to look from.
            let framed = ViewCamera::framing(low, high);
            let own = self.scenery().camera().map(|eye| ViewCamera::as_eye(&eye, framed.pivot));
            self.scene.camera = own.unwrap_or(framed);
            self.scene.camera.speed = framed.speed;
        }
        let path = self.session.document.path();
        self.session.log.info(format!("Opened {}", path.display()));
    }

    /// Theme and size, to a window.
    pub fn apply_preferences(&self, ctx: &egui::Context) {
        ctx.set_theme(match self.preferences.theme {
            Theme::Dark => egui::Theme::Dark,
            Theme::Light => egui::Theme::Light,
        });
        ctx.set_zoom_factor(self.preferences.ui_scale);
        self.keep_preferences();
    }

    fn keep_preferences(&self) {
        let Some(home) = &self.home else { return };
        let layout = layout::written(&self.layout);
        let preferences = Preferences { layout, ..self.preferences.clone() };
        if let Err(error) = preferences.save(home) {
            self.session.log.scene_error(&error, self.session.document.scene());
        }
    }

    /// As it is shown now.
    pub fn scenery(&self) -> Scenery<'_> {
        Scenery::of(&self.session.document, &self.assets, &self.placed, self.play.as_ref())
    }

    /// A picture of the editor.
    pub fn ui(&mut self, ui: &mut Ui) {
        self.stage.begin(ui.ctx().cumulative_frame_nr());
        self.beside(ui);
        self.take_sought(ui);
        self.stage.hold(self.is_behind());
        self.thumbnails.begin(self.session.document.project(), &self.assets);
        self.placed.follow(&self.session.document, &self.assets, &self.baked);
        if let Some(play) = &mut self.play {
            play.advance(&self.assets);
            ui.ctx().request_repaint();
        }
        if !self.is_asking() && !self.files.has_dialog() && !self.scene.is_pulling() {
            keys::pressed(ui, &self.bindings).into_iter().for_each(|command| self.asks.push(command));
        }
        self.bars(ui);
        let frame = egui::Frame::new().fill(theme::bars(ui.visuals()));
        CentralPanel::no_frame().frame(frame).show(ui, |ui| self.docks(ui));
        let state = self.state();
        self.palette.show(ui, &state, &self.bindings, &mut self.asks);
        self.dialogs(ui);
        self.do_what_was_asked(ui);
        self.thumbnails.end(ui.ctx(), self.stage.gpu());
        self.tell_title(ui);
    }

    fn bars(&mut self, ui: &mut Ui) {
        let (state, playing) = (self.state(), self.playing());
        let bar = theme::bar(ui.style());
        let top = Panel::top("menus").exact_size(26.0).frame(bar).show_separator_line(false);
        let mut asks = std::mem::take(&mut self.asks);
        top.show(ui, |ui| menu::show(ui, &state, &self.bindings, &|command| self.is_on(command), &mut asks));
        self.asks = asks;
        let tools = Panel::top("toolbar").exact_size(32.0).frame(bar).show_separator_line(false);
        let light =
            Light { badge: self.baking.badge(&self.session.document), progress: self.baking.progress() };
        tools.show(ui, |ui| toolbar::show(ui, &mut self.scene.handling, playing, &light, &mut self.asks));
        self.outdated(ui);
        let bottom = Panel::bottom("status").exact_size(24.0).frame(bar).show_separator_line(false);
        let Session { document, selection, log, .. } = &self.session;
        let (selected, entities) = (selection.ids().len(), document.scene().entities.len());
        bottom.show(ui, |ui| {
            let importing = self.bring.imports.going();
            self.status.show(ui, log, (selected, entities), importing.as_ref(), &mut self.asks);
        });
    }

    fn docks(&mut self, ui: &mut Ui) {
        let was = std::mem::replace(&mut self.width, ui.available_width());
        if !std::mem::replace(&mut self.is_laid_out, true) {
            self.layout = layout::default_layout(self.width);
        } else if was > 0.0 && was != self.width {
            layout::keep_sides(&mut self.layout, was, self.width);
        }
        self.scene.lens = None;
        let mut layout = std::mem::replace(&mut self.layout, Layout::empty(egui::Id::unique("none")));
        let mut docks = Docks { show: &mut |ui, pane| self.pane(ui, pane), closed: None };
        layout.ui(&mut docks, ui);
        if let Some(closed) = docks.closed {
            layout::close(&mut layout, closed);
        }
        self.layout = layout;
    }

    fn pane(&mut self, ui: &mut Ui, pane: Pane) {
        let scenery = Scenery::of(&self.session.document, &self.assets, &self.placed, self.play.as_ref());
        match pane {
            Pane::Scene => {
                let Session { document, selection, .. } = &self.session;
                let seen = Seen { document, assets: &self.assets, scenery, selection };
                return self.scene.show(ui, &mut self.stage, &seen, &mut self.asks);
            }
            Pane::Game => return self.game.show(ui, &mut self.stage, &scenery),
            _ => {}
        }
        let rect = ui.available_rect_before_wrap();
        ui.painter().rect_filled(rect, 0.0, ui.visuals().panel_fill);
        let state = self.state();
        let scenery = Scenery::of(&self.session.document, &self.assets, &self.placed, self.play.as_ref());
        let inner = egui::UiBuilder::new().max_rect(rect.shrink2(egui::vec2(7.0, 6.0)));
        ui.scope_builder(inner, |ui| match pane {
            Pane::Hierarchy => {
                let Session { document, selection, .. } = &self.session;
                let tree = Tree { document, selection, state, bindings: &self.bindings };
                self.hierarchy.show(ui, &tree, &mut self.asks);
            }
            Pane::Inspector => {
                let playing = self.play.is_some();
                let Session { document, selection, .. } = &self.session;
                let files = &mut Files {
                    assets: self.files.assets(),
                    missing: self.files.missing(),
                    thumbnails: &mut self.thumbnails,
                };
                self.inspector.show(ui, (document, selection), playing, files, &mut self.asks);
            }
            Pane::Assets => {
                self.files.show(ui, &self.session.document, &mut self.thumbnails, &mut self.asks);
            }
            Pane::Console => self.console.show(ui, &self.session.log, &mut self.asks),
            _ => statistics::show(ui, &self.stage, &self.scene.picture, &scenery),
        });
    }

    fn playing(&self) -> Playing {
        match &self.play {
            None => Playing::No,
            Some(play) if play.is_paused() => Playing::Paused,
            Some(_) => Playing::Runs,
        }
    }

    pub(crate) fn frame(&mut self, ids: &[EntityId]) {
        if let Some((low, high)) = self.extent(ids) {
            self.scene.camera.frame(low, high);
        }
    }

    /// What came is seen, even where all of it could not be.
    pub(crate) fn fit(&mut self, ids: &[EntityId]) {
        let seen = self.scene.camera.height_at_pivot();
        if self.extent(ids).is_some_and(|(low, high)| (high - low).length() > seen) {
            self.frame(ids);
        }
    }

    /// Of these and what they carry.
    fn extent(&self, ids: &[EntityId]) -> Option<(glam::DVec3, glam::DVec3)> {
        let indexed = self.session.document.indexed();
        let below: std::collections::HashSet<EntityId> =
            ids.iter().flat_map(|id| indexed.subtree(*id)).collect();
        self.scenery().extent(|entity| below.contains(&entity.id))
    }

    pub(crate) fn run_play(&mut self, command: Command) {
        match (command, &mut self.play) {
            (Command::Play, None) => {
                self.session.document.cancel();
                self.play = Some(Play::of(self.session.document.scene(), &self.assets));
                layout::reveal(&mut self.layout, Pane::Game);
            }
            (Command::Play, Some(_)) => {
                self.play = None;
                layout::reveal(&mut self.layout, Pane::Scene);
            }
            (Command::Pause, Some(play)) => play.pause(!play.is_paused()),
            (Command::Step, Some(play)) => play.step(),
            _ => {}
        }
    }

    fn tell_title(&mut self, ui: &Ui) {
        let document = &self.session.document;
        let dirty = if document.is_dirty() { "*" } else { "" };
        let project = document.project().file_name().unwrap_or_default().to_string_lossy();
        let title = format!("{}{dirty} \u{2013} {project} \u{2013} Hohlraum", document.name());
        if title != self.title {
            ui.ctx().send_viewport_cmd(ViewportCommand::Title(title.clone()));
            self.title = title;
        }
    }

    /// What the scene refers to, as far as it is in memory.
    pub fn assets(&self) -> &Assets {
        &self.assets
    }

    /// The engine as it draws here.
    pub fn stage(&self) -> &Stage {
        &self.stage
    }

    pub fn bindings(&self) -> &Bindings {
        &self.bindings
    }

    /// As the window's title says it.
    pub fn title(&self) -> &str {
        &self.title
    }
}
