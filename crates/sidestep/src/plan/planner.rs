//! Planners: which there are, and what each asks of the options.

use crate::error::InvalidInput;
use crate::optimizer::Method;
use crate::plan::auto::Auto;
use crate::plan::options::Options;
use crate::plan::planner_name::parse_planner;
use crate::plan::rrt_connect::RrtConnect;
use crate::policy::Policy;
use crate::profile::Profile;

/// How to look for a plan.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub enum Planner {
    /// An optimizer from one or more starts.
    Optimizer(Method),
    /// RRT-Connect with shortcutting.
    RrtConnect(RrtConnect),
    /// The exact shortest path.
    ShortestPath,
    /// Optimizers; where those fail or find a detour, the exact shortest path made smooth.
    Auto(Auto),
}

impl Default for Planner {
    /// [`Auto`] with the shipped policies.
    fn default() -> Self {
        Self::Auto(Auto::default())
    }
}

impl Planner {
    /// The default options; with the profile and the number of waypoints that the planner's policy is bound to, if it is.
    ///
    /// # Errors
    /// If the policy names a profile that there is not.
    pub fn options(&self) -> Result<Options, InvalidInput> {
        let policy = self.policy();
        let profile = match policy.and_then(Policy::fixed_profile) {
            Some(name) => name.parse()?,
            None => Profile::DEFAULT,
        };
        let waypoints = policy.and_then(Policy::fixed_waypoints);
        Ok(Options { profile, waypoints, ..Options::default() })
    }

    /// The policy that it plans with, where a trained one was given.
    pub fn policy(&self) -> Option<&Policy> {
        match self {
            Self::Optimizer(Method::Learned(policy))
            | Self::Auto(Auto { quick: Method::Learned(policy), .. }) => Some(policy),
            _ => None,
        }
    }
}

impl std::str::FromStr for Planner {
    type Err = InvalidInput;

    /// A planner that needs no file: `auto`, `gd:step=0.5`, .. For `learned:PATH`, see [`parse_planner`].
    fn from_str(text: &str) -> Result<Self, InvalidInput> {
        parse_planner(text, &mut |path| {
            let allowed = "a planner without a file; parse_planner reads policies";
            Err(InvalidInput::new("planner", format!("`{path}`"), allowed))
        })
    }
}
