//! Random numbers of a path: four-dimensional Sobol points, padded.
//!
//! Each decision of a path (which way, which lamp) takes a point set of its own, scrambled and put into an order of
//! its own (Burley 2020): even by itself, independent of the others. A replicate is another seed.

use crate::directions::{Sobol, hash, hash_of, unit};

/// The numbers of one path of one replicate.
pub struct Numbers<'a> {
    sobol: &'a Sobol,
    index: u32,
    /// The index's digits that are put into another order: the path's block has so many paths.
    mask: u32,
    seed: u64,
}

/// Paths `start .. start + count` of every replicate. The start is a multiple of the count rounded up to a power of
/// two, so that blocks that follow each other fill Sobol's sequence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Block {
    pub start: u32,
    pub count: u32,
}

impl Block {
    /// The block's paths, by their numbers.
    pub fn paths<'a>(&self, sobol: &'a Sobol, seed: u64) -> impl Iterator<Item = Numbers<'a>> {
        let mask = self.count.next_power_of_two() - 1;
        let seed = hash_of([seed, u64::from(self.start)]);
        (self.start..self.start + self.count).map(move |index| Numbers { sobol, index, mask, seed })
    }

    /// How many of Sobol's points the block needs.
    pub fn end(&self) -> u32 {
        self.start + self.count.next_power_of_two()
    }
}

impl Numbers<'_> {
    /// Four numbers in 0..1 for a decision.
    pub fn four(&self, decision: u32) -> [f32; 4] {
        let seed = hash(self.seed ^ hash(u64::from(decision)));
        let order = reorder(self.index.reverse_bits(), seed as u32) & self.mask;
        self.sobol.point(self.index & !self.mask | order, seed)
    }

    /// A number in 0..1 that is even in no way.
    pub fn one(&self, decision: u32) -> f32 {
        unit(hash(hash(self.seed ^ hash(u64::from(decision))) ^ u64::from(self.index)) as u32)
    }
}

/// A permutation of the indices of every power of two (Laine and Karras 2011).
fn reorder(reversed: u32, seed: u32) -> u32 {
    let mut x = reversed.wrapping_add(seed);
    x ^= x.wrapping_mul(0x6c50_b47c);
    x ^= x.wrapping_mul(0xb82f_1e52);
    x ^= x.wrapping_mul(0xc7af_e638);
    x ^= x.wrapping_mul(0x8d22_f6e6);
    x.reverse_bits()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_decision_takes_each_point_of_a_block_once() {
        let sobol = Sobol::new(96);
        for block in [Block { start: 0, count: 64 }, Block { start: 64, count: 32 }] {
            for decision in 0..5 {
                let mut orders: Vec<u32> = block
                    .paths(&sobol, 3)
                    .map(|numbers| (numbers.four(decision)[0] * block.count as f32) as u32)
                    .collect();
                let first = orders.clone();
                orders.sort_unstable();
                assert!(orders.iter().copied().eq(0..block.count), "decision {decision}: {orders:?}");
                let next: Vec<u32> = block
                    .paths(&sobol, 3)
                    .map(|numbers| (numbers.four(decision + 1)[0] * block.count as f32) as u32)
                    .collect();
                assert_ne!(first, next);
            }
        }
    }
}
