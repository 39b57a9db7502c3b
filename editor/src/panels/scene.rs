//! The scene view: the scene as its author moves through it, with what is selected, and handles to move it.

mod bars;
pub mod brush;
pub mod choose;
mod dropped;
mod faces;
mod hand;
mod handles;
pub mod net;
pub mod pick;
mod preview;
pub mod probing;
mod vertex;

use std::sync::Arc;

use eframe::egui;
use egui::{Align2, Color32, FontId, Pos2, Rect, Role, Sense, Ui, WidgetInfo, pos2};
use engine::render::outline::Marks;
use engine::render::{Eye, View};
use engine::scene::EntityId;
use engine::scene::assets::Assets;

use crate::ask::Asks;
use crate::camera::ViewCamera;
use crate::command::Command;
use crate::document::Document;
use crate::gizmo::{Steps, Tool};
use crate::intents::Intent;
use crate::lens::Lens;
use crate::scenery::Scenery;
use crate::selection::Selection;
use crate::tools::hit::Caster;
use crate::tools::navigate;
use crate::viewport::marks::{self, Mark};
use crate::viewport::{Picture, Stage, grid};
use hand::Hand;

/// How handles stand and pull.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Handling {
    pub tool: Tool,
    /// Along the axes of the active entity, not the world's.
    pub local: bool,
    /// In the middle of all that is selected, not at the active entity's origin.
    pub centre: bool,
    pub snap: bool,
    /// A vertex goes to a vertex.
    pub vertex: bool,
    pub steps: Steps,
}

#[derive(Default)]
pub struct SceneView {
    pub camera: ViewCamera,
    pub view: View,
    pub handling: Handling,
    pub hide_grid: bool,
    pub hide_gizmos: bool,
    pub wireframe: bool,
    pub picture: Picture,
    /// Of the last picture of the editor, where the panel is shown.
    pub lens: Option<Lens>,
    pub net: net::Net,
    pub painting: brush::Painting,
    pub probing: probing::Probing,
    handles: handles::Handles,
    faces: faces::Faces,
    vertex: vertex::VertexSnapping,
    pub choosing: choose::Choosing,
    preview: preview::Preview,
    caster: Caster,
    /// Where bars lay over the picture last.
    covered: Vec<Rect>,
}

/// What the panel is drawn of.
pub struct Seen<'a> {
    pub document: &'a Document,
    pub assets: &'a Arc<Assets>,
    pub scenery: Scenery<'a>,
    pub selection: &'a Selection,
}

impl SceneView {
    pub fn show(&mut self, ui: &mut Ui, stage: &mut Stage, seen: &Seen<'_>, asks: &mut Asks) {
        let rect = ui.available_rect_before_wrap();
        let response = ui.allocate_rect(rect, Sense::click_and_drag());
        response.widget_info(|| WidgetInfo::labeled(Role::Image, true, "Scene view"));
        let navigates = !self.is_pulling() && navigate::navigate(ui, &response, &mut self.camera);
        let exposed_as = seen.scenery.camera().unwrap_or(Eye::looking(glam::DVec3::Z, glam::DVec3::ZERO));
        let lens = Lens { eye: self.camera.eye(&exposed_as), rect };
        self.lens = Some(lens);
        let covers = ui.input(|input| input.pointer.latest_pos());
        let is_covered = covers.is_some_and(|at| self.covered.iter().any(|bar| bar.contains(at)));
        let hand = Hand::new(ui, &response, &lens, seen, !navigates && !is_covered);

        self.net.follow(ui, &seen.scenery);
        let marks = self.marks(&lens, seen);
        self.hand(&hand, &marks, stage, asks);
        self.picture(ui, stage, seen, &lens);
        self.paint(&hand, &marks);
        self.covered.clear();
        self.covered.extend(self.preview.show(ui, rect, stage, seen));
        self.controls(ui, rect);
        self.tool_bars(ui, rect, seen, asks);
        self.choosing.list_under_mouse(ui, seen, asks);
        dropped::show(ui, &response, &lens, seen, self.camera.pivot, &mut self.caster, asks);
    }

    /// Something is held by the mouse: keys belong to it, and the camera stays.
    pub fn is_pulling(&self) -> bool {
        self.handles.is_pulled()
            || self.faces.is_pulled()
            || self.vertex.is_pulled()
            || self.painting.is_pulled()
            || self.probing.is_pulled()
            || self.net.is_pulled()
            || self.choosing.is_boxing()
    }

    /// What a command means to the tool at hand; `None`: what it always means.
    pub fn intent(
        &mut self,
        command: Command,
        document: &Document,
        active: Option<EntityId>,
    ) -> Option<Intent> {
        (self.handling.tool == Tool::Probes).then(|| self.probing.intent(command, document, active))?
    }

    /// Pictures are drawn anew: the light is another.
    pub fn forget(&mut self) {
        self.picture.forget();
        self.preview.forget();
    }

    fn marks(&self, lens: &Lens, seen: &Seen<'_>) -> Vec<Mark> {
        if self.hide_gizmos {
            return Vec::new();
        }
        let open =
            seen.scenery.placed().filter(|(entity, _)| !entity.hidden && !seen.document.is_locked(entity.id));
        marks::marks(lens, open)
    }

    /// The mouse goes to the first that wants it.
    fn hand(&mut self, hand: &Hand<'_>, marks: &[Mark], stage: &Stage, asks: &mut Asks) {
        self.choosing.watch(hand);
        self.vertex.watch(hand, &mut self.handling.vertex);
        if self.handling.tool != Tool::Density {
            self.painting.put_down();
        }
        if self.net.handle(hand) {
            return;
        }
        let is_authored = !hand.seen.scenery.is_playing;
        let taken = is_authored
            && !self.hide_gizmos
            && match self.handling.tool {
                Tool::Density => {
                    self.painting.handle(hand, &mut self.caster, asks);
                    true
                }
                Tool::Probes => {
                    self.probing.handle(hand, &self.handling, &mut self.caster, asks);
                    true
                }
                _ => {
                    self.handling.vertex && self.vertex.handle(hand, &mut self.caster, asks)
                        || self.faces.handle(hand, &self.handling, asks)
                        || self.handles.handle(hand, &self.handling, asks)
                }
            };
        if !taken && (hand.over || self.choosing.is_boxing()) {
            self.choosing.handle(hand, marks, stage, asks);
        }
    }

    fn picture(&mut self, ui: &Ui, stage: &mut Stage, seen: &Seen<'_>, lens: &Lens) {
        let size = Picture::pixels(stage.gpu(), lens.rect.size(), ui.ctx().pixels_per_point());
        let mut lines = if self.hide_grid { Vec::new() } else { grid::lines(&self.camera, stage.origin()) };
        lines.extend(self.net.lines(stage.origin()));
        if self.handling.tool == Tool::Density {
            lines.extend(self.painting.lines(stage.origin()));
        }
        let outlined = match self.handling.tool {
            // Its outline would hide what is painted and placed.
            tool if tool.is_light() => Default::default(),
            // With all that it carries: a group has no surface of its own.
            _ => {
                let indexed = seen.document.indexed();
                seen.selection.ids().iter().flat_map(|id| indexed.subtree(*id)).collect()
            }
        };
        let displaced = seen.scenery.displaced.clone();
        let marks = Marks { lines, outlined, displaced, wireframe: self.wireframe };
        let now = seen.scenery.now(lens.eye, self.view);
        let shown = self.picture.show(stage, &now, seen.scenery.revision, &marks, size);
        if let Some(texture) = shown {
            let uv = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
            ui.painter().image(texture, lens.rect, uv, Color32::WHITE);
        }
        if let Some(error) = &self.picture.error {
            let (font, color) = (FontId::proportional(13.0), ui.visuals().error_fg_color);
            ui.painter().text(lens.rect.center(), Align2::CENTER_CENTER, error, font, color);
        }
        if !self.picture.is_settled() {
            ui.ctx().request_repaint();
        }
    }

    /// What is drawn over the picture.
    fn paint(&mut self, hand: &Hand<'_>, marks: &[Mark]) {
        let Hand { lens, seen, .. } = *hand;
        let painter = hand.painter();
        let selected = |entity: &engine::scene::Entity| seen.selection.contains(entity.id);
        if !self.hide_gizmos && !self.handling.tool.is_light() {
            for (entity, world) in seen.scenery.placed().filter(|(entity, _)| selected(entity)) {
                marks::paint_reach(&painter, lens, entity, world, 16.0 / 9.0);
            }
        }
        marks::paint(&painter, marks, |id| seen.selection.contains(id));
        self.net.paint(hand);
        if seen.scenery.is_playing || self.hide_gizmos {
            return;
        }
        match self.handling.tool {
            Tool::Density => self.painting.paint(hand),
            Tool::Probes => self.probing.paint(hand),
            _ if self.handling.vertex => self.vertex.paint(hand, &mut self.caster),
            _ => {
                self.faces.paint(hand);
                self.handles.paint(hand, &self.handling);
            }
        }
    }

    /// Bars of the tool at hand, one under the other.
    fn tool_bars(&mut self, ui: &mut Ui, rect: Rect, seen: &Seen<'_>, asks: &mut Asks) {
        let left = rect.left() + 8.0;
        // Under the bar of what is shown.
        let mut top = rect.top() + 42.0;
        // Beside the view cube.
        let width = (rect.width() - 120.0).max(200.0);
        let tool = self.handling.tool;
        let place = match tool {
            _ if seen.scenery.is_playing => None,
            Tool::Density => Some(self.painting.bar(ui, Pos2::new(left, top), width)),
            Tool::Probes => Some(self.probing.bar(ui, (Pos2::new(left, top), width), seen, asks)),
            _ => None,
        };
        if let Some(place) = place {
            top = place.bottom() + 5.0;
            self.covered.push(place);
        }
        let place = self.net.bar(ui, Pos2::new(left, top), width);
        self.covered.extend(place);
    }
}
