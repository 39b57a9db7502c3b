//! The light that the GPU solved, as a table: for reports that compare it with the CPU's, and for tools of one's own.
//!
//! ```text
//! space,index,r,g,b
//! exitance    by patch: emitted, and reflected once from punctual lights [W/m2]
//! radiosity   by patch [W/m2]; then, by sky patch, pi times its radiance
//! irradiance  by receiver, without what comes straight from punctual lights [W/m2]
//! probes      nine coefficients a probe [W/m2/sr], in the order of `query --probes`; none where nothing reads them
//! ```

use std::fmt::Write;
use std::path::Path;

use glam::Vec3;

use super::PlayError;
use crate::render::{Renderer, Solved};
use crate::scene::file::write_atomically;

/// Writes the light of the last frame, where somebody wants it.
pub fn write(to: Option<&Path>, renderer: &Renderer) -> Result<(), PlayError> {
    let Some(path) = to else { return Ok(()) };
    let solved = renderer.solved()?;
    Ok(write_atomically(path, table(&solved).as_bytes())?)
}

/// Numbers have the digits that give them back, and no more.
fn table(solved: &Solved) -> String {
    let spaces = [
        ("exitance", &solved.exitance),
        ("radiosity", &solved.radiosity),
        ("irradiance", &solved.irradiance),
        ("probes", &solved.probes),
    ];
    let mut text = "space,index,r,g,b\n".to_owned();
    for (space, values) in spaces {
        for (index, Vec3 { x, y, z }) in values.iter().enumerate() {
            // Into a string, which takes everything.
            let _ = writeln!(text, "{space},{index},{x},{y},{z}");
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_come_back_as_they_were() {
        let value = Vec3::new(0.1, 1.0 / 3.0, 1.5e-38);
        let text = table(&Solved { radiosity: vec![Vec3::ZERO, value], ..Solved::default() });
        let last = text.lines().last().unwrap();
        let rest = last.strip_prefix("radiosity,1,").unwrap();
        let read: Vec<f32> = rest.split(',').map(|number| number.parse().unwrap()).collect();
        assert_eq!(Vec3::from_slice(&read), value);
        assert_eq!(text.lines().count(), 3);
    }
}
