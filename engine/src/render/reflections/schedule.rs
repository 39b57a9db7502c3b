//! When a probe is captured: after what it sees has changed, as its author says, within a budget of faces a frame.

use crate::scene::{Faces, ReflectionProbe, Refresh};

/// Faces that probes share in a frame which need not be captured at once.
const BUDGET: u32 = 12;

/// Captures after a change, if they do not settle before: mirrors that give back 0.9 leave 1 % of what was there
/// after so many.
const MOST_ROUNDS: u32 = 45;

/// Counts changes of what captures show.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Seen {
    /// Light, materials, static surfaces, sky.
    pub still: u64,
    /// What moves.
    pub moving: u64,
}

/// What a probe waits for.
#[derive(Clone, Debug, Default)]
pub struct Schedule {
    /// `None`: nothing was followed yet.
    seen: Option<Seen>,
    /// Captures that are still due.
    rounds: u32,
    /// The next face of a capture that was begun.
    face: usize,
    /// Only what moves has changed: static surfaces need not be drawn again.
    on_top: bool,
    /// Something has moved since captures of all became due.
    moved: bool,
    /// Counts captures of all probes that share the budget: when its last one was.
    turn: u64,
    /// Nothing in view reads it.
    unread: bool,
    /// It has changed while nothing read it.
    stale: bool,
    /// Its cubemap holds a capture.
    pub taken: bool,
}

/// Faces to capture now.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Due {
    pub probe: usize,
    pub first: usize,
    pub end: usize,
    pub on_top: bool,
}

impl Schedule {
    /// Everything has changed.
    pub fn restart(&mut self) {
        *self = Self { taken: self.taken, face: self.face, turn: self.turn, ..Self::default() };
    }

    /// The cubemap came from elsewhere and stays.
    pub fn keep(&mut self) {
        *self = Self { seen: self.seen, taken: true, turn: self.turn, ..Self::default() };
    }

    /// Captured, and no capture is due.
    pub fn is_done(&self) -> bool {
        self.taken && self.rounds == 0 && self.face == 0
    }

    /// The last captures do not differ, and nothing has changed since: reflections of reflections are settled.
    pub fn settle(&mut self, refresh: Refresh, seen: Seen) {
        let same = refresh == Refresh::Baked || self.seen == Some(seen);
        if same && !self.on_top {
            self.rounds = 0;
        }
    }

    /// What it shows now.
    pub fn seen(&self) -> Seen {
        self.seen.unwrap_or_default()
    }

    /// `read`: something in view shows it. Else it waits, and is captured at once when it is read again.
    pub fn follow(&mut self, refresh: Refresh, now: Seen, read: bool) {
        self.unread = !read && self.taken && refresh != Refresh::Baked;
        let Some(seen) = self.seen.replace(now) else {
            self.rounds = MOST_ROUNDS;
            return;
        };
        if refresh == Refresh::Baked {
            return;
        }
        if now.still != seen.still {
            (self.rounds, self.on_top) = (MOST_ROUNDS, false);
        } else if now.moving != seen.moving {
            // A capture that is due anyway sees what has moved, too.
            if self.rounds == 0 || self.on_top {
                (self.rounds, self.on_top) = (1, true);
            }
            self.moved = true;
        } else if self.moved && self.rounds == 0 {
            // It stands still: what static mirrors show of it is caught up with.
            (self.rounds, self.on_top, self.moved) = (MOST_ROUNDS, false, false);
        }
        self.stale |= self.unread && (self.rounds > 0 || self.face > 0);
        if self.stale {
            // Faces of before are of another light.
            self.face = 0;
        }
    }

    /// What faces are due, by what the probe says.
    fn faces(&self, probe: usize, faces: Faces) -> Due {
        let end = match faces {
            Faces::Sliced if self.taken && !self.stale => self.face + 1,
            // The first picture has reflections, too.
            _ => 6,
        };
        Due { probe, first: self.face, end, on_top: self.on_top }
    }

    /// After these faces were captured. Returns whether the cubemap is complete.
    pub fn took(&mut self, due: &Due) -> bool {
        self.face = due.end % 6;
        let complete = due.end == 6;
        self.stale = false;
        self.rounds -= u32::from(complete && self.rounds > 0);
        self.taken |= complete;
        complete
    }
}

/// What is captured in this frame. `settled`: light is solved, so that what is baked may be captured for good.
pub fn plan(probes: &mut [(&ReflectionProbe, &mut Schedule)], settled: bool) -> Vec<Due> {
    let mut plan = Vec::new();
    let mut waiting = Vec::new();
    let mut turn = probes.iter().map(|(_, schedule)| schedule.turn).max().unwrap_or(0);
    for (index, (settings, schedule)) in probes.iter_mut().enumerate() {
        let due = schedule.rounds > 0 || schedule.face > 0;
        let early = settings.refresh == Refresh::Baked && schedule.taken && !settled;
        if !due || early || schedule.unread {
            continue;
        }
        let faces = schedule.faces(index, settings.faces);
        if settings.refresh == Refresh::EveryFrame || !schedule.taken || schedule.stale {
            plan.push(faces);
        } else {
            waiting.push((schedule.turn, faces));
        }
    }
    waiting.sort_by_key(|(turn, faces)| (*turn, faces.probe));
    let mut left = BUDGET;
    for (_, faces) in waiting {
        let count = (faces.end - faces.first) as u32;
        if count <= left {
            left -= count;
            turn += 1;
            probes[faces.probe].1.turn = turn;
            plan.push(faces);
        }
    }
    plan
}

#[cfg(test)]
mod tests {
    use super::*;

    fn probe(refresh: Refresh, faces: Faces) -> ReflectionProbe {
        ReflectionProbe { refresh, faces, ..ReflectionProbe::default() }
    }

    /// As light that settles with the second capture.
    fn took(schedule: &mut Schedule, due: &Due, seen: Seen) {
        if schedule.took(due) && schedule.rounds == MOST_ROUNDS - 2 {
            schedule.settle(Refresh::OnChange, seen);
        }
    }

    /// Faces captured in each of so many frames in which `seen` says what has changed.
    fn play(settings: &[ReflectionProbe], frames: u64, seen: impl Fn(u64) -> Seen) -> Vec<u32> {
        let mut schedules = vec![Schedule::default(); settings.len()];
        let frame = |frame: u64| {
            for (schedule, settings) in schedules.iter_mut().zip(settings) {
                schedule.follow(settings.refresh, seen(frame), true);
            }
            let mut probes: Vec<_> = settings.iter().zip(schedules.iter_mut()).collect();
            let plan = plan(&mut probes, true);
            for due in &plan {
                took(&mut schedules[due.probe], due, seen(frame));
            }
            plan.iter().map(|due| (due.end - due.first) as u32).sum()
        };
        (0..frames).map(frame).collect()
    }

    #[test]
    fn nothing_changed_means_no_captures() {
        for refresh in [Refresh::Baked, Refresh::OnChange, Refresh::EveryFrame] {
            let faces = play(&[probe(refresh, Faces::AllAtOnce)], 5, |_| Seen::default());
            assert_eq!(faces, [6, 6, 0, 0, 0], "{refresh:?}");
            let faces = play(&[probe(refresh, Faces::Sliced)], 14, |_| Seen::default());
            assert_eq!(faces, [vec![6], vec![1; 6], vec![0; 7]].concat(), "{refresh:?}");
        }
    }

    #[test]
    fn what_is_baked_stays_and_the_others_follow() {
        let seen = |frame| Seen { still: u64::from(frame >= 4), moving: 0 };
        let faces = |refresh| play(&[probe(refresh, Faces::AllAtOnce)], 8, seen);
        assert_eq!(faces(Refresh::Baked)[4..], [0; 4]);
        assert_eq!(faces(Refresh::OnChange)[4..], [6, 6, 0, 0]);
    }

    #[test]
    fn what_moves_is_drawn_on_top_and_caught_up_with_at_rest() {
        let mut schedule = Schedule::default();
        let settings = probe(Refresh::OnChange, Faces::AllAtOnce);
        let mut on_top = Vec::new();
        for frame in 0..9_u64 {
            let seen = Seen { still: 0, moving: frame.clamp(3, 5) };
            schedule.follow(settings.refresh, seen, true);
            let plan = plan(&mut [(&settings, &mut schedule)], true);
            plan.iter().for_each(|due| took(&mut schedule, due, seen));
            on_top.push(plan.first().map(|due| due.on_top));
        }
        let expected =
            [Some(false), Some(false), None, None, Some(true), Some(true), Some(false), Some(false), None];
        assert_eq!(on_top, expected);
    }

    #[test]
    fn what_nothing_reads_waits_and_is_captured_at_once_when_it_is_read_again() {
        let settings = vec![probe(Refresh::OnChange, Faces::Sliced); 5];
        let mut schedules = vec![Schedule::default(); 5];
        let mut faces = Vec::new();
        for frame in 0..12_u64 {
            // Light changes all the time; from the third frame to the eighth nobody looks.
            let seen = Seen { still: frame, moving: 0 };
            schedules.iter_mut().for_each(|schedule| {
                schedule.follow(Refresh::OnChange, seen, !(3..9).contains(&frame));
            });
            let mut probes: Vec<_> = settings.iter().zip(schedules.iter_mut()).collect();
            let plan = plan(&mut probes, true);
            plan.iter().for_each(|due| {
                schedules[due.probe].took(due);
            });
            faces.push(plan.iter().map(|due| due.end - due.first).sum::<usize>());
        }
        assert_eq!(faces[3..9], [0; 6]);
        // Whole cubemaps, in spite of slices and budget.
        assert_eq!(faces[9], 5 * 6);
    }

    #[test]
    fn probes_beyond_the_budget_take_turns() {
        let settings = vec![probe(Refresh::OnChange, Faces::AllAtOnce); 5];
        let mut schedules = vec![Schedule::default(); 5];
        let mut taken = vec![0; 5];
        for frame in 0..21 {
            for schedule in &mut schedules {
                schedule.follow(Refresh::OnChange, Seen { still: frame, moving: 0 }, true);
            }
            let mut probes: Vec<_> = settings.iter().zip(schedules.iter_mut()).collect();
            let plan = plan(&mut probes, true);
            // The first picture has them all.
            assert_eq!(plan.len(), if frame == 0 { 5 } else { 2 });
            for due in plan {
                schedules[due.probe].took(&due);
                taken[due.probe] += 1;
            }
        }
        assert_eq!(taken, [9; 5]);
    }
}
