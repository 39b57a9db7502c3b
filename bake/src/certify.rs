//! The certificate: every statement computed from the arrays as they are stored.

use engine::scene::{Scene, Warning};
use engine::transport::materials::PatchMaterials;
use engine::transport::sh::COEFFICIENTS;
use engine::transport::solve::{GAIN_LIMIT, System, cavity_gain, exact, gather, limit_gain};
use engine::transport::{Certificate, Transport};
use glam::DVec3;
use rayon::prelude::*;

use crate::directional;

/// What only the scene's materials decide: the cavity gain, whose albedo is limited, whether energy is kept, the
/// predicted noise.
pub fn certify_materials(
    certificate: &mut Certificate,
    transport: &Transport,
    scene: &Scene,
    materials: &mut PatchMaterials,
    unlimited: bool,
) -> Vec<Warning> {
    let mut warnings = Vec::new();
    certificate.unlimited_gain = unlimited;
    if !unlimited {
        let limited = limit_gain(&transport.patch_from_patch, &transport.patches, &mut materials.albedo);
        for component in limited {
            let name = entity_name(transport, scene, |i| transport.patches[i].component == component);
            let message = format!(
                "light in the closed room around it would be multiplied by more than {GAIN_LIMIT:.0}; its albedo is limited \
                 (`unlimited_gain: true` in project.ron lifts the limit)"
            );
            warnings.push(Warning::new(format!("entity `{name}`"), message));
        }
    }
    let system =
        System { rows: &transport.patch_from_patch, patches: &transport.patches, albedo: &materials.albedo };
    let w = cavity_gain(&system);
    let stiffest = (0..w.len()).max_by(|&a, &b| w[a].max_element().total_cmp(&w[b].max_element()));
    certificate.cavity_gain = stiffest.map_or(1.0, |i| w[i].max_element());
    certificate.cavity_gain_entity =
        stiffest.map_or(String::new(), |stiffest| entity_name(transport, scene, |i| i == stiffest));
    let lit = Lit::solve(&system, transport, materials);
    certificate.energy_defect = energy_defect(&lit, transport, materials);
    certificate.noise = noise(&lit, transport, certificate.rays_per_row);
    warnings
}

fn entity_name(transport: &Transport, scene: &Scene, of: impl Fn(usize) -> bool) -> String {
    let patch = (0..transport.patches.len()).find(|&i| of(i));
    let id = patch.map(|i| transport.surface.batches[transport.patches[i].batch as usize].entity());
    id.and_then(|id| scene.entity(id)).map_or(String::new(), |entity| entity.name.clone())
}

/// The scene under its own emitters and a white sky, solved: what the patches have by themselves and from the sky,
/// their radiosity, the irradiance that arrives [W/m2].
struct Lit {
    from_sky: Vec<DVec3>,
    radiosity: Vec<DVec3>,
    irradiance: Vec<DVec3>,
    /// Of all columns, sky patches last.
    values: Vec<DVec3>,
}

impl Lit {
    fn solve(system: &System, transport: &Transport, materials: &PatchMaterials) -> Self {
        let n = transport.patches.len();
        let mut values: Vec<DVec3> = vec![DVec3::ZERO; transport.columns()];
        values[n..].fill(DVec3::ONE);
        let from_sky = gather(&transport.patch_from_patch, &values);
        let e: Vec<DVec3> = (0..n)
            .map(|i| materials.exitance[i].as_dvec3() + materials.albedo[i].as_dvec3() * from_sky[i])
            .collect();
        let radiosity = exact(system, &e, 1e-9);
        values[..n].copy_from_slice(&radiosity);
        let irradiance = gather(&transport.patch_from_patch, &values);
        Self { from_sky, radiosity, irradiance, values }
    }
}

/// The share of all light that appears from nowhere or vanishes, by channel the worst:
/// ```text
/// in    Sum A_i (M_i + H_sky,i)            out    Sum A_i ((1 - rho_i) H_i + B_i (1 - Sum_j P_ij))
/// ```
/// with what patches absorb, and what they send to the sky or lose. Equal where P is reciprocal and B is the solution.
fn energy_defect(lit: &Lit, transport: &Transport, materials: &PatchMaterials) -> f64 {
    let n = transport.patches.len();
    let kept = gather(&transport.patch_from_patch, &ones(n, transport.columns()));
    let (mut come, mut gone) = (DVec3::ZERO, DVec3::ZERO);
    for (i, patch) in transport.patches.iter().enumerate() {
        let area = f64::from(patch.area);
        let absorbed = (DVec3::ONE - materials.albedo[i].as_dvec3()) * lit.irradiance[i];
        come += area * (materials.exitance[i].as_dvec3() + lit.from_sky[i]);
        gone += area * (absorbed + lit.radiosity[i] * (DVec3::ONE - kept[i]));
    }
    let share = |channel: usize| match come[channel] {
        come if come > 0.0 => (come - gone[channel]).abs() / come,
        _ => gone[channel].abs(),
    };
    (0..3).map(share).fold(0.0, |worst, share| if share > worst || share.is_nan() { share } else { worst })
}

/// 1 for each patch, 0 for the sky.
fn ones(patches: usize, columns: usize) -> Vec<DVec3> {
    (0..columns).map(|column| if column < patches { DVec3::ONE } else { DVec3::ZERO }).collect()
}

/// sigma_i / H_i with sigma_i^2 = (Sum_j P_ij B_j^2 - H_i^2) / R: what independent rays would leave. Median and 95th
/// percentile over patches.
fn noise(lit: &Lit, transport: &Transport, rays: u32) -> [f64; 2] {
    let h = &lit.irradiance;
    let squares: Vec<DVec3> = lit.values.iter().map(|b| *b * *b).collect();
    let h2 = gather(&transport.patch_from_patch, &squares);
    let mut relative: Vec<f64> = (0..h.len())
        .filter(|&i| h[i].y > 0.0)
        .map(|i| ((h2[i].y - h[i].y * h[i].y).max(0.0) / f64::from(rays.max(1))).sqrt() / h[i].y)
        .collect();
    relative.sort_by(f64::total_cmp);
    let at = |share: f64| relative.get((share * relative.len() as f64) as usize).copied().unwrap_or(0.0);
    [at(0.5), at(0.95)]
}

/// What the stored rows say of themselves.
pub fn certify_rows(certificate: &mut Certificate, transport: &Transport) {
    let rows = &transport.patch_from_patch;
    let n = transport.patches.len();
    let target = |i: usize| f64::from(transport.patches[i].target);
    let defects: Vec<f64> = (0..n).into_par_iter().map(|i| rows.sum(i) - target(i)).collect();
    certificate.row_sum_defect = defects.iter().fold(0.0, |max, defect| max.max(defect.abs()));
    certificate.row_sum_excess = defects.iter().fold(0.0, |max, defect| max.max(*defect));
    certificate.asymmetry = asymmetry(transport);
    certificate.receiver_sum_excess = (0..transport.receivers.len())
        .map(|i| transport.receiver_from_patch.sum(i) - 1.0)
        .fold(0.0, f64::max);
    certificate.probe_sum_excess = probe_sum_excess(transport);
    certificate.directional_sum_excess = directional::sum_excess(&transport.directional_from_patch);
    certificate.least_entry =
        rows.weights.iter().copied().map(f64::from).fold(f64::INFINITY, f64::min).min(1.0);
}

/// max |A_i P_ij - A_j P_ji| / max A_i P_ij.
fn asymmetry(transport: &Transport) -> f64 {
    let rows = &transport.patch_from_patch;
    let n = transport.patches.len();
    let area = |i: usize| f64::from(transport.patches[i].area);
    let entry = |i: usize, j: u32| {
        let range = rows.range(i);
        let at = rows.columns[range.clone()].binary_search(&j).ok();
        at.map_or(0.0, |at| f64::from(rows.weights[range.start + at]))
    };
    let (worst, largest) = (0..n)
        .into_par_iter()
        .map(|i| {
            let patches = rows.row(i).take_while(|&(j, _)| (j as usize) < n);
            patches.fold((0.0_f64, 0.0_f64), |(worst, largest), (j, weight)| {
                let (there, back) =
                    (area(i) * f64::from(weight), area(j as usize) * entry(j as usize, i as u32));
                (worst.max((there - back).abs()), largest.max(there))
            })
        })
        .reduce(|| (0.0, 0.0), |a, b| (a.0.max(b.0), a.1.max(b.1)));
    if largest > 0.0 { worst / largest } else { 0.0 }
}

/// By how much the constant coefficient of a probe exceeds the whole sphere's, 2 sqrt(pi) / pi for B = 1 all around;
/// relative.
fn probe_sum_excess(transport: &Transport) -> f64 {
    let whole = 2.0 / std::f64::consts::PI.sqrt();
    let rows = &transport.probe_from_patch;
    (0..transport.probes.len()).map(|k| rows.sum(k * COEFFICIENTS) / whole - 1.0).fold(0.0, f64::max)
}
