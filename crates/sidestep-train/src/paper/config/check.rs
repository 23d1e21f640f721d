//! Checks a configuration once, and names its parts.

use sidestep::InvalidInput;
use sidestep::plan::starts::StartStrategy;
use sidestep::policy::ActionRule;
use sidestep::policy::observation::{ObservationPart, observation_len};
use sidestep::profile::Profile;
use sidestep::suite::Suite;

use super::TrainConfig;
use crate::config::range::{above_zero, refuse, training_seed, validation_seed, within};
use crate::environment::Rules;
use crate::paper::stages::ppo::RepairBy;

/// Most numbers in the observations of one update or of cloning (4 GB of f32).
const MAX_NUMBERS: usize = 1 << 30;

/// A configuration that has been checked, with what its names stand for.
#[derive(Debug, Clone)]
pub(crate) struct Setup {
    pub config: TrainConfig,
    pub profile: Profile,
    pub parts: Vec<ObservationPart>,
    pub training: Suite,
    pub validation: Suite,
    pub starts: StartStrategy,
    pub dagger_starts: StartStrategy,
    pub rules: Rules,
}

impl Setup {
    /// Checks `config`.
    pub fn new(config: TrainConfig) -> Result<Self, InvalidInput> {
        let profile = config.profile.parse::<Profile>()?;
        let parts: Vec<ObservationPart> = config
            .observation
            .iter()
            .map(|name| name.parse::<ObservationPart>())
            .collect::<Result<_, _>>()?;
        let observation = observation_len(&parts, profile.waypoints)?;
        check_numbers(&config)?;
        check_sizes(&config, observation)?;
        let training = match config.training.suite.as_str() {
            "easy" => Suite::Easy,
            "mix" => Suite::Mix,
            "hard" => Suite::HardTraining,
            other => return refuse("training.suite", other, "easy, hard or mix"),
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
        Ok(Self { config, profile, parts, training, validation, starts, dagger_starts, rules })
    }
}

fn check_numbers(config: &TrainConfig) -> Result<(), InvalidInput> {
    let TrainConfig { training, network, environment, cloning, ppo, validation, .. } = config;
    check_imitation(config)?;
    within("environment_steps", config.environment_steps, 0..=1_000_000_000_000)?;
    within("training.count", training.count, 1..=1_000_000)?;
    within("network.hidden", network.hidden, 1..=4096)?;
    within("environment.mu", environment.mu, 0.0..=1000.0)?;
    within("environment.feasible_bonus", environment.feasible_bonus, 0.0..=1000.0)?;
    above_zero("environment.action_scale", environment.action_scale, 1e6)?;
    above_zero("environment.action_limit", environment.action_limit, 1e6)?;
    within("environment.episode_limit", environment.episode_limit.unwrap_or(1), 1..=u32::MAX)?;
    within("cloning.epochs", cloning.epochs, 0..=1_000_000)?;
    within("cloning.samples_per_task", cloning.samples_per_task, 1..=1_000_000)?;
    above_zero("cloning.step", cloning.step, 1000.0)?;
    within("cloning.minibatch", cloning.minibatch, 1..=1_000_000)?;
    above_zero("cloning.learning_rate", cloning.learning_rate, 1000.0)?;
    within("ppo.environments", ppo.environments, 1..=1_000_000)?;
    within("ppo.steps", ppo.steps, 1..=1_000_000)?;
    within("ppo.gamma", ppo.gamma, 0.0..=1.0)?;
    within("ppo.lambda", ppo.lambda, 0.0..=1.0)?;
    above_zero("ppo.learning_rate", ppo.learning_rate, 1.0)?;
    within("ppo.minibatch", ppo.minibatch, 1..=1_000_000)?;
    within("ppo.epochs", ppo.epochs, 1..=1000)?;
    within("ppo.entropy", ppo.entropy, 0.0..=1000.0)?;
    within("ppo.value", ppo.value, 0.0..=1000.0)?;
    above_zero("ppo.max_gradient_norm", ppo.max_gradient_norm, 1e6)?;
    above_zero("ppo.clip", ppo.clip, 1.0)?;
    above_zero("ppo.target_kl", ppo.target_kl.unwrap_or(1.0), 1000.0)?;
    within("ppo.initial_log_std", ppo.initial_log_std, -10.0..=3.0)?;
    within("validation.count", validation.count, 0..=100_000)?;
    within("validation.every", validation.every, 1..=1_000_000)?;
    within("validation.steps", validation.steps, 1..=100_000)
}

fn check_imitation(config: &TrainConfig) -> Result<(), InvalidInput> {
    let TrainConfig { dagger, expert, repair, .. } = config;
    within("dagger.rounds", dagger.rounds, 0..=100_000)?;
    within("dagger.rollouts", dagger.rollouts, 1..=100_000)?;
    within("dagger.steps", dagger.steps, 1..=10_000)?;
    within("dagger.beta", dagger.beta, 0.0..=1.0)?;
    within("dagger.random_starts", dagger.random_starts, 0.0..=1.0)?;
    within("dagger.noise", dagger.noise, 0.0..=1000.0)?;
    within("dagger.capacity", dagger.capacity, 1..=4_000_000)?;
    within("dagger.minibatches", dagger.minibatches, 1..=1_000_000)?;
    within("dagger.minibatch", dagger.minibatch, 1..=4096)?;
    above_zero("dagger.learning_rate", dagger.learning_rate, 1000.0)?;
    above_zero("expert.step", expert.step, 1000.0)?;
    above_zero("expert.rate", expert.rate, 1.0)?;
    within("expert.alternatives", expert.alternatives, 0..=64)?;
    within("repair.after", repair.after, 1..=u32::MAX)?;
    within("repair.steps", repair.steps, 1..=10_000)?;
    above_zero("repair.weight", repair.weight, 1e6)?;
    if repair.expert != RepairBy::None && config.environment_steps == 0 {
        return refuse(
            "repair.expert",
            "an expert, with environment_steps = 0",
            "\"none\", or environment_steps above 0: episodes are repaired during PPO",
        );
    }
    Ok(())
}

/// Products that decide how much memory a training takes.
fn check_sizes(config: &TrainConfig, observation: usize) -> Result<(), InvalidInput> {
    let TrainConfig { training, cloning, ppo, .. } = config;
    let check = |field: &str, rows: Option<usize>, what: &str| match rows
        .and_then(|rows| rows.checked_mul(observation))
    {
        Some(numbers) if numbers <= MAX_NUMBERS => Ok(()),
        _ => {
            let allowed = format!("{what} x {observation} (observation) up to {MAX_NUMBERS}");
            refuse(field, "too large a product", &allowed)
        }
    };
    check("ppo.steps", ppo.environments.checked_mul(ppo.steps), "environments x steps")?;
    if cloning.epochs == 0 {
        return Ok(());
    }
    let samples = training.count.checked_mul(cloning.samples_per_task);
    check("cloning.samples_per_task", samples, "training.count x samples_per_task")
}
