//! The bar at the bottom: what was told last, and what is selected.

use eframe::egui::{self, Layout, Role, Sense, Ui, WidgetInfo};

use super::console;
use crate::ask::Asks;
use crate::command::Command;
use crate::icons;
use crate::log::{Level, Line, Log};
use crate::theme;

#[derive(Default)]
pub struct Status {
    /// And the log's revision then.
    last: (u64, Option<Line>),
}

impl Status {
    pub fn show(&mut self, ui: &mut Ui, log: &Log, selected: usize, entities: usize, asks: &mut Asks) {
        if self.last.0 != log.revision() {
            let all = [Level::Info, Level::Warning, Level::Error];
            self.last = (log.revision(), log.filtered(&all, "").pop());
        }
        ui.horizontal_centered(|ui| {
            if let (_, Some(line)) = &self.last {
                told(ui, line, asks);
            }
            ui.with_layout(Layout::right_to_left(egui::Align::Center), |ui| {
                let selected = if selected > 0 { format!("{selected} selected of ") } else { String::new() };
                ui.weak(format!("{selected}{entities} objects"));
            });
        });
    }
}

fn told(ui: &mut Ui, line: &Line, asks: &mut Asks) {
    let shown = ui.horizontal(|ui| {
        icons::label(ui, console::icon(line.level), console::color(ui, line.level));
        let text = line.text.lines().next().unwrap_or_default();
        let is_remark = line.level == Level::Info;
        let color = if is_remark { theme::weak(ui.visuals()) } else { ui.visuals().text_color() };
        ui.scope(|ui| {
            ui.set_max_width((ui.available_width() - 190.0).max(60.0));
            ui.add(egui::Label::new(egui::RichText::new(text).color(color)).truncate());
        });
    });
    let response = ui.interact(shown.response.rect, ui.scope_id().with("last line"), Sense::click());
    response.widget_info(|| WidgetInfo::labeled(Role::Button, true, "Show the console"));
    if response.clicked() {
        asks.push(Command::ShowConsole);
    }
}
