//! What each command does.

use eframe::egui;
use egui::{Ui, ViewportCommand};
use engine::render::{Eye, View};
use engine::scene::{Entity, EntityId};
use glam::DVec3;

use crate::app::Editor;
use crate::assets::Wish;
use crate::camera::ViewCamera;
use crate::command::{Command, State};
use crate::gizmo::Tool;
use crate::intents::{Intent, Session};
use crate::layout::{self, Pane};
use crate::panels::preferences::Tab;
use crate::panels::scene::probing;
use crate::primitives::Primitive;
use crate::recent::Theme;
use crate::scenery::Scenery;
use crate::tools;

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

pub(crate) fn view(command: Command) -> Option<View> {
    Some(match command {
        Command::DrawComposite => View::Composite,
        Command::DrawDirect => View::Direct,
        Command::DrawIndirect => View::Indirect,
        Command::DrawReflection => View::Reflection,
        Command::DrawAlbedo => View::Albedo,
        Command::DrawNormal => View::Normal,
        Command::DrawPatches => View::Patches,
        Command::DrawDensity => View::Density,
        Command::DrawHeadlight => View::Headlight,
        _ => return None,
    })
}

pub(crate) fn pane(command: Command) -> Option<Pane> {
    Some(match command {
        Command::ShowHierarchy => Pane::Hierarchy,
        Command::ShowScene => Pane::Scene,
        Command::ShowGame => Pane::Game,
        Command::ShowInspector => Pane::Inspector,
        Command::ShowAssets => Pane::Assets,
        Command::ShowConsole => Pane::Console,
        Command::ShowStatistics => Pane::Statistics,
        _ => return None,
    })
}

/// What a command closes.
fn closed(command: Command) -> Option<Pane> {
    Some(match command {
        Command::CloseHierarchy => Pane::Hierarchy,
        Command::CloseGame => Pane::Game,
        Command::CloseInspector => Pane::Inspector,
        Command::CloseAssets => Pane::Assets,
        Command::CloseConsole => Pane::Console,
        Command::CloseStatistics => Pane::Statistics,
        _ => return None,
    })
}

impl Editor {
    /// What is the case now, for the table.
    pub fn state(&self) -> State {
        let Session { document, selection, .. } = &self.session;
        State {
            has_scene: true,
            is_playing: self.play.is_some(),
            is_baking: self.baking.progress().is_some(),
            selected: selection.ids().len(),
            asset_selected: self.files.selected().is_some(),
            can_undo: document.can_undo(),
            can_redo: document.can_redo(),
            can_paste: self.copied.is_some(),
        }
    }

    pub fn run(&mut self, command: Command, ui: &Ui) {
        if !command.is_enabled(&self.state()) {
            return;
        }
        let of_tool = self.scene.intent(command, &self.session.document, self.session.selection.active());
        if let Some(intent) = of_tool.or_else(|| self.intent(command)) {
            return self.carry_out(intent, ui);
        }
        if let Some(view) = view(command) {
            self.scene.view = view;
            return;
        }
        if let Some(pane) = pane(command) {
            return layout::reveal(&mut self.layout, pane);
        }
        if let Some(pane) = closed(command) {
            return layout::close(&mut self.layout, pane);
        }
        match command {
            Command::SelectChildren | Command::Rename => self.choose(command),
            Command::Play | Command::Pause | Command::Step => self.run_play(command),
            Command::Bake | Command::CancelBake => self.run_bake(command),
            Command::Save | Command::Reload | Command::Quit => self.file(command, ui),
            Command::NewProject
            | Command::OpenProject
            | Command::NewScene
            | Command::OpenScene
            | Command::SaveAs => self.ask_for_file(command),
            Command::Preferences => self.settings.open(Tab::Appearance),
            Command::Shortcuts => self.settings.open(Tab::Shortcuts),
            Command::ResetLayout
            | Command::ToggleTheme
            | Command::ScaleUp
            | Command::ScaleDown
            | Command::ScaleReset
            | Command::Palette
            | Command::ClearConsole
            | Command::CopyConsole => self.window(command, ui),
            Command::SearchHierarchy => {
                layout::reveal(&mut self.layout, Pane::Hierarchy);
                self.hierarchy.search(ui);
            }
            Command::Import
            | Command::Reimport
            | Command::RenameAsset
            | Command::RelinkMissing
            | Command::SearchAssets => self.run_files(command, ui),
            Command::DensityBrush
            | Command::EditLightProbes
            | Command::ShowTetrahedra
            | Command::ShowProbeSlice => {
                layout::reveal(&mut self.layout, Pane::Scene);
                self.light_tool(command);
            }
            _ => self.look(command),
        }
    }

    fn run_files(&mut self, command: Command, ui: &Ui) {
        if matches!(command, Command::RenameAsset | Command::SearchAssets) {
            layout::reveal(&mut self.layout, Pane::Assets);
        }
        match command {
            Command::Import => self.wish(Wish::AskForImport, ui),
            Command::Reimport => {
                let file = self.files.selected().unwrap_or_default().to_owned();
                self.wish(Wish::Again { file, settings: None }, ui);
            }
            Command::RenameAsset => self.files.rename_selected(),
            Command::RelinkMissing => self.files.relink_missing(),
            _ => self.files.focus_search(ui),
        }
    }

    /// What shows and shapes the light's parts. A tool that is in the hand already is laid down.
    fn light_tool(&mut self, command: Command) {
        self.scene.hide_gizmos = false;
        let scenery = Scenery::of(&self.session.document, &self.assets, &self.placed, self.play.as_ref());
        let tool = &mut self.scene.handling.tool;
        let toggled = |now: Tool, wanted: Tool| if now == wanted { Tool::Move } else { wanted };
        match command {
            Command::DensityBrush => *tool = toggled(*tool, Tool::Density),
            Command::EditLightProbes => {
                *tool = toggled(*tool, Tool::Probes);
                let Session { document, selection, .. } = &mut self.session;
                let group = probing::group_of(document, selection.active(), None);
                if let Some(group) = group.filter(|_| *tool == Tool::Probes) {
                    selection.set([group]);
                }
            }
            Command::ShowTetrahedra => self.scene.net.tetrahedra ^= true,
            Command::ShowProbeSlice => self.scene.net.toggle_slice(&scenery),
            _ => {}
        }
    }

    /// Of commands that change the document or what is selected, and nothing else.
    fn intent(&self, command: Command) -> Option<Intent> {
        if let Some(primitive) = primitive(command) {
            // In the middle of the picture, on whole centimetres.
            let place = self.scene.camera.pivot.to_array().map(|metres| (metres * 100.0).round() / 100.0);
            let size = self.scene.camera.size_of_new();
            return Some(Intent::Create { primitive, place: DVec3::from(place), size, parent: None });
        }
        let document = &self.session.document;
        let ids = self.session.selection.ids().to_vec();
        let all = |get: &dyn Fn(&Entity) -> bool| ids.iter().filter_map(|id| document.entity(*id)).all(get);
        Some(match command {
            Command::Undo => Intent::Undo,
            Command::Redo => Intent::Redo,
            Command::Cut => Intent::Cut,
            Command::Copy => Intent::Copy,
            Command::Paste => Intent::Paste { text: self.copied.clone()?, parent: None },
            Command::Duplicate => Intent::Duplicate,
            Command::Delete => Intent::Delete,
            Command::CreateMaterial => Intent::CreateMaterial,
            Command::SelectAll => Intent::SelectAll,
            Command::SelectNone => Intent::Select(Vec::new()),
            Command::InvertSelection => Intent::InvertSelection,
            Command::ToggleHidden => Intent::Hide { hidden: !all(&|e| e.hidden), ids },
            Command::ToggleLocked => Intent::Lock { locked: !all(&|e| document.is_locked(e.id)), ids },
            Command::ToggleStatic | Command::ToggleStaticWithChildren => Intent::Static {
                is_static: !all(&|e| e.is_static),
                ids,
                with_children: command == Command::ToggleStaticWithChildren,
            },
            Command::ShowAll => Intent::ShowAll,
            Command::Isolate => Intent::Isolate(ids),
            Command::Unparent => Intent::Reparent { ids, parent: None, before: None },
            Command::ParentToActive => {
                let active = self.session.selection.active()?;
                let others = ids.into_iter().filter(|id| *id != active).collect();
                Intent::Reparent { ids: others, parent: Some(active), before: None }
            }
            Command::DropToFloor => Intent::Commit(tools::drop::edit(document, &self.scenery(), &ids)),
            Command::AlignCamera => {
                let active = self.session.selection.active()?;
                let (place, turn) = (self.scene.camera.position(), self.scene.camera.rotation());
                Intent::Commit(tools::transform::placed(document, active, place, turn))
            }
            _ => return None,
        })
    }

    pub(crate) fn carry_out(&mut self, intent: Intent, ui: &Ui) {
        let active = self.session.selection.active();
        self.session.carry_out([intent]);
        if let Some(text) = self.session.copied.take() {
            ui.ctx().copy_text(text.clone());
            self.copied = Some(text);
        }
        let now = self.session.selection.active();
        if let Some(id) = now.filter(|_| now != active) {
            self.hierarchy.reveal(&self.session.document, id);
        }
    }

    fn choose(&mut self, command: Command) {
        let Session { document, selection, .. } = &mut self.session;
        if command == Command::SelectChildren {
            let children: Vec<EntityId> =
                selection.ids().iter().flat_map(|id| document.children(Some(*id)).to_vec()).collect();
            selection.set(children);
        } else if let Some(active) = selection.active() {
            layout::reveal(&mut self.layout, Pane::Hierarchy);
            self.hierarchy.rename(document, active);
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
            Command::ToggleVertexSnapping => handling.vertex ^= true,
            Command::ToggleWireframe => self.scene.wireframe ^= true,
            Command::ToggleGizmos => self.scene.hide_gizmos ^= true,
            Command::ViewCamera => self.look_through_camera(),
            Command::Frame if self.session.selection.is_empty() => self.frame_all(),
            Command::Frame => self.frame_selected(),
            Command::FrameAll => self.frame_all(),
            _ => {}
        }
    }

    /// From where the selected camera is, else the scene's.
    fn look_through_camera(&mut self) {
        let active = self.session.selection.active();
        let scenery = self.scenery();
        let selected = scenery.placed().find(|(entity, _)| Some(entity.id) == active);
        let own = selected.and_then(|(entity, world)| Some(Eye::of_camera(entity.camera.as_ref()?, world)));
        if let Some(eye) = own.or(scenery.camera()) {
            let camera = &mut self.scene.camera;
            let about = eye.position + eye.rotation * DVec3::NEG_Z * camera.distance;
            let speed = camera.speed;
            *camera = ViewCamera::as_eye(&eye, about);
            camera.speed = speed;
        }
    }

    fn frame_selected(&mut self) {
        let ids: Vec<EntityId> = self.session.selection.ids().into();
        self.frame(&ids);
    }

    fn frame_all(&mut self) {
        let all: Vec<EntityId> =
            self.session.document.scene().entities.iter().map(|entity| entity.id).collect();
        self.frame(&all);
    }

    fn file(&mut self, command: Command, ui: &Ui) {
        let document = &mut self.session.document;
        match command {
            Command::Save => document.save_in_background(),
            Command::Reload => document.reload_in_background(),
            Command::Quit => ui.ctx().send_viewport_cmd(ViewportCommand::Close),
            _ => {}
        }
    }

    fn window(&mut self, command: Command, ui: &Ui) {
        match command {
            Command::ResetLayout => self.layout = layout::default_layout(ui.ctx().content_rect().width()),
            Command::Palette => self.palette.toggle(),
            Command::ClearConsole => self.session.log.clear(),
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
