//! Proofs that there is no motion at all, for robots with few joints: cells of configurations that are wholly in collision.
//!
//! The box of configurations between the limits is cut into 2^L cells along each joint. From a cell's middle to anywhere in the
//! cell, a ball's centre moves by at most `sum_m R_m h_m` (`reach.rs`, h half the cell's sides), and a signed distance changes by
//! at most that; so where a ball is deeper in something at the middle, every configuration of the cell is in collision. What is
//! left is flooded from the start's cell over faces. A motion that avoids all collision stays within the flood: where it
//! passes through an edge of cells, all of them hold that place. If the goal's cell is not reached, there is none, and that is a
//! proof; else the cells that were reached are halved, until they are as fine as there is time for (some seconds), and nothing is known.
//!
//! This is approximate cell decomposition (D. Zhu and J.-C. Latombe, New heuristic algorithms for efficient
//! hierarchical path planning, IEEE T-RA 7(1), 1991, doi:10.1109/70.68066) for its negative answer alone; trees give the other.
//! Everything is f64, and a depth counts only beyond [`ROUNDING`].

use super::certificate::Certifier;
use super::robot::LIMIT_TOLERANCE;
use crate::space::vector::{Vector, norm, sub};

/// Joints of a robot, at most: beyond, cells are too many.
pub const MOST_JOINTS: usize = 3;
/// Levels that are flooded, for 1, 2 and 3 joints: 2^L cells along each.
const LEVELS: [[u32; 2]; MOST_JOINTS] = [[6, 14], [5, 11], [4, 7]];
/// More than what f64 loses in a place or a distance, in metres, at the sizes that models may have.
const ROUNDING: f64 = 1e-9;
/// Cells from one question whether to go on to the next.
const CELLS_A_QUESTION: usize = 256;

/// What is known of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Cell {
    /// Not reached.
    Unknown,
    /// Reached, and neither wholly free nor wholly in collision.
    Mixed,
    /// Reached, and no part of it collides: neither will any part of its parts.
    Free,
    /// Wholly in collision.
    Blocked,
}

/// Whether it is proved that no motion within the limits leads from `start` to `goal`, both `[dof]`. False where it is not, and
/// where the robot has more than [`MOST_JOINTS`]; also once `go_on` is false.
pub(super) fn are_separated(
    certifier: &Certifier,
    start: &[f64],
    goal: &[f64],
    go_on: &dyn Fn() -> bool,
) -> bool {
    let dof = start.len();
    let Some(&[first, last]) = LEVELS.get(dof - 1) else { return false };
    let mut judge = Judge::new(certifier);
    let mut before: Vec<Cell> = Vec::new();
    for level in first..=last {
        let mut cells = vec![Cell::Unknown; 1 << (level as usize * dof)];
        let [from, to] = [start, goal].map(|end| judge.place(level, end));
        let parents = (level > first).then_some(&before[..]);
        if !judge.flood(level, from, parents, &mut cells, go_on) {
            return false;
        }
        if !matches!(cells[number(level, to, dof)], Cell::Mixed | Cell::Free) {
            return true;
        }
        before = cells;
    }
    false
}

/// A cell's place along each joint; of joints that the robot lacks 0.
type Place = [usize; MOST_JOINTS];

/// The number of a cell among those of its level.
fn number(level: u32, place: Place, dof: usize) -> usize {
    place[..dof].iter().fold(0, |number, &along| (number << level) | along)
}

/// Judges cells.
struct Judge<'a> {
    certifier: &'a Certifier,
    /// Least value and range of each joint.
    limits: Vec<[f64; 2]>,
    /// `[ball][joint]`: how far a ball's centre moves at most for each rad or m.
    reach: Vec<Vec<f64>>,
    /// Pairs of balls that must not touch.
    pairs: Vec<[usize; 2]>,
    middle: Vec<f64>,
    near: Vec<u32>,
}

impl<'a> Judge<'a> {
    fn new(certifier: &'a Certifier) -> Self {
        let arm = certifier.arm();
        let limits = arm.joints().iter().map(|joint| {
            let least = joint.lower - LIMIT_TOLERANCE;
            [least, joint.upper + LIMIT_TOLERANCE - least]
        });
        let pairs = arm.pairs.iter().flat_map(|&[a, b]| {
            let others = arm.parts[b].balls.clone();
            arm.parts[a].balls.clone().flat_map(move |a| others.clone().map(move |b| [a, b]))
        });
        Self {
            certifier,
            limits: limits.collect(),
            reach: (0..arm.ball_count()).map(|ball| certifier.reach().of_ball(ball, arm)).collect(),
            pairs: pairs.collect(),
            middle: vec![0.0; arm.dof()],
            near: Vec::new(),
        }
    }

    /// The cell that holds a configuration.
    fn place(&self, level: u32, configuration: &[f64]) -> Place {
        let mut place = [0; MOST_JOINTS];
        for (along, (&value, [least, range])) in
            place.iter_mut().zip(configuration.iter().zip(&self.limits))
        {
            let part = ((value - least) / range).clamp(0.0, 1.0);
            *along = ((part * (1_usize << level) as f64) as usize).min((1 << level) - 1);
        }
        place
    }

    /// Floods the cells of a level from one of them, within what was reached a level before; false if broken off.
    fn flood(
        &mut self,
        level: u32,
        from: Place,
        parents: Option<&[Cell]>,
        cells: &mut [Cell],
        go_on: &dyn Fn() -> bool,
    ) -> bool {
        let dof = self.limits.len();
        let mut open = vec![from];
        let mut count = 0_usize;
        while let Some(place) = open.pop() {
            let index = number(level, place, dof);
            if cells[index] != Cell::Unknown {
                continue;
            }
            count += 1;
            if count.is_multiple_of(CELLS_A_QUESTION) && !go_on() {
                return false;
            }
            let parent =
                parents.map(|parents| parents[number(level - 1, place.map(|k| k >> 1), dof)]);
            cells[index] = match parent {
                Some(Cell::Free) => Cell::Free,
                Some(Cell::Unknown | Cell::Blocked) => Cell::Blocked,
                Some(Cell::Mixed) | None => self.judge(level, place),
            };
            if cells[index] == Cell::Blocked {
                continue;
            }
            for joint in 0..dof {
                let along = place[joint];
                let beside = [along.checked_sub(1), (along + 1 < 1 << level).then_some(along + 1)];
                for beside in beside.into_iter().flatten() {
                    let mut next = place;
                    next[joint] = beside;
                    if cells[number(level, next, dof)] == Cell::Unknown {
                        open.push(next);
                    }
                }
            }
        }
        true
    }

    /// Whether a cell is wholly free, wholly in collision, or neither as far as can be told from its middle.
    fn judge(&mut self, level: u32, place: Place) -> Cell {
        let side = 1.0 / (1_u64 << level) as f64;
        for ((middle, [least, range]), along) in self.middle.iter_mut().zip(&self.limits).zip(place)
        {
            *middle = least + range * side * (along as f64 + 0.5);
        }
        let (arm, world) = (self.certifier.arm(), self.certifier.world());
        let balls = arm.balls_at(&self.middle);
        let travel = |ball: usize| -> f64 {
            let reach = self.reach[ball].iter().zip(&self.limits);
            reach.map(|(reach, [_, range])| reach * 0.5 * side * range).sum::<f64>() + ROUNDING
        };
        let mut is_free = true;
        for (index, ball) in balls.iter().enumerate() {
            let (travel, radius) = (travel(index), ball.radius + arm.margin());
            world.near(ball.center, radius + travel, &mut self.near);
            for &piece in &self.near {
                let (distance, _) = world.distance(piece, ball.center);
                if distance + travel < radius {
                    return Cell::Blocked;
                }
                is_free &= distance - travel > radius;
            }
        }
        for &[a, b] in &self.pairs {
            let apart: Vector = sub(balls[a].center, balls[b].center);
            let (distance, travel) = (norm(apart), travel(a) + travel(b));
            let radii = balls[a].radius + balls[b].radius;
            if distance + travel < radii {
                return Cell::Blocked;
            }
            is_free &= distance - travel > radii;
        }
        if is_free { Cell::Free } else { Cell::Mixed }
    }
}
