//! The player as a program: pictures, statistics, exit codes.

mod program;

use std::path::Path;

use engine::scene::{Motion, Scene, Switching, Transform};
use glam::{DQuat, DVec3};
use program::*;

#[test]
fn the_same_scene_gives_the_same_pictures_and_motion_gives_others() {
    if !can_draw() {
        return;
    }
    let mut scene = scene();
    let switching = Switching { period: 0.4, on_share: 0.5, offset: 0.0 };
    scene.entities[1].light.as_mut().unwrap().switching = Some(switching);
    let folder = project(&scene, Some(&floor()));
    let draw = |out: &str| {
        let out = folder.path().join(out);
        let stats = out.with_extension("json");
        let args = ["--headless", "--frames", "5", "--size", "96x64", "--every", "2", "--fixed-dt", "0.1"];
        let places = ["--out", out.to_str().unwrap(), "--stats", stats.to_str().unwrap()];
        let output = play(folder.path(), &[&args[..], &places[..]].concat());
        assert!(output.status.success(), "{}", error_of(&output));
        let names: Vec<String> = ["00000", "00002", "00004"].map(|n| format!("frame_{n}.png")).to_vec();
        let pictures: Vec<Vec<u8>> = names.iter().map(|n| std::fs::read(out.join(n)).unwrap()).collect();
        assert_eq!(std::fs::read_dir(&out).unwrap().count(), 3);
        (pictures, std::fs::read_to_string(stats).unwrap())
    };
    let (once, stats) = draw("once");
    let (again, _) = draw("again");
    assert_eq!(once, again);
    assert_ne!(once[0], once[1]);
    let mean = |png: &[u8]| {
        let picture = image::load_from_memory(png).unwrap().to_rgb8();
        picture.pixels().map(|pixel| f64::from(pixel.0[0])).sum::<f64>()
    };
    assert!(mean(&once[0]) > 10.0 * mean(&once[1]), "the light is off after 0.2 s");
    assert!(mean(&once[2]) > 10.0 * mean(&once[1]), "and on again after 0.4 s");

    let stats: serde_json::Value = serde_json::from_str(&stats).unwrap();
    assert_eq!(stats["frames"], 5);
    assert_eq!(stats["patches"], 1);
    assert_eq!(stats["dispatches"].as_array().unwrap().len(), 5);
    assert!(stats["passes"]["surface"]["median_ms"].as_f64().unwrap() > 0.0);
    assert!(stats["bytes"]["shadow maps"].as_u64().unwrap() > 0);
    let lit = image::load_from_memory(&once[0]).unwrap().to_rgb8();
    assert!(lit.pixels().any(|pixel| pixel.0[0] > 60), "the floor is lit");
}

#[test]
fn what_stands_still_costs_no_transport_after_it_is_solved() {
    if !can_draw() {
        return;
    }
    let mut still = scene();
    still.entities[2].motion = None;
    let folder = project(&still, Some(&floor()));
    let stats = folder.path().join("stats.json");
    let args = ["--headless", "--frames", "4", "--size", "32x32", "--stats", stats.to_str().unwrap()];
    assert!(play(folder.path(), &args).status.success());
    let stats: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(stats).unwrap()).unwrap();
    assert_eq!(stats["dispatches"][3], 0, "{stats:#}");
    assert_eq!(stats["shadow_draws"][3], 0);
}

#[test]
fn scenes_without_light_camera_or_geometry_are_played() {
    if !can_draw() {
        return;
    }
    let mut dark = scene();
    dark.entities.retain(|entity| entity.light.is_none() && entity.camera.is_none());
    for (scene, bake) in [(Scene::default(), None), (dark, Some(floor()))] {
        let folder = project(&scene, bake.as_ref());
        let output = play(folder.path(), &["--headless", "--frames", "2", "--size", "32x32"]);
        assert!(output.status.success(), "{}", error_of(&output));
    }
}

#[test]
fn wrong_usage_is_2_and_says_what_is_right() {
    let nowhere = Path::new("nowhere");
    let wrong: [(&[&str], &str); 8] = [
        (&["--vsync", "perhaps"], "on or off"),
        (&["--view", "wonderful"], "composite, direct"),
        (&["--size", "0x10"], "1280x720"),
        (&["--frames", "0"], "frames"),
        (&["--every", "0"], "every"),
        (&["--products", "0"], "products"),
        (&["--fixed-dt", "-1"], "0 or more"),
        (&["--wings"], "--wings"),
    ];
    for (args, said) in wrong {
        let output = play(nowhere, args);
        assert_eq!(output.status.code(), Some(2), "{args:?}");
        assert!(error_of(&output).contains(said), "{args:?}: {}", error_of(&output));
    }
    let output = play(nowhere, &["--headless"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(error_of(&output).contains("nowhere"));
}

#[test]
fn statistics_are_written_though_the_device_is_lost_midway() {
    if !can_draw() {
        return;
    }
    let folder = project(&scene(), Some(&floor()));
    let file = folder.path().join("deep/stats.json");
    let mut program = std::process::Command::new(env!("CARGO_BIN_EXE_hohlraum-play"));
    program.arg(folder.path()).args(["--headless", "--frames", "5", "--size", "32x32", "--stats"]).arg(&file);
    let output = program.env("HOHLRAUM_LOSE_DEVICE", "2").output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(error_of(&output).contains("lost"), "{}", error_of(&output));
    let stats: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(file).unwrap()).unwrap();
    assert_eq!((&stats["frames"], &stats["patches"]), (&2.into(), &1.into()));
    assert!(stats["failed"].as_str().unwrap().contains("lost"));
    assert_eq!(stats["draws"].as_array().unwrap().len(), 2);
}

/// A camera that goes along a path over the floor, looking where it goes.
#[test]
fn a_camera_with_a_path_walks_through_the_scene() {
    if !can_draw() {
        return;
    }
    let mut scene = scene();
    let camera = &mut scene.entities[3];
    let points = vec![DVec3::new(0.0, 1.0, 8.0), DVec3::new(0.0, 1.0, 2.0)];
    camera.motion = Some(Motion::PingPong { points, seconds: 2.0, look: true });
    camera.transform = Transform { rotation: DQuat::from_rotation_y(2.0), ..Transform::default() };
    let folder = project(&scene, Some(&floor()));
    // Of the picture, the share that the floor and the cube cover grows.
    let seen = |frames: &str| {
        let args = ["--frames", frames, "--fixed-dt", "0.5", "--size", "64x64", "--view", "albedo"];
        picture(folder.path(), &args).pixels().filter(|pixel| pixel.0[0] > 0).count()
    };
    let (far, near) = (seen("1"), seen("3"));
    assert!(far > 20 && near > 3 * far, "{far} {near}");
}

#[test]
fn exposure_is_two_to_the_stops_whatever_the_camera_does() {
    if !can_draw() {
        return;
    }
    let mut scene = scene();
    scene.entities.retain(|entity| entity.name != "cube");
    let radiance = glam::Vec3::splat(0.1);
    scene.sky.kind = engine::scene::SkyKind::Constant { radiance };
    let looked_at_with = |auto: bool, args: &[&str]| {
        let mut scene: Scene = scene.clone();
        let camera = scene.entities.last_mut().unwrap().camera.as_mut().unwrap();
        camera.auto_exposure = auto.then(Default::default);
        let folder = project(&scene, Some(&floor()));
        // The upper corner shows the sky.
        picture(folder.path(), &[args, &["--size", "64x64"]].concat()).get_pixel(1, 1).0[0]
    };
    let encoded = |light: f64| (255.0 * (1.055 * light.powf(1.0 / 2.4) - 0.055)).round() as u8;
    for auto in [false, true] {
        assert_eq!(looked_at_with(auto, &["--exposure", "1"]), encoded(0.2));
        assert_eq!(looked_at_with(auto, &["--exposure", "-2.5"]), encoded(0.1 * 2f64.powf(-2.5)));
    }
    assert_eq!(looked_at_with(false, &[]), encoded(0.1));
    assert!(looked_at_with(true, &[]) > encoded(0.1), "a dark scene is brightened");
}

#[test]
fn the_overlay_is_there_when_asked_for_and_read_on_black_and_on_white() {
    if !can_draw() {
        return;
    }
    for radiance in [0.0, 100.0] {
        let mut scene = Scene::default();
        scene.sky.kind = engine::scene::SkyKind::Constant { radiance: glam::Vec3::splat(radiance) };
        let folder = project(&scene, None);
        let plain = picture(folder.path(), &["--size", "320x200"]);
        assert_eq!(plain.get_pixel(20, 20), plain.get_pixel(310, 190), "nothing is written");
        let written = picture(folder.path(), &["--size", "320x200", "--overlay"]);
        // The first line names scene and view.
        let line: Vec<u8> = (6..24)
            .flat_map(|y| (6..160).map(move |x| (x, y)))
            .map(|(x, y)| written.get_pixel(x, y).0[0])
            .collect();
        let (bright, dark) =
            (line.iter().filter(|&&v| v > 200).count(), line.iter().filter(|&&v| v < 110).count());
        assert!(
            bright > 150 && dark > 1000 && bright + dark == line.len(),
            "{bright} {dark} of {}",
            line.len()
        );
    }
}

/// Space, index and rgb of every line of a `--light` file.
fn light_of(path: &Path) -> Vec<(String, usize, [f32; 3])> {
    let text = std::fs::read_to_string(path).unwrap();
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("space,index,r,g,b"));
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        let number = |k: usize| cells[k].parse::<f32>().unwrap();
        (cells[0].to_owned(), cells[1].parse().unwrap(), [number(2), number(3), number(4)])
    };
    lines.map(row).collect()
}

#[test]
fn the_light_of_the_gpu_is_written_when_asked_for() {
    if !can_draw() {
        return;
    }
    let folder = project(&without_cube(), Some(&floor()));
    let file = folder.path().join("deep/light.csv");
    let args = ["--frames", "3", "--size", "32x32", "--light", file.to_str().unwrap()];
    plays(folder.path(), &args);
    let light = light_of(&file);
    let of = |space: &str| light.iter().filter(|row| row.0 == space).collect::<Vec<_>>();
    // Of the lamp's 10 W/sr the floor gets its solid angle over its area, and reflects half; nothing comes back.
    let corner = |a: f32, b: f32| (a * b / (2.0 * (a * a + b * b + 4.0).sqrt())).atan();
    let lit = 0.5 * 10.0 * (corner(3.0, 3.0) + 2.0 * corner(3.0, 1.0) + corner(1.0, 1.0)) / 16.0;
    for space in ["exitance", "radiosity"] {
        let rows = of(space);
        assert_eq!((rows.len(), rows[0].1), (1, 0), "{space}");
        assert!(rows[0].2.iter().all(|value| (value / lit - 1.0).abs() < 1e-4), "{space}: {rows:?} {lit}");
    }
    assert_eq!(of("irradiance")[0].2, [0.0; 3], "a floor sees no patch");
    assert_eq!(of("irradiance").len() + 2, light.len(), "the bake has no probes: {light:?}");
}

fn without_cube() -> Scene {
    let mut scene = scene();
    scene.entities.retain(|entity| entity.name != "cube");
    scene
}

#[test]
fn light_is_passed_on_so_often_as_is_said() {
    if !can_draw() {
        return;
    }
    let folder = project(&without_cube(), Some(&floor()));
    let stats = folder.path().join("stats.json");
    let products = |args: &[&str]| {
        let own = ["--frames", "3", "--size", "32x32", "--stats", stats.to_str().unwrap()];
        plays(folder.path(), &[&own[..], args].concat());
        let stats: serde_json::Value =
            serde_json::from_str(&std::fs::read_to_string(&stats).unwrap()).unwrap();
        stats["products"].clone()
    };
    assert_eq!(products(&["--products", "5"]), serde_json::json!([5, 5, 5]));
    assert_eq!(products(&[])[2], 0, "what is solved is left alone");
}

#[test]
fn a_scene_that_is_held_still_is_lit_as_if_there_were_nothing_that_moves() {
    if !can_draw() {
        return;
    }
    let lit = |scene: &Scene, args: &[&str]| {
        let folder = project(scene, Some(&floor()));
        let file = folder.path().join("light.csv");
        let own = ["--frames", "3", "--size", "32x32", "--light", file.to_str().unwrap()];
        plays(folder.path(), &[&own[..], args].concat());
        light_of(&file).into_iter().find(|row| row.0 == "exitance").unwrap().2
    };
    let alone = lit(&without_cube(), &[]);
    assert_ne!(lit(&scene(), &[]), alone, "the cube stands in the lamp's way");
    assert_eq!(lit(&scene(), &["--still"]), alone);
}
