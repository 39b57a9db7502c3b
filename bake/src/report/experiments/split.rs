//! Where the error comes from: one switch at a time.
//!
//! A chain of irradiance fields at the same points, from what the player shows to the path tracer; each differs from the
//! next in one thing, and the difference, a signed field, is that thing's part. Parts add up to the total because fields
//! do, if nothing is missing: the total is measured by another way, from what the GPU gathered at the receivers itself
//! (or, without a player, the CPU in f32). Both ends meet the same path-traced field p, whose noise is in the last part and
//! in the total alike. Against p1 for the parts and p2 for the total the sum misses by p2 - p1 more, which is nothing but
//! noise if the path tracer's standard errors s are right: over n points with three channels each, all alike,
//!
//! ```text
//! |p2 - p1|^2  ~  Sum_i v_i (1 +- spread)      v_i = s1_i^2 + s2_i^2      spread^2 = 2 (1 + 1/15) Sum_i v_i^2 / (Sum_i v_i)^2
//! ```
//! (2 of a square of normal noise, and its fifteenth since s comes from two sets of 16 replicates.)

use engine::transport::{Rows, Transport};
use glam::{DVec3, Vec3};

use super::bytes::radiosity;
use super::lit::{Lit, difference, weights};
use super::matrix::Exactly;
use super::truth::Truth;
use crate::Point;
use crate::query::Place;
use crate::report::model::{Error, Part, Seeds, Split, WorstPlace};
use crate::report::player::GpuLight;

/// Places on a patch where direct light is taken for the truth.
pub const MANY_SAMPLES: u32 = 256;
/// Places that are named.
const WORST: usize = 5;

/// One field of the chain, or why it is missing.
struct Link {
    /// The part between this and the field before.
    part: &'static str,
    /// What the field is.
    what: &'static str,
    field: Result<Vec<f64>, String>,
}

/// What the chain is made of.
pub struct Chain<'a> {
    pub lit: &'a Lit<'a>,
    pub points: &'a [Point],
    pub places: &'a [Option<Place>],
    /// From punctual lights, by patch, from many samples.
    pub direct_exactly: &'a [Vec3],
    /// The exact solution of the stored rows, and what the CPU's f32 iteration ends with.
    pub exact: &'a [DVec3],
    pub iterated: &'a [DVec3],
    pub gpu: Option<&'a GpuLight>,
    /// Patches' rows as counted, where they were traced again.
    pub raw: Result<Rows, String>,
    pub exactly: Option<&'a Exactly>,
    pub truth: &'a Truth,
}

impl Chain<'_> {
    pub fn split(&self) -> Split {
        let (parts, fields) = self.parts();
        let mut sum = vec![0.0; self.truth.field.len()];
        fields.iter().for_each(|(_, field)| sum.iter_mut().zip(field).for_each(|(sum, e)| *sum += e));
        let shown = self.shown();
        let total = difference(&shown, &self.truth.field);
        Split {
            about: self.about(),
            unexplained: missing(&sum, &total),
            seeds: self.seeds(&sum, &shown, &total),
            worst: worst(self.points, &fields, &shown, &self.truth.field),
            parts,
            total: self.error(&total),
            reference_error: self.truth.standard_error,
        }
    }

    /// The parts, of which the last ends at one half of the reference, against the total, which is measured by the other.
    fn seeds(&self, sum: &[f64], shown: &[f64], total: &[f64]) -> Seeds {
        let [one, other] = &self.truth.halves;
        let by_one: Vec<f64> =
            sum.iter().zip(&self.truth.field).zip(one).map(|((sum, mean), one)| sum + mean - one).collect();
        let missed = rms(&difference(&by_one, &difference(shown, other)));
        let size = rms(total);
        if size == 0.0 {
            return Seeds::default();
        }
        let apart = &self.truth.apart;
        let points = apart.len() / 3;
        let sum: f64 = apart.iter().sum();
        let of_point = |i: usize| (0..3).map(|channel| apart[channel * points + i]).sum::<f64>();
        let squares: f64 = (0..points).map(|i| of_point(i).powi(2)).sum();
        Seeds {
            missed: missed / size,
            noise: (sum / apart.len().max(1) as f64).sqrt() / size,
            spread: if sum > 0.0 { (2.0 * (1.0 + 1.0 / 15.0) * squares).sqrt() / sum } else { 0.0 },
        }
    }

    /// Of all links, and the fields of those that were measured.
    fn parts(&self) -> (Vec<Part>, Vec<(&'static str, Vec<f64>)>) {
        let mut parts = Vec::new();
        let mut fields = Vec::new();
        let mut last: Option<(&str, Vec<f64>)> = None;
        for Link { part, what, field } in self.links() {
            let mut found = Part { name: part.to_owned(), ..Part::default() };
            match (field, &last) {
                (Err(why), _) => found.left_out = Some(why),
                (Ok(field), None) => {
                    last = Some((what, field));
                    continue;
                }
                (Ok(field), Some((before, from))) => {
                    let e = difference(from, &field);
                    found.compared = format!("{before} against {what}");
                    found.error = self.error(&e);
                    fields.push((part, e));
                    last = Some((what, field));
                }
            }
            parts.push(found);
        }
        (parts, fields)
    }

    fn error(&self, field: &[f64]) -> Error {
        Error::of_field(field, &self.truth.field, &weights(field))
    }

    fn about(&self) -> String {
        let shown =
            if self.gpu.is_some() { "the irradiance that the GPU gathered" } else { "the CPU's, in f32" };
        format!(
            "Irradiance at {} points, without what comes straight from punctual lights, the scene as it is at its start. \
             Each part is a field, what one switch changes; the fields are added and compared with the total, which is \
             measured by itself: {shown}, against the path tracer.",
            self.places.len()
        )
    }

    /// From the player to the path tracer.
    fn links(&self) -> Vec<Link> {
        let lit = self.lit;
        let rows = &lit.transport.patch_from_patch;
        let show = |b: &[DVec3]| lit.shown(b, self.places);
        let none = |why: &str| Err(why.to_owned());
        let gpu = self
            .gpu
            .ok_or_else(|| "no player, or nothing to draw with: the chain begins on the CPU".to_owned());
        let iterated = show(self.iterated);
        let exactly = show(&lit.solve(rows, &lit.e(rows, self.direct_exactly)));
        let raw = self.raw.as_ref().map(|raw| show(&radiosity(lit, raw, self.direct_exactly, self.exact)));
        let reference = |field: fn(&Exactly) -> &Vec<f64>| match self.exactly {
            Some(exactly) => Ok(field(exactly).clone()),
            None => Err("no matrix reference: its share lies in discretisation".to_owned()),
        };
        let link = |part, what, field| Link { part, what, field };
        vec![
            link(
                "GPU",
                "the GPU's radiosity",
                gpu.map(|gpu| show(&gpu.radiosity[..lit.transport.patches.len()])),
            ),
            link("GPU", "the same iteration on the CPU in f32", Ok(iterated)),
            link("solver", "the exact solution of the stored rows", Ok(show(self.exact))),
            link("lag", "", none("light stands still here: its worst frames are in the diagrams of lag")),
            link("direct sampling", "direct light from 256 samples a patch", Ok(exactly)),
            link(
                "quantisation",
                "",
                none(
                    "not by itself: its share lies in form factors; the diagram of bytes has other forms of the rows",
                ),
            ),
            link("compression", "", none("rows are stored whole")),
            link("balance", "rows as their rays counted them", raw.map_err(Clone::clone)),
            link("form factors", "the matrix reference at the receivers", reference(|one| &one.at_receivers)),
            link("reconstruction", "the matrix reference at the points", reference(|one| &one.at_points)),
            link("discretisation", "the path tracer", Ok(self.truth.field.clone())),
        ]
    }

    /// By another way than the chain's first field.
    fn shown(&self) -> Vec<f64> {
        let irradiance = match self.gpu {
            Some(gpu) => gpu.irradiance.clone(),
            None => gathered_in_f32(self.lit.transport, &self.lit.columns(self.iterated)),
        };
        self.lit.blended(&irradiance, self.places)
    }
}

/// The places that have most of the squares of what is shown against the reference, and the largest part there.
fn worst(
    points: &[Point],
    parts: &[(&'static str, Vec<f64>)],
    shown: &[f64],
    reference: &[f64],
) -> Vec<WorstPlace> {
    let n = points.len();
    let at = |field: &[f64], k: usize| DVec3::from_array(std::array::from_fn(|c| field[c * n + k]));
    let squares: Vec<f64> = (0..n).map(|k| (at(shown, k) - at(reference, k)).length_squared()).collect();
    let all: f64 = squares.iter().sum();
    let mut order: Vec<usize> = (0..n).filter(|&k| squares[k] > 0.0).collect();
    order.sort_by(|&a, &b| squares[b].total_cmp(&squares[a]));
    let place = |&k: &usize| {
        let size = |(_, field): &&(&str, Vec<f64>)| at(field, k).length_squared();
        let largest = parts.iter().max_by(|a, b| size(a).total_cmp(&size(b)));
        WorstPlace {
            position: points[k].position,
            normal: points[k].normal,
            shown: at(shown, k).element_sum() / 3.0,
            reference: at(reference, k).element_sum() / 3.0,
            share: squares[k] / all,
            part: largest.map_or(String::new(), |(part, _)| (*part).to_owned()),
        }
    };
    order.iter().take(WORST).map(place).collect()
}

/// H = G B as a GPU adds it up: in f32, entry by entry.
fn gathered_in_f32(transport: &Transport, values: &[DVec3]) -> Vec<DVec3> {
    let values: Vec<Vec3> = values.iter().map(|value| value.as_vec3()).collect();
    let rows = &transport.receiver_from_patch;
    let row =
        |i: usize| -> Vec3 { rows.row(i).map(|(column, weight)| values[column as usize] * weight).sum() };
    (0..rows.len()).map(|i| row(i).as_dvec3()).collect()
}

/// rms of what two fields differ by, over the second's.
fn missing(found: &[f64], wanted: &[f64]) -> f64 {
    let size = rms(wanted);
    if size > 0.0 { rms(&difference(found, wanted)) / size } else { 0.0 }
}

fn rms(field: &[f64]) -> f64 {
    (field.iter().map(|e| e * e).sum::<f64>() / field.len().max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Channel after channel, the same in all three.
    fn grey(values: &[f64]) -> Vec<f64> {
        values.repeat(3)
    }

    #[test]
    fn the_worst_places_come_first_with_their_share_and_their_largest_part() {
        let at = |x: f64| Point { position: DVec3::X * x, normal: DVec3::Y };
        let points: Vec<Point> = (0..8).map(|k| at(f64::from(k))).collect();
        let reference = grey(&[1.0; 8]);
        // Squares 0, 1, 9, 0, 4, 0, 2, 0 of 16.
        let off = [0.0, 1.0, -3.0, 0.0, 2.0, 0.0, 2.0_f64.sqrt(), 0.0];
        let shown = grey(&off.map(|off| 1.0 + off));
        let patches = grey(&off.map(|off| if off < 0.0 { off } else { 0.1 }));
        let rays = grey(&off.map(|off| if off < 0.0 { 0.0 } else { off - 0.1 }));
        let found = worst(&points, &[("patches", patches), ("rays", rays)], &shown, &reference);
        let told: Vec<(f64, &str)> =
            found.iter().map(|place| (place.position.x, place.part.as_str())).collect();
        assert_eq!(told, [(2.0, "patches"), (4.0, "rays"), (6.0, "rays"), (1.0, "rays")]);
        for (place, squares) in found.iter().zip([9.0, 4.0, 2.0, 1.0]) {
            assert!((place.share - squares / 16.0).abs() < 1e-12, "{place:?}");
        }
        assert_eq!((found[0].shown, found[0].reference), (-2.0, 1.0));
        let many: Vec<f64> = (0..8).map(f64::from).collect();
        assert_eq!(worst(&points, &[], &grey(&many), &reference).len(), WORST);
        assert!(worst(&points, &[], &reference, &reference).is_empty());
        assert!(worst(&[], &[], &[], &[]).is_empty());
    }
}
