//! Scripted light: one lamp or sun that a script puts into the scene's own box, alone, sixty frames a second.
//!
//! The scene's lights and emitters are off, so that what is late is late against nothing else. E of every frame comes
//! from the direct light at patches as the runtime has it: the same samples, the same shadow rays, the same formula.

use std::f32::consts::PI;

use engine::scene::{EntityId, Light, LightKind};
use engine::transport::direct::PlacedLight;
use glam::{Vec3, vec3};

use super::lit::Lit;

/// What shines in each frame; light changes are of the kind that `moves`, or jumps.
pub struct Script {
    pub name: &'static str,
    pub moves: bool,
    /// By frame, what shines; none in the dark.
    pub frames: Vec<Option<PlacedLight>>,
    /// Whether light is solved before the first frame, or it was dark.
    pub begins_solved: bool,
}

/// Frames before those that count.
pub const WARM: usize = 4;
/// Of a crossing, and of the sun's way.
const STEPS: usize = 40;
/// Frames of a flicker of 10 Hz: as many on as off.
const HALF_PERIOD: usize = 3;

/// The box of all that is baked, where lamps go about.
struct Room {
    low: Vec3,
    high: Vec3,
}

pub fn scripts(lit: &Lit) -> Vec<Script> {
    let vertices = &lit.transport.surface.vertices;
    let low = vertices.iter().fold(Vec3::INFINITY, |low, vertex| low.min(vertex.position));
    let high = vertices.iter().fold(Vec3::NEG_INFINITY, |high, vertex| high.max(vertex.position));
    if vertices.is_empty() {
        return Vec::new();
    }
    let room = Room { low, high };
    let way = |k: usize| k as f32 / (STEPS - 1) as f32;
    let spot = |at: f32| Some(room.spot(at));
    let (near, far) = (spot(0.15), spot(0.85));
    let repeat = |light: &Option<PlacedLight>, frames: usize| vec![light.clone(); frames];
    let cycle = [repeat(&near, HALF_PERIOD), repeat(&None, HALF_PERIOD)].concat();
    let dark = repeat(&None, WARM);
    let towards = room.sunny_side(lit);
    vec![
        Script {
            name: "a spot crossing",
            moves: true,
            frames: (0..STEPS).map(|k| spot(0.1 + 0.8 * way(k))).collect(),
            begins_solved: true,
        },
        Script {
            name: "the sun moving",
            moves: true,
            frames: (0..STEPS).map(|k| Some(room.sun(way(k), towards))).collect(),
            begins_solved: true,
        },
        Script {
            name: "flicker at 10 Hz",
            moves: false,
            frames: [dark.clone(), vec![cycle; 4].concat()].concat(),
            begins_solved: false,
        },
        Script {
            name: "a teleport",
            moves: false,
            frames: [repeat(&near, WARM), repeat(&far, 10)].concat(),
            begins_solved: true,
        },
        Script {
            name: "on and off",
            moves: false,
            frames: [dark, repeat(&near, 10), repeat(&None, 10)].concat(),
            begins_solved: false,
        },
    ]
}

impl Room {
    /// From where the sun lights more: a room may be open to one side alone.
    fn sunny_side(&self, lit: &Lit) -> f32 {
        let lights = |towards: f32| -> f32 {
            let of =
                |k: u8| lit.direct(&[self.sun(f32::from(k) / 4.0, towards)]).iter().map(|h| h.x).sum::<f32>();
            (0..=4).map(of).sum()
        };
        if lights(1.0) > lights(-1.0) { 1.0 } else { -1.0 }
    }

    /// Under the ceiling, looking down; `at`: from one end of the longer side to the other.
    fn spot(&self, at: f32) -> PlacedLight {
        let size = self.high - self.low;
        let along = if size.x >= size.z { vec3(at, 0.85, 0.5) } else { vec3(0.5, 0.85, at) };
        let light = Light { kind: LightKind::Spot { inner: 0.5, outer: 0.8 }, ..white() };
        PlacedLight { entity: EntityId(0), light, position: self.low + size * along, direction: Vec3::NEG_Y }
    }

    /// From 60 degrees on one side to 60 on the other, a little from the front (`towards`: -1) or the back (1).
    fn sun(&self, at: f32, towards: f32) -> PlacedLight {
        let angle = (at - 0.5) * (2.0 * PI / 3.0);
        let direction = vec3(angle.sin(), -angle.cos(), 0.4 * towards).normalize();
        let light = Light { kind: LightKind::Sun, ..white() };
        PlacedLight { entity: EntityId(0), light, position: self.high, direction }
    }
}

fn white() -> Light {
    Light { color: Vec3::ONE, intensity: 1.0, range: None, ..Light::default() }
}
