//! `sidestep train`: a configuration to a policy, with checkpoints and logs.
//!
//! The folder holds `config.toml`, `checkpoint.safetensors` (the complete state), `policy.safetensors`
//! (the best on the validation tasks), `metrics.jsonl` and a TensorBoard event file (the curve), and
//! `summary.json`. Logs are written anew from the checkpoint's own curve, so a training that was killed
//! at any moment and resumed ends with the same files but for times.

pub mod tensorboard;
mod training;

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use clap::Args;
use serde_json::json;

use crate::Global;
use crate::failure::Failure;
use crate::input::read_text;
use crate::machine::Provenance;
use crate::output;
use tensorboard::Events;
use training::{Config, Training};

/// Arguments of `train`.
#[derive(Args)]
pub struct TrainArgs {
    /// Training configuration
    config: PathBuf,
    /// Folder for the policy, checkpoints and logs
    #[arg(long)]
    out: PathBuf,
    /// Go on from the folder's checkpoint
    #[arg(long)]
    resume: bool,
    /// Training seed in place of the configuration's
    #[arg(long)]
    seed: Option<u64>,
    /// Seconds between checkpoints
    #[arg(long, default_value_t = 30.0)]
    checkpoint_every: f64,
}

const CHECKPOINT: &str = "checkpoint.safetensors";

/// Trains to the end.
pub fn run(args: &TrainArgs, global: &Global) -> Result<(), Failure> {
    let mut config = Config::from_toml(&read_text(&args.config)?)
        .map_err(|error| Failure::file(&args.config, error))?;
    if let Some(seed) = args.seed {
        config.set_seed(seed);
    }
    std::fs::create_dir_all(&args.out)
        .map_err(|error| Failure::file(&args.out, format!("cannot be made ({error})")))?;
    let mut trainer = begin(args, config)?;
    let resumed_at = trainer.environment_steps();
    output::write_file(&args.out.join("config.toml"), trainer.config().to_toml()?.as_bytes())?;
    let begin = Instant::now();
    let (done, units) = trainer.units();
    let bar = output::progress("training", units, global.quiet);
    bar.set_position(done);
    let interval = Duration::try_from_secs_f64(args.checkpoint_every)
        .map_err(|error| Failure::at("--checkpoint-every", error))?;
    let mut last_save = Instant::now();
    let mut training_seconds = 0.0;
    loop {
        let unit = Instant::now();
        let progress = trainer.step()?;
        training_seconds += unit.elapsed().as_secs_f64();
        let Some(progress) = progress else { break };
        bar.inc(1);
        if !progress.is_empty() {
            bar.set_message(progress);
        }
        if last_save.elapsed() >= interval {
            save(&args.out, &trainer, training_seconds)?;
            last_save = Instant::now();
        }
    }
    bar.finish_and_clear();
    save(&args.out, &trainer, training_seconds)?;
    let mut summary = trainer.best();
    let success = summary["validation_success"].as_f64().unwrap_or(f64::NAN);
    summary["environment_steps"] = json!(trainer.environment_steps());
    summary["environment_steps_this_run"] = json!(trainer.environment_steps() - resumed_at);
    summary["training_seconds"] = json!(training_seconds);
    summary["provenance"] = json!(Provenance::here(begin.elapsed().as_secs_f64()));
    output::write_json(&args.out.join("summary.json"), &summary)?;
    if global.json {
        return output::print_json(&summary);
    }
    if !global.quiet {
        eprintln!(
            "{} steps in {training_seconds:.1} s; best on validation {:.1} %: {}",
            trainer.environment_steps(),
            100.0 * success,
            args.out.join("policy.safetensors").display(),
        );
    }
    Ok(())
}

fn begin(args: &TrainArgs, config: Config) -> Result<Training, Failure> {
    let checkpoint = args.out.join(CHECKPOINT);
    match (checkpoint.exists(), args.resume) {
        (true, false) => {
            let hint = "holds a training already; give --resume to go on with it, or another --out";
            Err(Failure::file(&args.out, hint))
        }
        (true, true) => {
            let bytes = std::fs::read(&checkpoint)
                .map_err(|error| Failure::file(&checkpoint, format!("cannot be read ({error})")))?;
            let trainer = Training::resume(&config, &bytes)
                .map_err(|error| Failure::file(&checkpoint, error))?;
            if trainer.config() != config {
                let reason = "was made with another configuration or seed than the one given";
                return Err(Failure::file(&checkpoint, reason));
            }
            Ok(trainer)
        }
        (false, _) => Ok(Training::new(config)?),
    }
}

/// Writes checkpoint, best policy and logs.
fn save(folder: &Path, trainer: &Training, training_seconds: f64) -> Result<(), Failure> {
    output::write_file(
        &folder.join("policy.safetensors"),
        &trainer.best_policy()?.to_safetensors()?,
    )?;
    output::write_file(&folder.join("metrics.jsonl"), trainer.lines()?.as_bytes())?;
    let events = events(trainer, training_seconds);
    output::write_file(&folder.join("events.out.tfevents.0.sidestep"), events.bytes())?;
    output::write_file(&folder.join(CHECKPOINT), &trainer.checkpoint()?)
}

/// The curve as TensorBoard events.
fn events(trainer: &Training, training_seconds: f64) -> Events {
    let now = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0.0, |d| d.as_secs_f64());
    let units = trainer.scalars();
    let begin = now - training_seconds;
    let mut events = Events::new(begin);
    for (index, scalars) in units.iter().enumerate() {
        // Only the whole duration is known; units are spread evenly over it.
        let time = begin + training_seconds * (index + 1) as f64 / units.len() as f64;
        for &(step, tag, value) in scalars {
            events.scalar(time, step, tag, value);
        }
        if let (Some(&(step, ..)), true) = (scalars.last(), training_seconds > 0.0) {
            let rate = trainer.environment_steps() as f64 / training_seconds;
            events.scalar(time, step, "charts/SPS", rate);
        }
    }
    events
}
