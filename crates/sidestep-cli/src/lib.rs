//! The `sidestep` program as a library: one file per verb, and [`main_with`], which runs it. So a
//! package for another language can carry the program without a second executable.
//!
//! Exit codes: 0 done, or a certified plan; 1 no certified plan, the status says why, or a training
//! that diverged; 2 bad input or usage, or a result that could not be written; 130 a training that
//! was stopped. With `--json`, standard output holds one JSON
//! document and nothing else; progress and messages go to standard error. An output that nobody
//! reads (a closed pipe) and messages that cannot be shown change no exit code.
//!
//! `SIDESTEP_KERNELS=portable`, `avx2` or `avx512` keeps to the kernels of that instruction set
//! ([`sidestep::kernels`]), to reproduce what another machine answers.

mod arguments;
mod bench;
mod bends;
mod completions;
mod driving;
mod experiment;
mod failure;
mod generate;
mod info;
mod input;
mod kernels;
mod lock;
mod machine;
mod obstacle;
mod output;
mod plan;
mod planners;
mod planning;
mod robots;
mod serve;
mod shortest;
mod smooth;
mod source;
mod table;
mod threads;
mod train;

use std::ffi::OsString;

use clap::{Args, CommandFactory, Parser, Subcommand};

use failure::Failure;

/// Optimisation-based motion planning with classical and learned optimizers.
#[derive(Parser)]
#[command(name = "sidestep", version = env!("SIDESTEP_VERSION"), propagate_version = true)]
#[command(after_help = "Example:\n  sidestep plan TASK.json --png picture.png\n\n\
    `sidestep VERB --help` has examples of each verb. Exit codes: 0 a certified plan, or done; \
    1 no certified plan; 2 bad input.")]
struct Cli {
    #[command(flatten)]
    global: Global,
    #[command(subcommand)]
    verb: Verb,
}

/// Flags that every verb takes.
#[derive(Args, Clone)]
struct Global {
    /// Threads to use, at most 512; 0 uses all cores. Results do not depend on it
    #[arg(
        long,
        global = true,
        default_value_t = 0,
        allow_negative_numbers = true,
        help_heading = "Every verb"
    )]
    threads: usize,
    /// No progress bars or messages
    #[arg(long, global = true, help_heading = "Every verb")]
    quiet: bool,
    /// Print one JSON document on standard output
    #[arg(long, global = true, help_heading = "Every verb")]
    json: bool,
}

#[derive(Subcommand)]
enum Verb {
    /// Plan one task and certify the plan
    Plan(Box<plan::PlanArgs>),
    /// Smooth and certify a path that something else made
    Smooth(smooth::SmoothArgs),
    /// Answer requests about one map, a line of JSON each
    Serve(serve::ServeArgs),
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
    /// Say what is read of a robot with joints, and keep it as one file
    Robot(robots::RobotVerbArgs),
    /// Exact shortest path of each task, or the proof that there is none
    Shortest(shortest::ShortestArgs),
    /// List the planners and their settings
    Planners(planners::PlannersArgs),
    /// Say what a policy is: what it sees, its size, how it was trained
    Info(info::InfoArgs),
    /// Print completions for a shell
    Completions(completions::CompletionsArgs),
    /// Write manual pages
    #[command(hide = true)]
    Man(completions::ManArgs),
}

/// Runs the program on a command line that begins with the program's name, and answers its exit
/// code. The threads of the first call serve every later one in the same process.
pub fn main_with<I>(arguments: I) -> u8
where
    I: IntoIterator,
    I::Item: Into<OsString> + Clone,
{
    let arguments = arguments::understood(arguments.into_iter().map(Into::into));
    let cli = match Cli::try_parse_from(arguments.words) {
        Ok(cli) => cli,
        Err(message) => {
            // Help and usage that cannot be shown are nobody's mistake.
            let _ = message.print();
            return if message.use_stderr() { 2 } else { 0 };
        }
    };
    if !cli.global.quiet {
        arguments.notes.iter().for_each(|note| output::tell(&format!("note: {note}")));
    }
    match run(cli) {
        Ok(code) => code,
        Err(failure) => {
            output::tell(&format!("error: {failure}"));
            2
        }
    }
}

fn run(cli: Cli) -> Result<u8, Failure> {
    let global = &cli.global;
    kernels::limit()?;
    threads::start(global.threads)?;
    let done = |()| 0;
    match cli.verb {
        Verb::Plan(args) => plan::run(&args, global),
        Verb::Smooth(args) => smooth::run(&args, global),
        Verb::Serve(args) => serve::run(&args, global).map(done),
        Verb::Generate(args) => generate::run(&args, global).map(done),
        Verb::Bench(args) => bench::run(&args, global).map(done),
        Verb::Table(args) => table::run(&args, global).map(done),
        Verb::Experiment(args) => experiment::run(&args, global).map(done),
        Verb::Train(args) => train::run(&args, global),
        Verb::Robot(args) => robots::run(&args, global).map(done),
        Verb::Shortest(args) => shortest::run(&args, global).map(done),
        Verb::Planners(_) => planners::run(global).map(done),
        Verb::Info(args) => info::run(&args, global).map(done),
        Verb::Completions(args) => completions::run(&args, Cli::command(), global).map(done),
        Verb::Man(args) => completions::manual(&args, Cli::command(), global).map(done),
    }
}
