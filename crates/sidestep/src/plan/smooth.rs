//! Smoothing: from a certified path with corners and no clearance, such as a shortest one, to a
//! smooth one that keeps its distance where there is room.
//!
//! The waypoints are the path's corners and points evenly between them, two to each ε. Adam walks
//! them downhill on U, and the certified iterate of least U wins. What the profile fixes for fields
//! of one size is here in proportion to the world:
//!
//! - ε is the scene's typical clearance, at most the profile's. Where that fails, because a passage
//!   is far narrower than most, it is halved.
//! - λ = b P ε / 2h² for waypoints at distances h, P being the most that obstacles push one of N
//!   waypoints with: 2 g / N where waypoints and substeps are averaged apart, g / N where together,
//!   with the profile's obstacle gradient factor g. Where the path bends by a radius of ε, length
//!   then pulls with 2 λ h² / ε = b P, however long the path is.
//! - Adam's step is a part of ε.

use crate::error::InvalidInput;
use crate::objective::Objective;
use crate::optimizer::{Method, Optimizer};
use crate::plan::options::Watch;
use crate::plan::run::{Iteration, Run, Until, run};
use crate::profile::{Averaging, MAX_WAYPOINTS};
use crate::rng::{Purpose, stream};
use crate::scene::Query;
use crate::trajectory::{Trajectory, distance};

/// The share b of length in the balance with obstacles.
const LENGTH_SHARE: f64 = 0.3;
/// Adam's step, as a part of ε.
const STEP: f64 = 0.1;
/// Waypoints to each ε along the path, if they are not too many.
const WAYPOINTS_PER_EPSILON: f64 = 2.0;
/// Fewest waypoints, and most unless the path has more corners.
const WAYPOINTS: (usize, usize) = (10, 1000);
/// Waypoints to each corner of the path at least.
const WAYPOINTS_PER_CORNER: usize = 3;
/// Values of ε that are tried, each half of the one before.
const ATTEMPTS: i32 = 3;
/// Steps that one attempt makes at most.
pub const MAX_STEPS: usize = 40;

/// A smoothed path.
#[derive(Debug, Clone, PartialEq)]
pub struct Smooth {
    /// Certified, from the same start to the same goal.
    pub trajectory: Trajectory,
    /// Optimizer steps made.
    pub steps: usize,
}

/// Smooths a certified path that answers `query`, with at most `steps` steps (and
/// [`MAX_STEPS`]) for each ε; nothing where no iterate is certified that is at most `longest` times as
/// long as the path. `watch` sees the iterates as those of start number `start`.
///
/// # Errors
/// If the path has more corners than a trajectory may have waypoints.
pub fn smooth(
    query: &Query,
    path: &Trajectory,
    longest: f64,
    steps: usize,
    start: usize,
    watch: Watch<'_>,
) -> Result<Option<Smooth>, InvalidInput> {
    let length = path.length();
    let widest = query.scene().typical_clearance().min(query.scene().profile().epsilon);
    if !(widest > 0.0 && length > 0.0) {
        return Ok(None);
    }
    let mut steps_made = 0;
    let mut broken_off = false;
    for attempt in 0..ATTEMPTS {
        let epsilon = widest * 0.5f64.powi(attempt);
        let (mut objective, mut x) = begin(query, path, epsilon)?;
        let method = Method::Adam { step: (STEP * epsilon) as f32 };
        let rng = stream(0, Purpose::Planner, 0, 0);
        let mut optimizer = Optimizer::new(&method, &objective, rng)?;
        let steps = steps.min(MAX_STEPS);
        let Run { steps, best, .. } =
            run(&mut objective, &mut optimizer, &mut x, steps, Until::Spent, |iteration| {
                let flow = watch.look(&Iteration { start, ..*iteration });
                broken_off = flow.is_break();
                flow
            });
        steps_made += steps;
        let trajectory = best.map(|best| objective.trajectory(&best.waypoints));
        if let Some(trajectory) = trajectory.filter(|found| found.length() <= longest * length) {
            return Ok(Some(Smooth { trajectory, steps: steps_made }));
        }
        if broken_off {
            break;
        }
    }
    Ok(None)
}

/// The objective for this ε and the first waypoints.
fn begin(
    query: &Query,
    path: &Trajectory,
    epsilon: f64,
) -> Result<(Objective, Vec<f32>), InvalidInput> {
    let scene = query.scene();
    let corners = path.len().saturating_sub(2);
    let length = scene.normalised_length(path);
    let even = (WAYPOINTS_PER_EPSILON * length / epsilon).ceil().min(MAX_WAYPOINTS as f64);
    let n = (even as usize).clamp(WAYPOINTS.0, WAYPOINTS.1).max(WAYPOINTS_PER_CORNER * corners);
    let h = length / (n + 1) as f64;
    let averages = match scene.profile().averaging {
        Averaging::Grouped => 2.0,
        Averaging::Pooled => 1.0,
    };
    let push = averages * scene.profile().obstacle_gradient_factor / n as f64;
    let lambda = LENGTH_SHARE * push * epsilon / (2.0 * h * h);
    let objective = Objective::new(query, n)?.with_weights(epsilon, lambda);
    let mut x = vec![0.0; objective.dim()];
    scene.to_normalised(&spread(path, n), &mut x);
    Ok((objective, x))
}

/// `n` configurations along a path, `[n x dof]`: its corners, and the others spread over its segments by length.
fn spread(path: &Trajectory, n: usize) -> Vec<f64> {
    let (dof, length) = (path.dof(), path.length());
    let spare = (n + 1).saturating_sub(path.len().saturating_sub(1));
    let (mut passed, mut given) = (0.0, 0);
    let mut points = Vec::with_capacity((n + 1) * dof);
    for (from, to) in path.segments() {
        // Rounding what all segments so far deserve gives away all of the spare points.
        passed += distance(from, to);
        let due = (spare as f64 * (passed / length).min(1.0)).round() as usize;
        let parts = 1 + due - given;
        given = due;
        for part in 1..=parts {
            let t = part as f64 / parts as f64;
            points.extend(from.iter().zip(to).map(|(from, to)| from + t * (to - from)));
        }
    }
    points.truncate(n * dof);
    points
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::plane::Robot;
    use crate::plane::geometry::Rect;
    use crate::plane::world::{Grid, Obstacle, World};
    use crate::profile::Profile;
    use crate::scene::Task;

    fn smoothed(task: &Task, profile: &Profile) -> (Trajectory, Option<Smooth>, Query) {
        let query = Query::of(task, profile);
        let route = query.scene().exact(query.start(), query.goal(), &|| true);
        let Some(crate::Route::Found { trajectory, .. }) = route else { panic!("{route:?}") };
        let smooth = smooth(&query, &trajectory, 1.2, MAX_STEPS, 0, Watch::NONE).unwrap();
        (trajectory, smooth, query)
    }

    #[test]
    fn corners_are_kept_and_the_rest_is_even() {
        let path = Trajectory::from_points(&[[0.0, 0.0], [4.0, 0.0], [4.0, 0.1], [4.0, 6.0]]);
        for n in [2, 3, 10, 37] {
            let points = spread(&path, n);
            let points = points.as_chunks::<2>().0;
            assert_eq!(points.len(), n);
            for corner in &crate::plane::points(&path)[1..3] {
                assert!(points.contains(corner), "{n}: {points:?}");
            }
        }
        let points = Trajectory::new(2, spread(&path, 22));
        let gap = points.segments().map(|(a, b)| distance(a, b)).fold(0.0, f64::max);
        assert!(gap < 0.6, "{points:?}");
    }

    #[test]
    fn smooth_paths_are_short_and_keep_clear() {
        // Walls of a room with doors left and right, as boxes and as grid cells.
        let bounds = Rect::new([0.0; 2], [20.0, 30.0]).unwrap();
        let walls: Vec<Rect> = (0..4)
            .map(|i| {
                let (x, y) = (if i % 2 == 0 { 0.0 } else { 5.0 }, 5.0 + 6.0 * f64::from(i));
                Rect::new([x, y], [x + 15.0, y + 1.0]).unwrap()
            })
            .collect();
        let inside = |i: usize| {
            let cell = [(i % 20) as f64 + 0.5, (i / 20) as f64 + 0.5];
            walls.iter().any(|wall| wall.contains(cell))
        };
        let grid = Grid::new(20, 30, 1.0, [0.0; 2], (0..600).map(inside).collect()).unwrap();
        let boxes = walls.iter().copied().map(Obstacle::Rect).collect();
        for world in [World::new(bounds, boxes, None), World::new(bounds, Vec::new(), Some(grid))] {
            let world = Arc::new(world);
            for (radius, profile) in
                [(0.0, Profile::DEFAULT), (0.7, Profile::DEFAULT), (0.0, Profile::PAPER)]
            {
                let robot = Robot::disc(radius).unwrap();
                let task =
                    Task::in_plane("", world.clone(), robot, [2.0, 2.0], [18.0, 28.0]).unwrap();
                let (path, smooth, query) = smoothed(&task, &profile);
                let smooth = smooth.unwrap().trajectory;
                let label = format!("{radius} {}", profile.name);
                assert!(query.certify(smooth.clone()).is_ok(), "{label}");
                assert!(smooth.length() < 1.15 * path.length(), "{label} {}", smooth.length());
                let clearance = query.scene().clearance(&smooth);
                assert!(query.scene().clearance(&path) < 1e-3, "{label}");
                assert!(clearance > 2e-3, "{label} {clearance}");
            }
        }
    }

    #[test]
    fn a_gap_far_narrower_than_most_is_passed() {
        let bounds = Rect::new([0.0; 2], [64.0; 2]).unwrap();
        let boxes = [[[0.0, 30.0], [31.9, 34.0]], [[32.1, 30.0], [64.0, 34.0]]];
        let boxes = boxes.map(|[min, max]| Obstacle::Rect(Rect::new(min, max).unwrap()));
        let world = Arc::new(World::new(bounds, boxes.to_vec(), None));
        let task = Task::in_plane("", world, Robot::Point, [5.0, 5.0], [50.0, 60.0]).unwrap();
        let (path, smooth, query) = smoothed(&task, &Profile::DEFAULT);
        let smooth = smooth.unwrap().trajectory;
        assert!(query.certify(smooth.clone()).is_ok());
        assert!(smooth.length() < 1.2 * path.length());
    }
}
