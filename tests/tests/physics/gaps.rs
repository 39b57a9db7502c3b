//! A lamp that hangs a little below its ceiling: what its back takes of the light of a white room, against photons that are
//! followed one by one, in boxes and by nothing of the product.

use std::f64::consts::{PI, TAU};

use engine::transport::Transport;
use glam::{DVec3, Vec3};
use tests::enclosure::{Wall, project, room};
use tests::solved::{Solved, settings};
use tests::surfaces::quad;

const SIZE: DVec3 = DVec3::new(4.0, 1.0, 1.0);
const ALBEDO: f64 = 0.9;
/// Of the lamp, along x and z, and its height: 2 cm are left above it.
const LAMP: [f64; 2] = [0.3, 0.7];
const HEIGHT: f64 = 0.98;

/// Of what the lamp gives: what falls on its front, and what on its back.
#[derive(Debug)]
struct Shares {
    front: f64,
    back: f64,
}

/// Numbers from 0 to 1 (xorshift64*, Vigna 2016).
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// About an axis, by the cosine.
    fn direction(&mut self, axis: usize, side: f64) -> DVec3 {
        let (u, turn) = (self.next(), TAU * self.next());
        let mut direction = DVec3::ZERO;
        direction[axis] = side * (1.0 - u).sqrt();
        direction[(axis + 1) % 3] = u.sqrt() * turn.cos();
        direction[(axis + 2) % 3] = u.sqrt() * turn.sin();
        direction
    }
}

/// Where a photon is, and the axis and side that it leaves along.
struct Photon {
    at: DVec3,
    axis: usize,
    side: f64,
}

impl Photon {
    fn of_the_lamp(numbers: &mut Numbers) -> Self {
        let mut along = || LAMP[0] + (LAMP[1] - LAMP[0]) * numbers.next();
        Self { at: DVec3::new(along(), HEIGHT, along()), axis: 1, side: -1.0 }
    }

    /// Goes to the wall that it meets, or says which side of the lamp it meets before.
    fn fly(&mut self, numbers: &mut Numbers) -> Option<f64> {
        let direction = numbers.direction(self.axis, self.side);
        let to_wall = |axis: usize| match direction[axis] {
            d if d > 0.0 => (SIZE[axis] - self.at[axis]) / d,
            d if d < 0.0 => -self.at[axis] / d,
            _ => f64::INFINITY,
        };
        let axis = (0..3).min_by(|&a, &b| to_wall(a).total_cmp(&to_wall(b))).unwrap_or(0);
        let to_lamp = (HEIGHT - self.at.y) / direction.y;
        let on_lamp = self.at + direction * to_lamp;
        let within = |x: f64| (LAMP[0]..LAMP[1]).contains(&x);
        if to_lamp > 1e-9 && to_lamp < to_wall(axis) && within(on_lamp.x) && within(on_lamp.z) {
            return Some(-direction.y.signum());
        }
        self.at += direction * to_wall(axis);
        self.side = -direction[axis].signum();
        self.at[axis] = if self.side < 0.0 { SIZE[axis] } else { 0.0 };
        self.axis = axis;
        None
    }
}

fn counted(photons: u32) -> Shares {
    let mut numbers = Numbers(0x9e37_79b9_7f4a_7c15);
    let [mut front, mut back] = [0_u32; 2];
    for _ in 0..photons {
        let mut photon = Photon::of_the_lamp(&mut numbers);
        loop {
            match photon.fly(&mut numbers) {
                Some(side) if side < 0.0 => front += 1,
                Some(_) => back += 1,
                None if numbers.next() < ALBEDO => continue,
                None => {}
            }
            break;
        }
    }
    Shares { front: f64::from(front) / f64::from(photons), back: f64::from(back) / f64::from(photons) }
}

fn baked(length: f64) -> Shares {
    let mut walls = room(Vec3::ZERO, SIZE.as_vec3());
    walls.iter_mut().for_each(|wall| wall.albedo = Vec3::splat(ALBEDO as f32));
    let side = (LAMP[1] - LAMP[0]) as f32;
    let corner = Vec3::new(LAMP[0] as f32, HEIGHT as f32, LAMP[0] as f32);
    let mut lamp = Wall::new("lamp", quad(corner, Vec3::X * side, Vec3::Z * side));
    (lamp.albedo, lamp.exitance) = (Vec3::ZERO, Vec3::splat(PI as f32));
    walls.push(lamp);
    let light = Solved::of(&project(&walls), &settings(length, 1024));
    let transport: &Transport = &light.transport;
    let (of, h) = (tests::surfaces::entities(transport), light.irradiance());
    let is_lamp = |i: usize| of[i] == walls.len() as u64;
    let sum = |of: &dyn Fn(usize) -> f64| (0..light.patches()).map(|i| light.area(i) * of(i)).sum::<f64>();
    let given = sum(&|i| light.materials.exitance[i].as_dvec3().x);
    Shares {
        front: sum(&|i| if is_lamp(i) { h[i].x } else { 0.0 }) / given,
        back: sum(&|i| light.b()[i].x * (1.0 - f64::from(transport.patches[i].target))) / given,
    }
}

#[test]
fn the_back_of_a_lamp_takes_what_comes_in_under_its_edges_and_no_more() {
    let photons = 1_000_000;
    let counted = counted(photons);
    let noise = |share: f64| (share / f64::from(photons)).sqrt();
    for length in [0.3, 0.2, 0.12] {
        let found = baked(length);
        println!("{length} m: {found:?}, counted {counted:?}");
        // 5 %: patches that are longer than light takes to change, and the noise of their rows. Patches that spread the light
        // under the whole lamp take a quarter too much.
        for (found, counted) in [(found.back, counted.back), (found.front, counted.front)] {
            let limit = 0.05 * counted + 4.0 * noise(counted);
            assert!((found - counted).abs() <= limit, "{length} m: {found} against {counted}");
        }
    }
}
