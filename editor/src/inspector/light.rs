//! A light: kind, colour, strength, reach.

use eframe::egui::Ui;
use engine::scene::{Changes, Entity, Light, LightKind, Switching};

use super::arithmetic::Unit;
use super::colour;
use super::component::{Can, component};
use super::fields::Number;
use super::subject::Subject;
use crate::ask::Asks;
use crate::edit::Field;
use crate::icons::Icon;

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Sun,
    Point,
    Spot,
}

const KINDS: [(Kind, &str); 3] = [(Kind::Sun, "Sun"), (Kind::Point, "Point"), (Kind::Spot, "Spot")];

pub const CHANGES: [(Changes, &str); 3] =
    [(Changes::Anything, "Anything"), (Changes::Intensity, "Intensity"), (Changes::Never, "Nothing")];

fn kind(light: &Light) -> Kind {
    match light.kind {
        LightKind::Sun => Kind::Sun,
        LightKind::Point => Kind::Point,
        LightKind::Spot { .. } => Kind::Spot,
    }
}

pub fn show<'a>(ui: &mut Ui, entities: &[&'a Entity], asks: &'a mut Asks) {
    let field = |light| Field::Light(Some(Box::new(light)));
    let mut of = Subject::component(entities, |e| e.light.as_ref(), field, asks);
    if of.is_empty() {
        return;
    }
    of = of.usually(usual(entities));
    let can = Can::all(of.can_paste(ui));
    let wish = component(ui, Icon::Lamp, "Light", can, |ui| {
        of.choice(
            ui,
            ("Kind", "A sun shines from infinitely far, a point all around, a spot in a cone"),
            &KINDS,
            kind,
            set_kind,
        );
        of.toggle(ui, ("On", "Lit when the scene begins"), |l| l.on, |l, on| l.on = on);
        colour::row(
            ui,
            &mut of,
            ("Color", "Linear RGB; the strength is the intensity's"),
            |l| l.color,
            |l, c| l.color = c,
        );
        colour::kelvin(ui, &mut of, |l| l.color, |l, c| l.color = c);
        strength(ui, &mut of);
        if of.shared(kind) == Some(Kind::Spot) {
            cone(ui, &mut of);
        }
        if of.shared(|l| kind(l) != Kind::Sun) == Some(true) {
            range(ui, &mut of);
        }
        of.toggle(
            ui,
            ("Shadows", "What it shines on casts shadows"),
            |l| l.casts_shadows,
            |l, on| l.casts_shadows = on,
        );
        let changes = "What of it may change while the scene plays: the less, the cheaper";
        of.choice(ui, ("May change", changes), &CHANGES, |l| l.changes, |l, changes| l.changes = changes);
        switching(ui, &mut of);
    });
    of.fulfil(ui, wish, Field::Light(None));
}

/// As one of its kind is created.
fn usual(entities: &[&Entity]) -> Light {
    let mut usual = Light { intensity: 10.0, ..Light::default() };
    let first = entities.iter().find_map(|entity| entity.light.as_ref());
    set_kind(&mut usual, first.map_or(Kind::Point, kind));
    if usual.kind == LightKind::Sun {
        usual.intensity = 3.0;
    }
    usual
}

fn set_kind(light: &mut Light, kind: Kind) {
    light.kind = match kind {
        Kind::Sun => LightKind::Sun,
        Kind::Point => LightKind::Point,
        Kind::Spot => LightKind::Spot { inner: 0.35, outer: 0.5 },
    };
    if kind == Kind::Sun {
        light.range = None;
    }
}

type Lights<'a> = Subject<'a, engine::scene::EntityId, Light>;

/// In the unit of its kind: irradiance of a sun, radiant intensity of lamps.
fn strength(ui: &mut Ui, of: &mut Lights<'_>) {
    let is_sun = of.shared(kind) == Some(Kind::Sun);
    let tooltip = match is_sun {
        true => "Irradiance of what it shines on straight, W/m\u{b2}",
        false => "Radiant intensity, W/sr: at a metre it is the irradiance in W/m\u{b2}",
    };
    let number = Number::positive(if is_sun { Unit::Irradiance } else { Unit::Intensity });
    of.number(
        ui,
        ("Intensity", tooltip),
        &number,
        |l| l.intensity.into(),
        |l, value| l.intensity = value as f32,
    );
}

fn cone(ui: &mut Ui, of: &mut Lights<'_>) {
    let angles = |light: &Light| match light.kind {
        LightKind::Spot { inner, outer } => [inner, outer],
        _ => [0.0, 0.0],
    };
    let number = Number { least: 0.0, most: 89.9, ..Number::degrees() };
    let half = |angle: f32| f64::from(angle).to_degrees();
    of.number(
        ui,
        ("Inner angle", "From the middle to where it begins to fade, degrees"),
        &number,
        |l| half(angles(l)[0]),
        |l, degrees| {
            let outer = angles(l)[1];
            let inner = (degrees.to_radians() as f32).min(outer - 0.001).max(0.0);
            l.kind = LightKind::Spot { inner, outer };
        },
    );
    of.number(
        ui,
        ("Outer angle", "From the middle to where nothing is lit any more, degrees"),
        &Number { least: 0.1, ..number },
        |l| half(angles(l)[1]),
        |l, degrees| {
            let outer = degrees.to_radians() as f32;
            l.kind = LightKind::Spot { inner: angles(l)[0].min(outer - 0.001).max(0.0), outer };
        },
    );
}

fn range(ui: &mut Ui, of: &mut Lights<'_>) {
    let limited = "Beyond its range nothing is lit. Without one it falls off with the square alone";
    let set = |l: &mut Light, on: bool| l.range = on.then_some(10.0);
    of.toggle(ui, ("Limited", limited), |l| l.range.is_some(), set);
    of.usually_with(|l| l.range = Some(10.0));
    if of.shared(|l| l.range.is_some()) == Some(true) {
        let number = Number { least: 0.01, ..Number::positive(Unit::Metres) };
        let get = |l: &Light| f64::from(l.range.unwrap_or_default());
        of.number(ui, ("Range", "Metres"), &number, get, |l, metres| l.range = Some(metres as f32));
    }
}

fn switching(ui: &mut Ui, of: &mut Lights<'_>) {
    let first = Switching { period: 2.0, on_share: 0.5, offset: 0.0 };
    let set = |l: &mut Light, on: bool| l.switching = on.then_some(first);
    of.toggle(
        ui,
        ("Switches", "Goes on and off by itself while the scene plays"),
        |l| l.switching.is_some(),
        set,
    );
    if of.shared(|l| l.switching.is_some()) != Some(true) {
        return;
    }
    of.usually_with(|l| l.switching = Some(first));
    let get = move |l: &Light| l.switching.unwrap_or(first);
    let change = |l: &mut Light, change: &dyn Fn(&mut Switching)| l.switching.iter_mut().for_each(change);
    let seconds = Number { least: 0.01, ..Number::positive(Unit::Seconds) };
    of.number(
        ui,
        ("Period", "From on to on, seconds"),
        &seconds,
        |l| get(l).period,
        |l, value| change(l, &|s| s.period = value),
    );
    of.number(
        ui,
        ("Share on", "Of the period"),
        &Number::share(),
        |l| get(l).on_share,
        |l, value| change(l, &|s| s.on_share = value),
    );
    let ahead = Number { unit: Unit::Seconds, ..Number::default() };
    of.number(
        ui,
        ("Ahead by", "Seconds: lamps of one period take turns by it"),
        &ahead,
        |l| get(l).offset,
        |l, value| change(l, &|s| s.offset = value),
    );
}
