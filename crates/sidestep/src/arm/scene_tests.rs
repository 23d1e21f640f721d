//! What the seam asks: costs and slopes against the formula in f64 and differences, free paths, violations, planning.

use std::collections::HashMap;
use std::sync::Arc;

use super::tests::{arm, configuration, rng, world};
use super::*;
use crate::kernels::Block;
use crate::plan::{Options, Planner, Status, plan};
use crate::profile::Profile;
use crate::scene::{Setting, Task};
use crate::space::vector::{norm, sub};
use crate::space::{Object, Pose, Shape, World};
use crate::trajectory::{ObstacleId, Trajectory, Violation};

/// c of a gap in metres, f64.
fn clearance_cost(epsilon: f64, gap: f64) -> f64 {
    let t = (epsilon - 10.0 * gap).clamp(0.0, epsilon);
    0.5 * t * t / epsilon + (-10.0 * gap).max(0.0)
}

/// The cost of a configuration by the formula, f64.
fn reference(scene: &ArmScene, epsilon: f64, q: &[f64]) -> f64 {
    let (arm, world) = (scene.arm(), scene.world());
    let balls = arm.balls_at(q);
    let mut cost = 0.0;
    for part in arm.parts.iter().filter(|part| part.slot > 0) {
        for ball in &balls[part.balls.clone()] {
            for piece in 0..world.pieces() as u32 {
                let gap = world.distance(piece, ball.center).0 - ball.radius;
                cost += clearance_cost(epsilon, gap);
            }
        }
    }
    for &[a, b] in &arm.pairs {
        for i in arm.parts[a].balls.clone() {
            for j in arm.parts[b].balls.clone() {
                let apart = norm(sub(balls[i].center, balls[j].center));
                let gap = apart - balls[i].radius - balls[j].radius;
                cost += clearance_cost(0.2 * epsilon, gap);
            }
        }
    }
    cost
}

#[test]
fn costs_and_slopes_match_reference() {
    let (mut costly, mut compared) = (0, 0);
    for index in 0..120 {
        let mut rng = rng(50_000 + index);
        let mut arm = arm(&mut rng);
        if index % 3 == 0 {
            arm = arm.with_self_collisions(&[]).unwrap();
        }
        let scene = ArmScene::new(&Arc::new(arm), &Arc::new(world(&mut rng)), &Profile::DEFAULT);
        let (dof, count, epsilon) = (scene.arm().dof(), 21, 1.0_f64);
        let weights: Vec<f32> = (0..count).map(|i| 0.5 + i as f32 / 40.0).collect();
        let mut block = Block::new(dof, weights.clone());
        let all: Vec<Vec<f64>> = (0..count).map(|_| configuration(scene.arm(), &mut rng)).collect();
        for (i, q) in all.iter().enumerate() {
            for (k, &value) in q.iter().enumerate() {
                block.points[k * block.padded + i] = value as f32;
            }
        }
        scene.cost_and_slope(&mut block, epsilon as f32, 2.0, true);
        for (i, q) in all.iter().enumerate() {
            let expected = reference(&scene, epsilon, q);
            let found = f64::from(block.costs[i]);
            assert!(
                (found - expected).abs() < 1e-3 * expected.max(1.0),
                "{index}: {found} {expected}"
            );
            costly += usize::from(expected > 0.0);
            for k in 0..dof {
                // A step that is long beside rounding and short beside the curvature; kinks are where it disagrees
                // with half of itself.
                let difference = |h: f64| {
                    let [mut low, mut high] = [q.clone(), q.clone()];
                    (low[k], high[k]) = (low[k] - h, high[k] + h);
                    (reference(&scene, epsilon, &high) - reference(&scene, epsilon, &low))
                        / (2.0 * h)
                };
                let (wide, narrow) = (difference(1e-5), difference(5e-6));
                if (wide - narrow).abs() > 1e-3 * narrow.abs().max(1.0) {
                    continue;
                }
                let slope =
                    f64::from(block.slopes[k * block.padded + i]) / f64::from(2.0 * weights[i]);
                let error = (slope - narrow).abs() / narrow.abs().max(expected).max(1.0);
                // Where f32 puts a place on the other side of a kink, the slope is that of the other side.
                compared += 1;
                assert!(error < 0.02, "{index}: joint {k}: {slope} against {narrow}");
            }
        }
        assert!(block.costs[count..].iter().all(|cost| cost.is_finite()));
    }
    assert!(costly > 1000 && compared > 8000, "{costly} {compared}");
}

/// A planar arm of three links of 0.4 m between two walls.
fn planar(walls: &[([f64; 3], [f64; 3])]) -> (Arc<Arm>, Arc<World>) {
    let ball = |x: f64| Body {
        origin: Pose::at([x, 0.0, 0.0]).unwrap(),
        shape: BodyShape::Sphere { radius: 0.04 },
    };
    let link = |index: usize| Link {
        name: format!("link {index}"),
        bodies: if index == 0 {
            vec![]
        } else {
            (0..6).map(|i| ball(0.08 * f64::from(i))).collect()
        },
    };
    let joint = |index: usize| Joint {
        name: format!("joint {index}"),
        kind: JointKind::Revolute,
        parent: index,
        child: index + 1,
        origin: Pose::at([if index == 0 { 0.0 } else { 0.4 }, 0.0, 0.0]).unwrap(),
        axis: [0.0, 0.0, 1.0],
        limits: Some(Limits { lower: -2.6, upper: 2.6, velocity: None, effort: None }),
        mimic: None,
    };
    let model =
        Model::new("planar", (0..4).map(link).collect(), (0..3).map(joint).collect()).unwrap();
    let neighbours = [("link 1".into(), "link 2".into()), ("link 2".into(), "link 3".into())];
    let arm = Arm::new(&model, &[], &HashMap::new()).unwrap();
    let walls = walls.iter().enumerate().map(|(index, &(center, half_extents))| {
        let shape = Shape::Box { half_extents };
        Object::new(format!("wall {index}"), vec![(Pose::at(center).unwrap(), shape)])
    });
    let world = World::new(walls.collect()).unwrap();
    (Arc::new(arm.with_self_collisions(&neighbours).unwrap()), Arc::new(world))
}

#[test]
fn every_planner_answers_with_proved_plans() {
    // The straight line meets the box; there is a way with the arm bent.
    let (arm, world) = planar(&[([0.95, 0.0, 0.0], [0.1, 0.1, 1.0])]);
    let setting = Setting::Arm { arm, world };
    let task = Task::new("", setting, vec![-0.9, 0.0, 0.0], vec![0.9, 0.0, 0.0]).unwrap();
    let mut solved = Vec::new();
    for name in ["gd", "momentum", "adam", "chomp", "lbfgs", "lm", "stomp", "rrt-connect", "auto"] {
        let planner: Planner = name.parse().unwrap();
        let options = Options { starts: 3, ..Options::default() };
        let plan = plan(&task, &planner, &options).unwrap();
        if let Some(path) = plan.certified() {
            assert!(crate::certify(&task, path).is_ok(), "{name}");
            solved.push(name);
        }
    }
    assert!(solved.contains(&"rrt-connect") && solved.contains(&"auto"), "{solved:?}");
    assert!(solved.len() >= 4, "{solved:?}");
}

#[test]
fn violations_say_what_is_wrong() {
    let (arm, world) = planar(&[([0.95, 0.0, 0.0], [0.1, 0.1, 1.0])]);
    let scene = ArmScene::new(&arm, &world, &Profile::DEFAULT);
    let object = ObstacleId::Object { link: 3, object: 0 };
    let own = ObstacleId::Link { link: 1, other: 3 };
    for (points, expected) in [
        (vec![[-0.9, 0.0, 0.0], [-1.2, 0.0, 0.0]], Ok(())),
        (vec![], Err(Violation::EmptyTrajectory)),
        (vec![[-0.9, 0.0, f64::NAN]], Err(Violation::NotFinite { point: 0 })),
        (
            vec![[-0.9, 0.0, 0.0], [-0.9, 2.7, 0.0]],
            Err(Violation::OutOfLimits { point: 1, coordinate: 1 }),
        ),
        (
            vec![[0.0, 0.0, 0.0], [0.9, 0.0, 0.0]],
            Err(Violation::StartInCollision { obstacle: object }),
        ),
        (
            vec![[0.9, 0.0, 0.0], [0.0, 0.0, 0.0]],
            Err(Violation::GoalInCollision { obstacle: object }),
        ),
        (
            vec![[-0.9, 0.0, 0.0], [0.9, 0.0, 0.0]],
            Err(Violation::Collision { segment: 0, obstacle: object }),
        ),
        (vec![[-0.9, 2.4, 2.4]], Err(Violation::StartInCollision { obstacle: own })),
    ] {
        let values = points.concat();
        let trajectory = Trajectory::new(3, values);
        assert_eq!(scene.check(&trajectory), expected, "{points:?}");
        if matches!(expected, Err(Violation::Collision { .. })) {
            let hit = scene.hit(&trajectory).unwrap();
            assert_eq!(
                (hit.link.as_str(), &hit.with),
                ("link 3", &certificate::Met::Object("wall 0".into()))
            );
            assert!(hit.depth > 0.0 && hit.t > 0.1 && hit.t < 0.9, "{hit:?}");
        }
    }
    let invalid = Task::new(
        "",
        Setting::Arm { arm: arm.clone(), world: world.clone() },
        vec![0.0; 3],
        vec![0.9, 0.0, 0.0],
    );
    let planner = Planner::RrtConnect(Default::default());
    let answer = plan(&invalid.unwrap(), &planner, &Options::default()).unwrap();
    assert!(matches!(answer.status, Status::Invalid(Violation::StartInCollision { .. })));
    // A margin closes what is open by less.
    let near = [0.25, 0.0, 0.0];
    let trajectory = Trajectory::new(3, near.to_vec());
    let gap = scene.clearance(&trajectory);
    for (margin, free) in [(0.9 * gap, true), (1.1 * gap, false)] {
        let arm = Arc::new(Arm::clone(&arm).with_margin(margin).unwrap());
        let scene = ArmScene::new(&arm, &world, &Profile::DEFAULT);
        assert_eq!(scene.motion_is_free(&near, &near), free, "{margin}");
    }
}

#[test]
fn paths_are_free_where_their_segments_are() {
    let (arm, world) = planar(&[([0.95, 0.0, 0.0], [0.1, 0.1, 1.0])]);
    let scene = ArmScene::new(&arm, &world, &Profile::DEFAULT);
    let (start, goal) = ([-0.9, 0.0, 0.0], [0.9, 0.0, 0.0]);
    let x = [-1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 2.7, 0.0_f32];
    let mut free = [true; 4];
    assert!(!scene.path_is_free(&start, &x, &goal, Some(&mut free)));
    assert_eq!(free, [true, false, false, false]);
    assert!(!scene.path_is_free(&start, &x, &goal, None));
    assert!(scene.path_is_free(&start, &x[..3], &start, None));
}

#[test]
fn links_that_always_touch_are_found() {
    let (arm, _) = planar(&[]);
    let all = Arm::clone(&arm).with_self_collisions(&[]).unwrap();
    // Neighbours overlap at their joint; the first and the third link touch only where the arm is bent.
    let (left, found) = all.without_lasting_contacts();
    let pair = |a: &str, b: &str| (a.to_string(), b.to_string());
    assert_eq!(found, [pair("link 1", "link 2"), pair("link 2", "link 3")]);
    assert_eq!(left.self_collision_pairs().collect::<Vec<_>>(), [("link 1", "link 3")]);
}

#[test]
fn limits_have_a_tolerance() {
    let (arm, world) = planar(&[]);
    let scene = ArmScene::new(&arm, &world, &Profile::DEFAULT);
    for (value, allowed) in [(2.6, true), (2.600_009, true), (2.600_02, false), (-2.600_02, false)]
    {
        let q = [value, 0.0, 0.0];
        assert_eq!(arm.check("start", &q).is_ok(), allowed, "{value}");
        assert_eq!(scene.motion_is_free(&q, &q), allowed, "{value}");
    }
}
