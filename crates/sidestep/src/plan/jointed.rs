//! The planner `auto` for robots with joints, where no search is exact: the straight line, a few steps of L-BFGS from it, and
//! RRT-Connect; short cuts on what is found.
//!
//! Nothing is promised about the length, and a failure proves nothing. Where the best plan is asked for, as many ways are
//! looked for as there are starts (trees go the wrong way round as often as not), and the shortest is made smooth.

use crate::error::InvalidInput;
use crate::optimizer::Method;
use crate::plan::answer::{Origin, Plan, Reason, Status};
use crate::plan::auto::smoothed;
use crate::plan::optimize::optimize;
use crate::plan::options::{Options, Stop, Watch};
use crate::plan::rrt_connect::{RrtConnect, RrtRun, shortcut};
use crate::rng::{Purpose, stream};
use crate::scene::Query;

/// Steps of L-BFGS: it is through after a few, or hardly ever.
const STEPS: usize = 12;
/// Pairs that L-BFGS remembers.
const MEMORY: usize = 7;
/// Random short cuts on a path.
const SHORT_CUTS: usize = 32;
/// Samples of the trees: what a narrow passage needs. Most problems need a few hundred, a few per cent more than 20,000.
const SAMPLES: usize = 1_000_000;

/// Plans where the straight line is not free.
pub(super) fn plan(
    query: &Query,
    options: &Options,
    watch: Watch<'_>,
) -> Result<Plan, InvalidInput> {
    let method = Method::Lbfgs { memory: MEMORY };
    let few = Options { steps: options.steps.min(STEPS), starts: 1, ..options.clone() };
    let optimized = optimize(query, &method, &few, watch)?;
    let mut best = None;
    if let Some(found) = optimized.certified() {
        let mut path = found.clone();
        let mut rng = stream(options.seed, Purpose::Planner, options.index, 0);
        let is_free = |from: &[f64], to: &[f64]| query.scene().motion_is_free(from, to);
        shortcut(&mut path, is_free, SHORT_CUTS, &mut rng);
        best = Some(Plan::of(query, path, optimized.steps, optimized.origin));
    }
    let trees = match (options.stop, best.is_some()) {
        (Stop::First, true) => 0,
        (Stop::First, false) => 1,
        (Stop::Best, _) => options.starts,
    };
    let planner =
        RrtConnect { shortcut_rounds: SHORT_CUTS, max_samples: SAMPLES, ..RrtConnect::default() };
    let (mut spent, mut broken_off) = (0, false);
    for run in 0..trees {
        if run > 0 && !(watch.go_on)() {
            break;
        }
        let mut rng = stream(options.seed, Purpose::Planner, options.index, 1 + run as u64);
        let RrtRun { trajectory, samples, .. } = planner.plan_while(query, &mut rng, watch.go_on);
        spent += samples;
        broken_off = trajectory.is_none() && samples < planner.max_samples;
        let Some(path) = trajectory else { continue };
        let length = |plan: &Plan| plan.certified().map_or(f64::INFINITY, |path| path.length());
        if best.as_ref().is_none_or(|best| path.length() < length(best)) {
            best = Some(Plan::of(query, path, optimized.steps, Origin::Tree));
        }
    }
    let Some(best) = best else {
        let reason = if broken_off {
            Reason::SamplingBrokenOff { samples: spent }
        } else {
            Reason::SamplesSpent { samples: spent }
        };
        let status = Status::Unsolved(reason);
        let none = Plan::none(status, Origin::Tree);
        return Ok(Plan { attempt: optimized.attempt, steps: optimized.steps, ..none });
    };
    let smooth = match (options.stop, best.certified()) {
        (Stop::Best, Some(path)) => smoothed(query, path, Origin::SmoothTree, options, watch)?,
        _ => None,
    };
    Ok(smooth.unwrap_or(best))
}
