//! The expert of imitation: trajectories along exact shortest paths, the best one and detours past
//! other sides of obstacles.
//!
//! Rectangles grow by the largest margin that makes the path little longer; where start or goal is
//! closer to a rectangle than that, this one grows less. A shortest path among the grown rectangles
//! is resampled to the waypoints. Alternatives go through random via-points and are pulled taut.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use sidestep::objective::Objective;
use sidestep::plane::geometry::{Point, Rect, cross, distance, lerp, sub};
use sidestep::plane::{PlaneScene, Subject, points};
use sidestep::{Obstacle, PlaneTask, Robot, Route, ShortestPath, Trajectory, World};

use super::{
    ALTERNATIVE_ROOM, ALTERNATIVE_STRETCH, DIFFERENT, MARGINS, ROOM, SLACK, STRETCH, Target,
    mean_distance,
};

/// Random via-points per task.
const VIA_POINTS: usize = 8;
/// Most trajectories per task.
const MOST: usize = 5;
/// Rounds of pulling taut before an alternative is given up.
const PULLS: usize = 24;

/// The trajectories for a task of rectangles, best first; none if the task has no solution that
/// leaves any room.
pub fn targets(task: PlaneTask<'_>, objective: &Objective, rng: &mut ChaCha8Rng) -> Vec<Target> {
    let Some(Subject { scene, .. }) = objective.plane() else { return Vec::new() };
    let scale = scene.frame().scale;
    let route = scene.shortest_path().find(task.start, task.goal);
    let Some(shortest) = route.length() else { return Vec::new() };
    let mut targets = Vec::new();
    for margin in MARGINS.map(|margin| margin * scale) {
        let Some(mut grown) = Grown::new(task, margin) else { continue };
        let Some((path, length)) = grown.path(task.start, task.goal) else { continue };
        if length > STRETCH * shortest + SLACK * margin + ROOM * scale {
            continue;
        }
        let Some(waypoints) = resample(&path, scene, objective.waypoints()) else { continue };
        targets.push(Target { waypoints, extra: 0.0 });
        let most = ALTERNATIVE_STRETCH * length + ALTERNATIVE_ROOM * scale;
        for _ in 0..VIA_POINTS {
            if targets.len() == MOST {
                break;
            }
            let bounds = task.world.bounds();
            let via = [0, 1].map(|axis| rng.random_range(bounds.min[axis]..bounds.max[axis]));
            let Some(taut) = grown.through(task.start, via, task.goal) else { continue };
            let long = taut.windows(2).map(|w| distance(w[0], w[1])).sum::<f64>();
            if long > most {
                continue;
            }
            let Some(waypoints) = resample(&taut, scene, objective.waypoints()) else { continue };
            if targets
                .iter()
                .all(|other| mean_distance(2, &other.waypoints, &waypoints) > DIFFERENT)
            {
                targets.push(Target { waypoints, extra: ((long - length) / scale) as f32 });
            }
        }
        break;
    }
    targets
}

/// The task's world with grown rectangles.
struct Grown {
    search: ShortestPath,
    /// Corners just outside the grown rectangles.
    corners: Vec<Point>,
}

impl Grown {
    /// Grows by the robot's radius and `margin`, less where that would swallow start or goal; none
    /// if they are not free.
    fn new(task: PlaneTask<'_>, margin: f64) -> Option<Self> {
        let radius = task.robot.radius();
        let room = |gap: f64| radius + margin.min(0.9 * (gap - radius)).max(0.0);
        let gap = |rect: &Rect, p: Point| {
            let beyond = |axis: usize| (rect.min[axis] - p[axis]).max(p[axis] - rect.max[axis]);
            beyond(0).max(beyond(1))
        };
        let least = |rect: &Rect| gap(rect, task.start).min(gap(rect, task.goal));
        let mut rects = Vec::new();
        for obstacle in task.world.obstacles() {
            let Obstacle::Rect(rect) = obstacle else { return None };
            rects.push(rect.inflated(room(least(rect))));
        }
        let bounds = task.world.bounds();
        let wall = |p: Point| -gap(&bounds, p);
        let shrunk = bounds.inflated(-room(wall(task.start).min(wall(task.goal))));
        let grown = rects.clone();
        let obstacles = rects.into_iter().map(Obstacle::Rect).collect();
        let world = World::new(shrunk, obstacles, None);
        // The search's corners lie two tolerances outside, and what is free more than one: between
        // them, a path along the search's corners holds these in its triangles.
        let hair = 1.5 * world.tolerance();
        let corners: Vec<Point> =
            grown.iter().flat_map(|rect| rect.inflated(hair).corners()).collect();
        let search = ShortestPath::new(&world, Robot::Point);
        let free = |p: &Point| search.certifier().point_is_free(*p);
        if !(free(&task.start) && free(&task.goal)) {
            return None;
        }
        let corners = corners.iter().copied().filter(free).collect();
        Some(Self { search, corners })
    }

    fn path(&mut self, start: Point, goal: Point) -> Option<(Vec<Point>, f64)> {
        match self.search.find(start, goal) {
            Route::Found { trajectory, length, .. } => Some((points(&trajectory).to_vec(), length)),
            _ => None,
        }
    }

    /// A path through `via`, pulled taut: it is locally shortest.
    fn through(&mut self, start: Point, via: Point, goal: Point) -> Option<Vec<Point>> {
        if !self.search.certifier().point_is_free(via) {
            return None;
        }
        let (mut path, _) = self.path(start, via)?;
        let (rest, _) = self.path(via, goal)?;
        path.extend_from_slice(&rest[1..]);
        for _ in 0..PULLS {
            let mut changed = false;
            let mut i = 1;
            while i + 1 < path.len() {
                let chain = self.chain(path[i - 1], path[i], path[i + 1]);
                if chain != [path[i]] {
                    path.splice(i..=i, chain);
                    changed = true;
                }
                i += 1;
            }
            if !changed {
                let certifier = self.search.certifier();
                let free = path.windows(2).all(|w| certifier.segment_is_free(w[0], w[1]));
                return free.then_some(path);
            }
        }
        None
    }

    /// The shortest way from `a` to `b` that stays on `v`'s side of what lies in the triangle a, v,
    /// b.
    fn chain(&self, a: Point, v: Point, b: Point) -> Vec<Point> {
        let side = cross(sub(b, a), sub(v, a));
        if side.abs() <= 1e-12 * distance(a, b).max(1.0) {
            return Vec::new();
        }
        let sign = side.signum();
        let inside = |p: Point| {
            let left = |from: Point, to: Point| sign * cross(sub(to, from), sub(p, from));
            left(a, b) > 0.0 && left(b, v) >= 0.0 && left(v, a) >= 0.0
        };
        let base = sub(b, a);
        let along = |p: &Point| base[0] * (p[0] - a[0]) + base[1] * (p[1] - a[1]);
        let mut points: Vec<Point> = self.corners.iter().copied().filter(|&p| inside(p)).collect();
        points.sort_by(|p, q| along(p).total_cmp(&along(q)));
        // Half of a convex hull, by the monotone chain (Andrew 1979).
        let mut hull = vec![a];
        for p in points.into_iter().chain([b]) {
            while let [.., before, last] = hull[..]
                && sign * cross(sub(last, before), sub(p, before)) >= 0.0
            {
                hull.pop();
            }
            hull.push(p);
        }
        hull[1..hull.len() - 1].to_vec()
    }
}

/// N waypoints along `path`, evenly spaced; where that would cut a corner, with waypoints at all
/// corners.
fn resample(path: &[Point], scene: &PlaneScene, count: usize) -> Option<Vec<f32>> {
    let free = |points: &[Point]| {
        let (start, goal) = (path[0], path[path.len() - 1]);
        let all: Vec<Point> =
            std::iter::once(start).chain(points.iter().copied()).chain([goal]).collect();
        all.windows(2).all(|w| scene.certifier().segment_is_free(w[0], w[1]))
    };
    let even = Trajectory::from_points(path).evenly(count + 2);
    let mut points = points(&even)[1..=count].to_vec();
    if !free(&points) {
        points = cornered(path, count)?;
        if !free(&points) {
            return None;
        }
    }
    let frame = scene.frame();
    Some(points.into_iter().flat_map(|p| frame.to_normalised(p)).collect())
}

/// All corners, and the other waypoints shared out over the legs by length.
fn cornered(path: &[Point], count: usize) -> Option<Vec<Point>> {
    let lengths: Vec<f64> = path.windows(2).map(|w| distance(w[0], w[1])).collect();
    let mut spare = count.checked_sub(path.len() - 2)?;
    let mut parts = vec![1_usize; lengths.len()];
    while spare > 0 {
        let step = |i: &usize| lengths[*i] / parts[*i] as f64;
        let longest = (0..parts.len()).max_by(|a, b| step(a).total_cmp(&step(b)))?;
        parts[longest] += 1;
        spare -= 1;
    }
    let mut points = Vec::with_capacity(count + 1);
    for (leg, &parts) in parts.iter().enumerate() {
        let (a, b) = (path[leg], path[leg + 1]);
        points.extend((1..=parts).map(|k| lerp(a, b, k as f64 / parts as f64)));
    }
    points.pop();
    Some(points)
}

#[cfg(test)]
mod tests {
    use super::*;
    use sidestep::profile::Profile;
    use sidestep::rng::{Purpose, stream};
    use sidestep::scene::{Query, Task};
    use sidestep::suite::{candidate, varied};
    use std::sync::Arc;

    #[test]
    fn targets_are_certified_and_different() {
        let (mut solvable, mut several) = (0, 0);
        for index in 0..200 {
            let task = if index % 2 == 0 { candidate(1000, index) } else { varied(1000, index) };
            let objective = Objective::new(&Query::of(&task, &Profile::DEFAULT), 10).unwrap();
            let mut rng = stream(5, Purpose::Imitation, index, 0);
            let targets = targets(task.plane().unwrap(), &objective, &mut rng);
            for target in &targets {
                assert!(objective.is_certified(&target.waypoints), "{}", task.name);
            }
            for (i, target) in targets.iter().enumerate() {
                for other in &targets[..i] {
                    assert!(mean_distance(2, &target.waypoints, &other.waypoints) > DIFFERENT);
                }
            }
            solvable += usize::from(!targets.is_empty());
            several += usize::from(targets.len() > 1);
        }
        assert!(solvable >= 180 && several >= 60, "{solvable} {several}");
    }

    #[test]
    fn taut_paths_hug_the_obstacle() {
        // One box between start and goal: the way past its far side has exactly its two far
        // corners.
        let rect = Rect { min: [20.0, 20.0], max: [40.0, 50.0] };
        let bounds = Rect { min: [0.0; 2], max: [64.0; 2] };
        let world = Arc::new(World::new(bounds, vec![Obstacle::Rect(rect)], None));
        let task = Task::in_plane("", world, Robot::Point, [10.0, 30.0], [50.0, 30.0]).unwrap();
        let task = task.plane().unwrap();
        let mut grown = Grown::new(task, 1.0).unwrap();
        let path = grown.through(task.start, [30.0, 60.0], task.goal).unwrap();
        let corners: Vec<Point> = path.iter().map(|p| p.map(f64::round)).collect();
        assert_eq!(corners, [[10.0, 30.0], [19.0, 51.0], [41.0, 51.0], [50.0, 30.0]]);
    }
}
