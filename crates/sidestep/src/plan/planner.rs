//! Planners, and their names as people type them: `gd`, `gd:step=0.5`, `stomp:rollouts=32,noise=0.3`,
//! `learned:PATH`, `auto`.

use std::sync::Arc;

use crate::error::InvalidInput;
use crate::optimizer::Method;
use crate::plan::auto::Auto;
use crate::plan::options::Options;
use crate::plan::rrt_connect::RrtConnect;
use crate::policy::Policy;
use crate::policy::shipped;
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

/// Every planner name with its options and what it is, for help and suggestions.
pub const PLANNERS: [(&str, &str, &str); 14] = [
    ("auto", "", "the shipped policies, then the exact shortest path made smooth (default)"),
    ("sidestep-1", "", "the shipped policy"),
    ("sidestep-1-small", "", "a smaller and faster one"),
    ("gd", "step", "gradient descent"),
    ("gd-line-search", "step", "gradient descent with backtracking line search"),
    ("momentum", "step,decay", "gradient descent with momentum"),
    ("adam", "step", "Adam"),
    ("chomp", "step", "covariant gradient descent"),
    ("lbfgs", "memory", "limited-memory BFGS"),
    ("stomp", "rollouts,noise", "stochastic trajectory optimization"),
    ("rrt-connect", "samples,rounds", "random trees with shortcutting"),
    ("shortest-path", "", "the exact shortest path"),
    ("learned", "PATH", "a trained policy"),
    ("auto-with", "PATH", "auto, with a trained policy as its optimizer"),
];

/// Parses a planner name; `load` reads the policy at a path.
///
/// # Errors
/// If the name or an option is not known, or a value is out of range; the message suggests the
/// nearest name. Errors of `load` are passed on.
pub fn parse_planner(
    text: &str,
    load: &mut dyn FnMut(&str) -> Result<Arc<Policy>, InvalidInput>,
) -> Result<Planner, InvalidInput> {
    let (name, rest) = text.split_once(':').unwrap_or((text, ""));
    if name == "learned" {
        return Ok(Planner::Optimizer(Method::Learned(load(rest)?)));
    }
    if name == "auto-with" {
        return Ok(Planner::Auto(Auto::with(Method::Learned(load(rest)?))));
    }
    let Some((_, known, _)) = PLANNERS.iter().find(|(planner, ..)| *planner == name) else {
        let names = PLANNERS.map(|(planner, ..)| planner);
        return Err(InvalidInput::unknown("planner", text, &names));
    };
    let options = Settings::parse(name, rest, known)?;
    let optimizer = |method| Ok(Planner::Optimizer(method));
    match name {
        "auto" => Ok(Planner::Auto(Auto::default())),
        "gd" => optimizer(Method::GradientDescent { step: options.step()? }),
        "gd-line-search" => optimizer(Method::LineSearch { step: options.step()?.unwrap_or(4.0) }),
        "momentum" => optimizer(Method::Momentum {
            step: options.step()?,
            decay: options.number("decay", 0.0, 0.999)?.unwrap_or(0.9),
        }),
        "adam" => optimizer(Method::Adam { step: options.step()?.unwrap_or(0.1) }),
        "chomp" => optimizer(Method::Chomp { step: options.step()? }),
        "lbfgs" => optimizer(Method::Lbfgs {
            memory: options.number("memory", 1.0, 1000.0)?.unwrap_or(7.0) as usize,
        }),
        "stomp" => optimizer(Method::Stomp {
            rollouts: options.number("rollouts", 1.0, 10_000.0)?.unwrap_or(16.0) as usize,
            noise: options.number("noise", 1e-6, 100.0)?.unwrap_or(0.5),
        }),
        "sidestep-1" => optimizer(Method::Learned(shipped::sidestep_1())),
        "sidestep-1-small" => optimizer(Method::Learned(shipped::sidestep_1_small())),
        "shortest-path" => Ok(Planner::ShortestPath),
        _ => {
            let mut rrt = RrtConnect::default();
            if let Some(samples) = options.number("samples", 1.0, 1e9)? {
                rrt.max_samples = samples as usize;
            }
            if let Some(rounds) = options.number("rounds", 0.0, 1e6)? {
                rrt.shortcut_rounds = rounds as usize;
            }
            Ok(Planner::RrtConnect(rrt))
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

/// The `key=value` pairs after a planner's name.
struct Settings<'a> {
    planner: &'a str,
    pairs: Vec<(&'a str, f32)>,
}

impl<'a> Settings<'a> {
    fn parse(planner: &'a str, text: &'a str, known: &str) -> Result<Self, InvalidInput> {
        let mut pairs = Vec::new();
        for pair in text.split(',').filter(|pair| !pair.is_empty()) {
            let (key, value) = pair.split_once('=').unwrap_or((pair, ""));
            if !known.split(',').any(|option| option == key && !option.is_empty()) {
                let allowed = if known.is_empty() { "no option" } else { known };
                return Err(InvalidInput::new(format!("planner.{planner}"), key, allowed));
            }
            let value: f32 = value.parse().map_err(|_| {
                InvalidInput::new(
                    format!("planner.{planner}.{key}"),
                    format!("`{value}`"),
                    "a number",
                )
            })?;
            pairs.push((key, value));
        }
        Ok(Self { planner, pairs })
    }

    fn number(&self, key: &str, least: f64, most: f64) -> Result<Option<f32>, InvalidInput> {
        let Some(&(_, value)) = self.pairs.iter().find(|(known, _)| *known == key) else {
            return Ok(None);
        };
        if (least..=most).contains(&f64::from(value)) {
            return Ok(Some(value));
        }
        let field = format!("planner.{}.{key}", self.planner);
        Err(InvalidInput::new(field, value, format!("a number from {least} to {most}")))
    }

    fn step(&self) -> Result<Option<f32>, InvalidInput> {
        self.number("step", 1e-9, 1e6)
    }
}
