//! What frames do, on the CPU: the runtime's choice of method, its iteration in f32 with all channels at once, and its
//! rule of how many products light needs. The plain twin of the GPU's bounce.

use engine::transport::solve::{Choice, Coarse, Method, System, TwoLevel, choose_for_frames};
use engine::transport::steering::{Measured, Steering};
use glam::{DVec3, Vec3};

/// The method, prepared once for an albedo.
pub struct Runtime<'a> {
    pub choice: Choice,
    pub gain: f32,
    system: &'a System<'a>,
    coarse: Coarse,
}

/// Frames after which light that stands still is as solved as it gets.
const FRAMES: usize = 200;

impl<'a> Runtime<'a> {
    /// `gain`: the largest cavity gain.
    pub fn new(system: &'a System<'a>, gain: f64) -> Self {
        let choice = choose_for_frames(system.rows, system.patches, gain);
        let corrected = choice.method == Method::TwoLevel;
        let coarse = if corrected { Coarse::new(system) } else { Coarse::default() };
        Self { choice, gain: gain as f32, system, coarse }
    }

    /// Products of the first frame, from darkness.
    pub fn first(&self) -> u32 {
        Steering::default().products(self.gain, &self.choice)
    }

    /// So many products; measured is the light before the last.
    pub fn frame(&self, e: &[Vec3], b: &mut [Vec3], products: u32, version: u64) -> Measured {
        let iteration = TwoLevel { system: self.system, coarse: &self.coarse };
        let mut measured = Measured {
            version,
            products,
            residual: f32::INFINITY,
            largest: largest(b),
            exitance: largest(e),
        };
        for _ in 0..products {
            measured.largest = largest(b);
            measured.residual = iteration.step(e, b);
        }
        measured
    }

    /// What light that stands still ends with: products by the rule, frame after frame, until it asks for none.
    pub fn settled(&self, e: &[DVec3]) -> Vec<DVec3> {
        let e: Vec<Vec3> = e.iter().map(|e| e.as_vec3()).collect();
        let mut b = e.clone();
        let mut steering = Steering::default();
        for _ in 0..FRAMES {
            let products = steering.products(self.gain, &self.choice);
            if products == 0 {
                break;
            }
            steering.receive(self.frame(&e, &mut b, products, steering.version()));
        }
        b.iter().map(|b| b.as_dvec3()).collect()
    }
}

fn largest(values: &[Vec3]) -> f32 {
    values.iter().fold(0.0, |max, value| max.max(value.max_element()))
}
