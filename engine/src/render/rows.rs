//! Sparse rows on the GPU, in pages that fit a storage binding.

use bytemuck::{Pod, Zeroable};
use wgpu::BufferUsages as Usage;

use crate::gpu::pass::{self, Binding};
use crate::gpu::{Gpu, GpuError, buffer};
use crate::transport::{Rows, packed};

/// `Page` in `transport/rows.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct PageUniform {
    pub first: u32,
    pub count: u32,
    /// 1 where columns hold weights too ([`crate::transport::packed`]).
    pub packed: u32,
    pub padding: u32,
}

/// Rows as runs of whole rows, each with its own starts, columns and weights.
pub struct PagedRows {
    pages: Vec<Page>,
    pub bytes: u64,
}

struct Page {
    group: wgpu::BindGroup,
    rows: u32,
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
    pub fn new(gpu: &Gpu, layout: &wgpu::BindGroupLayout, what: &str, rows: &Rows) -> Result<Self, GpuError> {
        let mut pages = Vec::new();
        let mut bytes = rows.starts.len() as u64 * 4;
        for range in buffer::pages(what, &rows.starts, gpu.page_bytes)? {
            let entries = rows.starts[range.start] as usize..rows.starts[range.end] as usize;
            let starts: Vec<u32> = rows.starts[range.start..=range.end]
                .iter()
                .map(|start| (start - rows.starts[range.start]) as u32)
                .collect();
            let (columns, weights) = (&rows.columns[entries.clone()], &rows.weights[entries]);
            let packed = packed::pack_all(columns, weights);
            let (columns, weights) = match &packed {
                Some(packed) => (packed.as_slice(), &[][..]),
                None => (columns, weights),
            };
            bytes += (columns.len() + weights.len()) as u64 * 4;
            let page = PageUniform {
                first: range.start as u32,
                count: range.len() as u32,
                packed: u32::from(packed.is_some()),
                padding: 0,
            };
            let buffers = [
                buffer::filled(gpu, "page", &[page], Usage::UNIFORM),
                buffer::filled(gpu, "starts", &starts, Usage::STORAGE),
                buffer::filled(gpu, "columns", columns, Usage::STORAGE),
                buffer::filled(gpu, "weights", weights, Usage::STORAGE),
            ];
            let group = pass::buffers(gpu, what, layout, &buffers.each_ref());
            pages.push(Page { group, rows: page.count });
        }
        Ok(Self { pages, bytes })
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
