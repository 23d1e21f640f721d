//! The trainings of an experiment: side by side, one per core, each kept in the output folder.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use rayon::prelude::*;
use sidestep::policy::Policy;

use super::config::{Experiment, PolicyEntry};
use crate::failure::Failure;
use crate::output;
use crate::planning::load_policy;

/// One trained policy.
pub struct Trained {
    /// The best on the validation tasks.
    pub policy: Arc<Policy>,
    /// Seconds of training.
    pub seconds: f64,
}

/// Trains every policy for every seed, those that the folder lacks; answers them policy by policy.
pub fn train_all(
    experiment: &Experiment,
    folder: &Path,
    quiet: bool,
) -> Result<Vec<Vec<Trained>>, Failure> {
    let jobs = experiment.trainings();
    let bar = output::progress("training", jobs.len() as u64, quiet);
    let trained: Vec<(usize, Trained)> = jobs
        .into_par_iter()
        .with_max_len(1)
        .map(|(index, seed)| {
            let policy = train_one(experiment, &experiment.policies[index], seed, folder)?;
            bar.inc(1);
            Ok((index, policy))
        })
        .collect::<Result<_, Failure>>()?;
    bar.finish_and_clear();
    let mut grouped: Vec<Vec<Trained>> = experiment.policies.iter().map(|_| Vec::new()).collect();
    for (index, policy) in trained {
        grouped[index].push(policy);
    }
    Ok(grouped)
}

fn train_one(
    experiment: &Experiment,
    entry: &PolicyEntry,
    seed: u64,
    folder: &Path,
) -> Result<Trained, Failure> {
    let recipe = experiment.recipe(entry, seed)?;
    let name = entry.file_name(seed);
    // Not `with_extension`, which would cut a name at its last dot.
    let file = |ending: &str| -> PathBuf { folder.join("policies").join(name.clone() + ending) };
    let (path, seconds_path) = (file(".safetensors"), file(".seconds"));
    if path.exists() {
        let policy = load_policy(&path)?;
        if policy.card().training["config"] == recipe.to_json() {
            let seconds = std::fs::read_to_string(&seconds_path).unwrap_or_default();
            let seconds = seconds.trim().parse().unwrap_or(f64::NAN);
            return Ok(Trained { policy: Arc::new(policy), seconds });
        }
    }
    let begin = Instant::now();
    let mut training = recipe.begin(None)?;
    while training.step().map_err(|divergence| Failure::at(&name, divergence))?.is_some() {}
    let seconds = begin.elapsed().as_secs_f64();
    let policy = training.best_policy()?;
    output::write_file(&file(".metrics.jsonl"), training.lines().as_bytes())?;
    output::write_file(&seconds_path, format!("{seconds}\n").as_bytes())?;
    output::write_file(&path, &policy.to_safetensors()?)?;
    Ok(Trained { policy: Arc::new(policy), seconds })
}
