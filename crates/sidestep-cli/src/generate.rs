//! `sidestep generate`: the tasks of a suite as a file.

use std::path::PathBuf;

use clap::Args;
use sidestep::InvalidInput;
use sidestep::profile::Profile;
use sidestep::suite::Suite;
use sidestep_io::{TaskFormat, write_tasks};

use crate::Global;
use crate::failure::Failure;
use crate::output;

/// Most tasks that one call writes.
const MAX_COUNT: usize = 10_000_000;

/// Arguments of `generate`.
#[derive(Args)]
pub struct GenerateArgs {
    /// easy, hard, hard-training, mix or time
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
    /// File to write, .jsonl (one task a line) or .json (an array)
    #[arg(long)]
    out: PathBuf,
}

/// Writes the file.
pub fn run(args: &GenerateArgs, global: &Global) -> Result<(), Failure> {
    let suite = Suite::named(&args.suite)?;
    let profile = Profile::named(&args.profile)?;
    let format = TaskFormat::from_file_name(&args.out.to_string_lossy())
        .ok_or_else(|| Failure::file(&args.out, "expected a name that ends in .json or .jsonl"))?;
    if !(1..=MAX_COUNT).contains(&args.count) {
        let allowed = format!("a number from 1 to {MAX_COUNT}");
        return Err(InvalidInput::new("--count", args.count, allowed).into());
    }
    output::check_outputs(&[("--out", &args.out)], &[])?;
    let tasks = suite.generate(args.count, args.seed, &profile);
    output::write_file(&args.out, write_tasks(&tasks, format).as_bytes())?;
    if !global.quiet {
        let GenerateArgs { suite, seed, out, .. } = args;
        let out = out.display();
        output::tell(&format!("{} tasks of {suite} (seed {seed}): {out}", tasks.len()));
    }
    Ok(())
}
