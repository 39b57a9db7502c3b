//! Imports in a row: one goes on, others wait. What is to become of each is remembered with it.

use std::collections::VecDeque;

use super::{Failed, Job, Order, Ready, Stage};
use crate::assets::Place;

/// What comes after an import.
#[derive(Clone, Debug, PartialEq)]
pub enum Then {
    /// It lies in the project.
    Keep,
    Place(Place),
    /// Every placement of it follows.
    Again,
    /// What refers to this file refers to the new one.
    Relink(String),
}

#[derive(Default)]
pub struct Imports {
    waiting: VecDeque<(Order, Then)>,
    going: Option<(Job, Then)>,
    /// Those that had no thread.
    refused: Vec<Ended>,
}

/// How far it is.
#[derive(Clone, Debug, PartialEq)]
pub struct Going {
    /// Of the file.
    pub name: String,
    pub stage: Stage,
    /// Others that wait.
    pub waiting: usize,
}

/// What came of one.
pub struct Ended {
    pub name: String,
    pub then: Then,
    pub result: Result<Ready, Failed>,
}

impl Imports {
    pub fn push(&mut self, order: Order, then: Then) {
        self.waiting.push_back((order, then));
    }

    /// To be called with every picture: what ended, once. The next begins at once.
    pub fn poll(&mut self) -> Option<Ended> {
        let ended = self.take_ended();
        if self.going.is_none() {
            self.begin();
        }
        ended.or_else(|| self.refused.pop())
    }

    fn take_ended(&mut self) -> Option<Ended> {
        let (job, _) = self.going.as_mut()?;
        let result = job.poll()?;
        let (job, then) = self.going.take()?;
        Some(Ended { name: name(&job.source), then, result })
    }

    fn begin(&mut self) {
        let Some((order, then)) = self.waiting.pop_front() else { return };
        let name = name(&order.source);
        match Job::carry_out(order) {
            Ok(job) => self.going = Some((job, then)),
            Err(error) => self.refused.push(Ended { name, then, result: Err(error) }),
        }
    }

    pub fn going(&self) -> Option<Going> {
        let (job, _) = self.going.as_ref()?;
        Some(Going { name: name(&job.source), stage: job.stage(), waiting: self.waiting.len() })
    }

    pub fn is_idle(&self) -> bool {
        self.going.is_none() && self.waiting.is_empty() && self.refused.is_empty()
    }

    /// The one that goes on, and all that wait.
    pub fn cancel(&mut self) {
        self.waiting.clear();
        if let Some((job, _)) = &self.going {
            job.cancel();
        }
    }
}

fn name(source: &std::path::Path) -> String {
    source.file_name().unwrap_or_default().to_string_lossy().into_owned()
}
