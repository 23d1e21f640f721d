//! The objective once more, plainly: the formula configuration by configuration in f64, as documentation and as the
//! slow twin that the fast path ([`crate::objective`]) is tested and timed against.

use crate::profile::{Averaging, Profile};

/// U and its gradient (`[N x dof]`) at the waypoints `x` (`[N x dof]`, normalised units) between `start` and `goal` (`[dof]`);
/// `obstacle_cost` says what a configuration `[dof]` costs, and the derivative of that.
pub fn cost_and_gradient(
    obstacle_cost: impl Fn(&[f64]) -> (f64, Vec<f64>),
    profile: &Profile,
    start: &[f32],
    goal: &[f32],
    x: &[f32],
) -> (f64, Vec<f64>) {
    let dof = start.len();
    let values: Vec<f64> = [start, x, goal].concat().into_iter().map(f64::from).collect();
    let points: Vec<&[f64]> = values.chunks_exact(dof).collect();
    let (n, s) = (points.len() - 2, profile.substeps);
    let (waypoint_weight, substep_weight) = match profile.averaging {
        Averaging::Pooled => {
            let all = (n + (n + 1) * s) as f64;
            (1.0 / all, 1.0 / all)
        }
        Averaging::Grouped => (1.0 / n as f64, 1.0 / ((n + 1) * s) as f64),
    };
    let mut total = 0.0;
    let mut gradient = vec![0.0; values.len()];
    let mut add_point = |p: &[f64], weight: f64, shares: [(usize, f64); 2]| {
        let (cost, slope) = obstacle_cost(p);
        for (point, share) in shares {
            for k in 0..dof {
                let factor = profile.obstacle_gradient_factor;
                gradient[dof * point + k] += weight * share * slope[k] * factor;
            }
        }
        weight * cost
    };
    for i in 0..=n {
        for j in 1..=s {
            let t = j as f64 / (s + 1) as f64;
            let ends = points[i].iter().zip(points[i + 1]);
            let p: Vec<f64> = ends.map(|(from, to)| from + t * (to - from)).collect();
            total += add_point(&p, substep_weight, [(i, 1.0 - t), (i + 1, t)]);
        }
        if i < n {
            total += add_point(points[i + 1], waypoint_weight, [(i + 1, 1.0), (i + 1, 0.0)]);
        }
    }
    for i in 0..=n {
        for k in 0..dof {
            let step = points[i + 1][k] - points[i][k];
            total += profile.lambda * step * step;
            gradient[dof * i + k] -= 2.0 * profile.lambda * step;
            gradient[dof * (i + 1) + k] += 2.0 * profile.lambda * step;
        }
    }
    (total, gradient[dof..dof * (n + 1)].to_vec())
}

/// c(D) and dc/dD (paper, section I.A).
pub fn clearance_cost(distance: f64, epsilon: f64) -> (f64, f64) {
    if distance < 0.0 {
        (0.5 * epsilon - distance, -1.0)
    } else if distance < epsilon {
        ((distance - epsilon).powi(2) / (2.0 * epsilon), (distance - epsilon) / epsilon)
    } else {
        (0.0, 0.0)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use proptest::prelude::*;

    use super::*;
    use crate::objective::Objective;
    use crate::plane::geometry::{Circle, ConvexPolygon};
    use crate::scene::{Query, Setting};
    use crate::suite::Suite;
    use crate::{Obstacle, Robot, Task, World};

    /// A paper-like task with a circle and a polygon more.
    fn mixed_task(index: usize) -> Task {
        let mut task = Suite::Easy.generate(index + 1, 1000, &Profile::PAPER).remove(index);
        let bounds = task.plane().unwrap().world.bounds();
        let mut obstacles = task.plane().unwrap().world.obstacles().to_vec();
        obstacles.truncate(5);
        obstacles.push(Obstacle::Circle(Circle::new([20.0, 44.0], 7.5).unwrap()));
        let corners = vec![[40.0, 8.0], [55.0, 14.0], [47.0, 25.0]];
        obstacles.push(Obstacle::Polygon(ConvexPolygon::new(corners).unwrap()));
        let world = Arc::new(World::new(bounds, obstacles, None));
        task.setting = Setting::Plane { world, robot: Robot::disc(index as f64 % 3.0).unwrap() };
        task
    }

    /// c at the distance of a place in the plane, and its slope.
    fn obstacle_cost(
        objective: &Objective,
        epsilon: f64,
    ) -> impl Fn(&[f64]) -> (f64, Vec<f64>) + '_ {
        let field = objective.plane().unwrap().scene.field();
        move |p: &[f64]| {
            let (distance, gradient) = field.at([p[0] as f32, p[1] as f32]);
            let (cost, slope) = clearance_cost(distance.into(), epsilon);
            (cost, gradient.map(|g| slope * f64::from(g)).to_vec())
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn objective_matches_reference(
            index in 0usize..20,
            paper in any::<bool>(),
            n in 1usize..30,
            offsets in proptest::collection::vec(-1.5f32..1.5, 60),
        ) {
            let task = mixed_task(index);
            let profile = if paper { Profile::PAPER } else { Profile::DEFAULT };
            let mut objective = Objective::new(&Query::of(&task, &profile), n).unwrap();
            let mut x = vec![0.0; 2 * n];
            objective.straight_line(&mut x);
            x.iter_mut().zip(&offsets).for_each(|(x, o)| *x += o);
            let mut gradient = vec![0.0; 2 * n];
            let cost = objective.cost_and_gradient(&x, &mut gradient).total;
            let cost_of = obstacle_cost(&objective, profile.epsilon);
            let (start, goal) = (objective.start(), objective.goal());
            let (expected, slopes) = cost_and_gradient(cost_of, &profile, start, goal, &x);
            prop_assert!((f64::from(cost) - expected).abs() <= 2e-5 * (1.0 + expected));
            prop_assert_eq!(objective.cost(&x).total, cost);
            for (got, expected) in gradient.iter().zip(slopes) {
                prop_assert!((f64::from(*got) - expected).abs() <= 1e-4 * (1.0 + expected.abs()));
            }
        }

        #[test]
        fn gradient_matches_finite_differences(
            index in 0usize..20,
            offsets in proptest::collection::vec(-1.5f32..1.5, 20),
            k in 0usize..20,
        ) {
            let task = mixed_task(index);
            let objective = Objective::new(&Query::of(&task, &Profile::DEFAULT), 10).unwrap();
            let mut x = vec![0.0; 20];
            objective.straight_line(&mut x);
            x.iter_mut().zip(&offsets).for_each(|(x, o)| *x += o);
            let at = |delta: f32| {
                let mut moved = x.clone();
                moved[k] += delta;
                let cost_of = obstacle_cost(&objective, Profile::DEFAULT.epsilon);
                let (start, goal) = (objective.start(), objective.goal());
                cost_and_gradient(cost_of, &Profile::DEFAULT, start, goal, &moved)
            };
            let h = 2e-3;
            let (low, here, high) = (at(-h), at(0.0), at(h));
            let span = f64::from((x[k] + h) - (x[k] - h));
            let slope = (high.0 - low.0) / span;
            // D has kinks; where one lies in between, the slope is between the one-sided ones.
            let bend = (high.1[k] - low.1[k]).abs();
            prop_assert!(
                (slope - here.1[k]).abs() <= 2e-3 + bend,
                "{} {} {}", slope, here.1[k], bend
            );
        }
    }
}
