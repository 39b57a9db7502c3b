//! Undo and redo: steps that are data, as many as fit a budget of memory.

use std::collections::VecDeque;

use crate::edit::{Edit, Stale};

/// Bytes that undo and redo may hold together; then the oldest steps go.
pub const BUDGET: usize = 256 << 20;

/// What takes the scene from one state to its neighbour.
#[derive(Debug)]
pub struct Step {
    pub name: String,
    pub edit: Edit,
    pub stale: Stale,
    /// The state that it leads to. States are numbered and never numbered again.
    pub leads_to: u64,
    bytes: usize,
}

impl Step {
    pub fn new(name: String, edit: Edit, stale: Stale, leads_to: u64) -> Self {
        let bytes = std::mem::size_of::<Self>() + name.len() + edit.bytes();
        Self { name, edit, stale, leads_to, bytes }
    }

    pub fn bytes(&self) -> usize {
        self.bytes
    }
}

#[derive(Debug)]
pub struct History {
    /// The latest last.
    undo: VecDeque<Step>,
    /// The next last.
    redo: Vec<Step>,
    bytes: usize,
    budget: usize,
    /// Steps that had to go.
    pub spilled: usize,
}

impl Default for History {
    fn default() -> Self {
        Self::within(BUDGET)
    }
}

impl History {
    pub fn within(budget: usize) -> Self {
        Self { undo: VecDeque::new(), redo: Vec::new(), bytes: 0, budget, spilled: 0 }
    }

    /// A new step: what was undone cannot be redone any more.
    pub fn push(&mut self, step: Step) {
        self.bytes -= self.redo.drain(..).map(|step| step.bytes).sum::<usize>();
        self.push_undo(step);
    }

    /// The way back from a step that was redone.
    pub fn push_undo(&mut self, step: Step) {
        self.bytes += step.bytes;
        self.undo.push_back(step);
        // The latest step stays, however large: it holds no more than the scene did.
        while self.bytes > self.budget && self.undo.len() > 1 {
            let oldest = self.undo.pop_front().map_or(0, |step| step.bytes);
            self.bytes -= oldest;
            self.spilled += 1;
        }
    }

    pub fn push_redo(&mut self, step: Step) {
        self.bytes += step.bytes;
        self.redo.push(step);
    }

    pub fn pop_undo(&mut self) -> Option<Step> {
        let step = self.undo.pop_back()?;
        self.bytes -= step.bytes;
        Some(step)
    }

    pub fn pop_redo(&mut self) -> Option<Step> {
        let step = self.redo.pop()?;
        self.bytes -= step.bytes;
        Some(step)
    }

    /// The latest first.
    pub fn undo_names(&self) -> impl Iterator<Item = &str> {
        self.undo.iter().rev().map(|step| step.name.as_str())
    }

    /// The next first.
    pub fn redo_names(&self) -> impl Iterator<Item = &str> {
        self.redo.iter().rev().map(|step| step.name.as_str())
    }

    pub fn bytes(&self) -> usize {
        self.bytes
    }

    /// The sums hold.
    pub fn validate(&self) -> Result<(), String> {
        let sum: usize = self.undo.iter().chain(&self.redo).map(|step| step.bytes).sum();
        if sum == self.bytes { Ok(()) } else { Err(format!("holds {sum} bytes, counts {}", self.bytes)) }
    }
}

#[cfg(test)]
mod tests {
    use engine::scene::EntityId;

    use super::*;
    use crate::edit::Field;

    fn step(state: u64) -> Step {
        let edit = Edit::set(EntityId(1), Field::Name("x".repeat(1000)));
        Step::new(format!("step {state}"), edit, Stale::Nothing, state)
    }

    #[test]
    fn the_oldest_steps_go_when_the_budget_is_spent() {
        let budget = 10 * step(0).bytes() + 50;
        let mut history = History::within(budget);
        for state in 0..25 {
            history.push(step(state));
            assert!(history.bytes() <= budget);
            history.validate().unwrap();
        }
        assert_eq!(history.undo_names().count() + history.spilled, 25);
        assert_eq!(history.undo_names().next(), Some("step 24"));
        assert!(history.undo_names().count() >= 9);
    }

    #[test]
    fn what_goes_from_undo_to_redo_and_back_counts_once() {
        let mut history = History::default();
        (0..3).for_each(|state| history.push(step(state)));
        let before = history.bytes();
        let undone = history.pop_undo().unwrap();
        history.push_redo(undone);
        assert_eq!((history.bytes(), history.redo_names().count()), (before, 1));
        history.push(step(9));
        assert_eq!((history.undo_names().count(), history.redo_names().count()), (3, 0));
        history.validate().unwrap();
    }

    #[test]
    fn one_step_larger_than_the_budget_stays() {
        let mut history = History::within(10);
        history.push(step(1));
        assert_eq!(history.undo_names().count(), 1);
        history.push(step(2));
        assert_eq!((history.undo_names().count(), history.spilled), (1, 1));
    }
}
