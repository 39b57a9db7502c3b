//! A value that is typed while a handle is pulled: `1.5`, `-30`, `0.5 2`, and the pull is exactly that.

use eframe::egui::{Event, InputState, Key};
use glam::DVec3;

use super::{Change, Handle, Stand};
use crate::inspector::arithmetic::{self, Unit};

#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Typed {
    pub text: String,
}

impl Typed {
    /// Takes what was typed since the last picture. Returns whether Enter was pressed.
    pub fn take(&mut self, input: &InputState) -> bool {
        let mut done = false;
        for event in &input.events {
            match event {
                Event::Text(text) => {
                    self.text.extend(text.chars().filter(|c| " 0123456789+-*/().,".contains(*c)))
                }
                Event::Key { key: Key::Backspace, pressed: true, .. } => drop(self.text.pop()),
                Event::Key { key: Key::Enter, pressed: true, .. } => done = true,
                _ => {}
            }
        }
        done && !self.text.is_empty()
    }

    pub fn is_empty(&self) -> bool {
        self.text.trim().is_empty()
    }

    /// What the handle is pulled by; `None`: it is no number yet. Planes take two numbers, all axes at once three.
    pub fn change(&self, handle: Handle, stand: &Stand, towards_eye: DVec3) -> Option<Change> {
        let unit = match handle {
            Handle::Ring(_) | Handle::RingScreen => Unit::Degrees,
            Handle::ScaleAxis(_) | Handle::ScaleAll => Unit::None,
            _ => Unit::Metres,
        };
        let words = self.text.split([' ', ',']).filter(|word| !word.is_empty());
        let numbers: Option<Vec<f64>> = words.map(|word| arithmetic::number(word, unit)).collect();
        let numbers = numbers.filter(|numbers| !numbers.is_empty())?;
        let at = |index: usize| numbers.get(index).copied().unwrap_or(0.0);
        let along = |axes: &[usize]| axes.iter().enumerate().map(|(k, axis)| stand.axis(*axis) * at(k)).sum();
        Some(match handle {
            Handle::MoveAxis(axis) => Change::Move(along(&[axis])),
            Handle::MovePlane(axis) => {
                let [low, high] = [(axis + 1) % 3, (axis + 2) % 3];
                Change::Move(along(&[low.min(high), low.max(high)]))
            }
            Handle::MoveScreen => Change::Move(along(&[0, 1, 2])),
            Handle::Ring(axis) => Change::Turn { axis: stand.axis(axis), angle: at(0).to_radians() },
            Handle::RingScreen => Change::Turn { axis: towards_eye, angle: at(0).to_radians() },
            Handle::ScaleAxis(axis) => {
                let mut scale = DVec3::ONE;
                scale[axis] = at(0);
                Change::Scale(scale)
            }
            Handle::ScaleAll => Change::Scale(DVec3::splat(at(0))),
        })
    }
}

#[cfg(test)]
mod tests {
    use glam::DQuat;

    use super::*;

    const STAND: Stand = Stand { origin: DVec3::ZERO, axes: DQuat::IDENTITY };

    fn typed(text: &str, handle: Handle) -> Option<Change> {
        Typed { text: text.to_owned() }.change(handle, &STAND, DVec3::Z)
    }

    #[test]
    fn numbers_mean_what_the_handle_does() {
        assert_eq!(typed("1.5", Handle::MoveAxis(1)), Some(Change::Move(DVec3::Y * 1.5)));
        assert_eq!(typed("-2 3", Handle::MovePlane(1)), Some(Change::Move(DVec3::new(-2.0, 0.0, 3.0))));
        assert_eq!(typed("1,2,3", Handle::MoveScreen), Some(Change::Move(DVec3::new(1.0, 2.0, 3.0))));
        let quarter = std::f64::consts::FRAC_PI_2;
        assert_eq!(typed("90", Handle::Ring(1)), Some(Change::Turn { axis: DVec3::Y, angle: quarter }));
        assert_eq!(typed("2", Handle::ScaleAll), Some(Change::Scale(DVec3::splat(2.0))));
        assert_eq!(typed("0.5", Handle::ScaleAxis(0)), Some(Change::Scale(DVec3::new(0.5, 1.0, 1.0))));
    }

    #[test]
    fn what_is_no_number_yet_changes_nothing() {
        assert_eq!((typed("", Handle::ScaleAll), typed("-", Handle::ScaleAll)), (None, None));
    }
}
