//! Planar arms of two and three joints against an exhaustive grid of their configurations.
//!
//! The grid knows nothing of the library's kinematics, bounds and proofs: angles add up, links are the balls that the arm is made
//! of, and boxes are measured here. Every cell is looked at in its middle. What is clear by more than the arm can move to the
//! next middle is open; what is in collision by more than it can move within the cell is shut. Where open cells join start and
//! goal there is a way, and a plan must be found; where shut ones separate them there is none. Between the two the grid is too
//! coarse to say, and that may be so of few problems only.

#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout, reason = "a test")]

use std::sync::Arc;

use sidestep::plan::{Options, Planner, plan};
use sidestep::scene::{Setting, Task};
use sidestep::space::{Shape, World};
use sidestep::suite::arms::{ArmSuite, planar_arm_alone};
use sidestep::{Profile, Status, scene::Query};

const TURN: f64 = 2.9;
const RADIUS: f64 = 0.02;
const REACH: f64 = 1.0;

/// What a cell is.
#[derive(Clone, Copy, PartialEq)]
enum Cell {
    /// All of it is free.
    Open,
    /// All of it is in collision.
    Shut,
    /// The middle alone does not say.
    Unclear,
}

/// The cell of half width `half` (rad) around a configuration.
fn judge(q: &[f64], half: f64, world: &World) -> Cell {
    let length = (REACH - RADIUS) / q.len() as f64;
    let steps = (length / RADIUS).ceil() as usize;
    let (mut at, mut angle) = ([0.0, 0.0], 0.0);
    // Of each link the balls' places, and how far each moves when all joints turn by `half`: it is no farther from a joint than the
    // links between them are long.
    let mut links: Vec<Vec<([f64; 2], f64)>> = Vec::new();
    for (k, turn) in q.iter().enumerate() {
        angle += turn;
        let (sin, cos) = f64::sin_cos(angle);
        links.push(
            (0..=steps)
                .map(|i| {
                    let along = length * i as f64 / steps as f64;
                    let travel: f64 = (0..=k).map(|j| half * (along + length * j as f64)).sum();
                    ([at[0] + cos * along, at[1] + sin * along], travel)
                })
                .collect(),
        );
        at = [at[0] + cos * length, at[1] + sin * length];
    }
    let mut cell = Cell::Open;
    // Whether this settles it.
    let mut see = |gap: f64, travel: f64| {
        if gap < -travel {
            cell = Cell::Shut;
        } else if gap <= travel && cell == Cell::Open {
            cell = Cell::Unclear;
        }
        cell == Cell::Shut
    };
    for object in world.objects() {
        for (pose, shape) in object.shapes() {
            let Shape::Box { half_extents } = shape else { panic!("a box") };
            let ([x_axis, y_axis, _], center) = (pose.rotation(), pose.translation());
            let gap = |[x, y]: [f64; 2]| {
                let away = [x - center[0], y - center[1]];
                // The boxes stand upright: their frame is turned about z alone.
                let along = [
                    x_axis[0] * away[0] + y_axis[0] * away[1],
                    x_axis[1] * away[0] + y_axis[1] * away[1],
                    -center[2],
                ];
                let out = [0, 1, 2].map(|k| f64::abs(along[k]) - half_extents[k]);
                let outside = out.map(|v| v.max(0.0)).iter().map(|v| v * v).sum::<f64>().sqrt();
                outside + out.iter().copied().fold(f64::NEG_INFINITY, f64::max).min(0.0) - RADIUS
            };
            for link in &links {
                let ((first, _), (last, most)) = (link[0], link[steps]);
                let middle = [0, 1].map(|k| 0.5 * (first[k] + last[k]));
                if gap(middle) <= 0.5 * length + most
                    && link.iter().any(|&(place, travel)| see(gap(place), travel))
                {
                    return Cell::Shut;
                }
            }
        }
    }
    for (a, b) in (0..links.len()).flat_map(|b| (0..b.saturating_sub(1)).map(move |a| (a, b))) {
        // Against each other, links that are not neighbours move by the joints between them.
        for &(p, _) in &links[a] {
            for (i, &(q, _)) in links[b].iter().enumerate() {
                let along = length * i as f64 / steps as f64;
                let travel = |k: usize| half * (along + length * (b - k) as f64);
                let travel = (a + 1..=b).map(travel).sum();
                if see((p[0] - q[0]).hypot(p[1] - q[1]) - 2.0 * RADIUS, travel) {
                    return Cell::Shut;
                }
            }
        }
    }
    cell
}

/// Whether cells join two configurations: those that are open, and those that are not shut.
fn joined(world: &World, ends: [&[f64]; 2], side: usize) -> [bool; 2] {
    let dof = ends[0].len();
    let half = TURN / side as f64;
    let mut cells: Vec<Option<Cell>> = vec![None; side.pow(dof as u32)];
    let place = |end: &[f64]| -> usize {
        let along = |q: f64| (((q + TURN) / (2.0 * half)) as usize).min(side - 1);
        (0..dof).map(|k| along(end[k]) * side.pow(k as u32)).sum()
    };
    let mut reaches = |passes: &dyn Fn(Cell) -> bool| {
        let ([from, to], mut seen) = (ends.map(place), vec![false; cells.len()]);
        let mut open = vec![from];
        while let Some(index) = open.pop() {
            if std::mem::replace(&mut seen[index], true) {
                continue;
            }
            let along = |k: usize| index / side.pow(k as u32) % side;
            let cell = *cells[index].get_or_insert_with(|| {
                let middle = |k: usize| -TURN + half * (2 * along(k) + 1) as f64;
                judge(&(0..dof).map(middle).collect::<Vec<f64>>(), half, world)
            });
            if !passes(cell) {
                continue;
            }
            if index == to {
                return true;
            }
            for k in 0..dof {
                let step = side.pow(k as u32);
                if along(k) > 0 {
                    open.push(index - step);
                }
                if along(k) + 1 < side {
                    open.push(index + step);
                }
            }
        }
        false
    };
    [reaches(&|cell| cell == Cell::Open), reaches(&|cell| cell != Cell::Shut)]
}

fn agree(dof: usize, side: usize, count: usize) {
    let arm = Arc::new(planar_arm_alone(dof).unwrap());
    let problems = ArmSuite::PlanarArm.generate(&arm, None, None, count, 1007, &|| {}).unwrap();
    let [mut solved, mut disproved, mut unknown] = [0; 3];
    for problem in problems {
        let setting = Setting::Arm { arm: arm.clone(), world: problem.world.clone() };
        let (start, goal) = (problem.start.clone(), problem.goal.clone());
        let task = Task::new(&problem.name, setting, start, goal).unwrap();
        let [is_open, may_be_open] = joined(&problem.world, [&task.start, &task.goal], side);
        let options = Options { max_samples: Some(100_000), ..Options::default() };
        let answer = plan(&task, &Planner::default(), &options).unwrap();
        let name = &problem.name;
        match &answer.status {
            Status::Solved(_) => assert!(may_be_open, "{name}: solved, and shut by the grid"),
            Status::Unsolvable(_) => assert!(!is_open, "{name}: disproved, and open by the grid"),
            other => assert!(!is_open, "{name}: {other:?}, and open by the grid"),
        }
        if answer.is_solved() && solved == 0 {
            let query = Query::of(&task, &Profile::DEFAULT);
            let proof = query.scene().disproof(&task.start, &task.goal, &|| true);
            assert!(proof.is_none(), "{name}: solved and disproved");
        }
        solved += usize::from(is_open && answer.is_solved());
        disproved += usize::from(!may_be_open && matches!(answer.status, Status::Unsolvable(_)));
        unknown += usize::from(is_open != may_be_open);
    }
    println!(
        "{dof} joints: {solved} open and solved, {disproved} shut and disproved, {unknown} neither"
    );
    assert!(solved * 2 > count && disproved > 0 && unknown * 3 < count);
}

#[test]
fn two_joints_agree_with_a_grid() {
    agree(2, 290, 30);
}

#[test]
fn three_joints_agree_with_a_grid() {
    agree(3, 128, 8);
}
