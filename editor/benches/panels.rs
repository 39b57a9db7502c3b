//! What a picture of the editor costs besides the 3D view: all panels laid out and painted into triangles, in a scene of
//! 5,000 entities, while a person rests, points, scrolls, selects, searches, types and pulls at a number.
//!
//! `cargo bench -p editor --bench panels`, `-- COUNT` for other than 5000 entities. Scene and game view are closed: what
//! they cost is the renderer's. Needs a GPU all the same, as the editor does.

use std::path::Path;
use std::time::{Duration, Instant};

use editor::app::{Editor, wgpu_setup_headless};
use editor::document::Document;
use editor::intents::Intent;
use editor::layout::{self, Pane};
use editor::opened::Opened;
use editor::primitives;
use eframe::egui;
use eframe::egui_wgpu::{RenderState, RendererOptions, WgpuConfiguration};
use egui::{Event, Key, Modifiers, Pos2, Rect, Vec2, pos2, vec2};
use engine::scene::{Entity, EntityId, Light, Scene, Transform};
use glam::DVec3;

const SIZE: Vec2 = vec2(1920.0, 1080.0);
const PICTURES: usize = 120;

fn main() {
    let many = std::env::args().skip(1).find_map(|argument| argument.parse().ok()).unwrap_or(5000);
    let folder = tempfile::tempdir().expect("a folder for the project");
    let project = folder.path().join("many");
    drop(Document::new_project(&project, "main", crowd(many)).expect("a project can be written"));
    let Some(mut desk) = Desk::open(&project) else { return println!("not run: no GPU adapter") };
    println!("{many} entities, {} x {} points", SIZE.x, SIZE.y);
    println!("{:<28} {:>9} {:>9} {:>9}", "", "median ms", "p99 ms", "most ms");
    desk.rest(20);
    for (what, step) in STEPS {
        desk.measure(what, step);
    }
    println!("each undo took back what was pulled, each redo brought it again");
    let Some(held) = desk.undo_bytes() else { return };
    println!("undo holds {held} bytes after all of that");
}

/// Groups of ten, most of them shapes; one in a hundred is a lamp, without shadows, so that pictures settle soon.
fn crowd(many: u64) -> Scene {
    let mut scene = primitives::first_scene();
    let shape = scene.entities[1].clone();
    for n in 0..many.saturating_sub(4) {
        let id = EntityId(100 + n);
        let place = DVec3::new((n % 70) as f64, 0.5, (n / 70) as f64);
        let base = Entity { id, name: format!("stone {n}"), ..Entity::default() };
        scene.entities.push(match n % 10 {
            0 => Entity { transform: Transform::at(place), ..base },
            1 if n % 100 == 1 => {
                let lamp = Light { casts_shadows: false, ..Light::default() };
                Entity { light: Some(lamp), transform: Transform::at(place), ..base }
            }
            _ => Entity {
                transform: Transform::at(DVec3::X * 0.1),
                parent: Some(EntityId(100 + n - n % 10)),
                mesh: shape.mesh.clone(),
                ..base
            },
        });
    }
    scene
}

/// What happens before the n-th picture.
type Step = fn(&mut Desk, usize) -> Vec<Event>;

const STEPS: [(&str, Step); 8] = [
    ("at rest", |_, _| Vec::new()),
    ("pointing at the tree", |_, n| vec![Event::PointerMoved(pos2(120.0, 150.0 + 5.0 * n as f32))]),
    ("scrolling the tree", |_, n| wheel(if n < PICTURES / 2 { -400.0 } else { 400.0 })),
    ("selecting one by one", |desk, n| desk.select(n)),
    ("all selected", |desk, n| desk.select_all(n)),
    ("searching the tree", |desk, n| desk.search(n)),
    ("pulling at a number", |desk, n| desk.pull(n)),
    ("undoing and redoing", |desk, n| desk.travel(n)),
];

fn wheel(points: f32) -> Vec<Event> {
    let (unit, phase, source) =
        (egui::MouseWheelUnit::Point, egui::TouchPhase::Move, egui::MouseWheelSource::Wheel);
    vec![
        Event::PointerMoved(pos2(120.0, 300.0)),
        Event::MouseWheel { unit, delta: vec2(0.0, points), modifiers: Modifiers::NONE, phase, source },
    ]
}

fn keys(key: Key) -> Vec<Event> {
    let event = |pressed| Event::Key {
        key,
        physical_key: None,
        pressed,
        repeat: false,
        modifiers: Modifiers::COMMAND,
    };
    vec![event(true), event(false)]
}

/// An editor without a window.
struct Desk {
    ctx: egui::Context,
    editor: Editor,
    time: f64,
}

impl Desk {
    fn open(project: &Path) -> Option<Self> {
        let wgpu_setup = wgpu_setup_headless();
        let instance = pollster::block_on(wgpu_setup.new_instance());
        let config = WgpuConfiguration { wgpu_setup, ..Default::default() };
        let state = RenderState::create(&config, &instance, None, RendererOptions::PREDICTABLE);
        let state = pollster::block_on(state).ok()?;
        let ctx = egui::Context::default();
        let opened = Opened::load(project, None).expect("it was just written");
        let editor = Editor::new(&ctx, &state, opened, None).expect("the GPU draws");
        let mut desk = Self { ctx, editor, time: 0.0 };
        // Panels are laid out when the window's width is known; the views are closed after that.
        desk.rest(1);
        [Pane::Scene, Pane::Game].into_iter().for_each(|pane| layout::close(&mut desk.editor.layout, pane));
        // A driver that draws on the processor is still at those first pictures, and what is measured would share it.
        desk.editor.stage().gpu().wait().expect("the GPU draws");
        Some(desk)
    }

    fn picture(&mut self, events: Vec<Event>) -> Duration {
        self.time += 1.0 / 60.0;
        let input = egui::RawInput {
            screen_rect: Some(Rect::from_min_size(Pos2::ZERO, SIZE)),
            time: Some(self.time),
            events,
            ..Default::default()
        };
        let since = Instant::now();
        let mut output = self.ctx.run_ui(input, |ui| self.editor.ui(ui));
        let triangles = self.ctx.tessellate(std::mem::take(&mut output.shapes), output.pixels_per_point);
        let took = since.elapsed();
        std::hint::black_box(&triangles);
        output.textures_delta.clear(); // nobody shows them
        took
    }

    fn rest(&mut self, pictures: usize) {
        for _ in 0..pictures {
            self.picture(Vec::new());
        }
    }

    fn measure(&mut self, what: &str, step: Step) {
        let mut took: Vec<Duration> = Vec::new();
        for n in 0..PICTURES {
            let events = step(self, n);
            took.push(self.picture(events));
        }
        took.sort();
        let ms = |share: f64| took[((PICTURES - 1) as f64 * share) as usize].as_secs_f64() * 1e3;
        println!("{what:<28} {:>9.2} {:>9.2} {:>9.2}", ms(0.5), ms(0.99), ms(1.0));
        self.editor.session.carry_out([Intent::End, Intent::Select(Vec::new())]);
        self.leave_field();
        self.rest(4);
    }

    /// What was typed goes, and keys are the editor's again.
    fn leave_field(&mut self) {
        let Some(field) = self.ctx.memory(|memory| memory.focused()) else { return };
        self.picture(keys(Key::A));
        self.picture(vec![Event::Cut]);
        self.ctx.memory_mut(|memory| memory.surrender_focus(field));
    }

    /// What was pulled at last goes back and comes again; the key before has done its work, or this is no measurement.
    fn travel(&mut self, n: usize) -> Vec<Event> {
        let x =
            self.editor.session.document.entity(EntityId(103)).map(|entity| entity.transform.translation.x);
        let pulled = 0.01 * (PICTURES - 1) as f64;
        assert_eq!(x, Some(if n.is_multiple_of(2) { pulled } else { 0.1 }), "undone and redone {n} times");
        keys(if n.is_multiple_of(2) { Key::Z } else { Key::Y })
    }

    fn select(&mut self, n: usize) -> Vec<Event> {
        self.editor.session.carry_out([Intent::Select(vec![EntityId(100 + 10 * n as u64 + 3)])]);
        Vec::new()
    }

    fn select_all(&mut self, n: usize) -> Vec<Event> {
        if n == 0 {
            self.editor.session.carry_out([Intent::SelectAll]);
        }
        Vec::new()
    }

    fn search(&mut self, n: usize) -> Vec<Event> {
        match n {
            0 => keys(Key::F),
            _ if n % 10 == 9 => keys(Key::A),
            _ => vec![Event::Text(["s", "t", "o", "n", "e", " "][n % 10 % 6].to_owned())],
        }
    }

    /// As the inspector does while a number is pulled: a preview a picture.
    fn pull(&mut self, n: usize) -> Vec<Event> {
        let id = EntityId(103);
        let place = Transform::at(DVec3::X * 0.01 * n as f64);
        let edit = editor::edit::Edit::set(id, editor::edit::Field::Transform(Box::new(place)));
        self.editor.session.carry_out([Intent::Select(vec![id]), Intent::Preview(edit)]);
        Vec::new()
    }

    fn undo_bytes(&self) -> Option<usize> {
        let history = self.editor.session.document.history();
        history.validate().ok().map(|()| history.bytes())
    }
}
