//! The end of the frame: from radiance to the display.

use std::sync::Arc;

use glam::{Mat3, Vec3};

use super::shaders;
use super::targets::Targets;
use super::view::View;
use crate::gpu::Gpu;
use crate::gpu::pass::{self, Binding};
use crate::gpu::pipeline::{Compiler, Pipelines, Variant};
use crate::gpu::timing::Timer;
use crate::scene::ToneCurve;

/// As `frame.wgsl` numbers them.
pub fn curve_of(view: View, curve: ToneCurve) -> u32 {
    match (view.shows_light(), curve) {
        (false, _) => 0,
        (true, ToneCurve::Neutral) => 1,
        (true, ToneCurve::Agx) => 2,
    }
}

/// The plain twin of `tonemap.wgsl`: a display's linear colours from exposed radiance.
pub fn displayed(color: Vec3, curve: ToneCurve) -> Vec3 {
    let color = color.map(|light| if light > 0.0 { light.min(1e30) } else { 0.0 });
    match curve {
        ToneCurve::Neutral => neutral(color),
        ToneCurve::Agx => agx(color),
    }
}

fn neutral(color: Vec3) -> Vec3 {
    const BEND: f32 = 0.8;
    let peak = color.max_element();
    if peak < BEND {
        return color;
    }
    let room = 1.0 - BEND;
    let new_peak = 1.0 - room * room / (peak + room - BEND);
    let pale = 1.0 - 1.0 / (0.15 * (peak - new_peak) + 1.0);
    (color * (new_peak / peak)).lerp(Vec3::splat(new_peak), pale)
}

/// Sobotka (2022), with Wrensch's numbers (2023).
fn agx(color: Vec3) -> Vec3 {
    const AGX_FROM_RGB: Mat3 = Mat3::from_cols(
        Vec3::new(0.842_479_06, 0.042_328_242, 0.042_375_655),
        Vec3::new(0.078_433_6, 0.878_468_64, 0.078_433_6),
        Vec3::new(0.079_223_745, 0.079_166_13, 0.879_143),
    );
    const RGB_FROM_AGX: Mat3 = Mat3::from_cols(
        Vec3::new(1.196_879, -0.052_896_853, -0.052_971_635),
        Vec3::new(-0.098_020_88, 1.151_903_1, -0.098_043_45),
        Vec3::new(-0.099_029_74, -0.098_961_175, 1.151_073_7),
    );
    const STOPS: [f32; 2] = [-12.473_93, 4.026_069];
    const SIGMOID: [f32; 7] = [-0.002_32, 0.119_1, 0.429_8, -6.868, 31.96, -40.14, 15.5];
    let curved = (AGX_FROM_RGB * color).map(|light| {
        let x = (light.max(1e-10).log2() - STOPS[0]) / (STOPS[1] - STOPS[0]);
        SIGMOID.iter().rev().fold(0.0, |sum, factor| sum * x.clamp(0.0, 1.0) + factor)
    });
    (RGB_FROM_AGX * curved).map(|light| light.clamp(0.0, 1.0).powf(2.2))
}

/// What is drawn into, and whether more samples a pixel are read than one.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct Display {
    format: wgpu::TextureFormat,
    many: bool,
}

impl Variant for Display {
    fn name(&self) -> String {
        format!("tonemap{}", if self.many { ", samples" } else { "" })
    }
}

pub struct Tonemap {
    /// For one sample a pixel, and for more.
    layouts: [wgpu::BindGroupLayout; 2],
    pipeline_layouts: [wgpu::PipelineLayout; 2],
    pipelines: Pipelines<Display, wgpu::RenderPipeline>,
}

impl Tonemap {
    pub fn new(gpu: &Gpu, compiler: &Arc<Compiler>, frame_layout: &wgpu::BindGroupLayout) -> Self {
        let layouts = [Binding::Texels, Binding::MultisampledTexels]
            .map(|texels| pass::layout(gpu, "tonemap", wgpu::ShaderStages::FRAGMENT, &[texels]));
        let pipeline_layouts = layouts
            .each_ref()
            .map(|layout| pass::pipeline_layout(gpu, &[Some(frame_layout), None, None, Some(layout)]));
        Self { layouts, pipeline_layouts, pipelines: Pipelines::new(compiler, shaders::TONEMAP) }
    }

    /// What reads these targets.
    pub fn group(&self, gpu: &Gpu, targets: &Targets) -> wgpu::BindGroup {
        let resource = wgpu::BindingResource::TextureView(&targets.radiance_view);
        pass::group(gpu, "tonemap", &self.layouts[usize::from(targets.samples_read() > 1)], &[resource])
    }

    pub fn draw(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        timer: &mut Timer,
        frame: &wgpu::BindGroup,
        (targets, radiance): &(Targets, wgpu::BindGroup),
        display: &wgpu::Texture,
    ) {
        let many = targets.samples_read() > 1;
        let format = display.format();
        let entry = if many { "tonemap_samples" } else { "tonemap" };
        let layout = &self.pipeline_layouts[usize::from(many)];
        let made = self.pipelines.get(Display { format, many }, |gpu, module| {
            pass::over_picture(gpu, module, entry, layout, format)
        });
        let Some(pipeline) = made else { return };
        let view = display.create_view(&Default::default());
        let mut pass = pass::draw_into(encoder, "tonemap", &view, timer.render("tonemap"));
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, frame, &[]);
        pass.set_bind_group(3, radiance, &[]);
        pass.draw(0..3, 0..1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CURVES: [ToneCurve; 2] = [ToneCurve::Neutral, ToneCurve::Agx];

    /// As it is written to the display: 0..1.
    fn encoded(light: f32) -> f32 {
        if light <= 0.003_130_8 { light * 12.92 } else { 1.055 * light.powf(1.0 / 2.4) - 0.055 }
    }

    #[test]
    fn greys_stay_grey_and_in_order() {
        for curve in CURVES {
            assert_eq!(displayed(Vec3::ZERO, curve), Vec3::ZERO);
            let mut last = -1.0;
            for step in -200..200 {
                let grey = displayed(Vec3::splat((step as f32 * 0.1).exp2()), curve);
                assert!((grey.max_element() - grey.min_element()) < 2e-3, "{grey}");
                assert!((last..=1.0).contains(&grey.y), "{curve:?} {step}: {} after {last}", grey.y);
                last = grey.y;
            }
            assert!(last > 0.99, "{curve:?} ends at white: {last}");
        }
    }

    #[test]
    fn middle_grey_is_in_the_middle() {
        assert_eq!(displayed(Vec3::splat(0.18), ToneCurve::Neutral), Vec3::splat(0.18));
        let grey = encoded(displayed(Vec3::splat(0.18), ToneCurve::Agx).y);
        assert!((0.4..0.55).contains(&grey), "{grey}");
    }

    #[test]
    fn saturated_colours_pale_smoothly_as_they_brighten() {
        for (curve, color) in CURVES.into_iter().flat_map(|curve| {
            [Vec3::X, Vec3::Y, Vec3::Z, Vec3::new(1.0, 0.4, 0.02)].map(|color| (curve, color))
        }) {
            let share = |stops: f32| {
                let shown = displayed(color * stops.exp2(), curve);
                shown.min_element() / shown.max_element()
            };
            let mut last = share(0.0);
            for step in 1..160 {
                let now = share(step as f32 * 0.1);
                assert!(now >= last - 1e-4 && now - last < 0.1, "{curve:?} {color} {step}: {last} {now}");
                last = now;
            }
            assert!(last > 0.8, "{curve:?} {color}: {last}");
        }
    }
}
