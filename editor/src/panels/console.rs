//! The console: what happened, newest at the end. A click on a line leads to what it is about.

use std::time::{SystemTime, UNIX_EPOCH};

use eframe::egui;
use egui::{Color32, Label, RichText, ScrollArea, Sense, TextEdit, Ui, vec2};

use crate::ask::{Ask, Asks};
use crate::assets::Wish;
use crate::command::Command;
use crate::icons::{self, Icon};
use crate::intents::Intent;
use crate::log::{Level, Line, Log, Source};
use crate::theme;

pub struct Console {
    levels: [bool; 3],
    search: String,
    lines: Vec<Line>,
    /// What the lines were filtered by.
    made_of: Option<(u64, [bool; 3], String)>,
}

impl Default for Console {
    fn default() -> Self {
        Self { levels: [true; 3], search: String::new(), lines: Vec::new(), made_of: None }
    }
}

const LEVELS: [(Level, Icon, &str); 3] = [
    (Level::Info, Icon::Info, "Remarks"),
    (Level::Warning, Icon::Warning, "Warnings"),
    (Level::Error, Icon::Error, "Errors"),
];

impl Console {
    pub fn show(&mut self, ui: &mut Ui, log: &Log, asks: &mut Asks) {
        self.bar(ui, log, asks);
        self.filter(log);
        if self.lines.is_empty() {
            ui.weak("Nothing to tell");
            return;
        }
        ui.spacing_mut().item_spacing.y = 0.0;
        let height = theme::ROW - 2.0;
        ScrollArea::vertical().auto_shrink(false).stick_to_bottom(true).show_rows(
            ui,
            height,
            self.lines.len(),
            |ui, range| self.lines[range].iter().for_each(|line| row(ui, line, asks)),
        );
    }

    /// All that is shown, as text.
    pub fn text(&self) -> String {
        self.lines
            .iter()
            .map(|line| format!("{} {:?}: {}\n", clock(line.at), line.level, line.text))
            .collect()
    }

    fn bar(&mut self, ui: &mut Ui, log: &Log, asks: &mut Asks) {
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 3.0;
            for (at, (level, icon, name)) in LEVELS.into_iter().enumerate() {
                if icons::button(ui, icon, name, "Shown or left out", self.levels[at]).clicked() {
                    self.levels[at] ^= true;
                }
                ui.label(
                    RichText::new(log.count(level).to_string()).small().color(theme::weak(ui.visuals())),
                );
                ui.add_space(6.0);
            }
            let field = TextEdit::singleline(&mut self.search).hint_text("Filter");
            let field = ui.add_sized(vec2(160.0, theme::ROW - 2.0), field);
            field.ctx.accesskit_node_builder(field.id, |node| node.set_label("Filter the console"));
            ui.add_space(6.0);
            if ui.button("Clear").on_hover_text("Forgets all lines").clicked() {
                asks.push(Command::ClearConsole);
            }
            if ui.button("Copy").on_hover_text("All that is shown, as text").clicked() {
                asks.push(Command::CopyConsole);
            }
        });
        ui.add_space(3.0);
    }

    fn filter(&mut self, log: &Log) {
        let now = (log.revision(), self.levels, self.search.clone());
        if self.made_of.as_ref() == Some(&now) {
            return;
        }
        let levels: Vec<Level> =
            LEVELS.into_iter().zip(self.levels).filter(|(_, on)| *on).map(|((level, ..), _)| level).collect();
        self.lines = log.filtered(&levels, &self.search);
        self.made_of = Some(now);
    }
}

pub fn color(ui: &Ui, level: Level) -> Color32 {
    match level {
        Level::Info => theme::weak(ui.visuals()),
        Level::Warning => ui.visuals().warn_fg_color,
        Level::Error => ui.visuals().error_fg_color,
    }
}

pub fn icon(level: Level) -> Icon {
    LEVELS[level as usize].1
}

fn row(ui: &mut Ui, line: &Line, asks: &mut Asks) {
    ui.horizontal(|ui| {
        ui.set_min_height(theme::ROW - 2.0);
        icons::label(ui, icon(line.level), color(ui, line.level));
        ui.label(RichText::new(clock(line.at)).monospace().color(theme::weak(ui.visuals())));
        let times = if line.times > 1 { format!("  ({} times)", line.times) } else { String::new() };
        let text = Label::new(format!("{}{times}", line.text)).truncate().sense(Sense::click());
        let response = ui.add(text);
        if line.source != Source::Nothing {
            response.clone().on_hover_cursor(egui::CursorIcon::PointingHand);
        }
        if response.clicked() {
            lead(&line.source, asks);
        }
        response.context_menu(|ui| {
            if ui.button("Copy line").clicked() {
                ui.ctx().copy_text(line.text.clone());
            }
        });
        response.on_hover_text(&line.text);
    });
}

/// To what a line is about.
fn lead(source: &Source, asks: &mut Asks) {
    match source {
        Source::Nothing => {}
        Source::Entity(id) => {
            asks.push(Intent::Select(vec![*id]));
            asks.push(Ask::Frame(vec![*id]));
        }
        Source::Material(id) => asks.push(Wish::RevealMaterial(*id)),
        Source::File(file) => asks.push(Wish::Reveal { file: file.clone() }),
    }
}

/// Hours, minutes and seconds, UTC.
fn clock(at: SystemTime) -> String {
    let seconds = at.duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
    format!("{:02}:{:02}:{:02}", seconds / 3600 % 24, seconds / 60 % 60, seconds % 60)
}
