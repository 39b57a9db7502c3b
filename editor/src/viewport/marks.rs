//! What stands in a scene without being seen in it: icons for lights, cameras and probes, and, where they are selected, how
//! far they reach.

use std::f64::consts::TAU;

use eframe::egui;
use egui::{Color32, Painter, Pos2, Rect, Stroke, Vec2};
use engine::scene::{Camera, Entity, EntityId, Light, LightKind, Projection, ReflectionProbe};
use glam::{DAffine3, DVec3, Vec3};

use crate::icons::{self, Icon};
use crate::lens::Lens;
use crate::theme;

/// Points from the middle of an icon that still hit it.
const HIT: f32 = 13.0;

/// An icon in the picture.
#[derive(Clone, Copy, Debug)]
pub struct Mark {
    pub entity: EntityId,
    pub icon: Icon,
    pub at: Pos2,
    pub depth: f64,
    color: Color32,
}

/// The picture by which lists and views show an entity.
pub fn icon_of(entity: &Entity) -> Icon {
    match (&entity.light, &entity.camera, &entity.light_probes, &entity.reflection_probe, &entity.mesh) {
        (Some(light), ..) => match light.kind {
            LightKind::Sun => Icon::Sun,
            LightKind::Point => Icon::Lamp,
            LightKind::Spot { .. } => Icon::Spot,
        },
        (_, Some(_), ..) => Icon::Camera,
        (_, _, Some(_), ..) => Icon::LightProbes,
        (_, _, _, Some(_), _) => Icon::ReflectionProbe,
        (.., Some(_)) => Icon::Mesh,
        _ => Icon::Empty,
    }
}

/// Icons of all that has no surface, far ones first.
pub fn marks<'a>(lens: &Lens, placed: impl Iterator<Item = (&'a Entity, &'a DAffine3)>) -> Vec<Mark> {
    let mut marks: Vec<Mark> = placed.filter_map(|(entity, world)| mark(lens, entity, world)).collect();
    marks.sort_by(|a, b| b.depth.total_cmp(&a.depth));
    marks
}

fn mark(lens: &Lens, entity: &Entity, world: &DAffine3) -> Option<Mark> {
    let has_icon = entity.light.is_some()
        || entity.camera.is_some()
        || entity.light_probes.is_some()
        || entity.reflection_probe.is_some();
    let (at, depth) = lens.project(world.translation).filter(|_| has_icon)?;
    let color = entity.light.as_ref().map_or(Color32::from_gray(225), shine);
    lens.rect.contains(at).then_some(Mark { entity: entity.id, icon: icon_of(entity), at, depth, color })
}

/// The colour of a light, as bright as it can be shown; grey where it is off.
fn shine(light: &Light) -> Color32 {
    if !light.on {
        return Color32::from_gray(120);
    }
    let most = light.color.max_element().max(1e-6);
    let [r, g, b] = (light.color / most).to_array().map(|part| (part.max(0.0).powf(1.0 / 2.2) * 255.0) as u8);
    Color32::from_rgb(r, g, b).lerp_to_gamma(Color32::WHITE, 0.25)
}

/// Icons under the mouse, the nearest first.
pub fn under(marks: &[Mark], at: Pos2) -> Vec<EntityId> {
    let mut near: Vec<&Mark> = marks.iter().filter(|mark| mark.at.distance(at) <= HIT).collect();
    near.sort_by(|a, b| a.depth.total_cmp(&b.depth));
    near.into_iter().map(|mark| mark.entity).collect()
}

pub fn paint(painter: &Painter, marks: &[Mark], is_selected: impl Fn(EntityId) -> bool) {
    for mark in marks {
        let rect = Rect::from_center_size(mark.at, Vec2::splat(16.0));
        let selected = is_selected(mark.entity);
        let back =
            if selected { theme::SELECTED.gamma_multiply(0.85) } else { Color32::from_black_alpha(120) };
        painter.circle_filled(mark.at, 12.0, back);
        let color = if selected { Color32::from_gray(15) } else { mark.color };
        icons::paint(painter, rect, mark.icon, color);
    }
}

/// How far a selected light, camera or probe reaches.
pub fn paint_reach(painter: &Painter, lens: &Lens, entity: &Entity, world: &DAffine3, aspect: f32) {
    let wire = Wire { painter, lens, stroke: Stroke::new(1.25, theme::SELECTED.gamma_multiply(0.9)) };
    if let Some(light) = &entity.light {
        light_reach(&wire, light, world);
    }
    if let Some(camera) = &entity.camera {
        frustum(&wire, camera, world, aspect);
    }
    if let Some(group) = &entity.light_probes {
        for position in &group.positions {
            if let Some((at, _)) = lens.project(world.transform_point3(position.as_dvec3())) {
                painter.circle(at, 4.0, Color32::from_gray(235), wire.stroke);
            }
        }
    }
    if let Some(probe) = &entity.reflection_probe {
        probe_box(&wire, probe, world);
    }
}

struct Wire<'a> {
    painter: &'a Painter,
    lens: &'a Lens,
    stroke: Stroke,
}

impl Wire<'_> {
    fn line(&self, from: DVec3, to: DVec3) {
        if let Some(ends) = self.lens.segment(from, to) {
            self.painter.line_segment(ends, self.stroke);
        }
    }

    fn circle(&self, middle: DVec3, u: DVec3, v: DVec3) {
        const PIECES: usize = 48;
        let point = |index: usize| {
            let (sin, cos) = (TAU * index as f64 / PIECES as f64).sin_cos();
            middle + u * cos + v * sin
        };
        (0..PIECES).for_each(|index| self.line(point(index), point(index + 1)));
    }
}

/// Right, up and the way it shines, unit.
fn axes(world: &DAffine3) -> [DVec3; 3] {
    let m = world.matrix3;
    let forward = (-m.z_axis).normalize_or(DVec3::NEG_Z);
    let right = m.x_axis.normalize_or(forward.any_orthonormal_vector());
    [right, right.cross(forward), forward]
}

fn light_reach(wire: &Wire<'_>, light: &Light, world: &DAffine3) {
    let [right, up, forward] = axes(world);
    let from = world.translation;
    let unit = wire.lens.metres_per_point(from);
    match light.kind {
        LightKind::Sun => {
            let (radius, length) = (unit * 16.0, unit * 70.0);
            wire.circle(from, right * radius, up * radius);
            for number in 0..8 {
                let (sin, cos) = (TAU * f64::from(number) / 8.0).sin_cos();
                let foot = from + (right * cos + up * sin) * radius;
                wire.line(foot, foot + forward * length);
            }
        }
        LightKind::Point => {
            let Some(range) = light.range.map(f64::from) else { return };
            for [u, v] in [[DVec3::X, DVec3::Y], [DVec3::Y, DVec3::Z], [DVec3::Z, DVec3::X]] {
                wire.circle(from, u * range, v * range);
            }
        }
        LightKind::Spot { inner, outer } => {
            let range = light.range.map_or(unit * 140.0, f64::from);
            for angle in [inner, outer].map(f64::from) {
                let (sin, cos) = angle.sin_cos();
                let (middle, radius) = (from + forward * range * cos, range * sin);
                wire.circle(middle, right * radius, up * radius);
            }
            let (sin, cos) = f64::from(outer).sin_cos();
            for way in [right, up, -right, -up] {
                wire.line(from, from + (forward * cos + way * sin) * range);
            }
        }
    }
}

fn frustum(wire: &Wire<'_>, camera: &Camera, world: &DAffine3, aspect: f32) {
    let [right, up, forward] = axes(world);
    let from = world.translation;
    // A far plane that is far away, or none, is drawn where it still says something.
    let shown = wire.lens.metres_per_point(from) * 160.0;
    let near = f64::from(camera.near);
    let far = camera.far.map_or(f64::INFINITY, f64::from).min(shown.max(near * 2.0));
    let half = |depth: f64| match camera.projection {
        Projection::Perspective { fov_y } => depth * f64::from(fov_y * 0.5).tan(),
        Projection::Orthographic { half_height } => f64::from(half_height),
    };
    let corners = |depth: f64| {
        let height = half(depth);
        let width = height * f64::from(aspect);
        [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(x, y)| from + forward * depth + right * (x * width) + up * (y * height))
    };
    let (near, far) = (corners(near), corners(far));
    for i in 0..4 {
        wire.line(near[i], near[(i + 1) % 4]);
        wire.line(far[i], far[(i + 1) % 4]);
        wire.line(near[i], far[i]);
    }
}

fn probe_box(wire: &Wire<'_>, probe: &ReflectionProbe, world: &DAffine3) {
    let corner = |i: usize| {
        let sign = |axis: usize| if i >> axis & 1 == 1 { 1.0 } else { -1.0 };
        let off = probe.half_size * Vec3::new(sign(0), sign(1), sign(2));
        world.transform_point3((probe.offset + off).as_dvec3())
    };
    for from in 0..8 {
        for axis in 0..3 {
            if from >> axis & 1 == 0 {
                wire.line(corner(from), corner(from | 1 << axis));
            }
        }
    }
}
