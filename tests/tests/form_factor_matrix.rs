//! The matrix of form factors with faces as patches: against closed forms, against the slow plain twin, and against
//! the rays of others (`reference/` of the shared folder: 2.1 M rays a patch, noise 0.4 % rms).

use bake::Silent;
use bake::form_factors::{FormFactors, by_plain_rays, of_faces};
use glam::Vec3;
use tests::room::walls;
use tests::shared;
use tests::surfaces::{Faces, face, quad};

type Triangles = Vec<[Vec3; 3]>;

fn triangles(faces: &Faces) -> Triangles {
    let fan =
        |face: &Vec<Vec3>| (2..face.len()).map(|k| [face[0], face[k - 1], face[k]]).collect::<Triangles>();
    faces.iter().flat_map(fan).collect()
}

/// The share of what leaves the first `count` faces that arrives at the others.
fn factor(matrix: &FormFactors, count: usize) -> f64 {
    let there = |i: usize| -> f64 {
        let row = matrix.rows.row(i).filter(|entry| entry.0 as usize >= count);
        matrix.areas[i] * row.map(|entry| f64::from(entry.1)).sum::<f64>()
    };
    (0..count).map(there).sum::<f64>() / matrix.areas[..count].iter().sum::<f64>()
}

/// Two surfaces alone.
fn assert_pair(first: Faces, second: Faces, wanted: f64, tolerance: f64) {
    let (first, second) = (triangles(&first), triangles(&second));
    let both: Triangles = first.iter().chain(&second).copied().collect();
    let found = factor(&of_faces(&both, 256, &Silent).expect("a matrix"), first.len());
    assert!((found - wanted).abs() <= tolerance, "{found}, not {wanted}");
}

fn floor() -> Faces {
    quad(Vec3::ZERO, Vec3::Z, Vec3::X)
}

#[test]
fn rectangles_that_face_each_other_have_the_factor_of_the_closed_form() {
    let ceiling = |at: Vec3| quad(at, Vec3::X, Vec3::Z);
    for (height, wanted) in [(0.1, 0.826_995), (0.5, 0.415_253), (1.0, 0.199_825), (2.0, 0.068_589_6)] {
        assert_pair(floor(), ceiling(Vec3::Y * height), wanted, 1e-6);
    }
    assert_pair(floor(), ceiling(Vec3::Y * 10.0), 0.003_162_06, 1e-6);
    assert_pair(floor(), ceiling(Vec3::ONE), 0.043_327_4, 1e-6);
    let wide = quad(Vec3::new(-0.5, 1.0, -0.5), Vec3::X * 2.0, Vec3::Z * 2.0);
    assert_pair(floor(), wide, 0.517_653, 1e-6);
}

#[test]
fn rectangles_with_a_common_edge_have_the_factor_of_the_closed_form() {
    let wall = |height: f32| quad(Vec3::ZERO, Vec3::Y * height, Vec3::Z);
    for (height, wanted) in [(1.0, 0.200_044), (2.0, 0.232_853), (0.5, 0.146_187)] {
        assert_pair(floor(), wall(height), wanted, 1e-6);
    }
    for (degrees, wanted) in
        [(30.0_f32, 0.619_028), (60.0, 0.370_905), (120.0, 0.086_615), (150.0, 0.021_345_3)]
    {
        let (sin, cos) = degrees.to_radians().sin_cos();
        assert_pair(floor(), quad(Vec3::ZERO, Vec3::new(cos, sin, 0.0), Vec3::Z), wanted, 1.5e-6);
    }
}

#[test]
fn a_closed_cube_closes_to_the_last_bit_and_gives_back_what_it_gets() {
    let cube: Triangles =
        walls(Vec3::ZERO, Vec3::ONE).iter().flat_map(|wall| triangles(&face(wall))).collect();
    let matrix = of_faces(&cube, 64, &Silent).expect("a matrix");
    assert!(matrix.lost.iter().all(|&lost| lost == 0.0), "{:?}", matrix.lost);
    for i in 0..cube.len() {
        let sum = matrix.rows.sum(i);
        assert!((1.0 - 2e-7..=1.0).contains(&sum), "{sum}");
    }
    let error = matrix.error(&matrix.dense());
    assert_eq!((error.rms, error.row_l1), (0.0, 0.0));
    assert!(error.reciprocity < 1e-6, "{}", error.reciprocity);
    let opposite = |a: usize, b: usize| -> f64 {
        let flux = |i: usize| {
            matrix.rows.row(i).filter(|e| e.0 as usize / 2 == b).map(|e| f64::from(e.1)).sum::<f64>()
        };
        0.5 * (flux(2 * a) + flux(2 * a + 1))
    };
    assert!((opposite(0, 1) - 0.199_825).abs() < 1e-6, "{}", opposite(0, 1));
    assert!((opposite(0, 2) - 0.200_044).abs() < 1e-6, "{}", opposite(0, 2));
}

#[test]
fn faces_without_area_have_empty_rows_and_faces_without_numbers_are_refused() {
    let mut faces = triangles(&floor());
    faces.insert(1, [Vec3::ZERO, Vec3::X, Vec3::X * 2.0]);
    faces.extend(triangles(&quad(Vec3::Y, Vec3::X, Vec3::Z)));
    let matrix = of_faces(&faces, 64, &Silent).expect("a matrix");
    assert_eq!((matrix.rows.len(), matrix.rows.row(1).len(), matrix.areas[1]), (5, 0, 0.0));
    assert!(matrix.rows.columns.iter().all(|&column| column != 1));
    assert!(of_faces(&[], 64, &Silent).expect("nothing").rows.is_empty());
    faces[0][1].y = f32::NAN;
    assert!(of_faces(&faces, 64, &Silent).is_err() && by_plain_rays(&faces, 64, 0).is_err());
}

/// The Cornell box in 500 faces, and its matrix.
fn cornell() -> Option<(Triangles, Vec<f32>)> {
    let folder = shared()?.join("reference");
    let text = std::fs::read_to_string(folder.join("scenes/cornell/patches_500.obj")).expect("faces");
    let (mut corners, mut faces) = (Vec::new(), Vec::new());
    for line in text.lines() {
        let numbers = || line[1..].split_whitespace().map(|word| word.parse::<f32>().expect("a number"));
        match line.as_bytes().first() {
            Some(b'v') => corners.push(Vec3::from_slice(&numbers().collect::<Vec<f32>>())),
            Some(b'f') => faces.push(numbers().map(|n| corners[n as usize - 1]).collect::<Vec<_>>()),
            _ => {}
        }
    }
    let bytes = std::fs::read(folder.join("cornell_500_form_factors.npy")).expect("a matrix");
    let matrix = npyz::NpyFile::new(&bytes[..]).expect("an array").into_vec().expect("f32");
    let triangles = faces.into_iter().map(|face| face.try_into().expect("a triangle")).collect();
    Some((triangles, matrix))
}

const RAYS: u32 = 1024;

#[test]
fn at_equal_rays_the_matrix_of_the_cornell_box_is_ten_times_as_right_as_plain_rays() {
    let Some((faces, reference)) = cornell() else { return };
    let matrix = of_faces(&faces, RAYS, &Silent).expect("a matrix");
    let plain = by_plain_rays(&faces, RAYS, 1).expect("a matrix");
    let (found, by_rays) = (matrix.error(&reference), plain.error(&reference));
    println!("{found:?}\nplain {by_rays:?}");
    assert!(found.rms <= 0.1 * by_rays.rms && found.row_l1 <= 0.1 * by_rays.row_l1);
    assert!(found.rms <= 0.012, "{}", found.rms);
    assert!(found.reciprocity <= 1e-6);
}

#[test]
fn the_plain_twin_differs_from_the_matrix_by_the_noise_of_its_rays() {
    let Some((faces, _)) = cornell() else { return };
    let matrix = of_faces(&faces, RAYS, &Silent).expect("a matrix").dense();
    let plain = by_plain_rays(&faces, RAYS, 2).expect("a matrix").dense();
    let (mut square, mut variance, mut bias) = (0.0, 0.0, 0.0);
    for (&found, &by_rays) in matrix.iter().zip(&plain) {
        let (found, by_rays) = (f64::from(found), f64::from(by_rays));
        square += (found - by_rays).powi(2);
        variance += found * (1.0 - found) / f64::from(RAYS);
        bias += by_rays - found;
    }
    println!("{:.4} of the variance, bias {bias:.1e} of 500", square / variance);
    assert!((0.96..1.04).contains(&(square / variance)), "{}", square / variance);
}

#[test]
fn floor_parts_under_the_blocks_see_backs_as_the_reference_says() {
    let Some((faces, reference)) = cornell() else { return };
    let n = faces.len();
    let matrix = of_faces(&faces, RAYS, &Silent).expect("a matrix");
    let mut partly = 0;
    for i in 0..n {
        let wanted: f64 = reference[i * n..][..n].iter().map(|&share| f64::from(share)).sum();
        let found = matrix.rows.sum(i);
        if wanted > 0.9999 {
            assert!((1.0 - 2e-7..=1.0).contains(&found), "row {i} sums to {found}");
            continue;
        }
        partly += 1;
        let sigma = (wanted * (1.0 - wanted) / f64::from(RAYS)).sqrt();
        assert!(found < 1.0 && (found - wanted).abs() < 4.0 * sigma + 1e-3, "row {i}: {found}, not {wanted}");
    }
    println!("{partly} rows see backs");
    assert!(partly > 10);
}

#[test]
fn any_number_of_threads_finds_the_same_matrix() {
    let Some((faces, _)) = cornell() else { return };
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| of_faces(&faces, 64, &Silent).expect("a matrix"))
    };
    let one = with(1);
    assert!(one == with(2) && one == with(5));
}
