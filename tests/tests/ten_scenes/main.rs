//! Ten scenes, each without something: what is left out of each is known by heart, shows in its file, on the GPU and in
//! its frames, and in no picture.

mod played;

use std::sync::Arc;

use engine::scene::{Feature, Forced};
use glam::Vec3;
use played::{Played, play, project};
use tests::picture::gpu;
use tests::ten;

fn apart(a: &[Vec3], b: &[Vec3]) -> f32 {
    let brightest = a.iter().map(|a| a.max_element()).fold(0.0, f32::max);
    a.iter().zip(b).map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f32::max) / brightest
}

#[test]
fn table() {
    let Some(_gpu) = gpu() else { return };
    let only = std::env::var("ONLY").unwrap_or_default();
    for (name, scene) in ten::all().into_iter().filter(|(name, _)| name.contains(&only)) {
        let project = project(&scene);
        let played = play(&Arc::new(gpu().unwrap()), &project, &[]);
        println!("== {name}");
        for v in &played.needs.verdicts {
            println!("   {:?} {} {} | {:?}", v.feature, v.is_in, v.why, v.saving);
        }
        println!(
            "   sections {:?}\n   bytes {:?}\n   pipelines {:?}\n   moving {:?}\n   steady {:?}\n   captures {} sky {}",
            played.sections,
            played.bytes,
            played.pipelines,
            played.moving,
            played.steady,
            played.captures,
            played.sky_patches
        );
        let all: Vec<_> = Feature::ALL.into_iter().map(|f| (f, Forced::In)).collect();
        let full = play(&Arc::new(gpu().unwrap()), &project, &all);
        println!(
            "   forced in: bytes {:?}\n   sections {:?}\n   pipelines {:?}\n   moving {:?}\n   steady {:?} captures {}",
            full.bytes, full.sections, full.pipelines, full.moving, full.steady, full.captures
        );
        println!("   apart {}", apart(&full.picture, &played.picture));
    }
}
