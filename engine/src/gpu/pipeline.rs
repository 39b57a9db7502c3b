//! Pipelines that are made when they are first used: a scene compiles what it draws with and nothing else, not even the
//! shader files of what it does without.

use std::collections::HashMap;
use std::hash::Hash;
use std::sync::{Arc, Mutex, PoisonError};

use super::pass::{self, Groups};
use super::shader::{Library, Source};
use super::{Gpu, GpuError};

/// What shaders are compiled by and for.
pub struct Compiler {
    pub gpu: Arc<Gpu>,
    pub library: Library,
}

/// What tells one pipeline of a shader file from another.
pub trait Variant: Copy + Eq + Hash {
    /// For people.
    fn name(&self) -> String;

    /// What is defined in the file, for `#ifdef`.
    fn defines(&self) -> Vec<&'static str> {
        Vec::new()
    }
}

/// An entry point.
impl Variant for &'static str {
    fn name(&self) -> String {
        (*self).to_owned()
    }
}

/// The pipelines of one shader file.
pub struct Pipelines<Key, Pipeline> {
    compiler: Arc<Compiler>,
    source: Source,
    modules: Mutex<HashMap<Vec<&'static str>, wgpu::ShaderModule>>,
    made: Mutex<HashMap<Key, Pipeline>>,
}

impl<Key: Variant, Pipeline: Clone> Pipelines<Key, Pipeline> {
    pub fn new(compiler: &Arc<Compiler>, source: Source) -> Self {
        let compiler = compiler.clone();
        Self { compiler, source, modules: Mutex::default(), made: Mutex::default() }
    }

    /// `make`s it the first time. `None`: that failed, and the device says so at the end of the frame ([`Gpu::check`]).
    pub fn get(
        &self,
        key: Key,
        make: impl FnOnce(&Gpu, &wgpu::ShaderModule) -> Pipeline,
    ) -> Option<Pipeline> {
        let mut made = self.made.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(pipeline) = made.get(&key) {
            return Some(pipeline.clone());
        }
        let gpu = &*self.compiler.gpu;
        let module = self.module(key.defines());
        match module.and_then(|module| pass::checked(gpu, || make(gpu, &module))) {
            Ok(pipeline) => {
                gpu.compiled(key.name());
                made.insert(key, pipeline.clone());
                Some(pipeline)
            }
            Err(error) => {
                gpu.report(error);
                None
            }
        }
    }

    fn module(&self, defines: Vec<&'static str>) -> Result<wgpu::ShaderModule, GpuError> {
        let mut modules = self.modules.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(module) = modules.get(&defines) {
            return Ok(module.clone());
        }
        let Compiler { gpu, library } = &*self.compiler;
        let module = library.module(gpu, self.source, &defines)?;
        modules.insert(defines, module.clone());
        Ok(module)
    }
}

/// What is defined in a shader file.
pub type Defines = &'static [&'static str];

/// The compute pipelines of one shader file, by entry point and what is defined; all have the same groups.
pub struct Compute {
    pipelines: Pipelines<Entry, wgpu::ComputePipeline>,
    layout: wgpu::PipelineLayout,
}

/// An entry point of a file in which something is defined.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct Entry(&'static str, Defines);

impl Variant for Entry {
    fn name(&self) -> String {
        self.1.iter().fold(self.0.to_owned(), |name, define| format!("{name}, {}", define.to_lowercase()))
    }

    fn defines(&self) -> Vec<&'static str> {
        self.1.to_vec()
    }
}

impl Compute {
    pub fn new(compiler: &Arc<Compiler>, source: Source, groups: &Groups<'_>) -> Self {
        let layout = pass::pipeline_layout(&compiler.gpu, groups);
        Self { pipelines: Pipelines::new(compiler, source), layout }
    }

    /// The pass goes on with this pipeline. Returns whether it is there.
    pub fn set(&self, pass: &mut wgpu::ComputePass<'_>, entry: &'static str, defines: Defines) -> bool {
        let make = |gpu: &Gpu, module: &wgpu::ShaderModule| pass::compute(gpu, module, entry, &self.layout);
        let pipeline = self.pipelines.get(Entry(entry, defines), make);
        if let Some(pipeline) = &pipeline {
            pass.set_pipeline(pipeline);
        }
        pipeline.is_some()
    }
}
