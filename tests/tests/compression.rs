//! Receivers' rows as cuts through a tree over the patches: what it saves, and what it costs in light.

use bake::compress::{CutRows, cut_rows, deviations, marked, one_ray};
use bake::{Settings, Silent, bake};
use engine::scene::file::load_scene;
use engine::scene::import::load_assets;
use engine::transport::packed::{fold, pack, pack_all, unpack};
use engine::transport::solve::{System, exact, gather};
use engine::transport::{Rows, Transport, materials};
use glam::{DVec3, Vec3};
use tests::project::TestProject;
use tests::source::workspace;

struct Box {
    transport: Transport,
    /// By patch.
    marked: Vec<bool>,
    /// Radiosity of all columns, by light.
    lit: Vec<(&'static str, Vec<DVec3>)>,
}

/// 500 patches, 2000 patches [m].
const COARSE: f64 = 0.062;
const MIDDLE: f64 = 0.031;

fn cornell(length: f64, rays: u32) -> Box {
    let project = TestProject::copy_of(&workspace().join("projects/cornell"));
    let settings = Settings { patch_length: Some(length), rays: Some(rays), ..Settings::default() };
    let transport = bake(project.path(), None, &settings, &Silent).unwrap().transport;
    let scene = load_scene(project.path(), "cornell").unwrap();
    let (assets, _) = load_assets(project.path(), &scene).unwrap();
    let made_of = materials::of_patches(&transport, &scene, &assets);
    let n = transport.patches.len();
    let system =
        System { rows: &transport.patch_from_patch, patches: &transport.patches, albedo: &made_of.albedo };
    let solved = |e: &dyn Fn(usize) -> DVec3| -> Vec<DVec3> {
        let mut b = exact(&system, &(0..n).map(e).collect::<Vec<_>>(), 1e-8);
        b.resize(transport.columns(), DVec3::ZERO);
        b
    };
    let on = |lit: bool| if lit { DVec3::ONE } else { DVec3::ZERO };
    let patches = &transport.patches;
    let [low, high] =
        [f32::min, f32::max].map(|pick| patches.iter().map(|patch| patch.centre.x).reduce(pick));
    let middle = 0.5 * (low.unwrap() + high.unwrap());
    let ground = patches.iter().map(|patch| patch.centre.y).fold(f32::INFINITY, f32::min);
    let on_floor = |i: usize| patches[i].normal.y > 0.9 && patches[i].centre.y < ground + 0.01;
    let spot = Vec3::new(middle, ground, low.unwrap());
    let nearest = (0..n)
        .filter(|&i| on_floor(i))
        .min_by(|&a, &b| patches[a].centre.distance(spot).total_cmp(&patches[b].centre.distance(spot)));
    let lit = vec![
        ("own light", solved(&|i| made_of.exitance[i].as_dvec3())),
        ("half the floor", solved(&|i| on(on_floor(i) && patches[i].centre.x < middle))),
        ("one patch", solved(&|i| on(Some(i) == nearest))),
    ];
    Box { marked: marked(&scene, &transport), lit, transport }
}

/// rms of the difference over receivers, as a share of the mean.
fn apart(transport: &Transport, a: &[DVec3], b: &[DVec3]) -> f64 {
    let valid = || transport.receivers.iter().zip(a.iter().zip(b)).filter(|(r, _)| r.valid > 0.5);
    let n = 3.0 * valid().count() as f64;
    let mean = valid().map(|(_, (_, b))| b.element_sum()).sum::<f64>() / n;
    let square = valid().map(|(_, (a, b))| (*a - *b).length_squared()).sum::<f64>() / n;
    square.sqrt() / mean
}

/// What cut rows miss of whole ones, by light.
fn missed(cornell: &Box, cut: &CutRows) -> Vec<f64> {
    let transport = &cornell.transport;
    let of = |b: &Vec<DVec3>| {
        apart(transport, &cut.gather(transport, b), &gather(&transport.receiver_from_patch, b))
    };
    cornell.lit.iter().map(|(_, b)| of(b)).collect()
}

/// `cargo test -p tests --test compression -- --nocapture` prints bytes against error.
fn figures(cornell: &Box) {
    let Box { transport, marked, lit } = cornell;
    let rows = &transport.receiver_from_patch;
    let names: Vec<_> = lit.iter().map(|lit| lit.0).collect();
    println!(
        "{}: {} patches, {} receivers, {:.1} entries a row, {:.2} MB; % of the mean for {names:?}",
        transport.certificate.quality,
        transport.patches.len(),
        rows.len(),
        rows.entries() as f64 / rows.len() as f64,
        rows.bytes() as f64 * 1e-6,
    );
    for in_rays in [0.25, 0.5, 0.7, 1.0, 1.4, 2.0, 4.0] {
        let cut = cut_rows(rows, transport, marked, in_rays * one_ray(transport));
        let bound = deviations(transport, rows, &cut).iter().sum::<f64>() / rows.len() as f64;
        println!(
            "  {in_rays:.2} rays: {:.1} entries a row, {:.2} MB, 1/{:.2}; {:.3?} %; sum of deviations {bound:.3}",
            cut.rows.entries() as f64 / rows.len() as f64,
            cut.bytes() as f64 * 1e-6,
            rows.entries() as f64 / cut.rows.entries() as f64,
            missed(cornell, &cut).iter().map(|error| error * 100.0).collect::<Vec<_>>(),
        );
    }
}

#[test]
fn a_third_of_a_coarse_and_half_of_a_finer_box_is_saved_for_a_quarter_percent() {
    for (length, rays, shrinks) in [(COARSE, 1024, 1.6), (MIDDLE, 2048, 2.0)] {
        let cornell = cornell(length, rays);
        figures(&cornell);
        let rows = &cornell.transport.receiver_from_patch;
        let cut = cut_rows(rows, &cornell.transport, &cornell.marked, one_ray(&cornell.transport));
        let missed = missed(&cornell, &cut);
        let shrunk = rows.entries() as f64 / cut.rows.entries() as f64;
        assert!(shrunk > shrinks, "{length} m: {shrunk}");
        assert!(missed[0] < 0.0025 && missed[1] < 0.006, "{length} m: {missed:?}");
    }
}

/// What is merged is mostly noise: against rows of 16 times as many rays, one bright patch comes out no worse.
#[test]
fn cut_rows_are_about_as_near_the_truth_as_whole_ones() {
    let cornell = cornell(COARSE, 1024);
    let truth = self::cornell(COARSE, 16384).transport;
    let transport = &cornell.transport;
    assert_eq!(truth.receivers, transport.receivers);
    let rows = &transport.receiver_from_patch;
    let cut = cut_rows(rows, transport, &cornell.marked, one_ray(transport));
    for ((name, b), grows) in cornell.lit.iter().zip([1.25, 1.1, 1.0]) {
        let exact = gather(&truth.receiver_from_patch, b);
        let whole = apart(transport, &gather(rows, b), &exact);
        let merged = apart(transport, &cut.gather(transport, b), &exact);
        println!("{name}: whole rows {:.3} %, cut rows {:.3} %", whole * 100.0, merged * 100.0);
        assert!(merged < grows * whole, "{name}: {merged} against {whole}");
    }
}

#[test]
fn a_furnace_stays_even() {
    let cornell = cornell(COARSE, 1024);
    let transport = &cornell.transport;
    let rows = &transport.receiver_from_patch;
    let cut = cut_rows(rows, transport, &cornell.marked, 4.0 * one_ray(transport));
    let ones = vec![DVec3::ONE; transport.columns()];
    for (row, h) in cut.gather(transport, &ones).iter().enumerate() {
        assert!((h.x - rows.sum(row)).abs() <= 1e-7, "{row}: {h}");
    }
}

/// The rows of patches stand for what receivers' were before they were folded.
#[test]
fn four_bytes_an_entry_miss_next_to_nothing() {
    let cornell = cornell(COARSE, 1024);
    let rows = &cornell.transport.patch_from_patch;
    let mut folded = Rows::default();
    for row in 0..rows.len() {
        let mut entries: Vec<(u32, f32)> = rows.row(row).collect();
        fold(&mut entries);
        let held = entries
            .iter()
            .all(|&(column, weight)| pack(column, weight).map(unpack) == Some((column, weight)));
        assert!(held, "row {row}");
        folded.push(entries);
        let lost = rows.sum(row) - folded.sum(row);
        assert!((0.0..=1e-6).contains(&lost), "row {row}: {lost}");
    }
    for (name, b) in &cornell.lit {
        let (there, whole) = (gather(&folded, b), gather(rows, b));
        let square: f64 = there.iter().zip(&whole).map(|(a, b)| (*a - *b).length_squared()).sum();
        let mean = (whole.iter().map(|h| h.length_squared()).sum::<f64>() / whole.len() as f64).sqrt();
        let error = (square / whole.len() as f64).sqrt() / mean;
        println!("{name}: {error:.1e} of rms");
        // Each weight moves to one of its neighbours, at most a step of 2^-10 of itself: so does what one entry carries.
        assert!(error < if *name == "half the floor" { 1e-4 } else { 0.5_f64.powi(10) }, "{name}: {error}");
    }
    let receivers = &cornell.transport.receiver_from_patch;
    assert!(
        pack_all(&receivers.columns, &receivers.weights).is_some(),
        "the baker stores what four bytes hold"
    );
}
