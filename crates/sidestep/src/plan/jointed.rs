//! The planner `auto` for robots with joints, where no search is exact: the straight line, a few steps of Levenberg-Marquardt from
//! it, and RRT-Connect, each with short cuts.
//!
//! Nothing is promised about the length, and a failure proves nothing. Where the best plan is asked for, as many ways are
//! looked for as there are starts (trees go the wrong way round as often as not), and the shortest is made smooth. What the
//! optimizer finds is shorter than what the trees do, and sooner there (docs/research/arms.md).

use crate::arm::MOST_JOINTS;
use crate::error::InvalidInput;
use crate::optimizer::Method;
use crate::plan::answer::{Origin, Plan, Reason, Status};
use crate::plan::auto::smoothed;
use crate::plan::optimize::optimize;
use crate::plan::options::{Options, Stop, Watch};
use crate::plan::rrt_connect::{RrtConnect, RrtRun, shortcut};
use crate::rng::{Purpose, stream};
use crate::scene::Query;

/// Steps of Levenberg-Marquardt where the best plan is asked for or nothing else helps: it is through after a few, or hardly ever.
const STEPS: usize = 12;
/// Steps before the trees where the first plan will do.
const FEW: usize = 4;
/// Random short cuts on a path.
const SHORT_CUTS: usize = 32;
/// Samples of the first pair of trees, and twice as many of each further one; most problems need a few hundred. Trees that grew badly
/// are better begun anew than grown on, but what is really narrow needs large ones.
const SAMPLES: usize = 100_000;
/// Nodes of a pair of trees. What is narrow has few, however many samples it takes; trees that fill all there is and do not meet
/// are slow, for each sample is compared with all of their nodes.
const MOST_NODES: usize = 50_000;
/// Samples of the first pair of trees where a proof that there is no way can follow.
const SAMPLES_BEFORE_PROOF: usize = 10_000;
/// Pairs of trees before giving up.
const RUNS: usize = 5;

/// Plans where the straight line is not free.
pub(super) fn plan(
    query: &Query,
    options: &Options,
    watch: Watch<'_>,
) -> Result<Plan, InvalidInput> {
    let first = options.stop == Stop::First;
    let tried = optimized(query, options, if first { FEW } else { STEPS }, watch)?;
    let mut best = shortened(query, options, &tried);
    if let (Some(plan), true) = (&best, first) {
        return Ok(plan.clone());
    }
    let wanted = if first { 1 } else { options.starts };
    let most = options.max_samples.unwrap_or(usize::MAX);
    let few_joints = query.scene().dof() <= MOST_JOINTS;
    let (mut spent, mut broken_off) = (0, false);
    for run in 0..RUNS.max(wanted) {
        if run >= wanted && best.is_some() || spent >= most {
            break;
        }
        if run > 0 && !(watch.go_on)() {
            broken_off = true;
            break;
        }
        let mut rng = stream(options.seed, Purpose::Planner, options.index, 1 + run as u64);
        let first_pair = if few_joints { SAMPLES_BEFORE_PROOF } else { SAMPLES };
        let max_samples = if run == 0 { first_pair } else { SAMPLES << run.min(RUNS - 1) };
        let max_samples = max_samples.min(most - spent);
        let planner = RrtConnect {
            shortcut_rounds: SHORT_CUTS,
            max_samples,
            max_nodes: MOST_NODES,
            ..RrtConnect::default()
        };
        let grown = planner.plan_while(query, &mut rng, watch.go_on);
        let RrtRun { trajectory, samples, .. } = grown;
        spent += samples;
        broken_off = grown.broken_off;
        let Some(path) = trajectory else {
            if run == 0
                && best.is_none()
                && !broken_off
                && let Some(proof) =
                    query.scene().disproof(query.start(), query.goal(), watch.go_on)
            {
                let none = Plan::none(Status::Unsolvable(proof), Origin::Tree);
                return Ok(Plan { attempt: tried.attempt, steps: tried.steps, ..none });
            }
            continue;
        };
        let length = |plan: &Plan| plan.certified().map_or(f64::INFINITY, |path| path.length());
        if best.as_ref().is_none_or(|best| path.length() < length(best)) {
            best = Some(Plan::of(query, path, 0, Origin::Tree));
        }
    }
    let Some(best) = best else {
        // What was tried for a while may be through after some more.
        let optimized = if first { optimized(query, options, STEPS, watch)? } else { tried };
        if let Some(plan) = shortened(query, options, &optimized) {
            return Ok(plan);
        }
        let reason = if broken_off {
            Reason::SamplingBrokenOff { samples: spent }
        } else {
            Reason::SamplesSpent { samples: spent }
        };
        let none = Plan::none(Status::Unsolved(reason), Origin::Tree);
        return Ok(Plan { attempt: optimized.attempt, steps: optimized.steps, ..none });
    };
    let smooth = match (options.stop, best.certified()) {
        (Stop::Best, Some(path)) => smoothed(query, path, Origin::SmoothTree, options, watch)?,
        _ => None,
    };
    Ok(smooth.unwrap_or(best))
}

/// A few steps of Levenberg-Marquardt from the straight line.
fn optimized(
    query: &Query,
    options: &Options,
    steps: usize,
    watch: Watch<'_>,
) -> Result<Plan, InvalidInput> {
    let method = Method::levenberg_marquardt();
    let few = Options { steps: options.steps.min(steps), starts: 1, ..options.clone() };
    optimize(query, &method, &few, watch)
}

/// What was optimized with short cuts, if it is a plan.
fn shortened(query: &Query, options: &Options, optimized: &Plan) -> Option<Plan> {
    let mut path = optimized.certified()?.clone();
    let mut rng = stream(options.seed, Purpose::Planner, options.index, 0);
    let is_free = |from: &[f64], to: &[f64]| query.scene().motion_is_free(from, to);
    shortcut(&mut path, is_free, SHORT_CUTS, &mut rng);
    Some(Plan::of(query, path, optimized.steps, optimized.origin))
}
