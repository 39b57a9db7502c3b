//! Light probes in the hand: choose them by clicks and rectangles, drag them, copy and delete them, set new ones onto
//! surfaces, fill a box with them.

use eframe::egui;
use egui::{Color32, Key, Pos2, Rect, Stroke, Ui, vec2};
use engine::scene::{EntityId, LightProbeGroup};
use glam::{DAffine3, DQuat, DVec3};

use super::bars::{bar, number, told};
use super::choose::paint_box;
use super::hand::Hand;
use super::handles::tell_beside_mouse;
use super::{Handling, Seen};
use crate::ask::Asks;
use crate::command::Command;
use crate::document::Document;
use crate::gizmo::typed::Typed;
use crate::gizmo::{self, Change, Grasp, Handle, Stand, Tool};
use crate::intents::Intent;
use crate::theme;
use crate::tools::hit::Caster;
use crate::tools::probes::{self, Chosen};

/// Points from the middle of a probe that still hit it.
const HIT: f32 = 9.0;
/// Points that the mouse may go and it was a click all the same.
const STILL: f32 = 3.0;

pub struct Probing {
    /// Of which group the chosen are.
    of: Option<EntityId>,
    pub chosen: Chosen,
    /// A click on a surface sets a probe, as Ctrl does while it is held.
    pub sets: bool,
    /// How far before the surface, metres.
    pub offset: f64,
    /// Of a grid that fills a box, metres.
    pub spacing: f64,
    /// They are somebody's choice.
    is_fitted: bool,
    pull: Option<Pull>,
    boxed: Option<Pos2>,
}

struct Pull {
    grasp: Grasp,
    typed: Typed,
    /// As it was.
    group: LightProbeGroup,
    began: bool,
    from: Pos2,
    told: String,
}

/// A group and where it stands.
struct Group<'a> {
    id: EntityId,
    group: &'a LightProbeGroup,
    world: DAffine3,
}

impl Default for Probing {
    fn default() -> Self {
        Self {
            of: None,
            chosen: Chosen::new(),
            sets: false,
            offset: 0.5,
            spacing: 1.0,
            is_fitted: false,
            pull: None,
            boxed: None,
        }
    }
}

/// The active entity's, else the one that was edited last, else the scene's first.
pub fn group_of(document: &Document, active: Option<EntityId>, last: Option<EntityId>) -> Option<EntityId> {
    let has = |id: &EntityId| document.entity(*id).is_some_and(|entity| entity.light_probes.is_some());
    let first = || document.scene().entities.iter().find(|entity| entity.light_probes.is_some());
    active.filter(has).or(last.filter(has)).or(first().map(|entity| entity.id))
}

fn group<'a>(document: &'a Document, id: Option<EntityId>) -> Option<Group<'a>> {
    let entity = document.entity(id?)?;
    let group = entity.light_probes.as_ref()?;
    Some(Group { id: entity.id, group, world: document.world_from_local(entity.id) })
}

impl Group<'_> {
    fn place(&self, probe: usize) -> DVec3 {
        self.world.transform_point3(self.group.positions[probe].as_dvec3())
    }

    /// The nearest probe under the mouse.
    fn under(&self, hand: &Hand<'_>, at: Pos2) -> Option<usize> {
        let near = (0..self.group.positions.len()).filter_map(|probe| {
            let (seen, depth) = hand.lens.project(self.place(probe))?;
            (seen.distance(at) <= HIT).then_some((probe, depth))
        });
        near.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(probe, _)| probe)
    }

    fn inside(&self, hand: &Hand<'_>, area: Rect) -> Chosen {
        let is_inside = |probe: &usize| {
            hand.lens.project(self.place(*probe)).is_some_and(|(seen, _)| area.contains(seen))
        };
        (0..self.group.positions.len()).filter(is_inside).collect()
    }
}

impl Probing {
    pub fn is_pulled(&self) -> bool {
        self.pull.is_some() || self.boxed.is_some()
    }

    fn follow(&mut self, seen: &Seen<'_>) {
        let of = group_of(seen.document, seen.selection.active(), self.of);
        if of != self.of {
            self.of = of;
            self.chosen.clear();
            self.fit(seen);
        }
        let count = group(seen.document, of).map_or(0, |group| group.group.positions.len());
        self.chosen.retain(|probe| *probe < count);
    }

    /// Distances that make sense among the probes that there are, unless somebody has chosen others.
    fn fit(&mut self, seen: &Seen<'_>) {
        let reach = group(seen.document, self.of)
            .filter(|_| !self.is_fitted)
            .and_then(|group| Some((probes::extent(group.group, &Chosen::new())?, group.world)));
        let Some(([low, high], world)) = reach else { return };
        let side = |axis: usize| f64::from(high[axis] - low[axis]) * world.matrix3.col(axis).length();
        let longest = side(0).max(side(1)).max(side(2));
        if longest > 0.0 {
            let step = 10f64.powf((longest / 4.0).log10().floor() - 1.0);
            self.spacing = (longest / 4.0 / step).round() * step;
            self.offset = self.spacing * 0.5;
        }
    }

    pub(super) fn handle(
        &mut self,
        hand: &Hand<'_>,
        handling: &Handling,
        caster: &mut Caster,
        asks: &mut Asks,
    ) {
        self.follow(hand.seen);
        let Some(group) = group(hand.seen.document, self.of) else { return };
        if hand.pressed && !self.is_pulled() {
            self.press(hand, &group, caster, asks);
        }
        if hand.key(Key::Escape) {
            self.escape(asks);
        }
        if self.pull.is_some() {
            self.go_on(hand, handling, &group, asks);
        }
        self.go_on_boxing(hand, &group);
    }

    fn escape(&mut self, asks: &mut Asks) {
        match self.pull.take() {
            Some(pull) if pull.began => asks.push(Intent::Cancel),
            Some(_) => {}
            None if self.boxed.is_none() => self.chosen.clear(),
            None => {}
        }
        self.boxed = None;
    }

    fn press(&mut self, hand: &Hand<'_>, group: &Group<'_>, caster: &mut Caster, asks: &mut Asks) {
        let Some(at) = hand.at else { return };
        let arrow = self.stand(group).and_then(|stand| {
            let handle = gizmo::under(hand.lens, &stand, Tool::Move, at)?;
            Some((handle, stand)).filter(|_| !hand.modifiers.any())
        });
        if let Some((handle, stand)) = arrow {
            return self.pull(hand, handle, stand, group, at);
        }
        if let Some(probe) = group.under(hand, at) {
            match hand.modifiers {
                held if held.command && self.chosen.contains(&probe) => drop(self.chosen.remove(&probe)),
                held if held.command || held.shift => drop(self.chosen.insert(probe)),
                _ if !self.chosen.contains(&probe) => self.chosen = Chosen::from([probe]),
                _ => {}
            }
            let stand = Stand { origin: group.place(probe), axes: DQuat::IDENTITY };
            return self.pull(hand, Handle::MoveScreen, stand, group, at);
        }
        if self.sets || hand.modifiers.command {
            return self.set(hand, group, caster, asks);
        }
        self.boxed = Some(at);
    }

    fn pull(&mut self, hand: &Hand<'_>, handle: Handle, stand: Stand, group: &Group<'_>, from: Pos2) {
        let grasp = Grasp::new(handle, stand, hand.lens, from);
        let (typed, group, told) = (Typed::default(), group.group.clone(), String::new());
        self.pull = Some(Pull { grasp, typed, group, began: false, from, told });
    }

    /// A new probe before the surface under the mouse.
    fn set(&mut self, hand: &Hand<'_>, group: &Group<'_>, caster: &mut Caster, asks: &mut Asks) {
        let ray = hand.at.map(|at| hand.lens.ray(at));
        let hit = ray.and_then(|ray| caster.cast(&hand.seen.scenery, &ray, |entity| entity.mesh.is_some()));
        let place = hit.map(|hit| hit.at + hit.normal * self.offset);
        let added = place.and_then(|place| probes::added(group.group, &group.world, place));
        if let Some((new, chosen)) = added {
            asks.push(Intent::Commit(probes::edit(group.id, "Add light probe", new)));
            self.chosen = chosen;
            // The next picture has it.
            hand.ui.ctx().request_repaint();
        }
    }

    fn go_on(&mut self, hand: &Hand<'_>, handling: &Handling, group: &Group<'_>, asks: &mut Asks) {
        let Some(pull) = &mut self.pull else { return };
        let entered = hand.ui.input(|input| pull.typed.take(input));
        let went = hand.at.is_some_and(|at| at.distance(pull.from) > STILL);
        let steps = (handling.snap != hand.modifiers.command).then_some(&handling.steps);
        let change = match pull.typed.is_empty() {
            false => pull.typed.change(pull.grasp.handle, &pull.grasp.stand, hand.lens.forward()),
            true => {
                hand.at.filter(|_| went || pull.began).and_then(|at| pull.grasp.change(hand.lens, at, steps))
            }
        };
        if let Some(Change::Move(way)) = change.filter(|_| hand.down || entered) {
            let name = match self.chosen.len() {
                1 => "Move light probe".to_owned(),
                many => format!("Move {many} light probes"),
            };
            if !pull.began {
                asks.push(Intent::Begin(name.clone()));
                pull.began = true;
            }
            let new = probes::moved(&pull.group, &group.world, &self.chosen, way);
            asks.push(Intent::Preview(probes::edit(group.id, &name, new)));
            let typed =
                if pull.typed.is_empty() { String::new() } else { format!("{}|   ", pull.typed.text) };
            pull.told = format!("{typed}{:.3}  {:.3}  {:.3} m", way.x, way.y, way.z);
        }
        if entered || !hand.down {
            if pull.began {
                asks.push(Intent::End);
            }
            self.pull = None;
        }
    }

    fn go_on_boxing(&mut self, hand: &Hand<'_>, group: &Group<'_>) {
        let (Some(from), Some(to)) = (self.boxed, hand.at) else { return };
        let area = Rect::from_two_pos(from, to);
        if hand.down {
            return paint_box(hand, area.intersect(hand.lens.rect));
        }
        self.boxed = None;
        let found = if from.distance(to) > STILL { group.inside(hand, area) } else { Chosen::new() };
        if !hand.modifiers.shift {
            self.chosen.clear();
        }
        self.chosen.extend(found);
    }

    /// In the middle of what is chosen.
    fn stand(&self, group: &Group<'_>) -> Option<Stand> {
        let chosen = self.chosen.iter().filter(|probe| **probe < group.group.positions.len());
        let places: Vec<DVec3> = chosen.map(|probe| group.place(*probe)).collect();
        let origin = places.iter().sum::<DVec3>() / places.len() as f64;
        (!places.is_empty()).then_some(Stand { origin, axes: DQuat::IDENTITY })
    }

    /// What a command means while probes are edited; `None`: what it always means.
    pub fn intent(
        &mut self,
        command: Command,
        document: &Document,
        active: Option<EntityId>,
    ) -> Option<Intent> {
        let Group { id, group, .. } = group(document, self.of.filter(|of| active == Some(*of)))?;
        let some = !self.chosen.is_empty();
        match command {
            // Not the whole group.
            Command::Delete | Command::Duplicate if !some => Some(Intent::Select(vec![id])),
            Command::Delete => {
                let left = probes::removed(group, &self.chosen);
                let name = format!("Delete {} light probes", self.chosen.len());
                self.chosen.clear();
                Some(Intent::Commit(probes::edit(id, &name, left)))
            }
            Command::Duplicate => {
                let name = format!("Duplicate {} light probes", self.chosen.len());
                let (new, chosen) = probes::duplicated(group, &self.chosen);
                self.chosen = chosen;
                Some(Intent::Commit(probes::edit(id, &name, new)))
            }
            Command::SelectAll => {
                self.chosen = (0..group.positions.len()).collect();
                Some(Intent::Select(vec![id]))
            }
            Command::SelectNone => {
                self.chosen.clear();
                Some(Intent::Select(vec![id]))
            }
            Command::InvertSelection => {
                let others = (0..group.positions.len()).filter(|probe| !self.chosen.contains(probe));
                self.chosen = others.collect();
                Some(Intent::Select(vec![id]))
            }
            _ => None,
        }
    }

    pub(super) fn paint(&self, hand: &Hand<'_>) {
        let Some(group) = group(hand.seen.document, self.of) else { return };
        let painter = hand.painter();
        let hot = hand.at.filter(|_| hand.over && self.pull.is_none()).and_then(|at| group.under(hand, at));
        let mut balls: Vec<(f64, Pos2, usize)> = (0..group.group.positions.len())
            .filter_map(|probe| {
                hand.lens.project(group.place(probe)).map(|(seen, depth)| (depth, seen, probe))
            })
            .filter(|(_, seen, _)| hand.lens.rect.expand(10.0).contains(*seen))
            .collect();
        // Far ones first.
        balls.sort_by(|a, b| b.0.total_cmp(&a.0));
        for (_, seen, probe) in balls {
            let color = match (hot == Some(probe), self.chosen.contains(&probe)) {
                (true, _) => theme::GRASPED,
                (_, true) => theme::SELECTED,
                _ => Color32::from_gray(215),
            };
            ball(&painter, seen, if hot == Some(probe) { 7.0 } else { 6.0 }, color);
        }
        if let Some(stand) = self.stand(&group) {
            let grasped = self.pull.as_ref().map(|pull| pull.grasp.handle);
            let at = hand.at.filter(|_| hand.over);
            let hot = grasped.or_else(|| gizmo::under(hand.lens, &stand, Tool::Move, at?));
            gizmo::paint(&painter, hand.lens, &stand, Tool::Move, hot);
        }
        if let Some(pull) = &self.pull {
            tell_beside_mouse(hand, &pull.told);
        }
    }

    /// What it can do.
    pub(super) fn bar(
        &mut self,
        ui: &mut Ui,
        (corner, width): (Pos2, f32),
        seen: &Seen<'_>,
        asks: &mut Asks,
    ) -> Rect {
        bar(ui, corner, width, |ui| match group(seen.document, self.of) {
            Some(group) => self.offers(ui, &group, asks),
            None => {
                ui.label("This scene has no light probes.");
                if ui.button("Create light probe group").clicked() {
                    asks.push(Command::CreateLightProbeGroup);
                }
            }
        })
    }

    fn offers(&mut self, ui: &mut Ui, group: &Group<'_>, asks: &mut Asks) {
        let tooltip = "A click on a surface sets a probe before it. Ctrl does this while it is held";
        let response = ui.selectable_label(self.sets, "Add").on_hover_text(tooltip);
        if response.clicked() {
            self.sets ^= true;
        }
        let tooltip = "How far before the surface, metres";
        let offset = ("Offset from the surface", "Offset", tooltip);
        self.is_fitted |= number(ui, offset, &mut self.offset, 0.0..=100.0, " m").changed();
        ui.separator();
        let tooltip = "Between probes of a grid, at most; metres";
        let spacing = ("Spacing of the grid", "Spacing", tooltip);
        self.is_fitted |= number(ui, spacing, &mut self.spacing, 0.01..=1000.0, " m").changed();
        self.offer_filling(ui, group, asks);
        ui.separator();
        let all = group.group.positions.len();
        told(ui, &format!("{} of {all} probes chosen", self.chosen.len()));
    }

    fn offer_filling(&mut self, ui: &mut Ui, group: &Group<'_>, asks: &mut Asks) {
        let reach = probes::extent(group.group, &self.chosen);
        let Some(reach) = reach else { return };
        let counts = probes::counts(reach, &group.world, self.spacing);
        let [x, y, z] = counts;
        let many = x.saturating_mul(y).saturating_mul(z);
        let button = egui::Button::new(format!("Fill box {x} \u{d7} {y} \u{d7} {z}"));
        let tooltip = if many <= probes::MOST {
            "A grid instead of the probes in the box about those that are chosen, or about all"
        } else {
            "Too many: let them stand farther apart"
        };
        let response = ui.add_enabled(many <= probes::MOST, button).on_hover_text(tooltip);
        response.ctx.accesskit_node_builder(response.id, |node| node.set_label("Fill the box with a grid"));
        if response.clicked() {
            let (new, chosen) = probes::filled(group.group, reach, counts);
            asks.push(Intent::Commit(probes::edit(group.id, "Fill box with light probes", new)));
            self.chosen = chosen;
        }
    }
}

/// A small sphere, lit from above.
fn ball(painter: &egui::Painter, at: Pos2, radius: f32, color: Color32) {
    painter.circle_filled(at, radius + 1.25, Color32::from_black_alpha(190));
    painter.circle_filled(at, radius, color.lerp_to_gamma(Color32::BLACK, 0.35));
    painter.circle_filled(at + vec2(-0.14, -0.16) * radius, radius * 0.76, color);
    painter.circle_stroke(at, radius, Stroke::new(0.5, color));
    let shine = color.lerp_to_gamma(Color32::WHITE, 0.75);
    painter.circle_filled(at + vec2(-0.3, -0.34) * radius, radius * 0.28, shine);
}
