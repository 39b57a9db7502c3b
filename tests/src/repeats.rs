//! Very long runs of an iteration that depends on nothing but its state: once it comes back to a state it was in, all
//! that follows is known, to the last bit.

use std::collections::HashMap;

use bytemuck::Pod;

/// The states that an iteration goes through until it repeats itself.
pub struct Run<T> {
    /// The first is what it started from.
    pub states: Vec<Vec<T>>,
    /// Where the last state leads to.
    first: usize,
}

/// Steps after which an iteration that has not come back has none of our patience.
const PATIENCE: usize = 50_000;

pub fn run<T: Pod>(start: Vec<T>, mut step: impl FnMut(&mut Vec<T>)) -> Run<T> {
    let mut seen: HashMap<Vec<u8>, usize> = HashMap::new();
    let (mut states, mut state) = (Vec::new(), start);
    while states.len() < PATIENCE {
        let bits = bytemuck::cast_slice(&state).to_vec();
        if let Some(&first) = seen.get(&bits) {
            return Run { states, first };
        }
        seen.insert(bits, states.len());
        states.push(state.clone());
        step(&mut state);
    }
    panic!("it does not repeat itself within {PATIENCE} steps");
}

impl<T> Run<T> {
    /// Steps from a state to its return.
    pub fn period(&self) -> usize {
        self.states.len() - self.first
    }

    /// The state after so many steps.
    pub fn after(&self, steps: usize) -> &[T] {
        let n = self.states.len();
        &self.states[if steps < n { steps } else { self.first + (steps - self.first) % self.period() }]
    }
}
