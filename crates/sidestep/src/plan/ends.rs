//! Plans with a margin that an end does not have.

use crate::error::InvalidInput;
use crate::plan::answer::{Origin, Plan, Status};
use crate::plan::fair::fair;
use crate::plan::options::{Options, Watch};
use crate::plan::planner::Planner;
use crate::plan::polish::{Wishes, reach, taut};
use crate::plane::ends::{EndChange, Relaxed};
use crate::scene::Query;

use super::plan_in;

/// Plans with a margin: `asked` is the question for the robot with it, `own` the same for the robot itself. Where the robot stands
/// freely at an end but not with the margin, the margin is relaxed near that end, and the answer says so. What is
/// certified then is the path for the robot itself, and all of it but what lies near such an end with the margin.
///
/// # Errors
/// As [`plan()`](crate::plan::plan()).
pub fn plan_with_margin(
    own: &Query,
    asked: &Query,
    planner: &Planner,
    options: &Options,
    watch: Watch<'_>,
) -> Result<(Plan, Vec<EndChange>), InvalidInput> {
    let as_asked = || Ok((plan_in(asked, planner, options, watch)?, Vec::new()));
    let scenes = own.scene().plane().zip(asked.scene().plane());
    let ends = [own.start(), own.goal()];
    let Some(relaxed) = scenes.and_then(|(own, asked)| Relaxed::of(own, asked, ends)) else {
        return as_asked();
    };
    let [from, to] = relaxed.places();
    let inner = plan_in(&asked.between(from, to), planner, options, watch)?;
    let path = match (&inner.status, inner.certified()) {
        (_, Some(path)) => relaxed.joined(path),
        // From other places near the end there might be a way.
        (Status::Unsolvable(_), _) => return as_asked(),
        _ => return Ok((inner, relaxed.changes)),
    };
    let is_auto = matches!(planner, Planner::Auto(_));
    let path = match options.wishes.or_else(|| is_auto.then(Wishes::default)) {
        None => path,
        Some(wishes) => {
            let is_free = |a: &[f64], b: &[f64]| relaxed.motion_is_free(a, b);
            fair(&taut(&path, &is_free), reach(own, &wishes), &wishes, &is_free, watch.go_on)
        }
    };
    let origin = match inner.origin {
        Origin::ShortestPath => Origin::SmoothShortestPath,
        other => other,
    };
    Ok((Plan::of(own, path, inner.steps, origin), relaxed.changes))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::plane::Robot;
    use crate::plane::certificate::Certifier;
    use crate::plane::ends::Change;
    use crate::plane::geometry::{Point, Rect, distance};
    use crate::plane::world::{Obstacle, World};
    use crate::profile::Profile;
    use crate::scene::Task;

    /// A field of 20 x 10 with a block in the middle of its lower side.
    fn task(start: Point, goal: Point, radius: f64) -> Task {
        let block = Obstacle::Rect(Rect::new([8.0, 0.0], [12.0, 6.0]).unwrap());
        let bounds = Rect::new([0.0; 2], [20.0, 10.0]).unwrap();
        let world = Arc::new(World::new(bounds, vec![block], None));
        Task::in_plane("", world, Robot::disc(radius).unwrap(), start, goal).unwrap()
    }

    fn planned(task: &Task, margin: f64, planner: &str) -> (Plan, Vec<EndChange>) {
        let query = |task: &Task| Query::of(task, &Profile::DEFAULT);
        let asked = query(&task.with_margin(margin).unwrap());
        let planner = planner.parse().unwrap();
        plan_with_margin(&query(task), &asked, &planner, &Options::default(), Watch::NONE).unwrap()
    }

    #[test]
    fn the_margin_is_kept_everywhere_but_near_the_end_that_has_none() {
        for planner in ["auto", "shortest-path", "rrt-connect"] {
            for (start, goal, relaxed) in [
                ([7.7, 3.0], [18.0, 2.0], 1),
                ([18.0, 2.0], [7.7, 3.0], 1),
                ([7.75, 1.0], [12.3, 1.0], 2),
                ([0.3, 0.3], [12.25, 5.0], 2),
                ([2.0, 2.0], [18.0, 2.0], 0),
            ] {
                let task = task(start, goal, 0.2);
                let (plan, changes) = planned(&task, 0.4, planner);
                let path = plan.certified().unwrap();
                assert!(crate::certify(&task, path).is_ok());
                assert_eq!(changes.len(), relaxed);
                // Points along the path, but for those near such an end, have the margin.
                let wide = Robot::disc(0.6).unwrap();
                let wide = Certifier::new(task.plane().unwrap().world, wide);
                let near = |p: Point, change: &EndChange| match change.change {
                    Change::Relaxed { radius, clearance } => {
                        assert!(clearance < 0.4 && radius < 1.6, "{change}");
                        distance(p, change.place) <= radius
                    }
                    Change::Moved(_) => panic!("{change}"),
                };
                for p in path.evenly(2000).configurations() {
                    let p = [p[0], p[1]];
                    let relaxed = changes.iter().any(|change| near(p, change));
                    assert!(relaxed || wide.point_is_free(p), "{planner} {p:?}");
                }
                if planner == "auto" {
                    assert!(path.sharpest_turn().to_degrees() <= 35.0, "{}", path.sharpest_turn());
                }
            }
        }
    }

    #[test]
    fn an_end_that_is_not_free_or_has_no_way_out_stays_invalid() {
        let (plan, changes) = planned(&task([9.0, 3.0], [18.0, 2.0], 0.2), 0.4, "auto");
        assert_eq!((plan.status.name(), changes.len()), ("invalid", 0));
        // What is left of the way is near one of the ends.
        let (plan, _) = planned(&task([0.3, 0.3], [1.0, 0.3], 0.2), 0.6, "auto");
        assert_eq!(plan.status.name(), "invalid");
        // With this margin the gap over the block is closed.
        let (plan, _) = planned(&task([7.7, 3.0], [18.0, 2.0], 0.2), 1.9, "auto");
        assert_eq!(plan.status.name(), "invalid");
    }

    #[test]
    fn ends_that_are_not_free_are_moved_to_where_the_robot_can_stand() {
        for (start, margin, most, expected) in [
            ([9.0, 3.0], 0.4, 5.0, Some([7.4, 3.0])),
            // No place with the margin is so near, but one without.
            ([8.1, 3.0], 0.4, 0.4, Some([7.8, 3.0])),
            ([9.0, 3.0], 0.4, 0.5, None),
            // The robot stands there, if without the margin.
            ([7.7, 3.0], 0.4, 5.0, None),
            ([2.0, 2.0], 0.4, 5.0, None),
            ([-3.0, 5.0], 0.4, 5.0, Some([0.6, 5.0])),
        ] {
            let (moved, changes) = task(start, [18.0, 2.0], 0.2).snapped(margin, most).unwrap();
            let place = [moved.start[0], moved.start[1]];
            assert_eq!(changes.len(), usize::from(expected.is_some()), "{start:?}");
            assert!(distance(place, expected.unwrap_or(start)) < 1e-3, "{start:?} {place:?}");
        }
        let error = task([9.0, 3.0], [18.0, 2.0], 0.2).snapped(0.0, f64::NAN).unwrap_err();
        assert_eq!(error.field, "snap");
    }
}
