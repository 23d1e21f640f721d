//! `sidestep generate`: the tasks of a suite as a file.

mod arms;

use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;
use sidestep::profile::Profile;
use sidestep::suite::Suite;
use sidestep::suite::arms::ArmSuite;
use sidestep::{InvalidInput, Task};
use sidestep_io::{TaskFormat, write_tasks};

use crate::Global;
use crate::failure::Failure;
use crate::output;

/// Most tasks that one call draws: a gigabyte of them.
pub const MAX_COUNT: usize = 1_000_000;

/// Arguments of `generate`.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  sidestep generate --suite hard --count 100 --seed 7 --out tasks.jsonl\n  \
    sidestep generate --suite planar-arm --dof 3 --count 50 --seed 7 --out planar.json\n  \
    sidestep generate --suite shelf --robot panda.urdf --srdf panda.srdf --group panda_arm --tool panda_hand \
    --count 20 --seed 7 --out shelf.json"
)]
pub struct GenerateArgs {
    /// In the plane: easy, hard, hard-training, mix, time, varied, rooms, blobs or scans. For robots with joints: planar-arm, box, shelf, table,
    /// cage, or one kind of shelf or table (bookshelf_small, _tall, _thin, table_pick, table_under_pick)
    #[arg(long)]
    suite: String,
    /// Number of tasks
    #[arg(long, allow_negative_numbers = true)]
    count: usize,
    /// Seed of the suite
    #[arg(long, allow_negative_numbers = true)]
    seed: u64,
    /// The gradient descent that decides what is hard: paper or default
    #[arg(long, default_value = "paper")]
    profile: String,
    /// File to write, .jsonl (one task a line) or .json (an array; for robots with joints, problems)
    #[arg(long)]
    out: PathBuf,
    #[command(flatten, next_help_heading = "Robot with joints")]
    arms: arms::ArmArgs,
}

/// What was written, as JSON.
#[derive(Serialize)]
struct Written<'a> {
    suite: &'static str,
    seed: u64,
    tasks: usize,
    out: &'a Path,
}

/// Writes the file.
pub fn run(args: &GenerateArgs, global: &Global) -> Result<(), Failure> {
    if let Some(suite) = arms::suite(&args.suite) {
        return arms::run(suite, args, global);
    }
    let suite = args.suite.parse::<Suite>().map_err(|error| {
        let arms = ArmSuite::NAMES.map(|(name, _)| name).join(", ");
        Failure(format!("{error}; for robots with joints {arms}"))
    })?;
    arms::refuse(&args.arms)?;
    let profile = args.profile.parse::<Profile>()?;
    let format = TaskFormat::from_file_name(&args.out.to_string_lossy())
        .ok_or_else(|| Failure::file(&args.out, "expected a name that ends in .json or .jsonl"))?;
    if !(1..=MAX_COUNT).contains(&args.count) {
        let allowed = format!("a number from 1 to {MAX_COUNT}");
        return Err(InvalidInput::new("--count", args.count, allowed).into());
    }
    output::check_outputs(&[("--out", &args.out)], &[])?;
    let tasks = draw(&suite, args.count, args.seed, &profile, global.quiet);
    output::write_file(&args.out, write_tasks(&tasks, format)?.as_bytes())?;
    if global.json {
        let written =
            Written { suite: suite.name(), seed: args.seed, tasks: tasks.len(), out: &args.out };
        output::print_json(&written)?;
    } else if !global.quiet {
        let GenerateArgs { suite, seed, out, .. } = args;
        let out = out.display();
        output::tell(&format!("{} tasks of {suite} (seed {seed}): {out}", tasks.len()));
    }
    Ok(())
}

/// Draws the tasks of a suite under a progress bar.
pub fn draw(suite: &Suite, count: usize, seed: u64, profile: &Profile, quiet: bool) -> Vec<Task> {
    let label = format!("tasks of {}, seed {seed}", suite.name());
    let bar = output::progress(&label, count as u64, quiet);
    // A batch may hold more than are asked for.
    let kept = || bar.inc(u64::from(bar.position() < count as u64));
    let tasks = suite.generate_watched(count, seed, profile, &kept);
    bar.finish_and_clear();
    tasks
}
