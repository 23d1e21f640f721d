//! `sidestep train`: a configuration to a policy, with checkpoints and logs ([`folder`]).
//!
//! Exit code 0 if the training is done, 1 if it diverged, 130 if it was stopped. In each case the
//! folder holds a whole state.

mod folder;
mod interrupt;
mod pace;
pub mod tensorboard;

use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::Args;
use serde_json::{Value, json};
use sidestep_train::config::toml_file;
use sidestep_train::{Recipe, Training};

use crate::Global;
use crate::failure::Failure;
use crate::input::read_text;
use crate::machine::Provenance;
use crate::output;
use crate::planning::load_policy;
use folder::Folder;
use interrupt::Interrupt;
use pace::Pace;

/// Arguments of `train`.
#[derive(Args)]
pub struct TrainArgs {
    /// Training configuration
    config: PathBuf,
    /// Folder for the policy, checkpoints and logs
    #[arg(long)]
    out: PathBuf,
    /// Go on from the folder's checkpoint; the configuration may ask for more steps than before
    #[arg(long)]
    resume: bool,
    /// Training seed in place of the configuration's
    #[arg(long)]
    seed: Option<u64>,
    /// Value in place of the configuration's, such as ppo.learning_rate=1e-3; may be given several
    /// times
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Begin from the weights of this policy
    #[arg(long, value_name = "POLICY", conflicts_with = "resume")]
    init: Option<PathBuf>,
    /// Seconds between checkpoints
    #[arg(long, default_value_t = 30.0, allow_negative_numbers = true)]
    checkpoint_every: f64,
}

/// How a run ended.
enum End {
    Finished,
    Stopped,
    Diverged(String),
}

/// Trains to the end, and answers the exit code.
pub fn run(args: &TrainArgs, global: &Global) -> Result<u8, Failure> {
    let recipe = recipe(args)?;
    let interval = Duration::try_from_secs_f64(args.checkpoint_every).map_err(|_| {
        let found = format!("{} is not allowed", args.checkpoint_every);
        Failure::at("--checkpoint-every", format!("{found}; expected seconds, 0 or more"))
    })?;
    let begin = Instant::now();
    let interrupt = Interrupt::listen()?;
    let folder = Folder::open(&args.out)?;
    let mut training = begin_training(args, &recipe, &folder, global.quiet)?;
    let steps_before = training.environment_steps();
    folder.write_config(&recipe)?;
    let mut pace = Pace::of(&*training, global.quiet);
    let (mut seconds, mut last_save) = (0.0, Instant::now());
    // At once, so that there is something to go on from whatever happens.
    folder.save(&*training, seconds)?;
    let end = loop {
        if interrupt.is_wanted() {
            break End::Stopped;
        }
        let unit = Instant::now();
        let made = training.step();
        seconds += unit.elapsed().as_secs_f64();
        match made {
            Ok(None) => break End::Finished,
            Ok(Some(made)) => pace.step(&*training, made.validation),
            Err(divergence) => break End::Diverged(divergence.to_string()),
        }
        if last_save.elapsed() >= interval {
            folder.save(&*training, seconds)?;
            last_save = Instant::now();
        }
    };
    pace.end();
    folder.save(&*training, seconds)?;
    let mut summary = training.summary();
    summary["outcome"] = json!(end.name());
    summary["environment_steps"] = json!(training.environment_steps());
    summary["environment_steps_this_run"] = json!(training.environment_steps() - steps_before);
    summary["training_seconds"] = json!(seconds);
    summary["provenance"] = json!(Provenance::here(begin.elapsed().as_secs_f64()));
    folder.write_summary(&summary)?;
    if global.json {
        output::print_json(&summary)?;
    }
    if !global.quiet {
        output::tell(&end.words(&*training, &folder, &summary, args));
    }
    Ok(end.code())
}

impl End {
    fn name(&self) -> &'static str {
        match self {
            Self::Finished => "finished",
            Self::Stopped => "stopped",
            Self::Diverged(_) => "diverged",
        }
    }

    fn code(&self) -> u8 {
        match self {
            Self::Finished => 0,
            Self::Diverged(_) => 1,
            Self::Stopped => interrupt::EXIT,
        }
    }

    /// What happened, and what to do next.
    fn words(
        &self,
        training: &dyn Training,
        folder: &Folder,
        summary: &Value,
        args: &TrainArgs,
    ) -> String {
        let (steps, units) = (training.environment_steps(), training.units());
        let policy = folder.policy();
        let policy = policy.display();
        let found = match summary["validation_success"].as_f64() {
            Some(success) => format!("best on validation {:.1} %", 100.0 * success),
            None => "the last policy, as nothing was validated".into(),
        };
        match self {
            Self::Finished => {
                let seconds = summary["training_seconds"].as_f64().unwrap_or_default();
                format!("{steps} steps in {seconds:.1} s; {found}: {policy}")
            }
            Self::Stopped => format!(
                "stopped after unit {} of {}; go on with\n  sidestep train {} --out {} --resume",
                units.done,
                units.all,
                folder.config().display(),
                args.out.display()
            ),
            Self::Diverged(words) => format!("{words}; {found}, before that: {policy}"),
        }
    }
}

/// The configuration that file and flags ask for.
fn recipe(args: &TrainArgs) -> Result<Recipe, Failure> {
    let text = read_text(&args.config)?;
    let inside = |error| Failure::file(&args.config, error);
    let mut table = toml_file::table(&text).map_err(inside)?;
    if table.contains_key("measure") {
        let hint = "is an experiment; run `sidestep experiment` on it";
        return Err(Failure::file(&args.config, hint));
    }
    let recipe = if args.set.is_empty() {
        Recipe::from_toml(&text).map_err(inside)?
    } else {
        for setting in &args.set {
            toml_file::merge(&mut table, &toml_file::setting(setting)?);
        }
        let place = format!("{} with --set", args.config.display());
        Recipe::from_table(&table).map_err(|error| Failure::at(place, error))?
    };
    Ok(match args.seed {
        Some(seed) => recipe.with_seed(seed),
        None => recipe,
    })
}

fn begin_training(
    args: &TrainArgs,
    recipe: &Recipe,
    folder: &Folder,
    quiet: bool,
) -> Result<Box<dyn Training>, Failure> {
    let stored = folder.read_checkpoint()?;
    if stored.is_some() && !args.resume {
        let hint = "holds a training already; give --resume to go on with it, or another --out";
        return Err(Failure::file(&args.out, hint));
    }
    if stored.is_none() && args.resume {
        let hint = "holds no checkpoint to go on from; leave --resume out to begin a training";
        return Err(Failure::file(&args.out, hint));
    }
    let init = args.init.as_deref().map(load_policy).transpose()?;
    let bar = output::spinner("drawing the tasks", quiet);
    let training = match stored {
        Some(bytes) => {
            recipe.resume(&bytes).map_err(|error| Failure::file(&folder.checkpoint(), error))?
        }
        None => recipe.begin(init.as_ref()).map_err(|error| Failure::file(&args.config, error))?,
    };
    bar.finish_and_clear();
    Ok(training)
}
