//! An optimizer from one or more starts: the certified plan of least U.

use crate::error::InvalidInput;
use crate::objective::Objective;
use crate::optimizer::{Method, Optimizer};
use crate::plan::answer::{Origin, Plan, Reason, Status};
use crate::plan::options::{Options, Stop, Watch};
use crate::plan::parallel;
use crate::plan::run::{FARTHEST, Iteration, Run, Until, run};
use crate::rng::{Purpose, stream};
use crate::scene::{Query, Refused};
use crate::trajectory::Trajectory;
use crate::trajectory::waypoints::polyline;

/// One start's run: its waypoints end at the last iterate.
struct Attempt {
    start: usize,
    run: Run,
    waypoints: Vec<f32>,
}

/// Optimizes from every start that the options ask for.
pub(super) fn optimize(
    query: &Query,
    method: &Method,
    options: &Options,
    watch: Watch<'_>,
) -> Result<Plan, InvalidInput> {
    let waypoints = options.waypoints.unwrap_or(query.scene().profile().waypoints);
    if !query.scene().prepare_costs(watch.go_on) {
        return Ok(Plan::straight(query, waypoints));
    }
    let mut objective = Objective::new(query, waypoints)?;
    let attempt = |objective: &mut Objective, start: usize| {
        let mut x = vec![0.0; objective.dim()];
        let mut rng = stream(options.seed, Purpose::Start, options.index, start as u64);
        match (&options.warm_start, start) {
            (Some(warm), 0) => resample(objective, warm, &mut x)?,
            (None, 0) => objective.straight_line(&mut x),
            _ => options.strategy.draw(objective, &mut rng, &mut x),
        }
        attempt(objective, method, options, start, x, watch)
    };
    let first = attempt(&mut objective, 0)?;
    if options.stop == Stop::First && first.run.best.is_some() || options.starts == 1 {
        return Ok(chosen(&objective, options, vec![first]));
    }
    let other = |index: usize| attempt(&mut objective.clone(), index + 1);
    let others: Result<Vec<_>, _> = parallel::map(options.starts - 1, other).into_iter().collect();
    let attempts = std::iter::once(first).chain(others?).collect();
    Ok(chosen(&objective, options, attempts))
}

/// Runs the method from the waypoints `x`.
fn attempt(
    objective: &mut Objective,
    method: &Method,
    options: &Options,
    start: usize,
    mut x: Vec<f32>,
    watch: Watch<'_>,
) -> Result<Attempt, InvalidInput> {
    let rng = stream(options.seed, Purpose::Planner, options.index, start as u64);
    let mut optimizer = Optimizer::new(method, objective, rng)?;
    let until = match options.stop {
        Stop::First => Until::Certified,
        Stop::Best => Until::Spent,
    };
    let run = run(objective, &mut optimizer, &mut x, options.steps, until, |iteration| {
        watch.look(&Iteration { start, ..*iteration })
    });
    Ok(Attempt { start, run, waypoints: x })
}

/// The certified attempt of least U, the earliest at a tie; else the first start's failure.
fn chosen(objective: &Objective, options: &Options, attempts: Vec<Attempt>) -> Plan {
    let starts = attempts.len();
    let solved = attempts.iter().filter_map(|a| a.run.best.as_ref().map(|best| (a, best)));
    let best = solved.min_by(|(_, p), (_, q)| p.cost.total_cmp(&q.cost));
    // The certificate has passed the best iterate: so it does the trajectory that is made of it.
    let first = &attempts[0];
    let (attempt, waypoints, steps) = match best {
        Some((attempt, best)) => {
            let steps = attempt.run.first_certified.unwrap_or(attempt.run.steps);
            (attempt, &best.waypoints, steps)
        }
        None => (first, &first.waypoints, first.run.steps),
    };
    let origin = match attempt.start {
        0 => Origin::FirstStart,
        start => Origin::RandomStart(start),
    };
    match objective.query().certify(objective.trajectory(waypoints)) {
        // Also where the paper's check refuses a point on a wall that the exact one passes.
        Ok(certified) => Plan { status: Status::Solved(certified), attempt: None, steps, origin },
        Err(Refused { violation, trajectory }) => {
            let reason = if attempt.run.diverged {
                Reason::Diverged { steps, violation }
            } else if steps < options.steps {
                Reason::BrokenOff { steps, violation }
            } else {
                Reason::StepsSpent { steps, starts, violation }
            };
            Plan { status: Status::Unsolved(reason), attempt: Some(trajectory), steps, origin }
        }
    }
}

/// Spreads the objective's waypoints evenly along a trajectory's interior points.
fn resample(
    objective: &Objective,
    trajectory: &Trajectory,
    x: &mut [f32],
) -> Result<(), InvalidInput> {
    let dof = objective.dof();
    if trajectory.dof() != dof {
        let found = format!("configurations of {} numbers", trajectory.dof());
        let allowed = format!("configurations of {dof} numbers, as the task's robot has");
        return Err(InvalidInput::new("warm_start", found, allowed));
    }
    let inner = 1..trajectory.len().max(2) - 1;
    let inner = trajectory.values().get(inner.start * dof..inner.end * dof).unwrap_or(&[]);
    let mut corners = vec![0.0; inner.len() + 2 * dof];
    corners[..dof].copy_from_slice(objective.start());
    objective.scene().to_normalised(inner, &mut corners[dof..dof + inner.len()]);
    corners.iter_mut().for_each(|x| *x = x.clamp(-FARTHEST, FARTHEST));
    corners[dof + inner.len()..].copy_from_slice(objective.goal());
    polyline(dof, &corners, x);
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::plan::{Planner, plan};
    use crate::plane::Robot;
    use crate::plane::geometry::Rect;
    use crate::plane::world::{Obstacle, World};
    use crate::scene::Task;

    #[test]
    fn an_optimizer_that_diverges_ends_at_its_last_finite_iterate() {
        let field = |min, max| Rect::new(min, max).unwrap();
        let wall = Obstacle::Rect(field([4.0, 2.0], [6.0, 8.0]));
        let world = Arc::new(World::new(field([0.0; 2], [10.0; 2]), vec![wall], None));
        let task = Task::in_plane("", world, Robot::Point, [1.0, 5.0], [9.0, 5.0]).unwrap();
        let planner = Planner::Optimizer(Method::GradientDescent { step: Some(30.0) });
        let answer = plan(&task, &planner, &Options::default()).unwrap();
        assert!(
            matches!(answer.status, Status::Unsolved(Reason::Diverged { steps: 1.., .. })),
            "{answer:?}"
        );
        let path = answer.attempt.unwrap();
        assert!(path.values().iter().all(|x| x.abs() < 1e8), "{path:?}");
        // What an answer holds can be started from.
        let options = Options { warm_start: Some(path), ..Options::default() };
        plan(&task, &planner, &options).unwrap();
        let nowhere = Trajectory::from_points(&[[1.0, f64::NAN]]);
        let options = Options { warm_start: Some(nowhere), ..Options::default() };
        assert_eq!(plan(&task, &planner, &options).unwrap_err().field, "warm_start[0]");
    }
}
