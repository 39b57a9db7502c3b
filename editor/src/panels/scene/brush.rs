//! The density brush in the hand: where it lies, what a stroke of it paints, and the patches that a bake would make.

use std::collections::BTreeMap;

use eframe::egui;
use egui::{Color32, Key, Pos2, Rect, Stroke, Ui};
use engine::render::lines::Line;
use engine::scene::density::RANGE;
use engine::scene::{Density, Entity, EntityId};
use glam::{DVec3, Vec4};

use super::SceneView;
use super::bars::{bar, number, told};
use super::hand::Hand;
use crate::ask::Asks;
use crate::baking::density::Brush;
use crate::baking::patches::Patching;
use crate::edit::{Edit, Field};
use crate::intents::Intent;
use crate::theme;
use crate::tools::hit::{Caster, Hit};

/// Share of the radius between dabs of a stroke.
const APART: f64 = 0.25;
/// Dabs between two pictures, however far the mouse went.
const MOST_DABS: usize = 24;
/// Outlines of patches; linear, and opacity.
const OUTLINE: Vec4 = Vec4::new(1.0, 0.62, 0.1, 0.75);
/// Metres.
const RADII: std::ops::RangeInclusive<f64> = 0.01..=100.0;

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    #[default]
    Paint,
    Erase,
    Smooth,
}

const MODES: [(Mode, &str, &str); 3] = [
    (Mode::Paint, "Paint", "Strokes bring the density towards the number beside"),
    (Mode::Erase, "Erase", "Strokes take paint away. Ctrl does this while it is held"),
    (Mode::Smooth, "Smooth", "Strokes even out differences. Shift does this while it is held"),
];

pub struct Painting {
    pub mode: Mode,
    pub brush: Brush,
    stroke: Option<Painted>,
    pub patching: Patching,
    /// What the brush was on last: its patches are shown.
    on: Option<EntityId>,
    hit: Option<Hit>,
    /// Its radius fits the scene, or somebody's wish.
    is_sized: bool,
}

/// What a stroke has painted so far.
#[derive(Default)]
struct Painted {
    densities: BTreeMap<EntityId, Density>,
    last: Option<DVec3>,
}

impl Default for Painting {
    fn default() -> Self {
        Self {
            mode: Mode::default(),
            brush: Brush { radius: 0.5, strength: 0.5, target: 4.0 },
            stroke: None,
            patching: Patching::default(),
            on: None,
            hit: None,
            is_sized: false,
        }
    }
}

/// What has patches.
fn is_painted(entity: &Entity) -> bool {
    entity.is_static && entity.mesh.is_some()
}

impl Painting {
    pub fn is_pulled(&self) -> bool {
        self.stroke.is_some()
    }

    pub(super) fn handle(&mut self, hand: &Hand<'_>, caster: &mut Caster, asks: &mut Asks) {
        self.keys(hand);
        self.patching.follow(hand.seen.document, hand.seen.assets);
        let document = hand.seen.document;
        let open = |entity: &Entity| entity.mesh.is_some() && !document.is_locked(entity.id);
        let at = hand.at.filter(|_| hand.over || self.stroke.is_some());
        self.hit = at.and_then(|at| caster.cast(&hand.seen.scenery, &hand.lens.ray(at), open));
        self.fit(hand);
        if let Some(hit) = self.hit.filter(|hit| document.entity(hit.entity).is_some_and(is_painted)) {
            self.on = Some(hit.entity);
        }
        if hand.pressed && self.stroke.is_none() {
            asks.push(Intent::Begin(self.verb(hand).to_owned()));
            self.stroke = Some(Painted::default());
        }
        if self.stroke.is_some() && hand.ui.input(|input| input.key_pressed(Key::Escape)) {
            asks.push(Intent::Cancel);
            self.stroke = None;
        }
        if self.stroke.is_some() && hand.down {
            self.go_on(hand, asks);
        } else if self.stroke.take().is_some() {
            asks.push(Intent::End);
        }
        if self.patching.is_busy() {
            hand.ui.ctx().request_repaint_after(std::time::Duration::from_millis(30));
        }
    }

    /// Taken up for the first time it is as wide as a thumb on the screen.
    fn fit(&mut self, hand: &Hand<'_>) {
        const POINTS: f64 = 48.0;
        let Some(hit) = self.hit.filter(|_| !self.is_sized) else { return };
        let radius = hand.lens.metres_per_point(hit.at) * POINTS;
        let step = 10f64.powf(radius.log10().floor() - 1.0);
        self.brush.radius = ((radius / step).round() * step).clamp(*RADII.start(), *RADII.end());
        self.is_sized = true;
    }

    /// It is laid down.
    pub(super) fn put_down(&mut self) {
        (self.hit, self.on) = (None, None);
    }

    /// The brush grows and shrinks, and with Shift its strength.
    fn keys(&mut self, hand: &Hand<'_>) {
        let factor = match (hand.key(Key::OpenBracket), hand.key(Key::CloseBracket)) {
            (true, _) => 0.8,
            (_, true) => 1.25,
            _ => return,
        };
        if hand.modifiers.shift {
            self.brush.strength = (self.brush.strength * factor).clamp(0.01, 1.0);
        } else if !hand.modifiers.any() {
            self.brush.radius = (self.brush.radius * factor).clamp(*RADII.start(), *RADII.end());
            self.is_sized = true;
        }
    }

    /// What it does now: keys that are held count.
    fn mode(&self, hand: &Hand<'_>) -> Mode {
        match hand.modifiers {
            held if held.command => Mode::Erase,
            held if held.shift => Mode::Smooth,
            _ => self.mode,
        }
    }

    fn verb(&self, hand: &Hand<'_>) -> &'static str {
        match self.mode(hand) {
            Mode::Paint => "Paint density",
            Mode::Erase => "Erase density",
            Mode::Smooth => "Smooth density",
        }
    }

    /// Dabs from where the stroke was to where it is.
    fn go_on(&mut self, hand: &Hand<'_>, asks: &mut Asks) -> Option<()> {
        let hit = self.hit?;
        let mode = self.mode(hand);
        let (brush, seen) = (self.brush, hand.seen);
        let stroke = self.stroke.as_mut()?;
        let entity = seen.document.entity(hit.entity).filter(|entity| is_painted(entity))?;
        let renderer = entity.mesh.as_ref()?;
        let mesh = seen.scenery.assets.meshes.get(&renderer.mesh)?;
        let world = seen.document.world_from_local(hit.entity);
        let dabs = dabs(stroke.last, hit.at, brush.radius * APART)?;
        let before = stroke.densities.get(&hit.entity).unwrap_or(&renderer.density);
        let mut density = before.clone();
        let brush = if mode == Mode::Erase { Brush { target: 1.0, ..brush } } else { brush };
        for at in &dabs {
            let new = match mode {
                Mode::Smooth => brush.smooth(&density, mesh, &world, *at),
                _ => brush.dab(&density, mesh, &world, *at).or_else(|| {
                    let is_here = *at == hit.at;
                    is_here.then(|| brush.dab_between(&density, mesh, hit.corners, hit.shares))?
                }),
            };
            density = new.unwrap_or(density);
        }
        stroke.last = Some(hit.at);
        stroke.densities.insert(hit.entity, density);
        let fields = stroke.densities.iter();
        let fields = fields.map(|(id, density)| (*id, Field::Density(Box::new(density.clone()))));
        asks.push(Intent::Preview(Edit::Set(fields.collect())));
        None
    }

    /// Outlines of the patches of what the brush is on.
    pub(super) fn lines(&self, origin: DVec3) -> Vec<Line> {
        let patches = self.patching.patches();
        let outlines = self.on.and_then(|on| patches?.of.get(&on));
        let line =
            |side: &[DVec3; 2]| Line { ends: side.map(|end| (end - origin).as_vec3()), color: OUTLINE };
        outlines.map_or(Vec::new(), |outlines| outlines.sides.iter().map(line).collect())
    }

    /// The brush on the surface: its rim, and where it is half as strong.
    pub(super) fn paint(&self, hand: &Hand<'_>) {
        let Some(hit) = self.hit.filter(|_| hand.over || self.stroke.is_some()) else { return };
        let paints = hand.seen.document.entity(hit.entity).is_some_and(is_painted);
        self.paint_vertices(hand, &hit);
        /// w = (1 - x^2)^2 is a half there.
        const HALF: f64 = 0.541;
        let color = match (paints, self.mode(hand)) {
            (false, _) => Color32::from_gray(130),
            (_, Mode::Paint) => Color32::WHITE,
            (_, Mode::Erase) => theme::AXES[0],
            (_, Mode::Smooth) => theme::AXES[2],
        };
        let lift = hit.normal * hand.lens.metres_per_point(hit.at);
        for (share, width, alpha) in [(1.0, 1.75, 1.0), (HALF, 1.0, 0.6)] {
            circle(
                hand,
                hit.at + lift,
                hit.normal,
                self.brush.radius * share,
                width,
                color.gamma_multiply(alpha),
            );
        }
        let normal = hit.normal * hand.lens.metres_per_point(hit.at) * 22.0;
        if let Some(ends) = hand.lens.segment(hit.at, hit.at + normal) {
            hand.painter().line_segment(ends, Stroke::new(1.5, color));
        }
        if !paints {
            super::handles::tell_beside_mouse(hand, "It moves: it has no patches");
        }
    }

    /// Vertices about the brush, as dense as they are painted: that is where paint is kept.
    fn paint_vertices(&self, hand: &Hand<'_>, hit: &Hit) -> Option<()> {
        const MOST: usize = 20_000;
        let entity = hand.seen.document.entity(hit.entity).filter(|entity| is_painted(entity))?;
        let renderer = entity.mesh.as_ref()?;
        let mesh = hand.seen.scenery.assets.meshes.get(&renderer.mesh)?;
        let world = hand.seen.document.world_from_local(hit.entity);
        let painter = hand.painter();
        let reach = (self.brush.radius * 2.0).max(hand.lens.metres_per_point(hit.at) * 120.0);
        for (vertex, position) in mesh.positions.iter().enumerate().take(MOST) {
            let place = world.transform_point3(position.as_dvec3());
            let Some((seen, _)) = hand.lens.project(place).filter(|_| place.distance(hit.at) < reach) else {
                continue;
            };
            let painted = renderer.density.painted.get(mesh.original(vertex)).copied().unwrap_or(1.0);
            painter.circle(
                seen,
                3.0,
                density_color(painted),
                Stroke::new(1.0, Color32::from_black_alpha(160)),
            );
        }
        None
    }

    /// What it can do, and what a bake would come to.
    pub(super) fn bar(&mut self, ui: &mut Ui, corner: Pos2, width: f32) -> Rect {
        bar(ui, corner, width, |ui| {
            for (mode, name, tooltip) in MODES {
                let label = ui.selectable_label(self.mode == mode, name).on_hover_text(tooltip);
                if label.clicked() {
                    self.mode = mode;
                }
            }
            ui.separator();
            let brush = &mut self.brush;
            let mut target = f64::from(brush.target);
            let tooltip = "Patches along an edge, against the scene's: 2 halves their size, 0.5 doubles it";
            let range = f64::from(*RANGE.start())..=f64::from(*RANGE.end());
            ui.add_enabled_ui(self.mode == Mode::Paint, |ui| {
                number(ui, ("Brush density", "Density", tooltip), &mut target, range, "");
            });
            brush.target = target as f32;
            number(
                ui,
                ("Brush radius", "Radius", "On the surface, metres ([ and ])"),
                &mut brush.radius,
                RADII,
                " m",
            );
            let tooltip = "Of one dab at the middle: 1 goes all the way (Shift and [ or ])";
            number(ui, ("Brush strength", "Strength", tooltip), &mut brush.strength, 0.01..=1.0, "");
            ui.separator();
            told(ui, &self.told()).on_hover_text("What a bake of the scene as it is now would make");
        })
    }

    fn told(&self) -> String {
        if let Some((_, why)) = &self.patching.refused {
            return why.clone();
        }
        let Some(patches) = self.patching.patches() else { return "Dividing\u{2026}".to_owned() };
        let here = self.on.and_then(|on| patches.of.get(&on));
        let here = here.map_or(String::new(), |own| format!("{} patches here, ", own.count));
        format!("{here}{} in all", patches.count)
    }
}

impl SceneView {
    /// Patches of the scene as it is now, as the brush shows them.
    pub fn patching(&self) -> &Patching {
        &self.painting.patching
    }
}

/// Places of dabs on the way; `None`: it is not long enough for another yet.
fn dabs(from: Option<DVec3>, to: DVec3, apart: f64) -> Option<Vec<DVec3>> {
    let Some(from) = from else { return Some(vec![to]) };
    let count = (from.distance(to) / apart.max(1e-6)) as usize;
    let count = count.min(MOST_DABS);
    let place = |k: usize| if k == count { to } else { from.lerp(to, k as f64 / count as f64) };
    (count > 0).then(|| (1..=count).map(place).collect())
}

fn circle(hand: &Hand<'_>, middle: DVec3, normal: DVec3, radius: f64, width: f32, color: Color32) {
    const PIECES: usize = 64;
    let (u, v) = normal.any_orthonormal_pair();
    let point = |index: usize| {
        let (sin, cos) = (std::f64::consts::TAU * index as f64 / PIECES as f64).sin_cos();
        middle + (u * cos + v * sin) * radius
    };
    let painter = hand.painter();
    for (width, color) in [(width + 2.0, Color32::from_black_alpha(110)), (width, color)] {
        for index in 0..PIECES {
            if let Some(ends) = hand.lens.segment(point(index), point(index + 1)) {
                painter.line_segment(ends, Stroke::new(width, color));
            }
        }
    }
}

/// Blue where patches are coarser than the scene's, white where they are as fine, orange where they are finer.
fn density_color(density: f32) -> Color32 {
    let stops = (density.max(1e-3).log2() / 4.0).clamp(-1.0, 1.0);
    let end =
        if stops < 0.0 { Color32::from_rgb(0x35, 0x7d, 0xff) } else { Color32::from_rgb(0xff, 0x6a, 0x13) };
    Color32::WHITE.lerp_to_gamma(end, stops.abs().sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stroke_dabs_at_even_distances_and_ends_where_the_mouse_is() {
        assert_eq!(dabs(None, DVec3::X, 0.1), Some(vec![DVec3::X]));
        assert_eq!(dabs(Some(DVec3::ZERO), DVec3::X * 0.05, 0.1), None);
        let way = dabs(Some(DVec3::ZERO), DVec3::X, 0.25).unwrap();
        assert_eq!((way.len(), way[3]), (4, DVec3::X));
        assert_eq!(dabs(Some(DVec3::ZERO), DVec3::X * 1e6, 0.25).unwrap().len(), MOST_DABS);
    }
}
