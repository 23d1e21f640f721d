//! A part of an observation of one's own, without a change here: the paper's agent that also sees how far each waypoint is along the
//! way. `cargo run --release -p sidestep-train --example own_observation`.
#![allow(clippy::print_stdout, reason = "an example")]

use std::sync::Arc;

use sidestep::optimizer::Method;
use sidestep::policy::observation::OwnPart;
use sidestep::{InvalidInput, Options, Planner, Policy, Profile, Suite, plan_batch};
use sidestep_train::{TrainConfig, Trainer};

fn main() -> Result<(), InvalidInput> {
    let progress = OwnPart {
        name: "progress",
        len: |waypoints, _| waypoints,
        write: |_, _, _, out| {
            let count = out.len() as f32;
            out.iter_mut().enumerate().for_each(|(i, out)| *out = (i + 1) as f32 / (count + 1.0));
        },
    };
    let config = TrainConfig {
        observation: vec!["gradient".into(), "own:progress".into()],
        ..TrainConfig::from_toml("environment_steps = 20000\ntraining.count = 100")?
    };
    let mut trainer = Trainer::seeing(&[progress], config)?;
    while trainer.step().map_err(|_| InvalidInput::new("training", "diverged", "finite"))?.is_some()
    {
    }
    // Its file names the part; who reads it gives the part again.
    let file = trainer.best_policy()?.to_safetensors()?;
    let policy = Arc::new(Policy::read_seeing(&[progress], &file)?);
    let tasks = Suite::Easy.generate(500, 7, &Profile::PAPER);
    let options = Options { profile: Profile::PAPER, ..Options::default() };
    let planner = Planner::Optimizer(Method::Learned(policy));
    let solved =
        plan_batch(&tasks, &planner, &options)?.iter().filter(|plan| plan.is_solved()).count();
    println!("{:.1} % of easy tasks", 100.0 * solved as f64 / tasks.len() as f64);
    Ok(())
}
