//! Where panels are: docked, tabbed and split as the user likes.

use eframe::egui;
use egui::{Color32, Popup, Response, Role, Stroke, Style, Ui, Visuals, WidgetInfo, WidgetText};
use egui_tiles::{
    Container, Linear, LinearDir, SimplificationOptions, TabState, Tile, TileId, Tiles, Tree, UiResponse,
};
use serde::{Deserialize, Serialize};

use crate::theme;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Pane {
    Hierarchy,
    Scene,
    Game,
    Inspector,
    Assets,
    Console,
    Statistics,
}

impl Pane {
    pub const ALL: [Self; 7] = [
        Self::Hierarchy,
        Self::Scene,
        Self::Game,
        Self::Inspector,
        Self::Assets,
        Self::Console,
        Self::Statistics,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Self::Hierarchy => "Hierarchy",
            Self::Scene => "Scene",
            Self::Game => "Game",
            Self::Inspector => "Inspector",
            Self::Assets => "Assets",
            Self::Console => "Console",
            Self::Statistics => "Statistics",
        }
    }
}

pub type Layout = Tree<Pane>;

/// They share the room under the pictures.
const BELOW: [Pane; 3] = [Pane::Assets, Pane::Console, Pane::Statistics];

/// Hierarchy left, inspector right, the pictures between them above console and statistics. In a window of this width in
/// points: rows of names and numbers need no more than theirs, and a wide window is the picture's.
pub fn default_layout(width: f32) -> Layout {
    let [left_share, right_share] =
        [(0.17, 300.0), (0.255, 400.0)].map(|(share, most)| f32::min(share, most / width.max(1.0)));
    let mut tiles = Tiles::default();
    let mut tabs = |panes: &[Pane]| {
        let panes = panes.iter().map(|pane| tiles.insert_pane(*pane)).collect();
        tiles.insert_tab_tile(panes)
    };
    let left = tabs(&[Pane::Hierarchy]);
    let pictures = tabs(&[Pane::Scene, Pane::Game]);
    let below = tabs(&BELOW);
    let right = tabs(&[Pane::Inspector]);
    let middle = split(&mut tiles, LinearDir::Vertical, &[(pictures, 0.77), (below, 0.23)]);
    let root = split(
        &mut tiles,
        LinearDir::Horizontal,
        &[(left, left_share), (middle, 1.0 - left_share - right_share), (right, right_share)],
    );
    Tree::new(egui::Id::unique("layout"), root, tiles)
}

fn split(tiles: &mut Tiles<Pane>, dir: LinearDir, children: &[(TileId, f32)]) -> TileId {
    let mut linear = Linear::new(dir, children.iter().map(|(id, _)| *id).collect());
    children.iter().for_each(|(id, share)| linear.shares.set_share(*id, *share));
    tiles.insert_container(Container::Linear(linear))
}

/// After the window became `is` points wide that was `was`: what stands beside the pictures is as wide as before, and they
/// take what is new. Where that would leave too little of them, all shrink alike.
pub fn keep_sides(layout: &mut Layout, was: f32, is: f32) {
    const LEAST: f32 = 0.4;
    let tiles = &layout.tiles;
    let mut middle = tiles.find_pane(&Pane::Scene);
    while middle.is_some() && middle.and_then(|tile| tiles.parent_of(tile)) != layout.root {
        middle = middle.and_then(|tile| tiles.parent_of(tile));
    }
    let (Some(middle), Some(root)) = (middle, layout.root) else { return };
    let Some(Tile::Container(Container::Linear(linear))) = layout.tiles.get_mut(root) else { return };
    if linear.dir != LinearDir::Horizontal {
        return;
    }
    let all: f32 = linear.children.iter().map(|child| linear.shares[*child]).sum();
    let sides: Vec<TileId> = linear.children.iter().copied().filter(|child| *child != middle).collect();
    let kept = |side: &TileId| linear.shares[*side] * was / is;
    let shares: Vec<f32> = sides.iter().map(kept).collect();
    let rest = all - shares.iter().sum::<f32>();
    if rest >= LEAST * all {
        sides.iter().zip(shares).for_each(|(side, share)| linear.shares.set_share(*side, share));
        linear.shares.set_share(middle, rest);
    }
}

/// A tab beside the panel that it stands beside at first, or beside the scene.
fn add(layout: &mut Layout, pane: Pane) {
    if is_open(layout, pane) {
        return;
    }
    let neighbours = if BELOW.contains(&pane) { &BELOW[..] } else { &[Pane::Scene] };
    let tabs = |near: &Pane| layout.tiles.find_pane(near).and_then(|near| layout.tiles.parent_of(near));
    let beside = neighbours.iter().chain([&Pane::Scene]).find_map(tabs).or(layout.root);
    let new = layout.tiles.insert_pane(pane);
    match beside {
        Some(container) => layout.move_tile_to_container(new, container, usize::MAX, false),
        None => *layout = Tree::new(egui::Id::unique("layout"), new, std::mem::take(&mut layout.tiles)),
    }
}

/// Shows a panel, wherever it is; one that was closed comes back.
pub fn reveal(layout: &mut Layout, pane: Pane) {
    add(layout, pane);
    layout.make_active(|_, tile| matches!(tile, Tile::Pane(other) if *other == pane));
}

pub fn is_open(layout: &Layout, pane: Pane) -> bool {
    layout.tiles.find_pane(&pane).is_some()
}

/// Open, and not behind another tab.
pub fn is_in_front(layout: &Layout, pane: Pane) -> bool {
    layout.tiles.find_pane(&pane).is_some_and(|tile| layout.active_tiles().contains(&tile))
}

/// The pictures of the scene stay: everything else is about them.
pub fn can_close(pane: Pane) -> bool {
    pane != Pane::Scene
}

pub fn close(layout: &mut Layout, pane: Pane) {
    if let Some(tile) = layout.tiles.find_pane(&pane) {
        layout.remove_recursively(tile);
    }
}

/// A layout, and which panels there were when it was made.
#[derive(Serialize, Deserialize)]
struct Kept<L> {
    panels: Vec<Pane>,
    tree: L,
}

/// As preferences hold it. `None`: it cannot be written.
pub fn written(layout: &Layout) -> Option<String> {
    ron::to_string(&Kept { panels: Pane::ALL.to_vec(), tree: layout }).ok()
}

/// With panels that came after it was made; one that was closed stays closed. `None`: it is no layout of this editor, or
/// it lacks the scene view.
pub fn read(text: &str) -> Option<Layout> {
    let Kept { panels, tree: mut layout }: Kept<Layout> = ron::from_str(text).ok()?;
    if !is_open(&layout, Pane::Scene) {
        return None;
    }
    for pane in Pane::ALL.into_iter().filter(|pane| !panels.contains(pane)) {
        add(&mut layout, pane);
    }
    Some(layout)
}

/// Draws panels into their places.
pub struct Docks<'a> {
    pub show: &'a mut dyn FnMut(&mut Ui, Pane),
    /// The panel that is to be closed.
    pub closed: Option<Pane>,
}

impl egui_tiles::Behavior<Pane> for Docks<'_> {
    fn pane_ui(&mut self, ui: &mut Ui, _: TileId, pane: &mut Pane) -> UiResponse {
        (self.show)(ui, *pane);
        UiResponse::None
    }

    fn tab_title_for_pane(&mut self, pane: &Pane) -> WidgetText {
        pane.name().into()
    }

    fn simplification_options(&self) -> SimplificationOptions {
        SimplificationOptions { all_panes_must_have_tabs: true, ..Default::default() }
    }

    /// Named for screen readers; a right click closes it.
    fn on_tab_button(&mut self, tiles: &mut Tiles<Pane>, tile: TileId, button: Response) -> Response {
        let Some(Tile::Pane(pane)) = tiles.get(tile) else { return button };
        let pane = *pane;
        button.widget_info(|| WidgetInfo::labeled(Role::Tab, true, format!("{} panel", pane.name())));
        let is_closed = can_close(pane)
            && Popup::context_menu(&button)
                .show(|ui| ui.button(format!("Close {}", pane.name().to_lowercase())).clicked())
                .is_some_and(|shown| shown.inner);
        if is_closed {
            self.closed = Some(pane);
        }
        button
    }

    fn is_tab_closable(&self, _: &Tiles<Pane>, _: TileId) -> bool {
        false
    }

    fn tab_bar_height(&self, _: &Style) -> f32 {
        25.0
    }

    fn gap_width(&self, _: &Style) -> f32 {
        3.0
    }

    fn min_size(&self) -> f32 {
        120.0
    }

    fn tab_title_spacing(&self, _: &Visuals) -> f32 {
        12.0
    }

    fn tab_bar_color(&self, visuals: &Visuals) -> Color32 {
        theme::bars(visuals)
    }

    fn tab_outline_stroke(&self, _: &Visuals, _: &Tiles<Pane>, _: TileId, _: &TabState) -> Stroke {
        Stroke::NONE
    }

    fn tab_bar_hline_stroke(&self, visuals: &Visuals) -> Stroke {
        Stroke::new(1.0, visuals.panel_fill)
    }

    fn tab_text_color(&self, visuals: &Visuals, _: &Tiles<Pane>, _: TileId, state: &TabState) -> Color32 {
        if state.active { visuals.strong_text_color() } else { theme::weak(visuals) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_panel_is_in_the_first_layout_and_comes_back_when_it_was_closed() {
        let mut layout = default_layout(1280.0);
        for pane in Pane::ALL {
            assert!(is_open(&layout, pane), "{pane:?}");
            close(&mut layout, pane);
            assert!(!is_open(&layout, pane));
        }
        for pane in Pane::ALL {
            reveal(&mut layout, pane);
            assert!(is_open(&layout, pane), "{pane:?}");
        }
    }

    #[test]
    fn the_pictures_take_what_a_window_grows_by() {
        let mut layout = default_layout(1280.0);
        let shares = |layout: &Layout| match layout.root.and_then(|root| layout.tiles.get(root)) {
            Some(Tile::Container(Container::Linear(linear))) => {
                linear.children.iter().map(|child| linear.shares[*child]).collect::<Vec<f32>>()
            }
            _ => Vec::new(),
        };
        let before = shares(&layout);
        keep_sides(&mut layout, 1280.0, 2560.0);
        let wide = shares(&layout);
        assert!((wide[0] * 2560.0 - before[0] * 1280.0).abs() < 1e-2, "{before:?} {wide:?}");
        assert!((wide.iter().sum::<f32>() - 1.0).abs() < 1e-5 && wide[1] > 0.75, "{wide:?}");
        keep_sides(&mut layout, 2560.0, 600.0);
        assert_eq!(shares(&layout), wide, "there is no room for that");
    }

    #[test]
    fn a_layout_is_read_as_it_was_written() {
        let layout = default_layout(1280.0);
        let text = written(&layout).unwrap();
        assert!(read(&text) == Some(layout), "{text}");
        assert!(read("nonsense").is_none());
    }

    #[test]
    fn a_panel_of_a_later_version_comes_and_one_that_was_closed_stays_closed() {
        let mut layout = default_layout(1280.0);
        close(&mut layout, Pane::Console);
        close(&mut layout, Pane::Game);
        let text = written(&layout).unwrap();
        let older = text.replace(",console", "");
        assert_ne!(older, text, "{text}");
        let read = read(&older).unwrap();
        assert!(is_open(&read, Pane::Console) && !is_open(&read, Pane::Game));
        let beside = |pane| read.tiles.find_pane(&pane).and_then(|tile| read.tiles.parent_of(tile));
        assert_eq!(beside(Pane::Console), beside(Pane::Assets));
    }
}
