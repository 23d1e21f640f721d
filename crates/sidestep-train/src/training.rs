//! A training, as whoever runs one sees it: units made one after the other, a state that can be
//! stored, a curve.
//!
//! [`crate::paper::Trainer`] and [`crate::waypoint::WaypointTrainer`] are trainings;
//! [`crate::Recipe`] begins either.

use std::fmt;

use serde::Serialize;
use serde_json::Value;
use sidestep::InvalidInput;
use sidestep::policy::Policy;

/// Units of a training: epochs of cloning, updates of PPO, or blocks of optimizer steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Units {
    /// Made so far.
    pub done: u64,
    /// In the whole training.
    pub all: u64,
}

/// A unit that was made.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Made {
    /// What the validation found, in words, if the unit ended with one.
    pub validation: Option<String>,
}

/// A number of the training curve, under the tag that CleanRL uses where there is one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scalar {
    /// Environment steps made before (minibatches, within cloning).
    pub step: u64,
    /// Such as `losses/value_loss`.
    pub tag: &'static str,
    /// The number; finite.
    pub value: f64,
}

/// A unit after which something is no longer finite. The training stays as it was before that unit,
/// so what is stored of it is whole; going on would diverge again.
#[derive(Debug, Clone, PartialEq)]
pub struct Divergence {
    /// The unit, counted from 1 over the whole training.
    pub unit: u64,
    /// What is not finite: the parameters, or the tag of a scalar.
    pub what: &'static str,
    /// The configuration's key to lower.
    pub key: String,
    /// Its value.
    pub rate: f64,
}

impl fmt::Display for Divergence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { unit, what, key, rate } = self;
        let is = if what.ends_with('s') { "are" } else { "is" };
        write!(
            f,
            "the training diverged: after unit {unit} the {what} {is} not finite; try a {key} below {rate}"
        )
    }
}

impl std::error::Error for Divergence {}

impl Divergence {
    /// The divergence of a unit, if one of its `values` or of its scalars is not finite.
    pub(crate) fn find(
        unit: u64,
        values: &[(&'static str, &[f32])],
        scalars: &[Scalar],
        key: impl FnOnce() -> (String, f64),
    ) -> Option<Self> {
        let is_whole = |values: &[f32]| values.iter().all(|value| value.is_finite());
        let odd_values = values.iter().find(|(_, values)| !is_whole(values)).map(|(what, _)| *what);
        let odd_scalar = || scalars.iter().find(|scalar| !scalar.value.is_finite());
        let name = |tag: &'static str| tag.split_once('/').map_or(tag, |(_, name)| name);
        let what = odd_values.or_else(|| odd_scalar().map(|scalar| name(scalar.tag)))?;
        let (key, rate) = key();
        Some(Self { unit, what, key, rate })
    }
}

/// The points of a curve as lines of JSON.
pub(crate) fn lines<T: Serialize>(curve: &[T]) -> String {
    curve.iter().filter_map(|point| serde_json::to_string(point).ok()).map(|l| l + "\n").collect()
}

/// A training of either room.
pub trait Training: Send {
    /// Units made, and in all.
    fn units(&self) -> Units;

    /// Steps of environments or trajectories so far.
    fn environment_steps(&self) -> u64;

    /// Makes the next unit; `None` when all are done.
    ///
    /// # Errors
    /// If the training diverged.
    fn step(&mut self) -> Result<Option<Made>, Divergence>;

    /// The best policy on the validation tasks so far, or the present one if there was no
    /// validation yet.
    ///
    /// # Errors
    /// Never for a training that was made from a checked configuration.
    fn best_policy(&self) -> Result<Policy, InvalidInput>;

    /// The complete state, from which [`crate::Recipe::resume`] goes on to the same bits.
    ///
    /// # Errors
    /// If the state cannot be written as JSON, which only a number that is not finite could cause.
    fn checkpoint(&self) -> Result<Vec<u8>, InvalidInput>;

    /// What each unit did, as lines of JSON.
    fn lines(&self) -> String;

    /// The best result on the validation tasks, for a summary.
    fn summary(&self) -> Value;

    /// The curve unit by unit.
    fn scalars(&self) -> Vec<Vec<Scalar>>;
}
