//! Point after point: locate, take out, fill.

use std::collections::HashMap;

use glam::DVec3;

use super::{Cell, GHOST, Tetrahedra, inside_sphere, volume};

const NEW: u32 = u32::MAX;

/// Of distinct points with whole coordinates below 2^22, in an order in which near ones follow one another; `start`:
/// four that lie in no plane.
pub fn tetrahedralise(points: &[DVec3], start: [u32; 4]) -> Tetrahedra {
    let mut growing = Growing::new(points, start);
    for point in (0..points.len() as u32).filter(|point| !start.contains(point)) {
        growing.insert(point);
    }
    growing.finish()
}

struct Growing<'a> {
    points: &'a [DVec3],
    cells: Vec<Cell>,
    /// Places of cells that were taken out.
    free: Vec<u32>,
    /// By cell: the point that took it out, or looks at it.
    taken: Vec<u32>,
    last: u32,
    stack: Vec<u32>,
    hole: Vec<u32>,
    /// Faces of the hole: a cell that was taken out, and the corner opposite to the face.
    faces: Vec<(u32, usize)>,
    /// By the edge that a new face has besides the new point: the cell and the corner that wait for a neighbour.
    open: HashMap<[u32; 2], (u32, usize)>,
}

impl<'a> Growing<'a> {
    fn new(points: &'a [DVec3], start: [u32; 4]) -> Self {
        let mut corners = start;
        if volume(corners.map(|corner| points[corner as usize])) < 0.0 {
            corners.swap(0, 1);
        }
        let mut cells = vec![Cell { corners, neighbours: [1, 2, 3, 4] }];
        for slot in 0..4 {
            let mut ghost = Cell { corners, neighbours: [1, 2, 3, 4] };
            ghost.corners[slot] = GHOST;
            ghost.neighbours[slot] = 0;
            // Seen from outside.
            let (i, j) = ((slot + 1) % 4, (slot + 2) % 4);
            ghost.corners.swap(i, j);
            ghost.neighbours.swap(i, j);
            cells.push(ghost);
        }
        Self {
            points,
            taken: vec![NEW; cells.len()],
            cells,
            free: Vec::new(),
            last: 0,
            stack: Vec::new(),
            hole: Vec::new(),
            faces: Vec::new(),
            open: HashMap::new(),
        }
    }

    fn insert(&mut self, point: u32) {
        self.take_out(point);
        // Each face of the hole becomes a cell with the new point.
        let faces = std::mem::take(&mut self.faces);
        for &(old, slot) in &faces {
            let mut cell = self.cells[old as usize];
            cell.corners[slot] = point;
            let new = self.place(cell);
            let outside = cell.neighbours[slot];
            for there in &mut self.cells[outside as usize].neighbours {
                if *there == old {
                    *there = new;
                }
            }
            self.join(new, slot);
            self.last = new;
        }
        debug_assert!(self.open.is_empty());
        self.faces = faces;
        self.free.append(&mut self.hole);
    }

    /// Finds the hole: all cells whose sphere holds the point, from one of them outwards.
    fn take_out(&mut self, point: u32) {
        let at = self.points[point as usize];
        let start = self.locate(at);
        self.faces.clear();
        self.stack.push(start);
        self.taken[start as usize] = point;
        while let Some(index) = self.stack.pop() {
            self.hole.push(index);
            for slot in 0..4 {
                let there = self.cells[index as usize].neighbours[slot];
                if self.taken[there as usize] == point {
                    continue;
                }
                if self.holds(&self.cells[there as usize], at) {
                    self.taken[there as usize] = point;
                    self.stack.push(there);
                } else {
                    self.faces.push((index, slot));
                }
            }
        }
    }

    fn place(&mut self, cell: Cell) -> u32 {
        match self.free.pop() {
            Some(place) => {
                self.cells[place as usize] = cell;
                self.taken[place as usize] = NEW;
                place
            }
            None => {
                self.cells.push(cell);
                self.taken.push(NEW);
                self.cells.len() as u32 - 1
            }
        }
    }

    /// Finds the neighbours of a new cell among the new ones.
    fn join(&mut self, new: u32, point_slot: usize) {
        for slot in (0..4).filter(|&slot| slot != point_slot) {
            let corners = self.cells[new as usize].corners;
            let mut edge = [0, 1, 2, 3].into_iter().filter(|&k| k != slot && k != point_slot);
            let (a, b) = (edge.next().unwrap_or(0), edge.next().unwrap_or(0));
            let key = [corners[a].min(corners[b]), corners[a].max(corners[b])];
            match self.open.remove(&key) {
                Some((other, other_slot)) => {
                    self.cells[new as usize].neighbours[slot] = other;
                    self.cells[other as usize].neighbours[other_slot] = new;
                }
                None => {
                    self.open.insert(key, (new, slot));
                }
            }
        }
    }

    fn corners(&self, cell: &Cell) -> [DVec3; 4] {
        cell.corners.map(|corner| self.points[corner as usize])
    }

    /// The cell, its corner at infinity brought to a point.
    fn with(&self, cell: &Cell, slot: usize, at: DVec3) -> [DVec3; 4] {
        let at_slot = |k: usize| if k == slot { at } else { self.points[cell.corners[k] as usize] };
        [0, 1, 2, 3].map(at_slot)
    }

    /// Is the point strictly inside the cell's sphere? A ghost's holds all beyond its face, and in the plane of the
    /// face what the sphere behind it holds.
    fn holds(&self, cell: &Cell, at: DVec3) -> bool {
        let Some(slot) = cell.ghost() else { return inside_sphere(self.corners(cell), at) > 0.0 };
        match volume(self.with(cell, slot, at)) {
            0.0 => {
                let behind = &self.cells[cell.neighbours[slot] as usize];
                inside_sphere(self.corners(behind), at) > 0.0
            }
            beyond => beyond > 0.0,
        }
    }

    /// The solid cell that holds the point, or a ghost that it is beyond.
    fn locate(&self, at: DVec3) -> u32 {
        let mut index = self.last;
        if let Some(slot) = self.cells[index as usize].ghost() {
            index = self.cells[index as usize].neighbours[slot];
        }
        'walk: loop {
            let cell = &self.cells[index as usize];
            if cell.ghost().is_some() {
                return index;
            }
            for slot in 0..4 {
                if volume(self.with(cell, slot, at)) < 0.0 {
                    index = cell.neighbours[slot];
                    continue 'walk;
                }
            }
            return index;
        }
    }

    /// Solid cells first; a ghost's corner at infinity last.
    fn finish(self) -> Tetrahedra {
        let mut is_free = vec![false; self.cells.len()];
        self.free.iter().for_each(|&place| is_free[place as usize] = true);
        let living = |ghosts: bool| {
            let cells = self.cells.iter().enumerate();
            cells.filter(move |&(_, cell)| cell.ghost().is_some() == ghosts).map(|(index, _)| index)
        };
        let order: Vec<usize> = living(false).chain(living(true)).filter(|&index| !is_free[index]).collect();
        let mut new_from_old = vec![0; self.cells.len()];
        order.iter().enumerate().for_each(|(new, &old)| new_from_old[old] = new as u32);
        let cells: Vec<Cell> = order
            .iter()
            .map(|&old| {
                let Cell { corners, neighbours } = self.cells[old];
                turned(Cell { corners, neighbours: neighbours.map(|old| new_from_old[old as usize]) })
            })
            .collect();
        let solid = cells.iter().filter(|cell| cell.ghost().is_none()).count();
        Tetrahedra { points: self.points.to_vec(), cells, solid }
    }
}

/// The same cell with its corner at infinity last.
fn turned(mut cell: Cell) -> Cell {
    if let Some(slot) = cell.ghost().filter(|&slot| slot != 3) {
        let (i, j) = ((slot + 1) % 3, (slot + 2) % 3);
        for items in [&mut cell.corners, &mut cell.neighbours] {
            items.swap(slot, 3);
            items.swap(i, j);
        }
    }
    cell
}
