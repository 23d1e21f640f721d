//! An experiment as data: which policies to train, on what to measure them, and the paper's
//! numbers.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use sidestep::InvalidInput;
use sidestep_train::Recipe;
use sidestep_train::config::toml_file;

/// An experiment file.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Experiment {
    /// Short name, such as `table-1`.
    pub name: String,
    /// What the table shows, for its caption.
    pub title: String,
    /// Seeds that each policy is trained with, if it names none of its own.
    #[serde(default)]
    pub training_seeds: Vec<u64>,
    /// What the columns of the success table are.
    #[serde(default)]
    pub columns: Columns,
    /// The measurements made of every policy and baseline.
    pub measure: Vec<Measure>,
    /// Training configuration that all policies share; unnamed values are the defaults.
    #[serde(default)]
    pub train: toml::Table,
    /// The policies.
    #[serde(default)]
    pub policies: Vec<PolicyEntry>,
    /// Planners that need no training.
    #[serde(default)]
    pub baselines: Vec<BaselineEntry>,
}

/// What the columns of an experiment's success table are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Columns {
    /// One table per measurement, with the policies' columns.
    #[default]
    Policies,
    /// One table in all, with the measurements as columns.
    Measures,
}

/// Tasks and starts to measure on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Measure {
    /// Name of the measurement; the key of the paper's numbers.
    pub name: String,
    /// Suite.
    pub suite: String,
    /// Tasks per seed.
    pub count: usize,
    /// Task seeds.
    pub seeds: Vec<u64>,
    /// Optimizer steps per start.
    #[serde(default = "default_steps")]
    pub steps: usize,
    /// Start trajectories.
    #[serde(default = "default_starts")]
    pub starts: usize,
    /// How starts after the first are drawn.
    #[serde(default = "default_strategy")]
    pub start_strategy: String,
    /// Profile of planners that have none of their own.
    #[serde(default = "default_profile")]
    pub profile: String,
    /// Whether a start is broken off once it can no longer change the first feasible and the first
    /// certified iterate of its task. Much faster with several starts, and without end-state
    /// success.
    #[serde(default)]
    pub until_solved: bool,
}

impl Measure {
    /// Whether the two differ in nothing but their name and number of starts, so that one race
    /// serves both.
    pub fn races_with(&self, other: &Self) -> bool {
        let named = Self { name: other.name.clone(), starts: other.starts, ..self.clone() };
        self.until_solved && named == *other
    }
}

fn default_steps() -> usize {
    200
}

fn default_starts() -> usize {
    1
}

fn default_strategy() -> String {
    "via-point".into()
}

fn default_profile() -> String {
    "paper".into()
}

/// A policy to train.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PolicyEntry {
    /// Row of the table.
    pub row: String,
    /// Column of the table.
    pub column: String,
    /// Seeds that this policy is trained with, for trainings too long for all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub training_seeds: Option<Vec<u64>>,
    /// Training configuration over the shared one.
    #[serde(default)]
    pub train: toml::Table,
    /// The paper's percentage for each measurement that it has one for.
    #[serde(default)]
    pub paper: BTreeMap<String, f64>,
}

/// A planner that needs no training.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BaselineEntry {
    /// Planner name as on the command line.
    pub planner: String,
    /// The paper's percentage for each measurement that it has one for.
    #[serde(default)]
    pub paper: BTreeMap<String, f64>,
}

impl Experiment {
    /// The seeds that a policy is trained with.
    pub fn seeds<'a>(&'a self, entry: &'a PolicyEntry) -> &'a [u64] {
        entry.training_seeds.as_deref().unwrap_or(&self.training_seeds)
    }

    /// Every training: the index of its policy, and its seed.
    pub fn trainings(&self) -> Vec<(usize, u64)> {
        let policies = self.policies.iter().enumerate();
        let seeds = |(index, entry)| self.seeds(entry).iter().map(move |&seed| (index, seed));
        policies.flat_map(seeds).collect()
    }

    /// The whole training configuration of a policy for a seed.
    pub fn recipe(&self, entry: &PolicyEntry, seed: u64) -> Result<Recipe, InvalidInput> {
        let mut table = self.train.clone();
        toml_file::merge(&mut table, &entry.train);
        Ok(Recipe::from_table(&table)?.with_seed(seed))
    }
}

impl PolicyEntry {
    /// The name of the files of the training with this seed, without their extension.
    pub fn file_name(&self, seed: u64) -> String {
        let name = format!("{} {} seed {seed}", self.row, self.column);
        name.replace([' ', '/', '\\', ':'], "-")
    }
}
