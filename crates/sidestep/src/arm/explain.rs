//! What is wrong with a motion of a robot with joints, in the words of its files: links, objects, joints.

use super::certificate::{Hit, Met};
use super::scene::ArmScene;
use crate::trajectory::{Trajectory, Violation};

/// A violation of `trajectory` (rad or m) in words: which joint is outside which limits, or which link meets
/// what, where and how deep.
pub fn explain(scene: &ArmScene, trajectory: &Trajectory, violation: &Violation) -> String {
    let joints = scene.arm().joints();
    match violation {
        Violation::OutOfLimits { point, coordinate } => {
            let value = trajectory.configurations().nth(*point).map(|values| values[*coordinate]);
            match (joints.get(*coordinate), value) {
                (Some(joint), Some(value)) => {
                    let count = trajectory.configurations().count();
                    let place = match point {
                        0 => "the start".into(),
                        point if point + 1 == count => "the goal".into(),
                        point => format!("point {point}"),
                    };
                    let (lower, upper) = (joint.lower, joint.upper);
                    format!("{place} has {} at {value}, outside {lower} to {upper}", joint.name)
                }
                _ => violation.to_string(),
            }
        }
        _ => match scene.hit(trajectory) {
            Some(hit) => format!("{}: {}", place(violation), describe(&hit)),
            None => violation.to_string(),
        },
    }
}

/// The same of a question's ends alone: what is wrong with the start, or with the goal.
pub fn explain_ends(scene: &ArmScene, ends: [&[f64]; 2], violation: &Violation) -> String {
    let [start, goal] = ends;
    let resting = match violation {
        Violation::GoalInCollision { .. } => goal,
        Violation::OutOfLimits { .. } => {
            return explain(scene, &Trajectory::new(start.len(), ends.concat()), violation);
        }
        _ => start,
    };
    explain(scene, &Trajectory::new(start.len(), [resting, resting].concat()), violation)
}

fn place(violation: &Violation) -> String {
    match violation {
        Violation::StartInCollision { .. } => "the start is in collision".into(),
        Violation::GoalInCollision { .. } => "the goal is in collision".into(),
        Violation::Collision { segment, .. } => format!("segment {segment} collides"),
        other => other.to_string(),
    }
}

/// A collision in words.
fn describe(hit: &Hit) -> String {
    let with = match &hit.with {
        Met::Object(name) => format!("the object {name:?}"),
        Met::Link(name) => format!("the link {name}"),
    };
    let depth = if hit.depth >= 0.0 {
        format!("{:.1} mm deep in", 1e3 * hit.depth)
    } else {
        format!("only {:.1} mm from", -1e3 * hit.depth)
    };
    let numbers: Vec<String> = hit.configuration.iter().map(|v| format!("{v:.4}")).collect();
    format!("the link {} is {depth} {with} at [{}]", hit.link, numbers.join(", "))
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;
    use std::sync::Arc;

    use super::*;
    use crate::arm::model::{Joint, JointKind, Limits, Link, Model};
    use crate::arm::{Arm, Body, BodyShape};
    use crate::profile::Profile;
    use crate::space::{Object, Pose, Shape, World};

    #[test]
    fn names_links_objects_and_joints() {
        let ball = Body {
            origin: Pose::at([1.0, 0.0, 0.0]).unwrap(),
            shape: BodyShape::Sphere { radius: 0.1 },
        };
        let links = vec![
            Link { name: "base".into(), bodies: vec![] },
            Link { name: "boom".into(), bodies: vec![ball] },
        ];
        let joint = Joint {
            name: "turn".into(),
            kind: JointKind::Revolute,
            parent: 0,
            child: 1,
            origin: Pose::IDENTITY,
            axis: [0.0, 0.0, 1.0],
            limits: Some(Limits { lower: -2.0, upper: 2.0, velocity: None, effort: None }),
            mimic: None,
        };
        let model = Model::new("m", links, vec![joint]).unwrap();
        let arm = Arc::new(Arm::new(&model, &[], &HashMap::new()).unwrap());
        let post = Object::new(
            "post",
            vec![(Pose::at([0.0, 1.0, 0.0]).unwrap(), Shape::sphere(0.2).unwrap())],
        );
        let world = Arc::new(World::new(vec![post]).unwrap());
        let scene = ArmScene::new(&arm, &world, &Profile::DEFAULT);
        let told = |values: &[f64]| {
            let trajectory = Trajectory::new(1, values.to_vec());
            explain(&scene, &trajectory, &scene.check(&trajectory).unwrap_err())
        };
        let start = told(&[std::f64::consts::FRAC_PI_2, 0.0]);
        let words =
            "the start is in collision: the link boom is 300.0 mm deep in the object \"post\" at [";
        assert!(start.starts_with(words), "{start}");
        let half = std::f64::consts::FRAC_PI_2;
        let goal = Trajectory::new(1, vec![0.0, half]);
        let words = explain_ends(&scene, [&[0.0], &[half]], &scene.check(&goal).unwrap_err());
        assert!(
            words.starts_with("the goal is in collision: the link boom is 300.0 mm"),
            "{words}"
        );
        assert!(told(&[0.0, 1.9]).starts_with("segment 0 collides: the link boom is "));
        assert_eq!(told(&[0.0, 2.5]), "the goal has turn at 2.5, outside -2 to 2");
    }
}
