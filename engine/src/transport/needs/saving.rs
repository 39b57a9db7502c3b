//! What a feature costs: counted in a bake, or about where there is none yet; and what that is in time.
//!
//! ```text
//! bytes          of rows: entries times their bytes and a start a row, in the file 8, on the GPU 4
//! milliseconds   entries read in a frame, times what one costs, measured when asked for ([`Cost::measured`]); other
//!                bytes as if they were entries of 8
//! seconds        rays times what one costs: measured by a plan, or what the bake at hand took
//! ```

use std::time::Instant;

use super::Saving;
use crate::transport::{Rows, Transport, packed};

/// Rays of a light-probe row: few probes, each with nine coefficients to get right.
pub const PROBE_RAYS: u32 = 4096;
/// A vector of light on the GPU [bytes].
pub const VECTOR: u64 = 16;
/// Where it has one channel.
pub const CHANNEL: u64 = 4;

/// How much there is of everything.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sizes {
    pub patches: u64,
    pub receivers: u64,
    pub probes: u64,
    pub sky_patches: u64,
    pub of_patches: RowSizes,
    pub of_receivers: RowSizes,
    pub of_probes: RowSizes,
    pub rays_per_row: u64,
}

/// Of one kind of row.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RowSizes {
    pub rows: u64,
    pub entries: u64,
    /// Of an entry: 4 packed, else 8.
    pub bytes: u64,
}

/// What things take on this machine; 0 where nobody measured.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cost {
    /// On all threads that bake.
    pub seconds_per_ray: f64,
    pub milliseconds_per_entry: f64,
}

impl Sizes {
    pub fn of(transport: &Transport) -> Self {
        Self {
            patches: transport.patches.len() as u64,
            receivers: transport.receivers.len() as u64,
            probes: transport.probes.len() as u64,
            sky_patches: u64::from(transport.sky_patches),
            of_patches: RowSizes::of(&transport.patch_from_patch),
            of_receivers: RowSizes::of(&transport.receiver_from_patch),
            of_probes: RowSizes::of(&transport.probe_from_patch),
            rays_per_row: u64::from(transport.certificate.rays_per_row),
        }
    }

    /// About, where none is baked: a probe sees twice what a receiver does, or half of all there is.
    pub fn rows_of_probes(&self, probes: u64) -> RowSizes {
        let a_receiver = self.of_receivers.entries / self.receivers.max(1);
        let entries = 9 * probes * (2 * a_receiver).max(self.patches.min(u64::from(PROBE_RAYS)) / 2);
        RowSizes { rows: 9 * probes, entries, bytes: self.of_receivers.bytes }
    }
}

impl RowSizes {
    pub fn of(rows: &Rows) -> Self {
        let mut entries = rows.columns.iter().zip(&rows.weights);
        let is_packed = entries.all(|(&column, &weight)| packed::pack(column, weight).is_some());
        Self { rows: rows.len() as u64, entries: rows.entries() as u64, bytes: if is_packed { 4 } else { 8 } }
    }

    /// So many of the rows with so many of the entries.
    pub fn part(&self, rows: u64, entries: u64) -> Self {
        Self { rows, entries, ..*self }
    }

    /// Read `times` a frame.
    pub fn saving(&self, cost: &Cost, times: f64) -> Saving {
        Saving {
            file_bytes: self.entries * self.bytes + self.rows * 8,
            gpu_bytes: self.entries * self.bytes + self.rows * 4,
            milliseconds: self.entries as f64 * times * cost.milliseconds_per_entry,
            seconds: 0.0,
        }
    }
}

impl Cost {
    /// How long this machine's one thread takes for an entry of a row, the median of a few products over rows as many
    /// as a small scene has.
    pub fn measured() -> Self {
        const ROWS: usize = 512;
        let mut rows = Rows::default();
        (0..ROWS).for_each(|i| rows.push((0..ROWS).map(|j| (j as u32, 1.0 / (i + j + 1) as f32))));
        let light = vec![glam::DVec3::ONE; ROWS];
        let mut times: Vec<f64> = (0..5)
            .map(|_| {
                let started = Instant::now();
                let sum: glam::DVec3 = (0..ROWS).map(|i| gathered(&rows, i, &light)).sum();
                std::hint::black_box(sum);
                started.elapsed().as_secs_f64() * 1e3
            })
            .collect();
        times.sort_by(f64::total_cmp);
        Self { milliseconds_per_entry: times[2] / rows.entries() as f64, seconds_per_ray: 0.0 }
    }

    /// With what a ray took in the bake of a transport, everything included.
    pub fn of_bake(self, transport: &Transport) -> Self {
        let certificate = &transport.certificate;
        let rays = certificate.rays_traced.max(1) as f64;
        let seconds = if certificate.rays_traced == 0 { 0.0 } else { certificate.seconds };
        Self { seconds_per_ray: seconds / rays, ..self }
    }

    pub fn rays(&self, rays: u64) -> Saving {
        Saving { seconds: rays as f64 * self.seconds_per_ray, ..Saving::default() }
    }

    /// Memory of the GPU, of which a frame touches so many bytes.
    pub fn memory(&self, bytes: u64, touched: u64) -> Saving {
        let milliseconds = touched as f64 / 8.0 * self.milliseconds_per_entry;
        Saving { gpu_bytes: bytes, milliseconds, ..Saving::default() }
    }
}

fn gathered(rows: &Rows, row: usize, light: &[glam::DVec3]) -> glam::DVec3 {
    rows.row(row).map(|(column, weight)| light[column as usize] * f64::from(weight)).sum()
}

impl std::ops::Add for Saving {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            file_bytes: self.file_bytes + other.file_bytes,
            gpu_bytes: self.gpu_bytes + other.gpu_bytes,
            milliseconds: self.milliseconds + other.milliseconds,
            seconds: self.seconds + other.seconds,
        }
    }
}

/// "1.2 MB of file, 3.4 MB on the GPU, about 0.5 ms, about 12 s"; nothing where it saves nothing that is counted.
impl std::fmt::Display for Saving {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut parts = Vec::new();
        if self.file_bytes > 0 {
            parts.push(format!("{} of file", bytes(self.file_bytes)));
        }
        if self.gpu_bytes > 0 {
            parts.push(format!("{} on the GPU", bytes(self.gpu_bytes)));
        }
        if self.milliseconds >= 1e-3 {
            parts.push(format!("about {:.3} ms", self.milliseconds));
        }
        if self.seconds >= 1e-2 {
            parts.push(format!("about {:.2} s of bake", self.seconds));
        }
        f.write_str(&parts.join(", "))
    }
}

/// For people, in units of 1000.
pub fn bytes(bytes: u64) -> String {
    match bytes {
        0..1_000 => format!("{bytes} B"),
        1_000..1_000_000 => format!("{:.1} kB", bytes as f64 * 1e-3),
        1_000_000..1_000_000_000 => format!("{:.1} MB", bytes as f64 * 1e-6),
        _ => format!("{:.2} GB", bytes as f64 * 1e-9),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transport::file;

    #[test]
    fn rows_take_the_bytes_that_the_file_gives_them() {
        for weight in [0.25, 0.1] {
            let mut transport = Transport::default();
            transport.receiver_from_patch.push([(0, weight), (7, weight)]);
            transport.receiver_from_patch.push([(3, weight)]);
            let stored: u64 = file::arrays(&transport)
                .iter()
                .filter(|(name, _)| name.starts_with("receiver."))
                .map(|(_, bytes)| bytes.len() as u64)
                .sum();
            let told = Sizes::of(&transport).of_receivers.saving(&Cost::default(), 1.0).file_bytes;
            assert_eq!(told + 8, stored, "one start more than rows");
        }
    }

    #[test]
    fn costs_are_measured_and_savings_add_up() {
        let cost = Cost::measured();
        assert!(cost.milliseconds_per_entry > 0.0 && cost.milliseconds_per_entry < 1.0);
        let rows = RowSizes { rows: 10, entries: 1000, bytes: 4 }.saving(&cost, 2.0);
        assert_eq!(rows.milliseconds, 2000.0 * cost.milliseconds_per_entry);
        let both = rows + Cost { seconds_per_ray: 1e-6, ..cost }.rays(1_000_000);
        assert_eq!((both.file_bytes, both.gpu_bytes, both.seconds), (4080, 4040, 1.0));
    }

    #[test]
    fn a_saving_is_told_in_what_it_saves() {
        let saving = Saving { file_bytes: 2_500_000, seconds: 12.0, ..Saving::default() };
        assert_eq!(saving.to_string(), "2.5 MB of file, about 12.00 s of bake");
        assert_eq!(Saving::default().to_string(), "");
    }
}
