//! What a planner may use, and who watches it.

use std::ops::ControlFlow;

use crate::error::{InvalidInput, MAX_COORDINATE};
use crate::plan::polish::Wishes;
use crate::plan::run::Iteration;
use crate::plan::starts::StartStrategy;
use crate::profile::{MAX_WAYPOINTS, Profile};
use crate::trajectory::Trajectory;

/// When planning ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Stop {
    /// At the first certified plan.
    #[default]
    First,
    /// When the steps are spent, with the certified plan of least U.
    Best,
}

/// What a planner may use.
#[derive(Debug, Clone)]
pub struct Options {
    /// Constants of the objective.
    pub profile: Profile,
    /// Waypoints between start and goal; the profile's where none.
    pub waypoints: Option<usize>,
    /// Start trajectories of an optimizer, at least 1; the first is the straight line.
    pub starts: usize,
    /// How the others are drawn.
    pub strategy: StartStrategy,
    /// Optimizer steps per start.
    pub steps: usize,
    /// Most samples that trees draw in all; as many as the planner sees fit where none.
    pub max_samples: Option<usize>,
    /// When planning ends.
    pub stop: Stop,
    /// Seed of everything random.
    pub seed: u64,
    /// Number of the random stream, so that the tasks of a batch differ.
    pub index: u64,
    /// A trajectory to start from instead of the straight line.
    pub warm_start: Option<Trajectory>,
    /// What is wished of the plan's bends: whatever the planner, its plan is polished to keep them ([`crate::plan::polish()`]).
    /// Where none, only `auto` polishes, with [`Wishes::default`].
    pub wishes: Option<Wishes>,
    /// Whether a failed search is followed by one for a proof that there is no path.
    pub prove: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            profile: Profile::DEFAULT,
            waypoints: None,
            starts: 1,
            strategy: StartStrategy::default(),
            steps: 200,
            max_samples: None,
            stop: Stop::First,
            seed: 0,
            index: 0,
            warm_start: None,
            wishes: None,
            prove: false,
        }
    }
}

/// Most start trajectories of one plan.
pub const MAX_STARTS: usize = 1_000_000;
/// Most optimizer steps per start.
pub const MAX_STEPS: usize = 100_000_000;

/// Most samples of a plan's trees that may be asked for.
pub const MAX_SAMPLES: usize = 1_000_000_000;

/// Who watches a planner at work, from any thread.
#[derive(Clone, Copy)]
pub struct Watch<'a> {
    /// Sees every iterate of every start.
    pub see: &'a (dyn Fn(&Iteration<'_>) + Sync),
    /// Asked at every iterate, all along the searches and while a world is prepared; once it is false, planning ends with the
    /// best certified plan so far. Only a [`Scene`](crate::scene::Scene) itself, which packs the world for the certificate, is not
    /// broken off.
    pub go_on: &'a (dyn Fn() -> bool + Sync),
}

impl Watch<'_> {
    /// Nobody.
    pub const NONE: Watch<'static> = Watch { see: &|_| {}, go_on: &|| true };

    /// Shows an iterate and asks whether to go on.
    pub fn look(&self, iteration: &Iteration<'_>) -> ControlFlow<()> {
        (self.see)(iteration);
        if (self.go_on)() { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    }
}

impl Options {
    /// Checks every number's range, as planning does before it begins.
    ///
    /// # Errors
    /// If one is out of range.
    pub fn check(&self) -> Result<(), InvalidInput> {
        let range = |field, value: usize, least: usize, most: usize| {
            let allowed = || format!("a number from {least} to {most}");
            let fits = (least..=most).contains(&value);
            fits.then_some(()).ok_or_else(|| InvalidInput::new(field, value, allowed()))
        };
        let waypoints = self.waypoints.unwrap_or(self.profile.waypoints);
        range("waypoints", waypoints, 1, MAX_WAYPOINTS)?;
        range("starts", self.starts, 1, MAX_STARTS)?;
        let warm = self.warm_start.iter().flat_map(Trajectory::configurations).enumerate();
        for (index, configuration) in warm {
            if !configuration.iter().all(|x| x.is_finite()) {
                let value = format!("{configuration:?}");
                let field = format!("warm_start[{index}]");
                return Err(InvalidInput::new(field, value, "finite numbers"));
            }
        }
        if let Some(Wishes { turn, radius }) = self.wishes {
            if !(0.0..=std::f64::consts::PI).contains(&turn) {
                return Err(InvalidInput::new("wishes.turn", turn, "radians from 0 to π"));
            }
            if !(0.0..=MAX_COORDINATE).contains(&radius) {
                return Err(InvalidInput::new("wishes.radius", radius, "a number from 0 to 1e9"));
            }
        }
        if let Some(samples) = self.max_samples {
            range("max_samples", samples, 1, MAX_SAMPLES)?;
        }
        range("steps", self.steps, 0, MAX_STEPS)
    }
}
