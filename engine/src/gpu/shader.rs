//! Shaders: WGSL files that import each other (naga_oil), embedded into the program.

use std::borrow::Cow;

use naga_oil::compose::{ComposableModuleDescriptor, Composer, ComposerError, NagaModuleDescriptor};
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
    composer: Composer,
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
        Ok(Self { composer })
    }

    /// The file with everything that it imports.
    pub fn compose(&mut self, source: Source) -> Result<naga::Module, GpuError> {
        let described =
            NagaModuleDescriptor { source: source.text, file_path: source.name, ..Default::default() };
        let composed = self.composer.make_naga_module(described);
        composed.map_err(|error| refused(&self.composer, source.name, &error))
    }

    pub fn module(&mut self, gpu: &Gpu, source: Source) -> Result<wgpu::ShaderModule, GpuError> {
        let module = self.compose(source)?;
        Ok(gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(source.name),
            source: wgpu::ShaderSource::Naga(Cow::Owned(module)),
        }))
    }
}

fn refused(composer: &Composer, name: &'static str, error: &ComposerError) -> GpuError {
    GpuError::Shader { name, message: error.emit_to_string(composer) }
}
