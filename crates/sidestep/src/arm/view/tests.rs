use std::sync::Arc;

use super::*;
use crate::objective::Objective;
use crate::profile::Profile;
use crate::rng::{Purpose, stream};
use crate::scene::{Query, Setting, Task};
use crate::suite::arms::{ArmSuite, planar_arm_alone};
use crate::trajectory::waypoints::bend;

fn tasks(count: usize) -> Vec<Task> {
    let arm = Arc::new(planar_arm_alone(4).unwrap());
    let drawn = ArmSuite::PlanarArm.generate(&arm, None, None, count, 1000, &|| {}).unwrap();
    let task = |problem: crate::suite::arms::ArmProblem| {
        let setting = Setting::Arm { arm: arm.clone(), world: problem.world };
        Task::new(problem.name, setting, problem.start, problem.goal).unwrap()
    };
    drawn.into_iter().map(task).collect()
}

fn bent(objective: &Objective, seed: u64) -> Vec<f32> {
    let mut x = vec![0.0; objective.dim()];
    objective.straight_line(&mut x);
    bend(objective.dof(), &mut x, 0.6, &mut stream(seed, Purpose::Start, 0, 0));
    x
}

/// Gaps are those of the balls in f64, and the slopes point where the objective's do.
#[test]
fn what_is_measured_is_there() {
    let (mut along, mut squares) = (0.0, [0.0; 2]);
    for (seed, task) in tasks(12).iter().enumerate() {
        let mut objective = Objective::new(&Query::of(task, &Profile::DEFAULT), 9).unwrap();
        let x = bent(&objective, seed as u64);
        let mut gradient = vec![0.0; x.len()];
        objective.cost_and_gradient(&x, &mut gradient);
        let subject = objective.arm().unwrap();
        let mut sensor = ArmSensor::new(subject);
        sensor.look(subject, &x);
        sensor.slope(subject, &x);
        for (own, exact) in sensor.gradient.iter().zip(&gradient) {
            along += own * exact;
            squares[0] += own * own;
            squares[1] += exact * exact;
        }
        let (arm, world) = (subject.scene.arm(), subject.scene.world());
        for i in 0..9 {
            let q: Vec<f64> = x[4 * i..][..4].iter().map(|&v| f64::from(v)).collect();
            for (k, ball) in arm.balls_at(&q).iter().enumerate() {
                let pieces = 0..world.pieces() as u32;
                let gaps = pieces.map(|piece| world.distance(piece, ball.center).0 - ball.radius);
                let least = gaps.fold(f64::from(HORIZON), f64::min);
                // Each link has 14 balls, of which the 2nd, 6th, 9th and 13th are looked at.
                let place = [1, 5, 8, 12].iter().position(|&seen| seen == k % 14);
                let Some(place) = place else { continue };
                let row = 4 * (k / 14) + place;
                let found = sensor.gaps[row * sensor.points + i * PERIOD + SUBSTEPS];
                assert!((f64::from(found) - least).abs() < 1e-5, "{row} {i}: {found} {least}");
            }
        }
    }
    let cosine = along / (squares[0] * squares[1]).sqrt();
    let ratio = (squares[0] / squares[1]).sqrt();
    assert!(cosine > 0.95 && (0.9..1.1).contains(&ratio), "{cosine} {ratio}");
}

/// The gradient of what is seen is that of its cost: it goes down along it.
#[test]
fn a_network_that_says_nothing_descends() {
    let (mut before, mut after) = (0.0, 0.0);
    for (seed, task) in tasks(12).iter().enumerate() {
        let mut objective = Objective::new(&Query::of(task, &Profile::DEFAULT), 9).unwrap();
        let mut x = bent(&objective, seed as u64);
        before += objective.cost(&x).total;
        let rule = ActionRule { scale: 0.4, limit: 1.6, keep_inside: true };
        let subject = objective.arm().unwrap();
        let (mut sensor, mut view) = (ArmSensor::new(subject), ArmView::new(subject));
        let shape = ArmViewShape::of(subject.scene.arm());
        assert_eq!((shape.dof, shape.balls), (4, 16));
        assert_eq!(ArmViewShape::from_names(&shape.names(), 4), Ok(shape));
        let stride = shape.row_len().next_multiple_of(16);
        let mut rows = vec![f32::NAN; 9 * stride];
        for _ in 0..20 {
            view.encode(subject, &mut sensor, (&x, &[false; 10]), &mut rows, stride);
            for row in rows.chunks(stride) {
                assert!(row[..shape.row_len()].iter().all(|v| v.abs() <= 10.0), "{row:?}");
            }
            view.apply(subject, &rule, |_| &[0.0, f32::NAN, 0.0, 0.0], &mut x);
        }
        after += objective.cost(&x).total;
    }
    assert!(after < 0.5 * before, "{before} {after}");
}

#[test]
fn names_of_views_are_checked() {
    for names in [&["joints"][..], &["joints:0"], &["joints:2000"], &["joints:4", "probes"], &[]] {
        let names: Vec<String> = names.iter().map(|name| name.to_string()).collect();
        let error = ArmViewShape::from_names(&names, 4).unwrap_err();
        assert_eq!(error.field, "observation");
    }
}
