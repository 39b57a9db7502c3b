//! Transports made by hand, whose light is known: the inside of a box, and a floor under the sky.

use std::f32::consts::{PI, TAU};

use engine::scene::shape::Shape;
use engine::scene::{
    Albedo, Entity, EntityId, Light, LightKind, Material, MaterialId, MeshRenderer, MeshSource, Scene,
    Transform,
};
use engine::transport::surface::{Blend, Surface};
use engine::transport::{Batch, NONE, Patch, Probe, Receiver, Rows, Sample, Transport, Vertex, sh, sky};
use glam::{DQuat, DVec3, Vec2, Vec3};

/// A rectangle: a corner and two edges; its front is along their cross product.
#[derive(Clone, Copy, Debug)]
pub struct Rectangle {
    pub corner: Vec3,
    pub edges: [Vec3; 2],
}

impl Rectangle {
    pub fn normal(&self) -> Vec3 {
        self.edges[0].cross(self.edges[1]).normalize()
    }

    pub fn area(&self) -> f32 {
        self.edges[0].cross(self.edges[1]).length()
    }

    pub fn at(&self, u: f32, v: f32) -> Vec3 {
        self.corner + self.edges[0] * u + self.edges[1] * v
    }

    fn cell(&self, n: u32, i: u32, j: u32) -> Self {
        let step = 1.0 / n as f32;
        Self { corner: self.at(i as f32 * step, j as f32 * step), edges: self.edges.map(|edge| edge * step) }
    }

    /// Share of the cosine-weighted hemisphere over a point that the rectangle covers (Lambert 1760); all of it
    /// lies in front of the point, which it faces.
    pub fn factor(&self, point: Vec3, normal: Vec3) -> f32 {
        if self.normal().dot(point - self.corner) <= 1e-6 {
            return 0.0;
        }
        let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(u, v)| self.at(u, v) - point);
        let mut sum = 0.0;
        for k in 0..4 {
            let (a, b) = (corners[k], corners[(k + 1) % 4]);
            let cross = a.cross(b);
            if cross.length() > 1e-9 {
                sum += a.angle_between(b) * normal.dot(cross.normalize());
            }
        }
        (sum / TAU).abs()
    }
}

/// -x +x -y +y -z +z of a box, all facing its inside.
pub fn walls(low: Vec3, high: Vec3) -> [Rectangle; 6] {
    let size = high - low;
    let (x, y, z) = (Vec3::X * size.x, Vec3::Y * size.y, Vec3::Z * size.z);
    let wall = |corner, edges| Rectangle { corner, edges };
    [
        wall(low, [y, z]),
        wall(low + x, [z, y]),
        wall(low, [z, x]),
        wall(low + y, [x, z]),
        wall(low, [x, y]),
        wall(low + z, [y, x]),
    ]
}

/// Each rectangle becomes a static entity (ids from 1) with a material of its own (ids from 0), n x n patches and
/// (n + 1) x (n + 1) receivers. Rows are empty.
pub fn surfaces(rectangles: &[Rectangle], n: u32) -> Transport {
    let mut transport = Transport::default();
    for (index, rectangle) in rectangles.iter().enumerate() {
        add(&mut transport, rectangle, n, index as u32);
    }
    transport
}

fn add(transport: &mut Transport, rectangle: &Rectangle, n: u32, index: u32) {
    let Surface { vertices, blends, triangles, patches, batches, .. } = &mut transport.surface;
    let (first_vertex, first_triangle) = (vertices.len() as u32, triangles.len() as u32);
    let normal = rectangle.normal();
    for j in 0..=n {
        for i in 0..=n {
            let uv = Vec2::new(i as f32, j as f32) / n as f32;
            let position = rectangle.at(uv.x, uv.y);
            blends.push(Blend::one(transport.receivers.len() as u32));
            transport.receivers.push(Receiver { position, valid: 1.0, normal, padding: 0 });
            vertices.push(Vertex { position, normal, tangent: [0.0; 4], uv: [uv, uv], color: [1.0; 4] });
        }
    }
    for j in 0..n {
        for i in 0..n {
            let patch = transport.patches.len() as u32;
            let cell = rectangle.cell(n, i, j);
            let at = |i: u32, j: u32| first_vertex + j * (n + 1) + i;
            let corners = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            transport.patches.push(Patch {
                centre: cell.at(0.5, 0.5),
                area: cell.area(),
                normal,
                batch: index,
                first_triangle: triangles.len() as u32,
                triangle_count: 2,
                first_sample: transport.samples.len() as u32,
                sample_count: 4,
                aggregate: index,
                ..Patch::default()
            });
            for (u, v) in [(0.25, 0.25), (0.75, 0.25), (0.25, 0.75), (0.75, 0.75)] {
                transport.samples.push(Sample { position: cell.at(u, v), patch, normal, padding: 0 });
            }
            triangles.push([corners[0], corners[1], corners[2]]);
            triangles.push([corners[0], corners[2], corners[3]]);
            patches.extend([[patch, NONE]; 2]);
        }
    }
    batches.push(Batch {
        entity: [index + 1, 0],
        material: index,
        double_sided: 0,
        first: first_triangle,
        count: n * n * 2,
    });
}

/// The inside of a box, closed: every row sums to 1.
pub fn closed_box(low: Vec3, high: Vec3, n: u32) -> Transport {
    let walls = walls(low, high);
    let mut transport = surfaces(&walls, n);
    let cells: Vec<Rectangle> =
        walls.iter().flat_map(|wall| (0..n * n).map(move |k| wall.cell(n, k % n, k / n))).collect();
    for cell in &cells {
        let points = [(0.25, 0.25), (0.75, 0.25), (0.25, 0.75), (0.75, 0.75)].map(|(u, v)| cell.at(u, v));
        let normal = cell.normal();
        let factor = |to: &Rectangle| points.iter().map(|&point| to.factor(point, normal)).sum::<f32>() / 4.0;
        let row: Vec<f32> = cells.iter().map(factor).collect();
        transport.patch_from_patch.push(shares(&row));
    }
    for receiver in &transport.receivers {
        // Off the edges, at which a wall's share is not defined.
        let inside = receiver.position + ((low + high) * 0.5 - receiver.position) * 1e-3;
        let inside = inside - receiver.normal * receiver.normal.dot(inside - receiver.position);
        let row: Vec<f32> = cells.iter().map(|cell| cell.factor(inside, receiver.normal)).collect();
        transport.receiver_from_patch.push(shares(&row));
    }
    transport
}

/// A closed box of [`closed_box`] with light probes in it, their rows by many rays.
pub fn with_probes(mut transport: Transport, low: Vec3, high: Vec3, positions: &[Vec3]) -> Transport {
    const RAYS: u32 = 20_000;
    let walls = walls(low, high);
    let n = ((transport.patches.len() / 6) as f32).sqrt().round() as u32;
    for &position in positions {
        transport.probes.push(Probe { position, valid: 1.0, ..Probe::default() });
        let mut weights = vec![[0.0_f32; sh::COEFFICIENTS]; transport.patches.len()];
        for direction in directions(RAYS) {
            let way = |wall: &Rectangle| {
                wall.normal().dot(wall.corner - position) / wall.normal().dot(direction).min(-1e-9)
            };
            let distances = walls.each_ref().map(way);
            let hit = (0..6).min_by(|&a, &b| distances[a].total_cmp(&distances[b])).unwrap_or(0);
            let wall = &walls[hit];
            let at = position + direction * distances[hit] - wall.corner;
            let cell = wall.edges.map(|edge| (at.dot(edge) / edge.length_squared() * n as f32) as u32);
            let patch = hit as u32 * n * n + cell[1].min(n - 1) * n + cell[0].min(n - 1);
            let y = sh::basis(direction);
            (0..9).for_each(|k| weights[patch as usize][k] += 4.0 / RAYS as f32 * y[k]);
        }
        for k in 0..sh::COEFFICIENTS {
            transport.probe_from_patch.push((0..).zip(&weights).map(|(patch, weights)| (patch, weights[k])));
        }
    }
    transport
}

/// Evenly spread over the sphere (a Fibonacci spiral).
pub fn directions(n: u32) -> impl Iterator<Item = Vec3> {
    let golden = PI * (3.0 - 5.0_f32.sqrt());
    (0..n).map(move |k| {
        let z = 1.0 - (2 * k + 1) as f32 / n as f32;
        let r = (1.0 - z * z).sqrt();
        let angle = golden * k as f32;
        Vec3::new(r * angle.cos(), r * angle.sin(), z)
    })
}

/// What is more than nothing, as shares of 1 less a little for rounding.
fn shares(row: &[f32]) -> Vec<(u32, f32)> {
    let sum: f64 = row.iter().map(|&weight| f64::from(weight)).sum();
    let scale = (1.0 - 2e-7) / sum;
    let some = (0..).zip(row).filter(|(_, weight)| **weight > 0.0);
    some.map(|(column, &weight)| (column, (f64::from(weight) * scale) as f32)).collect()
}

/// A floor of `size` x `size` metres at y = 0 under the sky: half of what it sees of the sphere is sky.
pub fn floor(size: f32, n: u32) -> Transport {
    let corner = Vec3::new(-0.5, 0.0, -0.5) * size;
    let floor = Rectangle { corner, edges: [Vec3::Z * size, Vec3::X * size] };
    let mut transport = surfaces(&[floor], n);
    transport.sky_patches = sky::COUNT;
    let patches = transport.patches.len() as u32;
    let row: Vec<(u32, f32)> = sky_shares().into_iter().map(|(sky, share)| (patches + sky, share)).collect();
    transport.patches.iter().for_each(|_| transport.patch_from_patch.push(row.iter().copied()));
    transport.receivers.iter().for_each(|_| transport.receiver_from_patch.push(row.iter().copied()));
    transport
}

/// Shares of the cosine-weighted upper hemisphere, by sky patch.
fn sky_shares() -> Vec<(u32, f32)> {
    const GRID: u32 = 8;
    let weight = |patch: u32| {
        let cosine = |k: u32| {
            let at = |i: u32| (i as f32 + 0.5) / GRID as f32;
            sky::direction_in(patch, at(k % GRID), at(k / GRID)).y.max(0.0)
        };
        (0..GRID * GRID).map(cosine).sum::<f32>()
    };
    let weights: Vec<f32> = (0..sky::COUNT).map(weight).collect();
    shares(&weights)
}

/// Rows to nowhere for what has none: every space has a row.
pub fn with_empty_rows(mut transport: Transport) -> Transport {
    let fill = |rows: &mut Rows, count: usize| (rows.len()..count).for_each(|_| rows.push([]));
    fill(&mut transport.patch_from_patch, transport.patches.len());
    fill(&mut transport.receiver_from_patch, transport.receivers.len());
    fill(&mut transport.probe_from_patch, transport.probes.len() * 9);
    transport
}

/// The scene that such a transport was made of: an entity and a material of this albedo a batch.
pub fn scene_of(transport: &Transport, albedo: impl Fn(usize) -> Vec3) -> Scene {
    let mut scene = Scene::default();
    for (index, batch) in transport.surface.batches.iter().enumerate() {
        scene.entities.push(Entity {
            id: batch.entity(),
            name: format!("wall {index}"),
            is_static: true,
            mesh: Some(mesh(Shape::Quad, batch.material)),
            ..Entity::default()
        });
        scene.materials.push(Material {
            id: MaterialId(batch.material),
            name: format!("paint {index}"),
            albedo: Albedo { color: albedo(index), ..Albedo::default() },
            ..Material::default()
        });
    }
    scene
}

pub fn mesh(shape: Shape, material: u32) -> MeshRenderer {
    MeshRenderer {
        mesh: MeshSource::Shape(shape),
        materials: vec![MaterialId(material)],
        casts_shadows: true,
        density: Default::default(),
        reflection: Default::default(),
    }
}

pub fn light(id: u64, kind: LightKind, intensity: f32, position: DVec3, towards: DVec3) -> Entity {
    let way = (towards - position).normalize_or(DVec3::NEG_Y);
    Entity {
        id: EntityId(id),
        name: format!("light {id}"),
        transform: Transform {
            translation: position,
            rotation: DQuat::from_rotation_arc(DVec3::NEG_Z, way),
            ..Transform::default()
        },
        light: Some(Light { kind, intensity, ..Light::default() }),
        ..Entity::default()
    }
}

/// Irradiance from a point light of this intensity.
pub fn point_irradiance(intensity: f32, light: Vec3, point: Vec3, normal: Vec3) -> f32 {
    let way = light - point;
    intensity * normal.dot(way.normalize()).max(0.0) / way.length_squared()
}

/// Radiance of a diffuse surface.
pub fn radiance(albedo: f32, irradiance: f32) -> f32 {
    albedo * irradiance / PI
}
