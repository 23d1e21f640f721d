//! Flags that `plan` and `bench` share: the profile, the starts and the budget.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use sidestep::error::InvalidInput;
use sidestep::plan::starts::StartStrategy;
use sidestep::plan::{Options, PLANNERS, Planner, parse_planner};
use sidestep::policy::Policy;
use sidestep::profile::Profile;

use crate::failure::Failure;
use crate::source;

/// Most waypoints that can be asked for: with more, a policy's step takes longer than most plans.
const MAX_WAYPOINTS: usize = 10_000;

/// How to plan.
#[derive(Args, Clone)]
pub struct PlanningArgs {
    /// Start trajectories; the first is the straight line
    #[arg(long, default_value_t = 1, allow_negative_numbers = true)]
    starts: usize,
    /// How the others are drawn: line, via-point, sorted, random or paper
    #[arg(long, default_value = "via-point")]
    start_strategy: String,
    /// Constants of the objective: default or paper [default: the policy's where one plans]
    #[arg(long)]
    profile: Option<String>,
    /// Optimizer steps per start
    #[arg(long, default_value_t = 200, allow_negative_numbers = true)]
    steps: usize,
    /// Most samples that trees draw in all [default: 20,000, 3.1 million for `auto` and a robot with joints]
    #[arg(long, allow_negative_numbers = true)]
    max_samples: Option<usize>,
    /// Waypoints between start and goal [default: the profile's 10]
    #[arg(long, allow_negative_numbers = true)]
    waypoints: Option<usize>,
    /// Distance under which closeness to obstacles costs, in task units [default: a 6.4th of
    /// the field, on a map at most the typical clearance]
    #[arg(long, allow_negative_numbers = true)]
    epsilon: Option<f64>,
    /// Seed of random starts, random planners and what a file of worlds leaves open
    #[arg(long, default_value_t = 0, allow_negative_numbers = true)]
    pub seed: u64,
}

impl PlanningArgs {
    /// The planner options for a field of the given extent, or for a robot with joints; a learned planner among
    /// `planners` decides the profile and the number of waypoints that the flags leave open.
    pub fn options(&self, extent: Option<f64>, planners: &[&Planner]) -> Result<Options, Failure> {
        let policy = planners.iter().find_map(|planner| planner.policy());
        let default_profile = policy.and_then(|policy| policy.fixed_profile()).unwrap_or("default");
        let mut profile = self.profile.as_deref().unwrap_or(default_profile).parse::<Profile>()?;
        if let Some(epsilon) = self.epsilon {
            let Some(extent) = extent else {
                let allowed = "a robot in the plane for it; --margin keeps one with joints away";
                return Err(InvalidInput::new("--epsilon", epsilon, allowed).into());
            };
            if !(epsilon > 0.0 && epsilon <= extent) {
                let allowed = format!("a number above 0 and at most {extent}, the field's extent");
                return Err(InvalidInput::new("--epsilon", epsilon, allowed).into());
            }
            profile.fits_epsilon_to_maps = false;
            profile.epsilon = epsilon / extent * sidestep::profile::NORMALISED_EXTENT;
        }
        if let Some(waypoints) = self.waypoints
            && !(1..=MAX_WAYPOINTS).contains(&waypoints)
        {
            let allowed = format!("a number from 1 to {MAX_WAYPOINTS}");
            return Err(InvalidInput::new("--waypoints", waypoints, allowed).into());
        }
        let options = Options {
            profile,
            waypoints: self.waypoints.or(policy.and_then(|policy| policy.fixed_waypoints())),
            starts: self.starts,
            strategy: self.start_strategy.parse::<StartStrategy>()?,
            steps: self.steps,
            max_samples: self.max_samples,
            seed: self.seed,
            ..Options::default()
        };
        options.check()?;
        Ok(options)
    }
}

/// The planner of that name; a policy is read from its file.
pub fn planner(name: &str) -> Result<Planner, Failure> {
    let planner = parse_planner(name, &mut |path| load_policy(Path::new(path)).map(Arc::new));
    let kind = name.split(':').next().unwrap_or_default();
    planner.map_err(|error| match PLANNERS.iter().any(|known| known.name == kind) {
        true => error,
        false => Failure(format!("{error} (`sidestep planners` describes them)")),
    })
}

/// The planners of a list: repeated, or with commas between them. A word `key=value` after a comma is
/// a setting of the planner before it.
pub fn planner_names(words: &[String]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for word in words {
        for (index, part) in word.split(',').enumerate() {
            let is_setting = part.contains('=') && !part.contains(':');
            match names.last_mut().filter(|_| index > 0 && is_setting) {
                Some(last) => *last += &format!(",{part}"),
                None => names.push(part.into()),
            }
        }
    }
    names
}

/// The file of a planner that is a policy of the user's.
pub fn policy_file(name: &str) -> Option<PathBuf> {
    let (kind, path) = name.split_once(':')?;
    ["learned", "auto-with"].contains(&kind).then(|| in_folder(path.as_ref()))
}

/// The policy of a training's folder where the path is one, else the path.
fn in_folder(path: &Path) -> PathBuf {
    if path.is_dir() { path.join(POLICY_FILE) } else { path.into() }
}

/// The name that a training gives its policy.
const POLICY_FILE: &str = "policy.safetensors";

/// Reads a policy file, or that of a training's folder.
pub fn load_policy(path: &Path) -> Result<Policy, Failure> {
    let path = &in_folder(path);
    let bytes = source::companion(path).map_err(|error| {
        let expected = "expected a policy file (.safetensors) or the folder of a training";
        Failure::file(path, format!("cannot be read ({error}); {expected}"))
    })?;
    Policy::from_safetensors(&bytes).map_err(|error| Failure::file(path, error))
}
