//! A path in the plane as a wheeled robot drives it: heading, curvature, speed and time at each point.
//!
//! Speed is the greatest that limits allow, v² |κ| <= lateral acceleration and |dv²/ds| <= 2 x acceleration, found by one
//! pass forward from rest and one back from the end: each can only lower what the other left (for a limit on v² that
//! depends on s alone both together are the optimum; T. Kunz and M. Stilman, Time-optimal trajectory generation for path
//! following with bounded acceleration and velocity, RSS 2012). Between two points v² is linear in s, so each
//! segment is driven at constant acceleration and takes 2 ds / (v₁ + v₂).

use super::{Trajectory, distance};
use crate::error::{InvalidInput, MAX_COORDINATE};

/// What a wheeled robot may do, in task units and seconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DrivingLimits {
    /// Greatest speed.
    pub speed: f64,
    /// Greatest acceleration along the path, speeding up and braking.
    pub acceleration: f64,
    /// Greatest acceleration across it: v² |κ|.
    pub lateral_acceleration: f64,
}

impl Default for DrivingLimits {
    /// 0.5 m/s, 0.5 m/s² and 0.5 m/s²: an indoor robot with a load.
    fn default() -> Self {
        Self { speed: 0.5, acceleration: 0.5, lateral_acceleration: 0.5 }
    }
}

/// One point of a driven path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Place, in task units.
    pub position: [f64; 2],
    /// Heading in radians from the x axis, in (−π, π].
    pub yaw: f64,
    /// Seconds since the start.
    pub time: f64,
    /// Speed in task units a second.
    pub speed: f64,
    /// Curvature, positive to the left, in 1 / task unit.
    pub curvature: f64,
}

impl DrivingLimits {
    /// Distance of points that follow a change of speed well: a quarter of the way to top speed.
    pub fn spacing(&self) -> f64 {
        self.speed * self.speed / (8.0 * self.acceleration)
    }

    /// Checks the limits.
    ///
    /// # Errors
    /// If one is not above 0 and at most 1e9.
    pub fn check(&self) -> Result<(), InvalidInput> {
        let Self { speed, acceleration, lateral_acceleration } = *self;
        let named = [
            ("speed", speed),
            ("acceleration", acceleration),
            ("lateral_acceleration", lateral_acceleration),
        ];
        match named.iter().find(|(_, limit)| !(*limit > 0.0 && *limit <= MAX_COORDINATE)) {
            Some((field, limit)) => {
                Err(InvalidInput::new(*field, limit, "a number above 0, at most 1e9"))
            }
            None => Ok(()),
        }
    }
}

/// Points of a path in the plane that are `spacing` apart at most, the path's own kept; the distances within a segment
/// are equal. At most `most` points: with more the spacing grows.
pub fn spaced(path: &Trajectory, spacing: f64, most: usize) -> Trajectory {
    let spacing = spacing.max(path.length() / most.max(1) as f64);
    let dof = path.dof();
    let mut values = Vec::new();
    for (a, b) in path.segments() {
        let parts = (distance(a, b) / spacing * (1.0 - 1e-12)).ceil().max(1.0) as usize;
        for part in 0..parts {
            let t = part as f64 / parts as f64;
            values.extend(a.iter().zip(b).map(|(a, b)| a + t * (b - a)));
        }
    }
    values.extend_from_slice(path.configurations().next_back().unwrap_or(&[]));
    Trajectory::new(dof, values)
}

/// A place where a path turns.
struct Corner {
    /// Where on the path.
    at: f64,
    /// How far before and after it the arc that rounds it goes: to the middle of the shorter of its sides.
    reach: f64,
    curvature: f64,
    /// Heading in the corner: the tangent of the circle through it and the corners beside it.
    yaw: f64,
}

/// Turns of less than this, in radians, are points along a straight line.
const STRAIGHT: f64 = 1e-6;

/// The corners of a path by its segments' headings and the lengths up to its points. Points along a straight line, such as
/// [`spaced`] puts in, are no corners.
fn corners(headings: &[f64], passed: &[f64]) -> Vec<Corner> {
    let turn = |i: usize| wrapped(headings[i] - headings[i - 1]);
    let turning: Vec<usize> = (1..headings.len()).filter(|&i| turn(i).abs() > STRAIGHT).collect();
    let end = passed.last().copied().unwrap_or_default();
    (0..turning.len())
        .map(|k| {
            let (i, at) = (turning[k], passed[turning[k]]);
            let before = at - k.checked_sub(1).map_or(0.0, |k| passed[turning[k]]);
            let after = turning.get(k + 1).map_or(end, |&next| passed[next]) - at;
            let reach = 0.5 * before.min(after);
            // The nearer neighbour's side counts for more.
            let yaw = wrapped(headings[i - 1] + before / (before + after) * turn(i));
            Corner { at, reach, curvature: (0.5 * turn(i)).tan() / reach, yaw }
        })
        .collect()
}

/// Drives a path of points in the plane, from rest to rest. Corners are driven as the arcs that round them from half the shorter
/// of their sides: the curvature of a point on such an arc is the arc's, and its heading turns evenly along it. Points
/// that repeat their neighbour are left out.
///
/// # Errors
/// If a limit is out of range.
pub fn drive(points: &[[f64; 2]], limits: &DrivingLimits) -> Result<Vec<Pose>, InvalidInput> {
    limits.check()?;
    let mut places = points.to_vec();
    places.dedup();
    let segments: Vec<[f64; 2]> =
        places.windows(2).map(|p| [p[1][0] - p[0][0], p[1][1] - p[0][1]]).collect();
    let lengths: Vec<f64> = segments.iter().map(|[x, y]| x.hypot(*y)).collect();
    let headings: Vec<f64> = segments.iter().map(|[x, y]| y.atan2(*x)).collect();
    let mut passed = vec![0.0];
    for (i, length) in lengths.iter().enumerate() {
        passed.push(passed[i] + length);
    }
    let corners = corners(&headings, &passed);
    let mut next = 0;
    let mut poses: Vec<Pose> = (0..places.len())
        .map(|i| {
            // A point between two segments of one heading is as well on the one as on the other.
            let heading = headings.get(i).or(headings.last()).copied().unwrap_or_default();
            while corners.get(next).is_some_and(|corner| corner.at < passed[i]) {
                next += 1;
            }
            let around = [next.checked_sub(1), Some(next)].into_iter().flatten();
            let near = around
                .filter_map(|k| corners.get(k))
                .find(|corner| (passed[i] - corner.at).abs() <= corner.reach * (1.0 + 1e-9));
            let (yaw, curvature) = match near {
                Some(corner) => {
                    let away = (passed[i] - corner.at).abs() / corner.reach;
                    let out = wrapped(heading - corner.yaw);
                    (wrapped(corner.yaw + away * out), corner.curvature)
                }
                None => (heading, 0.0),
            };
            let bound = (limits.lateral_acceleration / curvature.abs()).sqrt();
            Pose { position: places[i], yaw, time: 0.0, speed: limits.speed.min(bound), curvature }
        })
        .collect();
    if let Some(first) = poses.first_mut() {
        first.speed = 0.0;
    }
    if let Some(last) = poses.last_mut() {
        last.speed = 0.0;
    }
    let reach =
        |speed: f64, length: f64| speed.mul_add(speed, 2.0 * limits.acceleration * length).sqrt();
    for i in 1..poses.len() {
        poses[i].speed = poses[i].speed.min(reach(poses[i - 1].speed, lengths[i - 1]));
    }
    for i in (1..poses.len()).rev() {
        poses[i - 1].speed = poses[i - 1].speed.min(reach(poses[i].speed, lengths[i - 1]));
    }
    for i in 1..poses.len() {
        let (from, to) = (poses[i - 1].speed, poses[i].speed);
        // From rest to rest over a single segment: up to the middle, and down again.
        let time = if from + to > 0.0 {
            2.0 * lengths[i - 1] / (from + to)
        } else {
            rest_to_rest(lengths[i - 1], limits)
        };
        poses[i].time = poses[i - 1].time + time;
    }
    Ok(poses)
}

/// Seconds over a length from rest to rest.
fn rest_to_rest(length: f64, limits: &DrivingLimits) -> f64 {
    let DrivingLimits { speed, acceleration, .. } = *limits;
    let peak = (acceleration * length).sqrt();
    if peak <= speed { 2.0 * peak / acceleration } else { length / speed + speed / acceleration }
}

/// An angle in (−π, π].
fn wrapped(angle: f64) -> f64 {
    let tau = std::f64::consts::TAU;
    let wrapped = angle - tau * (angle / tau).round();
    if wrapped <= -std::f64::consts::PI { wrapped + tau } else { wrapped }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use super::*;

    const LIMITS: DrivingLimits =
        DrivingLimits { speed: 2.0, acceleration: 0.5, lateral_acceleration: 0.8 };

    #[test]
    fn a_straight_line_is_driven_as_on_paper() {
        // 8 m to reach 2 m/s at 0.5 m/s² takes 4 m and 4 s, so does braking; 12 m more at 2 m/s.
        let line = spaced(&Trajectory::from_points(&[[0.0, 0.0], [20.0, 0.0]]), 0.1, 10_000);
        let poses = drive(crate::plane::points(&line), &LIMITS).unwrap();
        let last = poses.last().unwrap();
        assert_eq!(poses.len(), 201);
        assert!((last.time - 14.0).abs() < 1e-6, "{}", last.time);
        assert!((poses[100].speed - 2.0).abs() < 1e-12 && last.speed == 0.0);
        // And with two points only.
        let poses = drive(&[[0.0, 0.0], [20.0, 0.0]], &LIMITS).unwrap();
        assert!((poses[1].time - 14.0).abs() < 1e-9);
    }

    #[test]
    fn limits_hold_on_a_circle_and_headings_are_its_tangents() {
        let place = |i: usize| {
            let angle = -FRAC_PI_2 + PI * i as f64 / 200.0;
            [3.0 * angle.cos(), 3.0 * angle.sin()]
        };
        let points: Vec<[f64; 2]> = (0..=400).map(place).collect();
        let poses = drive(&points, &LIMITS).unwrap();
        for (i, pose) in poses.iter().enumerate().skip(1).take(399) {
            assert!((pose.curvature - 1.0 / 3.0).abs() < 1e-3, "{pose:?}");
            assert!((wrapped(pose.yaw - PI * i as f64 / 200.0)).abs() < 1e-9, "{pose:?}");
        }
        check_limits(&poses);
        assert!((poses[200].speed - (0.8f64 * 3.0).sqrt()).abs() < 1e-3);
    }

    /// A circle of few points, driven at many: no point of it is straight, and none bends more than its arcs.
    #[test]
    fn points_between_corners_lie_on_their_arcs() {
        let place = |i: usize| {
            let angle = -FRAC_PI_2 + PI * i as f64 / 12.0;
            [3.0 * angle.cos(), 3.0 * angle.sin()]
        };
        let few: Vec<[f64; 2]> = (0..=24).map(place).collect();
        let many = spaced(&Trajectory::from_points(&few), 0.05, 10_000);
        let (few, many) =
            (drive(&few, &LIMITS).unwrap(), drive(crate::plane::points(&many), &LIMITS).unwrap());
        check_limits(&many);
        let inner = &many[20..many.len() - 20];
        assert!(inner.iter().all(|pose| (pose.curvature - few[5].curvature).abs() < 1e-6));
        // The heading turns as evenly as the circle's tangent, but for what chords leave out.
        for pair in inner.windows(2) {
            let turned = wrapped(pair[1].yaw - pair[0].yaw);
            let way = distance(&pair[0].position, &pair[1].position);
            assert!((turned / way - 1.0 / 3.0).abs() < 0.02, "{turned} over {way}");
        }
    }

    fn check_limits(poses: &[Pose]) {
        for pair in poses.windows(2) {
            let (a, b) = (&pair[0], &pair[1]);
            assert!(b.speed <= LIMITS.speed + 1e-12);
            assert!(b.speed.powi(2) * b.curvature.abs() <= LIMITS.lateral_acceleration + 1e-9);
            let ds = distance(&a.position, &b.position);
            let acceleration = (b.speed.powi(2) - a.speed.powi(2)).abs() / (2.0 * ds);
            assert!(acceleration <= LIMITS.acceleration + 1e-9, "{acceleration}");
            assert!(b.time > a.time);
        }
    }

    #[test]
    fn corners_slow_down_and_nothing_is_no_number() {
        let path =
            Trajectory::from_points(&[[0.0, 0.0], [5.0, 0.0], [5.0, 0.0], [5.0, 5.0], [5.0, 0.0]]);
        let poses = drive(crate::plane::points(&spaced(&path, 0.5, 1000)), &LIMITS).unwrap();
        check_limits(&poses);
        assert!(poses.iter().all(|pose| pose.time.is_finite() && pose.yaw.is_finite()));
        assert_eq!(drive(&[[1.0, 1.0]], &LIMITS).unwrap().len(), 1);
        assert_eq!(drive(&[], &LIMITS).unwrap().len(), 0);
        for field in ["speed", "acceleration", "lateral_acceleration"] {
            let mut limits = LIMITS;
            match field {
                "speed" => limits.speed = 0.0,
                "acceleration" => limits.acceleration = f64::NAN,
                _ => limits.lateral_acceleration = -1.0,
            }
            assert_eq!(drive(&[], &limits).unwrap_err().field, field);
        }
    }

    #[test]
    fn spacing_is_kept_and_bounded() {
        let path = Trajectory::from_points(&[[0.0, 0.0], [1.0, 0.0], [1.0, 2.05]]);
        let even = spaced(&path, 0.1, 1000);
        assert!(even.segments().all(|(a, b)| distance(a, b) <= 0.1 + 1e-9));
        assert_eq!(even.len(), 1 + 10 + 21);
        assert!(spaced(&path, 1e-9, 100).len() <= 103);
    }
}
