//! Worlds that look like pictures of workspaces: occupancy grids of rooms, blobs and noisy scans, with a disc as the robot.
//! Not the paper's, and nothing is trained on them: they show how far a policy carries.

use std::sync::Arc;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::plane::Robot;
use crate::plane::certificate::Certifier;
use crate::plane::geometry::{Point, Rect, distance};
use crate::plane::world::{Grid, World};
use crate::rng::{Purpose, stream};
use crate::scene::{Setting, Task};

use super::FIELD;

/// What a picture shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Kind {
    /// Rooms within rooms, joined by doors.
    Rooms,
    /// Smooth noise, of which the highest quarter to third is solid.
    Blobs,
    /// A hall with furniture at all angles as a scanner maps it: frayed edges and specks.
    Scans,
}

/// Cells per side.
const SIDE: usize = 128;
const CELL: f64 = FIELD / SIDE as f64;
/// Start and goal are at least so far apart.
const APART: f64 = 0.4 * FIELD;

type Cells = Vec<bool>;

/// Task `index` of `seed`.
pub fn pictured(kind: Kind, seed: u64, index: u64) -> Task {
    let (sub, name, draw): (u64, _, fn(&mut ChaCha8Rng) -> Cells) = match kind {
        Kind::Rooms => (2, "rooms", rooms),
        Kind::Blobs => (3, "blobs", blobs),
        Kind::Scans => (4, "scans", scans),
    };
    let mut rng = stream(seed, Purpose::Task, index, sub);
    let robot = Robot::Disc { radius: rng.random_range(0.4..1.2) };
    loop {
        let grid = Grid::new(SIDE, SIDE, CELL, [0.0; 2], draw(&mut rng));
        let bounds = Rect { min: [0.0; 2], max: [FIELD; 2] };
        let world = World::new(bounds, vec![], grid.ok());
        let certifier = Certifier::new(&world, robot);
        for _ in 0..40 {
            let mut point = || [(); 2].map(|()| rng.random_range(1.0..FIELD - 1.0));
            let (start, goal): (Point, Point) = (point(), point());
            let free = [start, goal].iter().all(|&p| certifier.point_is_free(p));
            if free && distance(start, goal) >= APART {
                let name = format!("{name}, seed {seed}, task {index}");
                let setting = Setting::Plane { world: Arc::new(world), robot };
                return Task { name, setting, start: start.into(), goal: goal.into() };
            }
        }
    }
}

/// Walls of two cells cut the field in two, and the halves again, each wall with a door.
fn rooms(rng: &mut ChaCha8Rng) -> Cells {
    const WALL: usize = 2;
    const LEAST: usize = 28;
    let mut cells = vec![false; SIDE * SIDE];
    let mut open = vec![[0, 0, SIDE, SIDE]];
    while let Some([left, bottom, right, top]) = open.pop() {
        let (width, height) = (right - left, top - bottom);
        let upright = if width == height { rng.random_bool(0.5) } else { width > height };
        let (along, across) = if upright { (height, width) } else { (width, height) };
        if across < 2 * LEAST || across < SIDE / 2 && rng.random_bool(0.2) {
            continue;
        }
        let wall = rng.random_range(LEAST..=across - LEAST);
        let door = rng.random_range(7..14).min(along);
        let door_at = rng.random_range(0..=along - door);
        for i in (0..along).filter(|i| !(door_at..door_at + door).contains(i)) {
            for j in wall - 1..wall - 1 + WALL {
                let (column, row) =
                    if upright { (left + j, bottom + i) } else { (left + i, bottom + j) };
                cells[row * SIDE + column] = true;
            }
        }
        let halves = if upright {
            [[left, bottom, left + wall, top], [left + wall, bottom, right, top]]
        } else {
            [[left, bottom, right, bottom + wall], [left, bottom + wall, right, top]]
        };
        open.extend(halves);
    }
    cells
}

/// Smoothed noise above a level.
fn blobs(rng: &mut ChaCha8Rng) -> Cells {
    let mut height = vec![0.0f32; SIDE * SIDE];
    for (spacing, weight) in [(16, 1.0), (8, 0.4)] {
        let knots = SIDE / spacing + 1;
        let values: Vec<f32> = (0..knots * knots).map(|_| rng.random_range(-1.0..1.0)).collect();
        let smooth = |i: usize| {
            let t = (i % spacing) as f32 / spacing as f32;
            (i / spacing, t * t * (3.0 - 2.0 * t))
        };
        for (i, height) in height.iter_mut().enumerate() {
            let ((column, u), (row, v)) = (smooth(i % SIDE), smooth(i / SIDE));
            let value = |r: usize, c: usize| values[r * knots + c];
            let low = value(row, column) * (1.0 - u) + value(row, column + 1) * u;
            let high = value(row + 1, column) * (1.0 - u) + value(row + 1, column + 1) * u;
            *height += weight * (low * (1.0 - v) + high * v);
        }
    }
    let mut sorted = height.clone();
    sorted.sort_by(f32::total_cmp);
    let level = sorted[(SIDE * SIDE) * rng.random_range(68..78) / 100];
    height.iter().map(|&height| height > level).collect()
}

/// Boxes at all angles whose edges are frayed by a cell, and specks.
fn scans(rng: &mut ChaCha8Rng) -> Cells {
    let boxes: Vec<[f32; 6]> = (0..rng.random_range(8..18))
        .map(|_| {
            let angle = rng.random_range(0.0..std::f32::consts::PI);
            let mut place = || rng.random_range(0.0..SIDE as f32);
            let (x, y) = (place(), place());
            let (a, b) = (rng.random_range(4.0..14.0), rng.random_range(4.0..14.0));
            [x, y, angle.cos(), angle.sin(), a, b]
        })
        .collect();
    let depth = |column: usize, row: usize| {
        let inside = |&[x, y, cos, sin, a, b]: &[f32; 6]| {
            let (dx, dy) = (column as f32 + 0.5 - x, row as f32 + 0.5 - y);
            (a - (cos * dx + sin * dy).abs()).min(b - (cos * dy - sin * dx).abs())
        };
        boxes.iter().map(inside).fold(f32::NEG_INFINITY, f32::max)
    };
    (0..SIDE * SIDE)
        .map(|i| {
            let frayed = depth(i % SIDE, i / SIDE) > rng.random_range(-1.0..1.0);
            frayed || rng.random_bool(0.001)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Suite;
    use crate::profile::Profile;

    #[test]
    fn each_kind_has_free_ends_and_something_in_between() {
        for suite in [Suite::Rooms, Suite::Blobs, Suite::Scans] {
            let tasks = suite.generate(30, 5, &Profile::PAPER);
            assert_eq!(tasks[7..9], suite.generate(9, 5, &Profile::PAPER)[7..]);
            let mut blocked = 0;
            for task in &tasks {
                let plane = task.plane().unwrap();
                let cells = plane.world.grid().unwrap().cells();
                let solid = cells.iter().filter(|&&solid| solid).count();
                assert!((SIDE * SIDE / 100..SIDE * SIDE / 2).contains(&solid), "{suite}: {solid}");
                let certifier = Certifier::new(plane.world, plane.robot);
                assert!(
                    certifier.point_is_free(plane.start) && certifier.point_is_free(plane.goal)
                );
                blocked += usize::from(!certifier.segment_is_free(plane.start, plane.goal));
            }
            assert!(blocked >= 10, "{suite}: {blocked} of 30 blocked");
        }
    }
}
