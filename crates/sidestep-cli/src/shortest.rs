//! `sidestep shortest`: the exact shortest path of each task, or the proof that there is none.

use std::path::PathBuf;

use clap::Args;
use rayon::prelude::*;
use serde::Serialize;
use sidestep::plan::by_setting;
use sidestep::plane::points;
use sidestep::plane::shortest_path::{Route, ShortestPath};
use sidestep::{InvalidInput, PlaneTask, Task};
use sidestep_io::input::Question;

use crate::Global;
use crate::failure::Failure;
use crate::input::{self, InputArgs};
use crate::output;

/// Arguments of `shortest`.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  sidestep shortest tasks.jsonl\n  sidestep shortest map.yaml --random-queries 20 --robot-radius 0.2 --json"
)]
pub struct ShortestArgs {
    /// Task .json or .jsonl, MovingAI .map or .scen, ROS map .yaml, BARN worlds .json, MPNet worlds .dat
    tasks: PathBuf,
    #[command(flatten)]
    from: InputArgs,
    /// Seed of what a file of worlds leaves open
    #[arg(long, default_value_t = 0)]
    seed: u64,
}

/// The exact answer to one task.
#[derive(Serialize)]
struct Answer {
    name: String,
    /// solvable, unsolvable or undecided
    answer: &'static str,
    reason: String,
    length: Option<f64>,
    lower_bound: Option<f64>,
    waypoints: Vec<[f64; 2]>,
}

/// Answers every task.
pub fn run(args: &ShortestArgs, global: &Global) -> Result<(), Failure> {
    let question = Question { seed: args.seed, ..Question::default() };
    let tasks = input::read(&args.tasks, &args.from, question)?.tasks;
    let bar = output::progress("exact shortest paths", tasks.len() as u64, global.quiet);
    let answers: Result<Vec<Vec<Answer>>, InvalidInput> = by_setting(&tasks)
        .into_par_iter()
        .map(|(_, tasks)| {
            let PlaneTask { world, robot, .. } = tasks[0].plane()?;
            let exact = ShortestPath::new(world, robot);
            let answer = |exact: &mut ShortestPath, task: &Task| {
                let answer = answer(exact, task.plane()?);
                bar.inc(1);
                Ok(answer)
            };
            tasks.par_iter().map_with(exact, answer).collect()
        })
        .collect();
    let answers: Vec<Answer> = answers?.into_iter().flatten().collect();
    bar.finish_and_clear();
    if global.json {
        return output::print_json(&answers);
    }
    let mut text = String::new();
    for (index, answer) in answers.iter().enumerate() {
        let detail = answer.length.map_or(answer.reason.clone(), |length| format!("{length:.4}"));
        text += &format!("{index} {} {detail}\n", answer.answer);
    }
    let solvable = answers.iter().filter(|answer| answer.length.is_some()).count();
    text += &format!("{solvable} of {} solvable\n", answers.len());
    output::print(&text)
}

fn answer(exact: &mut ShortestPath, task: PlaneTask<'_>) -> Answer {
    let name = task.name.to_owned();
    match exact.find(task.start, task.goal) {
        Route::Found { trajectory, length, lower_bound } => Answer {
            name,
            answer: "solvable",
            reason: String::new(),
            length: Some(length),
            lower_bound: Some(lower_bound),
            waypoints: points(&trajectory).to_vec(),
        },
        Route::Unsolvable(proof) => blank(name, "unsolvable", proof.to_string()),
        Route::Undecided(doubt) => blank(name, "undecided", doubt.to_string()),
    }
}

fn blank(name: String, answer: &'static str, reason: String) -> Answer {
    Answer { name, answer, reason, length: None, lower_bound: None, waypoints: Vec::new() }
}
