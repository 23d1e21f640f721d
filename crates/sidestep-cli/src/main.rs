//! The `sidestep` program: one file per verb.
//!
//! Exit codes: 0 done, or a certified plan; 1 no certified plan, the status says why; 2 bad input
//! or usage. With `--json`, standard output holds one JSON document and nothing else; progress and
//! messages go to standard error.

mod bench;
mod experiment;
mod failure;
mod generate;
mod input;
mod machine;
mod oracle;
mod output;
mod plan;
mod planning;
mod table;
mod train;

use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};

use failure::Failure;

/// Optimisation-based motion planning with classical and learned optimizers.
#[derive(Parser)]
#[command(name = "sidestep", version, propagate_version = true)]
struct Cli {
    #[command(flatten)]
    global: Global,
    #[command(subcommand)]
    verb: Verb,
}

/// Flags that every verb takes.
#[derive(Args, Clone)]
struct Global {
    /// Threads to use; 0 uses all cores. Results do not depend on it
    #[arg(long, global = true, default_value_t = 0)]
    threads: usize,
    /// No progress bars or messages
    #[arg(long, global = true)]
    quiet: bool,
    /// Print one JSON document on standard output
    #[arg(long, global = true)]
    json: bool,
}

#[derive(Subcommand)]
enum Verb {
    /// Plan one task and certify the plan
    Plan(plan::PlanArgs),
    /// Write the tasks of a suite to a file
    Generate(generate::GenerateArgs),
    /// Measure planners on suites or task files
    Bench(bench::BenchArgs),
    /// Render a report as a table
    Table(table::TableArgs),
    /// Train and measure what an experiment file names
    Experiment(experiment::ExperimentArgs),
    /// Train a policy
    Train(train::TrainArgs),
    /// Exact shortest path of each task, or the proof that there is none
    Oracle(oracle::OracleArgs),
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    if let Err(error) =
        rayon::ThreadPoolBuilder::new().num_threads(cli.global.threads).build_global()
    {
        eprintln!("warning: {error}");
    }
    let outcome = match cli.verb {
        Verb::Plan(args) => plan::run(&args, &cli.global),
        Verb::Generate(args) => generate::run(&args, &cli.global).map(|()| ExitCode::SUCCESS),
        Verb::Bench(args) => bench::run(&args, &cli.global).map(|()| ExitCode::SUCCESS),
        Verb::Table(args) => table::run(&args).map(|()| ExitCode::SUCCESS),
        Verb::Experiment(args) => experiment::run(&args, &cli.global).map(|()| ExitCode::SUCCESS),
        Verb::Train(args) => train::run(&args, &cli.global).map(|()| ExitCode::SUCCESS),
        Verb::Oracle(args) => oracle::run(&args, &cli.global).map(|()| ExitCode::SUCCESS),
    };
    outcome.unwrap_or_else(|Failure(message)| {
        eprintln!("error: {message}");
        ExitCode::from(2)
    })
}
