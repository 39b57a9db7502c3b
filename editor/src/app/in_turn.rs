//! Input that comes faster than pictures. Whoever types `0.9`, Tab, `2` within one picture of a heavy scene means two
//! fields; but the keyboard moves on once for a picture, before any field reads what was typed. And a handle that is pressed,
//! pulled and let go within one picture would only be clicked. So what such steps part is given to pictures of its own.

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
    let mut before = Before::default();
    for (at, event) in events.iter().enumerate() {
        if before.ends_at(event) {
            return at;
        }
        before.note(event);
    }
    events.len()
}

/// What a picture takes already.
#[derive(Default)]
struct Before {
    is_typed: bool,
    /// The keyboard may have gone to another field.
    has_left: bool,
    is_pressed: bool,
    /// Since it was pressed.
    has_moved: bool,
}

impl Before {
    fn note(&mut self, event: &Event) {
        self.is_typed |= is_key(event);
        self.has_left |= leaves_field(event);
        self.is_pressed |= is_button(event, true);
        self.has_moved |= matches!(event, Event::PointerMoved(_));
        // A click stays whole: what lasts for several slow pictures would be none.
        self.has_moved &= !is_button(event, true);
    }

    fn ends_at(&self, event: &Event) -> bool {
        let is_typed_elsewhere = leaves_field(event) && self.is_typed || is_key(event) && self.has_left;
        // What is grasped is what lies where the button went down, and it is pulled before it is let go.
        let is_pull = self.is_pressed && matches!(event, Event::PointerMoved(_));
        let is_end_of_pull = is_button(event, false) && self.has_moved;
        is_typed_elsewhere || is_pull || is_end_of_pull
    }
}

/// Tab, and a click that ends.
fn leaves_field(event: &Event) -> bool {
    matches!(event, Event::Key { key: Key::Tab, pressed: true, .. }) || is_button(event, false)
}

fn is_button(event: &Event, down: bool) -> bool {
    matches!(event, Event::PointerButton { pressed, .. } if *pressed == down)
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

    fn button(pressed: bool) -> Event {
        let (pos, button) = (pos2(1.0, 1.0), PointerButton::Primary);
        Event::PointerButton { pos, button, pressed, modifiers: Modifiers::NONE }
    }

    fn press() -> Event {
        button(true)
    }

    fn let_go() -> Event {
        button(false)
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
    fn a_pull_within_a_picture_is_grasped_pulled_and_let_go() {
        let (from, to) = (Event::PointerMoved(pos2(1.0, 1.0)), Event::PointerMoved(pos2(9.0, 1.0)));
        let events = vec![from.clone(), press(), to.clone(), to.clone(), let_go()];
        assert_eq!(turns(events), [vec![from, press()], vec![to.clone(), to], vec![let_go()]]);
        let click = vec![Event::PointerMoved(pos2(1.0, 1.0)), press(), let_go()];
        assert_eq!(turns(click.clone()), [click]);
    }

    #[test]
    fn what_goes_to_one_place_stays_together() {
        let typed = vec![text("a"), text("b"), key(Key::Enter)];
        assert_eq!(turns(typed.clone()), [typed]);
        let clicks = vec![let_go(), let_go()];
        assert_eq!(turns(clicks.clone()), [clicks]);
    }
}
