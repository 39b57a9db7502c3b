//! Frames into files, without a window. The clock plays no part: the same frames give the same pictures.

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use super::light;
use super::lose::LoseDevice;
use super::overlay::{self, Took};
use super::statistics::Statistics;
use super::{Options, PlayError, World};
use crate::gpu::{Gpu, GpuError, texture};
use crate::render::{Now, Renderer, Settings};

/// Seconds from frame to frame where nothing is said.
const DT: f64 = 1.0 / 60.0;

pub fn run(options: &Options, mut world: World) -> Result<(), PlayError> {
    let gpu = Arc::new(Gpu::headless()?);
    eprintln!("{}", gpu.name());
    can_draw(&gpu, options.size)?;
    let (unlimited_gain, products) = (world.unlimited_gain, options.products);
    let settings = Settings { wait: true, unlimited_gain, products, ..Settings::default() };
    world.cubemaps.prepare(&gpu, &world, settings)?;
    let mut renderer = world.renderer(&gpu, settings)?;
    renderer.give_cubemaps(world.cubemaps.load(&world.scene));
    let display = texture::target(&gpu, "display", options.size, 1, wgpu::TextureFormat::Rgba8UnormSrgb);
    let mut statistics = Statistics::new(options.stats.as_deref());
    let ended = draw_all(options, &mut world, &mut renderer, &display, &mut statistics)
        .and_then(|()| light::write(options.light.as_deref(), &renderer));
    statistics.finish(ended, Some(&renderer), &world, options.size)
}

fn draw_all(
    options: &Options,
    world: &mut World,
    renderer: &mut Renderer,
    display: &wgpu::Texture,
    statistics: &mut Statistics,
) -> Result<(), PlayError> {
    let lose = LoseDevice::from_environment();
    let frames = options.frames.unwrap_or(1);
    for frame in 0..frames {
        let since = Instant::now();
        lose.at(frame, renderer.gpu());
        let time = frame as f64 * options.fixed_dt.unwrap_or(DT);
        world.follow(time);
        let world_from_local = world.placed_at(time);
        let eye = world.eye(&world_from_local).exposed(options.exposure);
        let now = Now {
            scene: &world.scene,
            assets: &world.assets,
            world_from_local: &world_from_local,
            time,
            eye,
            view: options.view,
        };
        let drawn = renderer.draw(&now, display)?;
        if frame == 0 {
            world.tell_misplaced(renderer);
        }
        let took = Took { frame: since.elapsed(), cpu: None };
        statistics.add(&drawn, took);
        if options.overlay {
            let title = format!("{} - {} - {time:.2} s", world.name, options.view.name());
            let lines = overlay::told(&title, took, &drawn, &eye, renderer, world);
            renderer.lay_over(lines, display);
        }
        let due = frame % options.every.max(1) == 0 || frame + 1 == frames;
        if let Some(out) = options.out.as_ref().filter(|_| due) {
            save(renderer.gpu(), display, &out.join(format!("frame_{frame:05}.png")))?;
        }
    }
    Ok(())
}

fn can_draw(gpu: &Gpu, size: [u32; 2]) -> Result<(), PlayError> {
    let limit = gpu.device.limits().max_texture_dimension_2d;
    if size.iter().all(|&side| side <= limit) {
        return Ok(());
    }
    let bytes = u64::from(size[0]) * u64::from(size[1]);
    let what = format!("a picture of {} x {} (pixels a side up to {limit})", size[0], size[1]);
    Err(GpuError::TooLarge { what, bytes, limit: u64::from(limit) * u64::from(limit) }.into())
}

/// A texture of 8 bits RGBA (or BGRA) as a PNG file.
pub fn save(gpu: &Gpu, display: &wgpu::Texture, path: &Path) -> Result<(), PlayError> {
    let failed = |message: String| PlayError::Write { path: path.to_owned(), message };
    let pixels = texture::read(gpu, display, 4)?;
    let rgb: Vec<u8> = pixels.chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(|error| failed(error.to_string()))?;
    }
    image::save_buffer(path, &rgb, display.width(), display.height(), image::ExtendedColorType::Rgb8)
        .map_err(|error| failed(error.to_string()))
}
