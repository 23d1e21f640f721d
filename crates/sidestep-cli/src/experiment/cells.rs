//! An experiment as a list of cells, each worked on by itself: one for every training with its
//! measurements, policy by policy and seed by seed, then one for every baseline.
//!
//! What a cell came to is `cells/0012/cell.json` in the output folder. A result counts for the
//! experiment and the commit of the program that it was made with, and for no other.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::json;

use super::config::Experiment;
use super::report::{Cell, ExperimentReport, FORMAT};
use super::training::files;
use crate::failure::Failure;
use crate::machine::Provenance;
use crate::output;

/// The name and version of a cell's file.
const CELL_FORMAT: &str = "sidestep.experiment-cell/1";

/// What one cell of an experiment is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Work {
    /// The training of a policy with a seed, and its measurements.
    Training { policy: usize, seed: u64 },
    /// The measurements of a baseline.
    Baseline(usize),
}

impl Work {
    /// The cells of an experiment in their order.
    pub fn all(experiment: &Experiment) -> Vec<Self> {
        let training = |(policy, seed)| Self::Training { policy, seed };
        let trainings = experiment.trainings().into_iter().map(training);
        trainings.chain((0..experiment.baselines.len()).map(Self::Baseline)).collect()
    }
}

/// What a cell came to.
#[derive(Debug, Serialize, Deserialize)]
pub struct CellFile {
    /// [`CELL_FORMAT`].
    format: String,
    /// Which cell.
    index: usize,
    provenance: Provenance,
    /// What was asked for, as JSON.
    experiment: serde_json::Value,
    /// One for each measurement, in the experiment's order.
    cells: Vec<Cell>,
}

/// The folder of a cell.
pub fn folder(out: &Path, index: usize) -> PathBuf {
    out.join("cells").join(format!("{index:04}"))
}

fn file(out: &Path, index: usize) -> PathBuf {
    folder(out, index).join("cell.json")
}

impl CellFile {
    /// What is kept of a cell; `None` where there is nothing, or what another experiment or another
    /// commit of the program made.
    pub fn read(
        experiment: &Experiment,
        out: &Path,
        index: usize,
    ) -> Result<Option<Self>, Failure> {
        let path = file(out, index);
        if !path.exists() {
            return Ok(None);
        }
        let told = |error: &dyn std::fmt::Display| {
            Failure::file(&path, format!("{error}; remove it to have it made anew"))
        };
        let bytes = std::fs::read(&path).map_err(|error| told(&error))?;
        let kept: Self = serde_json::from_slice(&bytes).map_err(|error| told(&error))?;
        if kept.format != CELL_FORMAT {
            return Err(told(&format!("format: {:?}; expected {CELL_FORMAT:?}", kept.format)));
        }
        let is_of = kept.experiment == value(experiment)?
            && kept.index == index
            && kept.cells.len() == experiment.measure.len()
            && kept.provenance.commit == env!("SIDESTEP_COMMIT");
        Ok(is_of.then_some(kept))
    }

    /// Keeps what a cell came to.
    pub fn write(
        experiment: &Experiment,
        out: &Path,
        index: usize,
        provenance: Provenance,
        cells: Vec<Cell>,
    ) -> Result<Self, Failure> {
        let (format, experiment) = (CELL_FORMAT.into(), value(experiment)?);
        let kept = Self { format, index, provenance, experiment, cells };
        output::write_json(&file(out, index), &kept)?;
        Ok(kept)
    }
}

fn value(experiment: &Experiment) -> Result<serde_json::Value, Failure> {
    serde_json::to_value(experiment).map_err(|error| Failure::at("experiment", error))
}

/// Prints the cells and how far each is.
pub fn list(experiment: &Experiment, out: &Path, json: bool) -> Result<(), Failure> {
    let mut text = String::new();
    let mut all = Vec::new();
    for (index, work) in Work::all(experiment).into_iter().enumerate() {
        let (row, column, seed) = match work {
            Work::Training { policy, seed } => {
                let entry = &experiment.policies[policy];
                (entry.row.as_str(), entry.column.as_str(), Some(seed))
            }
            Work::Baseline(at) => (experiment.baselines[at].planner.as_str(), "", None),
        };
        let state = state(experiment, out, index, work)?;
        let seed_words = seed.map_or_else(String::new, |seed| format!(", seed {seed}"));
        let gap = if column.is_empty() { "" } else { " " };
        text += &format!("{index:4}  {state:9} {row}{gap}{column}{seed_words}\n");
        all.push(json!({
            "index": index, "row": row, "column": column, "seed": seed, "state": state,
        }));
    }
    if json { output::print_json(&all) } else { output::print(&text) }
}

/// How far a cell is, as a word.
fn state(
    experiment: &Experiment,
    out: &Path,
    index: usize,
    work: Work,
) -> Result<&'static str, Failure> {
    if CellFile::read(experiment, out, index)?.is_some() {
        return Ok("finished");
    }
    Ok(match work {
        Work::Training { policy, seed } => {
            let files = files(out, &experiment.policies[policy], seed);
            if files.is_trained(&experiment.recipe(&experiment.policies[policy], seed)?)? {
                "trained"
            } else if files.checkpoint.exists() {
                "begun"
            } else {
                "open"
            }
        }
        Work::Baseline(_) => "open",
    })
}

/// The report of finished cells.
pub fn merge_files(experiment: Experiment, out: &Path) -> Result<ExperimentReport, Failure> {
    let count = Work::all(&experiment).len();
    let read = |index| CellFile::read(&experiment, out, index);
    let kept = (0..count).map(read).collect::<Result<Vec<_>, Failure>>()?;
    let missing: Vec<usize> = (0..count).filter(|&index| kept[index].is_none()).collect();
    if let Some(first) = missing.first() {
        let words = format!(
            "{} of {count} cells are not finished, the first of them {first}; run them by --cell, \
             and see --list",
            missing.len()
        );
        return Err(Failure::file(out, words));
    }
    let kept: Vec<CellFile> = kept.into_iter().flatten().collect();
    let mut provenance = Provenance::here(kept.iter().map(|kept| kept.provenance.seconds).sum());
    let mut processors: Vec<String> = Vec::new();
    for kept in &kept {
        provenance.threads = kept.provenance.threads;
        if !processors.contains(&kept.provenance.processor) {
            processors.push(kept.provenance.processor.clone());
        }
    }
    provenance.processor = processors.join(", ");
    let parts: Vec<Vec<Cell>> = kept.into_iter().map(|kept| kept.cells).collect();
    let cells = merge(&experiment, &parts);
    Ok(ExperimentReport { format: FORMAT.into(), provenance, experiment, cells })
}

/// The report's cells of what each cell of work came to: seeds of a policy side by side,
/// measurement by measurement but for those that one race serves, which stay together.
pub fn merge(experiment: &Experiment, parts: &[Vec<Cell>]) -> Vec<Cell> {
    let mut merged = Vec::new();
    let mut first = 0;
    for group in experiment.measure.chunk_by(|a, b| a.races_with(b)) {
        let measures = first..first + group.len();
        first = measures.end;
        let mut parts = parts.iter();
        let seeds = experiment.policies.iter().map(|entry| experiment.seeds(entry).len());
        for count in seeds.chain(experiment.baselines.iter().map(|_| 1)) {
            let parts: Vec<&Vec<Cell>> = parts.by_ref().take(count).collect();
            for measure in measures.clone() {
                let cells = parts.iter().map(|cells| cells[measure].clone());
                merged.extend(cells.reduce(beside));
            }
        }
    }
    merged
}

/// Two cells of different training seeds as one.
fn beside(mut cell: Cell, other: Cell) -> Cell {
    cell.any.extend(other.any);
    cell.end.extend(other.end);
    cell.certified.extend(other.certified);
    cell.certified_of_solvable.extend(other.certified_of_solvable);
    cell.iterations.extend(other.iterations);
    cell.us_per_iteration.extend(other.us_per_iteration);
    cell.training_seconds.extend(other.training_seconds);
    cell.kept_at_steps.extend(other.kept_at_steps);
    cell.curves.extend(other.curves);
    cell.solved.extend(other.solved);
    cell.time.extend(other.time);
    cell
}
