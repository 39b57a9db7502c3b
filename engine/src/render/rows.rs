//! Sparse rows on the GPU, in pages that fit a storage binding.

use std::ops::Range;

use bytemuck::{Pod, Zeroable};
use wgpu::BufferUsages as Usage;

use super::channels::Channels;
use crate::gpu::pass::{self, Binding};
use crate::gpu::pipeline::Defines;
use crate::gpu::{Gpu, GpuError, buffer};
use crate::transport::{Rows, packed};

/// Columns up to which rows may be dense: more are compressed.
const MOST_DENSE: usize = 1500 + 512;

/// `Page` in `transport/rows.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct PageUniform {
    pub first: u32,
    pub count: u32,
    /// 1 where weights are halves ([`crate::transport::packed`]): above their columns, or two by two.
    pub packed: u32,
    /// Columns of the matrix.
    pub width: u32,
}

/// Rows as runs of whole rows, each with its own starts, columns and weights; or with the weights of all columns.
pub struct PagedRows {
    pages: Vec<Page>,
    dense: bool,
    pub bytes: u64,
}

struct Page {
    group: wgpu::BindGroup,
    rows: u32,
}

/// Whether rows have columns beside their weights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layout {
    /// Where that is smaller, of few patches.
    AsSuits,
    Sparse,
    Dense,
}

/// How a row is summed: the same numbers, in another order of additions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Summed {
    ByThread,
    ByGroup,
}

impl Summed {
    /// Barriers cost more than they win where a processor draws.
    pub fn best(gpu: &Gpu) -> Self {
        if gpu.software { Self::ByThread } else { Self::ByGroup }
    }
}

/// Group 3 of passes over rows.
pub fn page_layout(gpu: &Gpu) -> wgpu::BindGroupLayout {
    pass::layout(
        gpu,
        "page",
        wgpu::ShaderStages::COMPUTE,
        &[Binding::Uniform, Binding::Read, Binding::Read, Binding::Read],
    )
}

impl PagedRows {
    /// `columns`: of the matrix.
    pub fn new(
        gpu: &Gpu,
        group_layout: &wgpu::BindGroupLayout,
        what: &str,
        (rows, columns): (&Rows, usize),
        layout: Layout,
    ) -> Result<Self, GpuError> {
        let packed = rows.columns.iter().zip(&rows.weights).all(|(&c, &w)| packed::pack(c, w).is_some());
        let sparse = rows.starts.len() * 4 + rows.entries() * if packed { 4 } else { 8 };
        let stride = if packed { columns.div_ceil(2) } else { columns };
        let smaller = columns <= MOST_DENSE && rows.len() * stride * 4 < sparse;
        let dense = layout == Layout::Dense || layout == Layout::AsSuits && smaller;
        let starts: Vec<u64> = (0..=rows.len() as u64).map(|row| row * stride as u64).collect();
        let starts = if dense { &starts } else { &rows.starts };
        let mut paged = Self { pages: Vec::new(), dense, bytes: 0 };
        for range in buffer::pages(what, starts, gpu.page_bytes)? {
            let uniform = PageUniform {
                first: range.start as u32,
                count: range.len() as u32,
                packed: u32::from(packed),
                width: columns as u32,
            };
            let arrays =
                if dense { full(rows, range, columns, packed) } else { sparse_page(rows, range, packed) };
            paged.bytes += arrays.bytes();
            paged
                .pages
                .push(Page { group: arrays.group(gpu, group_layout, what, uniform), rows: uniform.count });
        }
        Ok(paged)
    }

    /// What is defined in shaders that sum these rows over light of so many channels.
    pub fn defines(&self, channels: Channels) -> Defines {
        match (self.dense, channels) {
            (false, channels) => channels.defines(),
            (true, Channels::Three) => &["DENSE"],
            (true, Channels::One) => &["DENSE", "GREY"],
        }
    }

    pub fn is_empty(&self) -> bool {
        self.pages.is_empty()
    }

    pub fn pages(&self) -> usize {
        self.pages.len()
    }

    /// One dispatch a page; the pipeline and its group 2 are set.
    pub fn dispatch(&self, pass: &mut wgpu::ComputePass<'_>, summed: Summed) -> u32 {
        for page in &self.pages {
            pass.set_bind_group(3, &page.group, &[]);
            match summed {
                Summed::ByThread => pass::dispatch(pass, page.rows),
                Summed::ByGroup => {
                    let (x, y) = pass::grid(page.rows);
                    pass.dispatch_workgroups(x, y, 1);
                }
            }
        }
        self.pages.len() as u32
    }
}

/// What a page binds.
#[derive(Default)]
struct Arrays {
    starts: Vec<u32>,
    columns: Vec<u32>,
    weights: Vec<f32>,
}

impl Arrays {
    fn bytes(&self) -> u64 {
        (self.starts.len() + self.columns.len() + self.weights.len()) as u64 * 4
    }

    fn group(
        &self,
        gpu: &Gpu,
        layout: &wgpu::BindGroupLayout,
        what: &str,
        uniform: PageUniform,
    ) -> wgpu::BindGroup {
        let buffers = [
            buffer::filled(gpu, "page", &[uniform], Usage::UNIFORM),
            buffer::filled(gpu, "starts", &self.starts, Usage::STORAGE),
            buffer::filled(gpu, "columns", &self.columns, Usage::STORAGE),
            buffer::filled(gpu, "weights", &self.weights, Usage::STORAGE),
        ];
        pass::buffers(gpu, what, layout, &buffers.each_ref())
    }
}

fn sparse_page(rows: &Rows, range: Range<usize>, packed: bool) -> Arrays {
    let entries = rows.starts[range.start] as usize..rows.starts[range.end] as usize;
    let starts = rows.starts[range.start..=range.end].iter();
    let starts = starts.map(|start| (start - rows.starts[range.start]) as u32).collect();
    let (columns, weights) = (&rows.columns[entries.clone()], &rows.weights[entries]);
    match packed::pack_all(columns, weights).filter(|_| packed) {
        Some(columns) => Arrays { starts, columns, ..Arrays::default() },
        None => Arrays { starts, columns: columns.to_vec(), weights: weights.to_vec() },
    }
}

/// The weights of all columns, row after row; halves lie two by two, the first one below.
fn full(rows: &Rows, range: Range<usize>, columns: usize, packed: bool) -> Arrays {
    let mut weights = vec![0.0; range.len() * columns];
    for (row, into) in range.zip(weights.chunks_exact_mut(columns.max(1))) {
        rows.row(row).for_each(|(column, weight)| into[column as usize] = weight);
    }
    if !packed {
        return Arrays { weights, ..Arrays::default() };
    }
    let half = |weight: &f32| packed::pack(0, *weight).map_or(0, |entry| entry >> 16);
    let two = |two: &[f32]| half(&two[0]) | two.get(1).map_or(0, half) << 16;
    let columns = weights.chunks(columns.max(1)).flat_map(|row| row.chunks(2).map(two)).collect();
    Arrays { columns, ..Arrays::default() }
}
