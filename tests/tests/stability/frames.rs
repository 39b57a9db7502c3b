//! Frame after frame: steps, switches, flicker, and a million frames of nothing. Cases 29 to 32 of the catalogue.

use engine::scene::{LightKind, Scene};
use engine::transport::solve::{self, Coarse, TwoLevel};
use glam::{DVec3, Vec3};
use tests::enclosure::{furnished, paint, project};
use tests::repeats::run;
use tests::room::light;
use tests::runtime::Runtime;
use tests::solution::{Solved, apart, largest, narrow, solved, wide};

/// Half the distance from 1 to the next float.
const U32: f64 = 6e-8;

fn room(albedo: f32) -> Solved {
    solved(&project(&furnished()), 0.3, 256).again(|scene| lamp(scene, albedo, 1.0, None))
}

/// A lamp without shadows in a room of this albedo; it may shine into no more than a range.
fn lamp(scene: &mut Scene, albedo: f32, intensity: f32, range: Option<f32>) {
    paint(scene, albedo, 0.0);
    let mut lamp =
        light(100, LightKind::Point, intensity, DVec3::new(0.5, 0.8, 0.3), DVec3::new(0.4, 0.0, 0.6));
    let shining = lamp.light.as_mut().expect("a light");
    (shining.range, shining.casts_shadows) = (range, false);
    scene.entities.retain(|entity| entity.id != lamp.id);
    scene.entities.push(lamp);
}

/// One product in f32, with the coarse correction or without it.
fn step(room: &Solved, coarse: &Coarse, e: &[Vec3], b: &mut [Vec3]) {
    TwoLevel { system: &room.system(), coarse }.step(e, b);
}

/// The solution for this E, in f64.
fn exact(room: &Solved, e: &[Vec3]) -> Vec<DVec3> {
    solve::exact(&room.system(), &wide(e), 1e-12)
}

/// Jacobi's iteration in f32 loses 4 u w.
fn floor(room: &Solved) -> f64 {
    4.0 * U32 * room.gain()
}

// Case 29.
#[test]
fn when_a_million_times_the_light_comes_jacobi_climbs_and_never_passes_it() {
    let room = room(0.9);
    let e: Vec<Vec3> = narrow(&room.e).iter().map(|e| *e * 1e6).collect();
    let wanted = exact(&room, &e);
    let (most, none) = (largest(&wanted), Coarse::default());
    let mut b = vec![Vec3::ZERO; e.len()];
    for k in 0..300 {
        let before = b.clone();
        step(&room, &none, &e, &mut b);
        // Sums of products with shares are monotone in every rounding.
        assert!(b.iter().zip(&before).all(|(b, before)| b.cmpge(*before).all()), "step {k} falls");
        let above = b.iter().zip(&wanted).map(|(b, wanted)| (b.as_dvec3() - *wanted).max_element());
        let above = above.fold(f64::NEG_INFINITY, f64::max);
        assert!(above <= floor(&room) * most, "step {k}: {above} above");
        let error = apart(&wide(&b), &wanted) / most;
        assert!(error <= f64::from(0.9_f32).powi(k) + floor(&room), "step {k}: {error}");
    }
}

// Case 29; asked for is 1e-2.
#[test]
fn when_a_million_times_the_light_comes_it_is_right_to_a_thousandth_within_ten_frames() {
    let room = room(0.9);
    let Some(mut runtime) = Runtime::new(&room) else { return };
    runtime.settle(&room.scene);
    let mut scene = room.scene.clone();
    lamp(&mut scene, 0.9, 1e6, None);
    let mut errors = Vec::new();
    for _ in 0..10 {
        runtime.frame(&scene);
        let (b, e) = (runtime.radiosity(), runtime.exitance());
        assert!(b.iter().zip(&e).all(|(b, e)| b.is_finite() && b.cmpge(*e).all()), "B >= E");
        let wanted = exact(&room, &e);
        errors.push(apart(&wide(&b), &wanted) / largest(&wanted));
    }
    println!("{errors:?}");
    assert!(errors[9] <= 1e-3, "{errors:?}");
}

// Case 30.
#[test]
fn when_the_light_goes_jacobi_falls_by_the_albedo_and_two_levels_are_dark_within_ten_frames() {
    let room = room(0.95);
    let (e, most) = (vec![Vec3::ZERO; room.b.len()], largest(&room.b));
    let share = |b: &[Vec3]| largest(&wide(b)) / most;
    let mut b = narrow(&room.b);
    for k in 1..=200 {
        step(&room, &Coarse::default(), &e, &mut b);
        assert!(share(&b) <= f64::from(0.95_f32).powi(k) * (1.0 + 1e-5), "step {k}: {}", share(&b));
    }
    println!("Jacobi after 200: {:.1e}", share(&b));
    let coarse = Coarse::new(&room.system());
    let mut b = narrow(&room.b);
    (0..10).for_each(|_| step(&room, &coarse, &e, &mut b));
    println!("two levels after 10: {:.1e}", share(&b));
    assert!(share(&b) <= 1e-3, "{}", share(&b));
}

// Case 30. A lamp that is off is known to leave nothing; here it shines on into a millimetre of air.
#[test]
fn when_the_light_goes_a_thousandth_is_left_after_ten_frames_and_in_the_end_nothing() {
    let room = room(0.95);
    let Some(mut runtime) = Runtime::new(&room) else { return };
    runtime.settle(&room.scene);
    let before = largest(&wide(&runtime.radiosity()));
    let mut scene = room.scene.clone();
    lamp(&mut scene, 0.95, 1.0, Some(1e-3));
    (0..10).for_each(|_| _ = runtime.frame(&scene));
    let left = largest(&wide(&runtime.radiosity())) / before;
    println!("{left:.1e} is left");
    assert!(left <= 1e-3, "{left}");
    runtime.settle(&scene);
    assert!(runtime.radiosity().iter().chain(&runtime.gathered()).all(|light| *light == Vec3::ZERO));
    assert_eq!(runtime.frame(&scene).transport_dispatches, 0);
}

/// Units in the last place of the largest.
fn ulps(a: &[DVec3], b: &[DVec3], ulp: impl Fn(f64) -> f64) -> f64 {
    apart(a, b) / ulp(largest(b))
}

fn ulp_of_f32(x: f64) -> f64 {
    f64::from((x as f32).next_up()) - f64::from(x as f32)
}

// Case 31. Nothing but B goes into the next B: once a state comes back, a million frames are known to the last bit.
#[test]
fn a_million_frames_of_still_light_do_not_drift() {
    let room = room(0.95);
    let e = narrow(&room.e);
    for (name, coarse) in [("Jacobi", Coarse::default()), ("two levels", Coarse::new(&room.system()))] {
        let run = run(vec![Vec3::ZERO; e.len()], |b: &mut Vec<Vec3>| step(&room, &coarse, &e, b));
        let [early, late] = [1000, 1_000_000].map(|frame| wide(run.after(frame)));
        let drift = ulps(&early, &late, ulp_of_f32);
        println!("{name}, f32: {} states, then {} for ever: {drift} ulp", run.states.len(), run.period());
        assert!(drift <= 2.0, "{name}: {drift} ulp");
        assert!(apart(&late, &room.b) <= floor(&room) * largest(&room.b), "{name}");
    }
    // In f64, by the product that the CPU's solver makes.
    let run = run(vec![DVec3::ZERO; e.len()], |b: &mut Vec<DVec3>| {
        let h = solve::gather(&room.transport.patch_from_patch, b);
        let next = (0..b.len()).map(|i| room.e[i] + room.albedo[i].as_dvec3() * h[i]).collect();
        *b = next;
    });
    let drift = ulps(run.after(1000), run.after(1_000_000), |x| x.next_up() - x);
    println!("Jacobi, f64: {} states, then {} for ever: {drift} ulp", run.states.len(), run.period());
    assert!(drift <= 2.0, "{drift} ulp");
    assert!(apart(run.after(1_000_000), &room.b) <= 1e-10 * largest(&room.b));
}

/// How far B moves between two frames [of the largest B] that have the same light and are never at rest: the lamp's range
/// changes in each, but reaches all there is. Then they rest, and it stays what it is.
fn drift_on_the_gpu(room: &Solved, albedo: f32, frames: [usize; 2]) -> Option<f64> {
    let mut runtime = Runtime::new(room)?;
    let mut scene = room.scene.clone();
    let mut states = Vec::new();
    for frame in 1..=frames[1] {
        lamp(&mut scene, albedo, 1.0, Some(1e6 + frame as f32));
        assert!(runtime.frame(&scene).products > 0, "frame {frame} is at rest");
        if frames.contains(&frame) {
            states.push(wide(&runtime.radiosity()));
        }
    }
    runtime.settle(&scene);
    let still = runtime.radiosity();
    (0..3).for_each(|_| _ = runtime.frame(&scene));
    assert_eq!(runtime.radiosity(), still);
    Some(apart(&states[0], &states[1]) / largest(&states[1]))
}

// Case 31: with a gain below 4 the runtime makes Jacobi's products alone.
#[test]
fn frames_of_still_light_do_not_drift_on_the_gpu() {
    let room = room(0.7);
    assert!(room.gain() < 4.0);
    let Some(drift) = drift_on_the_gpu(&room, 0.7, [150, 300]) else { return };
    println!("{drift:.1e} of the largest");
    assert!(drift <= 2.0 * f64::from(f32::EPSILON), "{drift:e}");
}

// Case 31. The coarse correction takes what rounding leaves in each product for light that is lacking, and multiplies it
// by the gain of whole aggregates: a state is known to 4 u w, about 5e-6, and two of them may be that far apart. That is
// the same after a thousand frames as after any.
#[test]
fn a_thousand_frames_of_still_light_in_a_bright_room_stay_where_rounding_leaves_them() {
    let room = room(0.95);
    let Some(drift) = drift_on_the_gpu(&room, 0.95, [500, 1000]) else { return };
    println!("{drift:.1e} of the largest, of {:.1e}", floor(&room));
    assert!(drift <= floor(&room), "{drift:e}");
}

// Case 32: a hundred thousand frames and all after them, as for the million of still light. Jacobi is monotone, and
// stays below. Two levels are not: a correction lifts whole aggregates, and some of their patches too far. No norm bounds
// that below 1, but every state that ever occurs is looked at here: with two products a frame a twentieth is not
// reached. The runtime makes more of them while light flickers, and stays within a thousandth (below).
#[test]
fn light_that_flickers_for_ever_never_gives_more_than_light_that_stays() {
    let room = room(0.95);
    let (on, off) = (narrow(&room.e), vec![Vec3::ZERO; room.e.len()]);
    let most = largest(&room.b);
    let two_levels = Coarse::new(&room.system());
    let ways = [("Jacobi", Coarse::default(), 1, 0.0), ("two levels", two_levels, 2, 0.05)];
    for (name, coarse, products, bound) in ways {
        let mut highest = 0.0_f64;
        let run = run(narrow(&room.b), |b: &mut Vec<Vec3>| {
            for e in [&off, &on] {
                (0..products).for_each(|_| step(&room, &coarse, e, b));
                assert!(b.iter().zip(e).all(|(b, e)| b.is_finite() && b.cmpge(*e).all()), "B >= E");
                let above = b.iter().zip(&room.b).map(|(b, most)| (b.as_dvec3() - *most).max_element());
                highest = highest.max(above.fold(f64::NEG_INFINITY, f64::max) / most);
            }
        });
        println!("{name}: {} states, then {} for ever; {highest:+.1e} above", run.states.len(), run.period());
        assert!(highest <= bound + floor(&room), "{name}: {highest}");
    }
}

// Case 32 on the GPU.
#[test]
fn light_that_flickers_on_the_gpu_never_gives_more_than_light_that_stays() {
    let room = room(0.95);
    let Some(mut runtime) = Runtime::new(&room) else { return };
    runtime.settle(&room.scene);
    let most = largest(&exact(&room, &runtime.exitance()));
    let mut scene = room.scene.clone();
    for frame in 0..300 {
        // Not quite off, which would be known to be dark.
        lamp(&mut scene, 0.95, [1e-3, 1.0][frame % 2], None);
        runtime.frame(&scene);
        let now = largest(&wide(&runtime.radiosity()));
        assert!(now <= most * 1.001, "frame {frame}: {now} of {most}");
    }
}
