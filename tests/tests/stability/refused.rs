//! Numbers that are none, and files that say what cannot be. Cases 25, 26 and 33 of the catalogue.

use bake::{Settings, Silent, bake, check};
use engine::scene::{LightKind, Scene};
use engine::transport::{Rows, Transport, file, materials};
use glam::{DVec3, Vec3};
use serde_json::json;
use tests::enclosure::{change, cube, paint, project};
use tests::made::{FACING, Made, SQUARE, project as files};
use tests::project::TestProject;
use tests::room::light;
use tests::solution::{Solved, baked, solved};
use tests::surfaces::from_obj;

const RAYS: u32 = 64;

fn told(solved: &Solved, what: &str) -> bool {
    solved.warnings.iter().any(|warning| warning.to_string().contains(what))
}

// Case 25.
#[test]
fn a_triangle_whose_corner_is_no_number_is_dropped_by_name_and_the_rest_is_lit() {
    for number in ["nan", "inf", "-inf", "1e39"] {
        let obj = format!(
            "o floor\nv 0 0 0\nv 0 0 1\nv 1 0 1\nv 1 0 0\nf 1 2 3 4\n\
             o broken\nv {number} 1 0\nv 0 1 1\nv 1 1 1\nv 0 1 0\nf 5 6 7\nf 8 7 6\n"
        );
        let project = from_obj(&obj);
        change(&project, |scene| paint(scene, 0.5, 1.0));
        let lit = solved(&project, 0.5, RAYS);
        assert!(told(&lit, "object 1 `broken`: 1 triangles"), "{number}: {:?}", lit.warnings);
        assert!(!lit.of_entity(2).is_empty(), "{number}");
        assert!(lit.b.iter().all(|b| b.is_finite() && b.min_element() > 0.0), "{number}");
    }
}

/// A square with these attributes, as glTF.
fn square(normals: [f32; 12], uvs: [f32; 8], colors: [f32; 12]) -> Solved {
    let mut made = Made::new();
    let attributes = json!({
        "POSITION": made.floats(&SQUARE, "VEC3"), "NORMAL": made.floats(&normals, "VEC3"),
        "TEXCOORD_0": made.floats(&uvs, "VEC2"), "COLOR_0": made.floats(&colors, "VEC3"),
    });
    made.draw(json!({"attributes": attributes, "mode": 6}));
    let folder = files(&[("a.gltf", made.text().as_bytes())]);
    let project = TestProject::from_file(&folder.path().join("a.gltf"));
    change(&project, |scene| paint(scene, 0.5, 1.0));
    solved(&project, 0.5, RAYS)
}

// Case 25.
#[test]
fn normals_coordinates_and_colours_that_are_no_numbers_are_replaced_and_told() {
    let clean = square(FACING, [0.5; 8], [1.0; 12]);
    assert!(clean.warnings.is_empty(), "{:?}", clean.warnings);
    for number in [f32::NAN, f32::INFINITY] {
        let mut normals = FACING;
        normals[4] = number;
        let (mut uvs, mut colors) = ([0.5; 8], [1.0; 12]);
        (uvs[3], colors[7]) = (number, number);
        let mended = square(normals, uvs, colors);
        assert!(told(&mended, "3 normals, texture coordinates or colours"), "{:?}", mended.warnings);
        assert_eq!(mended.b, clean.b);
        for vertex in &mended.transport.surface.vertices {
            let is_white = vertex.color.iter().all(|channel| (channel - 1.0).abs() < 1e-6);
            assert!(vertex.normal == Vec3::Z && vertex.uv[0].is_finite() && is_white, "{vertex:?}");
        }
    }
}

// Case 25. What the scene itself says is refused, not mended: nobody but its author knows what was meant.
#[test]
fn a_transform_or_light_that_is_no_number_is_refused_by_name() {
    type Damage = fn(&mut Scene, f64);
    let damages: [(&str, Damage); 6] = [
        ("`floor`", |scene, number| scene.entities[2].transform.translation.y = number),
        ("`floor`", |scene, number| scene.entities[2].transform.scale.x = number),
        ("`floor`", |scene, number| scene.entities[2].transform.rotation.x = number),
        ("`light 100`", |scene, number| scene.entities[6].light.as_mut().unwrap().intensity = number as f32),
        ("`light 100`", |scene, number| scene.entities[6].light.as_mut().unwrap().color.y = number as f32),
        ("`ceiling`", |scene, number| scene.materials[3].emission.color.z = number as f32),
    ];
    for number in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for (name, damage) in &damages {
            let project = project(&cube());
            change(&project, |scene| {
                scene.entities.push(light(100, LightKind::Point, 1.0, DVec3::splat(0.5), DVec3::ZERO));
                damage(scene, number);
            });
            let refused = bake(project.path(), None, &Settings::default(), &Silent).map(|_| ());
            let message = refused.expect_err(name).to_string();
            assert!(message.contains(name), "{number}: `{message}` does not name {name}");
        }
    }
}

// Case 25: finite numbers that make others.
#[test]
fn what_is_too_large_to_be_a_number_of_metres_is_refused_by_name() {
    for scale in [1e30, 1e160, 1e300] {
        let project = project(&cube());
        change(&project, |scene| {
            scene.entities[2].transform.scale = DVec3::splat(scale);
            scene.entities[2].transform.translation = DVec3::splat(scale);
        });
        let settings = Settings { rays: Some(RAYS), ..Settings::default() };
        let refused = bake(project.path(), None, &settings, &Silent).map(|_| ());
        let message = refused.expect_err("a refusal").to_string();
        assert!(message.contains("`floor`"), "{scale}: {message}");
    }
}

// Case 26. A file with an albedo that is no number is refused; one that comes by hand while the scene is open is 0.5.
#[test]
fn an_albedo_outside_0_to_1_is_clamped_and_one_that_is_no_number_is_a_half() {
    let project = project(&cube());
    change(&project, |scene| {
        scene.materials[0].albedo.color = Vec3::new(1.5, -0.5, 1e30);
        paint_emission(scene);
    });
    let room = solved(&project, 0.5, RAYS);
    assert!(told(&room, "material `-x`: its albedo is clamped"), "{:?}", room.warnings);
    // 1 in red and blue, where the rest of the room absorbs.
    assert!(room.of_entity(1).iter().all(|&i| room.albedo[i] == Vec3::new(1.0, 0.0, 1.0)));
    assert!(room.b.iter().all(|b| b.is_finite() && b.min_element() >= 0.0));

    change(&project, |scene| scene.materials[0].albedo.color = Vec3::new(f32::NAN, 0.2, 0.2));
    let refused = bake(project.path(), None, &Settings::default(), &Silent).map(|_| ());
    let message = refused.expect_err("a refusal").to_string();
    assert!(message.contains("material `-x`: its albedo is not finite"), "{message}");

    let open = room.again(|scene| scene.materials[0].albedo.color = Vec3::new(f32::NAN, 0.2, f32::INFINITY));
    assert!(open.of_entity(1).iter().all(|&i| open.albedo[i] == Vec3::new(0.5, 0.2, 1.0)));
    let warned = materials::warnings(&open.scene);
    assert!(warned.len() == 1 && warned[0].to_string().contains("material `-x`"), "{warned:?}");
    assert!(open.b.iter().all(|b| b.is_finite()));
}

fn paint_emission(scene: &mut Scene) {
    scene.materials[3].emission.color = Vec3::ONE;
}

/// The same transport, its patch rows changed entry by entry.
fn with_rows(transport: &Transport, change: impl Fn(usize, u32, f32) -> f32) -> Transport {
    let mut changed = transport.clone();
    let mut rows = Rows::default();
    for i in 0..transport.patches.len() {
        rows.push(transport.patch_from_patch.row(i).map(|(j, weight)| (j, change(i, j, weight))));
    }
    changed.patch_from_patch = rows;
    changed
}

// Case 33: symmetrised alone, rows sum to up to 1.035; white walls would then multiply light for ever.
#[test]
fn a_file_whose_rows_give_more_than_they_have_does_not_load() {
    let baked = baked(&project(&cube()), 0.25, RAYS);
    let unbalanced = with_rows(&baked.transport, |i, _, weight| if i == 7 { weight * 1.035 } else { weight });
    file::save(&baked.file, &unbalanced).expect("a file");
    let refused = file::load(&baked.file).map(|_| ()).expect_err("a refusal").to_string();
    assert!(refused.contains("row 7 sums to 1.03") && refused.contains("light.hohlraum"), "{refused}");
    // Nor does one whose gain would be negative: a share below 0.
    let negative =
        with_rows(&baked.transport, |i, j, weight| if i == 7 && j == 40 { -weight } else { weight });
    file::save(&baked.file, &negative).expect("a file");
    let refused = file::load(&baked.file).map(|_| ()).expect_err("a refusal").to_string();
    assert!(refused.contains("row 7 has a weight that is no share"), "{refused}");
}

// Case 33: what sums to no more than 1 cannot diverge, but may make energy or lose it.
#[test]
fn a_file_whose_rows_break_reciprocity_does_not_pass_the_check() {
    let project = project(&cube());
    let baked = baked(&project, 0.25, RAYS);
    let settings = Settings::default();
    assert!(check(project.path(), None, &settings).expect("a certificate").holds());
    // Two shares of a row change places: all sums are as they were.
    let row: Vec<(u32, f32)> = baked.transport.patch_from_patch.row(7).filter(|&(j, _)| j != 7).collect();
    let largest = *row.iter().max_by(|a, b| a.1.total_cmp(&b.1)).expect("an entry");
    let least = *row.iter().min_by(|a, b| a.1.total_cmp(&b.1)).expect("an entry");
    let mut lopsided = with_rows(&baked.transport, |i, j, weight| match (i, j) {
        (7, j) if j == largest.0 => least.1,
        (7, j) if j == least.0 => largest.1,
        _ => weight,
    });
    lopsided.certificate.transport_hash = lopsided.hash().to_hex().to_string();
    file::save(&baked.file, &lopsided).expect("a file");
    let broken = match check(project.path(), None, &settings) {
        Ok(certificate) => {
            let statements = certificate.statements().into_iter().filter(|statement| !statement.holds);
            statements.map(|statement| statement.what.to_owned()).collect()
        }
        Err(refused) => vec![refused.to_string()],
    };
    println!("{broken:?}");
    assert!(broken.len() == 1 && broken[0].contains("reciprocity"), "{broken:?}");
}
