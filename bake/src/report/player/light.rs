//! The light that the GPU solved, as `hohlraum-play --light` writes it.

use engine::transport::Transport;
use engine::transport::sh::COEFFICIENTS;
use glam::{DVec3, Vec3};

/// Light as it lies on the GPU [W/m2].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GpuLight {
    /// E by patch: emitted, and reflected once from punctual lights.
    pub exitance: Vec<DVec3>,
    /// B by patch, then the sky patches' pi times radiance.
    pub radiosity: Vec<DVec3>,
    /// By receiver, without what comes straight from punctual lights.
    pub irradiance: Vec<DVec3>,
    /// Nine a probe [W/m2/sr]; empty where nothing reads probes.
    pub probes: Vec<DVec3>,
}

impl GpuLight {
    /// Of the columns space,index,r,g,b, every space in the order of its indices. The GPU's numbers are singles.
    pub fn read(text: &[u8]) -> Result<Self, String> {
        let mut light = Self::default();
        let mut reader = csv::Reader::from_reader(text);
        for row in reader.deserialize() {
            let (space, index, red, green, blue): (String, usize, f32, f32, f32) =
                row.map_err(|error| error.to_string())?;
            let values = match space.as_str() {
                "exitance" => &mut light.exitance,
                "radiosity" => &mut light.radiosity,
                "irradiance" => &mut light.irradiance,
                "probes" => &mut light.probes,
                other => return Err(format!("there is no space `{other}`")),
            };
            let value = Vec3::new(red, green, blue).as_dvec3();
            if index != values.len() || !value.is_finite() {
                return Err(format!("{space} {index} is out of order or no light: {value}"));
            }
            values.push(value);
        }
        Ok(light)
    }

    /// Whether it is of this bake.
    pub fn fits(&self, transport: &Transport) -> bool {
        let probes = [0, COEFFICIENTS * transport.probes.len()];
        self.exitance.len() == transport.patches.len()
            && self.radiosity.len() == transport.columns()
            && self.irradiance.len() == transport.receivers.len()
            && probes.contains(&self.probes.len())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_is_read_space_by_space() {
        let text = b"space,index,r,g,b\nexitance,0,0.1,0,0\nradiosity,0,1,2,3\nradiosity,1,4,5,6e-9\n";
        let light = GpuLight::read(text).unwrap();
        assert_eq!(light.exitance, [DVec3::X * f64::from(0.1_f32)]);
        assert_eq!(light.radiosity[1], DVec3::new(4.0, 5.0, f64::from(6e-9_f32)));
        assert!(light.irradiance.is_empty() && !light.fits(&Transport::default()));
        assert!(GpuLight::default().fits(&Transport::default()));
    }

    #[test]
    fn light_that_makes_no_sense_is_refused() {
        for row in [
            "radiosity,1,0,0,0",
            "radiosity,0,NaN,0,0",
            "radiosity,0,inf,0,0",
            "hall,0,0,0,0",
            "radiosity,0,1",
        ] {
            let text = format!("space,index,r,g,b\n{row}\n");
            assert!(GpuLight::read(text.as_bytes()).is_err(), "{row}");
        }
    }
}
