//! The exact answer as a plan.

use crate::plan::answer::{Origin, Plan, Reason, Status};
use crate::plan::options::Watch;
use crate::plane::shortest_path::{Proof, Route};
use crate::scene::Query;

/// The exact answer, where there is a search for it.
pub(super) fn shortest(query: &Query, watch: Watch<'_>) -> Option<Plan> {
    let origin = Origin::ShortestPath;
    Some(match query.scene().exact(query.start(), query.goal(), watch.go_on)? {
        Route::Found { trajectory, .. } => Plan::of(query, trajectory, 0, origin),
        Route::Unsolvable(Proof::End(violation)) => Plan::none(Status::Invalid(violation), origin),
        Route::Unsolvable(proof) => Plan::none(Status::Unsolvable(proof), origin),
        Route::Undecided(doubt) => Plan::none(Status::Unsolved(Reason::Undecided(doubt)), origin),
    })
}
