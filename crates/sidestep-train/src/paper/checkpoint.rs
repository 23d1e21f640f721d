//! A training's complete state as bytes, from which it goes on to the same bits.
//!
//! A safetensors file ([`sidestep::policy::tensors`]) with the parameters, the optimizer's moments,
//! each environment's waypoints, observation and memory, and the best policy so far; and a document
//! with the configuration, the counters, each environment's place in its stream, and the curve.
//! What the configuration determines (tasks, samples, shuffles) is made again.

use serde::{Deserialize, Serialize};
use sidestep::InvalidInput;
use sidestep::policy::observation::OwnPart;
use sidestep::policy::tensors::{self, Reader, Tensor};
use sidestep::policy::{network_tensors, parameter_tensors, read_network, read_parameters};

use super::curve::{Progress, Stage};
use super::trainer::{Best, Trainer};
use crate::config::check_same;
use crate::environments::{Problem, Saved};
use crate::paper::config::TrainConfig;
use crate::paper::stages::dagger::States;
use crate::parameters::Optimizer;
use crate::validation::Validation;

/// The version of the checkpoints that this program writes and reads.
pub const FORMAT: &str = "sidestep.checkpoint/2";

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    format: String,
    config: TrainConfig,
    epochs: u64,
    #[serde(default)]
    rounds: u64,
    /// States in DAgger's aggregate.
    #[serde(default)]
    states: usize,
    updates: u64,
    optimizer_steps: u64,
    environments: Vec<Place>,
    best: Option<BestCard>,
    curve: Vec<Progress>,
}

/// An environment's numbers that are no tensor.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Place {
    task: usize,
    age: u32,
    /// In words; 2^64 of them last 10^5 years.
    stream_position: u64,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct BestCard {
    validation: Validation,
    environment_steps: u64,
}

impl Trainer {
    /// The complete state.
    ///
    /// # Errors
    /// Never: everything in it is finite.
    pub fn checkpoint(&self) -> Result<Vec<u8>, InvalidInput> {
        let saved: Vec<Saved> = self.environments.all().iter().map(|env| env.save()).collect();
        let place = |saved: &Saved| Place {
            task: saved.task,
            age: saved.age,
            stream_position: saved.stream_position as u64,
        };
        let document = Document {
            format: FORMAT.into(),
            config: self.setup.config.clone(),
            epochs: self.epochs,
            rounds: self.rounds,
            states: self.states.len(),
            updates: self.updates,
            optimizer_steps: self.optimizer.steps(),
            environments: saved.iter().map(place).collect(),
            best: self.best.as_ref().map(|best| BestCard {
                validation: best.validation,
                environment_steps: best.environment_steps,
            }),
            curve: self.curve.clone(),
        };
        let mut tensors = parameter_tensors(&self.agent.policy, "policy.");
        tensors.extend(network_tensors(&self.agent.value, "value."));
        if let Some(best) = &self.best {
            tensors.extend(parameter_tensors(&best.network, "best."));
        }
        tensors.push(vector("log_std", &self.agent.log_std));
        let [first, second] = self.optimizer.moments();
        tensors.push(vector("optimizer.0", first));
        tensors.push(vector("optimizer.1", second));
        // Below 2^24, so f32 holds each number of a task.
        let state_tasks: Vec<f32> = self.states.tasks.iter().map(|&task| task as f32).collect();
        if !self.states.is_empty() {
            tensors.push(vector("states.tasks", &state_tasks));
            tensors.push(vector("states.waypoints", &self.states.waypoints));
            tensors.push(vector("states.memories", &self.states.memories));
            tensors.push(vector("states.answers", &self.states.answers));
        }
        for (index, saved) in saved.iter().enumerate() {
            tensors.push(vector(&format!("environments.{index}.waypoints"), &saved.x));
            tensors.push(vector(&format!("environments.{index}.observation"), &saved.observation));
            tensors.push(vector(&format!("environments.{index}.memory"), &saved.memory));
        }
        tensors::write(&document, &tensors)
    }

    /// Goes on from a checkpoint of this configuration, which may ask for more environment steps
    /// than before.
    ///
    /// # Errors
    /// If the bytes are no checkpoint of this version, damaged, contradict themselves, or belong to
    /// another configuration.
    pub fn resume(config: TrainConfig, bytes: &[u8]) -> Result<Self, InvalidInput> {
        Self::resume_seeing(&[], config, bytes)
    }

    /// The same for a training of [`Trainer::seeing`].
    ///
    /// # Errors
    /// As [`Trainer::resume`] and [`Trainer::seeing`].
    pub fn resume_seeing(
        own: &[OwnPart],
        config: TrainConfig,
        bytes: &[u8],
    ) -> Result<Self, InvalidInput> {
        let mut reader = Reader::new(bytes, "checkpoint", FORMAT)?;
        reader.require_checksum()?;
        let document: Document = reader.document()?;
        let mut stored = document.config;
        stored.environment_steps = stored.environment_steps.max(config.environment_steps);
        check_same(&stored, &config)?;
        let mut trainer = Self::seeing(own, config)?;
        let config = &trainer.setup.config;
        let (epochs, rounds) = (config.cloning.epochs as u64, config.dagger.rounds as u64);
        let (updates, capacity) = (config.updates(), config.dagger.capacity);
        let (cloned, imitated) = (document.epochs >= epochs, document.rounds >= rounds);
        at_most("epochs", document.epochs, epochs)?;
        at_most("rounds", document.rounds, if cloned { rounds } else { 0 })?;
        at_most("updates", document.updates, if cloned && imitated { updates } else { 0 })?;
        let aggregating = document.rounds > 0 && !imitated;
        at_most("states", document.states as u64, if aggregating { capacity as u64 } else { 0 })?;
        let lanes = trainer.environments.len();
        if document.environments.len() != lanes {
            let found = document.environments.len();
            return Err(InvalidInput::new("checkpoint.environments", found, lanes.to_string()));
        }
        (trainer.epochs, trainer.updates) = (document.epochs, document.updates);
        trainer.rounds = document.rounds;
        trainer.states =
            read_states(&mut reader, document.states, trainer.environments.problems())?;
        let policy_sizes = trainer.agent.policy.sizes().to_vec();
        let value_sizes = trainer.agent.value.sizes().to_vec();
        let (parts, waypoints) = (trainer.setup.parts.clone(), trainer.setup.profile.waypoints);
        let mut read_policy = |prefix: &str| {
            read_parameters(&mut reader, &parts, (waypoints, 2), &policy_sizes, prefix)
        };
        trainer.agent.policy = read_policy("policy.")?;
        let best_network = document.best.as_ref().map(|_| read_policy("best.")).transpose()?;
        trainer.agent.value = read_network(&mut reader, &value_sizes, "value.")?;
        trainer.agent.log_std = reader.tensor("log_std", &[trainer.agent.actions()])?;
        let count = trainer.agent.parameter_count();
        let moments =
            [reader.tensor("optimizer.0", &[count])?, reader.tensor("optimizer.1", &[count])?];
        let kind = trainer.stage_optimizer();
        trainer.optimizer = Optimizer::resumed(kind, document.optimizer_steps, moments);
        if trainer.stage() == Some(Stage::Ppo) && document.updates == 0 {
            // A training that ended before PPO and is now given steps; elsewhere these moments are
            // 0 already.
            trainer.optimizer = Optimizer::new(kind, count);
        }
        let best = document.best.zip(best_network);
        if let Some((BestCard { validation, environment_steps }, network)) = best {
            trainer.best = Some(Best { network, validation, environment_steps });
        }
        let memory = trainer.environments.problems()[0].encoder.memory().len();
        let tasks = trainer.environments.problems().len();
        for (index, place) in document.environments.into_iter().enumerate() {
            let environment = &trainer.environments.all()[index];
            let mut read = |name: &str, length: usize| {
                reader.tensor(&format!("environments.{index}.{name}"), &[length])
            };
            let saved = Saved {
                task: place.task,
                age: place.age,
                stream_position: u128::from(place.stream_position),
                x: read("waypoints", environment.waypoints().len())?,
                observation: read("observation", environment.observation().len())?,
                memory: read("memory", memory)?,
            };
            if trainer.environments.restore(index, saved).is_none() {
                let field = format!("checkpoint.environments[{index}].task");
                let allowed = format!("a number below {tasks}");
                return Err(InvalidInput::new(field, place.task, allowed));
            }
        }
        trainer.curve = document.curve;
        reader.finish()?;
        Ok(trainer)
    }
}

fn read_states(
    reader: &mut Reader,
    count: usize,
    problems: &[Problem],
) -> Result<States, InvalidInput> {
    let Some(first) = problems.first().filter(|_| count > 0) else { return Ok(States::default()) };
    let tasks = reader.tensor("states.tasks", &[count])?;
    let known = |task: &f32| *task >= 0.0 && *task < problems.len() as f32 && task.fract() == 0.0;
    if let Some(unknown) = tasks.iter().find(|task| !known(task)) {
        let allowed = format!("whole numbers below {}", problems.len());
        return Err(InvalidInput::new("checkpoint.tensors.states.tasks", unknown, allowed));
    }
    let (dim, memory) = (first.objective.dim(), first.encoder.memory().len());
    Ok(States {
        tasks: tasks.into_iter().map(|task| task as u32).collect(),
        waypoints: reader.tensor("states.waypoints", &[count * dim])?,
        memories: reader.tensor("states.memories", &[count * memory])?,
        answers: reader.tensor("states.answers", &[count * dim])?,
    })
}

fn vector<'a>(name: &str, values: &'a [f32]) -> Tensor<'a> {
    (name.to_string(), vec![values.len()], values)
}

fn at_most(field: &str, value: u64, most: u64) -> Result<(), InvalidInput> {
    if value <= most {
        return Ok(());
    }
    let field = format!("checkpoint.{field}");
    Err(InvalidInput::new(field, value, format!("a number from 0 to {most}")))
}
