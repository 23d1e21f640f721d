//! Start trajectories: where the optimizer begins.
//!
//! Start 0 of every strategy is the straight line; the others are random, each from its own stream.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::error::InvalidInput;
use crate::objective::Objective;
use crate::trajectory::waypoints::polyline;

/// How random start trajectories are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum StartStrategy {
    /// The straight line every time.
    Line,
    /// Start, one uniform random via-point, goal, evenly spaced by length.
    #[default]
    ViaPoint,
    /// Uniform random waypoints, sorted along the direction from start to goal.
    Sorted,
    /// Uniform random waypoints in the order they are drawn.
    Random,
    /// The paper's code: uniform random waypoints, each coordinate sorted ascending on its own, so
    /// that every start runs from lower left to upper right whatever the task.
    Paper,
}

impl StartStrategy {
    /// All strategies with their names.
    pub const NAMES: [(&'static str, Self); 5] = [
        ("line", Self::Line),
        ("via-point", Self::ViaPoint),
        ("sorted", Self::Sorted),
        ("random", Self::Random),
        ("paper", Self::Paper),
    ];

    /// The strategy's name.
    pub fn name(&self) -> &'static str {
        Self::NAMES.iter().find(|(_, strategy)| strategy == self).map_or("", |&(name, _)| name)
    }

    /// Writes a start trajectory for `objective` to `x` (`[N x dof]`, normalised units).
    pub fn draw(&self, objective: &Objective, rng: &mut ChaCha8Rng, x: &mut [f32]) {
        let room = Room(objective.scene().normalised_limits());
        let (dof, start, goal) = (objective.dof(), objective.start(), objective.goal());
        match self {
            Self::Line => objective.straight_line(x),
            Self::ViaPoint => {
                let mut corners = [start, start, goal].concat();
                room.draw(rng, &mut corners[dof..2 * dof]);
                polyline(dof, &corners, x);
            }
            Self::Random => x.chunks_exact_mut(dof).for_each(|p| room.draw(rng, p)),
            Self::Sorted => {
                let mut drawn = x.to_vec();
                drawn.chunks_exact_mut(dof).for_each(|p| room.draw(rng, p));
                let along = |p: &&[f32]| -> f32 {
                    let ways = goal.iter().zip(start).map(|(goal, start)| goal - start);
                    p.iter().zip(ways).map(|(p, way)| p * way).sum()
                };
                let mut points: Vec<&[f32]> = drawn.chunks_exact(dof).collect();
                points.sort_by(|p, q| along(p).total_cmp(&along(q)));
                x.chunks_exact_mut(dof).zip(points).for_each(|(x, p)| x.copy_from_slice(p));
            }
            Self::Paper => {
                x.chunks_exact_mut(dof).for_each(|p| room.draw(rng, p));
                for k in 0..dof {
                    let mut values: Vec<f32> = x.iter().skip(k).step_by(dof).copied().collect();
                    values.sort_by(f32::total_cmp);
                    x.iter_mut().skip(k).step_by(dof).zip(values).for_each(|(x, v)| *x = v);
                }
            }
        }
    }
}

impl std::str::FromStr for StartStrategy {
    type Err = InvalidInput;

    /// The strategy of that name.
    fn from_str(name: &str) -> Result<Self, InvalidInput> {
        let found = Self::NAMES.iter().find(|(known, _)| *known == name);
        let names = Self::NAMES.map(|(known, _)| known);
        let unknown = || InvalidInput::unknown("start-strategy", name, &names);
        found.map(|&(_, strategy)| strategy).ok_or_else(unknown)
    }
}

impl std::fmt::Display for StartStrategy {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// Left of each coordinate's range on each side, in normalised units (the paper's one pixel).
const MARGIN: f32 = 0.1;

/// Where random waypoints lie: limits of each coordinate, in normalised units.
struct Room<'a>(&'a [[f32; 2]]);

impl Room<'_> {
    fn draw(&self, rng: &mut ChaCha8Rng, p: &mut [f32]) {
        for (p, &[least, most]) in p.iter_mut().zip(self.0) {
            *p = (least + MARGIN) + rng.random::<f32>() * (most - least - 2.0 * MARGIN);
        }
    }
}
