//! Input that comes faster than pictures. Whoever types `0.9`, Tab, `2` within one picture of a heavy scene means two
//! fields; but the keyboard moves on once for a picture, before any field reads what was typed. So what comes before and
//! after such a step is given to pictures of its own.

use eframe::egui::{Context, Event, Key, RawInput};

/// What waits for the next picture.
#[derive(Default)]
pub struct InTurn {
    waiting: Vec<Event>,
}

impl InTurn {
    /// Leaves of the input what this picture can take.
    pub fn sort(&mut self, ctx: &Context, input: &mut RawInput) {
        let mut events = std::mem::take(&mut self.waiting);
        events.append(&mut input.events);
        self.waiting = events.split_off(end_of_turn(&events));
        input.events = events;
        if !self.waiting.is_empty() {
            ctx.request_repaint();
        }
    }
}

/// How many of them belong to one picture.
fn end_of_turn(events: &[Event]) -> usize {
    let (mut is_typed, mut has_moved) = (false, false);
    for (at, event) in events.iter().enumerate() {
        let ends = moves_keyboard(event) && is_typed || is_key(event) && has_moved;
        if ends {
            return at;
        }
        is_typed |= is_key(event);
        has_moved |= moves_keyboard(event);
    }
    events.len()
}

/// To another field: Tab, and a click that ends.
fn moves_keyboard(event: &Event) -> bool {
    matches!(
        event,
        Event::Key { key: Key::Tab, pressed: true, .. } | Event::PointerButton { pressed: false, .. }
    )
}

fn is_key(event: &Event) -> bool {
    match event {
        Event::Key { pressed, .. } => *pressed,
        Event::Text(_) | Event::Paste(_) | Event::Cut | Event::Copy | Event::Ime(_) => true,
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use eframe::egui::{Modifiers, PointerButton, pos2};

    use super::*;

    fn text(text: &str) -> Event {
        Event::Text(text.to_owned())
    }

    fn key(key: Key) -> Event {
        Event::Key { key, physical_key: None, pressed: true, repeat: false, modifiers: Modifiers::NONE }
    }

    fn let_go() -> Event {
        let (pos, button) = (pos2(1.0, 1.0), PointerButton::Primary);
        Event::PointerButton { pos, button, pressed: false, modifiers: Modifiers::NONE }
    }

    /// Picture by picture.
    fn turns(events: Vec<Event>) -> Vec<Vec<Event>> {
        let (ctx, mut in_turn) = (Context::default(), InTurn::default());
        let mut input = RawInput { events, ..RawInput::default() };
        let mut turns = Vec::new();
        loop {
            in_turn.sort(&ctx, &mut input);
            if input.events.is_empty() {
                return turns;
            }
            turns.push(std::mem::take(&mut input.events));
        }
    }

    #[test]
    fn what_is_typed_into_two_fields_within_a_picture_comes_in_turn() {
        let typed = vec![text("0"), text("9"), key(Key::Tab), text("2"), key(Key::Enter)];
        let wanted = [vec![text("0"), text("9")], vec![key(Key::Tab)], vec![text("2"), key(Key::Enter)]];
        assert_eq!(turns(typed), wanted);
        assert_eq!(turns(vec![let_go(), text("1")]), [vec![let_go()], vec![text("1")]]);
    }

    #[test]
    fn what_goes_to_one_place_stays_together() {
        let typed = vec![text("a"), text("b"), key(Key::Enter)];
        assert_eq!(turns(typed.clone()), [typed]);
        let clicks = vec![let_go(), let_go()];
        assert_eq!(turns(clicks.clone()), [clicks]);
    }
}
