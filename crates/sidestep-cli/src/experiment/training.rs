//! The trainings of an experiment: side by side, one per core, each kept in the output folder with
//! a checkpoint, so that what was broken off goes on to the same bits.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use rayon::prelude::*;
use sidestep::policy::Policy;
use sidestep_train::{Recipe, Training};

use super::config::{Experiment, PolicyEntry};
use crate::failure::Failure;
use crate::output;
use crate::planning::load_policy;

/// One trained policy.
pub struct Trained {
    /// The best on the validation tasks.
    pub policy: Arc<Policy>,
    /// Seconds of training, where they are known.
    pub seconds: Option<f64>,
}

/// The trainings of an experiment in its output folder.
pub struct Trainings<'a> {
    pub experiment: &'a Experiment,
    pub folder: &'a Path,
    /// Between checkpoints.
    pub interval: Duration,
}

/// The files of a training.
pub struct Files {
    name: String,
    policy: PathBuf,
    seconds: PathBuf,
    metrics: PathBuf,
    /// The whole state of a training that is not done.
    pub checkpoint: PathBuf,
    /// What it was begun with.
    config: PathBuf,
}

/// The files of the training of a policy with a seed.
pub fn files(folder: &Path, entry: &PolicyEntry, seed: u64) -> Files {
    let name = entry.file_name(seed);
    // Not `with_extension`, which would cut a name at its last dot.
    let file = |ending: &str| -> PathBuf { folder.join("policies").join(name.clone() + ending) };
    Files {
        policy: file(".safetensors"),
        seconds: file(".seconds"),
        metrics: file(".metrics.jsonl"),
        checkpoint: file(".checkpoint"),
        config: file(".checkpoint.json"),
        name,
    }
}

impl Files {
    /// Whether the policy that the recipe makes is there.
    pub fn is_trained(&self, recipe: &Recipe) -> Result<bool, Failure> {
        Ok(self.trained(recipe)?.is_some())
    }

    fn trained(&self, recipe: &Recipe) -> Result<Option<Trained>, Failure> {
        if !self.policy.exists() {
            return Ok(None);
        }
        let policy = load_policy(&self.policy)?;
        let is_of = policy.card().training["config"] == recipe.to_json();
        let seconds = self.seconds();
        Ok(is_of.then(|| Trained { policy: Arc::new(policy), seconds }))
    }

    fn seconds(&self) -> Option<f64> {
        std::fs::read_to_string(&self.seconds).ok()?.trim().parse().ok()
    }

    /// The training where its checkpoint left it, or at its beginning, and the seconds that it took
    /// so far. A checkpoint of another configuration, or a damaged one, counts for nothing.
    fn begin(&self, recipe: &Recipe) -> Result<(Box<dyn Training>, f64), Failure> {
        let config = recipe.to_json().to_string();
        let is_of = std::fs::read_to_string(&self.config).is_ok_and(|stored| stored == config);
        if is_of
            && let Ok(bytes) = std::fs::read(&self.checkpoint)
            && let Ok(training) = recipe.resume(&bytes)
        {
            return Ok((training, self.seconds().unwrap_or_default()));
        }
        self.remove_checkpoint();
        output::write_file(&self.config, config.as_bytes())?;
        Ok((recipe.begin(None)?, 0.0))
    }

    fn save(&self, training: &dyn Training, seconds: f64) -> Result<(), Failure> {
        output::write_file(&self.seconds, format!("{seconds}\n").as_bytes())?;
        output::write_file(&self.checkpoint, &training.checkpoint()?)
    }

    fn remove_checkpoint(&self) {
        for path in [&self.checkpoint, &self.config] {
            let _ = std::fs::remove_file(path);
        }
    }
}

impl Trainings<'_> {
    /// Trains every policy for every seed, those that the folder lacks; in the order of the cells.
    pub fn all(&self, quiet: bool) -> Result<Vec<Trained>, Failure> {
        let jobs = self.experiment.trainings();
        let bar = output::progress("training", jobs.len() as u64, quiet);
        let trained = jobs
            .into_par_iter()
            .with_max_len(1)
            .map(|(policy, seed)| {
                let trained = self.one(policy, seed, true)?;
                bar.inc(1);
                Ok(trained)
            })
            .collect();
        bar.finish_and_clear();
        trained
    }

    /// Trains a policy with a seed, or takes it from the folder.
    pub fn one(&self, policy: usize, seed: u64, quiet: bool) -> Result<Trained, Failure> {
        let entry = &self.experiment.policies[policy];
        let (recipe, files) =
            (self.experiment.recipe(entry, seed)?, files(self.folder, entry, seed));
        if let Some(trained) = files.trained(&recipe)? {
            return Ok(trained);
        }
        let policies = self.folder.join("policies");
        std::fs::create_dir_all(&policies)
            .map_err(|error| Failure::file(&policies, format!("cannot be made ({error})")))?;
        let (mut training, before) = files.begin(&recipe)?;
        let units = training.units();
        if units.done > 0 && !quiet {
            let (name, done, all) = (&files.name, units.done, units.all);
            output::tell(&format!("{name}: goes on after unit {done} of {all}"));
        }
        let bar = output::progress("training", units.all, quiet);
        let (begin, mut saved) = (Instant::now(), Instant::now());
        let seconds = || before + begin.elapsed().as_secs_f64();
        let diverged = |divergence| Failure::at(&files.name, divergence);
        while training.step().map_err(diverged)?.is_some() {
            bar.set_position(training.units().done);
            if saved.elapsed() >= self.interval {
                files.save(&*training, seconds())?;
                saved = Instant::now();
            }
        }
        bar.finish_and_clear();
        let seconds = seconds();
        let policy = training.best_policy()?;
        output::write_file(&files.metrics, training.lines().as_bytes())?;
        output::write_file(&files.seconds, format!("{seconds}\n").as_bytes())?;
        output::write_file(&files.policy, &policy.to_safetensors()?)?;
        files.remove_checkpoint();
        Ok(Trained { policy: Arc::new(policy), seconds: Some(seconds) })
    }
}
