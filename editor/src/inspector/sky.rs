//! The sky, shown where nothing is selected.

use eframe::egui::{self, Ui};
use engine::scene::{LightKind, Sky, SkyKind};

use super::entity::{self, Question};
use super::fields::{self, Number, section};
use super::subject::Subject;
use super::{colour, light};
use crate::ask::Asks;
use crate::document::Document;
use crate::edit::{Edit, tree};
use crate::icons::Icon;
use crate::primitives;

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    None,
    Constant,
    Gradient,
    Picture,
}

fn kind(sky: &Sky) -> Kind {
    match sky.kind {
        SkyKind::None => Kind::None,
        SkyKind::Constant { .. } => Kind::Constant,
        SkyKind::Gradient { .. } => Kind::Gradient,
        SkyKind::Picture { .. } => Kind::Picture,
    }
}

pub fn show(ui: &mut Ui, document: &Document, asks: &mut Asks) {
    let sky = &document.scene().sky;
    let edit = |items: Vec<((), Sky)>| match items.into_iter().next() {
        Some((_, sky)) => Edit::Sky(Box::new(sky)),
        None => Edit::Set(Vec::new()),
    };
    let mut of = Subject::new(vec![((), sky)], edit, asks).usually(usual(sky));
    section(ui, Icon::Sky, "Sky", None, |ui| {
        let mut kinds =
            vec![(Kind::None, "None"), (Kind::Constant, "One color"), (Kind::Gradient, "Gradient")];
        if kind(sky) == Kind::Picture {
            kinds.push((Kind::Picture, "Picture"));
        }
        of.choice(ui, ("Kind", "What rays see that leave the scene"), &kinds, kind, set_kind);
        match &sky.kind {
            SkyKind::None => {}
            SkyKind::Constant { .. } => constant(ui, &mut of),
            SkyKind::Gradient { .. } => {
                gradient(ui, &mut of);
                sun(ui, &mut of, document);
            }
            SkyKind::Picture { image, .. } => {
                fields::row(ui, "Picture", "Equirectangular", |ui| {
                    ui.add(egui::Label::new(format!("{image:?}")).truncate());
                });
                picture(ui, &mut of);
            }
        }
        let changes = "What of it may change while the scene plays: the less, the cheaper";
        of.choice(ui, ("May change", changes), &light::CHANGES, |s| s.changes, |s, v| s.changes = v);
    });
}

/// What its fields are reset to: another sky of its kind.
fn usual(sky: &Sky) -> Sky {
    let mut usual = Sky::default();
    set_kind(&mut usual, kind(sky));
    if let SkyKind::Picture { image, .. } = &sky.kind {
        usual.kind = SkyKind::Picture { image: image.clone(), strength: 1.0, turn: 0.0 };
    }
    usual
}

fn set_kind(sky: &mut Sky, kind: Kind) {
    sky.kind = match kind {
        Kind::None => SkyKind::None,
        Kind::Constant => SkyKind::Constant { radiance: glam::Vec3::splat(0.5) },
        Kind::Gradient => primitives::day().kind,
        Kind::Picture => return,
    };
}

type TheSky<'a> = Subject<'a, (), Sky>;

fn constant(ui: &mut Ui, of: &mut TheSky<'_>) {
    let get = |sky: &Sky| match sky.kind {
        SkyKind::Constant { radiance } => radiance,
        _ => glam::Vec3::ZERO,
    };
    let tooltip = "From everywhere, W/m\u{b2}/sr";
    colour::row(ui, of, ("Radiance", tooltip), get, |sky, radiance| {
        sky.kind = SkyKind::Constant { radiance }
    });
}

fn gradient(ui: &mut Ui, of: &mut TheSky<'_>) {
    let parts = [("Zenith", "From straight above"), ("Horizon", "From the side"), ("Ground", "From below")];
    for (part, (name, tooltip)) in parts.into_iter().enumerate() {
        let get = move |sky: &Sky| match sky.kind {
            SkyKind::Gradient { zenith, horizon, ground, .. } => [zenith, horizon, ground][part],
            _ => glam::Vec3::ZERO,
        };
        let set = move |sky: &mut Sky, color: glam::Vec3| {
            if let SkyKind::Gradient { zenith, horizon, ground, .. } = &mut sky.kind {
                *[zenith, horizon, ground][part] = color;
            }
        };
        let tooltip = format!("{tooltip}, W/m\u{b2}/sr");
        colour::row(ui, of, (name, tooltip.as_str()), get, set);
    }
}

/// The light whose disc is seen in it.
fn sun(ui: &mut Ui, of: &mut TheSky<'_>, document: &Document) {
    let get = |sky: &Sky| match sky.kind {
        SkyKind::Gradient { sun, sun_diameter, .. } => (sun, f64::from(sun_diameter).to_degrees()),
        _ => (None, 0.0),
    };
    let question = Question {
        name: "Sun",
        tooltip: "The light whose disc is seen in the sky. Its light is that light's own",
        none: "None",
        fits: |entity| entity.light.as_ref().is_some_and(|light| light.kind == LightKind::Sun),
    };
    let shared = of.shared(|sky| get(sky).0);
    if let Some(chosen) = entity::field(ui, &question, document, shared) {
        of.set_now(chosen, |sky, chosen| *sky = tree::with_sun(sky, chosen));
    }
    if shared.flatten().is_some() {
        let number = Number { least: 0.01, most: 90.0, speed: 0.01, ..Number::degrees() };
        let tooltip = "Across the disc, degrees: ours is half of one";
        of.number(
            ui,
            ("Sun's size", tooltip),
            &number,
            |sky| get(sky).1,
            |sky, degrees| {
                if let SkyKind::Gradient { sun_diameter, .. } = &mut sky.kind {
                    *sun_diameter = degrees.to_radians() as f32;
                }
            },
        );
    }
}

fn picture(ui: &mut Ui, of: &mut TheSky<'_>) {
    let get = |sky: &Sky| match sky.kind {
        SkyKind::Picture { strength, turn, .. } => [strength, turn],
        _ => [0.0; 2],
    };
    let number = Number::positive(Default::default());
    of.number(
        ui,
        ("Strength", "Times the picture's values"),
        &number,
        |s| get(s)[0].into(),
        |s, v| {
            if let SkyKind::Picture { strength, .. } = &mut s.kind {
                *strength = v as f32;
            }
        },
    );
    let degrees = |s: &Sky| f64::from(get(s)[1]).to_degrees();
    of.number(ui, ("Turn", "About the vertical, degrees"), &Number::degrees(), degrees, |s, v| {
        if let SkyKind::Picture { turn, .. } = &mut s.kind {
            *turn = v.to_radians() as f32;
        }
    });
}
