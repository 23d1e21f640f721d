//! An optimizer of one's own, beside the ones that are there, on the paper's easy tasks:
//! `cargo run --release -p sidestep --example own_optimizer`.
#![allow(clippy::print_stdout, reason = "an example")]

use sidestep::optimizer::{Method, Own};
use sidestep::{InvalidInput, Options, Planner, Profile, Suite, plan_batch};

fn main() -> Result<(), InvalidInput> {
    // AdaGrad: each coordinate's steps shrink with what its gradients were. The closure is called once for each start, and what
    // it returns once for each iteration.
    let adagrad = Own::new(|objective| {
        let mut seen = vec![1e-6; objective.dim()];
        Box::new(move |x, known, _| {
            for ((x, g), seen) in x.iter_mut().zip(known.gradient).zip(&mut seen) {
                *seen += g * g;
                *x -= 0.2 * g / seen.sqrt();
            }
        })
    });
    let planners = [
        ("gd", "gd".parse()?),
        ("adam", "adam".parse()?),
        ("adagrad, ours", Planner::Optimizer(Method::Own(adagrad))),
        ("sidestep-1-small", "sidestep-1-small".parse()?),
    ];
    let tasks = Suite::Easy.generate(500, 7, &Profile::PAPER);
    for (name, planner) in planners {
        let plans = plan_batch(&tasks, &planner, &Options::default())?;
        let solved = plans.iter().filter(|plan| plan.is_solved()).count();
        println!("{name:18} {:5.1} %", 100.0 * solved as f64 / plans.len() as f64);
    }
    Ok(())
}
