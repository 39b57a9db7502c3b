//! What numbers a transport may hold so that whatever is made of them is a number again: no product of lengths beyond
//! floats, no array as long as an index that came from a file.

use glam::Vec3;

use super::{NONE, Transport, sky};

/// Metres; products of four lengths are floats.
const FARTHEST: f32 = 1.1e9;
/// Of a light-probe row: 4 / R times the harmonics of R directions, and what emitters add.
const LARGEST_WEIGHT: f32 = 64.0;
/// Of a directional row.
const LARGEST_TERM: f32 = 2.0;

pub fn numbers(transport: &Transport) -> Result<(), String> {
    let says = |holds: bool, message: &str| if holds { Ok(()) } else { Err(message.to_owned()) };
    says(transport.origin.is_finite(), "its origin is no place")?;
    says(sky::is_division(transport.sky_patches), "it has a sky of another division")?;

    let n = transport.patches.len() as u32;
    for (i, patch) in transport.patches.iter().enumerate() {
        let is_grouped = patch.component < n && (patch.aggregate == NONE || patch.aggregate < n);
        says(is_grouped, &format!("patch {i} is of a group that does not exist"))?;
        let is_one = is_place(patch.centre) && is_direction(patch.normal) && patch.target.is_finite();
        says(is_one, &format!("patch {i} has no proper centre, normal or target"))?;
        let squared = patch.area * patch.area;
        says(squared.is_normal(), &format!("patch {i} is too small or too large: {} m2", patch.area))?;
    }

    let points = transport.samples.iter().map(|sample| (sample.position, sample.normal));
    let points =
        points.chain(transport.receivers.iter().map(|receiver| (receiver.position, receiver.normal)));
    let vertices = transport.surface.vertices.iter().map(|vertex| (vertex.position, vertex.normal));
    for (position, normal) in points.chain(vertices) {
        says(is_place(position) && is_direction(normal), "a point has no proper place or normal")?;
    }
    for vertex in &transport.surface.vertices {
        let numbers = vertex.uv.iter().flat_map(|uv| uv.to_array()).chain(vertex.tangent).chain(vertex.color);
        says(
            { numbers }.all(f32::is_finite),
            "a vertex has a texture coordinate, tangent or colour that is no number",
        )?;
    }
    let blends = transport.surface.blends.iter().chain(&transport.surface.back_blends);
    let is_share = |weight: f32| (0.0..=1.001).contains(&weight);
    says(
        { blends }.all(|blend| blend.weights.into_iter().all(is_share)),
        "a vertex blends what is no share",
    )?;

    let is_probe = |probe: &super::Probe| is_place(probe.position) && probe.valid.is_finite();
    says(transport.probes.iter().all(is_probe), "a light probe has no proper place")?;
    let weights = &transport.probe_from_patch.weights;
    says(
        weights.iter().all(|weight| weight.abs() <= LARGEST_WEIGHT),
        "a light probe sees more than there is",
    )?;
    let terms = &transport.directional_from_patch.weights;
    says(terms.iter().all(|term| term.abs() <= LARGEST_TERM), "a directional term is more than there is")?;
    let is_known = transport.directional_receivers() <= transport.receivers.len();
    says(is_known, "directional terms are of receivers that do not exist")
}

fn is_place(position: Vec3) -> bool {
    position.is_finite() && position.abs().max_element() <= FARTHEST
}

/// Unit, or nothing where a mesh has none.
fn is_direction(normal: Vec3) -> bool {
    normal.is_finite() && normal.length_squared() <= 1.1
}
