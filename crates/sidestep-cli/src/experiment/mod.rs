//! `sidestep experiment`: trains and measures what a file names, and writes one report.
//!
//! Trainings run side by side, one per core, and are kept in the output folder: a run that was
//! broken off goes on with those that are missing. The same work is a list of cells ([`cells`]),
//! each for a process of its own anywhere, whose results are merged into the same report.

mod cells;
mod check;
pub mod config;
mod measuring;
pub mod report;
mod training;

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use clap::Args;

use crate::Global;
use crate::failure::Failure;
use crate::input::read_text;
use crate::lock::Lock;
use crate::machine::Provenance;
use crate::output;
use crate::table;
use cells::{CellFile, Work};
use config::Experiment;
use measuring::{Prepared, baseline_cells, policy_cells, prepare};
use report::{Cell, ExperimentReport, FORMAT};
use training::{Trained, Trainings};

/// Arguments of `experiment`.
#[derive(Args)]
#[command(after_help = "Example:\n  sidestep experiment experiments/table-1.toml\n\n\
    Its cells in processes of their own, on machines that share the folder:\n  \
    sidestep experiment E.toml --list\n  \
    seq 0 17 | xargs -P 4 -I {} sidestep experiment E.toml --cell {} --threads 1\n  \
    sidestep experiment E.toml --merge")]
pub struct ExperimentArgs {
    /// Experiment file
    experiment: PathBuf,
    /// Folder for policies and the report [default: runs/NAME]
    #[arg(long)]
    out: Option<PathBuf>,
    /// List the cells: one for each training, with its measurements, and one for each baseline
    #[arg(long, conflicts_with_all = ["cell", "merge"])]
    list: bool,
    /// Work on this cell alone; nothing is done for one that is finished
    #[arg(long, value_name = "I", conflicts_with = "merge")]
    cell: Option<usize>,
    /// Make the report of the cells, all of them finished
    #[arg(long)]
    merge: bool,
    /// Seconds between checkpoints of a training
    #[arg(long, default_value_t = 30.0, allow_negative_numbers = true)]
    checkpoint_every: f64,
}

/// Trains, measures, writes `report.json` and prints its table; or a part of that.
pub fn run(args: &ExperimentArgs, global: &Global) -> Result<(), Failure> {
    let experiment = check::read(&read_text(&args.experiment)?)
        .map_err(|Failure(message)| Failure::file(&args.experiment, message))?;
    let folder = args.out.clone().unwrap_or_else(|| Path::new("runs").join(&experiment.name));
    if args.list {
        return cells::list(&experiment, &folder, global.json);
    }
    let interval = Duration::try_from_secs_f64(args.checkpoint_every).map_err(|_| {
        let found = format!("{} is not allowed", args.checkpoint_every);
        Failure::at("--checkpoint-every", format!("{found}; expected seconds, 0 or more"))
    })?;
    let trainings = Trainings { experiment: &experiment, folder: &folder, interval };
    if let Some(index) = args.cell {
        return one_cell(index, &trainings, global);
    }
    if args.merge {
        let report = cells::merge_files(experiment, &folder)?;
        let _lock = Lock::shared(&folder)?;
        return finish(&report, &folder, global);
    }
    let begin = Instant::now();
    let _lock = Lock::folder(&folder)?;
    let trained = trainings.all(global.quiet)?;
    let measures = prepare(&experiment.measure, global.quiet)?;
    let works = Work::all(&experiment);
    let bar = output::progress("measuring", works.len() as u64, global.quiet);
    let mut trained = trained.iter();
    let mut parts = Vec::with_capacity(works.len());
    for work in works {
        parts.push(measure(&experiment, work, trained.next(), &measures)?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    let cells = cells::merge(&experiment, &parts);
    let provenance = Provenance::here(begin.elapsed().as_secs_f64());
    finish(
        &ExperimentReport { format: FORMAT.into(), provenance, experiment, cells },
        &folder,
        global,
    )
}

/// The measurements of a cell, whose training is done.
fn measure(
    experiment: &Experiment,
    work: Work,
    trained: Option<&Trained>,
    measures: &[Prepared],
) -> Result<Vec<Cell>, Failure> {
    match (work, trained) {
        (Work::Training { policy, .. }, Some(trained)) => {
            policy_cells(&experiment.policies[policy], trained, measures)
        }
        (Work::Baseline(index), _) => baseline_cells(&experiment.baselines[index], measures),
        (Work::Training { .. }, None) => unreachable!("trainings come first, one a cell"),
    }
}

/// Trains and measures one cell where that was not done, and keeps what came out.
fn one_cell(index: usize, trainings: &Trainings, global: &Global) -> Result<(), Failure> {
    let (experiment, folder) = (trainings.experiment, trainings.folder);
    let works = Work::all(experiment);
    let Some(&work) = works.get(index) else {
        let found = format!("{index} is not allowed");
        let allowed = format!("a number from 0 to {}, as --list names them", works.len() - 1);
        return Err(Failure::at("--cell", format!("{found}; expected {allowed}")));
    };
    let begin = Instant::now();
    let _shared = Lock::shared(folder)?;
    let _lock = Lock::folder(&cells::folder(folder, index))?;
    let file = match CellFile::read(experiment, folder, index)? {
        Some(file) => file,
        None => {
            let trained = match work {
                Work::Training { policy, seed } => {
                    Some(trainings.one(policy, seed, global.quiet)?)
                }
                Work::Baseline(_) => None,
            };
            let measures = prepare(&experiment.measure, global.quiet)?;
            let cells = measure(experiment, work, trained.as_ref(), &measures)?;
            let seconds = begin.elapsed().as_secs_f64();
            CellFile::write(experiment, folder, index, Provenance::here(seconds), cells)?
        }
    };
    if global.json { output::print_json(&file) } else { Ok(()) }
}

fn finish(report: &ExperimentReport, folder: &Path, global: &Global) -> Result<(), Failure> {
    output::write_json(&folder.join("report.json"), report)?;
    if global.json {
        output::print_json(report)
    } else {
        output::print(&table::experiment_markdown(report))
    }
}
