//! The bar under the menus: tools, how they stand, play.

use eframe::egui;
use egui::{Layout, Ui, vec2};

use super::scene::Handling;
use crate::ask::Asks;
use crate::baking::{Badge, Progress};
use crate::command::Command;
use crate::gizmo::Tool;
use crate::icons::{self, Icon};
use crate::theme;

const TOOLS: [(Tool, Command, Icon, &str, &str); 6] = [
    (Tool::View, Command::ToolSelect, Icon::View, "Select", "Look and select, nothing else (Q)"),
    (Tool::Move, Command::ToolMove, Icon::Move, "Move", "Move what is selected (W)"),
    (Tool::Rotate, Command::ToolRotate, Icon::Rotate, "Rotate", "Turn what is selected (E)"),
    (Tool::Scale, Command::ToolScale, Icon::Scale, "Scale", "Scale what is selected (R)"),
    (
        Tool::Density,
        Command::DensityBrush,
        Icon::Brush,
        "Density brush",
        "Paint how finely surfaces are divided for the light (B)",
    ),
    (
        Tool::Probes,
        Command::EditLightProbes,
        Icon::LightProbes,
        "Edit light probes",
        "Set, choose, move and delete light probes (P)",
    ),
];

/// What of playing the buttons show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Playing {
    No,
    Runs,
    Paused,
}

/// What of the light the button shows.
pub struct Light {
    pub badge: Badge,
    /// Of a bake that goes on.
    pub progress: Option<Progress>,
}

pub fn show(ui: &mut Ui, handling: &mut Handling, playing: Playing, light: &Light, asks: &mut Asks) {
    ui.horizontal_centered(|ui| {
        ui.spacing_mut().item_spacing.x = 3.0;
        tools(ui, handling, asks);
        let width = 26.0 * 3.0 + 6.0;
        let room = ui.available_width() + ui.min_rect().width();
        let left = (room - width) * 0.5 - ui.min_rect().width();
        ui.add_space(left.max(8.0));
        play(ui, playing, asks);
        ui.with_layout(Layout::right_to_left(egui::Align::Center), |ui| match &light.progress {
            Some(progress) => baking(ui, progress, asks),
            None => bake_button(ui, &light.badge, playing, asks),
        });
    });
}

/// What the bake is worth, and the button that makes another.
fn bake_button(ui: &mut Ui, badge: &Badge, playing: Playing, asks: &mut Asks) {
    ui.add_enabled_ui(playing == Playing::No, |ui| {
        let button = ui
            .button("Bake")
            .on_hover_text("Bakes the light on threads of its own; edit on meanwhile (Ctrl+B)");
        if button.clicked() {
            asks.push(Command::Bake);
        }
    });
    let (told, why, color) = match badge {
        Badge::Missing => ("Not baked", "Only direct light is shown", ui.visuals().warn_fg_color),
        Badge::Current => ("Light is current", "The bake was made of this scene", CURRENT),
        Badge::LightOnly => (
            "Light is current",
            "Only lights and colors have changed since the bake: they need none",
            CURRENT,
        ),
        Badge::Stale(why) if why.is_empty() => {
            ("Bake is stale", "Surfaces have changed since the bake", ui.visuals().warn_fg_color)
        }
        Badge::Stale(why) => ("Bake is stale", why.as_str(), ui.visuals().warn_fg_color),
    };
    ui.add_space(4.0);
    let label = ui.label(egui::RichText::new(told).color(theme::weak(ui.visuals())));
    let (rect, dot) = ui.allocate_exact_size(vec2(12.0, 12.0), egui::Sense::hover());
    ui.painter().circle_filled(rect.center(), 4.0, color);
    label.union(dot).on_hover_text(why);
}

const CURRENT: egui::Color32 = egui::Color32::from_rgb(0x5f, 0xb3, 0x5f);

fn baking(ui: &mut Ui, progress: &Progress, asks: &mut Asks) {
    if ui.button("Cancel").on_hover_text("The bake stops, and what is shown stays (Ctrl+Shift+B)").clicked() {
        asks.push(Command::CancelBake);
    }
    let left = progress.remaining.map_or(String::new(), |left| match left.as_secs() + 1 {
        seconds @ ..100 => format!(", {seconds} s left"),
        seconds => format!(", {} min left", seconds.div_ceil(60)),
    });
    let text = format!("{} {:.0} %{left}", progress.stage, progress.share * 100.0);
    let (rect, _) = ui.allocate_exact_size(vec2(90.0, 6.0), egui::Sense::hover());
    ui.painter().rect_filled(rect, 3.0, ui.visuals().widgets.inactive.bg_fill);
    let done = rect.with_max_x(rect.left() + rect.width() * progress.share.clamp(0.0, 1.0) as f32);
    ui.painter().rect_filled(done, 3.0, theme::accent(ui.visuals()));
    ui.label(egui::RichText::new(text).color(theme::weak(ui.visuals())));
}

fn tools(ui: &mut Ui, handling: &mut Handling, asks: &mut Asks) {
    for (tool, command, icon, name, tooltip) in TOOLS {
        if icons::button(ui, icon, name, tooltip, handling.tool == tool).clicked() {
            asks.push(command);
        }
    }
    gap(ui);
    let (icon, name, tooltip) = match handling.local {
        true => (Icon::Local, "Local axes", "Handles stand along the axes of what is selected (X)"),
        false => (Icon::Global, "World axes", "Handles stand along the axes of the world (X)"),
    };
    if icons::button(ui, icon, name, tooltip, false).clicked() {
        handling.local ^= true;
    }
    let (icon, name, tooltip) = match handling.centre {
        true => (Icon::Centre, "Centre", "Handles stand in the middle of all that is selected (Z)"),
        false => (Icon::Pivot, "Pivot", "Handles stand at the origin of what was selected last (Z)"),
    };
    if icons::button(ui, icon, name, tooltip, false).clicked() {
        handling.centre ^= true;
    }
    gap(ui);
    let tooltip = "Pulls go in steps; Ctrl does the opposite while it is held. Right click sets the steps";
    let snap = icons::button(ui, Icon::Snap, "Snapping", tooltip, handling.snap);
    if snap.clicked() {
        handling.snap ^= true;
    }
    egui::Popup::context_menu(&snap).close_behavior(egui::PopupCloseBehavior::CloseOnClickOutside).show(
        |ui| {
            steps(ui, handling);
        },
    );
}

fn steps(ui: &mut Ui, handling: &mut Handling) {
    let steps = &mut handling.steps;
    egui::Grid::new("steps").num_columns(2).spacing(vec2(12.0, 6.0)).show(ui, |ui| {
        let mut row = |name: &str, value: &mut f64, suffix: &str, speed: f64| {
            let label = ui.label(name);
            let value = egui::DragValue::new(value).speed(speed).range(0.0..=1000.0).suffix(suffix);
            ui.add(value).labelled_by(label.id);
            ui.end_row();
        };
        row("Move", &mut steps.metres, " m", 0.01);
        row("Rotate", &mut steps.degrees, "\u{b0}", 0.5);
        row("Scale", &mut steps.scale, "", 0.01);
    });
}

fn play(ui: &mut Ui, playing: Playing, asks: &mut Asks) {
    let runs = playing != Playing::No;
    let (icon, name) = if runs { (Icon::Stop, "Stop") } else { (Icon::Play, "Play") };
    let tooltip = "The scene comes alive; stopping brings back exactly what you made (F5)";
    if icons::button(ui, icon, name, tooltip, runs).clicked() {
        asks.push(Command::Play);
    }
    ui.add_enabled_ui(runs, |ui| {
        let paused = playing == Playing::Paused;
        if icons::button(ui, Icon::Pause, "Pause", "Time stands still (F6)", paused).clicked() {
            asks.push(Command::Pause);
        }
        if icons::button(ui, Icon::Step, "Step", "One picture on, then time stands still (F7)", false)
            .clicked()
        {
            asks.push(Command::Step);
        }
    });
}

fn gap(ui: &mut Ui) {
    ui.add_space(4.0);
    let (rect, _) = ui.allocate_exact_size(vec2(1.0, 16.0), egui::Sense::hover());
    ui.painter().rect_filled(rect, 0.0, ui.visuals().widgets.inactive.bg_fill);
    ui.add_space(4.0);
}
