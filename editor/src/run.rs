//! What each command does.

use eframe::egui;
use egui::{Ui, ViewportCommand};
use engine::render::View;
use engine::scene::EntityId;
use glam::DVec3;

use crate::app::Editor;
use crate::command::{Command, State};
use crate::edit::{Edit, Field, copies, tree};
use crate::gizmo::Tool;
use crate::layout::{self, Pane};
use crate::log::Source;
use crate::primitives::{self, Primitive};
use crate::recent::Theme;
use crate::{clipboard, tools};

/// Commands of the table that this editor has no part for yet: no menu shows them, no key gives them.
const NOT_YET: [Command; 25] = [
    Command::NewProject,
    Command::NewScene,
    Command::OpenScene,
    Command::SaveAs,
    Command::Recover,
    Command::Preferences,
    Command::CreateMaterial,
    Command::ToggleLocked,
    Command::ToggleVertexSnapping,
    Command::ViewCamera,
    Command::ToggleGizmos,
    Command::ToggleWireframe,
    Command::Import,
    Command::Reimport,
    Command::RenameAsset,
    Command::RelinkMissing,
    Command::SearchAssets,
    Command::Bake,
    Command::CancelBake,
    Command::DensityBrush,
    Command::EditLightProbes,
    Command::ShowTetrahedra,
    Command::ShowProbeSlice,
    Command::ShowAssets,
    Command::Shortcuts,
];

pub fn is_known(command: Command) -> bool {
    !NOT_YET.contains(&command)
}

fn primitive(command: Command) -> Option<Primitive> {
    Some(match command {
        Command::CreateEmpty => Primitive::Empty,
        Command::CreateCube => Primitive::Cube,
        Command::CreateSphere => Primitive::Sphere,
        Command::CreateCylinder => Primitive::Cylinder,
        Command::CreatePlane => Primitive::Plane,
        Command::CreateQuad => Primitive::Quad,
        Command::CreateSun => Primitive::Sun,
        Command::CreatePointLight => Primitive::PointLight,
        Command::CreateSpotLight => Primitive::SpotLight,
        Command::CreateCamera => Primitive::Camera,
        Command::CreateLightProbeGroup => Primitive::LightProbeGroup,
        Command::CreateReflectionProbe => Primitive::ReflectionProbe,
        Command::CreateSky => Primitive::Sky,
        _ => return None,
    })
}

fn view(command: Command) -> Option<View> {
    Some(match command {
        Command::DrawComposite => View::Composite,
        Command::DrawDirect => View::Direct,
        Command::DrawIndirect => View::Indirect,
        Command::DrawReflection => View::Reflection,
        Command::DrawAlbedo => View::Albedo,
        Command::DrawNormal => View::Normal,
        Command::DrawPatches => View::Patches,
        Command::DrawDensity => View::Density,
        _ => return None,
    })
}

fn pane(command: Command) -> Option<Pane> {
    Some(match command {
        Command::ShowHierarchy => Pane::Hierarchy,
        Command::ShowScene => Pane::Scene,
        Command::ShowGame => Pane::Game,
        Command::ShowInspector => Pane::Inspector,
        Command::ShowConsole => Pane::Console,
        Command::ShowStatistics => Pane::Statistics,
        _ => return None,
    })
}

impl Editor {
    /// What is the case now, for the table.
    pub fn state(&self) -> State {
        State {
            has_scene: true,
            is_playing: self.play.is_some(),
            is_baking: false,
            selected: self.selection.ids().len(),
            asset_selected: false,
            can_undo: self.document.can_undo(),
            can_redo: self.document.can_redo(),
            can_paste: self.copied.is_some(),
        }
    }

    pub fn run(&mut self, command: Command, ui: &Ui) {
        if !is_known(command) || !command.is_enabled(&self.state()) {
            return;
        }
        if let Some(primitive) = primitive(command) {
            return self.create(primitive);
        }
        if let Some(view) = view(command) {
            self.scene.view = view;
            return;
        }
        if let Some(pane) = pane(command) {
            return layout::reveal(&mut self.layout, pane);
        }
        match command {
            Command::Undo | Command::Redo => self.travel(command),
            Command::Cut | Command::Copy | Command::Paste | Command::Duplicate | Command::Delete => {
                self.change_what_is_there(command, ui);
            }
            Command::SelectAll
            | Command::SelectNone
            | Command::InvertSelection
            | Command::SelectChildren
            | Command::Rename => self.choose(command),
            Command::ParentToActive
            | Command::Unparent
            | Command::ToggleHidden
            | Command::Isolate
            | Command::ShowAll
            | Command::ToggleStatic
            | Command::ToggleStaticWithChildren => self.arrange(command),
            Command::Play | Command::Pause | Command::Step => self.run_play(command),
            Command::Save | Command::Reload | Command::OpenProject | Command::Quit => self.file(command, ui),
            Command::ResetLayout
            | Command::ToggleTheme
            | Command::ScaleUp
            | Command::ScaleDown
            | Command::ScaleReset
            | Command::Palette
            | Command::ClearConsole
            | Command::CopyConsole => self.window(command, ui),
            _ => self.look(command),
        }
    }

    fn commit(&mut self, edit: Edit) -> bool {
        match self.document.commit(edit) {
            Ok(()) => true,
            Err(error) => {
                self.log.scene_error(&error, self.document.scene());
                false
            }
        }
    }

    fn create(&mut self, primitive: Primitive) {
        let place = self.scene.camera.pivot;
        let place = DVec3::from(place.to_array().map(|metres| (metres * 100.0).round() / 100.0));
        let (edit, created) = primitives::create(&mut self.document, primitive, place, None);
        if self.commit(edit) {
            self.choose_ids(created.into_iter().collect());
        }
    }

    fn travel(&mut self, command: Command) {
        let name = if command == Command::Undo { self.document.undo() } else { self.document.redo() };
        if let Some(name) = name {
            let verb = if command == Command::Undo { "Undone" } else { "Redone" };
            self.log.info(format!("{verb}: {name}"));
        }
    }

    fn change_what_is_there(&mut self, command: Command, ui: &Ui) {
        let ids = self.selection.ids().to_vec();
        if matches!(command, Command::Cut | Command::Copy) {
            match clipboard::copy(self.document.indexed(), &ids) {
                Ok(text) => {
                    ui.ctx().copy_text(text.clone());
                    self.copied = Some(text);
                }
                Err(error) => return self.log.error(Source::Nothing, error),
            }
        }
        match command {
            Command::Cut | Command::Delete => {
                let (edit, warnings) = tree::delete(self.document.indexed(), &ids);
                self.log.warnings(&warnings, self.document.scene());
                self.commit(edit);
            }
            Command::Duplicate => self.duplicate(&ids),
            Command::Paste => self.paste(),
            _ => {}
        }
    }

    fn duplicate(&mut self, ids: &[EntityId]) {
        // Ids from here on are free.
        let mut next = self.document.new_entity_id().0;
        let mut new_id = || {
            next += 1;
            EntityId(next - 1)
        };
        let edit = copies::duplicate(self.document.indexed(), ids, &mut new_id);
        let named: Vec<EntityId> = edit.entities();
        if self.commit(edit) {
            let top = self.document.indexed().topmost(&named);
            self.choose_ids(top);
        }
    }

    fn paste(&mut self) {
        let Some(text) = self.copied.clone() else { return };
        match clipboard::paste(&mut self.document, &text, None) {
            Ok((edit, top, warnings)) => {
                self.log.warnings(&warnings, self.document.scene());
                if self.commit(edit) {
                    self.choose_ids(top);
                }
            }
            Err(error) => self.log.error(Source::Nothing, error),
        }
    }

    fn choose(&mut self, command: Command) {
        let all = || self.document.scene().entities.iter().map(|entity| entity.id);
        let ids: Vec<EntityId> = match command {
            Command::SelectAll => all().collect(),
            Command::InvertSelection => all().filter(|id| !self.selection.contains(*id)).collect(),
            Command::SelectChildren => {
                let children = |id: &EntityId| self.document.children(Some(*id)).to_vec();
                self.selection.ids().iter().flat_map(children).collect()
            }
            Command::Rename => {
                if let Some(active) = self.selection.active() {
                    layout::reveal(&mut self.layout, Pane::Hierarchy);
                    self.hierarchy.rename(&self.document, active);
                }
                return;
            }
            _ => Vec::new(),
        };
        self.selection.set(ids);
    }

    pub(crate) fn choose_ids(&mut self, ids: Vec<EntityId>) {
        self.selection.set(ids);
        if let Some(active) = self.selection.active() {
            self.hierarchy.reveal(&self.document, active);
        }
    }

    fn arrange(&mut self, command: Command) {
        let ids = self.selection.ids().to_vec();
        let scene = self.document.indexed();
        let has = |get: fn(&engine::scene::Entity) -> bool| {
            ids.iter().filter_map(|id| scene.entity(*id)).all(get)
        };
        let edit = match command {
            Command::ToggleHidden => tree::set_flag(scene, &ids, false, Field::Hidden(!has(|e| e.hidden))),
            Command::ToggleStatic => tree::set_flag(scene, &ids, false, Field::Static(!has(|e| e.is_static))),
            Command::ToggleStaticWithChildren => {
                tree::set_flag(scene, &ids, true, Field::Static(!has(|e| e.is_static)))
            }
            Command::ShowAll => {
                let hidden = scene.scene().entities.iter().filter(|entity| entity.hidden);
                Edit::Set(hidden.map(|entity| (entity.id, Field::Hidden(false))).collect())
            }
            Command::Isolate => tools::isolate(scene, &ids),
            Command::ParentToActive => {
                let active = self.selection.active();
                let others = ids.iter().copied().filter(|id| Some(*id) != active).collect();
                return self.reparent(others, active, None);
            }
            _ => return self.reparent(ids, None, None),
        };
        self.commit(edit);
    }

    pub(crate) fn reparent(&mut self, ids: Vec<EntityId>, parent: Option<EntityId>, before: Option<EntityId>) {
        match tree::reparent(self.document.indexed(), &ids, parent, before) {
            Ok((edit, warnings)) => {
                self.log.warnings(&warnings, self.document.scene());
                self.commit(edit);
            }
            Err(error) => self.log.error(Source::Nothing, error),
        }
    }

    /// The scene view: what it shows, from where, and with which tool.
    fn look(&mut self, command: Command) {
        let handling = &mut self.scene.handling;
        let camera = &mut self.scene.camera;
        match command {
            Command::ToolSelect => handling.tool = Tool::View,
            Command::ToolMove => handling.tool = Tool::Move,
            Command::ToolRotate => handling.tool = Tool::Rotate,
            Command::ToolScale => handling.tool = Tool::Scale,
            Command::ToggleSpace => handling.local ^= true,
            Command::TogglePivot => handling.centre ^= true,
            Command::ToggleSnapping => handling.snap ^= true,
            Command::SnapFiner => handling.steps = handling.steps.times(0.5),
            Command::SnapCoarser => handling.steps = handling.steps.times(2.0),
            Command::ViewFront => camera.look_along(DVec3::NEG_Z),
            Command::ViewRight => camera.look_along(DVec3::NEG_X),
            Command::ViewTop => camera.look_along(DVec3::NEG_Y),
            Command::ToggleOrthographic => camera.orthographic ^= true,
            Command::ToggleGrid => self.scene.hide_grid ^= true,
            Command::Frame if self.selection.is_empty() => self.frame_all(),
            Command::Frame => self.frame(&self.selection.ids().to_vec()),
            Command::FrameAll => self.frame_all(),
            Command::DropToFloor => self.drop_to_floor(),
            Command::AlignCamera => self.align_with_view(),
            _ => {}
        }
    }

    fn frame_all(&mut self) {
        let all: Vec<EntityId> = self.document.scene().entities.iter().map(|entity| entity.id).collect();
        self.frame(&all);
    }

    fn drop_to_floor(&mut self) {
        let ids = self.selection.ids().to_vec();
        let edit = tools::drop::edit(&self.document, &self.scenery(), &ids);
        self.commit(edit);
    }

    /// What is selected looks at what the scene view looks at, from there.
    fn align_with_view(&mut self) {
        let Some(active) = self.selection.active() else { return };
        let (place, turn) = (self.scene.camera.position(), self.scene.camera.rotation());
        let edit = tools::transform::placed(&self.document, active, place, turn);
        self.commit(edit);
    }

    fn file(&mut self, command: Command, ui: &Ui) {
        match command {
            Command::Save => {
                match self.document.save() {
                    Ok(()) => self.log.info(format!("Saved {}", self.document.path().display())),
                    Err(error) => {
                        let source = Source::File(self.document.path());
                        self.log.error(source, bake::chain::told(&error));
                    }
                };
            }
            Command::Reload => {
                if let Err(error) = self.document.reload() {
                    self.log.scene_error(&error, self.document.scene());
                }
            }
            Command::OpenProject => self.ask_for_project(),
            Command::Quit => ui.ctx().send_viewport_cmd(ViewportCommand::Close),
            _ => {}
        }
    }

    fn window(&mut self, command: Command, ui: &Ui) {
        match command {
            Command::ResetLayout => self.layout = layout::default_layout(),
            Command::Palette => self.palette.toggle(),
            Command::ClearConsole => self.log.clear(),
            Command::CopyConsole => ui.ctx().copy_text(self.console.text()),
            Command::ToggleTheme => {
                self.preferences.theme = match self.preferences.theme {
                    Theme::Dark => Theme::Light,
                    Theme::Light => Theme::Dark,
                };
            }
            Command::ScaleUp => self.preferences.ui_scale = (self.preferences.ui_scale + 0.1).min(3.0),
            Command::ScaleDown => self.preferences.ui_scale = (self.preferences.ui_scale - 0.1).max(0.6),
            Command::ScaleReset => self.preferences.ui_scale = 1.0,
            _ => {}
        }
        self.apply_preferences(ui.ctx());
    }
}
