//! Playing: a copy of the scene is alive, the authored one is not touched. Leaving play drops the copy.

use std::time::Instant;

use engine::play::clock::Clock;
use engine::play::world::placed_at;
use engine::scene::Scene;
use engine::scene::assets::Assets;
use glam::DAffine3;

pub struct Play {
    pub scene: Scene,
    clock: Clock,
    last: Instant,
    /// By entity: whether its light was on when play began.
    lit: Vec<bool>,
    pub world_from_local: Vec<DAffine3>,
}

impl Play {
    pub fn of(scene: &Scene, assets: &Assets) -> Self {
        let lit = scene.entities.iter().map(|entity| entity.light.as_ref().is_some_and(|l| l.on)).collect();
        let mut play = Self {
            scene: scene.clone(),
            clock: Clock::new(None),
            last: Instant::now(),
            lit,
            world_from_local: placed_at(scene, assets, 0.0),
        };
        play.follow(assets);
        play
    }

    /// Time goes on to now.
    pub fn advance(&mut self, assets: &Assets) {
        self.clock.advance(self.last.elapsed().as_secs_f64());
        self.last = Instant::now();
        self.follow(assets);
    }

    /// Everything is where it is at this time.
    fn follow(&mut self, assets: &Assets) {
        let seconds = self.clock.time();
        for (entity, &lit) in self.scene.entities.iter_mut().zip(&self.lit) {
            let Some(light) = &mut entity.light else { continue };
            light.on = lit && light.switching.is_none_or(|switching| switching.is_on(seconds));
        }
        self.world_from_local = placed_at(&self.scene, assets, seconds);
    }

    pub fn time(&self) -> f64 {
        self.clock.time()
    }

    pub fn is_paused(&self) -> bool {
        self.clock.paused
    }

    pub fn pause(&mut self, paused: bool) {
        self.clock.paused = paused;
    }

    /// Stops, after one more picture.
    pub fn step(&mut self) {
        self.clock.step();
    }
}
