//! Shaders: WGSL files that import each other (naga_oil), embedded into the program.

use std::borrow::Cow;
use std::sync::{Mutex, PoisonError};

use naga_oil::compose::{
    ComposableModuleDescriptor, Composer, ComposerError, NagaModuleDescriptor, ShaderDefValue,
};
use wgpu::naga;

use super::{Gpu, GpuError};

/// A file's name under `shaders/` and its text.
#[derive(Clone, Copy, Debug)]
pub struct Source {
    pub name: &'static str,
    pub text: &'static str,
}

/// Knows the files that others import, in an order in which each stands behind those it imports.
pub struct Library {
    composer: Mutex<Composer>,
}

impl Library {
    pub fn new(imported: &[Source]) -> Result<Self, GpuError> {
        let mut composer = Composer::default();
        for source in imported {
            let described = ComposableModuleDescriptor {
                source: source.text,
                file_path: source.name,
                ..Default::default()
            };
            if let Err(error) = composer.add_composable_module(described) {
                return Err(refused(&composer, source.name, &error));
            }
        }
        Ok(Self { composer: Mutex::new(composer) })
    }

    /// The file with everything that it imports.
    pub fn compose(&self, source: Source) -> Result<naga::Module, GpuError> {
        self.compose_with(source, &[])
    }

    /// The same where these names are defined, in it and in what it imports.
    pub fn compose_with(&self, source: Source, defines: &[&str]) -> Result<naga::Module, GpuError> {
        let defined = |name: &&str| ((*name).to_owned(), ShaderDefValue::Bool(true));
        let described = NagaModuleDescriptor {
            source: source.text,
            file_path: source.name,
            shader_defs: defines.iter().map(defined).collect(),
            ..Default::default()
        };
        let mut composer = self.composer.lock().unwrap_or_else(PoisonError::into_inner);
        let composed = composer.make_naga_module(described);
        composed.map_err(|error| refused(&composer, source.name, &error))
    }

    pub fn module(
        &self,
        gpu: &Gpu,
        source: Source,
        defines: &[&str],
    ) -> Result<wgpu::ShaderModule, GpuError> {
        let module = self.compose_with(source, defines)?;
        Ok(gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(source.name),
            source: wgpu::ShaderSource::Naga(Cow::Owned(module)),
        }))
    }
}

fn refused(composer: &Composer, name: &'static str, error: &ComposerError) -> GpuError {
    GpuError::Shader { name, message: error.emit_to_string(composer) }
}
