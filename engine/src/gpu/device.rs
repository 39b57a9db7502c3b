//! One GPU device and what it can do.

use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::thread::{self, ThreadId};

use super::GpuError;

/// A device, its queue, and its limits.
pub struct Gpu {
    pub adapter: wgpu::Adapter,
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    pub info: wgpu::AdapterInfo,
    /// No array of a page (see [`super::buffer::pages`]) is larger than this many bytes.
    pub page_bytes: u64,
    /// Drawn by the processor: barriers are slow there, threads few.
    pub software: bool,
    said: Arc<Mutex<Said>>,
    /// Names of all pipelines, in the order in which they were made.
    compiled: Mutex<Vec<String>>,
    /// How often each thread has waited.
    waits: Mutex<HashMap<ThreadId, u64>>,
}

/// Where to look for adapters that need no window: as WGPU_BACKEND says; or else not at OpenGL where Vulkan, Metal or
/// DirectX has a GPU. NVIDIA's driver (580) hung for ever where several threads opened and dropped devices and its
/// OpenGL was asked, too.
pub fn backends() -> wgpu::Backends {
    static FOUND: OnceLock<wgpu::Backends> = OnceLock::new();
    *FOUND.get_or_init(|| {
        if let Some(asked) = wgpu::Backends::from_env() {
            return asked;
        }
        let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
        descriptor.backends = wgpu::Backends::PRIMARY;
        let adapters =
            pollster::block_on(wgpu::Instance::new(descriptor).enumerate_adapters(wgpu::Backends::PRIMARY));
        let has_gpu = adapters.iter().any(|adapter| adapter.get_info().device_type != wgpu::DeviceType::Cpu);
        if has_gpu { wgpu::Backends::PRIMARY } else { wgpu::Backends::all() }
    })
}

/// What the device said of itself since it was last asked.
#[derive(Default)]
struct Said {
    error: Option<GpuError>,
    lost: Option<String>,
}

impl Gpu {
    /// The best adapter that needs no window; WGPU_BACKEND and WGPU_ADAPTER_NAME choose another.
    pub fn headless() -> Result<Self, GpuError> {
        let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
        descriptor.backends = backends();
        Self::open(&wgpu::Instance::new(descriptor.with_env()), None)
    }

    /// The best adapter that can show pictures on `surface`.
    pub fn open(instance: &wgpu::Instance, surface: Option<&wgpu::Surface<'_>>) -> Result<Self, GpuError> {
        let options = wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            compatible_surface: surface,
            ..Default::default()
        };
        let adapter =
            pollster::block_on(instance.request_adapter(&options)).map_err(|_| GpuError::NoAdapter)?;
        Self::from_adapter(adapter)
    }

    pub fn from_adapter(adapter: wgpu::Adapter) -> Result<Self, GpuError> {
        let info = adapter.get_info();
        can_draw(&adapter, &info)?;
        let descriptor = Self::descriptor(&adapter);
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))
            .map_err(|error| GpuError::NoDevice { adapter: info.name.clone(), message: error.to_string() })?;
        Self::from_device(adapter, device, queue)
    }

    /// What a device has to be made with to draw scenes.
    pub fn descriptor(adapter: &wgpu::Adapter) -> wgpu::DeviceDescriptor<'static> {
        wgpu::DeviceDescriptor {
            label: Some("hohlraum"),
            required_features: adapter.features() & WANTED,
            required_limits: adapter.limits(),
            ..Default::default()
        }
    }

    /// A device that somebody else made of [`Self::descriptor`] and draws with too.
    pub fn from_device(
        adapter: wgpu::Adapter,
        device: wgpu::Device,
        queue: wgpu::Queue,
    ) -> Result<Self, GpuError> {
        let info = adapter.get_info();
        can_draw(&adapter, &info)?;
        let limits = device.limits();
        let said = listen(&device);
        let page_bytes = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        let software = info.device_type == wgpu::DeviceType::Cpu;
        Ok(Self {
            adapter,
            device,
            queue,
            info,
            page_bytes,
            software,
            said,
            compiled: Mutex::default(),
            waits: Mutex::default(),
        })
    }

    /// "llvmpipe (LLVM 15.0.6, 256 bits), Gl".
    pub fn name(&self) -> String {
        format!("{}, {:?}", self.info.name, self.info.backend)
    }

    pub fn has(&self, features: wgpu::Features) -> bool {
        self.device.features().contains(features)
    }

    /// The first error that the device reported since this was last asked.
    pub fn check(&self) -> Result<(), GpuError> {
        let said = std::mem::take(&mut *self.said.lock().unwrap_or_else(PoisonError::into_inner));
        match (said.lost, said.error) {
            (Some(message), _) => Err(GpuError::Lost(message)),
            (None, Some(error)) => Err(error),
            (None, None) => Ok(()),
        }
    }

    /// Keeps what went wrong for the next [`Self::check`].
    pub fn report(&self, error: GpuError) {
        self.said.lock().unwrap_or_else(PoisonError::into_inner).error.get_or_insert(error);
    }

    pub(super) fn compiled(&self, pipeline: String) {
        self.compiled.lock().unwrap_or_else(PoisonError::into_inner).push(pipeline);
    }

    /// Names of all pipelines that this device was given, in the order in which they were made.
    pub fn pipelines(&self) -> Vec<String> {
        self.compiled.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Blocks until everything that was submitted is done.
    pub fn wait(&self) -> Result<(), GpuError> {
        let here = thread::current().id();
        *self.waits.lock().unwrap_or_else(PoisonError::into_inner).entry(here).or_default() += 1;
        match self.device.poll(wgpu::PollType::wait_indefinitely()) {
            Ok(_) => self.check(),
            Err(error) => Err(GpuError::Lost(error.to_string())),
        }
    }

    /// How often this thread has waited. A window's own thread never should.
    pub fn waits_here(&self) -> u64 {
        let waits = self.waits.lock().unwrap_or_else(PoisonError::into_inner);
        waits.get(&thread::current().id()).copied().unwrap_or(0)
    }

    /// Lets what the GPU is done with be known. Waits for nothing.
    pub fn look(&self) -> Result<(), GpuError> {
        let looked = self.device.poll(wgpu::PollType::Poll);
        looked.map(drop).map_err(|error| GpuError::Lost(error.to_string()))
    }

    /// True as soon as these commands, once they are submitted, are done and [`Self::look`] or a frame has seen it. (The
    /// queue could be asked as well, but would submit first what was written since, and drivers may wait there.)
    pub fn done(commands: &wgpu::CommandEncoder) -> Arc<AtomicBool> {
        let done = Arc::new(AtomicBool::new(false));
        let told = done.clone();
        commands.on_submitted_work_done(move || told.store(true, Ordering::Release));
        done
    }

    /// Refuses an array that no buffer of this device can hold.
    pub fn fits(&self, what: &str, bytes: u64) -> Result<(), GpuError> {
        let limits = self.device.limits();
        let limit = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        if bytes <= limit {
            return Ok(());
        }
        Err(GpuError::TooLarge { what: what.to_owned(), bytes, limit })
    }
}

const WANTED: wgpu::Features = wgpu::Features::TIMESTAMP_QUERY;

fn can_draw(adapter: &wgpu::Adapter, info: &wgpu::AdapterInfo) -> Result<(), GpuError> {
    let flags = adapter.get_downlevel_capabilities().flags;
    let needed = [
        (wgpu::DownlevelFlags::COMPUTE_SHADERS, "compute shaders"),
        (wgpu::DownlevelFlags::VERTEX_STORAGE, "storage buffers in vertex shaders"),
        (wgpu::DownlevelFlags::COMPARISON_SAMPLERS, "comparison samplers"),
    ];
    match needed.iter().find(|(flag, _)| !flags.contains(*flag)) {
        Some((_, what)) => Err(GpuError::Lacks { adapter: info.name.clone(), what }),
        None => Ok(()),
    }
}

/// Keeps what wgpu would otherwise panic about, for [`Gpu::check`].
fn listen(device: &wgpu::Device) -> Arc<Mutex<Said>> {
    let said = Arc::new(Mutex::new(Said::default()));
    let errors = said.clone();
    device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
        let mut said = errors.lock().unwrap_or_else(PoisonError::into_inner);
        said.error.get_or_insert_with(|| GpuError::Reported(error.to_string()));
    }));
    let losses = said.clone();
    device.set_device_lost_callback(move |reason, message| {
        let message = if message.is_empty() { format!("{reason:?}").to_lowercase() } else { message };
        losses.lock().unwrap_or_else(PoisonError::into_inner).lost = Some(message);
    });
    said
}
