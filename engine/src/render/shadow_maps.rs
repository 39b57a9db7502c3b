//! The memory of shadow maps: for each kind of light the layers of one array texture. Maps are as large as a budget
//! allows for so many of them, so that many lights have coarser shadows and not none. Room is made by doubling: only
//! then are all maps of the kind drawn again. Whose layers are whose does not change while a light is there.

use crate::gpu::{Gpu, texture};
use crate::scene::EntityId;

use super::shadow_view::{POINT, SUN};

/// Bytes for the maps of a kind.
const BUDGETS: [u64; 3] = [96 << 20, 64 << 20, 96 << 20];
/// Texels across a map at most, on a GPU and drawn by the processor.
const LARGEST: [[u32; 2]; 3] = [[4096, 2048], [1024, 1024], [512, 512]];
/// The same of suns with cascades.
const LARGEST_CASCADE: [u32; 2] = [2048, 1024];
/// Sizes are multiples of this many texels.
const STEP: u32 = 16;

/// The maps of one kind of light.
pub struct Maps {
    kind: usize,
    pub texture: wgpu::Texture,
    /// Texels across a map.
    pub size: u32,
    /// Layers of one light.
    pub each: usize,
    /// By place: whose it is.
    owners: Vec<Option<EntityId>>,
    /// By layer.
    pub drawn: Vec<Content>,
}

/// What is drawn in a map; zeros before the first time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Content {
    /// A number for all that is seen there.
    pub signature: u64,
    /// Of all casters and the view, when that was last looked at.
    pub looked_at: u64,
}

impl Maps {
    pub fn new(gpu: &Gpu, kind: usize) -> Self {
        let texture = texture::depth_layers(gpu, "shadow maps", 1, 1);
        Self { kind, texture, size: 0, each: 1, owners: Vec::new(), drawn: Vec::new() }
    }

    /// Gives each of these lights its place, as far as there is room, and makes room. Returns whether the texture is
    /// another one now, with nothing drawn yet.
    pub fn keep(&mut self, gpu: &Gpu, wanted: &[EntityId], each: usize) -> bool {
        let remade = self.make_room(gpu, wanted.len(), each);
        for owner in &mut self.owners {
            *owner = owner.filter(|owner| wanted.contains(owner));
        }
        for &light in wanted {
            if self.place(light).is_some() {
                continue;
            }
            if let Some(free) = self.owners.iter_mut().find(|owner| owner.is_none()) {
                *free = Some(light);
            }
        }
        remade
    }

    /// The first layer of a light.
    pub fn layer(&self, light: EntityId) -> Option<usize> {
        Some(self.place(light)? * self.each)
    }

    fn place(&self, light: EntityId) -> Option<usize> {
        self.owners.iter().position(|&owner| owner == Some(light))
    }

    /// Lights that have no map.
    pub fn left_out(&self, wanted: usize) -> usize {
        wanted.saturating_sub(self.owners.len())
    }

    pub fn bytes(&self) -> u64 {
        if self.size == 0 {
            return 0;
        }
        let texels = u64::from(self.texture.width()) * u64::from(self.texture.height());
        texels * 4 * u64::from(self.texture.depth_or_array_layers())
    }

    /// Nobody wants a map. Returns whether there were any.
    fn release(&mut self, gpu: &Gpu) -> bool {
        let had = self.size > 0;
        if had {
            *self = Self::new(gpu, self.kind);
        }
        had
    }

    fn make_room(&mut self, gpu: &Gpu, wanted: usize, each: usize) -> bool {
        let most = gpu.device.limits().max_texture_array_layers as usize;
        let fits = wanted <= self.owners.len() && wanted * 4 > self.owners.len();
        let places = wanted.next_power_of_two().min((most - 1) / each);
        if wanted == 0 {
            return self.release(gpu);
        }
        if each == self.each && (fits || places == self.owners.len()) && self.size > 0 {
            return false;
        }
        let largest = if each > 1 && self.kind == SUN { LARGEST_CASCADE } else { LARGEST[self.kind] };
        let largest = largest[usize::from(gpu.software)];
        self.each = each;
        self.size = size(places * each, BUDGETS[self.kind], largest);
        self.texture = texture::depth_layers(gpu, "shadow maps", self.size, (places * each) as u32);
        self.owners.resize(places, None);
        self.drawn = vec![Content::default(); places * each];
        true
    }
}

/// Texels across each of so many maps.
fn size(layers: usize, budget: u64, largest: u32) -> u32 {
    let layers = u64::from(texture::array_layers(layers as u32));
    let most = (budget as f64 / (4 * layers) as f64).sqrt() as u32 / STEP * STEP;
    most.clamp(STEP, largest)
}

/// Texels across the one map of a single sun.
pub fn largest_sun(gpu: &Gpu) -> u32 {
    LARGEST[SUN][usize::from(gpu.software)]
}

/// Layers of a light of this kind.
pub fn layers_each(kind: usize, cascades: usize) -> usize {
    match kind {
        SUN => 1 + cascades,
        POINT => 6,
        _ => 1,
    }
}

#[cfg(test)]
mod tests {
    use super::super::shadow_view::SPOT;
    use super::*;

    #[test]
    fn many_maps_are_small_ones_and_never_more_bytes() {
        let mut last = u32::MAX;
        for lights in (0..9).map(|k| 1usize << k) {
            let size = size(lights * 6, BUDGETS[POINT], 512);
            assert!(size <= last && size >= 112, "{lights}: {size}");
            assert!(u64::from(size * size * 4) * (lights as u64 * 6 + 1) <= BUDGETS[POINT]);
            last = size;
        }
        assert_eq!([1, 16, 256].map(|spots| size(spots, BUDGETS[SPOT], 1024)), [1024, 1024, 256]);
    }
}
