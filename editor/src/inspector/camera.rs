//! A camera: projection, depth, exposure, tone curve.

use eframe::egui::Ui;
use engine::scene::{AutoExposure, Camera, Entity, Projection, ToneCurve};

use super::arithmetic::Unit;
use super::component::{Can, component};
use super::fields::Number;
use super::subject::Subject;
use crate::ask::Asks;
use crate::edit::Field;
use crate::icons::Icon;

const CURVES: [(ToneCurve, &str); 2] = [(ToneCurve::Neutral, "Neutral"), (ToneCurve::Agx, "AgX")];
const PROJECTIONS: [(bool, &str); 2] = [(false, "Perspective"), (true, "Orthographic")];

fn is_parallel(camera: &Camera) -> bool {
    matches!(camera.projection, Projection::Orthographic { .. })
}

pub fn show<'a>(ui: &mut Ui, entities: &[&'a Entity], asks: &'a mut Asks) {
    let field = |camera| Field::Camera(Some(Box::new(camera)));
    let mut of = Subject::component(entities, |e| e.camera.as_ref(), field, asks);
    if of.is_empty() {
        return;
    }
    let mut usual = Camera::default();
    project(&mut usual, of.first().is_some_and(is_parallel));
    of = of.usually(usual);
    let can = Can::all(of.can_paste(ui));
    let wish = component(ui, Icon::Camera, "Camera", can, |ui| {
        of.choice(
            ui,
            ("Projection", "With parallel rays nothing gets smaller with distance"),
            &PROJECTIONS,
            is_parallel,
            project,
        );
        lens(ui, &mut of);
        let near = Number { least: 0.0001, ..Number::positive(Unit::Metres) };
        of.number(
            ui,
            ("Near", "What is nearer is not seen, metres"),
            &near,
            |c| c.near.into(),
            |c, v| c.near = v as f32,
        );
        let limited = "What is farther away than that is not seen. Without it, all is";
        of.toggle(
            ui,
            ("Limited", limited),
            |c| c.far.is_some(),
            |c, on| c.far = on.then_some(c.near + 1000.0),
        );
        of.usually_with(|c| c.far = Some(c.near + 1000.0));
        if of.shared(|c| c.far.is_some()) == Some(true) {
            let get = |c: &Camera| f64::from(c.far.unwrap_or_default());
            of.number(ui, ("Far", "Metres"), &near, get, |c, v| {
                c.far = Some((v as f32).max(c.near * 1.001 + 1e-4))
            });
        }
        exposure(ui, &mut of);
        of.choice(
            ui,
            ("Tone curve", "How light too bright for the display is shown"),
            &CURVES,
            |c| c.tonemap,
            |c, v| c.tonemap = v,
        );
    });
    of.fulfil(ui, wish, Field::Camera(None));
}

fn project(camera: &mut Camera, parallel: bool) {
    camera.projection = match parallel {
        true => Projection::Orthographic { half_height: 2.0 },
        false => Projection::Perspective { fov_y: 0.9 },
    };
}

type Cameras<'a> = Subject<'a, engine::scene::EntityId, Camera>;

fn lens(ui: &mut Ui, of: &mut Cameras<'_>) {
    match of.shared(is_parallel) {
        Some(false) => {
            let get = |c: &Camera| match c.projection {
                Projection::Perspective { fov_y } => f64::from(fov_y).to_degrees(),
                Projection::Orthographic { .. } => 0.0,
            };
            let set = |c: &mut Camera, degrees: f64| {
                c.projection = Projection::Perspective { fov_y: degrees.to_radians() as f32 };
            };
            let number = Number { least: 1.0, most: 170.0, ..Number::degrees() };
            of.number(ui, ("Field of view", "From the lower to the upper edge, degrees"), &number, get, set);
        }
        Some(true) => {
            let get = |c: &Camera| match c.projection {
                Projection::Orthographic { half_height } => f64::from(half_height) * 2.0,
                Projection::Perspective { .. } => 0.0,
            };
            let set = |c: &mut Camera, height: f64| {
                c.projection = Projection::Orthographic { half_height: (height * 0.5) as f32 };
            };
            let number = Number { least: 0.001, ..Number::positive(Unit::Metres) };
            of.number(ui, ("Height", "Of what is seen, metres"), &number, get, set);
        }
        None => {}
    }
}

fn exposure(ui: &mut Ui, of: &mut Cameras<'_>) {
    let stops =
        Number { unit: Unit::Stops, speed: 0.02, least: -32.0, most: 32.0, decimals: 2, ..Number::default() };
    let set = |c: &mut Camera, on: bool| c.auto_exposure = on.then(AutoExposure::default);
    of.toggle(
        ui,
        ("Automatic", "The exposure follows what is seen, as eyes do"),
        |c| c.auto_exposure.is_some(),
        set,
    );
    match of.shared(|c| c.auto_exposure.is_some()) {
        Some(false) => {
            let tooltip = "Stops: one more is twice as bright";
            of.number(ui, ("Exposure", tooltip), &stops, |c| c.exposure.into(), |c, v| c.exposure = v as f32);
        }
        Some(true) => {
            of.usually_with(|c| c.auto_exposure = Some(AutoExposure::default()));
            let get = |c: &Camera| c.auto_exposure.unwrap_or_default();
            let mut row = |name,
                           tooltip,
                           number: &Number,
                           of: &mut Cameras<'_>,
                           part: fn(&mut AutoExposure) -> &mut f32| {
                let set = |c: &mut Camera, v: f64| {
                    c.auto_exposure.iter_mut().for_each(|auto| *part(auto) = v as f32)
                };
                of.number(ui, (name, tooltip), number, |c| (*part(&mut get(c))).into(), set);
            };
            row("Compensation", "Brighter or darker than it would be, stops", &stops, of, |a| {
                &mut a.compensation
            });
            row("Least", "Stops that it never goes below", &stops, of, |a| &mut a.least);
            row("Most", "Stops that it never goes above", &stops, of, |a| &mut a.most);
            row("Speed", "Stops a second, about", &Number::positive(Unit::None), of, |a| &mut a.speed);
        }
        None => {}
    }
}
