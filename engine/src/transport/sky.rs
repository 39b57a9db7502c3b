//! The sky as patches at infinity: an equal-area division of the sphere of directions.
//!
//! The sphere is cut into bands of equal height in y, each into cells of equal longitude: every cell has the
//! solid angle 4 pi / n (Archimedes). The cell of a direction is found by two multiplications.

use glam::{Vec3, Vec4};

use crate::scene::assets::{Assets, Picture};
use crate::scene::sky::zenith_weight;
use crate::scene::{Sky, SkyKind};

pub const BANDS: u32 = 16;
pub const CELLS: u32 = 32;
/// Sky patches where there is a sky.
pub const COUNT: u32 = BANDS * CELLS;

/// Of a sky that is the same everywhere, all columns of a row are one. Two where entries take four bytes each: the
/// second holds what the first one's eleven bits lack.
pub const FEWEST: u32 = 1;
pub const FEWEST_PACKED: u32 = 2;

/// Is it how many sky patches a transport may have?
pub fn is_division(sky_patches: u32) -> bool {
    [0, FEWEST, FEWEST_PACKED, COUNT].contains(&sky_patches)
}

/// The sky patch that a unit direction points to.
pub fn patch_of(direction: Vec3) -> u32 {
    let band = ((direction.y * 0.5 + 0.5) * BANDS as f32) as u32;
    let turn = direction.z.atan2(direction.x) / std::f32::consts::TAU;
    let cell = ((turn - turn.floor()) * CELLS as f32) as u32;
    band.min(BANDS - 1) * CELLS + cell.min(CELLS - 1)
}

/// A direction inside a sky patch; u, v in 0..1 are uniform over its solid angle.
pub fn direction_in(patch: u32, u: f32, v: f32) -> Vec3 {
    let (band, cell) = (patch / CELLS, patch % CELLS);
    let y = (band as f32 + v) / BANDS as f32 * 2.0 - 1.0;
    let (sin, cos) = ((cell as f32 + u) / CELLS as f32 * std::f32::consts::TAU).sin_cos();
    let r = (1.0 - y * y).max(0.0).sqrt();
    Vec3::new(r * cos, y, r * sin)
}

/// Mean radiance of each sky patch [W/m2/sr]. The first ones do for a transport that has fewer, of a sky that is the
/// same everywhere.
pub fn radiance_of_patches(sky: &Sky, assets: &Assets) -> Vec<Vec3> {
    const GRID: u32 = 8;
    (0..COUNT)
        .map(|patch| {
            let cells = (0..GRID * GRID).map(|k| {
                let at = |i: u32| (i as f32 + 0.5) / GRID as f32;
                radiance(sky, assets, direction_in(patch, at(k % GRID), at(k / GRID)))
            });
            cells.sum::<Vec3>() / (GRID * GRID) as f32
        })
        .collect()
}

/// Radiance from a unit direction, without the sun's disc [W/m2/sr].
pub fn radiance(sky: &Sky, assets: &Assets, direction: Vec3) -> Vec3 {
    match &sky.kind {
        SkyKind::None => Vec3::ZERO,
        SkyKind::Constant { radiance } => *radiance,
        SkyKind::Gradient { zenith, horizon, ground, .. } => {
            if direction.y < 0.0 {
                *ground
            } else {
                horizon.lerp(*zenith, zenith_weight(direction.y))
            }
        }
        SkyKind::Picture { image, strength, turn } => assets
            .images
            .get(image)
            .map_or(Vec3::ZERO, |picture| look_up(picture, direction, *turn) * *strength),
    }
}

/// Bilinear in an equirectangular picture whose middle looks along -Z.
fn look_up(picture: &Picture, d: Vec3, turn: f32) -> Vec3 {
    let u = (d.x.atan2(-d.z) + turn) / std::f32::consts::TAU + 0.5;
    let v = d.y.clamp(-1.0, 1.0).acos() / std::f32::consts::PI;
    let x = (u - u.floor()) * picture.width as f32 - 0.5;
    let y = v * picture.height as f32 - 0.5;
    let texel = |x: f32, y: f32| -> Vec4 {
        let x = (x as i64).rem_euclid(i64::from(picture.width)) as u32;
        let y = (y as i64).clamp(0, i64::from(picture.height) - 1) as u32;
        picture.linear_texel(x, y)
    };
    let (x0, y0) = (x.floor(), y.floor());
    let row = |y: f32| texel(x0, y).lerp(texel(x0 + 1.0, y), x - x0);
    row(y0).lerp(row(y0 + 1.0), y - y0).truncate()
}
