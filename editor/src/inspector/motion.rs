//! How it moves while the scene plays: about an axis, along a path, or as its file says.

use std::f64::consts::TAU;

use eframe::egui::{Label, Ui};
use engine::scene::{Entity, EntityId, Motion, Transform};
use glam::DVec3;

use super::arithmetic::Unit;
use super::component::{Can, component};
use super::fields::{self, Number};
use super::subject::Subject;
use crate::ask::Asks;
use crate::edit::Field;
use crate::icons::Icon;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Spin,
    Path,
    Clip,
}

fn kind(motion: &Motion) -> Kind {
    match motion {
        Motion::Spin { .. } => Kind::Spin,
        Motion::PingPong { .. } => Kind::Path,
        Motion::Clip { .. } => Kind::Clip,
    }
}

/// Once around in ten seconds.
pub fn spin() -> Motion {
    Motion::Spin { axis: DVec3::Y, radians_per_second: TAU / 10.0 }
}

/// Two metres aside and back.
fn path(from: DVec3) -> Motion {
    Motion::PingPong { points: vec![from, from + DVec3::X * 2.0], seconds: 8.0, look: false }
}

type Motions<'a> = Subject<'a, EntityId, Motion>;

pub fn show<'a>(ui: &mut Ui, entities: &[&'a Entity], asks: &'a mut Asks) {
    let field = |motion| Field::Motion(Some(Box::new(motion)));
    let mut of = Subject::component(entities, |e| e.motion.as_ref(), field, asks);
    let Some(first) = of.first() else { return };
    let stands = entities.iter().find(|entity| entity.motion.is_some()).map(|entity| entity.transform);
    let from = stands.unwrap_or_default();
    of = of.usually(usual(first, &from));
    let can = Can::all(of.can_paste(ui));
    let wish = component(ui, Icon::Rotate, "Motion", can, |ui| {
        choose_kind(ui, &mut of, first, &from);
        match of.shared(kind) {
            Some(Kind::Spin) => spinning(ui, &mut of),
            Some(Kind::Path) => along(ui, &mut of),
            Some(Kind::Clip) => clip(ui, &mut of),
            None => {}
        }
    });
    of.fulfil(ui, wish, Field::Motion(None));
}

fn usual(first: &Motion, from: &Transform) -> Motion {
    match first {
        Motion::Spin { .. } => spin(),
        Motion::PingPong { .. } => path(from.translation),
        Motion::Clip { file, animation, node, .. } => {
            Motion::Clip { file: file.clone(), animation: *animation, node: *node, speed: 1.0 }
        }
    }
}

fn choose_kind(ui: &mut Ui, of: &mut Motions<'_>, first: &Motion, from: &Transform) {
    let mut kinds = vec![(Kind::Spin, "Turns"), (Kind::Path, "Along a path")];
    if kind(first) == Kind::Clip {
        kinds.push((Kind::Clip, "As its file says"));
    }
    let from = from.translation;
    let set = move |motion: &mut Motion, new: Kind| match new {
        Kind::Spin => *motion = spin(),
        Kind::Path => *motion = path(from),
        Kind::Clip => {}
    };
    of.choice(
        ui,
        ("Moves", "What it does while the scene plays, as a function of time alone"),
        &kinds,
        kind,
        set,
    );
}

fn spinning(ui: &mut Ui, of: &mut Motions<'_>) {
    let axis = |motion: &Motion| match motion {
        Motion::Spin { axis, .. } => *axis,
        _ => DVec3::Y,
    };
    let about = "Through its own origin, in its parent's space; its length does not matter";
    of.vector(ui, ("Axis", about), &Number::default(), axis, |motion, at, value| {
        if let Motion::Spin { axis, .. } = motion {
            axis[at] = value;
        }
    });
    let speed = |motion: &Motion| match motion {
        Motion::Spin { radians_per_second, .. } => radians_per_second.to_degrees(),
        _ => 0.0,
    };
    let told = "Degrees a second, against the clock as seen from the axis' end";
    of.number(ui, ("Speed", told), &Number::degrees(), speed, |motion, value| {
        if let Motion::Spin { radians_per_second, .. } = motion {
            *radians_per_second = value.to_radians();
        }
    });
}

fn points(motion: &Motion) -> &[DVec3] {
    if let Motion::PingPong { points, .. } = motion { points } else { &[] }
}

fn along(ui: &mut Ui, of: &mut Motions<'_>) {
    let many = of.shared(|motion| points(motion).len()).unwrap_or(0);
    for at in 0..many {
        let name = format!("Point {}", at + 1);
        let get = |motion: &Motion| points(motion).get(at).copied().unwrap_or_default();
        let told = "Of its path, in its parent's space, metres";
        of.vector(ui, (&name, told), &Number::metres(), get, |motion, axis, value| {
            if let Motion::PingPong { points, .. } = motion {
                points.iter_mut().skip(at).take(1).for_each(|point| point[axis] = value);
            }
        });
    }
    change_points(ui, of, many);
    let seconds = |motion: &Motion| match motion {
        Motion::PingPong { seconds, .. } => *seconds,
        _ => 0.0,
    };
    let number = Number { least: 0.01, ..Number::positive(Unit::Seconds) };
    of.number(ui, ("There and back", "Seconds"), &number, seconds, |motion, value| {
        if let Motion::PingPong { seconds, .. } = motion {
            *seconds = value;
        }
    });
    let looks = |motion: &Motion| matches!(motion, Motion::PingPong { look: true, .. });
    let told = "Its -Z faces along the path, on the way back too: for a camera on rails";
    of.toggle(ui, ("Looks ahead", told), looks, |motion, on| {
        if let Motion::PingPong { look, .. } = motion {
            *look = on;
        }
    });
}

fn change_points(ui: &mut Ui, of: &mut Motions<'_>, many: usize) {
    let (mut adds, mut removes) = (false, false);
    fields::row(ui, "Path", "At least two points; it slows down at both ends", |ui| {
        adds = fields::small_button(ui, Icon::Plus, "Add point").clicked();
        ui.add_enabled_ui(many > 2, |ui| {
            removes = fields::small_button(ui, Icon::Close, "Remove last point").clicked();
        });
        ui.weak(format!("{many} points"));
    });
    if adds {
        of.set_now((), |motion, ()| {
            if let Motion::PingPong { points, .. } = motion {
                points.push(straight_on(points));
            }
        });
    }
    if removes {
        of.set_now((), |motion, ()| {
            if let Motion::PingPong { points, .. } = motion {
                points.pop();
            }
        });
    }
}

/// As far beyond the last point as that is from the one before; a metre aside where they are one.
fn straight_on(points: &[DVec3]) -> DVec3 {
    match points {
        [.., before, last] if before != last => *last + (*last - *before),
        [.., last] => *last + DVec3::X,
        [] => DVec3::ZERO,
    }
}

fn clip(ui: &mut Ui, of: &mut Motions<'_>) {
    let named = of.shared(|motion| match motion {
        Motion::Clip { file, animation, .. } => format!("{file}, animation {animation}"),
        _ => String::new(),
    });
    let told = named.unwrap_or("\u{2014}".to_owned());
    fields::row(ui, "Animation", "The file that it is read from", |ui| {
        ui.add(Label::new(&told).truncate()).on_hover_text(&told);
    });
    let speed = |motion: &Motion| match motion {
        Motion::Clip { speed, .. } => *speed,
        _ => 1.0,
    };
    let number = Number { speed: 0.01, ..Number::default() };
    of.number(
        ui,
        ("Speed", "1: as it was recorded. Less than 0: backwards"),
        &number,
        speed,
        |motion, value| {
            if let Motion::Clip { speed, .. } = motion {
                *speed = value;
            }
        },
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_goes_on_straight_and_starts_anywhere() {
        assert_eq!(straight_on(&[DVec3::ZERO, DVec3::Y]), DVec3::Y * 2.0);
        assert_eq!(straight_on(&[DVec3::ONE, DVec3::ONE]), DVec3::ONE + DVec3::X);
        assert_eq!(straight_on(&[]), DVec3::ZERO);
    }
}
