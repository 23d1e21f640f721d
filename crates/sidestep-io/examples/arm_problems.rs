//! Plans the problems of a file for a robot with joints and says how many were solved and how fast.
//!
//! `cargo run --release -p sidestep-io --example arm_problems -- PROBLEMS.json ROBOT.urdf ROBOT.srdf [PLANNER] [REPEATS] [DENSITY]`
//!
//! With a DENSITY each plan is judged once more by the f64 chain and distances, which the fast proof
//! does not use (the certificate's witnesses and unmoving parts do, and the robot's data are the same): so many configurations for each radian of it,
//! each ball against each piece of the world and each ball of another link by the slow formulas in f64. One that penetrates ends the run.
//!
//! A time is the shortest of REPEATS runs, from world and robot to the plan: preparation of the scene, search, short cuts.
//! `proof` is one more certificate of the finished plan.

#![allow(clippy::print_stdout, reason = "an example prints its result")]

use std::sync::Arc;
use std::time::Instant;

use sidestep::arm::Arm;
use sidestep::arm::certificate::{Certifier, Verdict};
use sidestep::space::World;
use sidestep::{Options, Planner, Setting, Task, Trajectory, plan};
use sidestep_io::robots::{read_srdf, read_urdf};
use sidestep_io::scenes::{Problem, read_problems};

type Failure = Box<dyn std::error::Error>;

/// The median, the 95th percentile and the largest.
fn percentiles(values: &[f64]) -> [f64; 3] {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let at = |p: f64| sorted.get((sorted.len().max(1) as f64 * p - 1e-9) as usize).copied();
    [0.5, 0.95, 1.0].map(|p| at(p).or(sorted.last().copied()).unwrap_or(f64::NAN))
}

fn main() -> Result<(), Failure> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [problems, urdf, srdf, rest @ ..] = args.as_slice() else {
        return Err(
            "usage: arm_problems PROBLEMS.json ROBOT.urdf ROBOT.srdf [PLANNER] [REPEATS] [DENSITY]"
                .into(),
        );
    };
    let mut none = |_: &str| Err(std::io::Error::other("no file"));
    let problems = read_problems(&std::fs::read(problems)?, &mut none)?;
    let begin = Instant::now();
    let model = read_urdf(&std::fs::read_to_string(urdf)?)?;
    let srdf = read_srdf(&std::fs::read_to_string(srdf)?)?;
    let (arm, lasting) = problems[0].arm(&model, &srdf)?;
    let arm = Arc::new(arm);
    for (a, b) in &lasting {
        println!("{a} and {b} always touch: not checked against each other");
    }
    println!(
        "{}: {} joints, {} balls, {} pairs of links, reach {:.2} m, ready in {:.1} ms",
        arm.name(),
        arm.dof(),
        arm.ball_count(),
        arm.self_collision_pairs().count(),
        arm.reach(),
        begin.elapsed().as_secs_f64() * 1e3
    );
    let name = rest.first().map_or("auto", String::as_str);
    let planner: Planner = name.parse()?;
    let repeats = rest.get(1).map_or(Ok(3), |n| n.parse())?;
    let density: f64 = rest.get(2).map_or(Ok(0.0), |n| n.parse())?;
    let mut judge = Judge::new(&arm, density);
    let mut sets: Vec<(String, Row)> = Vec::new();
    let mut all = Row::default();
    for (index, problem) in problems.iter().enumerate() {
        // Of `cage/12` it is `cage`.
        let set = problem.name.split('/').next().unwrap_or_default().to_owned();
        let at = sets.iter().position(|row| row.0 == set).unwrap_or_else(|| {
            sets.push((set, Row::default()));
            sets.len() - 1
        });
        let row = solve(&arm, &planner, index, problem, repeats, &mut judge)?;
        all.add(&row);
        sets[at].1.add(&row);
    }
    sets.push(("all".to_string(), all));
    println!(
        "{:<32} {:>5} {:>7} {:>6} {:>9} {:>9} {:>9} {:>7} {:>7} {:>9} {:>9}",
        "set",
        "all",
        "invalid",
        "solved",
        "us p50",
        "p95",
        "max",
        "length",
        "points",
        "proof p50",
        "p95"
    );
    for (set, row) in &sets {
        let [p50, p95, max] = percentiles(&row.times);
        let [proof, proof95, _] = percentiles(&row.proofs);
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        println!(
            "{set:<32} {:>5} {:>7} {:>6} {p50:>9.1} {p95:>9.1} {max:>9.1} {:>7.3} {:>7.1} {proof:>9.1} {proof95:>9.1}",
            row.count,
            row.invalid,
            row.times.len(),
            mean(&row.lengths),
            mean(&row.points)
        );
    }
    if density > 0.0 {
        let Judge { plans, configurations, least, .. } = judge;
        println!(
            "{plans} plans judged at {configurations} configurations, {density} a radian: none penetrates, least gap {:.3} mm",
            1e3 * least
        );
    }
    Ok(())
}

/// Looks at a plan's configurations one by one.
struct Judge {
    /// Configurations for each radian; 0 for none.
    density: f64,
    /// Balls of links that must not touch.
    pairs: Vec<[usize; 2]>,
    plans: usize,
    configurations: usize,
    /// The least gap of all, metres.
    least: f64,
}

impl Judge {
    fn new(arm: &Arm, density: f64) -> Self {
        let links: Vec<&str> = (0..arm.ball_count()).map(|ball| arm.link_of_ball(ball)).collect();
        let of = |link: &str| -> Vec<usize> {
            (0..links.len()).filter(|&ball| links[ball] == link).collect()
        };
        let mut pairs = Vec::new();
        for (a, b) in arm.self_collision_pairs() {
            pairs.extend(of(a).iter().flat_map(|&i| of(b).into_iter().map(move |j| [i, j])));
        }
        Self { density, pairs, plans: 0, configurations: 0, least: f64::INFINITY }
    }

    fn look(&mut self, arm: &Arm, world: &World, path: &Trajectory) -> Result<(), Failure> {
        if self.density <= 0.0 {
            return Ok(());
        }
        self.plans += 1;
        for (from, to) in path.segments() {
            let square: f64 = from.iter().zip(to).map(|(a, b)| (a - b) * (a - b)).sum();
            let count = (square.sqrt() * self.density).ceil().max(1.0) as usize;
            for step in 0..=count {
                let t = step as f64 / count as f64;
                let q: Vec<f64> = from.iter().zip(to).map(|(a, b)| a + t * (b - a)).collect();
                let gap = self.gap(arm, world, &q);
                if gap < 0.0 {
                    return Err(format!("a plan penetrates by {} m at {q:?}", -gap).into());
                }
                self.least = self.least.min(gap);
                self.configurations += 1;
            }
        }
        Ok(())
    }

    fn gap(&self, arm: &Arm, world: &World, q: &[f64]) -> f64 {
        let balls = arm.balls_at(q);
        let mut gap = f64::INFINITY;
        for ball in &balls {
            for piece in 0..world.pieces() {
                gap = gap.min(world.distance(piece as u32, ball.center).0 - ball.radius);
            }
        }
        for &[i, j] in &self.pairs {
            let (a, b) = (&balls[i], &balls[j]);
            let square: f64 = (0..3).map(|k| (a.center[k] - b.center[k]).powi(2)).sum();
            gap = gap.min(square.sqrt() - a.radius - b.radius);
        }
        gap
    }
}

/// What came of some problems.
#[derive(Default)]
struct Row {
    count: usize,
    invalid: usize,
    times: Vec<f64>,
    lengths: Vec<f64>,
    points: Vec<f64>,
    proofs: Vec<f64>,
}

impl Row {
    fn add(&mut self, other: &Self) {
        self.count += other.count;
        self.invalid += other.invalid;
        self.times.extend(&other.times);
        self.lengths.extend(&other.lengths);
        self.points.extend(&other.points);
        self.proofs.extend(&other.proofs);
    }
}

/// Plans one problem `repeats` times and keeps the shortest time; judges the plan once more on its own.
fn solve(
    arm: &Arc<Arm>,
    planner: &Planner,
    index: usize,
    problem: &Problem,
    repeats: usize,
    judge: &mut Judge,
) -> Result<Row, Failure> {
    let mut row = Row { count: 1, ..Row::default() };
    let world = Arc::clone(&problem.world);
    let (start, goal) = (problem.start.clone(), problem.goals[0].clone());
    let certifier = Certifier::new(Arc::clone(arm), Arc::clone(&world));
    let mut work = certifier.work();
    for (name, end) in [("start", &start), ("goal", &goal)] {
        let allowed = arm.check(name, end).map_err(|error| println!("problem {index}: {error}"));
        if let Verdict::Blocked(hit) = certifier.judge(end, end, &mut work) {
            println!(
                "problem {index}: {name}: {} in {:?} by {:.5} m",
                hit.link, hit.with, hit.depth
            );
            row.invalid = 1;
        }
        row.invalid = row.invalid.max(usize::from(allowed.is_err()));
    }
    if row.invalid > 0 {
        return Ok(row);
    }
    let setting = Setting::Arm { arm: Arc::clone(arm), world: Arc::clone(&world) };
    let task = Task::new(format!("{index}"), setting, start, goal)?;
    let options = Options { index: index as u64, ..Options::default() };
    let (mut best, mut proof) = (f64::INFINITY, f64::INFINITY);
    let mut solved = None;
    for _ in 0..repeats {
        let begin = Instant::now();
        let plan = plan(&task, planner, &options)?;
        best = best.min(begin.elapsed().as_secs_f64() * 1e6);
        let Some(path) = plan.certified().cloned() else { continue };
        let begin = Instant::now();
        let free = path.segments().all(|(from, to)| certifier.motion_is_free(from, to, &mut work));
        proof = proof.min(begin.elapsed().as_secs_f64() * 1e6);
        assert!(free, "problem {index}: a plan that is not proved");
        solved = Some(path);
    }
    if let Some(path) = solved {
        judge.look(arm, &world, &path)?;
        row.times.push(best);
        row.proofs.push(proof);
        row.lengths.push(path.length());
        row.points.push(path.len() as f64);
    }
    Ok(row)
}
