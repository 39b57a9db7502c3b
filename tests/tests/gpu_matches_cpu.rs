//! The GPU's bounce and gather against the same iteration on the CPU.

use engine::gpu::{Gpu, buffer};
use engine::render::rows::Summed;
use engine::render::{Eye, Settings, View};
use engine::scene::{Feature, Forced, LightKind, Scene};
use engine::transport::materials::of_patches;
use engine::transport::packed::fold;
use engine::transport::solve::{self, Coarse, System, TwoLevel, gather};
use engine::transport::{Probe, Transport, dering, sh};
use glam::{DVec3, Vec3, Vec4};
use tests::picture::{Studio, gpu};
use tests::room;

fn transport() -> Transport {
    room::closed_box(Vec3::new(-2.0, 0.0, -1.0), Vec3::new(2.0, 2.5, 1.0), 6)
}

/// Bright walls, a lamp, and a ceiling that glows.
fn scene(transport: &Transport) -> Scene {
    let mut scene = room::scene_of(transport, |wall| Vec3::new(0.9, 0.5 + 0.07 * wall as f32, 0.8));
    scene.materials[3].emission.color = Vec3::new(2.0, 1.0, 0.5);
    scene.entities.push(room::light(100, LightKind::Point, 4.0, DVec3::new(0.5, 1.5, 0.2), DVec3::ZERO));
    scene
}

fn eye() -> Eye {
    Eye::looking(DVec3::new(0.0, 1.0, 3.0), DVec3::new(0.0, 1.0, 0.0))
}

fn studio(gpu: Gpu, transport: Transport, summed: Summed) -> Studio {
    studio_with(gpu, transport, summed, &[])
}

fn studio_with(gpu: Gpu, transport: Transport, summed: Summed, said: &[(Feature, Forced)]) -> Studio {
    let settings = Settings { samples: Some(1), summed: Some(summed), ..Settings::default() };
    Studio::asked(gpu, transport, eye(), [16, 16], settings, said)
}

/// What lies on the GPU, the first `count`.
fn read(studio: &Studio, buffer: &wgpu::Buffer, count: usize) -> Vec<Vec3> {
    let all: Vec<Vec4> = buffer::read(studio.renderer.gpu(), buffer).unwrap();
    all[..count].iter().map(|value| value.truncate()).collect()
}

/// Largest difference, as a share of the largest value.
fn apart(a: &[Vec3], b: &[Vec3]) -> f32 {
    assert_eq!(a.len(), b.len());
    let largest = b.iter().map(|b| b.max_element()).fold(0.0, f32::max);
    assert!(largest > 0.0, "nothing is lit");
    a.iter().zip(b).map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f32::max) / largest
}

fn box_of(n: u32) -> Transport {
    room::closed_box(Vec3::new(-2.0, 0.0, -1.0), Vec3::new(2.0, 2.5, 1.0), n)
}

/// Returns the pages of patch rows, and the bytes of all rows.
fn follows_the_cpu(
    mut gpu: Gpu,
    page_bytes: Option<u64>,
    summed: Summed,
    columns: Forced,
    transport: &Transport,
) -> (usize, u64) {
    gpu.page_bytes = page_bytes.unwrap_or(gpu.page_bytes);
    let scene = scene(transport);
    let mut studio = studio_with(gpu, transport.clone(), summed, &[(Feature::Columns, columns)]);
    let drawn = studio.draw(&scene, View::Composite);
    let spaces = studio.renderer.spaces();
    let n = transport.patches.len();
    let exitance = read(&studio, &spaces.exitance, n);

    let mut materials = of_patches(transport, &scene, &studio.assets);
    solve::limit_gain(&transport.patch_from_patch, &transport.patches, &mut materials.albedo);
    let system =
        System { rows: &transport.patch_from_patch, patches: &transport.patches, albedo: &materials.albedo };
    let coarse = Coarse::new(&system);
    assert_eq!(coarse.m, 6);
    let mut radiosity = vec![Vec3::ZERO; n];
    for _ in 0..drawn.products {
        TwoLevel { system: &system, coarse: &coarse }.step(&exitance, &mut radiosity);
    }
    let on_gpu = read(&studio, &spaces.radiosity, n);
    assert!(apart(&on_gpu, &radiosity) < 1e-4, "bounce: {}", apart(&on_gpu, &radiosity));

    let rows = &transport.receiver_from_patch;
    let wide = |values: &[Vec3]| -> Vec<DVec3> { values.iter().map(|value| value.as_dvec3()).collect() };
    let narrow = |values: Vec<DVec3>| -> Vec<Vec3> { values.iter().map(|value| value.as_vec3()).collect() };
    let bounced: Vec<Vec3> = radiosity.iter().zip(&materials.exitance).map(|(b, m)| *b - *m).collect();
    let sources = [&materials.exitance, &bounced];
    for (source, buffer) in sources.iter().zip(&spaces.receivers) {
        let truth = narrow(gather(rows, &wide(source)));
        let on_gpu = read(&studio, buffer, truth.len());
        assert!(apart(&on_gpu, &truth) < 1e-4, "receivers: {}", apart(&on_gpu, &truth));
    }
    let bytes = studio.renderer.bytes().into_iter().find(|(kind, _)| *kind == "rows").unwrap().1;
    (studio.renderer.pages(), bytes)
}

#[test]
fn bounce_and_receivers_follow_the_cpu_with_a_thread_a_row() {
    let Some(gpu) = gpu() else { return };
    assert_eq!(follows_the_cpu(gpu, None, Summed::ByThread, Forced::In, &box_of(6)).0, 1);
}

#[test]
fn bounce_and_receivers_follow_the_cpu_with_a_workgroup_a_row() {
    let Some(gpu) = gpu() else { return };
    assert_eq!(follows_the_cpu(gpu, None, Summed::ByGroup, Forced::In, &box_of(6)).0, 1);
}

#[test]
fn pages_of_one_mebibyte_change_nothing() {
    let Some(gpu) = gpu() else { return };
    // 864 patches see five walls: 720 columns a row, 2.5 MB of weights.
    assert!(follows_the_cpu(gpu, Some(1 << 20), Summed::ByThread, Forced::In, &box_of(12)).0 >= 3);
}

/// The rows of receivers as the baker stores them: in four bytes an entry.
#[test]
fn packed_rows_are_read_as_the_cpu_reads_them() {
    let mut packed = box_of(6);
    let rows = std::mem::take(&mut packed.receiver_from_patch);
    for row in 0..rows.len() {
        let mut entries: Vec<(u32, f32)> = rows.row(row).collect();
        fold(&mut entries);
        packed.receiver_from_patch.push(entries);
    }
    assert_ne!(packed.receiver_from_patch, rows);
    for summed in [Summed::ByThread, Summed::ByGroup] {
        let Some(gpu) = gpu() else { return };
        let (_, bytes) = follows_the_cpu(gpu, None, summed, Forced::In, &packed);
        let Some(gpu) = self::gpu() else { return };
        let (_, plain) = follows_the_cpu(gpu, None, summed, Forced::In, &box_of(6));
        assert_eq!(plain - bytes, 4 * rows.entries() as u64);
    }
}

/// Weights of all columns and no columns: singles, and the halves of the receivers' rows.
#[test]
fn dense_rows_are_read_as_the_cpu_reads_them() {
    let mut packed = box_of(6);
    for rows in [&mut packed.receiver_from_patch, &mut packed.patch_from_patch] {
        let plain = std::mem::take(rows);
        for row in 0..plain.len() {
            let mut entries: Vec<(u32, f32)> = plain.row(row).collect();
            fold(&mut entries);
            rows.push(entries);
        }
    }
    let rows = (packed.receiver_from_patch.len() + packed.patch_from_patch.len()) as u64;
    let columns = packed.columns() as u64;
    for summed in [Summed::ByThread, Summed::ByGroup] {
        for (transport, bytes) in [(&box_of(6), 4 * columns), (&packed, 4 * columns.div_ceil(2))] {
            let Some(gpu) = gpu() else { return };
            let found = follows_the_cpu(gpu, None, summed, Forced::Out, transport);
            assert_eq!(found, (1, rows * bytes));
        }
    }
    let Some(gpu) = gpu() else { return };
    assert!(follows_the_cpu(gpu, Some(1 << 20), Summed::ByThread, Forced::Out, &box_of(12)).0 >= 3);
}

#[test]
fn a_bake_whose_rows_fit_no_page_is_refused() {
    let Some(mut gpu) = gpu() else { return };
    gpu.page_bytes = 256;
    let settings = Settings::default();
    let assets = Default::default();
    let refused =
        engine::render::Renderer::new(gpu.into(), transport().into(), &assets, settings).err().unwrap();
    assert!(refused.to_string().contains("row 0"), "{refused}");
}

#[test]
fn the_solved_light_is_the_exact_solution_and_the_bound_holds() {
    let Some(gpu) = gpu() else { return };
    let transport = transport();
    let scene = scene(&transport);
    let mut studio = studio(gpu, transport.clone(), Summed::ByThread);
    let drawn = studio.settle(&scene, View::Composite);
    let spaces = studio.renderer.spaces();
    let n = transport.patches.len();
    let exitance = read(&studio, &spaces.exitance, n);
    let mut albedo = of_patches(&transport, &scene, &studio.assets).albedo;
    solve::limit_gain(&transport.patch_from_patch, &transport.patches, &mut albedo);
    let system = System { rows: &transport.patch_from_patch, patches: &transport.patches, albedo: &albedo };
    let wide: Vec<DVec3> = exitance.iter().map(|e| e.as_dvec3()).collect();
    let exact: Vec<Vec3> = solve::exact(&system, &wide, 1e-9).iter().map(|b| b.as_vec3()).collect();
    let on_gpu = read(&studio, &spaces.radiosity, n);
    let error = apart(&on_gpu, &exact);
    let bound = drawn.bound.unwrap();
    assert!(bound <= 1e-3, "{bound}");
    assert!(error <= bound.max(2e-6), "error {error}, bound {bound}");
}

#[test]
fn where_few_bounces_count_the_coarse_correction_is_left_out_and_told() {
    let Some(gpu) = gpu() else { return };
    let transport = transport();
    let mut scene = scene(&transport);
    let mut studio = studio(gpu, transport.clone(), Summed::ByThread);
    let told = |studio: &Studio| {
        studio.renderer.left_out().into_iter().find(|what| what.starts_with("coarse correction"))
    };
    studio.settle(&scene, View::Composite);
    assert_eq!(told(&studio), None);
    // The same walls in dark paint, on the way and solved.
    scene.materials.iter_mut().for_each(|material| material.albedo.color *= 0.3);
    let drawn = studio.draw(&scene, View::Composite);
    assert_eq!(told(&studio).as_deref(), Some("coarse correction: few bounces count"));
    let bytes = studio.renderer.bytes();
    assert!(bytes.iter().any(|&(what, bytes)| what == "coarse correction" && bytes == 0), "{bytes:?}");
    assert!(drawn.products >= 2);
    let n = transport.patches.len();
    let albedo = of_patches(&transport, &scene, &studio.assets).albedo;
    let system = System { rows: &transport.patch_from_patch, patches: &transport.patches, albedo: &albedo };
    let mut radiosity = read(&studio, &studio.renderer.spaces().radiosity, n);
    for _ in 0..3 {
        let drawn = studio.draw(&scene, View::Composite);
        let exitance = read(&studio, &studio.renderer.spaces().exitance, n);
        for _ in 0..drawn.products {
            TwoLevel { system: &system, coarse: &Coarse::default() }.step(&exitance, &mut radiosity);
        }
        let on_gpu = read(&studio, &studio.renderer.spaces().radiosity, n);
        assert!(apart(&on_gpu, &radiosity) < 1e-5, "{}", apart(&on_gpu, &radiosity));
    }
    // Bright again: it comes back.
    scene.materials.iter_mut().for_each(|material| material.albedo.color /= 0.3);
    studio.settle(&scene, View::Composite);
    assert_eq!(told(&studio), None);
}

#[test]
fn a_probe_reads_what_the_cpu_gathers() {
    let Some(gpu) = gpu() else { return };
    let mut transport = transport();
    // A probe whose coefficients are single patches, told apart by weight.
    transport.probes = vec![Probe { valid: 1.0, position: Vec3::Y, ..Probe::default() }];
    for k in 0..sh::COEFFICIENTS as u32 {
        transport.probe_from_patch.push([(k * 3, 0.5 - 0.1 * k as f32)]);
    }
    let mut scene = scene(&transport);
    let cube = engine::scene::shape::Shape::Cube;
    scene.entities.push(engine::scene::Entity {
        id: engine::scene::EntityId(200),
        mesh: Some(room::mesh(cube, 0)),
        ..Default::default()
    });
    let mut studio = studio(gpu, transport.clone(), Summed::ByThread);
    let source = engine::scene::MeshSource::Shape(cube);
    studio.assets.meshes.insert(source, engine::scene::shape::mesh(cube).into());
    studio.settle(&scene, View::Composite);
    let spaces = studio.renderer.spaces();
    let bounced = read(&studio, &spaces.bounced, transport.patches.len());
    let on_gpu = read(&studio, &spaces.probes[1], 18);
    let mut gathered = std::array::from_fn(|k| bounced[k * 3] * (0.5 - 0.1 * k as f32));
    dering::dering(&mut gathered);
    for k in 0..9 {
        assert!((on_gpu[k] - gathered[k]).length() < 1e-4, "{k}: {} {}", on_gpu[k], gathered[k]);
    }
    // Behind the probes: the mean of all receivers, from everywhere.
    let receivers = read(&studio, &spaces.receivers[1], transport.receivers.len());
    let mean = receivers.iter().sum::<Vec3>() / receivers.len() as f32;
    let mut l = [Vec3::ZERO; 9];
    l.copy_from_slice(&on_gpu[9..]);
    assert!((sh::irradiance(&l, Vec3::Y) - mean).length() < 1e-4 * mean.length());
}
