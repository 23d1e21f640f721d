//! Routes of a robot with joints: what optimizers find from several starts and RRT-Connect finds, with
//! short cuts, as trajectories of N waypoints.

use std::ops::ControlFlow;

use rand_chacha::ChaCha8Rng;
use sidestep::objective::Objective;
use sidestep::optimizer::{Method, Optimizer};
use sidestep::plan::rrt_connect::{RrtConnect, shortcut};
use sidestep::plan::run::{Until, run};
use sidestep::plan::starts::StartStrategy;
use sidestep::rng::{Purpose, stream};
use sidestep::scene::Query;
use sidestep::trajectory::waypoints::polyline;
use sidestep::trajectory::{Trajectory, distance};

use super::{Target, mean_distance};

/// Pairs of trees, and samples of each.
const TREES: usize = 2;
const SAMPLES: usize = 3000;
/// Random short cuts on what was found.
const SHORT_CUTS: usize = 40;
/// Starts of each optimizer: the straight line, then through via-points.
const STARTS: usize = 3;
/// The optimizers with their steps: CHOMP, as its step serves arms, and L-BFGS.
const OPTIMIZERS: [(Method, usize); 2] =
    [(Method::Chomp { step: Some(0.02) }, 40), (Method::Lbfgs { memory: 7 }, 15)];
/// Routes that are kept.
const MOST: usize = 6;
/// Mean distance of waypoints from which on two routes are different, rad or m.
const DIFFERENT: f32 = 0.3;

/// The shortest of a few paths of RRT-Connect with short cuts; none if it finds none.
pub fn reference(query: &Query, rng: &mut ChaCha8Rng) -> Option<Trajectory> {
    paths(query, rng).into_iter().min_by(|a, b| a.length().total_cmp(&b.length()))
}

fn paths(query: &Query, rng: &mut ChaCha8Rng) -> Vec<Trajectory> {
    let planner =
        RrtConnect { max_samples: SAMPLES, shortcut_rounds: SHORT_CUTS, ..RrtConnect::default() };
    let mut found = Vec::new();
    for _ in 0..TREES {
        let Some(path) = planner.plan(query, rng).trajectory else { break };
        found.push(path);
    }
    found
}

/// Up to `MOST` different routes, the shortest first; none if the trees find no way.
pub fn targets(objective: &Objective, rng: &mut ChaCha8Rng) -> Vec<Target> {
    let query = objective.query();
    let mut found = paths(query, rng);
    if found.is_empty() {
        return Vec::new();
    }
    found.extend(optimized(objective, rng));
    found.sort_by(|a, b| a.length().total_cmp(&b.length()));
    let shortest = found[0].length();
    let mut targets: Vec<Target> = Vec::new();
    for path in &found {
        let Some(waypoints) = spread(objective, path) else { continue };
        let differs = |target: &Target| {
            mean_distance(objective.dof(), &target.waypoints, &waypoints) > DIFFERENT
        };
        if targets.len() < MOST && targets.iter().all(differs) {
            targets.push(Target { waypoints, extra: (path.length() - shortest) as f32 });
        }
    }
    targets
}

/// What optimizers find, with short cuts.
fn optimized(objective: &Objective, rng: &mut ChaCha8Rng) -> Vec<Trajectory> {
    let scene = objective.scene();
    let is_free = |from: &[f64], to: &[f64]| scene.motion_is_free(from, to);
    let mut found = Vec::new();
    for start in 0..STARTS {
        let mut begin = vec![0.0; objective.dim()];
        match start {
            0 => objective.straight_line(&mut begin),
            _ => StartStrategy::ViaPoint.draw(objective, rng, &mut begin),
        }
        for (method, steps) in &OPTIMIZERS {
            let (mut own, mut x) = (objective.clone(), begin.clone());
            let unused = stream(0, Purpose::Planner, 0, 0);
            let Ok(mut optimizer) = Optimizer::new(method, &own, unused) else { continue };
            let until = Until::Certified;
            let done =
                run(&mut own, &mut optimizer, &mut x, *steps, until, |_| ControlFlow::Continue(()));
            if let Some(best) = done.best {
                let mut path = objective.trajectory(&best.waypoints);
                shortcut(&mut path, is_free, SHORT_CUTS, rng);
                found.push(path);
            }
        }
    }
    found
}

/// N waypoints along a path: evenly, or where that cuts a corner that is needed, with all corners kept and
/// the others shared out over the longest legs. None if there are more corners than waypoints.
fn spread(objective: &Objective, path: &Trajectory) -> Option<Vec<f32>> {
    let (dof, waypoints) = (objective.dof(), objective.waypoints());
    let mut corners = vec![0.0; path.values().len()];
    objective.scene().to_normalised(path.values(), &mut corners);
    let mut x = vec![0.0; objective.dim()];
    polyline(dof, &corners, &mut x);
    if objective.is_certified(&x) {
        return Some(x);
    }
    let mut spare = waypoints.checked_sub(path.len().saturating_sub(2))?;
    let legs: Vec<f64> = path.segments().map(|(a, b)| distance(a, b)).collect();
    let mut parts = vec![1_usize; legs.len()];
    let share = |legs: &[f64], parts: &[usize], i: usize| legs[i] / parts[i] as f64;
    while spare > 0 {
        let order =
            |&a: &usize, &b: &usize| share(&legs, &parts, a).total_cmp(&share(&legs, &parts, b));
        let longest = (0..legs.len()).max_by(order)?;
        parts[longest] += 1;
        spare -= 1;
    }
    x.clear();
    for (leg, (&count, ends)) in parts.iter().zip(corners.windows(2 * dof).step_by(dof)).enumerate()
    {
        let (from, to) = ends.split_at(dof);
        let last = if leg + 1 == parts.len() { count - 1 } else { count };
        for k in 1..=last {
            let t = k as f32 / count as f32;
            x.extend(from.iter().zip(to).map(|(a, b)| a + t * (b - a)));
        }
    }
    objective.is_certified(&x).then_some(x)
}
