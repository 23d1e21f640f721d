//! A training, one unit at a time: epochs of cloning, rounds of DAgger, updates of PPO (paper,
//! section II.B).
//!
//! A [`Trainer`] holds the complete state and touches neither files nor clock: the caller writes
//! checkpoints and shows progress. A checkpoint after any unit goes on to the same bits as if
//! nothing had happened ([`crate::paper::checkpoint`]).

use serde_json::json;
use sidestep::policy::observation::OwnPart;
use sidestep::policy::{Policy, PolicyCard, PolicyNetwork};
use sidestep::profile::Profile;
use sidestep::rng::{Purpose, stream};
use sidestep::suite::Suite;
use sidestep::{InvalidInput, Task, network::Network};

use super::curve::{Progress, Stage};
use crate::LICENCE;
use crate::environments::{Environment, Environments, Problem, Reward};
use crate::paper::agent::Agent;
use crate::paper::config::{Setup, TrainConfig};
use crate::paper::expert::Experts;
use crate::paper::stages::cloning::{self, Samples};
use crate::paper::stages::dagger::{self, Rate, States, Surroundings};
use crate::paper::stages::ppo::{self, Rollout};
use crate::paper::validation::validate;
use crate::parameters::{Optimizer, OptimizerKind};
use crate::training::{Divergence, Units};
use crate::validation::Validation;

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
    pub(crate) validation: Vec<Problem>,
    pub(crate) agent: Agent,
    /// Cloning's optimizer, then PPO's.
    pub(crate) optimizer: Optimizer,
    pub(crate) environments: Environments,
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
        Self::seeing(&[], config)
    }

    /// The same, where parts of the observation are one's `own`; [`Policy::read_seeing`] reads the policies.
    ///
    /// # Errors
    /// As [`Trainer::new`], and if a part is neither there nor among them.
    pub fn seeing(own: &[OwnPart], config: TrainConfig) -> Result<Self, InvalidInput> {
        let setup = Setup::new(config, own)?;
        let config = &setup.config;
        // What is hard is the paper's gradient descent's to say, whatever profile is trained.
        let tasks = |suite: Suite, count, seed| suite.generate(count, seed, &Profile::PAPER);
        let (training, checks) = (&config.training, &config.validation);
        let ready =
            |task: &Task| Problem::new(task, &setup.profile, setup.profile.waypoints, &setup.parts);
        let validation = tasks(setup.validation, checks.count, checks.seed);
        let validation = validation.iter().map(ready).collect::<Result<_, _>>()?;
        let tasks = tasks(setup.training, training.count, training.seed);
        let (profile, count) = (&setup.profile, config.ppo.environments);
        let environments =
            Environments::new(&tasks, profile, &setup.parts, setup.rules, count, config.seed)?;
        let experts = Experts::new(tasks, config.expert.clone(), setup.rules.action, config.seed);
        let (waypoints, hidden) = (setup.profile.waypoints, config.network.hidden);
        let (initialization, log_std) = (config.network.initialization, config.ppo.initial_log_std);
        let (parts, seed) = (&setup.parts, config.seed);
        let agent = Agent::seeing(parts, waypoints, hidden, initialization, log_std, seed)?;
        let mut trainer = Self {
            environments,
            optimizer: Optimizer::new(OptimizerKind::Adam, agent.parameter_count()),
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

    /// The same training with a reward of one's own, which checkpoints do not hold: give it again
    /// after resuming.
    pub fn with_reward(mut self, reward: Reward) -> Self {
        self.environments = self.environments.with_reward(reward);
        self
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
    pub fn units(&self) -> Units {
        let config = &self.setup.config;
        let imitation = (config.cloning.epochs + config.dagger.rounds) as u64;
        let done = self.epochs + self.rounds + self.updates;
        Units { done, all: imitation + config.updates() }
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
    /// If something is no longer finite afterwards. The training is then as it was before the unit.
    pub fn step(&mut self) -> Result<Option<Progress>, Divergence> {
        let Some(stage) = self.stage() else { return Ok(None) };
        let before = Before::of(self, stage);
        let mut progress = match stage {
            Stage::Cloning => self.clone_once(),
            Stage::Dagger => self.dagger_once(),
            Stage::Ppo => self.update_once(),
        };
        if let Some(divergence) = self.divergence(&progress) {
            before.restore(self);
            return Err(divergence);
        }
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
        match self.stage() {
            // The last moments are kept, so that a training that is given more steps goes on as if
            // it had had them.
            None => self.forget_samples(None),
            next if next != Some(stage) => self.begin_stage(),
            _ => {}
        }
        self.curve.push(progress.clone());
        Ok(Some(progress))
    }

    /// Begins from the weights of `policy`; its values are not known, so the value network begins
    /// as ever.
    ///
    /// # Errors
    /// If the policy has another observation, profile, size or meaning of its output than the
    /// configuration.
    pub fn begin_from(&mut self, policy: &Policy) -> Result<(), InvalidInput> {
        let (card, config) = (policy.card(), &self.setup.config);
        let differs = |field: &str, found: String, wanted: String| {
            let allowed = format!("{wanted}, as the configuration says");
            Err(InvalidInput::new(format!("--init: {field}"), found, allowed))
        };
        let PolicyNetwork::Whole { network, .. } = policy.network() else {
            return differs("architecture", card.architecture.clone(), "mlp or cnn".into());
        };
        if card.observation != config.observation {
            let [found, wanted] = [&card.observation, &config.observation].map(|o| o.join(", "));
            return differs("observation", found, wanted);
        }
        if card.profile != config.profile {
            return differs("profile", card.profile.clone(), config.profile.clone());
        }
        if network.sizes() != self.agent.policy.sizes() {
            let [found, wanted] =
                [network.sizes(), self.agent.policy.sizes()].map(|s| format!("{s:?}"));
            return differs("sizes", found, wanted);
        }
        if card.action != self.setup.rules.action {
            let [found, wanted] =
                [card.action, self.setup.rules.action].map(|rule| format!("{rule:?}"));
            return differs("action", found, wanted);
        }
        self.agent.policy = network.clone();
        Ok(())
    }

    /// The policy as it is now, with its card.
    ///
    /// # Errors
    /// Never for a trainer that has not diverged.
    pub fn policy(&self) -> Result<Policy, InvalidInput> {
        self.card(&self.agent.policy, self.environment_steps())
    }

    /// The best policy on the validation tasks so far, or the present one if there was no
    /// validation yet.
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
        self.forget_samples(self.stage());
    }

    /// Drops what only other stages than the next one need.
    fn forget_samples(&mut self, next: Option<Stage>) {
        if next != Some(Stage::Cloning) {
            self.samples = None;
        }
        if next != Some(Stage::Dagger) {
            self.states = States::default();
        }
    }

    /// The kind of optimizer of the next unit's stage, or of the last stage where all is done.
    pub(crate) fn stage_optimizer(&self) -> OptimizerKind {
        let config = &self.setup.config;
        let only_cloning = config.updates() == 0 && config.dagger.rounds == 0;
        match self.stage() {
            Some(Stage::Cloning) => config.cloning.optimizer,
            None if only_cloning => config.cloning.optimizer,
            _ => OptimizerKind::Adam,
        }
    }

    fn clone_once(&mut self) -> Progress {
        let (config, starts) = (&self.setup.config, self.setup.starts);
        let problems = self.environments.problems();
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
        let (config, problems) = (&self.setup.config, self.environments.problems());
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
        let (environments, rollouts) = (&mut self.environments, &mut self.rollouts);
        ppo::collect(&self.agent, environments, ppo, rollouts);
        let repair = &config.repair;
        let repaired = ppo::repair::repair(environments, rollouts, &self.experts, repair);
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

    /// The divergence of the unit that was just made, if it is one.
    fn divergence(&self, progress: &Progress) -> Option<Divergence> {
        let Agent { policy, value, log_std } = &self.agent;
        let mut values = vec![
            ("parameters", policy.parameters()),
            ("parameters", value.parameters()),
            ("parameters", log_std),
        ];
        values.extend(self.optimizer.moments().iter().map(|moment| ("gradients", &moment[..])));
        for environment in self.environments.all() {
            values.push(("trajectories", environment.waypoints()));
            values.push(("observations", environment.observation()));
        }
        let config = &self.setup.config;
        let key = || {
            let (stage, rate) = match progress.stage {
                Stage::Cloning => ("cloning", config.cloning.learning_rate),
                Stage::Dagger => ("dagger", config.dagger.learning_rate),
                Stage::Ppo => ("ppo", config.ppo.learning_rate),
            };
            (format!("{stage}.learning_rate"), rate)
        };
        Divergence::find(self.units().done, &values, &progress.scalars(), key)
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
            dof: 2,
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
        Policy::seeing(&self.setup.own, card, network.clone())
    }
}

/// What a unit of a stage changes, as it was before.
struct Before {
    agent: Agent,
    optimizer: Optimizer,
    environments: Option<Vec<Environment>>,
    states: Option<States>,
    counters: [u64; 3],
}

impl Before {
    fn of(trainer: &Trainer, stage: Stage) -> Self {
        Self {
            agent: trainer.agent.clone(),
            optimizer: trainer.optimizer.clone(),
            environments: (stage == Stage::Ppo).then(|| trainer.environments.all().to_vec()),
            states: (stage == Stage::Dagger).then(|| trainer.states.clone()),
            counters: [trainer.epochs, trainer.rounds, trainer.updates],
        }
    }

    fn restore(self, trainer: &mut Trainer) {
        (trainer.agent, trainer.optimizer) = (self.agent, self.optimizer);
        [trainer.epochs, trainer.rounds, trainer.updates] = self.counters;
        if let Some(environments) = self.environments {
            trainer.environments.set_all(environments);
        }
        if let Some(states) = self.states {
            trainer.states = states;
        }
    }
}
