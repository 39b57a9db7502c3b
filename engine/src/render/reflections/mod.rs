//! Reflection probes: when each is captured, and what surfaces read of them.
//!
//! A probe's cubemap shows the scene as it is lit now, with the reflections of the last frame in it, so that
//! mirrors in mirrors converge frame by frame; it is blurred for roughness and then read by surfaces. Probes are
//! captured when what they see has changed, and a few times more while their own reflections settle.
//!
//! Cubemap 0 of the array is the sky's, cubemap k + 1 that of probe k.

pub mod baked;
pub mod capture;
mod cubes;
mod in_view;
pub mod prefilter;
mod schedule;
mod settling;
pub mod sight;
pub mod uses;
mod wanted;

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DVec3, Vec3};

use super::frame::Now;
use super::instances::Instances;
use super::materials::Materials;
use crate::gpu::Gpu;
use crate::gpu::buffer::Held;
use crate::gpu::pipeline::Compiler;
use crate::scene::{EntityId, Feature, Forced, ReflectionProbe};
use crate::transport::reflection::Cube;
use crate::transport::{Occluders, Transport};
use capture::{Room, Set, Shown, Views};
use cubes::{Cubes, split_sum, unit_of};
use prefilter::{Prefilter, Source, levels};
pub use schedule::Seen;
use schedule::{Due, Schedule};
use settling::Settling;
use sight::{Sight, look_around, seen_batches};
use uses::{GpuReflectionProbe, Ranked, ReflectionUse};
use wanted::{Wanted, fit, wanted};

/// Where there is a sky and no probe.
const SKY_SIZE: u32 = 128;

pub struct Reflections {
    prefilter: Prefilter,
    table: wgpu::TextureView,
    cubes: Cubes,
    sky: SkyCube,
    probes: Vec<Probe>,
    ranked: Ranked,
    held: Held<GpuReflectionProbe>,
    uses: Held<ReflectionUse>,
    reads: Vec<ReflectionUse>,
    views: Views,
    settling: Settling,
    /// Cubemaps from disk that no probe has taken yet.
    given: HashMap<EntityId, Cube>,
    /// Probes that are too many.
    pub left_out: usize,
    /// Probes that nothing in view reads, at the last frame.
    pub unread: usize,
    asked: Asked,
    /// Counts arrays made.
    made: u64,
}

/// What of reflections is not left to the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Asked {
    /// In: all probes have cubemaps; out: none.
    cubemaps: Option<Forced>,
    sky: bool,
    /// Of what does not change: in every frame.
    again: bool,
    /// Of what nothing in view reads.
    unseen: bool,
}

struct SkyCube {
    source: Option<(Source, Room)>,
    /// What was captured of it.
    seen: u64,
}

struct Probe {
    entity: EntityId,
    settings: ReflectionProbe,
    source: Source,
    room: Room,
    schedule: Schedule,
    /// From where it stands.
    sight: Option<(Vec3, Sight)>,
    /// What it sees of the static surface.
    batches: Vec<usize>,
    /// What it sees of what moves: a number, and how often that changed.
    moving: (u64, u64),
    /// Captures that are asked for though nothing changed.
    again: u64,
    /// Radiance of one unit of the capture at hand, and of the cubemap that is read.
    unit: f32,
    read_unit: f32,
}

/// What a frame's captures came to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Captured {
    /// Faces of probes and sky.
    pub faces: u32,
    pub draws: u32,
    /// There are cubemaps that surfaces could not read before.
    pub first: bool,
}

impl Reflections {
    pub fn new(
        gpu: &Gpu,
        compiler: &Arc<Compiler>,
        frame_layout: &wgpu::BindGroupLayout,
        asked: &super::Asked,
    ) -> Self {
        let asked = Asked {
            cubemaps: asked.said(Feature::Reflections),
            sky: asked.has(Feature::Sky, true),
            again: asked.has(Feature::Recaptures, false),
            unseen: asked.has(Feature::UnseenCaptures, false),
        };
        let prefilter = Prefilter::new(gpu, compiler);
        Self {
            cubes: Cubes::new(gpu, 1, 2),
            sky: SkyCube { source: None, seen: 0 },
            prefilter,
            views: Views::new(frame_layout),
            settling: Settling::new(gpu, 2),
            given: HashMap::new(),
            table: split_sum(gpu),
            probes: Vec::new(),
            ranked: Ranked::default(),
            held: Held::new(gpu, "reflection probes", wgpu::BufferUsages::STORAGE),
            uses: Held::new(gpu, "reflections", wgpu::BufferUsages::UNIFORM),
            reads: Vec::new(),
            left_out: 0,
            unread: 0,
            asked,
            made: 0,
        }
    }

    /// Bindings 4 and up of group 2.
    pub fn resources(&self) -> [wgpu::BindingResource<'_>; 6] {
        [
            wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                buffer: self.uses.buffer(),
                offset: 0,
                size: wgpu::BufferSize::new(uses::READ_BYTES),
            }),
            self.held.buffer().as_entire_binding(),
            self.cubes.harmonics.as_entire_binding(),
            wgpu::BindingResource::TextureView(&self.cubes.view),
            wgpu::BindingResource::Sampler(self.prefilter.sampler()),
            wgpu::BindingResource::TextureView(&self.table),
        ]
    }

    /// Where a draw's [`ReflectionUse`] lies.
    pub fn offset(draw: usize) -> u32 {
        (draw * size_of::<ReflectionUse>()) as u32
    }

    /// Whether anything is captured at all.
    pub fn any(&self) -> bool {
        self.sky.source.is_some() || !self.probes.is_empty()
    }

    pub fn bytes(&self) -> u64 {
        if !self.any() {
            return 0;
        }
        let cube = |texture: &wgpu::Texture| {
            u64::from(texture.width()) * u64::from(texture.width()) * 8 * 4 / 3
                * u64::from(texture.depth_or_array_layers())
        };
        let taken = |(source, room): (&Source, &Room)| cube(&source.texture) + room.bytes();
        let probes = self.probes.iter().map(|probe| (&probe.source, &probe.room));
        let sky = self.sky.source.iter().map(|(source, room)| (source, room));
        cube(&self.cubes.texture) + probes.chain(sky).map(taken).sum::<u64>()
    }

    /// Follows probes and objects.
    pub fn update(
        &mut self,
        gpu: &Gpu,
        now: &Now<'_>,
        (instances, materials): (&Instances, &Materials),
        (transport, occluders): (&Transport, &Occluders),
    ) {
        let origin = transport.origin;
        let (mut probes, with_sky) = wanted(now, instances, materials, origin, &self.asked);
        self.left_out = fit(&mut probes, gpu.device.limits().max_texture_array_layers);
        self.make_room(gpu, &probes, with_sky);
        let influences = probes.iter().map(|wanted| (wanted.entity, wanted.influence)).collect();
        self.ranked = Ranked::new(influences);
        for (probe, wanted) in self.probes.iter_mut().zip(&probes) {
            if probe.settings != *wanted.settings {
                probe.settings = wanted.settings.clone();
                probe.schedule.restart();
            }
        }
        self.look(transport, occluders);
        self.write_probes(gpu);
        let baked = !(transport.receivers.is_empty() && transport.probes.is_empty());
        self.write_uses(gpu, now, instances, origin, [with_sky, baked]);
    }

    /// Looks around from where probes stand now.
    fn look(&mut self, transport: &Transport, occluders: &Occluders) {
        for (probe, influence) in self.probes.iter_mut().zip(&self.ranked.influences) {
            let at = influence.position;
            if probe.sight.is_none_or(|(from, _)| from != at) {
                let moved = probe.sight.is_some();
                probe.sight = Some((at, look_around(transport, occluders, at)));
                probe.batches = seen_batches(transport, occluders, at);
                if moved {
                    probe.schedule.restart();
                }
            }
        }
    }

    /// Probes that stand inside a solid and show nothing: what to tell the author, in world space.
    pub fn misplaced(&self, origin: DVec3) -> impl Iterator<Item = (EntityId, Sight, Option<DVec3>)> + '_ {
        self.probes.iter().filter_map(move |probe| {
            let (_, sight) = probe.sight.filter(|(_, sight)| sight.is_inside())?;
            Some((probe.entity, sight, sight.better.map(|better| origin + better.as_dvec3())))
        })
    }

    /// Changes when what is bound is another buffer or texture.
    pub fn generation(&self) -> [u64; 3] {
        [self.held.generation, self.uses.generation, self.made]
    }

    /// Cubemaps for these probes; nothing is made where nothing is read.
    fn make_room(&mut self, gpu: &Gpu, probes: &[Wanted<'_>], with_sky: bool) {
        let now = self.probes.iter().map(|probe| (probe.entity, probe.source.size));
        let same = now.eq(probes.iter().map(|wanted| (wanted.entity, wanted.size)));
        if same && with_sky == self.sky.source.is_some() {
            return;
        }
        self.made += 1;
        let most = probes.iter().map(|wanted| wanted.size).max();
        let any = with_sky || most.is_some();
        let size = if any { most.unwrap_or(SKY_SIZE) } else { 1 };
        let count = (probes.len() as u32 + 1).max(2);
        self.cubes = Cubes::new(gpu, size, count);
        self.settling = Settling::new(gpu, count);
        let levels = levels(size);
        let source = |index, size| self.prefilter.source(gpu, size, levels, &self.cubes.harmonics, index);
        self.sky.seen = 0;
        self.sky.source = with_sky.then(|| (source(0, size), Room::new(gpu, size)));
        let probe = |(index, wanted): (u32, &Wanted<'_>)| Probe {
            entity: wanted.entity,
            settings: wanted.settings.clone(),
            source: source(index, wanted.size),
            room: Room::new(gpu, wanted.size),
            schedule: Schedule::default(),
            sight: None,
            batches: Vec::new(),
            moving: (0, 0),
            again: 0,
            unit: 1.0,
            read_unit: 1.0,
        };
        self.probes = (1..).zip(probes).map(probe).collect();
    }

    fn write_probes(&mut self, gpu: &Gpu) {
        let groups = self.ranked.groups();
        let described: Vec<GpuReflectionProbe> =
            (0..self.probes.len()).map(|index| self.described(index, groups[index])).collect();
        self.held.write(gpu, &described);
    }

    fn described(&self, index: usize, group: u32) -> GpuReflectionProbe {
        let influence = &self.ranked.influences[index];
        let (m, shift) = (influence.box_from_world.transpose(), influence.shift);
        GpuReflectionProbe {
            rows: [m.x_axis.extend(shift.x), m.y_axis.extend(shift.y), m.z_axis.extend(shift.z)],
            position: influence.position,
            fade: influence.fade,
            half: influence.half,
            unit: self.probes[index].read_unit,
            cube: index as u32 + 1,
            group,
            box_projection: u32::from(self.probes[index].settings.box_projection),
            padding: 0,
        }
    }

    fn write_uses(
        &mut self,
        gpu: &Gpu,
        now: &Now<'_>,
        instances: &Instances,
        origin: DVec3,
        [with_sky, baked]: [bool; 2],
    ) {
        let usable: Vec<bool> = self.probes.iter().map(Probe::is_usable).collect();
        let sky = with_sky && self.sky.seen > 0;
        let last_level = (self.cubes.texture.mip_level_count() - 1) as f32;
        let reads = |draw| ReflectionUse {
            last_level,
            sky: u32::from(sky),
            baked: u32::from(baked),
            ..self.ranked.of(draw, now, origin, &usable)
        };
        self.reads.clear();
        self.reads.extend(instances.draws.iter().map(reads));
        self.uses.write(gpu, &self.reads);
    }

    /// Captures what is due. `seen` counts what captures show, `sky` changes of the sky (from 1); `settled`: light
    /// is solved.
    pub fn capture(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        set: &mut Set<'_>,
        (seen, sky): (Seen, u64),
        settled: bool,
    ) -> Captured {
        self.views.clear();
        let mut captured = Captured::default();
        self.capture_sky(encoder, set, sky, &mut captured);
        let read = self.read_in_view(set);
        self.unread = read.iter().filter(|read| !**read).count();
        for ((probe, influence), read) in self.probes.iter_mut().zip(&self.ranked.influences).zip(read) {
            let seen = probe.sees(seen, influence.position, set.scenery.instances, self.asked.again);
            probe.schedule.follow(probe.settings.refresh, seen, read);
        }
        captured.first |= self.take_given(encoder, set);
        let mut schedules: Vec<_> =
            self.probes.iter_mut().map(|probe| (&probe.settings, &mut probe.schedule)).collect();
        let mut complete = Vec::new();
        for due in schedule::plan(&mut schedules, settled) {
            if self.capture_probe(encoder, set, &due, &mut captured) {
                complete.push(due.probe);
            }
        }
        if !complete.is_empty() {
            let complete = complete.into_iter().map(|probe| (probe, self.probes[probe].schedule.seen()));
            self.settling.copy(encoder, &self.cubes.harmonics, complete.collect());
        }
        captured
    }

    /// After the submit.
    pub fn sent(&mut self) {
        self.settling.sent();
    }

    /// Takes in what captures came to: those that do not differ from the ones before are the last.
    pub fn receive(&mut self) {
        for (probe, seen) in self.settling.settled() {
            if let Some(probe) = self.probes.get_mut(probe) {
                probe.schedule.settle(probe.settings.refresh, seen);
            }
        }
    }

    fn capture_sky(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        set: &mut Set<'_>,
        seen: u64,
        captured: &mut Captured,
    ) {
        let Some((source, room)) = &mut self.sky.source else { return };
        if self.sky.seen == seen {
            return;
        }
        captured.first |= self.sky.seen == 0;
        self.sky.seen = seen;
        for face in 0..6 {
            let into = (&source.texture, &source.views[0][face]);
            captured.draws +=
                room.take(set, &mut self.views, encoder, face, (Vec3::ZERO, 0.1), into, Shown::Sky);
            captured.faces += 1;
        }
        self.prefilter.run(encoder, set.timer, source, &self.cubes.faces[0]);
    }

    fn capture_probe(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        set: &mut Set<'_>,
        due: &Due,
        captured: &mut Captured,
    ) -> bool {
        let probe = &mut self.probes[due.probe];
        let shown = match (due.on_top, probe.settings.refresh) {
            (_, crate::scene::Refresh::Baked) => Shown::Still,
            // wgpu's OpenGL copies no depth.
            (true, _) if set.gpu.info.backend != wgpu::Backend::Gl => Shown::MovingOnTop,
            _ => Shown::All,
        };
        if !due.on_top {
            probe.room.forget();
        }
        if due.first == 0 {
            probe.unit = unit_of(set.brightest, probe.unit);
        }
        set.frame.pre_exposure = 1.0 / probe.unit;
        let place = (self.ranked.influences[due.probe].position, probe.near());
        for face in due.first..due.end {
            let into = (&probe.source.texture, &probe.source.views[0][face]);
            captured.draws += probe.room.take(set, &mut self.views, encoder, face, place, into, shown);
            captured.faces += 1;
        }
        captured.first |= !probe.schedule.taken;
        let complete = probe.schedule.took(due);
        if complete {
            // In another unit, it is told before anything reads it.
            captured.first |= probe.read_unit != probe.unit;
            probe.read_unit = probe.unit;
            self.prefilter.run(encoder, set.timer, &probe.source, &self.cubes.faces[due.probe + 1]);
        }
        complete
    }
}

impl Probe {
    /// It holds a capture, and one that was not taken inside a solid.
    fn is_usable(&self) -> bool {
        self.schedule.taken && self.sight.is_none_or(|(_, sight)| !sight.is_inside())
    }

    /// Metres: before the nearest wall, so that it has no hole.
    fn near(&self) -> f32 {
        let nearest = self.sight.map_or(f32::INFINITY, |(_, sight)| sight.nearest);
        self.settings.near.min(0.5 * nearest).max(1e-5)
    }
}
