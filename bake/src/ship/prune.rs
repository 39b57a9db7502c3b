//! Rows without what comes to nothing.

use engine::transport::solve::limit_gain;
use engine::transport::{Rows, Transport, packed, sky};
use glam::Vec3;

use super::lit::Sources;

/// Empties the rows of patches that hold no light and drops their columns everywhere. Returns whether there was
/// anything to drop. Where albedo is limited otherwise without them, which a room at the edge of the limit may be,
/// they stay.
pub fn patches(transport: &mut Transport, sources: &Sources, dark: &[bool]) -> bool {
    let is_dark = |column: u32| dark.get(column as usize).is_some_and(|dark| *dark);
    let kept = |rows: &Rows, row: usize| -> Vec<(u32, f32)> {
        rows.row(row).filter(|(column, _)| !is_dark(*column)).collect()
    };
    let of = |rows: &Rows| mapped(rows, |row| kept(rows, row));
    let own = &transport.patch_from_patch;
    let patch_from_patch = mapped(own, |row| if dark[row] { Vec::new() } else { kept(own, row) });
    let [_, receiver, probe, directional] = all(transport);
    let rows = [patch_from_patch, of(receiver), of(probe), of(directional)];
    let is_less = rows.iter().zip(all(transport)).any(|(rows, before)| rows.entries() < before.entries());
    if !is_less || !is_limited_alike(transport, &rows[0], sources, dark) {
        return false;
    }
    put(transport, rows);
    true
}

fn is_limited_alike(transport: &Transport, pruned: &Rows, sources: &Sources, dark: &[bool]) -> bool {
    if sources.unlimited_gain {
        return true;
    }
    let authored = sources.materials().albedo;
    let limited = |rows: &Rows| -> Vec<Vec3> {
        let mut albedo = authored.clone();
        limit_gain(rows, &transport.patches, &mut albedo);
        albedo
    };
    let (before, after) = (limited(&sources.full.patch_from_patch), limited(pruned));
    before.iter().zip(after).zip(dark).all(|((before, after), dark)| *dark || *before == after)
}

/// With one column for the whole sky, which is exact where it is the same everywhere. Returns whether there were more.
pub fn sky_patches(transport: &mut Transport) -> bool {
    if transport.sky_patches <= sky::FEWEST_PACKED {
        return false;
    }
    let n = transport.patches.len();
    let is_packed = |rows: &Rows| packed::pack_all(&rows.columns, &rows.weights).is_some();
    let packed = all(transport).map(is_packed);
    let any_packed =
        all(transport).into_iter().zip(packed).any(|(rows, packed)| packed && rows.entries() > 0);
    let mut kinds = packed.into_iter();
    let rows = all(transport).map(|rows| {
        let packed = kinds.next().unwrap_or(false);
        mapped(rows, |row| with_one_sky(rows, row, n, packed))
    });
    put(transport, rows);
    transport.sky_patches = if any_packed { sky::FEWEST_PACKED } else { sky::FEWEST };
    true
}

/// A row whose entries of the sky, column `n` and on, are summed up.
fn with_one_sky(rows: &Rows, row: usize, n: usize, packed: bool) -> Vec<(u32, f32)> {
    let (patches, sky): (Vec<_>, Vec<_>) = rows.row(row).partition(|&(column, _)| (column as usize) < n);
    let sum: f64 = sky.iter().map(|&(_, weight)| f64::from(weight)).sum();
    let sums = if packed { packed::split(sum) } else { [towards_zero(sum), 0.0] };
    let sums = (n as u32..).zip(sums).filter(|(_, weight)| *weight != 0.0);
    patches.into_iter().chain(sums).collect()
}

/// A sum of shares stays a share.
fn towards_zero(sum: f64) -> f32 {
    let near = sum as f32;
    let is_beyond = f64::from(near).abs() > sum.abs();
    match is_beyond {
        true if near > 0.0 => near.next_down(),
        true => near.next_up(),
        false => near,
    }
}

fn all(transport: &Transport) -> [&Rows; 4] {
    let Transport { patch_from_patch, receiver_from_patch, probe_from_patch, directional_from_patch, .. } =
        transport;
    [patch_from_patch, receiver_from_patch, probe_from_patch, directional_from_patch]
}

fn put(transport: &mut Transport, [patch, receiver, probe, directional]: [Rows; 4]) {
    transport.patch_from_patch = patch;
    transport.receiver_from_patch = receiver;
    transport.probe_from_patch = probe;
    transport.directional_from_patch = directional;
}

fn mapped(rows: &Rows, row: impl Fn(usize) -> Vec<(u32, f32)>) -> Rows {
    let mut mapped = Rows::default();
    (0..rows.len()).for_each(|index| mapped.push(row(index)));
    mapped
}
