//! The tree of all entities. Only the rows that are seen are drawn, and which rows there are is found out once a change:
//! a tree of thousands costs as much as one of thirty.

mod row;

use std::collections::HashSet;

use eframe::egui;
use egui::{ScrollArea, Ui, vec2};
use engine::scene::{Entity, EntityId};

use super::menu;
use crate::ask::Asks;
use crate::command::{Bindings, State};
use crate::document::Document;
use crate::icons::{self, Icon};
use crate::intents::Intent;
use crate::selection::{Click, Selection};
use crate::theme;

/// Shows only what carries something.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Kind {
    #[default]
    All,
    Meshes,
    Lights,
    Cameras,
    Probes,
}

impl Kind {
    const ALL: [Self; 5] = [Self::All, Self::Meshes, Self::Lights, Self::Cameras, Self::Probes];

    fn name(self) -> &'static str {
        match self {
            Self::All => "All",
            Self::Meshes => "Meshes",
            Self::Lights => "Lights",
            Self::Cameras => "Cameras",
            Self::Probes => "Probes",
        }
    }

    fn takes(self, entity: &Entity) -> bool {
        match self {
            Self::All => true,
            Self::Meshes => entity.mesh.is_some(),
            Self::Lights => entity.light.is_some(),
            Self::Cameras => entity.camera.is_some(),
            Self::Probes => entity.light_probes.is_some() || entity.reflection_probe.is_some(),
        }
    }
}

/// One row of the list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Row {
    pub id: EntityId,
    pub depth: u16,
    pub has_children: bool,
}

/// What is dragged in the tree.
struct Dragged(Vec<EntityId>);

#[derive(Default)]
pub struct Hierarchy {
    search: String,
    kind: Kind,
    collapsed: HashSet<EntityId>,
    /// The name that is being typed.
    renaming: Option<(EntityId, String)>,
    rows: Vec<Row>,
    /// What the rows were made of.
    made_of: Option<(u64, String, Kind, usize)>,
    /// Brought into sight in the next picture.
    reveal: Option<EntityId>,
    /// Changes of what is collapsed.
    folds: usize,
    clicked: Option<EntityId>,
    /// Has the keyboard as soon as its row is drawn.
    focus: Option<EntityId>,
    /// Points that the list is scrolled by.
    scrolled: f32,
}

/// What the tree is drawn of.
pub struct Tree<'a> {
    pub document: &'a Document,
    pub selection: &'a Selection,
    /// For the menu on a right click.
    pub state: State,
    pub bindings: &'a Bindings,
}

impl Hierarchy {
    pub fn show(&mut self, ui: &mut Ui, tree: &Tree<'_>, asks: &mut Asks) {
        self.search_bar(ui);
        self.find_rows(tree.document);
        let height = theme::ROW - 2.0;
        ui.spacing_mut().item_spacing.y = 0.0;
        let mut area = ScrollArea::vertical().auto_shrink(false);
        if let Some(at) = self.reveal.take().and_then(|id| self.rows.iter().position(|row| row.id == id)) {
            let (top, room) = (at as f32 * height, ui.available_height());
            // What is in sight stays where it is.
            if top < self.scrolled || top + height > self.scrolled + room {
                let last = self.rows.len() as f32 * height - room;
                area = area.vertical_scroll_offset((top - room * 0.5).min(last).max(0.0));
            }
        }
        if self.rows.is_empty() {
            ui.add_space(12.0);
            ui.vertical_centered(|ui| ui.weak("Nothing here"));
            return;
        }
        let rows = self.rows.len();
        let shown = area.show_rows(ui, height, rows, |ui, range| {
            for at in range {
                let row = self.rows[at];
                if let Some(entity) = tree.document.entity(row.id) {
                    self.row(ui, row, entity, tree, asks);
                }
            }
            self.beside(ui, tree, asks);
        });
        self.scrolled = shown.state.clamped_offset().y;
    }

    /// The room under the last row: a click selects nothing, a right click offers to create, what is dropped there stands
    /// under nothing.
    fn beside(&self, ui: &mut Ui, tree: &Tree<'_>, asks: &mut Asks) {
        let rect = ui.clip_rect();
        let below = egui::Rect::from_min_max(egui::pos2(rect.left(), ui.min_rect().bottom()), rect.max);
        if below.height() < 4.0 {
            return;
        }
        let response = ui.interact(below, ui.scope_id().with("beside"), egui::Sense::click());
        let name = "Room under the tree";
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Label, true, name));
        if response.clicked() {
            asks.push(Intent::Select(Vec::new()));
        }
        if let Some(dropped) = response.dnd_release_payload::<Dragged>() {
            asks.push(Intent::Reparent { ids: dropped.0.clone(), parent: None, before: None });
        }
        response.context_menu(|ui| menu::context(ui, &tree.state, tree.bindings, asks));
    }

    /// Unfolds all that stands above an entity and brings it into sight. What was clicked here is in sight.
    pub fn reveal(&mut self, document: &Document, id: EntityId) {
        if self.clicked.take() == Some(id) {
            return;
        }
        for above in document.indexed().ancestors(id) {
            self.folds += usize::from(self.collapsed.remove(&above.id));
        }
        self.reveal = Some(id);
    }

    pub fn rename(&mut self, document: &Document, id: EntityId) {
        if let Some(entity) = document.entity(id) {
            self.clicked = None;
            self.reveal(document, id);
            self.renaming = Some((id, entity.name.clone()));
        }
    }

    /// The search field takes the keyboard.
    pub fn search(&self, ui: &Ui) {
        ui.memory_mut(|memory| memory.request_focus(egui::Id::unique("hierarchy search")));
    }

    fn search_bar(&mut self, ui: &mut Ui) {
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 4.0;
            let kind_width = 82.0;
            let width = (ui.available_width() - kind_width - 8.0).max(40.0);
            let hint = egui::TextEdit::singleline(&mut self.search)
                .id(egui::Id::unique("hierarchy search"))
                .hint_text("Search");
            let field = ui.add_sized(vec2(width, theme::ROW - 2.0), hint);
            field.ctx.accesskit_node_builder(field.id, |node| node.set_label("Search the hierarchy"));
            let chosen = egui::ComboBox::from_id_salt("kind")
                .selected_text(self.kind.name())
                .width(kind_width)
                .show_ui(ui, |ui| {
                    for kind in Kind::ALL {
                        ui.selectable_value(&mut self.kind, kind, kind.name());
                    }
                });
            let id = chosen.response.id;
            ui.ctx().accesskit_node_builder(id, |node| node.set_label("Show only"));
        });
        ui.add_space(4.0);
    }

    fn find_rows(&mut self, document: &Document) {
        let now = (document.revision(), self.search.clone(), self.kind, self.folds);
        if self.made_of.as_ref() == Some(&now) {
            return;
        }
        self.rows = rows(document, &self.search.to_lowercase(), self.kind, &self.collapsed);
        self.made_of = Some(now);
    }

    /// In their order, for a range with Shift.
    fn shown(&self) -> Vec<EntityId> {
        self.rows.iter().map(|row| row.id).collect()
    }

    fn click(&mut self, ui: &Ui, id: EntityId, asks: &mut Asks) {
        let modifiers = ui.input(|input| input.modifiers);
        let how = match (modifiers.shift, modifiers.command) {
            (true, _) => Click::Range,
            (_, true) => Click::Toggle,
            _ => Click::Replace,
        };
        self.clicked = Some(id);
        asks.push(Intent::Click { id, how, shown: self.shown() });
    }

    fn fold(&mut self, id: EntityId) {
        if !self.collapsed.remove(&id) {
            self.collapsed.insert(id);
        }
        self.folds += 1;
    }
}

/// A search or a filter makes the tree flat: what is looked for is shown, wherever it stands.
fn rows(document: &Document, search: &str, kind: Kind, collapsed: &HashSet<EntityId>) -> Vec<Row> {
    let is_flat = !search.is_empty() || kind != Kind::All;
    if is_flat {
        let matches = |entity: &&Entity| kind.takes(entity) && entity.name.to_lowercase().contains(search);
        let flat = |entity: &Entity| Row { id: entity.id, depth: 0, has_children: false };
        return document.scene().entities.iter().filter(matches).map(flat).collect();
    }
    let mut rows = Vec::new();
    let mut stack: Vec<(EntityId, u16)> = document.children(None).iter().rev().map(|id| (*id, 0)).collect();
    while let Some((id, depth)) = stack.pop() {
        let children = document.children(Some(id));
        rows.push(Row { id, depth, has_children: !children.is_empty() });
        if !collapsed.contains(&id) {
            stack.extend(children.iter().rev().map(|child| (*child, depth + 1)));
        }
    }
    rows
}

/// An icon for an entity in a list.
fn icon(entity: &Entity) -> Icon {
    crate::viewport::marks::icon_of(entity)
}

fn small_icon(ui: &Ui, rect: egui::Rect, icon: Icon, color: egui::Color32) {
    icons::paint_scaled(ui.painter(), rect, icon, color, 0.82);
}
