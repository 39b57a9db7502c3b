//! Projects of plain surfaces that are painted, with lights; and the witnesses that are asked what arrives there.

use bake::reference::{Measured, PathTracer, Surfaces};
use bake::{Irradiance, Method, Point, Settings, Silent, bake, query_points};
use engine::scene::{Entity, EntityId, Scene};
use engine::transport::Transport;
use glam::{DVec3, Vec3};

use crate::project::TestProject;
use crate::room::Rectangle;
use crate::surfaces::{Faces, face, project};

/// Grey, and what it gives off by itself.
#[derive(Clone, Copy, Debug, Default)]
pub struct Paint {
    pub albedo: f32,
    /// M [W/m2].
    pub exitance: f32,
}

pub const BLACK: Paint = Paint { albedo: 0.0, exitance: 0.0 };
/// Black, and radiosity 1: irradiance is the form factor.
pub const LAMP: Paint = Paint { albedo: 0.0, exitance: 1.0 };

pub struct Lit {
    pub project: TestProject,
}

impl Lit {
    /// Entities have ids from 1 in this order.
    pub fn new(surfaces: &[(&str, Faces, Paint)], lights: Vec<Entity>) -> Self {
        let plain: Vec<(&str, Faces)> =
            surfaces.iter().map(|(name, faces, _)| (*name, faces.clone())).collect();
        let lit = Self { project: project(&plain) };
        let paints: Vec<Paint> = surfaces.iter().map(|(_, _, paint)| *paint).collect();
        lit.paint(&paints);
        lit.change(|scene| scene.entities.extend(lights));
        lit
    }

    /// Paints the surfaces anew, in their order: no bake depends on it, but on which of them shine.
    pub fn paint(&self, paints: &[Paint]) {
        self.change(|scene| {
            for (k, paint) in paints.iter().enumerate() {
                let entity = scene.entity(EntityId(k as u64 + 1)).expect("a surface");
                let id = entity.mesh.as_ref().expect("a mesh").materials[0];
                let material =
                    scene.materials.iter_mut().find(|material| material.id == id).expect("a paint");
                material.albedo.color = Vec3::splat(paint.albedo);
                material.emission.color = Vec3::splat(paint.exitance / std::f32::consts::PI);
                material.emission.sampled = paint.exitance > 0.0;
            }
        });
    }

    pub fn change(&self, change: impl FnOnce(&mut Scene)) {
        let mut scene = self.project.scene();
        change(&mut scene);
        self.project.save(&scene);
    }

    pub fn bake(&self, length: f64, rays: u32) -> Transport {
        let settings = Settings { rays: Some(rays), patch_length: Some(length), ..Settings::default() };
        let baked = bake(self.project.path(), None, &settings, &Silent).expect("a bake");
        let certificate = &baked.transport.certificate;
        assert!(certificate.holds(), "{:#?}", certificate.statements());
        baked.transport
    }

    pub fn query(&self, points: &[Point], method: Method) -> Vec<Irradiance> {
        query_points(self.project.path(), None, &Settings::default(), points, method).expect("a query")
    }

    pub fn tracer(&self, surfaces: Surfaces) -> PathTracer {
        PathTracer::open(self.project.path(), None, surfaces).expect("a path tracer")
    }

    pub fn traced(&self, points: &[Point], paths: u32) -> Vec<Measured> {
        self.tracer(Surfaces::Diffuse).irradiance(points, paths, 1, &Silent).expect("irradiance")
    }
}

pub fn point(position: [f64; 3], normal: [f64; 3]) -> Point {
    Point { position: DVec3::from(position), normal: DVec3::from(normal) }
}

/// A meter: a square of this size about a point, which faces its normal.
pub fn meter(point: &Point, size: f32) -> Faces {
    let (u, v) = point.normal.as_vec3().any_orthonormal_pair();
    let corner = point.position.as_vec3() - (u + v) * (0.5 * size);
    face(&Rectangle { corner, edges: [u * size, v * size] })
}

/// A regular polygon with so many sides, of the area of a disc of this radius, facing up.
pub fn disc(radius: f32, y: f32, sides: usize) -> Faces {
    let turn = std::f32::consts::TAU / sides as f32;
    let radius = radius * (turn / turn.sin()).sqrt();
    let corner = |k: usize| {
        let (sin, cos) = (-turn * k as f32).sin_cos();
        Vec3::new(cos * radius, y, sin * radius)
    };
    vec![(0..sides).map(corner).collect()]
}

/// A sphere's belt between two rings of `down`, of flat trapezoids, facing outward.
pub fn belt(radius: f32, around: usize, down: usize, rings: std::ops::Range<usize>) -> Faces {
    let at = |i: usize, j: usize| {
        let (sin, cos) = (std::f32::consts::TAU * (i % around) as f32 / around as f32).sin_cos();
        let (ring, height) = (std::f32::consts::PI * j as f32 / down as f32).sin_cos();
        let ring = if j == 0 || j == down { 0.0 } else { ring };
        Vec3::new(ring * cos, height, ring * sin) * radius
    };
    let mut faces = Faces::new();
    for (i, j) in (0..around).flat_map(|i| rings.clone().map(move |j| (i, j))) {
        let mut face = vec![at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        face.dedup();
        if face.first() == face.last() {
            face.pop();
        }
        faces.push(face);
    }
    faces
}
