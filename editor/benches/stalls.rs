//! How long the editor keeps a person waiting while a large file comes in beside the editing, and in the scene that came of it:
//! orbit, select, edit, undo. The longest step of the UI without what drawing takes, the median, and the longest drawing.
//!
//! Where the system tells it, steps are also told in the time that their thread ran: on a busy machine that is the figure to
//! compare.
//!
//! `cargo bench -p editor --bench stalls`, `-- FILE` for another than the shared folder's bathroom of 851 meshes and 380,000
//! triangles.

#[allow(dead_code)]
#[path = "../tests/ui/window.rs"]
mod window;

use std::path::PathBuf;
use std::time::{Duration, Instant};

use editor::edit::{Edit, Field};
use editor::intents::Intent;
use egui::{Event, Key, Modifiers, PointerButton, Pos2};
use engine::scene::Transform;
use glam::DVec3;
use window::Window;

/// The UI's steps of one kind of work.
struct Steps {
    name: &'static str,
    steps: Vec<Duration>,
    /// The most that the thread ran in a step, drawing and all.
    ran: Duration,
    drawing: Duration,
}

fn main() {
    let named = std::env::args().skip(1).find(|argument| !argument.starts_with('-')).map(PathBuf::from);
    let Some(file) = named.or_else(shared).filter(|file| file.is_file()) else {
        return println!("not run: no ../shared");
    };
    let Some(mut window) = window::open() else { return };
    let heads = ["steps", "median ms", "longest ms", "drawing ms", "thread ms"];
    let [steps, median, longest, drawing, thread] = heads;
    println!("{:<28}{steps:>8}{median:>12}{longest:>12}{drawing:>14}{thread:>12}", "");
    let at = window.scene_view().center();
    let before = window.editor().session.document.scene().entities.len();
    window.harness.hover_at(at);
    let mut import = Steps::new("import, in the background");
    window.queue_files(&[file]);
    while window.editor().session.document.scene().entities.len() == before && window.errors().is_empty() {
        import.step(&mut window);
        std::thread::sleep(Duration::from_millis(5));
    }
    import.tell();
    let mut first = Steps::new("first pictures");
    (0..30).for_each(|_| first.step(&mut window));
    first.tell();
    let entities = window.editor().session.document.scene().entities.len();
    window.harness.key_press_modifiers(Modifiers::NONE, Key::F);
    let eye = window.editor().scene.camera;
    orbit(&mut window, at).tell();
    assert_ne!(window.editor().scene.camera, eye, "the orbit turned nothing: this is no measurement");
    select(&mut window).tell();
    edit(&mut window).tell();
    println!("{entities} objects; errors: {:?}", window.errors());
}

fn shared() -> Option<PathBuf> {
    let beside = || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared");
    let shared = std::env::var_os("HOHLRAUM_SHARED").map_or_else(beside, PathBuf::from);
    Some(shared.join("assets/scenes/contemporary-bathroom.glb"))
}

impl Steps {
    fn new(name: &'static str) -> Self {
        Self { name, steps: Vec::new(), ran: Duration::ZERO, drawing: Duration::ZERO }
    }

    fn step(&mut self, window: &mut Window) {
        let drawn = window.editor().stage().drawing();
        let (since, ran) = (Instant::now(), ran());
        window.harness.step();
        let took = since.elapsed();
        self.ran = self.ran.max(self::ran().saturating_sub(ran));
        // Of all pictures: a step of the harness may be several, and a picture of the editor is laid out twice at times.
        let drawing = window.editor().stage().drawing().saturating_sub(drawn);
        self.drawing = self.drawing.max(drawing);
        self.steps.push(took.saturating_sub(drawing));
    }

    fn tell(mut self) {
        self.steps.sort();
        let ms = |duration: Duration| duration.as_secs_f64() * 1e3;
        let (median, longest) = (self.steps[self.steps.len() / 2], self.steps[self.steps.len() - 1]);
        let Self { name, steps, ran, drawing } = self;
        let (count, median, longest, drawing, ran) =
            (steps.len(), ms(median), ms(longest), ms(drawing), ms(ran));
        println!("{name:<28}{count:>8}{median:>12.1}{longest:>12.1}{drawing:>14.1}{ran:>12.1}");
    }
}

/// How long this thread has run. Zero where nobody tells.
fn ran() -> Duration {
    let told = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let nanoseconds = told.split_whitespace().next().and_then(|first| first.parse().ok());
    Duration::from_nanos(nanoseconds.unwrap_or(0))
}

/// With Alt and the left button.
fn orbit(window: &mut Window, at: Pos2) -> Steps {
    let mut steps = Steps::new("orbit");
    let button = |pressed| Event::PointerButton {
        pos: at,
        button: PointerButton::Primary,
        pressed,
        modifiers: Modifiers::ALT,
    };
    // Held all the while: events with modifiers of their own would let go of it between them.
    window.harness.event(Event::ModifiersChanged(Modifiers::ALT));
    window.harness.event(button(true));
    steps.step(window);
    for n in 1..=20 {
        window.harness.event(Event::PointerMoved(at + egui::vec2(n as f32 * 6.0, 0.0)));
        steps.step(window);
    }
    window.harness.event(button(false));
    window.harness.event(Event::ModifiersChanged(Modifiers::NONE));
    steps.step(window);
    steps
}

/// Clicks on a lattice over the picture, each answered by a pass of its own in a later picture; then everything, then nothing.
fn select(window: &mut Window) -> Steps {
    let mut steps = Steps::new("click, which the GPU answers");
    let (rect, mut met) = (window.scene_view(), false);
    window.editor_mut().session.carry_out([Intent::Select(Vec::new())]);
    for n in 0..9 {
        let share = egui::vec2((n % 3) as f32 + 1.0, (n / 3) as f32 + 1.0) / 4.0;
        let at = rect.min + rect.size() * share;
        window.harness.hover_at(at);
        steps.step(window);
        window.harness.drag_at(at);
        steps.step(window);
        window.harness.drop_at(at);
        steps.step(window);
        while window.editor().is_seeking() {
            steps.step(window);
            std::thread::sleep(Duration::from_millis(1));
        }
        steps.step(window);
        met |= !window.editor().session.selection.is_empty();
    }
    assert!(met, "no click met anything: this is no measurement");
    steps.tell();
    let mut steps = Steps::new("select all, select none");
    for key in [Modifiers::COMMAND, Modifiers::COMMAND | Modifiers::SHIFT] {
        window.harness.key_press_modifiers(key, Key::A);
        (0..3).for_each(|_| steps.step(window));
    }
    steps
}

/// Moves one object in a drag, renames it, undoes and redoes.
fn edit(window: &mut Window) -> Steps {
    let mut steps = Steps::new("edit, undo, redo");
    let Some(id) = window.editor().session.document.scene().entities.last().map(|entity| entity.id) else {
        return steps;
    };
    let carry_out = |window: &mut Window, steps: &mut Steps, intent: Intent| {
        let since = Instant::now();
        window.editor_mut().session.carry_out([intent]);
        let took = since.elapsed();
        steps.step(window);
        if let Some(last) = steps.steps.last_mut() {
            *last += took;
        }
    };
    let start = window.entity(id).transform;
    for n in 0..10 {
        let moved = Transform { translation: start.translation + DVec3::X * 0.01 * f64::from(n), ..start };
        let edit = Edit::set(id, Field::Transform(Box::new(moved)));
        carry_out(window, &mut steps, Intent::Preview(edit));
    }
    for intent in [
        Intent::End,
        Intent::Rename { id, name: "moved".to_owned() },
        Intent::Undo,
        Intent::Undo,
        Intent::Redo,
        Intent::Select(vec![id]),
        Intent::Duplicate,
        Intent::Undo,
    ] {
        carry_out(window, &mut steps, intent);
        (0..2).for_each(|_| steps.step(window));
    }
    steps
}
