//! Configurations that put a link at a pose.
//!
//! Levenberg and Marquardt's method on the six errors e of position (m) and rotation (rad, as a
//! rotation vector): `Δq = Jᵀ (J Jᵀ + λ I)⁻¹ e` with λ in proportion to |e|² (T. Sugihara,
//! "Solvability-unconcerned inverse kinematics by the Levenberg-Marquardt method", IEEE T-RO 27(5),
//! 2011), clamped to the limits, from one start after another drawn within the limits. Different
//! starts find different branches; that none finds one proves nothing.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::robot::Arm;
use crate::error::InvalidInput;
use crate::space::Pose;
use crate::space::vector::{Vector, cross, norm, scale, sub};

/// Errors below this (m, rad) count as none.
const CLOSE: f64 = 1e-6;
/// Steps from one start.
const STEPS: usize = 60;
/// λ over |e|², and its least value.
const DAMPING: f64 = 0.05;
const LEAST_DAMPING: f64 = 1e-9;
/// Solutions nearer than this in every joint are one.
const SAME: f64 = 1e-3;

/// A link, and a frame in it that is to be put somewhere.
#[derive(Debug, Clone, PartialEq)]
pub struct Tool {
    /// The link's name.
    pub link: String,
    /// The frame in the link's.
    pub frame: Pose,
}

impl Arm {
    /// Configurations within the limits that put `tool` at `target` (in the root link's frame),
    /// each found from a start drawn from `rng`, `starts` of them; different ones only, in the
    /// order in which they were found.
    ///
    /// # Errors
    /// If the robot has no link of that name.
    pub fn inverse_kinematics(
        &self,
        tool: &Tool,
        target: &Pose,
        starts: usize,
        rng: &mut ChaCha8Rng,
    ) -> Result<Vec<Vec<f64>>, InvalidInput> {
        let Some(link) = self.link_names.iter().position(|name| *name == tool.link) else {
            let found = format!("{:?}", tool.link);
            return Err(InvalidInput::new("tool.link", found, "a link of the robot"));
        };
        let mut solutions: Vec<Vec<f64>> = Vec::new();
        for _ in 0..starts {
            let mut q = self.drawn(rng);
            if self.approach(link, &tool.frame, target, &mut q) {
                let same =
                    |other: &Vec<f64>| q.iter().zip(other).all(|(a, b)| (a - b).abs() < SAME);
                if !solutions.iter().any(same) {
                    solutions.push(q);
                }
            }
        }
        Ok(solutions)
    }

    /// A configuration uniformly within the limits.
    pub fn drawn(&self, rng: &mut ChaCha8Rng) -> Vec<f64> {
        let joints = self.joints().iter();
        joints
            .map(|joint| joint.lower + (joint.upper - joint.lower) * rng.random::<f64>())
            .collect()
    }

    /// Walks to the target; whether it got there.
    fn approach(&self, link: usize, frame: &Pose, target: &Pose, q: &mut [f64]) -> bool {
        let mut columns = vec![[0.0; 6]; q.len()];
        for _ in 0..STEPS {
            let error = self.error_and_jacobian(link, frame, target, q, &mut columns);
            let square: f64 = error.iter().map(|e| e * e).sum();
            if square.sqrt() < CLOSE {
                return true;
            }
            let mut normal = [[0.0; 6]; 6];
            for column in &columns {
                for (row, a) in normal.iter_mut().zip(column) {
                    for (entry, b) in row.iter_mut().zip(column) {
                        *entry += a * b;
                    }
                }
            }
            for (i, row) in normal.iter_mut().enumerate() {
                row[i] += DAMPING * square + LEAST_DAMPING;
            }
            let Some(y) = solve(normal, error) else { return false };
            for ((q, column), joint) in q.iter_mut().zip(&columns).zip(self.joints()) {
                let step: f64 = column.iter().zip(&y).map(|(a, b)| a * b).sum();
                *q = (*q + step).clamp(joint.lower, joint.upper);
            }
        }
        false
    }

    /// What the frame lacks to the target, and how each coordinate moves it:
    /// `[coordinate][position, rotation]`.
    fn error_and_jacobian(
        &self,
        link: usize,
        frame: &Pose,
        target: &Pose,
        q: &[f64],
        columns: &mut [[f64; 6]],
    ) -> [f64; 6] {
        let frames = self.chain.frames(q);
        let (link_slot, place) = &self.chain.links[link];
        let at = frames[*link_slot].compose(place).compose(frame);
        let position = at.translation();
        columns.fill([0.0; 6]);
        let mut slot = *link_slot;
        while slot > 0 {
            let joint = &self.chain.slots[slot - 1];
            let axis = frames[slot].rotate([0.0, 0.0, joint.multiplier]);
            let arm = sub(position, frames[slot].translation());
            let (linear, angular) =
                if joint.prismatic { (axis, [0.0; 3]) } else { (cross(axis, arm), axis) };
            let column = &mut columns[joint.coordinate];
            for k in 0..3 {
                column[k] += linear[k];
                column[3 + k] += angular[k];
            }
            slot = joint.parent;
        }
        let [x, y, z] = sub(target.translation(), position);
        let [a, b, c] = rotation_vector(&target.compose(&at.inverse()));
        [x, y, z, a, b, c]
    }
}

/// The axis of a pose's rotation times its angle, at most π.
fn rotation_vector(pose: &Pose) -> Vector {
    let [w, x, y, z] = pose.wxyz();
    let v = [x, y, z];
    let sine = norm(v);
    if sine < 1e-12 { scale(v, 2.0) } else { scale(v, 2.0 * sine.atan2(w) / sine) }
}

/// Solves a symmetric positive definite system by Cholesky's method; nothing if it is not one.
fn solve(mut a: [[f64; 6]; 6], mut b: [f64; 6]) -> Option<[f64; 6]> {
    for i in 0..6 {
        for j in 0..=i {
            let sum: f64 = (0..j).map(|k| a[i][k] * a[j][k]).sum();
            let rest = a[i][j] - sum;
            if i != j {
                a[i][j] = rest / a[j][j];
            } else if rest > 0.0 {
                a[i][i] = rest.sqrt();
            } else {
                return None;
            }
        }
    }
    for i in 0..6 {
        let sum: f64 = (0..i).map(|k| a[i][k] * b[k]).sum();
        b[i] = (b[i] - sum) / a[i][i];
    }
    for i in (0..6).rev() {
        let sum: f64 = (i + 1..6).map(|k| a[k][i] * b[k]).sum();
        b[i] = (b[i] - sum) / a[i][i];
    }
    Some(b)
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use super::super::{Body, BodyShape, Joint, JointKind, Limits, Link, Mimic, Model};
    use super::*;
    use crate::rng::{Purpose, stream};

    /// Six joints like those of many industrial arms, a ball on each link, reach 1.1 m; `gripper`
    /// rides on a seventh joint that mimics the last.
    fn six_joints() -> Arm {
        let (y, z) = ([0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
        let places = [
            (z, [0.0, 0.0, 0.1]),
            (y, [0.0, 0.0, 0.1]),
            (y, [0.45, 0.0, 0.0]),
            (y, [0.4, 0.0, 0.0]),
            (z, [0.0, 0.1, 0.0]),
            (y, [0.0, 0.0, 0.08]),
            (z, [0.0, 0.05, 0.0]),
        ];
        let limits = Limits { lower: -3.0, upper: 3.0, velocity: None, effort: None };
        let joints = places.iter().enumerate().map(|(i, &(axis, at))| Joint {
            name: format!("joint {i}"),
            kind: JointKind::Revolute,
            parent: i,
            child: i + 1,
            origin: Pose::at(at).unwrap(),
            axis,
            limits: Some(limits),
            mimic: (i == 6).then_some(Mimic { joint: 5, multiplier: 0.5, offset: 0.1 }),
        });
        let ball = Body { origin: Pose::IDENTITY, shape: BodyShape::Sphere { radius: 0.04 } };
        let links = (0..8).map(|i| Link {
            name: if i == 7 { "gripper".into() } else { format!("link {i}") },
            bodies: vec![ball.clone()],
        });
        let model = Model::new("six", links.collect(), joints.collect()).unwrap();
        Arm::new(&model, &[], &HashMap::new()).unwrap()
    }

    fn tool() -> Tool {
        let frame = Pose::from_rpy([0.3, -0.2, 0.5], [0.05, 0.0, 0.1]).unwrap();
        Tool { link: "gripper".into(), frame }
    }

    #[test]
    fn jacobian_matches_finite_differences() {
        let arm = six_joints();
        let link = arm.link_names.iter().position(|name| name == "gripper").unwrap();
        for index in 0..50 {
            let mut rng = stream(1, Purpose::Task, index, 0);
            let q = arm.drawn(&mut rng);
            let at = |q: &[f64]| arm.link_pose("gripper", q).unwrap().compose(&tool().frame);
            let mut columns = vec![[0.0; 6]; 6];
            let here = at(&q);
            let error = arm.error_and_jacobian(link, &tool().frame, &here, &q, &mut columns);
            assert!(error.iter().all(|e| e.abs() < 1e-7), "{error:?}");
            for (k, column) in columns.iter().enumerate() {
                let mut moved = q.clone();
                moved[k] += 1e-6;
                let moved = at(&moved);
                let linear = scale(sub(moved.translation(), here.translation()), 1e6);
                let angular = scale(rotation_vector(&moved.compose(&here.inverse())), 1e6);
                for axis in 0..3 {
                    assert!((linear[axis] - column[axis]).abs() < 1e-4);
                    assert!((angular[axis] - column[3 + axis]).abs() < 1e-4);
                }
            }
        }
    }

    #[test]
    fn finds_what_can_be_reached() {
        let arm = six_joints();
        let (mut found, mut branches) = (0, 0);
        for index in 0..100 {
            let mut rng = stream(2, Purpose::Task, index, 0);
            let q = arm.drawn(&mut rng);
            let target = arm.link_pose("gripper", &q).unwrap().compose(&tool().frame);
            let solutions = arm.inverse_kinematics(&tool(), &target, 20, &mut rng).unwrap();
            for solution in &solutions {
                arm.check("solution", solution).unwrap();
                let there = arm.link_pose("gripper", solution).unwrap().compose(&tool().frame);
                let off = target.compose(&there.inverse());
                assert!(norm(sub(there.translation(), target.translation())) < 2e-6);
                assert!(norm(rotation_vector(&off)) < 2e-6);
            }
            found += usize::from(!solutions.is_empty());
            branches += solutions.len();
        }
        assert!(found >= 95 && branches > 200, "{found} reached, {branches} ways");
        let far = Pose::at([5.0, 0.0, 0.0]).unwrap();
        let mut rng = stream(3, Purpose::Task, 0, 0);
        assert!(arm.inverse_kinematics(&tool(), &far, 5, &mut rng).unwrap().is_empty());
        let nobody = Tool { link: "nobody".into(), ..tool() };
        let error = arm.inverse_kinematics(&nobody, &far, 1, &mut rng).unwrap_err();
        assert_eq!(error.field, "tool.link");
    }
}
