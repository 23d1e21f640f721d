//! The planner for people who want a path: learned optimizers, and the exact shortest path behind them.
//!
//! 1. The straight line itself, where nothing is asked for but the first plan.
//! 2. The quick optimizer from the straight line; where more starts are asked for, the thorough one from all of them. A plan
//!    hardly longer than the straight line is the answer.
//! 3. The exact shortest path, which also proves that there is none. A plan of step 2 hardly
//!    longer than it is the answer.
//! 4. The shortest path made smooth ([`crate::plan::smooth`]).
//! 5. The shortest path itself.
//!
//! A warm start that is still free comes right after the straight line. On a map, where the first plan is asked for and something
//! stands on the warm start, a way round that is not much longer is the answer (`mend`): boxes move, maps hardly do.
//!
//! So every task is answered that the exact search decides in the time that there is, and no plan is longer than
//! [`LONGEST`] times the shortest, but for those from a warm start on a map. Where the search does not
//! decide, the thorough optimizer from random starts follows.
//!
//! The exact search knows nothing of robots with joints, nor do the shipped policies: `jointed` plans for them.

use crate::error::InvalidInput;
use crate::optimizer::Method;
use crate::plan::answer::{Origin, Plan, Status};
use crate::plan::exact::shortest;
use crate::plan::jointed;
use crate::plan::mend::mended;
use crate::plan::optimize::optimize;
use crate::plan::options::{Options, Stop, Watch};
use crate::plan::polish::{polish, score};
use crate::plan::smooth::{Smooth, smooth};
use crate::plane::PlaneScene;
use crate::policy::shipped;
use crate::scene::Query;
use crate::trajectory::{Trajectory, distance};

/// A plan may be this many times as long as the shortest path.
pub const LONGEST: f64 = 1.2;
/// Where the best is asked for on a map, a warm start that is still free is kept if it is at most
/// this many times as long as the shortest path; elsewhere [`LONGEST`] times.
const LONGEST_WARM: f64 = 1.05;
/// Steps of the quick optimizer: after so many, the exact path made smooth takes less time than going on.
const QUICK_STEPS: usize = 24;
/// Steps of a learned optimizer from each of several starts: it is through after a few, or hardly ever.
const LEARNED_STEPS: usize = 40;
/// Starts that are tried at least where the exact search does not decide.
const STARTS: usize = 5;

/// The optimizers of the planner `auto`.
#[derive(Debug, Clone)]
pub struct Auto {
    /// Tried first, from the straight line.
    pub quick: Method,
    /// Tried from many starts, where these are asked for or nothing else helps.
    pub thorough: Method,
}

impl Default for Auto {
    /// `sidestep-1-small` and `sidestep-1`.
    fn default() -> Self {
        Self {
            quick: Method::Learned(shipped::sidestep_1_small()),
            thorough: Method::Learned(shipped::sidestep_1()),
        }
    }
}

impl Auto {
    /// With the same optimizer for both parts.
    pub fn with(method: Method) -> Self {
        Self { quick: method.clone(), thorough: method }
    }

    pub(super) fn plan(
        &self,
        query: &Query,
        options: &Options,
        watch: Watch<'_>,
    ) -> Result<Plan, InvalidInput> {
        let (start, goal) = (query.start(), query.goal());
        // Nothing is shorter, so nothing is better, unless a cost of one's own says so.
        if query.terms().is_empty() && query.scene().motion_is_free(start, goal) {
            let waypoints = options.waypoints.unwrap_or(query.scene().profile().waypoints);
            return Ok(Plan::straight(query, waypoints));
        }
        if query.scene().arm().is_some() {
            let plan = jointed::plan(query, options, watch)?;
            return Ok(match &options.wishes {
                Some(wishes) => polish(query, plan, wishes, watch),
                None => plan,
            });
        }
        let on_map = query.scene().plane().is_some_and(PlaneScene::is_map);
        let wishes = options.wishes.unwrap_or_default();
        let polished = |plan: Plan| polish(query, plan, &wishes, watch);
        let warm = warm_start(query, options).filter(|_| query.terms().is_empty());
        if let Some(warm) = &warm
            && let plan = Plan::of(query, warm.clone(), 0, Origin::WarmStart)
            && plan.is_solved()
        {
            // What bends as little as is wished was polished before, most likely.
            let round = plan.certified().is_some_and(|path| wishes.are_kept(path));
            let kept = on_map && options.stop == Stop::First && round;
            let plan = if kept { plan } else { polished(plan) };
            let longest = if on_map { LONGEST_WARM } else { LONGEST };
            let short = |shortest: f64| {
                plan.certified().is_some_and(|path| path.length() <= longest * shortest)
            };
            // On a map the search costs far more than the check: who wants to know whether there is a shorter way by now asks for
            // the best.
            if short(distance(start, goal)) || on_map && options.stop == Stop::First {
                return Ok(plan);
            }
            let exact = shortest(query, watch);
            let exact = exact.filter(|exact| !exact.certified().is_none_or(|p| short(p.length())));
            return Ok(exact.map_or(plan, polished));
        }
        // Nor does it have to look at the whole map for what a box changed.
        if on_map
            && options.stop == Stop::First
            && let Some(warm) = &warm
            && let Some(plan) = mended(query, warm, options, watch)
        {
            return Ok(polished(plan));
        }
        if on_map
            && options.stop == Stop::First
            && options.starts == 1
            && query.terms().is_empty()
            && let Some(exact) = shortest(query, watch)
            && !matches!(exact.status, Status::Unsolved(_))
        {
            return Ok(polished(exact));
        }
        let plan = polished(self.first(query, options, watch)?);
        if options.stop == Stop::First || !query.terms().is_empty() {
            return Ok(plan);
        }
        // There is time for what would have been the first plan, and for the shortest path, which may be another way round.
        let quick = Options { stop: Stop::First, starts: 1, ..options.clone() };
        let quick = polished(self.first(query, &quick, watch)?);
        let exact = shortest(query, watch).map(polished);
        let scored = |plan: Plan| {
            let score = plan.certified().map_or(f64::INFINITY, |path| score(query, path, &wishes));
            (score, plan)
        };
        let better =
            |best: (f64, Plan), next: (f64, Plan)| if next.0 < best.0 { next } else { best };
        Ok([Some(quick), exact].into_iter().flatten().map(scored).fold(scored(plan), better).1)
    }

    /// A plan that is not polished yet.
    fn first(
        &self,
        query: &Query,
        options: &Options,
        watch: Watch<'_>,
    ) -> Result<Plan, InvalidInput> {
        let (start, goal) = (query.start(), query.goal());
        let is_short = |plan: &Plan, shortest: f64| {
            plan.certified().is_some_and(|path| path.length() <= LONGEST * shortest)
        };
        let with = |method: &Method, most: usize, starts: usize| {
            let steps = match method {
                Method::Learned(_) => options.steps.min(most),
                _ => options.steps,
            };
            optimize(query, method, &Options { steps, starts, ..options.clone() }, watch)
        };
        let straight_length = distance(start, goal);
        let mut optimized = with(&self.quick, QUICK_STEPS, 1)?;
        if options.starts > 1 && !is_short(&optimized, straight_length) {
            optimized = with(&self.thorough, LEARNED_STEPS, options.starts)?;
        }
        if is_short(&optimized, straight_length) {
            return Ok(optimized);
        }
        let Some(exact) = shortest(query, watch) else {
            return Ok(optimized);
        };
        let Some(path) = exact.certified() else {
            return match exact.status {
                _ if optimized.is_solved() => Ok(optimized),
                Status::Unsolved(_) if options.starts < STARTS => {
                    with(&self.thorough, LEARNED_STEPS, STARTS)
                }
                _ => Ok(Plan { attempt: optimized.attempt, ..exact }),
            };
        };
        if is_short(&optimized, path.length()) {
            return Ok(optimized);
        }
        let smooth = smoothed(query, path, Origin::SmoothShortestPath, options, watch)?;
        Ok(smooth.unwrap_or(exact))
    }
}

/// The warm start between the ends of the query, where there is one.
fn warm_start(query: &Query, options: &Options) -> Option<Trajectory> {
    let warm = options.warm_start.as_ref().filter(|warm| warm.dof() == query.start().len())?;
    let dof = warm.dof();
    let inner = warm.values().get(dof..warm.values().len().saturating_sub(dof)).unwrap_or(&[]);
    Some(Trajectory::new(dof, [query.start(), inner, query.goal()].concat()))
}

/// A certified path made smooth, where that works.
pub(super) fn smoothed(
    query: &Query,
    path: &Trajectory,
    origin: Origin,
    options: &Options,
    watch: Watch<'_>,
) -> Result<Option<Plan>, InvalidInput> {
    let smooth = smooth(query, path, LONGEST, options.steps, options.starts, watch)?;
    let plan = |smooth: Smooth| Plan::of(query, smooth.trajectory, smooth.steps, origin);
    Ok(smooth.map(plan).filter(Plan::is_solved))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::plan::{Planner, plan_batch, plan_in};
    use crate::plane::Robot;
    use crate::plane::shortest_path::ShortestPath;
    use crate::plane::world::{Grid, World};
    use crate::profile::Profile;
    use crate::scene::{PlaneTask, Task};
    use crate::suite::Suite;
    use crate::suite::queries::random_queries;

    /// Every decided task is answered, at most [`LONGEST`] times the shortest path long.
    fn check(tasks: &[Task], profile: Profile) -> Vec<Plan> {
        let planner = Planner::Auto(Auto::with(Method::GradientDescent { step: None }));
        let options = Options { profile, ..Options::default() };
        let plans = plan_batch(tasks, &planner, &options).unwrap();
        for (index, (task, plan)) in tasks.iter().zip(&plans).enumerate() {
            let PlaneTask { world, robot, start, goal, .. } = task.plane().unwrap();
            let route = ShortestPath::new(world, robot).find(start, goal);
            match (route.length(), plan.certified()) {
                (Some(length), Some(path)) => {
                    assert!(crate::certify(task, path).is_ok(), "{index}");
                    assert!(path.length() <= LONGEST * length + 1e-9, "{index}");
                }
                (Some(_), None) => panic!("{index}: {plan:?}"),
                (None, _) => assert!(matches!(plan.status, Status::Unsolvable(_)), "{index}"),
            }
        }
        plans
    }

    #[test]
    fn every_task_of_the_papers_kind_is_answered() {
        for profile in [Profile::DEFAULT, Profile::PAPER] {
            let plans = check(&Suite::Easy.generate(150, 1000, &Profile::PAPER), profile);
            let raw = plans.iter().filter(|plan| plan.origin == Origin::ShortestPath);
            // Those without a path, and hardly any that could not be made smooth.
            assert!(raw.count() <= 8);
        }
    }

    /// Queries in a maze: walls on every fourth row, with two doors each at pseudo-random columns.
    fn maze() -> Vec<Task> {
        let is_wall = |i: usize| {
            let (column, row) = (i % 60, i / 60);
            let door = |k: usize| (row * 37 + k * 23) % 56;
            row % 4 == 3 && (0..2).all(|k| !(door(k)..door(k) + 3).contains(&column))
        };
        let cells = (0..60 * 60).map(is_wall).collect();
        let grid = Grid::new(60, 60, 0.5, [0.0; 2], cells).unwrap();
        let world = Arc::new(World::new(grid.rect(), Vec::new(), Some(grid)));
        let robot = Robot::disc(0.3).unwrap();
        random_queries("maze", &world, robot, 30, 1000).unwrap()
    }

    #[test]
    fn every_query_in_a_maze_is_answered() {
        let tasks = maze();
        let plans = check(&tasks, Profile::DEFAULT);
        let sharp = plans.iter().filter_map(Plan::certified);
        let sharp = sharp.filter(|path| path.sharpest_turn().to_degrees() > 20.0).count();
        assert!(sharp == 0, "{sharp}");
    }

    #[test]
    fn a_spent_budget_ends_every_search() {
        let (planner, options) = (Planner::Auto(Auto::default()), Options::default());
        let watch = Watch { go_on: &|| false, ..Watch::NONE };
        let (mut solved, mut late) = (0, 0);
        for task in maze() {
            let query = Query::of(&task, &options.profile);
            let plan = plan_in(&query, &planner, &options, watch).unwrap();
            match plan.status {
                Status::Solved(_) => solved += 1,
                // From each start nothing but the start was looked at.
                Status::Unsolved(reason) => {
                    assert!(reason.to_string().contains("the time budget"), "{reason}");
                    late += 1;
                }
                other => panic!("{other:?}"),
            }
        }
        // Only straight lines are found in no time.
        assert!(late > 20 && solved + late == 30, "{solved} {late}");
    }
}
