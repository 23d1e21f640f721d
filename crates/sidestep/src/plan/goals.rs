//! Several goals, any of which will do.
//!
//! Nobody knows beforehand which of them can be reached, and trees to one that cannot spend all their samples. So all get a few
//! samples first, and those whose trees have not met get more in the next round.

use std::cmp::Ordering;

use crate::plan::answer::{Plan, Reason, Status};
use crate::plan::options::{Options, Stop};

/// Samples of each goal's trees in the first round, and in each further one so many times as many; the last has no limit but the
/// options'.
const FIRST: usize = 2_000;
const GROWTH: usize = 8;
const ROUNDS: u32 = 4;

/// Plans to `goals` goals in rounds, the first goals first: until there is a plan, or with [`Stop::Best`] a round that has one is
/// through. The goal whose plan it is, the shortest of several, with it; or else the goal that came nearest to having one. None
/// of no goals.
///
/// `plan_to` plans to a goal, by number and with these options; it is told too to how many goals the round leads from there on,
/// so that it can share time out.
///
/// # Errors
/// The first of `plan_to`.
pub fn plan_to_any<A: AsRef<Plan>, E>(
    goals: usize,
    options: &Options,
    mut plan_to: impl FnMut(usize, usize, &Options) -> Result<A, E>,
) -> Result<Option<(usize, A)>, E> {
    let most = options.max_samples.unwrap_or(usize::MAX);
    let mut open: Vec<usize> = (0..goals).collect();
    let mut best: Option<(usize, A)> = None;
    for round in 0..ROUNDS {
        let last = round + 1 == ROUNDS || goals == 1;
        let samples = if last { most } else { most.min(FIRST * GROWTH.pow(round)) };
        let limit = if last { options.max_samples } else { Some(samples) };
        let limited = Options { max_samples: limit, ..options.clone() };
        let mut still_open = Vec::new();
        for (index, &goal) in open.iter().enumerate() {
            let next = plan_to(goal, open.len() - index, &limited)?;
            let spent =
                matches!(next.as_ref().status, Status::Unsolved(Reason::SamplesSpent { .. }));
            if spent && samples < most {
                still_open.push(goal);
            }
            if best.as_ref().is_none_or(|(_, best)| is_better(next.as_ref(), best.as_ref())) {
                best = Some((goal, next));
            }
            let solved = best.as_ref().is_some_and(|(_, best)| best.as_ref().is_solved());
            if solved && options.stop == Stop::First {
                return Ok(best);
            }
        }
        let solved = best.as_ref().is_some_and(|(_, best)| best.as_ref().is_solved());
        if solved || last || still_open.is_empty() {
            break;
        }
        open = still_open;
    }
    Ok(best)
}

/// Plans before attempts before goals that cannot be, and short plans before long ones.
fn is_better(plan: &Plan, than: &Plan) -> bool {
    let rank = |plan: &Plan| match plan.status {
        Status::Solved(_) => 3,
        Status::Unsolved(_) => 2,
        Status::Unsolvable(_) => 1,
        Status::Invalid(_) => 0,
    };
    let length = |plan: &Plan| plan.certified().map_or(0.0, |path| path.length());
    match rank(plan).cmp(&rank(than)) {
        Ordering::Equal => length(plan) < length(than),
        unequal => unequal == Ordering::Greater,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::Origin;

    struct Attempt(Plan);

    impl AsRef<Plan> for Attempt {
        fn as_ref(&self) -> &Plan {
            &self.0
        }
    }

    fn spent(samples: usize) -> Attempt {
        let status = Status::Unsolved(Reason::SamplesSpent { samples });
        Attempt(Plan::none(status, Origin::Tree))
    }

    #[test]
    fn rounds_grow_and_end_without_a_limit() {
        let mut asked = Vec::new();
        let plan_to = |goal: usize, left: usize, options: &Options| {
            asked.push((goal, left, options.max_samples));
            Ok::<_, ()>(spent(options.max_samples.unwrap_or(3_000_000)))
        };
        let best = plan_to_any(2, &Options::default(), plan_to).unwrap();
        assert!(best.is_some_and(|(goal, _)| goal == 0));
        let limits = [Some(2_000), Some(16_000), Some(128_000), None];
        let expected: Vec<_> =
            limits.iter().flat_map(|&most| [(0, 2, most), (1, 1, most)]).collect();
        assert_eq!(asked, expected);
    }

    #[test]
    fn a_goal_that_failed_for_another_reason_is_asked_once_and_a_limit_is_kept() {
        let mut asked = Vec::new();
        let plan_to = |goal: usize, _: usize, options: &Options| {
            asked.push((goal, options.max_samples));
            let none = Status::Unsolvable(crate::plane::shortest_path::Proof::Disconnected);
            Ok::<_, ()>(match goal {
                0 => Attempt(Plan::none(none, Origin::Tree)),
                _ => spent(options.max_samples.unwrap()),
            })
        };
        let options = Options { max_samples: Some(5_000), ..Options::default() };
        let best = plan_to_any(2, &options, plan_to).unwrap();
        // What is not proved to be in vain comes nearer to a plan.
        assert!(best.is_some_and(|(goal, _)| goal == 1));
        assert_eq!(asked, [(0, Some(2_000)), (1, Some(2_000)), (1, Some(5_000))]);
    }

    #[test]
    fn one_goal_is_planned_to_once() {
        let mut count = 0;
        let plan_to = |_: usize, _: usize, options: &Options| {
            count += 1;
            assert_eq!(options.max_samples, None);
            Ok::<_, ()>(spent(1))
        };
        plan_to_any(1, &Options::default(), plan_to).unwrap();
        assert_eq!(count, 1);
    }
}
