//! Checks a configuration once, and names its parts.

use sidestep::InvalidInput;
use sidestep::plan::starts::StartStrategy;
use sidestep::policy::ActionRule;
use sidestep::policy::observation::{ObservationPart, OwnPart, observation_len};
use sidestep::profile::Profile;
use sidestep::suite::Suite;

use super::{TrainConfig, memory};
use crate::config::check_ranges;
use crate::config::range::{refuse, training_seed, validation_seed};
use crate::environments::Rules;
use crate::paper::stages::ppo::RepairBy;

/// A configuration that has been checked, with what its names stand for.
#[derive(Debug, Clone)]
pub(crate) struct Setup {
    pub config: TrainConfig,
    pub profile: Profile,
    pub parts: Vec<ObservationPart>,
    pub own: Vec<OwnPart>,
    pub training: Suite,
    pub validation: Suite,
    pub starts: StartStrategy,
    pub dagger_starts: StartStrategy,
    pub rules: Rules,
}

impl Setup {
    /// Checks `config`, some of whose parts of the observation may be one's `own`.
    pub fn new(config: TrainConfig, own: &[OwnPart]) -> Result<Self, InvalidInput> {
        let profile = config.profile.parse::<Profile>()?;
        let parts: Vec<ObservationPart> = config
            .observation
            .iter()
            .map(|name| ObservationPart::named(name, own))
            .collect::<Result<_, _>>()?;
        let observation = observation_len(&parts, profile.waypoints, 2)?;
        check_ranges(&config)?;
        check_repair(&config)?;
        memory::check(&config, observation, &parts, profile.waypoints)?;
        let training = match config.training.suite.as_str() {
            "easy" => Suite::Easy,
            "mix" => Suite::Mix,
            // The first is how `--suite` spells it, the second how configurations did before.
            "hard-training" | "hard" => Suite::HardTraining,
            other => {
                let allowed = "easy, hard-training (or hard, the same here) or mix";
                return refuse("training.suite", other, allowed);
            }
        };
        training_seed("training.seed", config.training.seed)?;
        validation_seed("validation.seed", config.validation.seed)?;
        let validation =
            config.validation.suite.parse::<Suite>().map_err(|error| error.inside("validation"))?;
        let starts = config
            .cloning
            .starts
            .parse::<StartStrategy>()
            .map_err(|error| InvalidInput::new("cloning.starts", error.value, error.allowed))?;
        let dagger_starts = config
            .dagger
            .starts
            .parse::<StartStrategy>()
            .map_err(|error| InvalidInput::new("dagger.starts", error.value, error.allowed))?;
        let environment = &config.environment;
        let action = ActionRule {
            scale: environment.action_scale,
            limit: environment.action_limit,
            keep_inside: environment.keep_inside,
        };
        let rules = Rules {
            action,
            mu: environment.mu,
            feasible_bonus: environment.feasible_bonus,
            episode_limit: environment.episode_limit,
        };
        let own = own.to_vec();
        Ok(Self { config, profile, parts, own, training, validation, starts, dagger_starts, rules })
    }
}

fn check_repair(config: &TrainConfig) -> Result<(), InvalidInput> {
    let TrainConfig { repair, .. } = config;
    if repair.expert != RepairBy::None && config.environment_steps == 0 {
        return refuse(
            "repair.expert",
            "an expert, with environment_steps = 0",
            "\"none\", or environment_steps above 0: episodes are repaired during PPO",
        );
    }
    Ok(())
}
