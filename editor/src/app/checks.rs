//! What of the table is switched on, for the check marks in menus.

use crate::app::Editor;
use crate::command::Command;
use crate::gizmo::Tool;
use crate::layout;
use crate::panels::toolbar::Playing;
use crate::run;

impl Editor {
    /// `None`: the command is no switch.
    pub fn is_on(&self, command: Command) -> Option<bool> {
        if let Some(pane) = run::pane(command) {
            return Some(layout::is_in_front(&self.layout, pane));
        }
        if let Some(view) = run::view(command) {
            return Some(self.scene.view == view);
        }
        let handling = &self.scene.handling;
        Some(match command {
            Command::ToolSelect => handling.tool == Tool::View,
            Command::ToolMove => handling.tool == Tool::Move,
            Command::ToolRotate => handling.tool == Tool::Rotate,
            Command::ToolScale => handling.tool == Tool::Scale,
            Command::DensityBrush => handling.tool == Tool::Density,
            Command::EditLightProbes => handling.tool == Tool::Probes,
            Command::ToggleSnapping => handling.snap,
            Command::ToggleVertexSnapping => handling.vertex,
            Command::ToggleGrid => !self.scene.hide_grid,
            Command::ToggleGizmos => !self.scene.hide_gizmos,
            Command::ToggleWireframe => self.scene.wireframe,
            Command::ShowTetrahedra => self.scene.net.tetrahedra,
            Command::ShowProbeSlice => self.scene.net.slice().is_some(),
            Command::Play => self.playing() != Playing::No,
            Command::Pause => self.playing() == Playing::Paused,
            _ => return None,
        })
    }
}
