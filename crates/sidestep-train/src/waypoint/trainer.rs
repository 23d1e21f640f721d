//! A training of the waypoint policy, one unit at a time.
//!
//! A unit is [`UPDATES_PER_UNIT`] optimizer steps and begins with fresh tasks, so that a checkpoint between units needs to hold
//! nothing but parameters, moments and counters, and goes on to the same bits. The policy that is validated and written is
//! the running average of the parameters (decay 0.999 per step).

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use serde_json::json;
use sidestep::InvalidInput;
use sidestep::kernels::{AdamStep, squared_norm};
use sidestep::network::{WaypointNet, WaypointShape};
use sidestep::policy::{ActionRule, Policy, PolicyCard};
use sidestep::profile::Profile;

use super::config::{StageKind, WaypointConfig};
use super::stages::gradient::Lessons;
use super::stages::imitation::{MEMBERS, Part, Recipe, Slot, Sums};
use super::stages::walks::Walker;
use super::validation::{Tasks, WaypointValidation};
use crate::LICENCE;
use crate::parameters::{he, warm_up_and_cosine};

/// Optimizer steps of a unit.
pub const UPDATES_PER_UNIT: u64 = 250;
/// Tasks of an update that one thread takes together.
const TASKS_PER_PART: usize = 4;
const BETAS: [f64; 2] = [0.9, 0.99];
const EPSILON: f64 = 1e-8;
const MAX_GRADIENT_NORM: f64 = 1.0;
/// Share of the running average that is kept per step.
const KEPT: f32 = 0.999;

/// What one unit did: a point of the training curve.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WaypointProgress {
    /// Index of the stage.
    pub stage: usize,
    /// What the stage does.
    pub kind: StageKind,
    /// Units so far, over all stages.
    pub unit: u64,
    /// Optimizer steps so far.
    pub updates: u64,
    /// Steps of trajectories so far.
    pub trajectory_steps: u64,
    /// Learning rate of the last update.
    pub learning_rate: f64,
    /// Mean loss per trajectory and step (imitation), or minus the mean return of a walk (policy gradient).
    pub loss: f64,
    /// Share of the tasks that the straight start (imitation) or a walk (policy gradient) solved.
    pub solved: f64,
    /// Mean gradient norm before clipping.
    pub gradient_norm: f64,
    /// The result on the validation tasks, where this unit ended with one.
    pub validation: Option<WaypointValidation>,
    /// Whether that is the best so far.
    pub is_best: bool,
}

/// The best policy on the validation tasks so far.
#[derive(Debug, Clone, PartialEq)]
pub struct WaypointBest {
    /// Its parameters.
    pub parameters: Vec<f32>,
    /// Its result.
    pub validation: WaypointValidation,
    /// Optimizer steps that made it.
    pub updates: u64,
}

/// A training and its state.
pub struct WaypointTrainer {
    pub(super) config: WaypointConfig,
    shape: WaypointShape,
    recipe: Recipe,
    tasks: Tasks,
    pub(super) net: WaypointNet,
    /// Running average of the parameters.
    pub(super) average: Vec<f32>,
    pub(super) moments: [Vec<f32>; 2],
    pub(super) units: u64,
    pub(super) trajectory_steps: u64,
    pub(super) curve: Vec<WaypointProgress>,
    pub(super) best: Option<WaypointBest>,
}

impl WaypointTrainer {
    /// A training at its beginning.
    ///
    /// # Errors
    /// If the configuration has a value out of range.
    pub fn new(config: WaypointConfig) -> Result<Self, InvalidInput> {
        let (view, shape) = config.check()?;
        let rule = ActionRule {
            scale: 0.1 * config.network.action_pixels,
            limit: 0.1 * config.network.action_limit_pixels,
            keep_inside: true,
        };
        let recipe = Recipe {
            view: view.clone(),
            rule,
            tasks: config.tasks.clone(),
            imitation: config.imitation.clone(),
            seed: config.seed,
        };
        let net = WaypointNet::new(&shape, he(&shape, config.seed)?)?;
        let average = net.parameters().to_vec();
        let moments = [vec![0.0; average.len()], vec![0.0; average.len()]];
        Ok(Self {
            tasks: Tasks::new(&config.validation, &view),
            config,
            shape,
            recipe,
            net,
            average,
            moments,
            units: 0,
            trajectory_steps: 0,
            curve: Vec::new(),
            best: None,
        })
    }

    /// The configuration.
    pub fn config(&self) -> &WaypointConfig {
        &self.config
    }

    /// The network's sizes.
    pub fn shape(&self) -> &WaypointShape {
        &self.shape
    }

    /// Units done, and in all.
    pub fn units(&self) -> (u64, u64) {
        let units = |updates: u64| updates.div_ceil(UPDATES_PER_UNIT);
        (self.units, self.config.stages.iter().map(|stage| units(stage.updates)).sum())
    }

    /// What every unit so far did.
    pub fn curve(&self) -> &[WaypointProgress] {
        &self.curve
    }

    /// Steps of trajectories so far.
    pub fn trajectory_steps(&self) -> u64 {
        self.trajectory_steps
    }

    /// The best result on the validation tasks so far.
    pub fn best(&self) -> Option<&WaypointBest> {
        self.best.as_ref()
    }

    /// The stage of the next unit with its number in it and the stage's units; none when all are done.
    fn place(&self) -> Option<(usize, u64, u64)> {
        let mut before = 0;
        for (index, stage) in self.config.stages.iter().enumerate() {
            let units = stage.updates.div_ceil(UPDATES_PER_UNIT);
            if self.units < before + units {
                return Some((index, self.units - before, units));
            }
            before += units;
        }
        None
    }

    /// One epoch on the walks of an update, which the first one makes.
    fn learn(&self, lessons: &mut [Lessons], parts: &mut [Part], update: u64, epoch: usize) {
        let settings = &self.config.policy_gradient;
        let walker = Walker { net: &self.net, recipe: &self.recipe, settings };
        let number = self.units * UPDATES_PER_UNIT + update;
        let tasks = lessons.par_iter_mut().zip(parts).enumerate();
        tasks.for_each(|(index, (lessons, part))| {
            part.clear(self.net.parameters().len());
            if epoch == 0 {
                let first = index * TASKS_PER_PART;
                let tasks = first as u64..settings.tasks.min(first + TASKS_PER_PART) as u64;
                lessons.walk(walker, number, tasks, part);
            }
            lessons.learn(walker, part);
        });
    }

    /// One optimizer step, number `number` of the stage, with the parts' gradient over `divisor`; returns its norm.
    fn update(
        &mut self,
        parts: &[Part],
        sums: &mut Sums,
        divisor: f32,
        learning_rate: f64,
        number: u64,
    ) -> f64 {
        let mut gradient = add_up(parts, sums);
        gradient.iter_mut().for_each(|g| *g /= divisor);
        let norm = f64::from(squared_norm(&gradient)).sqrt();
        let scale = (MAX_GRADIENT_NORM / norm.max(MAX_GRADIENT_NORM)) as f32;
        let adam = AdamStep::new(number, learning_rate, BETAS, EPSILON, scale);
        let [first, second] = &mut self.moments;
        self.net.update(|parameters| adam.apply(parameters, &gradient, first, second));
        for (average, p) in self.average.iter_mut().zip(self.net.parameters()) {
            *average = KEPT * *average + (1.0 - KEPT) * p;
        }
        norm
    }

    /// Makes the next unit; `None` when all are done.
    ///
    /// # Errors
    /// If the parameters are no longer finite: the learning rate is too high.
    pub fn step(&mut self) -> Result<Option<WaypointProgress>, InvalidInput> {
        let Some((index, unit, units)) = self.place() else { return Ok(None) };
        let stage = self.config.stages[index].clone();
        if unit == 0 {
            self.moments.iter_mut().for_each(|moment| moment.fill(0.0));
        }
        let total = (units * UPDATES_PER_UNIT) as f64;
        let mut slots: Vec<Slot> = match stage.kind {
            StageKind::Imitation => (0..self.config.imitation.tasks as u64)
                .into_par_iter()
                .map(|slot| Slot::new(&self.recipe, &self.net, self.units, slot))
                .collect(),
            StageKind::PolicyGradient => Vec::new(),
        };
        let tasks = match stage.kind {
            StageKind::Imitation => self.config.imitation.tasks,
            StageKind::PolicyGradient => self.config.policy_gradient.tasks,
        };
        let (mut parts, mut lessons): (Vec<Part>, Vec<Lessons>) = (Vec::new(), Vec::new());
        parts.resize_with(tasks.div_ceil(TASKS_PER_PART), Part::default);
        lessons.resize_with(parts.len(), Lessons::default);
        let mut sums = Sums::default();
        let (mut norms, mut learning_rate) = (0.0, 0.0);
        for update in 0..UPDATES_PER_UNIT {
            let done = unit * UPDATES_PER_UNIT + update;
            learning_rate = stage.learning_rate * warm_up_and_cosine(done as f64, total);
            match stage.kind {
                StageKind::Imitation => {
                    let (net, recipe) = (&self.net, &self.recipe);
                    let steps = self.config.imitation.steps;
                    let tasks = slots.par_chunks_mut(TASKS_PER_PART).zip(&mut parts);
                    tasks.for_each(|(slots, part)| {
                        part.clear(net.parameters().len());
                        slots.iter_mut().for_each(|slot| slot.run(net, recipe, steps, part));
                    });
                    let divisor = (slots.len() * MEMBERS * steps) as f32;
                    norms += self.update(&parts, &mut sums, divisor, learning_rate, done + 1);
                }
                StageKind::PolicyGradient => {
                    let epochs = self.config.policy_gradient.epochs;
                    for epoch in 0..epochs {
                        self.learn(&mut lessons, &mut parts, update, epoch);
                        let settings = &self.config.policy_gradient;
                        let divisor = (settings.tasks * settings.walks) as f32;
                        let number = done * epochs as u64 + epoch as u64 + 1;
                        norms += self.update(&parts, &mut sums, divisor, learning_rate, number)
                            / epochs as f64;
                    }
                }
            }
        }
        self.units += 1;
        self.trajectory_steps += sums.steps as u64;
        if !self.net.parameters().iter().all(|p| p.is_finite()) {
            let allowed = format!("a lower rate: after unit {} not all is finite", self.units);
            return Err(InvalidInput::new("stages.learning_rate", stage.learning_rate, allowed));
        }
        let per = match stage.kind {
            StageKind::Imitation => sums.steps,
            StageKind::PolicyGradient => sums.ended,
        };
        let mut progress = WaypointProgress {
            stage: index,
            kind: stage.kind,
            unit: self.units,
            updates: self.units * UPDATES_PER_UNIT,
            trajectory_steps: self.trajectory_steps,
            learning_rate,
            loss: sums.loss / per.max(1.0),
            solved: sums.solved / sums.ended.max(1.0),
            gradient_norm: norms / UPDATES_PER_UNIT as f64,
            validation: None,
            is_best: false,
        };
        let last = unit + 1 == units;
        if last || self.units.is_multiple_of(self.config.validation.every) {
            self.validate(&mut progress)?;
        }
        self.curve.push(progress.clone());
        Ok(Some(progress))
    }

    fn validate(&mut self, progress: &mut WaypointProgress) -> Result<(), InvalidInput> {
        let net = WaypointNet::new(&self.shape, self.average.clone())?;
        let result = self.tasks.validate(&net, self.recipe.rule, self.config.validation.steps);
        progress.is_best = self.best.as_ref().is_none_or(|best| result.beats(&best.validation));
        if progress.is_best {
            let (parameters, updates) = (self.average.clone(), progress.updates);
            self.best = Some(WaypointBest { parameters, validation: result, updates });
        }
        progress.validation = Some(result);
        Ok(())
    }

    /// The best policy on the validation tasks so far, or the present average if there was no validation yet.
    ///
    /// # Errors
    /// Never for a training that has not diverged.
    pub fn best_policy(&self) -> Result<Policy, InvalidInput> {
        let (parameters, updates) = match &self.best {
            Some(best) => (&best.parameters, best.updates),
            None => (&self.average, self.units * UPDATES_PER_UNIT),
        };
        let curve: Vec<_> = self
            .curve
            .iter()
            .filter_map(|progress| Some((progress, progress.validation?)))
            .map(|(progress, v)| {
                json!({"updates": progress.updates, "easy": v.easy.success(), "hard": v.hard.success()})
            })
            .collect();
        let card = PolicyCard {
            format: String::new(),
            architecture: String::new(),
            sizes: Vec::new(),
            waypoints: Profile::DEFAULT.waypoints,
            observation: self.config.observation.clone(),
            profile: Profile::DEFAULT.name.into(),
            action: self.recipe.rule,
            training: json!({
                "config": self.config,
                "updates": updates,
                "trajectory_steps": self.trajectory_steps,
                "validation_curve": curve,
            }),
            licence: LICENCE.into(),
        };
        Policy::of_waypoints(card, WaypointNet::new(&self.shape, parameters.clone())?)
    }
}

/// Adds gradients and sums in the order of the tasks.
fn add_up(parts: &[Part], sums: &mut Sums) -> Vec<f32> {
    let mut total = vec![0.0; parts.first().map_or(0, |part| part.gradient.len())];
    total.par_chunks_mut(4096).enumerate().for_each(|(chunk, total)| {
        for part in parts {
            let gradient = &part.gradient[chunk * 4096..];
            total.iter_mut().zip(gradient).for_each(|(sum, g)| *sum += g);
        }
    });
    for Part { sums: own, .. } in parts {
        sums.steps += own.steps;
        sums.loss += own.loss;
        sums.ended += own.ended;
        sums.solved += own.solved;
    }
    total
}
