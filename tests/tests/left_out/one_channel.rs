//! Light of one channel where nothing has a colour, and of three where something has: the same light.

use engine::render::rows::Summed;
use engine::render::{Asked, Channels, Drawn, Solved as Light};

use super::*;

const RED: MaterialId = MaterialId(60);

/// What is lit, how rows are summed, and what the author says.
type Way<'a> = (&'a Transport, Option<Summed>, &'a [(Feature, Forced)]);
type Edit = fn(&mut Scene);

/// Grey walls, one of which glows, a lamp, and a red ball that may move.
fn grey(transport: &Transport) -> Scene {
    let mut scene = room::scene_of(transport, |wall| Vec3::splat(0.2 + 0.1 * wall as f32));
    scene.materials.iter_mut().for_each(|material| material.roughness = 1.0);
    scene.materials[2].emission.color = Vec3::splat(0.4);
    let mut red = scene.materials[0].clone();
    (red.id, red.albedo.color) = (RED, Vec3::new(0.8, 0.1, 0.1));
    scene.materials.push(red);
    let mut ball = ball(DVec3::new(0.0, 0.9, 0.0));
    ball.mesh = Some(room::mesh(Shape::Sphere, RED.0));
    scene.entities.extend([lamp(true), ball]);
    scene
}

/// Each receiver's row in three parts, as if for a normal map.
fn with_directional_rows(mut transport: Transport) -> Transport {
    let rows = transport.receiver_from_patch.clone();
    for row in 0..rows.len() {
        for share in [0.3, -0.2, 0.1] {
            transport
                .directional_from_patch
                .push(rows.row(row).map(|(column, weight)| (column, weight * share)));
        }
    }
    transport
}

fn studio_of(gpu: Gpu, transport: &Transport, summed: Option<Summed>, asked: Asked) -> Studio {
    let eye = Eye::looking(DVec3::new(0.0, 1.0, 0.9), DVec3::new(0.0, 0.9, 0.0));
    let settings = Settings { samples: Some(1), summed, ..Settings::default() };
    let mut studio = Studio::heeding(gpu, transport.clone(), eye, [SIZE, SIZE], settings, asked);
    let source = MeshSource::Shape(Shape::Sphere);
    studio.assets.meshes.insert(source, shape::mesh(Shape::Sphere).into());
    studio
}

fn asked(said: &[(Feature, Forced)], grey: bool) -> Asked {
    Asked::new(&said.iter().copied().collect()).promising_grey(grey)
}

fn channels(studio: &Studio) -> Channels {
    studio.renderer.spaces().channels
}

fn assert_same_light(a: &Light, b: &Light, limit: f32) {
    let spaces = [
        (&a.exitance, &b.exitance),
        (&a.radiosity, &b.radiosity),
        (&a.irradiance, &b.irradiance),
        (&a.directional, &b.directional),
        (&a.probes, &b.probes),
    ];
    for (which, (a, b)) in spaces.into_iter().enumerate() {
        assert_eq!(a.len(), b.len());
        if !b.is_empty() {
            assert!(apart(a, b) < limit, "{which}: {}", apart(a, b));
        }
    }
}

#[test]
fn a_grey_scene_takes_a_quarter_of_the_light_and_as_many_dispatches_for_the_same_picture() {
    let plain = transport();
    let tilted = with_directional_rows(transport());
    let ways: [Way<'_>; 6] = [
        (&plain, None, &[]),
        (&plain, Some(Summed::ByGroup), &[]),
        (&plain, None, &[(Feature::CoarseCorrection, Forced::In)]),
        (&plain, None, &[(Feature::Columns, Forced::In)]),
        (&plain, None, &[(Feature::Columns, Forced::Out)]),
        (&tilted, None, &[]),
    ];
    for (transport, summed, said) in ways {
        let shown = |promised| {
            let mut studio = studio_of(gpu()?, transport, summed, asked(said, promised));
            let scene = grey(transport);
            let frames: Vec<Drawn> = (0..20).map(|_| studio.draw(&scene, View::Composite)).collect();
            let dispatches = frames.iter().map(|drawn| drawn.transport_dispatches).collect::<Vec<_>>();
            Some((studio.renderer.solved().unwrap(), studio.radiance(), dispatches, studio))
        };
        let Some((light, picture, dispatches, lean)) = shown(true) else { return };
        let (truth, seen, as_many, full) = shown(false).expect("a GPU");
        assert_eq!([channels(&lean), channels(&full)], [Channels::One, Channels::Three]);
        assert_eq!(dispatches, as_many, "{said:?}");
        assert_same_light(&light, &truth, 1e-5);
        assert!(apart(&picture, &seen) < 1e-3, "{}", apart(&picture, &seen));
        let bytes = |kind: &str| [lean.bytes(kind), full.bytes(kind)];
        assert_eq!(bytes("patches")[0], bytes("patches")[1]);
        let corrected = said.iter().any(|(feature, _)| *feature == Feature::CoarseCorrection);
        assert_eq!(bytes("coarse correction")[1] > 0, corrected);
        for kind in ["light", "light of probes", "coarse correction"] {
            let [one, three] = bytes(kind);
            assert!(3 * one <= three, "{kind}: {one} of {three}");
        }
        assert!(compiled(&lean, "grey") && !compiled(&full, "grey"));
    }
}

#[test]
fn colour_that_comes_in_is_seen_in_the_same_frame_and_goes_again() {
    let Some(gpu) = gpu() else { return };
    let transport = transport();
    let plain = grey(&transport);
    let mut lean = studio_of(gpu, &transport, None, asked(&[], true));
    let edits: [(Edit, Channels); 5] = [
        (|scene| scene.materials[1].albedo.color = Vec3::new(0.7, 0.2, 0.1), Channels::Three),
        (|_| (), Channels::One),
        (|scene| scene.materials[2].emission.color = Vec3::new(0.1, 0.2, 0.7), Channels::Three),
        (
            |scene| {
                let lights = scene.entities.iter_mut().filter_map(|entity| entity.light.as_mut());
                lights.for_each(|light| light.color = Vec3::new(1.0, 0.6, 0.2));
            },
            Channels::Three,
        ),
        (|scene| scene.entities.retain(|entity| entity.light.is_none()), Channels::One),
    ];
    for (which, (edit, expected)) in edits.into_iter().enumerate() {
        let mut scene = plain.clone();
        edit(&mut scene);
        lean.draw(&scene, View::Composite);
        assert_eq!(channels(&lean), expected, "edit {which}");
        lean.settle(&scene, View::Composite);
        let mut full = studio_of(tests::picture::gpu().expect("a GPU"), &transport, None, asked(&[], false));
        full.settle(&scene, View::Composite);
        let (light, truth) = (lean.renderer.solved().unwrap(), full.renderer.solved().unwrap());
        assert_same_light(&light, &truth, 2e-3);
        let [seen, fresh] = [lean.radiance(), full.radiance()];
        assert!(apart(&seen, &fresh) < 2e-3, "edit {which}: {}", apart(&seen, &fresh));
    }
}

#[test]
fn what_the_author_says_of_colour_holds_whatever_the_scene_is() {
    let Some(gpu) = gpu() else { return };
    let transport = transport();
    let mut forced_in = studio_of(gpu, &transport, None, asked(&[(Feature::Colour, Forced::In)], true));
    forced_in.settle(&grey(&transport), View::Composite);
    assert_eq!(channels(&forced_in), Channels::Three);
    let said = [(Feature::Colour, Forced::Out)];
    let mut without = studio_of(tests::picture::gpu().expect("a GPU"), &transport, None, asked(&said, false));
    let mut scene = plain(&transport);
    scene.entities.push(lamp(true));
    without.settle(&scene, View::Composite);
    assert_eq!(channels(&without), Channels::One);
    let light = without.renderer.solved().unwrap();
    assert!(light.radiosity.iter().all(|light| light.x > 0.0 && light.x == light.y && light.y == light.z));
    let mut coloured = studio_of(tests::picture::gpu().expect("a GPU"), &transport, None, asked(&[], false));
    coloured.settle(&scene, View::Composite);
    let luminance = |light: &Vec3| light.dot(Vec3::new(0.2126, 0.7152, 0.0722));
    let exitance = coloured.renderer.solved().unwrap().exitance;
    for (one, three) in light.exitance.iter().zip(&exitance) {
        assert!((one.x / luminance(three) - 1.0).abs() < 1e-4, "{one} {three}");
    }
}

#[test]
fn light_that_was_solved_is_uploaded_in_one_channel_where_it_is_grey() {
    let Some(gpu) = gpu() else { return };
    let transport = transport();
    let scene = grey(&transport);
    let mut live = studio_of(gpu, &transport, None, asked(&[], false));
    live.settle(&scene, View::Composite);
    let mut without = solved(&live, &transport);
    let truth = live.radiance();
    drop(live);
    let shown = |without: &Transport, promised| {
        let gpu = tests::picture::gpu().expect("a GPU");
        let mut studio = studio_of(gpu, without, None, asked(&[], promised));
        studio.draw(&scene, View::Composite);
        assert!(apart(&studio.radiance(), &truth) < 1e-3, "{}", apart(&studio.radiance(), &truth));
        assert_eq!(studio.draw(&scene, View::Composite).transport_dispatches, 0);
        studio
    };
    let (lean, full) = (shown(&without, true), shown(&without, false));
    assert_eq!([channels(&lean), channels(&full)], [Channels::One, Channels::Three]);
    assert_eq!(4 * lean.bytes("light"), full.bytes("light"));
    // One receiver of a little colour.
    let responses = without.solved.iter_mut().flat_map(|solved| &mut solved.responses);
    responses.for_each(|response| response.spread.receivers[1][0].x *= 1.001);
    assert_eq!(channels(&shown(&without, true)), Channels::Three);
}
