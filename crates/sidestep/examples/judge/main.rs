//! Plans tasks of many kinds by all planners and judges every answer in exact arithmetic that shares nothing with the
//! certificate: no plan that is called solved may collide, and no task may have both a plan and a proof that there is none.
//!
//! ```sh
//! cargo run --release -p sidestep --example judge -- --threads 16 --seconds 600 --seed 1 --out report.json
//! ```
//!
//! Task i of a seed does not depend on threads or time, so that a run goes on where another ended: `--first` is the other
//! report's `next`. `--task I` plans and judges one task again and prints it. Exit code 1 where something is wrong.
#![allow(clippy::print_stdout, clippy::expect_used, reason = "an example that measures")]

mod exact;
mod families;
mod verdict;

use std::collections::BTreeMap;
use std::process::ExitCode;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use families::Family;
use serde::Serialize;
use sidestep::plan::{Options, Plan, Planner, Status, Watch, plan_in};
use sidestep::profile::Profile;
use sidestep::{Query, Task};

/// These answer every task.
const ALWAYS: [&str; 2] = ["shortest-path", "rrt-connect:samples=300"];
/// Of these, one answers each task, by turns.
const BY_TURNS: [&str; 11] = [
    "auto",
    "gd",
    "sidestep-1-small",
    "momentum",
    "adam",
    "auto",
    "chomp",
    "lbfgs",
    "lm",
    "sidestep-1",
    "stomp",
];
/// Steps of an optimizer, from one start.
const STEPS: usize = 30;
/// Faults that a report spells out.
const MOST_FAULTS: usize = 20;

/// Answers of one planner to the tasks of one family.
#[derive(Debug, Clone, Copy, Default, Serialize)]
struct Answers {
    plans: u64,
    solved: u64,
    unsolvable: u64,
    invalid: u64,
    unsolved: u64,
    colliding: u64,
    planning_seconds: f64,
    judging_seconds: f64,
}

/// What one thread or all of them found.
#[derive(Debug, Default)]
struct Tally {
    answers: BTreeMap<(&'static str, &'static str), Answers>,
    contradictions: u64,
    faults: Vec<String>,
}

impl Tally {
    fn add(&mut self, other: Self) {
        for (key, answers) in other.answers {
            let sum = self.answers.entry(key).or_default();
            sum.plans += answers.plans;
            sum.solved += answers.solved;
            sum.unsolvable += answers.unsolvable;
            sum.invalid += answers.invalid;
            sum.unsolved += answers.unsolved;
            sum.colliding += answers.colliding;
            sum.planning_seconds += answers.planning_seconds;
            sum.judging_seconds += answers.judging_seconds;
        }
        self.contradictions += other.contradictions;
        self.faults.extend(other.faults);
        self.faults.truncate(MOST_FAULTS);
    }

    fn total(&self, count: impl Fn(&Answers) -> u64) -> u64 {
        self.answers.values().map(count).sum()
    }
}

struct Judge {
    seed: u64,
    always: Vec<(&'static str, Planner)>,
    by_turns: Vec<(&'static str, Planner)>,
}

impl Judge {
    fn new(seed: u64) -> Self {
        let named = |name: &'static str| (name, name.parse().expect("a known planner"));
        Self {
            seed,
            always: ALWAYS.into_iter().map(named).collect(),
            by_turns: BY_TURNS.into_iter().map(named).collect(),
        }
    }

    fn task(&self, index: u64) -> (&'static str, Task) {
        let families = Family::ALL.len() as u64;
        let (family, name) = Family::ALL[(index % families) as usize];
        (name, family.draw(self.seed, index / families))
    }

    /// Plans and judges a task.
    fn judge(&self, index: u64, tally: &mut Tally) -> Vec<(&'static str, Plan)> {
        let (family, task) = self.task(index);
        // The paper's profile has sampled checks and another field.
        let turn = index / Family::ALL.len() as u64;
        let profile = if turn % 7 == 3 { Profile::PAPER } else { Profile::DEFAULT };
        let options = Options { profile, steps: STEPS, index, ..Options::default() };
        let query = Query::of(&task, &options.profile);
        let plane = task.plane().expect("a task in the plane");
        let other = &self.by_turns[turn as usize % self.by_turns.len()];
        let mut plans = Vec::with_capacity(ALWAYS.len() + 1);
        for (name, planner) in self.always.iter().chain([other]) {
            let clock = Instant::now();
            let plan = plan_in(&query, planner, &options, Watch::NONE);
            let plan = plan.expect("options and task are valid");
            let answers = tally.answers.entry((family, name)).or_default();
            answers.planning_seconds += clock.elapsed().as_secs_f64();
            let clock = Instant::now();
            answers.plans += 1;
            match &plan.status {
                Status::Solved(_) => answers.solved += 1,
                Status::Unsolvable(_) => answers.unsolvable += 1,
                Status::Invalid(_) => answers.invalid += 1,
                _ => answers.unsolved += 1,
            }
            if let Some(path) = plan.certified() {
                if let Some(fault) = verdict::fault(&plane, path) {
                    answers.colliding += 1;
                    tally.faults.push(format!("task {index} ({family}), {name}: {fault}"));
                }
            } else if let Some(path) = &plan.attempt
                && !path.values().iter().all(|x| x.is_finite())
            {
                tally.faults.push(format!("task {index} ({family}), {name}: not finite"));
            }
            answers.judging_seconds += clock.elapsed().as_secs_f64();
            plans.push((*name, plan));
        }
        let solved = plans.iter().any(|(_, plan)| plan.is_solved());
        let refused =
            |plan: &Plan| matches!(plan.status, Status::Unsolvable(_) | Status::Invalid(_));
        if let Some((name, _)) = plans.iter().find(|(_, plan)| solved && refused(plan)) {
            tally.contradictions += 1;
            let what =
                format!("task {index} ({family}): a plan, and {name} proves that there is none");
            tally.faults.push(what);
        }
        plans
    }
}

fn main() -> ExitCode {
    let arguments = match Arguments::read() {
        Ok(arguments) => arguments,
        Err(message) => {
            eprintln!("error: {message}");
            return ExitCode::from(2);
        }
    };
    let judge = Judge::new(arguments.seed);
    if let Some(index) = arguments.task {
        let mut tally = Tally::default();
        println!("{:#?}", judge.task(index));
        println!("{:#?}\n{:#?}", judge.judge(index, &mut tally), tally.faults);
        return ExitCode::from(u8::from(!tally.faults.is_empty()));
    }
    let next = AtomicU64::new(arguments.first);
    let begin = Instant::now();
    let limit = Duration::from_secs_f64(arguments.seconds);
    let mut tally = Tally::default();
    std::thread::scope(|scope| {
        let work = || {
            let mut tally = Tally::default();
            while begin.elapsed() < limit {
                judge.judge(next.fetch_add(1, Ordering::Relaxed), &mut tally);
                tally.faults.truncate(MOST_FAULTS);
            }
            tally
        };
        let threads: Vec<_> = (0..arguments.threads).map(|_| scope.spawn(work)).collect();
        let mut told = Instant::now();
        while threads.iter().any(|thread| !thread.is_finished()) {
            std::thread::sleep(Duration::from_millis(20));
            if told.elapsed() > Duration::from_secs(2) {
                told = Instant::now();
                let done = next.load(Ordering::Relaxed) - arguments.first;
                eprint!(
                    "\r{done} tasks in {:.0} of {} s",
                    begin.elapsed().as_secs_f64(),
                    arguments.seconds
                );
            }
        }
        eprintln!();
        for thread in threads {
            tally.add(thread.join().expect("a thread that judges does not panic"));
        }
    });
    let seconds = begin.elapsed().as_secs_f64();
    let report = report(&arguments, &tally, next.load(Ordering::Relaxed), seconds);
    match &arguments.out {
        Some(path) => std::fs::write(path, report + "\n").expect("the report can be written"),
        None => println!("{report}"),
    }
    let wrong = tally.total(|answers| answers.colliding) + tally.contradictions;
    eprintln!(
        "{} plans, {} solved, {wrong} wrong",
        tally.total(|answers| answers.plans),
        tally.total(|answers| answers.solved)
    );
    ExitCode::from(u8::from(wrong > 0 || !tally.faults.is_empty()))
}

fn report(arguments: &Arguments, tally: &Tally, next: u64, seconds: f64) -> String {
    let mut families = BTreeMap::<_, BTreeMap<_, _>>::new();
    for ((family, planner), answers) in &tally.answers {
        families.entry(family).or_default().insert(planner, answers);
    }
    let report = serde_json::json!({
        "what": "plans of all planners, judged in exact arithmetic",
        "command": std::env::args().skip(1).collect::<Vec<_>>().join(" "),
        "seed": arguments.seed,
        "first": arguments.first,
        "next": next,
        "threads": arguments.threads,
        "seconds": seconds,
        "tasks": next - arguments.first,
        "plans": tally.total(|answers| answers.plans),
        "solved": tally.total(|answers| answers.solved),
        "colliding": tally.total(|answers| answers.colliding),
        "contradictions": tally.contradictions,
        "faults": tally.faults,
        "families": families,
    });
    serde_json::to_string_pretty(&report).expect("a report is JSON")
}

struct Arguments {
    threads: usize,
    seconds: f64,
    seed: u64,
    first: u64,
    task: Option<u64>,
    out: Option<String>,
}

impl Arguments {
    fn read() -> Result<Self, String> {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let mut read =
            Self { threads: cores, seconds: 10.0, seed: 1, first: 0, task: None, out: None };
        let mut arguments = std::env::args().skip(1);
        while let Some(flag) = arguments.next() {
            let value = arguments.next().ok_or(format!("{flag} needs a value"))?;
            fn number<T: std::str::FromStr>(flag: &str, value: &str) -> Result<T, String> {
                value.parse().map_err(|_| format!("{flag}: {value} is not a number that it takes"))
            }
            match flag.as_str() {
                "--threads" => read.threads = number(&flag, &value)?,
                "--seconds" => read.seconds = number(&flag, &value)?,
                "--seed" => read.seed = number(&flag, &value)?,
                "--first" => read.first = number(&flag, &value)?,
                "--task" => read.task = Some(number(&flag, &value)?),
                "--out" => read.out = Some(value),
                _ => {
                    return Err(format!(
                        "{flag}: expected --threads, --seconds, --seed, --first, --task or --out"
                    ));
                }
            }
        }
        if !(1..=1024).contains(&read.threads) {
            return Err(format!("--threads: {} is not from 1 to 1024", read.threads));
        }
        if !(0.0..=1e6).contains(&read.seconds) {
            return Err(format!("--seconds: {} is not from 0 to 1e6", read.seconds));
        }
        Ok(read)
    }
}
