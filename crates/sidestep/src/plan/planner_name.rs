//! Planner names as people type them: `gd`, `gd:step=0.5`, `stomp:rollouts=32,noise=0.3`,
//! `learned:PATH`, `auto`.

use std::sync::Arc;

use crate::error::{InvalidInput, nearest_name};
use crate::optimizer::Method;
use crate::plan::rrt_connect::RrtConnect;
use crate::plan::{Auto, Planner};
use crate::policy::Policy;
use crate::policy::shipped;

/// A planner's name, for help, suggestions and parsing.
#[derive(Debug, Clone, Copy)]
pub struct PlannerName {
    /// What one types.
    pub name: &'static str,
    /// What it is, in a line.
    pub about: &'static str,
    /// What may follow a colon, as `key=value` with commas between.
    pub settings: &'static [PlannerSetting],
    /// Whether a policy's path follows a colon.
    pub takes_path: bool,
    /// Other words that people know it by; suggested for, not accepted.
    pub other_names: &'static [&'static str],
}

/// A number that a planner's name may set.
#[derive(Debug, Clone, Copy)]
pub struct PlannerSetting {
    /// Its key.
    pub key: &'static str,
    /// What it is, with its unit.
    pub about: &'static str,
    /// The least value allowed.
    pub least: f64,
    /// The largest value allowed.
    pub most: f64,
    /// Whether fractions are refused.
    pub whole: bool,
    /// What holds where nothing is set, in words.
    pub default: &'static str,
}

impl PlannerSetting {
    /// The values that are allowed, in words.
    pub fn range(&self) -> String {
        let kind = if self.whole { "a whole number" } else { "a number" };
        format!("{kind} from {} to {}", self.least, self.most)
    }
}

const fn number(
    key: &'static str,
    about: &'static str,
    least: f64,
    most: f64,
    default: &'static str,
) -> PlannerSetting {
    PlannerSetting { key, about, least, most, whole: false, default }
}

const fn whole(
    key: &'static str,
    about: &'static str,
    least: f64,
    most: f64,
    default: &'static str,
) -> PlannerSetting {
    PlannerSetting { key, about, least, most, whole: true, default }
}

const fn step(default: &'static str) -> PlannerSetting {
    number("step", "step size, in normalised units", 1e-9, 1e6, default)
}

const fn planner(
    name: &'static str,
    about: &'static str,
    settings: &'static [PlannerSetting],
    other_names: &'static [&'static str],
) -> PlannerName {
    PlannerName { name, about, settings, takes_path: false, other_names }
}

/// Step of gradient descent in either profile.
const PROFILE_STEP: &str = "2; 0.1 in the profile paper and with joints";

/// Every planner.
pub const PLANNERS: [PlannerName; 15] = [
    planner(
        "auto",
        "the shipped policies, then the exact shortest path made smooth (the default)",
        &[],
        &["default", "best", "any", "smooth"],
    ),
    planner("sidestep-1", "the shipped policy", &[], &["sidestep", "neural", "policy"]),
    planner("sidestep-1-small", "a smaller and faster one", &[], &["small"]),
    planner(
        "gd",
        "gradient descent",
        &[step(PROFILE_STEP)],
        &["gradient-descent", "sgd", "gradient", "descent"],
    ),
    planner(
        "gd-line-search",
        "gradient descent with backtracking line search",
        &[step("4")],
        &["line-search", "backtracking", "armijo"],
    ),
    planner(
        "momentum",
        "gradient descent with momentum",
        &[
            step("2; 0.1 in the profile paper, 0.01 with joints"),
            number("decay", "share of the last update that is kept", 0.0, 0.999, "0.9"),
        ],
        &["heavy-ball", "nesterov"],
    ),
    planner("adam", "Adam", &[step("0.1")], &["adamw", "rmsprop"]),
    planner(
        "chomp",
        "covariant gradient descent",
        &[step("0.2; 0.01 in the profile paper, 0.02 with joints")],
        &["covariant"],
    ),
    planner(
        "lbfgs",
        "limited-memory BFGS",
        &[whole("memory", "updates that are remembered", 1.0, 1000.0, "7")],
        &["l-bfgs", "bfgs", "quasi-newton"],
    ),
    planner(
        "lm",
        "Levenberg-Marquardt",
        &[number("damping", "damping in the covariant metric", 0.0, 1e6, "0.01")],
        &["levenberg-marquardt", "gauss-newton", "gn", "newton"],
    ),
    planner(
        "stomp",
        "stochastic trajectory optimization",
        &[
            whole("rollouts", "noisy trajectories per step", 1.0, 10_000.0, "16"),
            number("noise", "largest deviation of the noise, normalised units", 1e-6, 100.0, "0.5"),
        ],
        &["stochastic", "mppi"],
    ),
    planner(
        "rrt-connect",
        "random trees with shortcutting",
        &[
            whole("samples", "samples before it gives up", 1.0, 1e9, "20000"),
            whole("rounds", "short cuts that are tried", 0.0, 1e6, "32"),
        ],
        &["rrt", "rrtconnect", "rrt-star", "rrt*", "prm", "ompl", "sampling"],
    ),
    planner(
        "shortest-path",
        "the exact shortest path",
        &[],
        &[
            "astar",
            "a-star",
            "a*",
            "dijkstra",
            "theta-star",
            "theta*",
            "exact",
            "oracle",
            "shortest",
        ],
    ),
    PlannerName {
        takes_path: true,
        ..planner("learned", "a trained policy (a file, or the folder of its training)", &[], &[])
    },
    PlannerName {
        takes_path: true,
        ..planner("auto-with", "auto, with a trained policy as its optimizer", &[], &[])
    },
];

impl PlannerName {
    /// The form to type, such as `gd[:step=NUMBER]`.
    pub fn form(&self) -> String {
        if self.takes_path {
            return format!("{}:PATH", self.name);
        }
        let settings: Vec<String> =
            self.settings.iter().map(|setting| format!("{}=NUMBER", setting.key)).collect();
        match settings.as_slice() {
            [] => self.name.into(),
            settings => format!("{}[:{}]", self.name, settings.join(",")),
        }
    }

    /// The planner of that name.
    fn named(name: &str, text: &str) -> Result<&'static Self, InvalidInput> {
        PLANNERS.iter().find(|planner| planner.name == name).ok_or_else(|| {
            let names = PLANNERS.map(|planner| planner.name).join(", ");
            let hint = nearest_planner(name)
                .map_or_else(String::new, |nearest| format!("; did you mean {nearest}?"));
            InvalidInput::new("planner", format!("`{text}`"), format!("one of {names}{hint}"))
        })
    }
}

/// The planner that somebody means who types `name`: by another word for it, or by the nearest name.
fn nearest_planner(name: &str) -> Option<&'static str> {
    let name = name.to_lowercase().replace(['_', ' '], "-");
    let known = PLANNERS.iter().find(|planner| planner.other_names.contains(&name.as_str()));
    match known {
        Some(planner) => Some(planner.name),
        None => nearest_name(&name, PLANNERS.iter().map(|planner| planner.name)),
    }
}

/// Parses a planner name; `load` reads the policy at a path.
///
/// # Errors
/// If the name or a setting is not known, or a value is out of range; the message suggests the
/// nearest name. Errors of `load` are passed on.
pub fn parse_planner<E: From<InvalidInput>>(
    text: &str,
    load: &mut dyn FnMut(&str) -> Result<Arc<Policy>, E>,
) -> Result<Planner, E> {
    let (name, rest) = text.split_once(':').unwrap_or((text, ""));
    let planner = PlannerName::named(name, text)?;
    if planner.takes_path && rest.is_empty() {
        let allowed = format!("{}, with the path of a policy file", planner.form());
        return Err(InvalidInput::new("planner", format!("`{text}`"), allowed).into());
    }
    if name == "learned" {
        return Ok(Planner::Optimizer(Method::Learned(load(rest)?)));
    }
    if name == "auto-with" {
        return Ok(Planner::Auto(Auto::with(Method::Learned(load(rest)?))));
    }
    let settings = Settings::parse(planner, rest)?;
    let (float, count) = (|key| settings.float(key), |key| settings.count(key));
    let optimizer = |method| Ok(Planner::Optimizer(method));
    match name {
        "auto" => Ok(Planner::Auto(Auto::default())),
        "gd" => optimizer(Method::GradientDescent { step: float("step") }),
        "gd-line-search" => optimizer(Method::LineSearch { step: float("step").unwrap_or(4.0) }),
        "momentum" => optimizer(Method::Momentum {
            step: float("step"),
            decay: float("decay").unwrap_or(0.9),
        }),
        "adam" => optimizer(Method::Adam { step: float("step").unwrap_or(0.1) }),
        "chomp" => optimizer(Method::Chomp { step: float("step") }),
        "lbfgs" => optimizer(Method::Lbfgs { memory: count("memory").unwrap_or(7) }),
        "lm" => optimizer(Method::LevenbergMarquardt { damping: float("damping").unwrap_or(0.01) }),
        "stomp" => optimizer(Method::Stomp {
            rollouts: count("rollouts").unwrap_or(16),
            noise: float("noise").unwrap_or(0.5),
        }),
        "sidestep-1" => optimizer(Method::Learned(shipped::sidestep_1())),
        "sidestep-1-small" => optimizer(Method::Learned(shipped::sidestep_1_small())),
        "shortest-path" => Ok(Planner::ShortestPath),
        _ => {
            let default = RrtConnect::default();
            Ok(Planner::RrtConnect(RrtConnect {
                max_samples: count("samples").unwrap_or(default.max_samples),
                shortcut_rounds: count("rounds").unwrap_or(default.shortcut_rounds),
                ..default
            }))
        }
    }
}

/// The `key=value` pairs after a planner's name, each in its range.
struct Settings {
    values: Vec<(&'static str, Value)>,
}

/// A number in both precisions: ranges and counts are f64, optimizers f32, each rounded once.
#[derive(Clone, Copy)]
struct Value {
    wide: f64,
    narrow: f32,
}

impl Settings {
    fn parse(planner: &PlannerName, text: &str) -> Result<Self, InvalidInput> {
        let name = planner.name;
        let mut values: Vec<(&'static str, Value)> = Vec::new();
        for pair in text.split(',').filter(|pair| !pair.is_empty()) {
            let (key, number) = pair.split_once('=').unwrap_or((pair, ""));
            let Some(setting) = planner.settings.iter().find(|setting| setting.key == key) else {
                let allowed = match planner.settings {
                    [] => format!("{name} alone, it has no option"),
                    _ => planner.form(),
                };
                return Err(InvalidInput::new(format!("planner.{name}"), key, allowed));
            };
            let field = || format!("planner.{name}.{key}");
            if values.iter().any(|(known, _)| *known == key) {
                return Err(InvalidInput::new(field(), format!("`{number}`"), "to be given once"));
            }
            let (Ok(wide), Ok(narrow)) = (number.parse::<f64>(), number.parse()) else {
                return Err(InvalidInput::new(field(), format!("`{number}`"), setting.range()));
            };
            let in_range = (setting.least..=setting.most).contains(&wide);
            if !in_range || setting.whole && wide.fract() != 0.0 {
                return Err(InvalidInput::new(field(), wide, setting.range()));
            }
            values.push((setting.key, Value { wide, narrow }));
        }
        Ok(Self { values })
    }

    fn value(&self, key: &str) -> Option<Value> {
        self.values.iter().find(|(known, _)| *known == key).map(|(_, value)| *value)
    }

    fn float(&self, key: &str) -> Option<f32> {
        self.value(key).map(|value| value.narrow)
    }

    fn count(&self, key: &str) -> Option<usize> {
        self.value(key).map(|value| value.wide as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Planner, InvalidInput> {
        parse_planner(text, &mut |path| Err(InvalidInput::new("policy", path, "no policy here")))
    }

    #[test]
    fn limits_belong_to_what_is_allowed() {
        for planner in &PLANNERS {
            for setting in planner.settings {
                for value in [setting.least, setting.most] {
                    let text = format!("{}:{}={value}", planner.name, setting.key);
                    assert!(parse(&text).is_ok(), "{text}");
                }
                for value in [setting.least - 1e-9, setting.most * 1.001] {
                    let text = format!("{}:{}={value}", planner.name, setting.key);
                    let message = parse(&text).unwrap_err().to_string();
                    assert!(message.contains(&setting.range()), "{text}: {message}");
                }
            }
        }
    }

    #[test]
    fn defaults_are_what_the_table_says() {
        let is = |text: &str, same: &str| {
            assert_eq!(format!("{:?}", parse(text)), format!("{:?}", parse(same)), "{text}");
        };
        for planner in &PLANNERS {
            for setting in planner.settings {
                // Those in words follow the profile or another planner.
                if setting.default.parse::<f64>().is_ok() {
                    let same = format!("{}:{}={}", planner.name, setting.key, setting.default);
                    is(planner.name, &same);
                }
            }
        }
    }

    #[test]
    fn what_is_meant_is_suggested() {
        for (typed, meant) in [
            ("gdd", "gd"),
            ("GD", "gd"),
            ("rrt_connect", "rrt-connect"),
            ("gradient-descent", "gd"),
            ("gradient_descent", "gd"),
            ("astar", "shortest-path"),
            ("A*", "shortest-path"),
            ("L-BFGS", "lbfgs"),
            ("rrt", "rrt-connect"),
            ("sidestep-1-smal", "sidestep-1-small"),
        ] {
            let message = parse(typed).unwrap_err().to_string();
            assert!(message.ends_with(&format!("did you mean {meant}?")), "{typed}: {message}");
        }
        assert!(!parse("xyzzy12345").unwrap_err().to_string().contains("did you mean"));
    }

    #[test]
    fn settings_are_checked_one_by_one() {
        for (text, part) in [
            ("gd:size=1", "expected gd[:step=NUMBER]"),
            ("auto:step=1", "no option"),
            ("gd:step", "planner.gd.step: `` is not allowed; expected a number from"),
            ("gd:step=1,step=2", "given once"),
            ("stomp:rollouts=2.5", "a whole number from 1 to 10000"),
            ("learned", "learned:PATH"),
            ("auto-with:", "auto-with:PATH"),
        ] {
            let message = parse(text).unwrap_err().to_string();
            assert!(message.contains(part), "{text}: {message}");
        }
    }
}
