//! Routes of a task as trajectories of N waypoints: the exact shortest path, and different ways
//! round.
//!
//! Paths are found among obstacles that are grown by a margin, the largest of `MARGINS` that makes
//! the path little longer than the shortest one, so that what learns from them does not scrape
//! along obstacles. An alternative leads through a random via-point and is then pulled taut; it is
//! kept if it is not much longer and differs from the others. A path becomes waypoints by spreading
//! them evenly, and where that would cut a corner, by putting one on every corner.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use sidestep::objective::Objective;
use sidestep::plan::rrt_connect::shortcut;
use sidestep::plane::geometry::{Point, distance};
use sidestep::plane::{PlaneScene, Subject, points};
use sidestep::rng::{Purpose, stream};
use sidestep::trajectory::waypoints::polyline;
use sidestep::{Obstacle, PlaneTask, Robot, Route, ShortestPath, Trajectory, World};

use super::{
    ALTERNATIVE_ROOM, ALTERNATIVE_STRETCH, DIFFERENT, MARGINS, ROOM, SLACK, STRETCH, Target,
    mean_distance,
};

/// Pixels of the paper's field (64ths of any field) in a normalised unit.
const PIXELS: f64 = 10.0;
/// Via-points drawn for each alternative wanted.
const DRAWS: usize = 4;

/// The routes of a task, the shortest first; none where there is no path or none that N waypoints
/// can follow.
pub fn find(
    task: PlaneTask<'_>,
    objective: &Objective,
    alternatives: usize,
    (seed, index): (u64, u64),
) -> Vec<Target> {
    let pixel = task.world.bounds().extent() / 64.0;
    let Some(Subject { scene, .. }) = objective.plane() else { return Vec::new() };
    let mut exact = scene.shortest_path();
    let Some(shortest) = exact.find(task.start, task.goal).length() else { return Vec::new() };
    let mut targets: Vec<Target> = Vec::new();
    let scale = scene.frame().scale;
    let keep = |targets: &mut Vec<Target>, points: &[Point]| {
        let Some(waypoints) = waypoints(points, scene, objective) else { return };
        let length: f64 = points.windows(2).map(|pair| distance(pair[0], pair[1])).sum();
        let extra = ((length - shortest) / scale).max(0.0) as f32;
        if targets.iter().all(|t| mean_distance(2, &t.waypoints, &waypoints) > DIFFERENT) {
            targets.push(Target { waypoints, extra });
        }
    };
    let mut search: Option<ShortestPath> = None;
    for margin in MARGINS.map(|margin| PIXELS * margin) {
        let mut grown = grown(task, margin * pixel);
        let Route::Found { trajectory, length, .. } = grown.find(task.start, task.goal) else {
            continue;
        };
        if length <= STRETCH * shortest + (SLACK * margin + PIXELS * ROOM) * pixel {
            keep(&mut targets, points(&trajectory));
            if !targets.is_empty() {
                search = Some(grown);
                break;
            }
        }
    }
    if targets.is_empty() {
        // A passage of hardly any width: the shortest path itself, if waypoints can follow it.
        if let Route::Found { trajectory, .. } = exact.find(task.start, task.goal) {
            keep(&mut targets, points(&trajectory));
        }
    }
    let Some(mut search) = search else { return targets };
    let mut rng = stream(seed, Purpose::Expert, index, 0);
    let longest = ALTERNATIVE_STRETCH * shortest + PIXELS * ALTERNATIVE_ROOM * pixel;
    for _ in 0..DRAWS * alternatives {
        if targets.len() > alternatives {
            break;
        }
        if let Some(points) = through(task, uniform(task, &mut rng), &mut search, longest, &mut rng)
        {
            keep(&mut targets, &points);
        }
    }
    targets
}

fn uniform(task: PlaneTask<'_>, rng: &mut ChaCha8Rng) -> Point {
    let (bounds, mut via) = (task.world.bounds(), [0.0; 2]);
    for axis in 0..2 {
        let t: f64 = rng.random();
        via[axis] = bounds.min[axis] + t * (bounds.max[axis] - bounds.min[axis]);
    }
    via
}

/// A taut path through `via`, if it is short enough.
fn through(
    task: PlaneTask<'_>,
    via: Point,
    search: &mut ShortestPath,
    longest: f64,
    rng: &mut ChaCha8Rng,
) -> Option<Vec<Point>> {
    let Route::Found { trajectory: first, length: one, .. } = search.find(task.start, via) else {
        return None;
    };
    let Route::Found { trajectory: second, length: two, .. } = search.find(via, task.goal) else {
        return None;
    };
    // Pulling it taut seldom takes off more than a half.
    if one + two > 2.0 * longest {
        return None;
    }
    let mut path = Trajectory::from_points(&[points(&first), &points(&second)[1..]].concat());
    let certifier = search.certifier();
    let is_free =
        |from: &[f64], to: &[f64]| certifier.segment_is_free([from[0], from[1]], [to[0], to[1]]);
    shortcut(&mut path, is_free, 8, rng);
    (path.length() <= longest).then(|| points(&path).to_vec())
}

/// The search among obstacles and walls that are `margin` nearer (task units). Rectangles grow to
/// rectangles, which keeps the search exact and quick; anything else is met by a larger robot.
fn grown(task: PlaneTask<'_>, margin: f64) -> ShortestPath {
    let world = &task.world;
    let rects: Option<Vec<Obstacle>> = world
        .obstacles()
        .iter()
        .map(|obstacle| match obstacle {
            Obstacle::Rect(rect) => Some(Obstacle::Rect(rect.inflated(margin))),
            _ => None,
        })
        .collect();
    match rects {
        Some(rects) if world.grid().is_none() && task.robot == Robot::Point => {
            let world = World::new(world.bounds().inflated(-margin), rects, None);
            ShortestPath::new(&world, Robot::Point)
        }
        _ => ShortestPath::new(world, Robot::Disc { radius: task.robot.radius() + margin }),
    }
}

/// N waypoints along the path, feasible by the profile's check and by the certificate; none if
/// there are more corners than waypoints or the path cannot be followed in f32.
fn waypoints(points: &[Point], scene: &PlaneScene, objective: &Objective) -> Option<Vec<f32>> {
    let frame = scene.frame();
    let corners: Vec<[f32; 2]> = points.iter().map(|&p| frame.to_normalised(p)).collect();
    let mut x = vec![0.0; objective.dim()];
    let passes = |x: &[f32]| objective.is_feasible(x) && objective.is_certified(x);
    polyline(2, corners.as_flattened(), &mut x);
    if passes(&x) {
        return Some(x);
    }
    on_corners(&corners, x.as_chunks_mut::<2>().0)?;
    passes(&x).then_some(x)
}

/// Puts a waypoint on every inner corner and spreads the others over the pieces, each time on the
/// piece whose segments are longest.
fn on_corners(corners: &[[f32; 2]], out: &mut [[f32; 2]]) -> Option<()> {
    let pieces = corners.len() - 1;
    let free = (out.len() + 1).checked_sub(pieces)?;
    let lengths: Vec<f32> = corners
        .windows(2)
        .map(|pair| (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]))
        .collect();
    let mut segments = vec![1usize; pieces];
    for _ in 0..free {
        let longest = (0..pieces).max_by(|&a, &b| {
            let part = |piece: usize| lengths[piece] / segments[piece] as f32;
            part(a).total_cmp(&part(b))
        })?;
        segments[longest] += 1;
    }
    let mut rest = out.iter_mut();
    for (piece, &count) in segments.iter().enumerate() {
        let (from, to) = (corners[piece], corners[piece + 1]);
        for step in 1..=count {
            let t = step as f32 / count as f32;
            // The last corner is the goal, which is no waypoint.
            let Some(point) = rest.next() else { break };
            *point = if step == count {
                to
            } else {
                [from[0] + t * (to[0] - from[0]), from[1] + t * (to[1] - from[1])]
            };
        }
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::super::nearest;
    use super::*;
    use sidestep::profile::Profile;
    use sidestep::scene::Query;
    use sidestep::suite::Suite;

    #[test]
    fn corners_get_waypoints_and_the_rest_is_spread() {
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 3.0]];
        let mut out = [[9.0; 2]; 3];
        on_corners(&corners, &mut out).unwrap();
        assert_eq!(out, [[1.0, 0.0], [1.0, 1.0], [1.0, 2.0]]);
        assert!(on_corners(&[[0.0; 2]; 6], &mut out).is_none(), "more corners than waypoints");
    }

    #[test]
    fn routes_are_certified_different_and_the_shortest_comes_first() {
        let tasks = Suite::Hard.generate(40, 1000, &Profile::PAPER);
        let (mut with_choice, mut none) = (0, 0);
        for (index, task) in tasks.iter().enumerate() {
            let objective = Objective::new(&Query::of(task, &Profile::PAPER), 10).unwrap();
            let plane = task.plane().unwrap();
            let targets = find(plane, &objective, 4, (5, index as u64));
            let again = find(plane, &objective, 4, (5, index as u64));
            assert_eq!(targets, again);
            for target in &targets {
                assert!(objective.is_certified(&target.waypoints), "{}", task.name);
                assert_eq!(nearest(2, &targets, &target.waypoints).unwrap().len(), 20);
            }
            assert!(targets.len() <= 5);
            none += usize::from(targets.is_empty());
            with_choice += usize::from(targets.len() > 1);
        }
        assert!(none <= 5, "{none} of 40 hard tasks without a route");
        assert!(with_choice >= 10, "{with_choice} of 40 with an alternative");
    }
}
