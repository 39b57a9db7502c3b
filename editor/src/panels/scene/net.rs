//! The tetrahedra between light probes over the picture, and a plane that cuts them.

use std::sync::Arc;

use eframe::egui;
use egui::epaint::{Mesh, Vertex};
use egui::{Color32, Pos2, Rect, Shape, Stroke, Ui};
use engine::render::lines::Line;
use glam::{DQuat, DVec3, Vec4};

use super::bars::{bar, told};
use super::hand::Hand;
use super::handles::tell_beside_mouse;
use crate::gizmo::{Change, Grasp, Handle, Stand};
use crate::lens::Lens;
use crate::scenery::Scenery;
use crate::theme;
use crate::tools::slice::{self, Plane, Slice};
use crate::tools::web::{Web, Webs};

/// Edges of the hull, and inside; linear, and opacity.
const ON_HULL: Vec4 = Vec4::new(1.0, 0.42, 0.03, 0.95);
const INSIDE: Vec4 = Vec4::new(0.08, 0.5, 1.0, 0.75);
const FILL: f32 = 0.5;
/// Points from the handle of the plane that still hit it, and its length.
const HIT: f32 = 9.0;
const REACH: f32 = 46.0;

#[derive(Default)]
pub struct Net {
    pub tetrahedra: bool,
    /// A plane through them.
    pub plane: Option<Plane>,
    webs: Webs,
    cut: Option<(Arc<Web>, Plane, Slice)>,
    pull: Option<(Grasp, f64)>,
}

impl Net {
    pub fn is_pulled(&self) -> bool {
        self.pull.is_some()
    }

    fn is_shown(&self) -> bool {
        self.tetrahedra || self.plane.is_some()
    }

    /// As it is drawn.
    pub fn web(&self) -> &Web {
        self.webs.web()
    }

    /// As it is drawn.
    pub fn slice(&self) -> Option<&Slice> {
        self.plane.and(self.cut.as_ref()).map(|(.., slice)| slice)
    }

    /// With a plane through the middle of all probes, or without one.
    pub fn toggle_slice(&mut self, scenery: &Scenery<'_>) {
        self.plane = match self.plane {
            Some(_) => None,
            None => {
                self.webs.follow(scenery);
                let middle = extent(self.web()).map_or(0.0, |[low, high]| (low.y + high.y) * 0.5);
                Some(Plane { axis: 1, offset: middle })
            }
        };
    }

    pub(super) fn follow(&mut self, ui: &Ui, scenery: &Scenery<'_>) {
        if !self.is_shown() {
            return;
        }
        self.webs.follow(scenery);
        if self.webs.is_busy() {
            ui.ctx().request_repaint_after(std::time::Duration::from_millis(20));
        }
        let Some(plane) = self.plane else { return };
        let web = self.webs.web();
        let is_known =
            self.cut.as_ref().is_some_and(|(of, through, _)| Arc::ptr_eq(of, web) && *through == plane);
        if !is_known {
            self.cut = Some((web.clone(), plane, slice::slice(web, &plane)));
        }
    }

    /// Edges, relative to `origin`.
    pub(super) fn lines(&self, origin: DVec3) -> Vec<Line> {
        let web = self.web();
        let place = |probe: usize| (web.positions[probe] - origin).as_vec3();
        let line = |(probes, on_hull): &([usize; 2], bool)| Line {
            ends: probes.map(place),
            color: if *on_hull { ON_HULL } else { INSIDE },
        };
        let edges = if self.tetrahedra { web.edges.as_slice() } else { &[] };
        edges.iter().map(line).collect()
    }

    /// Where the plane is held.
    fn stand(&self) -> Option<Stand> {
        let (plane, slice) = (self.plane?, self.slice()?);
        let mut origin = match slice.cuts.len() {
            0 => extent(self.web()).map(|[low, high]| (low + high) * 0.5)?,
            count => slice.cuts.iter().map(|cut| cut.at).sum::<DVec3>() / count as f64,
        };
        origin[plane.axis] = plane.offset;
        Some(Stand { origin, axes: DQuat::IDENTITY })
    }

    fn is_under(&self, hand: &Hand<'_>, at: Pos2) -> bool {
        let ends =
            self.stand().zip(self.plane).and_then(|(stand, plane)| shaft(hand.lens, &stand, plane.axis));
        ends.is_some_and(|[from, to]| crate::gizmo::to_segment(at, from, to) <= HIT)
    }

    /// Returns whether the mouse is the plane's.
    pub(super) fn handle(&mut self, hand: &Hand<'_>) -> bool {
        if let Some((stand, plane, at)) = self.grasped(hand) {
            let grasp = Grasp::new(Handle::MoveAxis(plane.axis), stand, hand.lens, at);
            self.pull = Some((grasp, plane.offset));
        }
        let (Some((grasp, from)), Some(plane)) = (&mut self.pull, &mut self.plane) else { return false };
        if let Some(Change::Move(way)) = hand.at.and_then(|at| grasp.change(hand.lens, at, None)) {
            plane.offset = *from + way[plane.axis];
        }
        if !hand.down {
            self.pull = None;
        }
        true
    }

    fn grasped(&self, hand: &Hand<'_>) -> Option<(Stand, Plane, Pos2)> {
        let at = hand.at.filter(|at| hand.pressed && self.pull.is_none() && self.is_under(hand, *at))?;
        Some((self.stand()?, self.plane?, at))
    }

    pub(super) fn paint(&self, hand: &Hand<'_>) {
        let (Some(plane), Some(slice)) = (self.plane, self.slice()) else { return };
        let painter = hand.painter();
        painter.add(Shape::mesh(filled(hand.lens, slice)));
        for side in &slice.sides {
            if let Some(ends) = hand.lens.segment(slice.cuts[side[0]].at, slice.cuts[side[1]].at) {
                painter.line_segment(ends, Stroke::new(1.0, Color32::from_white_alpha(150)));
            }
        }
        let ends = self.stand().and_then(|stand| shaft(hand.lens, &stand, plane.axis));
        let Some([from, to]) = ends else { return };
        let hot = self.is_pulled() || hand.over && hand.at.is_some_and(|at| self.is_under(hand, at));
        let color = if hot { theme::GRASPED } else { theme::AXES[plane.axis] };
        painter.line_segment([from, to], Stroke::new(5.0, Color32::from_black_alpha(140)));
        painter.line_segment([from, to], Stroke::new(2.5, color));
        for end in [from, to] {
            painter.circle(end, 5.5, color, Stroke::new(1.5, Color32::from_black_alpha(160)));
        }
        if self.is_pulled() {
            tell_beside_mouse(hand, &format!("{} = {:.3} m", ["x", "y", "z"][plane.axis], plane.offset));
        }
    }

    /// Where the plane lies, and what it cuts.
    pub(super) fn bar(&mut self, ui: &mut Ui, corner: Pos2, width: f32) -> Option<Rect> {
        let reach = extent(self.web());
        let words = match self.slice() {
            _ if self.web().cells.is_empty() => {
                "No tetrahedra: four probes that span space make one".to_owned()
            }
            Some(slice) => format!("cuts {} tetrahedra", slice.sections),
            None => String::new(),
        };
        let plane = self.plane.as_mut()?;
        Some(bar(ui, corner, width, |ui| {
            ui.label("Slice");
            for (axis, name) in ["X", "Y", "Z"].into_iter().enumerate() {
                let label = ui.selectable_label(plane.axis == axis, name);
                label
                    .ctx
                    .accesskit_node_builder(label.id, |node| node.set_label(format!("Slice across {name}")));
                if label.on_hover_text("The axis that the plane lies across").clicked() {
                    let middle = reach.map_or(0.0, |[low, high]| (low[axis] + high[axis]) * 0.5);
                    *plane = Plane { axis, offset: middle };
                }
            }
            let [low, high] = reach.map_or([-1.0, 1.0], |reach| reach.map(|end| end[plane.axis]));
            ui.spacing_mut().slider_width = 150.0;
            let slider = egui::Slider::new(&mut plane.offset, low..=high.max(low + 1e-6));
            let slider = slider.suffix(" m").max_decimals(3).clamping(egui::SliderClamping::Never);
            let response = ui.add(slider);
            response.ctx.accesskit_node_builder(response.id, |node| node.set_label("Place of the slice"));
            told(ui, &words);
        }))
    }
}

fn extent(web: &Web) -> Option<[DVec3; 2]> {
    let fold = |with: fn(DVec3, DVec3) -> DVec3| web.positions.iter().copied().reduce(with);
    Some([fold(DVec3::min)?, fold(DVec3::max)?])
}

fn shaft(lens: &Lens, stand: &Stand, axis: usize) -> Option<[Pos2; 2]> {
    let way = DVec3::AXES[axis] * lens.metres_per_point(stand.origin) * f64::from(REACH);
    Some([lens.project(stand.origin - way)?.0, lens.project(stand.origin + way)?.0])
}

/// Each probe has a colour of its own; between probes colours are blended as light would be.
fn filled(lens: &Lens, slice: &Slice) -> Mesh {
    let mut mesh = Mesh::default();
    let seen: Vec<Option<Pos2>> =
        slice.cuts.iter().map(|cut| lens.project(cut.at).map(|(seen, _)| seen)).collect();
    for (cut, seen) in slice.cuts.iter().zip(&seen) {
        let [from, to] = cut.probes.map(color_of);
        let color = from.lerp_to_gamma(to, cut.share as f32).gamma_multiply(FILL);
        mesh.vertices.push(Vertex { pos: seen.unwrap_or_default(), uv: egui::epaint::WHITE_UV, color });
    }
    for corners in slice.triangles.iter().filter(|corners| corners.iter().all(|cut| seen[*cut].is_some())) {
        mesh.indices.extend(corners.map(|cut| cut as u32));
    }
    mesh
}

/// Hues of neighbours in the list lie far apart: steps of the golden ratio.
fn color_of(probe: usize) -> Color32 {
    let hue = (probe as f32 * 0.618_034).fract();
    egui::ecolor::Hsva::new(hue, 0.75, 0.95, 1.0).into()
}
