//! The certificate: every statement computed from the arrays as they are stored.

use engine::scene::{Scene, Warning};
use engine::transport::materials::PatchMaterials;
use engine::transport::solve::{GAIN_LIMIT, System, cavity_gain, exact, gather, limit_gain};
use engine::transport::{Certificate, Transport};
use glam::DVec3;
use rayon::prelude::*;

/// What only the scene's materials decide: the cavity gain, whose albedo is limited, the predicted noise.
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
    certificate.noise = noise(&system, transport, materials, certificate.rays_per_row);
    warnings
}

fn entity_name(transport: &Transport, scene: &Scene, of: impl Fn(usize) -> bool) -> String {
    let patch = (0..transport.patches.len()).find(|&i| of(i));
    let id = patch.map(|i| transport.surface.batches[transport.patches[i].batch as usize].entity());
    id.and_then(|id| scene.entity(id)).map_or(String::new(), |entity| entity.name.clone())
}

/// sigma_i / H_i with sigma_i^2 = (Sum_j P_ij B_j^2 - H_i^2) / R: what independent rays would leave, under the
/// scene's own emitters and a white sky. Median and 95th percentile over patches.
fn noise(system: &System, transport: &Transport, materials: &PatchMaterials, rays: u32) -> [f64; 2] {
    let n = transport.patches.len();
    let mut values: Vec<DVec3> = vec![DVec3::ZERO; transport.columns()];
    values[n..].fill(DVec3::ONE);
    let from_sky = gather(&transport.patch_from_patch, &values);
    let e: Vec<DVec3> = (0..n)
        .map(|i| materials.exitance[i].as_dvec3() + materials.albedo[i].as_dvec3() * from_sky[i])
        .collect();
    let b = exact(system, &e, 1e-4);
    values[..n].copy_from_slice(&b);
    let h = gather(&transport.patch_from_patch, &values);
    let squares: Vec<DVec3> = values.iter().map(|b| *b * *b).collect();
    let h2 = gather(&transport.patch_from_patch, &squares);
    let mut relative: Vec<f64> = (0..n)
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
