//! Projects of plain surfaces: an OBJ file with an object, and so a static entity, for each.

use std::fmt::Write;

use engine::transport::Transport;
use glam::Vec3;

use crate::project::TestProject;
use crate::room::Rectangle;

/// Flat polygons, counter-clockwise from the front.
pub type Faces = Vec<Vec<Vec3>>;

/// Entities have ids from 1 in this order, and a grey material of their own each, ids from 0.
pub fn project(surfaces: &[(&str, Faces)]) -> TestProject {
    let mut obj = String::new();
    let mut next = 1;
    for (name, faces) in surfaces {
        writeln!(obj, "o {name}\nusemtl {name}").expect("text");
        for face in faces {
            face.iter().for_each(|p| writeln!(obj, "v {} {} {}", p.x, p.y, p.z).expect("text"));
            let corners: Vec<String> = (next..next + face.len()).map(|n| n.to_string()).collect();
            writeln!(obj, "f {}", corners.join(" ")).expect("text");
            next += face.len();
        }
    }
    from_obj(&obj)
}

pub fn from_obj(obj: &str) -> TestProject {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("surfaces.obj");
    std::fs::write(&file, obj).expect("an OBJ file");
    TestProject::from_file(&file)
}

pub fn quad(corner: Vec3, first: Vec3, second: Vec3) -> Faces {
    face(&Rectangle { corner, edges: [first, second] })
}

pub fn face(rectangle: &Rectangle) -> Faces {
    vec![[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(u, v)| rectangle.at(u, v)).to_vec()]
}

/// The same seen from its other side.
pub fn turned(faces: Faces) -> Faces {
    faces.into_iter().map(|face| face.into_iter().rev().collect()).collect()
}

pub fn area(faces: &Faces) -> f64 {
    let of = |face: &Vec<Vec3>| -> f64 {
        let points: Vec<_> = face.iter().map(|p| p.as_dvec3() - face[0].as_dvec3()).collect();
        0.5 * points.windows(2).map(|pair| pair[0].cross(pair[1])).sum::<glam::DVec3>().length()
    };
    faces.iter().map(of).sum()
}

/// By patch, the id of its entity.
pub fn entities(transport: &Transport) -> Vec<u64> {
    let batches = &transport.surface.batches;
    transport.patches.iter().map(|patch| batches[patch.batch as usize].entity().0).collect()
}

/// The share of the light that leaves entity `from` which arrives at entity `to`, as the rows say.
pub fn form_factor(transport: &Transport, from: u64, to: u64) -> f64 {
    let entities = entities(transport);
    let (mut flux, mut area) = (0.0, 0.0);
    for (i, patch) in transport.patches.iter().enumerate().filter(|&(i, _)| entities[i] == from) {
        let row = transport.patch_from_patch.row(i);
        let there = row.filter(|&(j, _)| entities.get(j as usize) == Some(&to));
        flux += f64::from(patch.area) * there.map(|(_, weight)| f64::from(weight)).sum::<f64>();
        area += f64::from(patch.area);
    }
    flux / area
}
