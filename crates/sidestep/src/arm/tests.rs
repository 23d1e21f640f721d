//! Robots made at random: the kernel against its slow twin, bounds against what happens, proofs against dense sampling.

use std::collections::HashMap;
use std::sync::Arc;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::certificate::{Certifier, Verdict};
use super::kinematics::{Program, point};
use super::lanes::Lane;
use super::reach::Reach;
use super::*;
use crate::kernels::{Isa, LANES, dispatch};
use crate::rng::{Purpose, stream};
use crate::space::vector::{Vector, norm, scale, sub};
use crate::space::{Object, Pose, Shape, World};

fn uniform(rng: &mut ChaCha8Rng, low: f64, high: f64) -> f64 {
    low + (high - low) * rng.random::<f64>()
}

fn vector(rng: &mut ChaCha8Rng, size: f64) -> Vector {
    std::array::from_fn(|_| uniform(rng, -size, size))
}

fn pose(rng: &mut ChaCha8Rng, size: f64) -> Pose {
    Pose::from_rpy(vector(rng, 3.0), vector(rng, size)).unwrap()
}

/// A tree of 2 to 9 joints of all kinds, every link with up to three balls; now and then a joint mimics another.
fn model(rng: &mut ChaCha8Rng) -> Model {
    let count = rng.random_range(2..10_usize);
    let mut joints: Vec<Joint> = Vec::new();
    for index in 0..count {
        let kind = match rng.random_range(0..8) {
            0 => JointKind::Fixed,
            1 => JointKind::Prismatic,
            2 => JointKind::Continuous,
            _ => JointKind::Revolute,
        };
        let kind = if index == 0 { JointKind::Revolute } else { kind };
        let axes = [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [0.0, -1.0, 0.0], vector(rng, 1.0)];
        let span = if kind == JointKind::Prismatic { 0.3 } else { 2.8 };
        let limits = Limits { lower: -span, upper: span, velocity: Some(1.0), effort: None };
        let mimics = kind != JointKind::Fixed && index > 1 && rng.random_range(0..6) == 0;
        let mimic = Mimic { joint: 0, multiplier: uniform(rng, -1.5, 1.5), offset: 0.2 };
        joints.push(Joint {
            name: format!("joint {index}"),
            kind,
            // Mostly a chain, at times a branch.
            parent: if rng.random_range(0..5) == 0 { rng.random_range(0..=index) } else { index },
            child: index + 1,
            origin: pose(rng, 0.3),
            axis: axes[rng.random_range(0..4_usize)],
            limits: Some(limits),
            mimic: mimics.then_some(mimic),
        });
    }
    let links = (0..=count).map(|index| {
        let bodies = (0..rng.random_range(0..4_usize)).map(|_| {
            let radius = uniform(rng, 0.02, 0.08);
            Body { origin: pose(rng, 0.15), shape: BodyShape::Sphere { radius } }
        });
        Link { bodies: bodies.collect(), name: format!("link {index}") }
    });
    let links = links.collect();
    Model::new("random", links, joints).unwrap()
}

pub(super) fn arm(rng: &mut ChaCha8Rng) -> Arm {
    Arm::new(&model(rng), &[], &HashMap::new()).unwrap()
}

pub(super) fn configuration(arm: &Arm, rng: &mut ChaCha8Rng) -> Vec<f64> {
    arm.joints().iter().map(|joint| uniform(rng, joint.lower, joint.upper)).collect()
}

fn between(a: &[f64], b: &[f64], t: f64) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + t * (b - a)).collect()
}

pub(super) fn rng(index: u64) -> ChaCha8Rng {
    stream(77, Purpose::Task, index, 0)
}

dispatch! {
    fn balls_block(arm: &Arm, program: &Program, q: &[Lane], out: &mut [[Lane; 3]]) = balls_body;
}

#[inline(always)]
fn balls_body<const ISA: u8>(arm: &Arm, program: &Program, q: &[Lane], out: &mut [[Lane; 3]]) {
    let mut frames = vec![[[0.0; LANES]; 12]; program.frames()];
    program.place::<ISA>(q, &mut frames);
    for part in &arm.parts {
        for ball in part.balls.clone() {
            let center = arm.balls[ball].center.map(|v| v as f32);
            point::<ISA>(&frames[part.slot], center, &mut out[ball]);
        }
    }
}

#[test]
fn block_matches_reference() {
    let mut worst = 0.0_f64;
    for index in 0..200 {
        let mut rng = rng(index);
        let arm = arm(&mut rng);
        let program = Program::new(&arm);
        let configurations: Vec<Vec<f64>> =
            (0..LANES).map(|_| configuration(&arm, &mut rng)).collect();
        let q: Vec<Lane> = (0..arm.dof())
            .map(|k| std::array::from_fn(|lane| configurations[lane][k] as f32))
            .collect();
        let mut answers = Vec::new();
        for isa in Isa::available() {
            let mut out = vec![[[0.0; LANES]; 3]; arm.ball_count()];
            balls_block(isa, &arm, &program, &q, &mut out);
            for lane in 0..LANES {
                for (ball, exact) in arm.balls_at(&configurations[lane]).iter().enumerate() {
                    let found = [0, 1, 2].map(|axis: usize| f64::from(out[ball][axis][lane]));
                    let error = norm(sub(found, exact.center));
                    assert!(error <= program.rounding, "{index}: {error} of {}", program.rounding);
                    worst = worst.max(error / program.rounding);
                }
            }
            answers.push(out);
        }
        for pair in answers[1..].windows(2) {
            assert!(pair[0] == pair[1], "{index}: instruction sets differ");
        }
    }
    assert!(worst > 0.01, "the bound says too little: {worst}");
}

#[test]
fn balls_leave_their_chords_by_no_more_than_their_bulge() {
    let mut tightest = 0.0_f64;
    for index in 0..300 {
        let mut rng = rng(1000 + index);
        let arm = arm(&mut rng);
        let reach = Reach::new(&arm);
        let (a, b) = (configuration(&arm, &mut rng), configuration(&arm, &mut rng));
        let part = uniform(&mut rng, 0.02, 1.0);
        let b = between(&a, &b, part);
        let delta: Vec<f64> = a.iter().zip(&b).map(|(a, b)| b - a).collect();
        let mut bulge = vec![0.0; reach.stride()];
        let mut turned = vec![0.0; arm.chain.slots.len() + 1];
        let mut weights = vec![0.0; turned.len() - 1];
        let speed = reach.bulges(Isa::detect(), &delta, &mut turned, &mut weights, &mut bulge);
        let (first, last) = (arm.balls_at(&a), arm.balls_at(&b));
        let mut before = first.clone();
        for step in 1..=200 {
            let t = f64::from(step) / 200.0;
            let now = arm.balls_at(&between(&a, &b, t));
            for ball in 0..arm.ball_count() {
                let [from, to] = [first[ball].center, last[ball].center];
                let chord: Vector = std::array::from_fn(|k| from[k] + t * (to[k] - from[k]));
                let off = norm(sub(now[ball].center, chord));
                let bound = f64::from(bulge[arm.parts.len() + ball]);
                assert!(off <= bound + 1e-12, "{index}: {off} over {bound}");
                tightest = tightest.max(off / bound.max(1e-9));
                let travel = norm(sub(now[ball].center, before[ball].center));
                assert!(travel <= speed / 200.0 + 1e-12, "{index}: faster than {speed}");
            }
            before = now;
        }
    }
    assert!(tightest > 0.5, "the bound says too little: {tightest}");
}

/// A world of up to twelve boxes, balls, cylinders and capsules around the robot.
pub(super) fn world(rng: &mut ChaCha8Rng) -> World {
    let count = rng.random_range(0..12);
    let objects = (0..count).map(|index| {
        let radius = uniform(rng, 0.02, 0.25);
        let half_length = uniform(rng, 0.05, 0.4);
        let shape = match rng.random_range(0..4) {
            0 => Shape::Box { half_extents: [radius, half_length, uniform(rng, 0.01, 0.3)] },
            1 => Shape::Sphere { radius },
            2 => Shape::Cylinder { radius, half_length },
            _ => Shape::Capsule { radius, half_length },
        };
        Object::new(format!("object {index}"), vec![(pose(rng, 0.9), shape)])
    });
    World::new(objects.collect()).unwrap()
}

/// How far the nearest thing is, f64: over all balls and pieces, and all pairs that are checked.
fn clearance(certifier: &Certifier, configuration: &[f64]) -> f64 {
    let (arm, world) = (certifier.arm(), certifier.world());
    let balls = arm.balls_at(configuration);
    let mut least = f64::INFINITY;
    for ball in &balls {
        for piece in 0..world.pieces() as u32 {
            least = least.min(world.distance(piece, ball.center).0 - ball.radius);
        }
    }
    for &[a, b] in &arm.pairs {
        for i in arm.parts[a].balls.clone() {
            for j in arm.parts[b].balls.clone() {
                let apart = norm(sub(balls[i].center, balls[j].center));
                least = least.min(apart - balls[i].radius - balls[j].radius);
            }
        }
    }
    least
}

#[test]
fn never_says_free_where_dense_sampling_hits() {
    let (mut free, mut blocked, mut undecided) = (0, 0, 0);
    for index in 0..1500 {
        let mut rng = rng(10_000 + index);
        let mut arm = arm(&mut rng);
        if index % 2 == 0 {
            // Neighbours touch each other at the joint.
            let neighbours: Vec<(String, String)> = (0..9)
                .flat_map(|a| (a + 1..10).map(move |b| (a, b)))
                .filter(|(a, b)| b - a < 3)
                .map(|(a, b)| (format!("link {a}"), format!("link {b}")))
                .filter(|(_, b)| arm.link_pose(b, &vec![0.0; arm.dof()]).is_some())
                .collect();
            arm = arm.with_self_collisions(&neighbours).unwrap();
        }
        let certifier = Certifier::new(Arc::new(arm), Arc::new(world(&mut rng)));
        let mut work = certifier.work();
        let (a, b) =
            (configuration(certifier.arm(), &mut rng), configuration(certifier.arm(), &mut rng));
        let part = uniform(&mut rng, 0.0, 1.0).powi(2);
        let b = between(&a, &b, part);
        let dense = || {
            let samples = 600;
            (0..=samples)
                .map(|k| clearance(&certifier, &between(&a, &b, f64::from(k) / f64::from(samples))))
                .fold(f64::INFINITY, f64::min)
        };
        match certifier.judge(&a, &b, &mut work) {
            Verdict::Free => {
                free += 1;
                let least = dense();
                assert!(least > 0.0, "{index}: free, but {least}");
            }
            Verdict::Blocked(hit) => {
                blocked += 1;
                assert!(hit.depth > 0.0, "{index}: {hit:?}");
                if !hit.configuration.is_empty() {
                    assert!(
                        clearance(&certifier, &hit.configuration) <= -hit.depth + 1e-9,
                        "{index}"
                    );
                }
            }
            Verdict::Undecided(_) => undecided += 1,
        }
        assert_eq!(
            certifier.motion_is_free(&a, &b, &mut work),
            matches!(certifier.judge(&a, &b, &mut work), Verdict::Free)
        );
    }
    assert!(free > 200 && blocked > 200 && undecided < 5, "{free} {blocked} {undecided}");
}

/// A planar arm of one link, and a wall that its tip passes at a distance.
#[test]
fn motions_that_all_but_touch_are_told_apart() {
    let tip = Body {
        origin: Pose::at([1.0, 0.0, 0.0]).unwrap(),
        shape: BodyShape::Sphere { radius: 0.1 },
    };
    let links = vec![
        Link { name: "base".into(), bodies: vec![] },
        Link { name: "arm".into(), bodies: vec![tip] },
    ];
    let turn = Joint {
        name: "turn".into(),
        kind: JointKind::Revolute,
        parent: 0,
        child: 1,
        origin: Pose::IDENTITY,
        axis: [0.0, 0.0, 1.0],
        limits: Some(Limits { lower: -3.0, upper: 3.0, velocity: None, effort: None }),
        mimic: None,
    };
    let model = Model::new("planar", links, vec![turn]).unwrap();
    let arm = Arc::new(Arm::new(&model, &[], &HashMap::new()).unwrap());
    // The tip's ball reaches to x = 1.1; the wall begins `gap` behind that.
    for (gap, expected) in [
        (0.1, "free"),
        (1e-3, "free"),
        (2e-4, "free"),
        (0.0, "not"),
        (-2e-4, "blocked"),
        (-0.1, "blocked"),
    ] {
        let wall = Shape::Box { half_extents: [0.5, 2.0, 0.5] };
        let at = Pose::at([1.6 + gap, 0.0, 0.0]).unwrap();
        let world = World::new(vec![Object::new("wall", vec![(at, wall)])]).unwrap();
        let certifier = Certifier::new(Arc::clone(&arm), Arc::new(world));
        let verdict = certifier.judge(&[-1.1], &[1.37], &mut certifier.work());
        let found = match &verdict {
            Verdict::Free => "free",
            Verdict::Blocked(hit) if hit.depth > 0.0 => {
                assert_eq!(
                    (hit.link.as_str(), &hit.with),
                    ("arm", &certificate::Met::Object("wall".into()))
                );
                "blocked"
            }
            _ => "not",
        };
        assert_eq!(found, expected, "{gap}: {verdict:?}");
    }
}

#[test]
fn models_are_checked() {
    let link = |name: &str| Link { name: name.into(), bodies: vec![] };
    let joint = |name: &str, parent, child| Joint {
        name: name.into(),
        kind: JointKind::Revolute,
        parent,
        child,
        origin: Pose::IDENTITY,
        axis: [0.0, 0.0, 2.0],
        limits: Some(Limits { lower: -1.0, upper: 1.0, velocity: None, effort: None }),
        mimic: None,
    };
    let links = |count: usize| (0..count).map(|i| link(&format!("{i}"))).collect::<Vec<_>>();
    let good = Model::new("", links(2), vec![joint("a", 0, 1)]).unwrap();
    assert_eq!(good.joints()[0].axis, [0.0, 0.0, 1.0]);
    let mimic =
        |j: Joint, joint| Joint { mimic: Some(Mimic { joint, multiplier: 1.0, offset: 0.0 }), ..j };
    let limits = |j: Joint, lower, upper| Joint {
        limits: Some(Limits { lower, upper, velocity: None, effort: None }),
        ..j
    };
    for (links, joints, field) in [
        (vec![], vec![], "links"),
        (vec![link("x"), link("x")], vec![joint("a", 0, 1)], "links"),
        (links(3), vec![joint("a", 0, 1), joint("a", 1, 2)], "joints"),
        (links(3), vec![joint("a", 0, 1)], "links"),
        (links(2), vec![joint("a", 0, 2)], "joint a.child"),
        (links(3), vec![joint("a", 1, 2), joint("b", 2, 1)], "links"),
        (links(2), vec![joint("a", 0, 1), joint("b", 1, 0)], "links"),
        (links(3), vec![joint("a", 0, 2), joint("b", 1, 2)], "joint b.child"),
        (links(2), vec![Joint { axis: [0.0; 3], ..joint("a", 0, 1) }], "joint a.axis"),
        (links(2), vec![Joint { limits: None, ..joint("a", 0, 1) }], "joint a.limit"),
        (links(2), vec![limits(joint("a", 0, 1), 1.0, -1.0)], "joint a.limit.upper"),
        (links(2), vec![limits(joint("a", 0, 1), f64::NAN, 1.0)], "joint a.limit.lower"),
        (links(2), vec![mimic(joint("a", 0, 1), 0)], "joint a.mimic"),
        (links(2), vec![mimic(joint("a", 0, 1), 7)], "joint a.mimic.joint"),
        (links(3), vec![mimic(joint("a", 0, 1), 1), mimic(joint("b", 1, 2), 0)], "joint a.mimic"),
    ] {
        assert_eq!(Model::new("", links, joints).unwrap_err().field, field);
    }
    for (names, field) in [(vec!["b"], "joints[0]"), (vec!["a", "a"], "joints[1]")] {
        assert_eq!(Arm::new(&good, &names, &HashMap::new()).unwrap_err().field, field);
    }
    let arm = Arm::new(&good, &["a"], &HashMap::new()).unwrap();
    for (q, field) in [(vec![], "start"), (vec![1.5], "start.a"), (vec![f64::NAN], "start.a")] {
        assert_eq!(arm.check("start", &q).unwrap_err().field, field);
    }
    assert!(arm.with_self_collisions(&[("0".into(), "7".into())]).is_err());
}

#[test]
fn held_joints_and_mimics_move_as_they_should() {
    let mut rng = rng(5);
    for _ in 0..100 {
        let model = model(&mut rng);
        let all = Arm::new(&model, &[], &HashMap::new()).unwrap();
        let q = configuration(&all, &mut rng);
        // Holding all joints but the first where they are changes nothing.
        let held: HashMap<String, f64> = all.joints()[1..]
            .iter()
            .zip(&q[1..])
            .map(|(joint, &value)| (joint.name.clone(), value))
            .collect();
        let one = Arm::new(&model, &[&all.joints()[0].name], &held).unwrap();
        for link in model.links() {
            let [a, b] = [all.link_pose(&link.name, &q), one.link_pose(&link.name, &q[..1])];
            let [a, b] = [a.unwrap(), b.unwrap()];
            for p in [[0.0; 3], scale([1.0, 2.0, 3.0], 0.1)] {
                assert!(norm(sub(a.apply(p), b.apply(p))) < 1e-9, "{}", link.name);
            }
        }
    }
}
