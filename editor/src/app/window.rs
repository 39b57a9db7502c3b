//! The window, and the device that it shares with the engine.

use std::sync::Arc;

use eframe::egui;
use eframe::egui_wgpu::{WgpuConfiguration, WgpuSetup, WgpuSetupCreateNew};
use egui::Ui;
use engine::gpu::Gpu;

use super::Editor;
use crate::baking::Badge;
use crate::command::Command;
use crate::opened::Opened;
use crate::recent;

impl eframe::App for Editor {
    fn ui(&mut self, ui: &mut Ui, _: &mut eframe::Frame) {
        Editor::ui(self, ui);
    }

    fn raw_input_hook(&mut self, ctx: &egui::Context, input: &mut egui::RawInput) {
        self.in_turn.sort(ctx, input);
    }

    fn on_exit(&mut self) {
        self.keep_preferences();
    }
}

/// A device as the engine needs it; all that eframe asks for by itself is a part of that.
fn wgpu_setup(mut setup: WgpuSetupCreateNew) -> WgpuSetup {
    setup.device_descriptor = Arc::new(Gpu::descriptor);
    WgpuSetup::CreateNew(setup)
}

/// The same for pictures that no window shows.
pub fn wgpu_setup_headless() -> WgpuSetup {
    let mut setup = WgpuSetupCreateNew::without_display_handle();
    setup.instance_descriptor.backends = engine::gpu::backends();
    wgpu_setup(setup)
}

/// Opens a window and stays until it is closed. `bake_first`: a scene that was never baked is, at once.
pub fn run(opened: Opened, bake_first: bool) -> eframe::Result {
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
        let mut editor = Editor::new(&cc.egui_ctx, state, opened, recent::folder())?;
        if bake_first && editor.baking.badge(&editor.session.document) == Badge::Missing {
            editor.run_bake(Command::Bake);
        }
        Ok(Box::new(editor) as Box<dyn eframe::App>)
    };
    eframe::run_native("hohlraum", options, Box::new(create))
}
