//! The last plan mended: where something stands on it now, a way round that only replaces what is blocked.

use crate::plan::answer::{Origin, Plan};
use crate::plan::options::{Options, Watch};
use crate::plan::rrt_connect::{RrtConnect, shortcut};
use crate::rng::{Purpose, stream};
use crate::scene::Query;
use crate::trajectory::Trajectory;

/// A mended plan may be this many times as long as the warm start; a longer one is not near it any more.
const LONGEST: f64 = 1.2;
/// Samples of the trees that look for the way round.
const SAMPLES: usize = 4_000;

/// The warm start between the ends of the query, with what is blocked of it replaced by a way that RRT-Connect finds from
/// the last free point before it to the first one behind it. None where the ways that lead there are not free, or where that way is long.
pub(super) fn mended(
    query: &Query,
    warm: &Trajectory,
    options: &Options,
    watch: Watch<'_>,
) -> Option<Plan> {
    let scene = query.scene();
    let points: Vec<&[f64]> = warm.configurations().collect();
    let is_free = |from: &[f64], to: &[f64]| scene.motion_is_free(from, to);
    let free = |pair: &[&[f64]]| is_free(pair[0], pair[1]);
    let before = points.windows(2).take_while(|pair| free(pair)).count();
    let behind = points.windows(2).rev().take_while(|pair| free(pair)).count();
    let behind = points.len().checked_sub(1 + behind)?;
    if before >= behind {
        return None;
    }
    let rrt = RrtConnect { max_samples: SAMPLES, ..RrtConnect::default() };
    let mut rng = stream(options.seed, Purpose::Planner, options.index, 0);
    let gap = query.between(points[before], points[behind]);
    let detour = rrt.plan_while(&gap, &mut rng, watch.go_on).trajectory?;
    let whole =
        [&points[..before], &detour.configurations().collect::<Vec<_>>(), &points[behind + 1..]];
    let mut whole = Trajectory::new(warm.dof(), whole.concat().concat());
    shortcut(&mut whole, is_free, rrt.shortcut_rounds, &mut rng);
    let plan = Plan::of(query, whole, 0, Origin::MendedWarmStart);
    plan.certified().is_some_and(|path| path.length() <= LONGEST * warm.length()).then_some(plan)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::plan::{Planner, plan};
    use crate::plane::geometry::Rect;
    use crate::plane::world::{Grid, Obstacle, World};
    use crate::{Robot, Task};

    /// A map of 40 x 20 cells with a wall up to row 12 in the middle, and one box.
    fn task(low: [f64; 2], high: [f64; 2]) -> Task {
        let wall = |i: usize| i % 40 == 20 && i / 40 < 12;
        let grid = Grid::new(40, 20, 1.0, [0.0; 2], (0..800).map(wall).collect()).unwrap();
        let boxes = vec![Obstacle::Rect(Rect::new(low, high).unwrap())];
        let world = Arc::new(World::new(grid.rect(), boxes, Some(grid)));
        Task::in_plane("t", world, Robot::disc(0.5).unwrap(), [3.0, 3.0], [37.0, 3.0]).unwrap()
    }

    fn planned(task: &Task, warm_start: Option<Trajectory>) -> Plan {
        plan(task, &Planner::default(), &Options { warm_start, ..Options::default() }).unwrap()
    }

    #[test]
    fn a_box_on_the_last_plan_is_walked_round_near_it() {
        let before = planned(&task([1.0, 17.0], [2.0, 18.0]), None).certified().unwrap().clone();
        let after = task([9.0, 5.0], [12.0, 9.0]);
        assert!(crate::certify(&after, &before).is_err());
        let plan = planned(&after, Some(before.clone()));
        assert_eq!(plan.origin, Origin::MendedWarmStart);
        let path = plan.certified().unwrap();
        assert!(crate::certify(&after, path).is_ok());
        assert!(path.length() <= 1.1 * before.length(), "{} {}", path.length(), before.length());
    }

    #[test]
    fn what_cannot_be_mended_nearby_is_planned_anew_or_proved() {
        let before = planned(&task([1.0, 17.0], [2.0, 18.0]), None).certified().unwrap().clone();
        // The way over the wall is closed; no other is left.
        let closed = task([19.0, 11.0], [22.0, 20.0]);
        let plan = planned(&closed, Some(before));
        assert_eq!(plan.status.name(), "unsolvable");
    }
}
