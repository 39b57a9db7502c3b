//! From a pull at a handle to an edit: where everything that is selected stands after it.

use engine::scene::{EntityId, Transform};
use glam::{DAffine3, DMat3, DQuat, DVec3};

use crate::document::Document;
use crate::edit::{Edit, Field};
use crate::gizmo::{Change, Stand};

/// An entity as it was when the pull began.
#[derive(Clone, Debug)]
pub struct Start {
    id: EntityId,
    authored: Transform,
    world_from_parent: DAffine3,
}

/// Of all that is selected and stands under nothing else that is: children go with their parents.
pub fn starts(document: &Document, selected: &[EntityId]) -> Vec<Start> {
    let start = |id: EntityId| {
        let entity = document.entity(id)?;
        let parent = entity.parent.map_or(DAffine3::IDENTITY, |parent| document.world_from_local(parent));
        Some(Start { id, authored: entity.transform, world_from_parent: parent })
    };
    document.indexed().topmost(selected).into_iter().filter_map(start).collect()
}

/// `own`: each is turned and scaled about its own origin, else about the stand's.
pub fn edit(starts: &[Start], stand: &Stand, change: &Change, own: bool) -> Edit {
    let set = |start: &Start| {
        let transform = changed(start, stand, change, own);
        transform.is_finite().then(|| (start.id, Field::Transform(Box::new(transform))))
    };
    Edit::Set(starts.iter().filter_map(set).collect())
}

fn changed(start: &Start, stand: &Stand, change: &Change, own: bool) -> Transform {
    let parent_from_world = start.world_from_parent.inverse();
    let mut new = start.authored;
    let place = start.world_from_parent.transform_point3(new.translation);
    let about = |point: DVec3| parent_from_world.transform_point3(point);
    match change {
        Change::Move(way) => new.translation = about(place + *way),
        Change::Turn { axis, angle } => {
            let turn = DQuat::from_axis_angle(axis.normalize_or(DVec3::Y), *angle);
            let parent = rotation_of(&start.world_from_parent);
            new.rotation = (parent.inverse() * turn * parent * new.rotation).normalize();
            if !own {
                new.translation = about(stand.origin + turn * (place - stand.origin));
            }
        }
        Change::Scale(factors) => {
            new.scale *= *factors;
            if !own {
                let off = stand.axes.inverse() * (place - stand.origin);
                new.translation = about(stand.origin + stand.axes * (off * *factors));
            }
        }
    }
    new
}

/// An entity stands at a place of the world and is turned so, whatever its parent is.
pub fn placed(document: &Document, id: EntityId, place: DVec3, turn: DQuat) -> Edit {
    let set = |start: &Start| {
        let mut new = start.authored;
        new.translation = start.world_from_parent.inverse().transform_point3(place);
        new.rotation = (rotation_of(&start.world_from_parent).inverse() * turn).normalize();
        (start.id, Field::Transform(Box::new(new)))
    };
    Edit::Set(starts(document, &[id]).iter().map(set).collect())
}

/// What is chosen goes this way (metres, world).
pub fn moved(document: &Document, ids: &[EntityId], way: impl Fn(EntityId) -> Option<DVec3>) -> Edit {
    let stand = Stand { origin: DVec3::ZERO, axes: DQuat::IDENTITY };
    let set = |start: &Start| {
        let new = changed(start, &stand, &Change::Move(way(start.id)?), false);
        Some((start.id, Field::Transform(Box::new(new))))
    };
    Edit::Set(starts(document, ids).iter().filter_map(set).collect())
}

/// Without scale and shear.
pub fn rotation_of(world: &DAffine3) -> DQuat {
    let m = world.matrix3;
    let x = m.x_axis.normalize_or(DVec3::X);
    let y = (m.y_axis - x * x.dot(m.y_axis)).normalize_or(x.any_orthonormal_vector());
    DQuat::from_mat3(&DMat3::from_cols(x, y, x.cross(y)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn start(translation: DVec3, world_from_parent: DAffine3) -> Start {
        Start { id: EntityId(1), authored: Transform::at(translation), world_from_parent }
    }

    const STAND: Stand = Stand { origin: DVec3::ZERO, axes: DQuat::IDENTITY };

    #[test]
    fn moving_goes_the_same_way_in_the_world_whatever_the_parent_is() {
        let parent = DAffine3::from_scale_rotation_translation(
            DVec3::splat(2.0),
            DQuat::from_rotation_y(1.0),
            DVec3::new(3.0, 0.0, 1.0),
        );
        let start = start(DVec3::X, parent);
        let before = parent.transform_point3(DVec3::X);
        let new = changed(&start, &STAND, &Change::Move(DVec3::Y * 1.5), false);
        assert!(parent.transform_point3(new.translation).abs_diff_eq(before + DVec3::Y * 1.5, 1e-9));
    }

    #[test]
    fn turning_about_the_stand_carries_and_about_itself_does_not() {
        let start = start(DVec3::X, DAffine3::IDENTITY);
        let quarter = Change::Turn { axis: DVec3::Y, angle: std::f64::consts::FRAC_PI_2 };
        let carried = changed(&start, &STAND, &quarter, false);
        assert!(carried.translation.abs_diff_eq(DVec3::NEG_Z, 1e-9));
        let own = changed(&start, &STAND, &quarter, true);
        assert_eq!(own.translation, DVec3::X);
        assert!((own.rotation * DVec3::X).abs_diff_eq(DVec3::NEG_Z, 1e-9));
    }

    #[test]
    fn scaling_about_the_stand_spreads_what_is_selected() {
        let start = start(DVec3::new(1.0, 2.0, 0.0), DAffine3::IDENTITY);
        let new = changed(&start, &STAND, &Change::Scale(DVec3::new(2.0, 1.0, 1.0)), false);
        assert_eq!((new.translation, new.scale), (DVec3::new(2.0, 2.0, 0.0), DVec3::new(2.0, 1.0, 1.0)));
    }
}
