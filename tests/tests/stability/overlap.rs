//! Surfaces in the same place, slivers, and triangles that are none. Cases 19 to 22 of the catalogue.

use glam::{DVec3, Vec3};
use tests::enclosure::{Wall, cube, project, rooms_apart};
use tests::project::TestProject;
use tests::solution::{Solved, baked, solved};
use tests::surfaces::{Faces, from_obj};

const RAYS: u32 = 1024;

/// A cube whose -x wall glows.
fn lit(walls: &mut [Wall]) -> TestProject {
    walls[0].exitance = Vec3::ONE;
    project(walls)
}

/// The means of what arrives at the six walls.
fn means(solved: &Solved) -> Vec<f64> {
    let h = solved.h();
    (1..=6).map(|id| solved.mean(&solved.of_entity(id), |i| h[i].y)).collect()
}

// Case 19.
#[test]
fn a_face_that_is_there_twice_counts_once() {
    let single = solved(&lit(&mut cube()), 0.25, RAYS);
    let mut walls = cube();
    walls.push(Wall::new("twin", walls[2].faces.clone()));
    let double = solved(&lit(&mut walls), 0.25, RAYS);
    let told = double.warnings.iter().map(ToString::to_string).find(|text| text.contains("twin"));
    assert!(told.as_ref().is_some_and(|text| text.contains("lie exactly on others")), "{told:?}");
    assert_eq!(double.transport.certificate.dropped_triangles, 2);
    assert!(double.transport.patch_from_patch == single.transport.patch_from_patch);
    assert_eq!(double.b, single.b);
}

// Case 19, where the two are divided differently and neither is dropped.
#[test]
fn a_face_that_lies_on_another_changes_the_light_by_no_more_than_noise() {
    let single = solved(&lit(&mut cube()), 0.25, RAYS);
    let mut walls = cube();
    let mut turned = walls[2].faces.clone();
    turned[0].rotate_left(1);
    walls.push(Wall::new("twin", turned));
    let project = lit(&mut walls);
    let double = solved(&project, 0.25, RAYS);
    assert_eq!(double.transport.certificate.dropped_triangles, 0);
    println!("{:?}\n{:?}", means(&single), means(&double));
    let told = double.warnings.iter().map(ToString::to_string).find(|text| text.contains("twin"));
    assert!(told.as_ref().is_some_and(|text| text.contains("lie on others")), "{told:?}");
    for (one, two) in means(&single).into_iter().zip(means(&double)) {
        // Of 16 patches' rays at least, each with a spread of no more than the light itself: 4 sigma is 3 %.
        assert!((two / one - 1.0).abs() < 0.03, "{one} {two}");
    }
    // Of two faces in the same place the one of the lower id is hit, in whatever order they are stored.
    tests::enclosure::change(&project, |scene| scene.entities.reverse());
    let again = baked(&project, 0.25, RAYS).transport;
    assert_eq!(again.hash(), double.transport.hash());
}

// Case 20.
#[test]
fn a_wall_without_thickness_leaves_the_dark_room_dark() {
    let rooms = solved(&lit(&mut rooms_apart()), 0.4, RAYS);
    let origin = rooms.transport.origin;
    let is_dark = |i: &usize| {
        let patch = &rooms.transport.patches[*i];
        let x = f64::from(patch.centre.x) + origin.x;
        x > 2.0 + 1e-6 || (x > 2.0 - 1e-6 && patch.normal.x > 0.0)
    };
    let (dark, bright): (Vec<usize>, Vec<usize>) = (0..rooms.b.len()).partition(is_dark);
    let h = rooms.h();
    assert!(dark.len() > 40 && dark.iter().all(|&i| rooms.b[i] == DVec3::ZERO && h[i] == DVec3::ZERO));
    assert!(bright.len() > 40 && bright.iter().all(|&i| h[i].min_element() > 0.0));
    let receivers = rooms.transport.receivers.iter().zip(rooms.h_of_receivers());
    let behind = receivers.filter(|(receiver, _)| f64::from(receiver.position.x) + origin.x > 2.001);
    let found: Vec<DVec3> = behind.map(|(_, h)| h).collect();
    assert!(found.len() > 100 && found.iter().all(|h| *h == DVec3::ZERO));
    let component = |i: usize| rooms.transport.patches[i].component;
    assert!(dark.iter().all(|&d| bright.iter().all(|&b| component(d) != component(b))));
}

// Case 21.
#[test]
fn a_sliver_a_million_times_as_long_as_wide_is_as_bright_as_what_lies_beside_it() {
    let p = |x: f32, z: f32| Vec3::new(x, 0.0, z);
    let beside = 0.5 + 1e-6;
    let left = vec![vec![p(0.0, 0.0), p(0.0, 1.0), p(0.5, 1.0), p(0.5, 0.0)]];
    let right: Faces = vec![vec![p(0.5, 0.0), p(beside, 1.0), p(1.0, 1.0), p(1.0, 0.0)]];
    let mut walls = cube();
    walls[2].faces = left;
    walls.push(Wall::new("right", right));
    walls.push(Wall::new("sliver", vec![vec![p(0.5, 0.0), p(0.5, 1.0), p(beside, 1.0)]]));
    walls[3].exitance = Vec3::ONE;
    let room = solved(&project(&walls), 0.25, 1 << 13);
    let certificate = &room.transport.certificate;
    assert_eq!((certificate.lost, certificate.escaped), (0.0, 0.0), "nothing slips through beside it");
    let sliver = room.of_entity(8);
    assert!(!sliver.is_empty());
    assert!(
        sliver
            .iter()
            .all(|&i| room.area(i) > 0.0 && (room.transport.patch_from_patch.sum(i) - 1.0).abs() < 2e-7)
    );
    assert!(room.b.iter().all(|b| b.is_finite()));
    let near = |i: &usize| {
        (f64::from(room.transport.patches[*i].centre.x) + room.transport.origin.x - 0.5).abs() < 0.2
    };
    let floor: Vec<usize> = [3, 7].into_iter().flat_map(|id| room.of_entity(id)).filter(near).collect();
    let (own, beside) = (room.mean(&sliver, |i| room.b[i].y), room.mean(&floor, |i| room.b[i].y));
    println!("{} patches of sliver: {own}, {} beside it: {beside}", sliver.len(), floor.len());
    assert!((own / beside - 1.0).abs() < 0.05, "{own} {beside}");
}

// Case 22.
#[test]
fn triangles_without_area_are_counted_and_leave_no_trace_in_the_bake() {
    let corners = "v 0 0 0\nv 0 0 1\nv 1 0 1\nv 1 0 0\nv 0.5 0 0.5\nv 0 0 1\nv 0.5 1 0\nv 0.5 1 1\nv 1 1 1\n";
    let of =
        |more: &str| from_obj(&format!("o floor\n{corners}f 1 2 3\nf 1 3 4\n{more}o ceiling\nf 7 9 8\n"));
    let clean = baked(&of(""), 0.25, 256);
    // Indices repeated, a corner twice under two numbers, corners in a line.
    let littered = baked(&of("f 1 1 2\nf 3 3 3\nf 2 6 3\nf 1 5 3\n"), 0.25, 256);
    assert_eq!(clean.transport.certificate.dropped_triangles, 0);
    assert_eq!(littered.transport.certificate.dropped_triangles, 4);
    assert_eq!(littered.transport.hash(), clean.transport.hash());
}
