//! Where it stands in its parent.

use eframe::egui::Ui;
use engine::scene::{Entity, Transform};
use glam::{DQuat, DVec3, EulerRot};

use super::component::{Can, component};
use super::fields::Number;
use super::subject::Subject;
use crate::ask::Asks;
use crate::edit::Field;
use crate::icons::Icon;

pub fn show<'a>(ui: &mut Ui, entities: &[&'a Entity], asks: &'a mut Asks) {
    let field = |transform| Field::Transform(Box::new(transform));
    let mut of = Subject::component(entities, |e| Some(&e.transform), field, asks);
    of = of.usually(Transform::default());
    let can = Can { remove: false, ..Can::all(of.can_paste(ui)) };
    let wish = component(ui, Icon::Empty, "Transform", can, |ui| {
        of.vector(
            ui,
            ("Position", "Of its origin in its parent, metres. Try 2*3+0.5 or 30cm"),
            &Number::metres(),
            |t| t.translation,
            |t, axis, value| t.translation[axis] = value,
        );
        of.vector(
            ui,
            ("Rotation", "About Y, then its own X, then its own Z, degrees"),
            &Number::degrees(),
            angles,
            turn,
        );
        of.vector(
            ui,
            ("Scale", "Along its own axes; a negative one mirrors"),
            &Number::default(),
            |t| t.scale,
            |t, axis, value| t.scale[axis] = value,
        );
    });
    of.fulfil(ui, wish, field(Transform::default()));
}

/// Degrees about x, y and z: turned about Y first, then about the X and Z that come of it.
fn angles(transform: &Transform) -> DVec3 {
    let (y, x, z) = transform.rotation.to_euler(EulerRot::YXZ);
    // What rounding leaves is not shown as an angle.
    DVec3::new(x, y, z).map(|angle| (angle.to_degrees() * 1e6).round() / 1e6)
}

fn turn(transform: &mut Transform, axis: usize, degrees: f64) {
    let mut angles = angles(transform);
    angles[axis] = degrees;
    let [x, y, z] = angles.to_array().map(f64::to_radians);
    transform.rotation = DQuat::from_euler(EulerRot::YXZ, y, x, z).normalize();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_that_are_set_are_read_again() {
        let mut transform = Transform::default();
        turn(&mut transform, 1, 30.0);
        turn(&mut transform, 0, -20.0);
        turn(&mut transform, 2, 75.0);
        assert!(
            angles(&transform).abs_diff_eq(DVec3::new(-20.0, 30.0, 75.0), 1e-5),
            "{}",
            angles(&transform)
        );
    }
}
