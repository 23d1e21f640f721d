//! A training of the waypoint policy, one unit at a time.
//!
//! A unit is [`UPDATES_PER_UNIT`] optimizer steps and begins with fresh tasks, so that a checkpoint
//! between units needs to hold nothing but parameters, moments and counters, and goes on to the
//! same bits. The policy that is validated and written is the running average of the parameters
//! (decay 0.999 per step).

use rayon::prelude::*;
use serde_json::json;
use sidestep::InvalidInput;
use sidestep::kernels::{AdamStep, squared_norm};
use sidestep::network::{WaypointNet, WaypointShape};
use sidestep::policy::{ActionRule, Policy, PolicyCard, PolicyNetwork};
use sidestep::profile::Profile;

use super::config::{ARCHITECTURE, StageConfig, StageKind, WaypointConfig};
use super::curve::WaypointProgress;
use super::stages::gradient::Lessons;
use super::stages::imitation::{Ingredients, MEMBERS, Part, Slot, Sums, TASKS_PER_PART};
use super::stages::walks::Walker;
use super::validation::{Tasks, WaypointValidation};
use crate::LICENCE;
use crate::parameters::{finite, he, told_norm, warm_up_and_cosine};
use crate::training::{Divergence, Units};

/// Optimizer steps of a unit.
pub const UPDATES_PER_UNIT: u64 = 250;
const BETAS: [f64; 2] = [0.9, 0.99];
const EPSILON: f64 = 1e-8;
const MAX_GRADIENT_NORM: f64 = 1.0;
/// Share of the running average that is kept per step.
const KEPT: f32 = 0.999;

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
    ingredients: Ingredients,
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
        let (sight, shape) = config.checked()?;
        let rule = ActionRule {
            scale: 0.1 * config.network.action_pixels,
            limit: 0.1 * config.network.action_limit_pixels,
            keep_inside: true,
        };
        let ingredients = Ingredients {
            sight: sight.clone(),
            rule,
            tasks: config.tasks.clone(),
            imitation: config.imitation.clone(),
            seed: config.seed,
        };
        let net = WaypointNet::new(&shape, he(&shape, config.seed)?)?;
        let average = net.parameters().to_vec();
        let moments = [vec![0.0; average.len()], vec![0.0; average.len()]];
        Ok(Self {
            tasks: Tasks::new(&config.validation, &sight),
            config,
            shape,
            ingredients,
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
    pub fn units(&self) -> Units {
        let units = |stage: &StageConfig| stage.updates.div_ceil(UPDATES_PER_UNIT);
        Units { done: self.units, all: self.config.stages.iter().map(units).sum() }
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

    /// Where the next unit is; none when all are done.
    fn place(&self) -> Option<Place> {
        let mut before = 0;
        for (index, stage) in self.config.stages.iter().enumerate() {
            let units = stage.updates.div_ceil(UPDATES_PER_UNIT);
            if self.units < before + units {
                return Some(Place { stage: index, unit: self.units - before, units });
            }
            before += units;
        }
        None
    }

    /// One epoch on the walks of an update, which the first one makes.
    fn learn(&self, lessons: &mut [Lessons], parts: &mut [Part], update: u64, epoch: usize) {
        let settings = &self.config.policy_gradient;
        let walker = Walker { net: &self.net, ingredients: &self.ingredients, settings };
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

    /// One optimizer step, number `number` of the stage, with the parts' gradient over `divisor`;
    /// returns its norm.
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
        let squared = squared_norm(&gradient);
        let norm = f64::from(squared).sqrt();
        let scale = (MAX_GRADIENT_NORM / norm.max(MAX_GRADIENT_NORM)) as f32;
        let adam = AdamStep::new(number, learning_rate, BETAS, EPSILON, scale);
        let [first, second] = &mut self.moments;
        self.net.update(|parameters| adam.apply(parameters, &gradient, first, second));
        for (average, p) in self.average.iter_mut().zip(self.net.parameters()) {
            *average = KEPT * *average + (1.0 - KEPT) * p;
        }
        told_norm(squared, &gradient)
    }

    /// Makes the next unit; `None` when all are done.
    ///
    /// # Errors
    /// If something is no longer finite afterwards. The training is then as it was before the unit.
    pub fn step(&mut self) -> Result<Option<WaypointProgress>, Divergence> {
        let Some(place) = self.place() else { return Ok(None) };
        let stage = self.config.stages[place.stage].clone();
        let before = (self.net.clone(), self.average.clone(), self.moments.clone());
        if place.unit == 0 {
            self.moments.iter_mut().for_each(|moment| moment.fill(0.0));
        }
        let made = match stage.kind {
            StageKind::Imitation => self.imitate(&stage, place),
            StageKind::PolicyGradient => self.improve(&stage, place),
        };
        let Made { sums, norms, learning_rate } = made;
        let per = match stage.kind {
            StageKind::Imitation => sums.steps,
            StageKind::PolicyGradient => sums.ended,
        };
        let unit = self.units + 1;
        let mut progress = WaypointProgress {
            stage: place.stage,
            kind: stage.kind,
            unit,
            updates: unit * UPDATES_PER_UNIT,
            trajectory_steps: self.trajectory_steps + sums.steps as u64,
            learning_rate,
            loss: finite(sums.loss / per.max(1.0)),
            solved: sums.solved / sums.ended.max(1.0),
            gradient_norm: finite(norms / UPDATES_PER_UNIT as f64),
            validation: None,
            is_best: false,
        };
        if let Some(divergence) = self.divergence(place, &progress) {
            (self.net, self.average, self.moments) = before;
            return Err(divergence);
        }
        self.units = unit;
        self.trajectory_steps = progress.trajectory_steps;
        let last = place.unit + 1 == place.units;
        if last || unit.is_multiple_of(self.config.validation.every) {
            self.validate(&mut progress);
        }
        self.curve.push(progress.clone());
        Ok(Some(progress))
    }

    /// A unit of imitation.
    fn imitate(&mut self, stage: &StageConfig, place: Place) -> Made {
        let (count, steps) = (self.config.imitation.tasks, self.config.imitation.steps);
        let begin = |slot| Slot::new(&self.ingredients, &self.net, self.units, slot);
        let mut slots: Vec<Slot> = (0..count as u64).into_par_iter().map(begin).collect();
        let mut parts = Part::for_tasks(count);
        let divisor = (count * MEMBERS * steps) as f32;
        let mut made = Made::default();
        for update in place.updates() {
            let (net, ingredients) = (&self.net, &self.ingredients);
            let tasks = slots.par_chunks_mut(TASKS_PER_PART).zip(&mut parts);
            tasks.for_each(|(slots, part)| {
                part.clear(net.parameters().len());
                slots.iter_mut().for_each(|slot| slot.run(net, ingredients, steps, part));
            });
            made.learning_rate = stage.learning_rate * place.rate(update);
            let (sums, rate) = (&mut made.sums, made.learning_rate);
            made.norms += self.update(&parts, sums, divisor, rate, update + 1);
        }
        made
    }

    /// A unit of policy gradient.
    fn improve(&mut self, stage: &StageConfig, place: Place) -> Made {
        let settings = self.config.policy_gradient.clone();
        let (mut parts, mut lessons) = (Part::for_tasks(settings.tasks), Vec::new());
        lessons.resize_with(parts.len(), Lessons::default);
        let divisor = (settings.tasks * settings.walks) as f32;
        let mut made = Made::default();
        for (index, update) in place.updates().enumerate() {
            made.learning_rate = stage.learning_rate * place.rate(update);
            for epoch in 0..settings.epochs {
                self.learn(&mut lessons, &mut parts, index as u64, epoch);
                let number = update * settings.epochs as u64 + epoch as u64 + 1;
                let (sums, rate) = (&mut made.sums, made.learning_rate);
                let norm = self.update(&parts, sums, divisor, rate, number);
                made.norms += norm / settings.epochs as f64;
            }
        }
        made
    }

    /// The divergence of the unit that was just made, if it is one.
    fn divergence(&self, place: Place, progress: &WaypointProgress) -> Option<Divergence> {
        let values = [
            ("parameters", self.net.parameters()),
            ("parameters", &self.average[..]),
            ("gradients", &self.moments[0]),
            ("gradients", &self.moments[1]),
        ];
        let rate = self.config.stages[place.stage].learning_rate;
        let key = || (format!("stages[{}].learning_rate", place.stage), rate);
        Divergence::find(progress.unit, &values, &progress.scalars(), key)
    }

    fn validate(&mut self, progress: &mut WaypointProgress) {
        let mut net = self.net.clone();
        net.update(|parameters| parameters.copy_from_slice(&self.average));
        let result = self.tasks.validate(&net, self.ingredients.rule, self.config.validation.steps);
        progress.is_best = self.best.as_ref().is_none_or(|best| result.beats(&best.validation));
        if progress.is_best {
            let (parameters, updates) = (self.average.clone(), progress.updates);
            self.best = Some(WaypointBest { parameters, validation: result, updates });
        }
        progress.validation = Some(result);
    }

    /// Begins from the weights of `policy`.
    ///
    /// # Errors
    /// If the policy has another observation, size or meaning of its output than the configuration.
    pub fn begin_from(&mut self, policy: &Policy) -> Result<(), InvalidInput> {
        let card = policy.card();
        let differs = |field: &str, found: String, wanted: String| {
            let allowed = format!("{wanted}, as the configuration says");
            Err(InvalidInput::new(format!("--init: {field}"), found, allowed))
        };
        let (PolicyNetwork::Waypoint { network, .. } | PolicyNetwork::Joints { network, .. }) =
            policy.network()
        else {
            return differs("architecture", card.architecture.clone(), ARCHITECTURE.into());
        };
        if card.observation != self.config.observation {
            let [found, wanted] =
                [&card.observation, &self.config.observation].map(|o| o.join(", "));
            return differs("observation", found, wanted);
        }
        if *network.shape() != self.shape {
            let [found, wanted] = [network.shape(), &self.shape].map(|shape| format!("{shape:?}"));
            return differs("network", found, wanted);
        }
        if card.action != self.ingredients.rule {
            let [found, wanted] =
                [card.action, self.ingredients.rule].map(|rule| format!("{rule:?}"));
            return differs("action", found, wanted);
        }
        self.net = network.clone();
        self.average = network.parameters().to_vec();
        Ok(())
    }

    /// The best policy on the validation tasks so far, or the present average if there was no
    /// validation yet.
    ///
    /// # Errors
    /// Never for a training that has not diverged.
    pub fn best_policy(&self) -> Result<Policy, InvalidInput> {
        let (parameters, updates) = match &self.best {
            Some(best) => (&best.parameters, best.updates),
            None => (&self.average, self.units * UPDATES_PER_UNIT),
        };
        let steps_at = |updates: u64| {
            let point = self.curve.iter().find(|progress| progress.updates == updates);
            point.map_or(0, |progress| progress.trajectory_steps)
        };
        let curve: Vec<_> = self
            .curve
            .iter()
            .filter_map(|progress| Some((progress, progress.validation?)))
            .map(|(progress, v)| {
                json!({
                    "updates": progress.updates,
                    "environment_steps": progress.trajectory_steps,
                    "success": v.score(),
                    "easy": v.easy.success(),
                    "hard": v.hard.success(),
                })
            })
            .collect();
        let card = PolicyCard {
            dof: self.ingredients.sight.dof(),
            format: String::new(),
            architecture: String::new(),
            sizes: Vec::new(),
            waypoints: Profile::DEFAULT.waypoints,
            observation: self.config.observation.clone(),
            profile: Profile::DEFAULT.name.into(),
            action: self.ingredients.rule,
            training: json!({
                "config": self.config,
                "updates": updates,
                "environment_steps": steps_at(updates),
                "trajectory_steps": self.trajectory_steps,
                "validation_curve": curve,
            }),
            licence: LICENCE.into(),
        };
        Policy::of_waypoints(card, WaypointNet::new(&self.shape, parameters.clone())?)
    }
}

/// Where a unit is: the index of its stage, its number in it from 0, and the stage's units.
#[derive(Debug, Clone, Copy)]
struct Place {
    stage: usize,
    unit: u64,
    units: u64,
}

impl Place {
    /// Numbers of the unit's updates within the stage, from 0.
    fn updates(self) -> std::ops::Range<u64> {
        self.unit * UPDATES_PER_UNIT..(self.unit + 1) * UPDATES_PER_UNIT
    }

    /// Share of the stage's learning rate at an update.
    fn rate(self, update: u64) -> f64 {
        warm_up_and_cosine(update as f64, (self.units * UPDATES_PER_UNIT) as f64)
    }
}

/// What a unit added up to.
#[derive(Debug, Default)]
struct Made {
    sums: Sums,
    /// Sum of the gradients' norms.
    norms: f64,
    /// Learning rate of the last update.
    learning_rate: f64,
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
