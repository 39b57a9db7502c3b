//! Ten scenes, each without something: what is left out of each is known by heart, shows in its file, on the GPU and in
//! its frames, and in no picture. Turned off by the author, a rule's omission is gone, and no other.

mod counters;
mod played;

use std::collections::BTreeSet;
use std::sync::Arc;

use engine::scene::{Feature, Forced};
use glam::Vec3;
use played::{Played, play, project};
use tests::picture::gpu;
use tests::ten;

use counters::is_gone;

/// Left out of most scenes: nothing in them asks for it. A probe out of view waits in all of them.
const PLAIN: [Feature; 9] = [
    Feature::LightProbes,
    Feature::Reflections,
    Feature::Recaptures,
    Feature::UnseenCaptures,
    Feature::Sky,
    Feature::SkyPatches,
    Feature::Directional,
    Feature::Holes,
    Feature::MaterialVariants,
];

struct Expected {
    /// Besides [`PLAIN`].
    out: &'static [Feature],
    /// Of [`PLAIN`], what is there.
    there: &'static [Feature],
    /// Rules to be turned off, one by one.
    turned_off: &'static [Feature],
}

fn expected(name: &str) -> Expected {
    use Feature::*;
    let (out, there, turned_off): (&[Feature], &[Feature], &[Feature]) = match name {
        "lights that never change" => (&[Matrix, CoarseCorrection, Columns], &[], &[Matrix]),
        "a lamp that moves" => (&[], &[], &[LightProbes]),
        "a ball that moves" => (&[], &[LightProbes], &[Reflections]),
        "grey" => (&[Matrix, CoarseCorrection, Columns, Colour], &[], &[Matrix, Colour]),
        "a mirror" => (&[BlackPatches], &[Reflections, Recaptures], &[BlackPatches]),
        "sky alone" => (&[Matrix, CoarseCorrection, Columns, ShadowMaps], &[Sky], &[Matrix]),
        "black" => (&[BlackPatches], &[], &[BlackPatches]),
        "two rooms, one lit" => (&[UnlitPatches], &[], &[UnlitPatches]),
        "a normal map" => (&[], &[Directional, MaterialVariants], &[Holes]),
        "everything" => (
            &[],
            &[LightProbes, Reflections, Recaptures, Sky, SkyPatches, Directional, Holes, MaterialVariants],
            &[],
        ),
        _ => panic!("{name}"),
    };
    Expected { out, there, turned_off }
}

impl Expected {
    fn all(&self) -> BTreeSet<Feature> {
        PLAIN.iter().filter(|feature| !self.there.contains(feature)).chain(self.out).copied().collect()
    }
}

fn left_out(played: &Played) -> BTreeSet<Feature> {
    played.needs.verdicts.iter().filter(|verdict| !verdict.is_in).map(|verdict| verdict.feature).collect()
}

/// The largest difference, in shares of the brightest pixel.
fn apart(a: &[Vec3], b: &[Vec3]) -> f32 {
    let brightest = a.iter().map(|a| a.max_element()).fold(0.0, f32::max);
    a.iter().zip(b).map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f32::max) / brightest
}

/// A device of its own for each: what it compiles is counted.
fn played(project: &tests::project::TestProject, forced: &[(Feature, Forced)]) -> Option<Played> {
    Some(play(&Arc::new(gpu()?), project, forced))
}

#[test]
fn each_scene_does_without_what_it_does_not_need_and_looks_the_same() {
    let everything = Feature::ALL.map(|feature| (feature, Forced::In));
    println!("{}", counters::HEAD);
    for (name, scene) in ten::all() {
        let (project, expected) = (project(&scene), expected(name));
        let Some(lean) = played(&project, &[]) else { return };
        let Some(full) = played(&project, &everything) else { return };
        println!("{}", counters::row(name, &lean));
        assert_eq!(left_out(&lean), expected.all(), "{name}: {:#?}", lean.needs);
        for feature in expected.all() {
            assert!(is_gone(feature, &lean, &full), "{name}: {feature:?} is there:\n{}", lean.told());
        }
        let apart = apart(&full.picture, &lean.picture);
        assert!(apart < 1e-3, "{name}: {apart}");
    }
}

#[test]
fn a_rule_that_is_turned_off_leaves_its_omission_out_and_no_other() {
    let everything = Feature::ALL.map(|feature| (feature, Forced::In));
    for (name, scene) in ten::all() {
        let (project, expected) = (project(&scene), expected(name));
        if expected.turned_off.is_empty() {
            continue;
        }
        let Some(full) = played(&project, &everything) else { return };
        for &off in expected.turned_off {
            let Some(found) = played(&project, &[(off, Forced::In)]) else { return };
            // Where there is a matrix, how it is stored and iterated is asked anew.
            let follows = |feature| {
                off == Feature::Matrix && [Feature::CoarseCorrection, Feature::Columns].contains(&feature)
            };
            let fails = |feature: &Feature| !follows(*feature) && !is_gone(*feature, &found, &full);
            let failing: Vec<Feature> = expected.all().into_iter().filter(fails).collect();
            assert_eq!(failing, [off], "{name}:\n{}", found.told());
        }
    }
}

#[test]
fn captures_that_nobody_sees_are_taken_where_the_author_wants_them() {
    let project = project(&ten::hidden_mirror());
    let Some(lean) = played(&project, &[]) else { return };
    assert!(left_out(&lean).contains(&Feature::UnseenCaptures), "{:#?}", lean.needs);
    assert_eq!((lean.moving.captures, lean.captures), (0, 0), "{}", lean.told());
    let forced = played(&project, &[(Feature::UnseenCaptures, Forced::In)]).expect("a GPU");
    assert!(forced.moving.captures > 0, "{}", forced.told());
    assert!(apart(&forced.picture, &lean.picture) < 1e-3);
}

#[test]
fn directional_rows_come_with_a_normal_map_and_go_by_the_authors_word() {
    let project = project(&ten::normal_mapped());
    let said = |forced: &[Forced]| {
        played(&project, &forced.iter().map(|forced| (Feature::Directional, *forced)).collect::<Vec<_>>())
    };
    let Some(mapped) = said(&[]) else { return };
    assert!(mapped.section("directional") > 0 && mapped.compiled("normal map"));
    let (forced_in, without) = (said(&[Forced::In]).expect("a GPU"), said(&[Forced::Out]).expect("a GPU"));
    assert_eq!(forced_in.section("directional"), mapped.section("directional"));
    assert!(apart(&forced_in.picture, &mapped.picture) < 1e-3);
    assert_eq!(without.section("directional"), 0);
    assert!(without.bytes["rows"] < mapped.bytes["rows"]);
    assert!(apart(&without.picture, &mapped.picture) > 1e-2, "bumps are seen by the rows' light");
}
