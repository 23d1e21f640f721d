//! Polishing: whatever made a plan, its corners are made round, and the better of both is kept by a stated score.

use std::f64::consts::FRAC_PI_2;

use crate::plan::answer::{Origin, Plan, Status};
use crate::plan::fair::{MOST_DOF, fair};
use crate::plan::options::Watch;
use crate::plan::rrt_connect::shortcut::remove_vertices;
use crate::scene::{Query, Scene};
use crate::trajectory::Trajectory;

/// Wishes for a plan's bends; an answer says whether they are kept.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wishes {
    /// The sharpest turn between two segments, in radians from 0 to π.
    pub turn: f64,
    /// The least radius of the arcs that round the corners, in task units, 0 or more.
    pub radius: f64,
}

impl Default for Wishes {
    /// No turn sharper than 20 degrees, however tight.
    fn default() -> Self {
        Self { turn: 20f64.to_radians(), radius: 0.0 }
    }
}

impl Wishes {
    /// By how much a path misses them: excess of its sharpest turn in right angles, and what is short of the radius as a
    /// part of it. 0 where they are kept.
    pub fn shortfall(&self, path: &Trajectory) -> f64 {
        let turn = (path.sharpest_turn() - self.turn).max(0.0) / FRAC_PI_2;
        let radius = path.turning_radius().min(self.radius);
        turn + if self.radius > 0.0 { 1.0 - radius / self.radius } else { 0.0 }
    }

    /// Whether a path keeps them.
    pub fn are_kept(&self, path: &Trajectory) -> bool {
        path.sharpest_turn() <= self.turn && path.turning_radius() >= self.radius
    }
}

/// What 90 degrees above the turn that is wished, or a radius of 0 for one that is, cost, as a part of the length.
const SHORTFALL_SHARE: f64 = 0.25;
/// What a turn of 90 degrees costs, wished or not.
const TURN_SHARE: f64 = 0.05;
/// What a path that touches something costs beside one that keeps its distance, as a part of the length.
const CLEARANCE_SHARE: f64 = 0.03;
/// The distance that is kept where there is room, as a part of the world's extent.
const EASE: f64 = 0.02;
/// Paths of more points are not shortened before they are faired.
const MOST_SHORTENED: usize = 500;

/// The score of a path, less is better, in task units:
/// length x (1 + 1/4 shortfall + 1/20 sharpest turn / 90° + 3/100 (1 − clearance / ease)), with [`Wishes::shortfall`] and the
/// clearance at most the ease, which is 1/50 of the world's extent.
pub fn score(query: &Query, path: &Trajectory, wishes: &Wishes) -> f64 {
    let ease = ease(query.scene());
    let clearance = query.scene().clearance(path).clamp(0.0, ease);
    let turn = path.sharpest_turn() / FRAC_PI_2;
    path.length()
        * (1.0
            + SHORTFALL_SHARE * wishes.shortfall(path)
            + TURN_SHARE * turn
            + CLEARANCE_SHARE * (1.0 - clearance / ease))
}

/// 1/50 of the extent in task units.
fn ease(scene: &Scene) -> f64 {
    EASE * scene.limits().iter().map(|[least, most]| most - least).fold(1e-9, f64::max)
}

/// A certified path of the same ends that bends less, by [`fair`]; the path itself where there is none.
pub fn round_off(
    query: &Query,
    path: &Trajectory,
    wishes: &Wishes,
    watch: Watch<'_>,
) -> Trajectory {
    let is_free = |from: &[f64], to: &[f64]| query.scene().motion_is_free(from, to);
    fair(path, reach(query, wishes), wishes, &is_free, watch.go_on)
}

/// Lengths that fairing begins with.
pub(super) fn reach(query: &Query, wishes: &Wishes) -> f64 {
    let radius = query.scene().plane().map_or(0.0, |plane| plane.robot().radius());
    ease(query.scene()).max(radius).max(2.0 * wishes.radius)
}

/// The plan made round where it bends; of both the one of the better [`score`], and never one that is not certified.
pub fn polish(query: &Query, plan: Plan, wishes: &Wishes, watch: Watch<'_>) -> Plan {
    let Some(path) = plan.certified() else { return plan };
    if path.dof() > MOST_DOF || path.sharpest_turn() < 1e-3 || !(watch.go_on)() {
        return plan;
    }
    let taut = match path.len() <= MOST_SHORTENED && plan.origin != Origin::ShortestPath {
        true => taut(path, &|a: &[f64], b: &[f64]| query.scene().motion_is_free(a, b)),
        false => path.clone(),
    };
    let round = round_off(query, &taut, wishes, watch);
    if score(query, &round, wishes) >= score(query, path, wishes) {
        return plan;
    }
    let origin = match plan.origin {
        Origin::ShortestPath => Origin::SmoothShortestPath,
        Origin::Tree => Origin::SmoothTree,
        other => other,
    };
    match query.certify(round) {
        Ok(certified) => Plan { status: Status::Solved(certified), origin, ..plan },
        Err(_) => plan,
    }
}

/// The path with straight lines from each point to the last one that it sees, looked at from the start, and from the goal; the
/// shorter of both. From the start alone a path that runs past its goal keeps the hook.
pub(super) fn taut(path: &Trajectory, is_free: &impl Fn(&[f64], &[f64]) -> bool) -> Trajectory {
    let dof = path.dof();
    let straightened = |mut points: Vec<f64>| {
        remove_vertices(dof, &mut points, is_free);
        points
    };
    let reversed = |points: &[f64]| -> Vec<f64> {
        points.chunks_exact(dof).rev().flatten().copied().collect()
    };
    let forwards = Trajectory::new(dof, straightened(path.values().to_vec()));
    let backwards = straightened(reversed(path.values()));
    let backwards = Trajectory::new(dof, reversed(&backwards));
    if backwards.length() < forwards.length() { backwards } else { forwards }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::plan::{Options, Planner, Stop, plan};
    use crate::plane::geometry::Rect;
    use crate::plane::world::{Grid, Obstacle, World};
    use crate::suite::Suite;
    use crate::{Profile, Robot, Task};

    /// Walls of a room with doors left and right, as grid cells.
    fn rooms(radius: f64) -> Task {
        let bounds = Rect::new([0.0; 2], [20.0, 30.0]).unwrap();
        let is_wall = |i: usize| {
            let (x, y) = (i % 20, i / 20);
            (0..4).any(|k| y == 5 + 6 * k && if k % 2 == 0 { x < 15 } else { x >= 5 })
        };
        let grid = Grid::new(20, 30, 1.0, [0.0; 2], (0..600).map(is_wall).collect()).unwrap();
        let world = Arc::new(World::new(bounds, Vec::new(), Some(grid)));
        let robot = Robot::disc(radius).unwrap();
        Task::in_plane("rooms", world, robot, [2.0, 2.0], [18.0, 28.0]).unwrap()
    }

    #[test]
    fn plans_on_maps_are_round_and_hardly_longer_than_the_shortest() {
        for radius in [0.0, 0.3, 1.0] {
            let task = rooms(radius);
            let planned = |planner: &Planner| {
                let plan = plan(&task, planner, &Options::default()).unwrap();
                plan.certified().unwrap().clone()
            };
            let (auto, exact) = (planned(&Planner::default()), planned(&Planner::ShortestPath));
            assert!(crate::certify(&task, &auto).is_ok());
            let turn = auto.sharpest_turn().to_degrees();
            assert!(turn <= 20.0, "{radius} {turn}");
            let ratio = auto.length() / exact.length();
            assert!(ratio <= 1.03, "{radius} {ratio}");
        }
    }

    #[test]
    fn wishes_are_kept_where_there_is_room_whatever_the_planner() {
        let wishes = Wishes { turn: 12f64.to_radians(), radius: 0.8 };
        let options = Options { wishes: Some(wishes), ..Options::default() };
        for planner in ["auto", "shortest-path", "rrt-connect"] {
            let planner = planner.parse::<Planner>().unwrap();
            let plan = plan(&rooms(0.3), &planner, &options).unwrap();
            let path = plan.certified().unwrap();
            assert!(
                wishes.are_kept(path),
                "{} {}",
                path.sharpest_turn().to_degrees(),
                path.turning_radius()
            );
        }
    }

    #[test]
    fn the_best_is_never_worse_than_the_first_and_lines_stay_lines() {
        let tasks = Suite::Easy.generate(60, 1000, &Profile::PAPER);
        let wishes = Wishes::default();
        for task in &tasks {
            let planned = |stop: Stop| {
                let options = Options { stop, ..Options::default() };
                plan(task, &Planner::default(), &options).unwrap()
            };
            let (first, best) = (planned(Stop::First), planned(Stop::Best));
            assert_eq!(first.is_solved(), best.is_solved());
            let (Some(first), Some(best)) = (first.certified(), best.certified()) else { continue };
            let query = Query::of(task, &Profile::DEFAULT);
            let [first_score, best_score] = [first, best].map(|path| score(&query, path, &wishes));
            assert!(best_score <= first_score + 1e-9, "{first_score} {best_score}");
            if first.sharpest_turn() < 1e-6 {
                assert!(best.sharpest_turn() < 1e-6);
            }
        }
    }

    #[test]
    fn a_path_that_runs_past_its_goal_loses_the_hook() {
        let block = Obstacle::Rect(Rect::new([3.0, 1.0], [5.0, 5.0]).unwrap());
        let bounds = Rect::new([0.0; 2], [10.0, 6.0]).unwrap();
        let world = Arc::new(World::new(bounds, vec![block], None));
        let robot = Robot::disc(0.3).unwrap();
        let task = Task::in_plane("", world, robot, [1.0, 3.0], [6.0, 3.0]).unwrap();
        let query = Query::of(&task, &Profile::DEFAULT);
        let points = [[1.0, 3.0], [2.4, 5.5], [5.6, 5.5], [7.5, 2.9], [6.0, 3.0]];
        let hooked = Plan::of(&query, Trajectory::from_points(&points), 0, Origin::Tree);
        let before = hooked.certified().unwrap().length();
        let after = polish(&query, hooked, &Wishes::default(), Watch::NONE);
        let length = after.certified().unwrap().length();
        assert!(length < before - 1.0, "{before} {length}");
    }

    #[test]
    fn a_passage_without_room_keeps_its_corner_and_a_polished_path_is_certified() {
        // A corridor as wide as the robot and a hair, with a corner.
        let boxes =
            [[[0.0, 1.01], [8.99, 10.0]], [[0.0, -1.0], [10.0, 0.0]], [[10.0, -1.0], [11.0, 10.0]]];
        let boxes = boxes.map(|[min, max]| Obstacle::Rect(Rect::new(min, max).unwrap()));
        let bounds = Rect::new([0.0, -1.0], [11.0, 10.0]).unwrap();
        let world = Arc::new(World::new(bounds, boxes.to_vec(), None));
        let robot = Robot::disc(0.5).unwrap();
        let task = Task::in_plane("", world, robot, [1.0, 0.505], [9.495, 9.0]).unwrap();
        let answer = plan(&task, &Planner::default(), &Options::default()).unwrap();
        let path = answer.certified().unwrap();
        assert!(crate::certify(&task, path).is_ok());
        assert!(path.sharpest_turn().to_degrees() < 46.0);
    }
}
