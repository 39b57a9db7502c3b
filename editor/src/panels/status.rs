//! The bar at the bottom: what was told last, and what is selected.

use eframe::egui::{self, Layout, Role, Sense, Ui, WidgetInfo};

use super::console;
use crate::ask::Asks;
use crate::assets::Wish;
use crate::command::Command;
use crate::icons;
use crate::importing::Going;
use crate::log::{Level, Line, Log};
use crate::theme;

#[derive(Default)]
pub struct Status {
    /// And the log's revision then.
    last: (u64, Option<Line>),
}

impl Status {
    pub fn show(
        &mut self,
        ui: &mut Ui,
        log: &Log,
        (selected, entities): (usize, usize),
        importing: Option<&Going>,
        asks: &mut Asks,
    ) {
        if self.last.0 != log.revision() {
            let all = [Level::Info, Level::Warning, Level::Error];
            self.last = (log.revision(), log.filtered(&all, "").pop());
        }
        ui.horizontal_centered(|ui| {
            if let (_, Some(line)) = &self.last {
                told(ui, line, if importing.is_some() { 520.0 } else { 190.0 }, asks);
            }
            ui.with_layout(Layout::right_to_left(egui::Align::Center), |ui| {
                // At the edge: a button that is aimed at stays where it is.
                if let Some(going) = importing {
                    import(ui, going, asks);
                    ui.add_space(14.0);
                }
                let selected = if selected > 0 { format!("{selected} selected of ") } else { String::new() };
                ui.weak(format!("{selected}{entities} objects"));
            });
        });
    }
}

/// From the right: how far an import is.
fn import(ui: &mut Ui, going: &Going, asks: &mut Asks) {
    let cancel = egui::Button::new("Cancel").small();
    let cancel = ui.add(cancel).on_hover_text("The import stops; nothing of it stays");
    cancel.ctx.accesskit_node_builder(cancel.id, |node| node.set_label("Cancel the import"));
    if cancel.clicked() {
        asks.push(Wish::CancelImport);
    }
    let (rect, _) = ui.allocate_exact_size(egui::vec2(80.0, 6.0), Sense::hover());
    ui.painter().rect_filled(rect, 3.0, ui.visuals().widgets.inactive.bg_fill);
    let done = rect.with_max_x(rect.left() + rect.width() * going.stage.share().max(0.05));
    ui.painter().rect_filled(done, 3.0, theme::accent(ui.visuals()));
    let waiting = if going.waiting > 0 { format!(", {} more wait", going.waiting) } else { String::new() };
    ui.weak(format!("{}: {}{waiting}", going.name, going.stage.name()));
}

/// `room`: points that are left free beside it.
fn told(ui: &mut Ui, line: &Line, room: f32, asks: &mut Asks) {
    let shown = ui.horizontal(|ui| {
        icons::label(ui, console::icon(line.level), console::color(ui, line.level));
        let text = line.text.lines().next().unwrap_or_default();
        let is_remark = line.level == Level::Info;
        let color = if is_remark { theme::weak(ui.visuals()) } else { ui.visuals().text_color() };
        ui.scope(|ui| {
            ui.set_max_width((ui.available_width() - room).max(60.0));
            ui.add(egui::Label::new(egui::RichText::new(text).color(color)).truncate());
        });
    });
    let response = ui.interact(shown.response.rect, ui.scope_id().with("last line"), Sense::click());
    response.widget_info(|| WidgetInfo::labeled(Role::Button, true, "Show the console"));
    if response.clicked() {
        asks.push(Command::ShowConsole);
    }
}
