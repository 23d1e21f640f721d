//! A training, one unit at a time: epochs of cloning, rounds of DAgger, updates of PPO (paper, section II.B).
//!
//! A [`Trainer`] holds the complete state and touches neither files nor clock: the caller writes checkpoints and shows
//! progress. A checkpoint after any unit goes on to the same bits as if nothing had happened ([`crate::paper::checkpoint`]).

use serde::{Deserialize, Serialize};
use serde_json::json;
use sidestep::policy::{Policy, PolicyCard};
use sidestep::profile::Profile;
use sidestep::rng::{Purpose, stream};
use sidestep::suite::Suite;
use sidestep::{InvalidInput, Task, network::Network};

use crate::LICENCE;
use crate::environment::{Environment, Problem};
use crate::paper::agent::Agent;
use crate::paper::config::{Setup, TrainConfig};
use crate::paper::expert::Experts;
use crate::paper::stages::cloning::{self, Samples};
use crate::paper::stages::dagger::{self, Rate, States, Surroundings};
use crate::paper::stages::ppo::{self, Rollout, UpdateMetrics};
use crate::paper::validation::validate;
use crate::parameters::{Optimizer, OptimizerKind};
use crate::validation::Validation;

/// Which part of the training a unit belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Stage {
    /// An epoch of behaviour cloning.
    Cloning,
    /// A round of DAgger: rollouts, then training on all that was met.
    Dagger,
    /// An update of PPO: experience from every environment, then epochs over it.
    Ppo,
}

/// What one unit did: a point of the training curve.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Progress {
    /// The unit's stage.
    pub stage: Stage,
    /// Its number within the stage, from 1.
    pub unit: u64,
    /// Units of the stage in all.
    pub units: u64,
    /// Environment steps made so far.
    pub environment_steps: u64,
    /// Loss of each minibatch of cloning or DAgger, in order; empty for PPO.
    pub cloning_losses: Vec<f64>,
    /// What the update of PPO did.
    pub update: Option<UpdateMetrics>,
    /// The result on the validation tasks, where this unit ended with one.
    pub validation: Option<Validation>,
    /// Whether that is the best so far.
    pub is_best: bool,
}

/// The best policy on the validation tasks so far.
#[derive(Debug, Clone, PartialEq)]
pub struct Best {
    /// Its network.
    pub network: Network,
    /// Its result.
    pub validation: Validation,
    /// Environment steps that made it.
    pub environment_steps: u64,
}

/// A training and its state.
pub struct Trainer {
    pub(crate) setup: Setup,
    pub(crate) problems: Vec<Problem>,
    pub(crate) validation: Vec<Problem>,
    pub(crate) agent: Agent,
    /// Cloning's optimizer, then PPO's.
    pub(crate) optimizer: Optimizer,
    pub(crate) environments: Vec<Environment>,
    pub(crate) epochs: u64,
    pub(crate) rounds: u64,
    pub(crate) states: States,
    pub(crate) updates: u64,
    pub(crate) curve: Vec<Progress>,
    pub(crate) best: Option<Best>,
    experts: Experts,
    samples: Option<Samples>,
    rollouts: Vec<Rollout>,
}

impl Trainer {
    /// A training at its beginning.
    ///
    /// # Errors
    /// If the configuration has a value out of range, or the observation does not fit the tasks.
    pub fn new(config: TrainConfig) -> Result<Self, InvalidInput> {
        let setup = Setup::new(config)?;
        let config = &setup.config;
        // What is hard is the paper's gradient descent's to say, whatever profile is trained.
        let tasks = |suite: Suite, count, seed| suite.generate(count, seed, &Profile::PAPER);
        let problems = |tasks: &[Task]| -> Result<Vec<Problem>, _> {
            let (profile, waypoints) = (&setup.profile, setup.profile.waypoints);
            tasks.iter().map(|task| Problem::new(task, profile, waypoints, &setup.parts)).collect()
        };
        let (training, checks) = (&config.training, &config.validation);
        let validation = problems(&tasks(setup.validation, checks.count, checks.seed))?;
        let tasks = tasks(setup.training, training.count, training.seed);
        let problems = problems(&tasks)?;
        let experts = Experts::new(tasks, config.expert.clone(), setup.rules.action, config.seed);
        let (waypoints, hidden) = (setup.profile.waypoints, config.network.hidden);
        let (initialization, log_std) = (config.network.initialization, config.ppo.initial_log_std);
        let (parts, seed) = (&setup.parts, config.seed);
        let agent = Agent::seeing(parts, waypoints, hidden, initialization, log_std, seed)?;
        let environment = |index| Environment::new(index, &problems, config.seed);
        let mut trainer = Self {
            environments: (0..config.ppo.environments).map(environment).collect(),
            optimizer: Optimizer::new(OptimizerKind::Adam, agent.parameter_count()),
            problems,
            validation,
            agent,
            epochs: 0,
            rounds: 0,
            states: States::default(),
            experts,
            updates: 0,
            curve: Vec::new(),
            best: None,
            samples: None,
            rollouts: Vec::new(),
            setup,
        };
        trainer.begin_stage();
        Ok(trainer)
    }

    /// The configuration.
    pub fn config(&self) -> &TrainConfig {
        &self.setup.config
    }

    /// The stage of the next unit, or `None` when all are done.
    pub fn stage(&self) -> Option<Stage> {
        if self.epochs < self.setup.config.cloning.epochs as u64 {
            Some(Stage::Cloning)
        } else if self.rounds < self.setup.config.dagger.rounds as u64 {
            Some(Stage::Dagger)
        } else if self.updates < self.setup.config.updates() {
            Some(Stage::Ppo)
        } else {
            None
        }
    }

    /// Units made and units in all, over all stages.
    pub fn units(&self) -> (u64, u64) {
        let config = &self.setup.config;
        let imitation = (config.cloning.epochs + config.dagger.rounds) as u64;
        (self.epochs + self.rounds + self.updates, imitation + config.updates())
    }

    /// Environment steps made so far.
    pub fn environment_steps(&self) -> u64 {
        let ppo = &self.setup.config.ppo;
        self.updates * (ppo.environments * ppo.steps) as u64
    }

    /// What every unit so far did.
    pub fn curve(&self) -> &[Progress] {
        &self.curve
    }

    /// Makes the next unit; `None` when all are done.
    ///
    /// # Errors
    /// If the parameters are no longer finite: the learning rate is too high. The training cannot go on from there.
    pub fn step(&mut self) -> Result<Option<Progress>, InvalidInput> {
        let Some(stage) = self.stage() else { return Ok(None) };
        let mut progress = match stage {
            Stage::Cloning => self.clone_once(),
            Stage::Dagger => self.dagger_once(),
            Stage::Ppo => self.update_once(),
        };
        self.check_finite(stage)?;
        if progress.validation_is_due(&self.setup.config) && !self.validation.is_empty() {
            let (rule, steps) = (self.setup.rules.action, self.setup.config.validation.steps);
            let result = validate(&self.agent.policy, rule, &self.validation, steps);
            progress.validation = Some(result);
            progress.is_best = self.best.as_ref().is_none_or(|best| result.beats(&best.validation));
            if progress.is_best {
                let (network, environment_steps) =
                    (self.agent.policy.clone(), progress.environment_steps);
                self.best = Some(Best { network, validation: result, environment_steps });
            }
        }
        if self.stage() != Some(stage) {
            self.begin_stage();
        }
        self.curve.push(progress.clone());
        Ok(Some(progress))
    }

    /// The policy as it is now, with its card.
    ///
    /// # Errors
    /// Never for a trainer that has not diverged.
    pub fn policy(&self) -> Result<Policy, InvalidInput> {
        self.card(&self.agent.policy, self.environment_steps())
    }

    /// The best policy on the validation tasks so far, or the present one if there was no validation yet.
    ///
    /// # Errors
    /// As [`Trainer::policy`].
    pub fn best_policy(&self) -> Result<Policy, InvalidInput> {
        match &self.best {
            Some(best) => self.card(&best.network, best.environment_steps),
            None => self.policy(),
        }
    }

    /// The best result on the validation tasks so far.
    pub fn best(&self) -> Option<&Best> {
        self.best.as_ref()
    }

    /// A fresh optimizer for the stage that comes.
    fn begin_stage(&mut self) {
        self.optimizer = Optimizer::new(self.stage_optimizer(), self.agent.parameter_count());
        if self.stage() != Some(Stage::Cloning) {
            self.samples = None;
        }
        if self.stage() != Some(Stage::Dagger) {
            self.states = States::default();
        }
    }

    /// The kind of optimizer that the stage of the next unit uses.
    pub(crate) fn stage_optimizer(&self) -> OptimizerKind {
        match self.stage() {
            Some(Stage::Cloning) => self.setup.config.cloning.optimizer,
            _ => OptimizerKind::Adam,
        }
    }

    fn clone_once(&mut self) -> Progress {
        let (config, starts) = (&self.setup.config, self.setup.starts);
        let problems = &self.problems;
        let samples = self.samples.get_or_insert_with(|| {
            cloning::draw_samples(problems, starts, &config.cloning, config.seed)
        });
        let mut shuffle = stream(config.seed, Purpose::Shuffle, self.epochs, 1);
        let (agent, optimizer) = (&mut self.agent, &mut self.optimizer);
        let losses = cloning::epoch(agent, optimizer, samples, &config.cloning, &mut shuffle);
        self.epochs += 1;
        Progress {
            cloning_losses: losses,
            ..self.progress(Stage::Cloning, self.epochs, self.setup.config.cloning.epochs as u64)
        }
    }

    fn dagger_once(&mut self) -> Progress {
        let (config, problems) = (&self.setup.config, &self.problems);
        let around = Surroundings {
            problems,
            experts: &self.experts,
            rule: self.setup.rules.action,
            starts: self.setup.dagger_starts,
            seed: config.seed,
        };
        let met = dagger::collect(&self.agent, around, &config.dagger, self.rounds);
        self.states.append(met, config.dagger.capacity);
        let (agent, optimizer) = (&mut self.agent, &mut self.optimizer);
        let schedule = Rate {
            learning_rate: config.dagger.learning_rate
                * config.dagger.schedule.factor(self.rounds as f64 / config.dagger.rounds as f64),
            max_gradient_norm: config.ppo.max_gradient_norm,
        };
        let mut shuffle = stream(config.seed, Purpose::Shuffle, self.rounds, 2);
        let (states, settings) = (&self.states, &config.dagger);
        let losses =
            dagger::train(agent, optimizer, (states, problems), settings, schedule, &mut shuffle);
        self.rounds += 1;
        Progress {
            cloning_losses: losses,
            ..self.progress(Stage::Dagger, self.rounds, self.setup.config.dagger.rounds as u64)
        }
    }

    fn update_once(&mut self) -> Progress {
        let config = &self.setup.config;
        let (ppo, updates) = (&config.ppo, config.updates());
        let (environments, problems) = (&mut self.environments, &self.problems);
        let (rules, rollouts) = (&self.setup.rules, &mut self.rollouts);
        ppo::collect(&self.agent, environments, problems, rules, ppo, rollouts);
        let repair = &config.repair;
        let rule = self.setup.rules.action;
        let repaired =
            ppo::repair::repair(environments, rollouts, problems, &self.experts, rule, repair);
        let progress = self.updates as f64 / updates as f64;
        let learning_rate = ppo.learning_rate * ppo.schedule.factor(progress);
        let mut shuffle = stream(config.seed, Purpose::Shuffle, self.updates, 0);
        let (agent, optimizer) = (&mut self.agent, &mut self.optimizer);
        let demonstrations = (&repaired, repair.weight);
        let rollouts = &self.rollouts;
        let metrics = ppo::update(
            agent,
            optimizer,
            rollouts,
            demonstrations,
            ppo,
            learning_rate,
            &mut shuffle,
        );
        self.updates += 1;
        Progress { update: Some(metrics), ..self.progress(Stage::Ppo, self.updates, updates) }
    }

    fn progress(&self, stage: Stage, unit: u64, units: u64) -> Progress {
        Progress {
            stage,
            unit,
            units,
            environment_steps: self.environment_steps(),
            cloning_losses: Vec::new(),
            update: None,
            validation: None,
            is_best: false,
        }
    }

    fn check_finite(&self, stage: Stage) -> Result<(), InvalidInput> {
        let Agent { policy, value, log_std } = &self.agent;
        let mut all = policy.parameters().iter().chain(value.parameters()).chain(log_std);
        if all.all(|parameter| parameter.is_finite()) {
            return Ok(());
        }
        let config = &self.setup.config;
        let (field, rate, unit) = match stage {
            Stage::Cloning => ("cloning", config.cloning.learning_rate, self.epochs),
            Stage::Dagger => ("dagger", config.dagger.learning_rate, self.rounds),
            Stage::Ppo => ("ppo", config.ppo.learning_rate, self.updates),
        };
        let allowed = format!("a lower rate: after unit {unit} the parameters are not finite");
        Err(InvalidInput::new(format!("{field}.learning_rate"), rate, allowed))
    }

    fn card(&self, network: &Network, environment_steps: u64) -> Result<Policy, InvalidInput> {
        let config = &self.setup.config;
        let point = |(index, progress): (usize, &Progress)| {
            let result = progress.validation?;
            Some(json!({
                "unit": index + 1,
                "stage": progress.stage,
                "environment_steps": progress.environment_steps,
                "success": result.success(),
                "mean_iterations": result.mean_iterations,
            }))
        };
        let curve: Vec<_> = self.curve.iter().enumerate().filter_map(point).collect();
        let card = PolicyCard {
            format: String::new(),
            architecture: String::new(),
            sizes: Vec::new(),
            waypoints: self.setup.profile.waypoints,
            observation: config.observation.clone(),
            profile: config.profile.clone(),
            action: self.setup.rules.action,
            training: json!({
                "config": config,
                "environment_steps": environment_steps,
                "validation_curve": curve,
            }),
            licence: LICENCE.into(),
        };
        Policy::new(card, network.clone())
    }
}

impl Progress {
    /// After cloning, after every so many rounds or updates, and after the last one.
    fn validation_is_due(&self, config: &TrainConfig) -> bool {
        match self.stage {
            Stage::Cloning => self.unit == self.units,
            Stage::Dagger | Stage::Ppo => {
                self.unit == self.units || self.unit.is_multiple_of(config.validation.every)
            }
        }
    }
}
