//! The Rust side of `scripts/bench_python`: what stepping environments and planning cost without Python, as one line of JSON.
//! Arguments: environments, steps of each, tasks, plans.
#![allow(clippy::print_stdout, reason = "it is what this program is for")]

use std::time::Instant;

use sidestep::plan::{Watch, plan_in};
use sidestep::policy::{ActionRule, observation::ObservationPart};
use sidestep::{InvalidInput, Options, Planner, Profile, Query, Suite, plan_batch};
use sidestep_train::environments::{Environments, Rules};

/// Seconds of `work`, the least of some runs.
fn least(
    runs: usize,
    mut work: impl FnMut() -> Result<(), InvalidInput>,
) -> Result<f64, InvalidInput> {
    let mut best = f64::INFINITY;
    for _ in 0..runs {
        let begin = Instant::now();
        work()?;
        best = best.min(begin.elapsed().as_secs_f64());
    }
    Ok(best)
}

fn main() -> Result<(), InvalidInput> {
    let numbers: Vec<usize> =
        std::env::args().skip(1).filter_map(|word| word.parse().ok()).collect();
    let &[count, steps, tasks, plans] = &numbers[..] else {
        let allowed = "environments, steps, tasks and plans";
        return Err(InvalidInput::new("arguments", format!("{numbers:?}"), allowed));
    };
    let easy = Suite::Easy.generate(count, 0, &Profile::PAPER);
    let limit = Some(200);
    let rules =
        Rules { action: ActionRule::PAPER, mu: 0.1, feasible_bonus: 0.0, episode_limit: limit };
    let parts = [ObservationPart::Gradient];
    let mut all = Environments::new(&easy, &Profile::PAPER, &parts, rules, count, 0)?;
    let mut seen = vec![0.0; count * all.observation_size()];
    all.observe(&mut seen);
    let stepping = least(3, || {
        for _ in 0..steps {
            let actions: Vec<f32> = seen.iter().map(|gradient| -0.1 * gradient).collect();
            let outcomes = all.step(&actions);
            for (index, _) in outcomes.iter().enumerate().filter(|(_, outcome)| outcome.done()) {
                all.reset(index);
            }
            all.observe(&mut seen);
        }
        Ok(())
    })?;
    let many = Suite::Easy.generate(tasks, 0, &Profile::PAPER);
    // As the package asks: what is not solved is proved, where it can be.
    let (auto, options) = (Planner::default(), Options { prove: true, ..Options::default() });
    let batch = least(3, || plan_batch(&many, &auto, &options).map(|_| ()))?;
    let mut single = serde_json::Map::new();
    for name in ["shortest-path", "sidestep-1-small", "gd"] {
        let planner: Planner = name.parse()?;
        let one = least(5, || {
            for task in many.iter().cycle().take(plans) {
                let query = Query::of(task, &options.profile);
                plan_in(&query, &planner, &options, Watch { see: &|_| {}, go_on: &|| true })?;
            }
            Ok(())
        })?;
        single.insert(name.into(), (one / plans as f64 * 1e6).into());
    }
    let steps_per_second = (count * steps) as f64 / stepping;
    println!(
        "{}",
        serde_json::json!({
            "steps_per_second": steps_per_second, "batch_seconds": batch, "plan_us": single,
        })
    );
    Ok(())
}
