//! Buffers: made once, written where something changed, read back without a stall.

use std::ops::Range;
use std::sync::mpsc;

use bytemuck::{AnyBitPattern, NoUninit};
use wgpu::util::DeviceExt;

use super::{Gpu, GpuError};

/// No binding may be smaller than what a shader reads of it, at least one element.
const LEAST: u64 = 256;

/// A buffer with this content.
pub fn filled<T: NoUninit>(gpu: &Gpu, label: &str, items: &[T], usage: wgpu::BufferUsages) -> wgpu::Buffer {
    let bytes: &[u8] = bytemuck::cast_slice(items);
    if bytes.is_empty() {
        return empty(gpu, label, 0, usage);
    }
    let padded: Vec<u8>;
    let contents = if bytes.len().is_multiple_of(4) && bytes.len() as u64 >= LEAST {
        bytes
    } else {
        padded = bytes
            .iter()
            .copied()
            .chain([0; LEAST as usize])
            .take(bytes.len().next_multiple_of(4).max(LEAST as usize))
            .collect();
        &padded
    };
    let usage = usage | wgpu::BufferUsages::COPY_DST;
    gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: Some(label), contents, usage })
}

/// A buffer of zeros.
pub fn empty(gpu: &Gpu, label: &str, bytes: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
    gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size: bytes.next_multiple_of(4).max(LEAST),
        usage: usage | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC,
        mapped_at_creation: false,
    })
}

/// A buffer that remembers what it holds and is written only where that changes. It grows by doubling; then
/// `generation` counts up, and whatever bound the old buffer binds the new one.
pub struct Held<T> {
    label: &'static str,
    usage: wgpu::BufferUsages,
    items: Vec<T>,
    buffer: wgpu::Buffer,
    pub generation: u64,
}

impl<T: NoUninit + PartialEq> Held<T> {
    pub fn new(gpu: &Gpu, label: &'static str, usage: wgpu::BufferUsages) -> Self {
        Self { label, usage, items: Vec::new(), buffer: empty(gpu, label, 0, usage), generation: 0 }
    }

    /// Returns whether anything differs from what was there.
    pub fn write(&mut self, gpu: &Gpu, items: &[T]) -> bool {
        if self.items == items {
            return false;
        }
        let bytes: &[u8] = bytemuck::cast_slice(items);
        if bytes.len() as u64 > self.buffer.size() {
            let room = (bytes.len() as u64).next_power_of_two();
            self.buffer = empty(gpu, self.label, room, self.usage);
            self.generation += 1;
        }
        gpu.queue.write_buffer(&self.buffer, 0, bytes);
        self.items.clear();
        self.items.extend_from_slice(items);
        true
    }

    pub fn buffer(&self) -> &wgpu::Buffer {
        &self.buffer
    }

    pub fn items(&self) -> &[T] {
        &self.items
    }
}

/// Cuts rows (row i holds entries `starts[i] .. starts[i + 1]`) into runs whose entries, of 4 bytes in each
/// array, fit into `page_bytes`. A row is never cut; one that is larger than a page is an error.
pub fn pages(what: &str, starts: &[u64], page_bytes: u64) -> Result<Vec<Range<usize>>, GpuError> {
    let entries = (page_bytes / 4).max(1);
    let rows = starts.len().saturating_sub(1);
    let mut pages = Vec::new();
    let mut first = 0;
    while first < rows {
        // The starts of a page's rows take one more entry than it has rows.
        let fits = |end: usize| starts[end] - starts[first] <= entries && ((end - first) as u64) < entries;
        let mut end = first + 1;
        if !fits(end) {
            let bytes = (starts[end] - starts[first]) * 4;
            return Err(GpuError::TooLarge { what: format!("{what} row {first}"), bytes, limit: page_bytes });
        }
        while end < rows && fits(end + 1) {
            end += 1;
        }
        pages.push(first..end);
        first = end;
    }
    Ok(pages)
}

/// What a buffer holds, once the GPU is done: for tests and pictures. Blocks.
pub fn read<T: AnyBitPattern + NoUninit>(gpu: &Gpu, buffer: &wgpu::Buffer) -> Result<Vec<T>, GpuError> {
    let staging = staging(gpu, buffer.size());
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    encoder.copy_buffer_to_buffer(buffer, 0, &staging, 0, buffer.size());
    gpu.queue.submit([encoder.finish()]);
    let arriving = Arriving::new(staging);
    gpu.wait()?;
    arriving.take(gpu).unwrap_or_else(|| Err(not_there()))
}

/// After a wait everything is.
pub(super) fn not_there() -> GpuError {
    GpuError::Reported("what was read back is not there after the GPU was waited for".to_owned())
}

pub fn staging(gpu: &Gpu, bytes: u64) -> wgpu::Buffer {
    gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("read back"),
        size: bytes,
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    })
}

/// What was copied into a staging buffer by commands already submitted, on its way to the processor.
pub struct Arriving {
    staging: wgpu::Buffer,
    mapped: mpsc::Receiver<bool>,
}

impl Arriving {
    pub fn new(staging: wgpu::Buffer) -> Self {
        let (sender, mapped) = mpsc::channel();
        staging.map_async(wgpu::MapMode::Read, .., move |result| {
            // Nobody asks any more where the receiver is gone.
            let _ = sender.send(result.is_ok());
        });
        Self { staging, mapped }
    }

    /// `None`: the GPU has not come so far. Waits for nothing; it comes once.
    pub fn take<T: AnyBitPattern + NoUninit>(&self, gpu: &Gpu) -> Option<Result<Vec<T>, GpuError>> {
        if let Err(error) = gpu.look() {
            return Some(Err(error));
        }
        match self.mapped.try_recv() {
            Err(mpsc::TryRecvError::Empty) => None,
            Ok(true) => {
                let items = mapped(&self.staging);
                self.staging.unmap();
                Some(items)
            }
            Ok(false) | Err(mpsc::TryRecvError::Disconnected) => {
                Some(Err(GpuError::Reported("what was read back did not arrive".to_owned())))
            }
        }
    }
}

fn mapped<T: AnyBitPattern + NoUninit>(staging: &wgpu::Buffer) -> Result<Vec<T>, GpuError> {
    let view = staging.get_mapped_range(..).map_err(|error| GpuError::Reported(error.to_string()))?;
    Ok(view.chunks_exact(size_of::<T>()).map(bytemuck::pod_read_unaligned).collect())
}

/// A few numbers of every frame on their way back, without a stall: three staging buffers take turns, and a
/// frame that finds none free sends nothing.
pub struct Readback<Tag> {
    slots: Vec<Slot<Tag>>,
    sender: mpsc::Sender<(usize, bool)>,
    arrived: mpsc::Receiver<(usize, bool)>,
}

struct Slot<Tag> {
    staging: wgpu::Buffer,
    /// Of the frame whose numbers are under way.
    tag: Option<Tag>,
}

impl<Tag> Readback<Tag> {
    pub fn new(gpu: &Gpu, bytes: u64) -> Self {
        let (sender, arrived) = mpsc::channel();
        let slots = (0..3).map(|_| Slot { staging: staging(gpu, bytes), tag: None }).collect();
        Self { slots, sender, arrived }
    }

    /// Copies `buffer` at this point of the frame. The result is what [`Self::send`] wants after the submit.
    pub fn copy(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        buffer: &wgpu::Buffer,
        tag: Tag,
    ) -> Option<usize> {
        let free = self.slots.iter().position(|slot| slot.tag.is_none())?;
        let slot = &mut self.slots[free];
        encoder.copy_buffer_to_buffer(buffer, 0, &slot.staging, 0, slot.staging.size());
        slot.tag = Some(tag);
        Some(free)
    }

    /// After the submit of the commands that copy.
    pub fn send(&mut self, slot: Option<usize>) {
        let Some(slot) = slot else { return };
        let sender = self.sender.clone();
        self.slots[slot].staging.map_async(wgpu::MapMode::Read, .., move |result| {
            // The receiver is gone only where the whole readback is.
            let _ = sender.send((slot, result.is_ok()));
        });
    }

    /// What has arrived since, oldest first. The device is polled by the caller.
    pub fn receive<T: AnyBitPattern + NoUninit>(&mut self) -> Vec<(Tag, Vec<T>)> {
        let mut all = Vec::new();
        while let Ok((slot, mapped_well)) = self.arrived.try_recv() {
            let slot = &mut self.slots[slot];
            let tag = slot.tag.take();
            if !mapped_well {
                continue;
            }
            if let (Some(tag), Ok(items)) = (tag, mapped(&slot.staging)) {
                all.push((tag, items));
            }
            slot.staging.unmap();
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pages_hold_whole_rows_and_cover_all() {
        let starts = [0, 3, 3, 9, 10, 20];
        let cut = pages("test", &starts, 40).unwrap();
        assert_eq!(cut, [0..4, 4..5]);
        assert!(pages("test", &[], 40).unwrap().is_empty());
        assert!(pages("test", &[0], 40).unwrap().is_empty());
    }

    #[test]
    fn a_row_larger_than_a_page_is_refused_by_name() {
        let error = pages("receiver", &[0, 2, 30], 40).unwrap_err();
        assert!(error.to_string().starts_with("receiver row 1: 112 bytes"), "{error}");
    }
}
