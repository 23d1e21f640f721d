//! `sidestep train`: a configuration to a policy, with checkpoints and logs.
//!
//! The folder holds `config.toml`, `checkpoint.safetensors` (the complete state), `policy.safetensors`
//! (the best on the validation tasks), `metrics.jsonl` and a TensorBoard event file (the curve), and
//! `summary.json`. Logs are written anew from the checkpoint's own curve, so a training that was killed
//! at any moment and resumed ends with the same files but for times.

pub mod tensorboard;

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use clap::Args;
use serde_json::json;
use sidestep_train::{Progress, TrainConfig, Trainer};

use crate::Global;
use crate::failure::Failure;
use crate::input::read_text;
use crate::machine::Provenance;
use crate::output;
use tensorboard::Events;

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
    let mut config = read_config(&args.config)?;
    if let Some(seed) = args.seed {
        config.seed = seed;
    }
    std::fs::create_dir_all(&args.out)
        .map_err(|error| Failure::file(&args.out, format!("cannot be made ({error})")))?;
    let mut trainer = begin(args, config)?;
    let resumed_at = trainer.environment_steps();
    output::write_file(&args.out.join("config.toml"), to_toml(trainer.config())?.as_bytes())?;
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
        bar.set_message(message(&progress));
        if last_save.elapsed() >= interval {
            save(&args.out, &trainer, training_seconds)?;
            last_save = Instant::now();
        }
    }
    bar.finish_and_clear();
    save(&args.out, &trainer, training_seconds)?;
    let best = trainer.best();
    let summary = json!({
        "environment_steps": trainer.environment_steps(),
        "environment_steps_this_run": trainer.environment_steps() - resumed_at,
        "training_seconds": training_seconds,
        "validation_success": best.map(|best| best.validation.success()),
        "validation_iterations": best.map(|best| best.validation.mean_iterations),
        "best_environment_steps": best.map(|best| best.environment_steps),
        "provenance": Provenance::here(begin.elapsed().as_secs_f64()),
    });
    output::write_json(&args.out.join("summary.json"), &summary)?;
    if global.json {
        return output::print_json(&summary);
    }
    if !global.quiet {
        let success = best.map_or(f64::NAN, |best| 100.0 * best.validation.success());
        eprintln!(
            "{} steps in {training_seconds:.1} s; best on validation {success:.1} %: {}",
            trainer.environment_steps(),
            args.out.join("policy.safetensors").display(),
        );
    }
    Ok(())
}

/// Reads and checks a training configuration.
pub fn read_config(path: &Path) -> Result<TrainConfig, Failure> {
    TrainConfig::from_toml(&read_text(path)?).map_err(|error| Failure::file(path, error))
}

fn begin(args: &TrainArgs, config: TrainConfig) -> Result<Trainer, Failure> {
    let checkpoint = args.out.join(CHECKPOINT);
    match (checkpoint.exists(), args.resume) {
        (true, false) => {
            let hint = "holds a training already; give --resume to go on with it, or another --out";
            Err(Failure::file(&args.out, hint))
        }
        (true, true) => {
            let bytes = std::fs::read(&checkpoint)
                .map_err(|error| Failure::file(&checkpoint, format!("cannot be read ({error})")))?;
            let trainer =
                Trainer::resume(&bytes).map_err(|error| Failure::file(&checkpoint, error))?;
            if *trainer.config() != config {
                let reason = "was made with another configuration or seed than the one given";
                return Err(Failure::file(&checkpoint, reason));
            }
            Ok(trainer)
        }
        (false, _) => Ok(Trainer::new(config)?),
    }
}

fn to_toml(config: &TrainConfig) -> Result<String, Failure> {
    toml::to_string(config).map_err(|error| Failure::at("configuration", error))
}

fn message(progress: &Progress) -> String {
    let validation =
        progress.validation.map(|v| format!("validation {:.1} %", 100.0 * v.success()));
    validation.unwrap_or_default()
}

/// Writes checkpoint, best policy and logs.
fn save(folder: &Path, trainer: &Trainer, training_seconds: f64) -> Result<(), Failure> {
    output::write_file(
        &folder.join("policy.safetensors"),
        &trainer.best_policy()?.to_safetensors()?,
    )?;
    let mut lines = String::new();
    for progress in trainer.curve() {
        let line =
            serde_json::to_string(progress).map_err(|error| Failure::at("metrics", error))?;
        lines += &(line + "\n");
    }
    output::write_file(&folder.join("metrics.jsonl"), lines.as_bytes())?;
    let events = events(trainer, training_seconds);
    output::write_file(&folder.join("events.out.tfevents.0.sidestep"), events.bytes())?;
    output::write_file(&folder.join(CHECKPOINT), &trainer.checkpoint()?)
}

/// The curve under the tags that CleanRL uses.
fn events(trainer: &Trainer, training_seconds: f64) -> Events {
    let now = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0.0, |d| d.as_secs_f64());
    let curve = trainer.curve();
    let begin = now - training_seconds;
    let mut events = Events::new(begin);
    for (index, progress) in curve.iter().enumerate() {
        // Only the whole duration is known; units are spread evenly over it.
        let time = begin + training_seconds * (index + 1) as f64 / curve.len() as f64;
        let step = progress.environment_steps;
        let mut scalar = |tag: &str, value: f64| events.scalar(time, step, tag, value);
        if let Some(update) = &progress.update {
            scalar("charts/learning_rate", update.learning_rate);
            scalar("charts/episodic_length", update.episode_length);
            scalar("charts/mean_reward", update.mean_reward);
            scalar("losses/policy_loss", update.policy_loss);
            scalar("losses/value_loss", update.value_loss);
            scalar("losses/entropy", update.entropy);
            scalar("losses/approx_kl", update.approx_kl);
            scalar("losses/clipfrac", update.clip_fraction);
            scalar("losses/explained_variance", update.explained_variance);
            scalar("losses/gradient_norm", update.gradient_norm);
            if training_seconds > 0.0 {
                scalar("charts/SPS", trainer.environment_steps() as f64 / training_seconds);
            }
        }
        for (index, loss) in progress.cloning_losses.iter().enumerate() {
            events.scalar(time, index as u64, "losses/cloning", *loss);
        }
        if let Some(validation) = &progress.validation {
            events.scalar(time, step, "validation/success", validation.success());
            events.scalar(time, step, "validation/iterations", validation.mean_iterations);
        }
    }
    events
}
