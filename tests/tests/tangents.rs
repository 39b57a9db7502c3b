//! Tangents that a file lacks: MikkTSpace's, split where the texture is mirrored, all the way into the bake.

use bake::{Settings, Silent, bake};
use engine::scene::Mesh;
use engine::scene::file::Quality;
use glam::{Vec3, Vec4};
use serde_json::{Value, json};
use tests::made::{Made, base64};
use tests::project::TestProject;

/// Two squares side by side in the XY plane, whose texture is mirrored about x = 0: u = |x|, v = 1 - y.
fn mirrored() -> (Made, Value) {
    let mut made = Made::new();
    let columns = [-1.0_f32, 0.0, 1.0];
    let each = |of: &dyn Fn(f32, f32) -> Vec<f32>| -> Vec<f32> {
        [0.0, 1.0].iter().flat_map(|&y| columns.iter().flat_map(move |&x| of(x, y))).collect()
    };
    let positions = made.floats(&each(&|x, y| vec![x, y, 0.0]), "VEC3");
    let normals = made.floats(&each(&|_, _| vec![0.0, 0.0, 1.0]), "VEC3");
    let uvs = made.floats(&each(&|x, y| vec![x.abs(), 1.0 - y]), "VEC2");
    (made, json!({"POSITION": positions, "NORMAL": normals, "TEXCOORD_0": uvs}))
}

fn draw(made: &mut Made, attributes: Value, normal_map: bool) {
    let indices = made.array(&[0, 1, 4, 0, 4, 3, 1, 2, 5, 1, 5, 4], 5121, "SCALAR", 12);
    made.draw(json!({"attributes": attributes, "indices": indices, "material": 0}));
    made.json["materials"] = json!([{"name": "bumpy"}]);
    if normal_map {
        let mut png = std::io::Cursor::new(Vec::new());
        image::RgbImage::from_pixel(1, 1, image::Rgb([128, 128, 255]))
            .write_to(&mut png, image::ImageFormat::Png)
            .unwrap();
        let uri = format!("data:image/png;base64,{}", base64(png.get_ref()));
        made.json["images"] = json!([{"uri": uri, "mimeType": "image/png"}]);
        made.json["textures"] = json!([{"source": 0}]);
        made.json["materials"][0]["normalTexture"] = json!({"index": 0});
    }
}

/// Right of the mirror the tangent goes right, left of it left; the bitangent n x t * w goes up on both sides.
fn assert_mirrored(
    position_of: impl Fn(usize) -> Vec3,
    tangent_of: impl Fn(usize) -> Vec4,
    triangles: &[[usize; 3]],
) {
    for triangle in triangles {
        let side = triangle.iter().map(|&vertex| position_of(vertex).x).sum::<f32>().signum();
        for &vertex in triangle {
            let tangent = tangent_of(vertex);
            assert!(tangent.abs_diff_eq(Vec4::new(side, 0.0, 0.0, side), 1e-6), "{triangle:?}: {tangent}");
            let bitangent = Vec3::Z.cross(tangent.truncate()) * tangent.w;
            assert!(bitangent.abs_diff_eq(Vec3::Y, 1e-6), "{bitangent}");
        }
    }
}

fn triangles(mesh: &Mesh) -> Vec<[usize; 3]> {
    mesh.triangles().map(|triangle| triangle.map(|vertex| vertex as usize)).collect()
}

#[test]
fn a_mirrored_texture_gets_the_tangents_that_it_has_by_hand() {
    let (mut made, attributes) = mirrored();
    draw(&mut made, attributes, true);
    let mesh = made.mesh();
    let tangents = mesh.tangents.clone().unwrap();
    assert_mirrored(|vertex| mesh.positions[vertex], |vertex| tangents[vertex], &triangles(&mesh));
    // The two vertices on the mirror were split; what is painted on them is painted on both.
    assert_eq!(mesh.positions.len(), 8);
    let on_mirror: Vec<usize> = (0..8).filter(|&vertex| mesh.positions[vertex].x == 0.0).collect();
    let mut originals: Vec<usize> = on_mirror.iter().map(|&vertex| mesh.original(vertex)).collect();
    originals.sort_unstable();
    assert_eq!(originals, [1, 1, 4, 4]);
}

#[test]
fn a_files_own_tangents_are_kept_and_nobody_gets_any_without_a_normal_map() {
    let (mut made, mut attributes) = mirrored();
    let own = made.floats(&[0.0, 1.0, 0.0, -1.0].repeat(6), "VEC4");
    attributes["TANGENT"] = json!(own);
    draw(&mut made, attributes, true);
    let mesh = made.mesh();
    assert_eq!(mesh.tangents.unwrap(), [Vec4::new(0.0, 1.0, 0.0, -1.0); 6]);

    let (mut made, attributes) = mirrored();
    draw(&mut made, attributes, false);
    let mesh = made.mesh();
    assert!(mesh.tangents.is_none() && mesh.positions.len() == 6);
}

#[test]
fn without_texture_coordinates_there_are_none() {
    let (mut made, mut attributes) = mirrored();
    attributes.as_object_mut().unwrap().remove("TEXCOORD_0");
    draw(&mut made, attributes, true);
    assert!(made.mesh().tangents.is_none());
}

#[test]
fn the_baked_surface_carries_them_through_every_cut() {
    let (mut made, attributes) = mirrored();
    draw(&mut made, attributes, true);
    let folder = tests::made::project(&[("a.gltf", made.text().as_bytes())]);
    let project = TestProject::from_file(&folder.path().join("a.gltf"));
    let settings = Settings { quality: Some(Quality::Draft), ..Settings::default() };
    let transport = bake(project.path(), None, &settings, &Silent).unwrap().transport;
    let surface = &transport.surface;
    assert!(surface.triangles.len() > 4, "{} triangles", surface.triangles.len());
    let origin = transport.origin.as_vec3();
    let triangles: Vec<[usize; 3]> =
        surface.triangles.iter().map(|triangle| triangle.map(|vertex| vertex as usize)).collect();
    let position = |vertex: usize| surface.vertices[vertex].position + origin;
    assert_mirrored(position, |vertex| Vec4::from(surface.vertices[vertex].tangent), &triangles);
}
