//! What patches are made of and what they and the sky emit, followed on the CPU and sent to the GPU where it
//! changed; and the cavity gain, which follows from albedo, and decides how the light is iterated.

use std::sync::{Arc, mpsc};

use glam::Vec3;

use super::Settings;
use super::channels::is_grey;
use super::coarse::Coarse;
use super::frame::Now;
use super::spaces::Spaces;
use super::unit;
use crate::gpu::{Gpu, GpuError};
use crate::scene::{Forced, Sky};
use crate::transport::materials::{PatchMaterials, of_patches};
use crate::transport::solve::{self, Choice, Method, System, choose_for_frames};
use crate::transport::{Transport, sky as sky_patches};

pub struct Sources {
    transport: Arc<Transport>,
    unlimited_gain: bool,
    /// What the author says of the coarse correction.
    coarse: Option<Forced>,
    /// Wait for what is solved for on another thread.
    wait: bool,
    held: Option<Held>,
    /// Of the unit of radiosity.
    exponent: i32,
    gain: f32,
    /// Nothing reflects anything.
    black: bool,
    /// A better one, being solved for on another thread.
    coming: Option<mpsc::Receiver<f32>>,
    choice: Choice,
}

/// As it was followed last.
#[derive(Default)]
struct Held {
    materials: PatchMaterials,
    sky: Sky,
    /// By sky patch; empty where the transport has none.
    radiance: Vec<Vec3>,
    /// Any of it is not grey.
    is_coloured: bool,
}

/// What differs from the last frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Changed {
    pub albedo: bool,
    /// Of patches or sky.
    pub emission: bool,
    /// Old unit of radiosity by new unit.
    pub rescaled: Option<f32>,
}

impl Changed {
    /// All of it is new.
    pub fn and_all(self) -> Self {
        Self { albedo: true, emission: true, ..self }
    }
}

impl Sources {
    pub fn new(transport: Arc<Transport>, settings: &Settings, coarse: Option<Forced>) -> Self {
        let choice = choose_for_frames(&transport.patch_from_patch, &transport.patches, 1.0);
        Self {
            transport,
            unlimited_gain: settings.unlimited_gain,
            coarse,
            wait: settings.wait,
            held: None,
            exponent: 0,
            gain: 1.0,
            black: false,
            coming: None,
            choice,
        }
    }

    /// Follows materials and sky. `brightest`: of punctual lights, and of what still bounces [W/m2].
    pub fn update(
        &mut self,
        (now, sky): (&Now<'_>, &Sky),
        materials_changed: bool,
        brightest: f32,
    ) -> Changed {
        if self.transport.solved.is_some() {
            return Changed::default();
        }
        let first = self.held.is_none();
        let mut held = self.held.take().unwrap_or_default();
        let mut changed = Changed { albedo: first, emission: first, rescaled: None };
        if materials_changed || first {
            let new = self.materials(now);
            changed.albedo |= new.albedo != held.materials.albedo;
            changed.emission |= new.exitance != held.materials.exitance;
            held.materials = new;
        }
        if self.transport.sky_patches > 0 && (first || held.sky != *sky) {
            held.radiance = sky_patches::radiance_of_patches(sky, now.assets);
            held.radiance.truncate(self.transport.sky_patches as usize);
            changed.emission = true;
        }
        held.sky = sky.clone();
        if changed != Changed::default() {
            let is_coloured = !held.all().all(is_grey);
            held.is_coloured = is_coloured;
        }
        let exponent = unit::exponent(self.exponent, brightest.max(held.brightest()));
        if exponent != self.exponent {
            // In steps that are no overflow themselves: what was stored is near 1.
            let apart = (self.exponent - exponent).clamp(-120, 120);
            changed.rescaled = Some((apart as f32).exp2());
            self.exponent = exponent;
        }
        self.held = Some(held);
        changed
    }

    /// What of it is new to the GPU: what `changed`, or all of it where the light's spaces are others.
    pub fn upload(
        &mut self,
        gpu: &Gpu,
        changed: Changed,
        spaces: &Spaces,
        coarse: &mut Coarse,
    ) -> Result<(), GpuError> {
        let Some(held) = self.held.take() else { return Ok(()) };
        if changed.albedo {
            spaces.set_albedo(gpu, &held.materials.albedo);
            self.follow_albedo(gpu, &held.materials.albedo, coarse)?;
        }
        self.follow_gain(gpu, coarse)?;
        if changed.emission || changed.rescaled.is_some() {
            spaces.set_emission(gpu, &held.materials.exitance, self.unit());
            spaces.set_sky(gpu, &held.radiance, self.unit());
        }
        self.held = Some(held);
        Ok(())
    }

    /// Whether a surface or the sky has a colour.
    pub fn is_coloured(&self) -> bool {
        self.held.as_ref().is_some_and(|held| held.is_coloured)
    }

    /// W/m2 of one stored unit of radiosity.
    pub fn unit(&self) -> f32 {
        (self.exponent as f32).exp2()
    }

    /// Does a surface or the sky shine by itself?
    pub fn shines(&self) -> bool {
        self.held.as_ref().is_some_and(|held| held.brightest() > 0.0)
    }

    pub fn sky_shines(&self) -> bool {
        self.held.as_ref().is_some_and(|held| largest(&held.radiance) > 0.0)
    }

    /// Does no patch reflect? B is then E.
    pub fn is_black(&self) -> bool {
        self.black
    }

    /// For every patch, with the albedo that closed rooms can bear.
    fn materials(&self, now: &Now<'_>) -> PatchMaterials {
        let mut materials = of_patches(&self.transport, now.scene, now.assets);
        if !self.unlimited_gain {
            let rows = &self.transport.patch_from_patch;
            solve::limit_gain(rows, &self.transport.patches, &mut materials.albedo);
        }
        materials
    }

    fn follow_albedo(&mut self, gpu: &Gpu, albedo: &[Vec3], coarse: &mut Coarse) -> Result<(), GpuError> {
        let rows = &self.transport.patch_from_patch;
        self.gain = stand_in(&self.transport, albedo);
        self.black = albedo.iter().all(|albedo| *albedo == Vec3::ZERO);
        let system = System { rows, patches: &self.transport.patches, albedo };
        self.choice = self.chosen();
        let corrected = self.choice.method == Method::TwoLevel;
        coarse.set(gpu, &if corrected { solve::Coarse::new(&system) } else { solve::Coarse::default() })?;
        let (sender, receiver) = mpsc::channel();
        let (transport, albedo) = (self.transport.clone(), albedo.to_vec());
        std::thread::spawn(move || {
            let system =
                System { rows: &transport.patch_from_patch, patches: &transport.patches, albedo: &albedo };
            let gains = solve::cavity_gain(&system);
            let largest = gains.iter().fold(1.0_f64, |max, gain| max.max(gain.max_element()));
            // Nobody listens where the albedo has changed again.
            let _ = sender.send(largest as f32);
        });
        self.coming = Some(receiver);
        Ok(())
    }

    /// Takes the gain that was solved for, if it is there: it is smaller than what stood in for it, and may show that
    /// no correction is needed.
    fn follow_gain(&mut self, gpu: &Gpu, coarse: &mut Coarse) -> Result<(), GpuError> {
        let Some(coming) = &self.coming else { return Ok(()) };
        let come = if self.wait { coming.recv().ok() } else { coming.try_recv().ok() };
        let Some(gain) = come else { return Ok(()) };
        self.coming = None;
        // Solved to seven digits; a little is added to be on the safe side.
        self.gain = self.gain.min(gain * 1.001);
        let chosen = self.chosen();
        let before = std::mem::replace(&mut self.choice, chosen);
        if self.choice.method == Method::Jacobi && before.method == Method::TwoLevel {
            coarse.set(gpu, &solve::Coarse::default())?;
        }
        Ok(())
    }

    /// The largest: solved for where that is done, else what stands in for it.
    pub fn cavity_gain(&self) -> f32 {
        self.gain
    }

    fn chosen(&self) -> Choice {
        let transport = &self.transport;
        let gain = match self.coarse {
            // As if light wandered for ever.
            Some(Forced::In) => f64::INFINITY,
            Some(Forced::Out) => 1.0,
            None => f64::from(self.gain),
        };
        choose_for_frames(&transport.patch_from_patch, &transport.patches, gain)
    }

    /// How frames iterate.
    pub fn choice(&self) -> Choice {
        self.choice
    }
}

impl Held {
    /// Of what surfaces and sky give [W/m2].
    fn brightest(&self) -> f32 {
        largest(&self.materials.exitance).max(largest(&self.radiance) * std::f32::consts::PI)
    }

    fn all(&self) -> impl Iterator<Item = &Vec3> {
        let PatchMaterials { albedo, exitance } = &self.materials;
        albedo.iter().chain(exitance).chain(&self.radiance)
    }
}

fn largest(values: &[Vec3]) -> f32 {
    values.iter().map(|value| value.max_element()).fold(0.0, f32::max)
}

/// max w <= 1 / (1 - max of rho_i times the sum of row i), as (I - RP) w = 1.
fn stand_in(transport: &Transport, albedo: &[Vec3]) -> f32 {
    let kept = albedo
        .iter()
        .enumerate()
        .map(|(i, albedo)| f64::from(albedo.max_element()) * transport.patch_from_patch.sum(i));
    let most = kept.fold(0.0, f64::max);
    (1.0 / (1.0 - most).max(1e-7)) as f32
}
