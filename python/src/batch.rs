//! Training environments side by side, stepped on all cores.

use numpy::ndarray::{Array1, Array2, Array3};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArray3, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;
use rayon::prelude::*;
use sidestep::Profile;
use sidestep::policy::ActionRule;
use sidestep::policy::observation::ObservationPart;
use sidestep_train::environments::{Environment, Problem, Rules};

use crate::invalid;
use crate::tasks::Task;
use crate::threads::detach;

/// Trajectories that an agent improves, one task each: environment e walks tasks e, e + count, .. in turn.
///
/// An action is flat, float32 `[count, waypoints * dof]`, the update of every waypoint before it is scaled and clipped
/// as the paper does. The reward of a step is -U, and `bonus - mu U` once the trajectory is feasible, which terminates
/// the episode; `limit` steps truncate it.
#[pyclass(module = "sidestep")]
pub struct Batch {
    problems: Vec<Problem>,
    environments: Vec<Environment>,
    rules: Rules,
    waypoints: usize,
    dof: usize,
    /// Whether an ended episode is reset in the step after, which ignores its action, or at once.
    next_step: bool,
    /// Whose episode ended in the step before, where `next_step`.
    waiting: Vec<bool>,
    /// Whether ended episodes are reset by whoever steps.
    disabled: bool,
}

/// What a step of one environment leaves.
struct Left {
    reward: f32,
    cost: f32,
    terminated: bool,
    truncated: bool,
    last: Option<Vec<f32>>,
}

type Step<'py> = (
    Bound<'py, PyArray2<f32>>,
    Bound<'py, PyArray1<f32>>,
    Bound<'py, PyArray1<bool>>,
    Bound<'py, PyArray1<bool>>,
    Bound<'py, PyArray1<f32>>,
    Bound<'py, PyArray1<i64>>,
    Bound<'py, PyArray2<f32>>,
);

#[pymethods]
impl Batch {
    /// `count` environments over these tasks, at least one, of robots with equally many coordinates; `reset` says who
    /// begins anew where an episode ends: `next-step`, `same-step` or `never`.
    #[new]
    #[pyo3(signature = (tasks, count, *, seed=0, waypoints=10, profile="paper", parts=None, mu=0.1, bonus=0.0, limit=None, reset="same-step"))]
    #[allow(clippy::too_many_arguments, reason = "keywords in Python")]
    fn new(
        py: Python<'_>,
        tasks: Vec<PyRef<'_, Task>>,
        count: usize,
        seed: u64,
        waypoints: usize,
        profile: &str,
        parts: Option<Vec<String>>,
        mu: f32,
        bonus: f32,
        limit: Option<u32>,
        reset: &str,
    ) -> PyResult<Self> {
        if !(1..=1_000_000).contains(&count) {
            let found = format!("count: {count} is not allowed");
            return Err(invalid(format!("{found}; expected a number from 1 to 1000000")));
        }
        if !(mu.is_finite() && bonus.is_finite()) {
            return Err(invalid("mu, bonus: expected finite numbers"));
        }
        let (next_step, disabled) = match reset {
            "next-step" => (true, false),
            "same-step" => (false, false),
            "never" => (false, true),
            other => {
                let found = format!("reset: {other:?} is not allowed");
                return Err(invalid(format!("{found}; expected next-step, same-step or never")));
            }
        };
        let profile: Profile = profile.parse().map_err(invalid)?;
        let parts = parts.unwrap_or_else(|| vec!["gradient".into()]);
        let parts: Result<Vec<ObservationPart>, _> =
            parts.iter().map(|name| name.parse()).collect();
        let parts = parts.map_err(invalid)?;
        let tasks: Vec<sidestep::Task> = tasks.iter().map(|task| task.0.clone()).collect();
        let Some(dof) = tasks.first().map(|task| task.setting.dof()) else {
            return Err(invalid("tasks: none is not allowed; expected at least one"));
        };
        if tasks.iter().any(|task| task.setting.dof() != dof) {
            return Err(invalid(format!(
                "tasks: all must have {dof} coordinates, as the first has"
            )));
        }
        detach(py, || {
            let ready = |task| Problem::new(task, &profile, waypoints, &parts);
            let problems: Result<Vec<Problem>, _> = tasks.par_iter().map(ready).collect();
            let problems = problems.map_err(invalid)?;
            let environments: Vec<Environment> =
                (0..count).map(|index| Environment::new(index, &problems, seed)).collect();
            let rules = Rules {
                action: ActionRule::PAPER,
                mu,
                feasible_bonus: bonus,
                episode_limit: limit,
            };
            let waiting = vec![false; count];
            Ok(Self { problems, environments, rules, waypoints, dof, next_step, waiting, disabled })
        })
    }

    /// How many environments.
    #[getter]
    fn count(&self) -> usize {
        self.environments.len()
    }

    /// Numbers in one observation.
    #[getter]
    fn observation_size(&self) -> usize {
        self.environments[0].observation().len()
    }

    /// Numbers in one action.
    #[getter]
    fn action_size(&self) -> usize {
        self.waypoints * self.dof
    }

    /// The waypoints of all, float32 `[count, waypoints, dof]`, in normalised units.
    fn waypoints<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f32>>> {
        let flat: Vec<f32> =
            self.environments.iter().flat_map(|e| e.waypoints().iter().copied()).collect();
        let shape = (self.count(), self.waypoints, self.dof);
        Ok(Array3::from_shape_vec(shape, flat).map_err(invalid)?.into_pyarray(py))
    }

    /// Begins the episodes of the marked environments anew, bool `[count]`, or of all with their first tasks; the
    /// observations, float32 `[count, observation_size]`.
    #[pyo3(signature = (mask=None))]
    fn reset<'py>(
        &mut self,
        py: Python<'py>,
        mask: Option<Vec<bool>>,
    ) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let count = self.environments.len();
        if let Some(found) = mask.as_ref().map(Vec::len).filter(|found| *found != count) {
            return Err(invalid(format!("mask: {found} values are not allowed; expected {count}")));
        }
        detach(py, || match &mask {
            Some(mask) => {
                for index in (0..count).filter(|index| mask[*index]) {
                    self.environments[index].reset(&self.problems, count);
                    self.waiting[index] = false;
                }
            }
            None => {
                self.waiting.fill(false);
                for (index, environment) in self.environments.iter_mut().enumerate() {
                    *environment = Environment::new(index, &self.problems, 0);
                }
            }
        });
        let size = self.observation_size();
        let flat: Vec<f32> =
            self.environments.iter().flat_map(|e| e.observation().iter().copied()).collect();
        Ok(Array2::from_shape_vec((count, size), flat).map_err(invalid)?.into_pyarray(py))
    }

    /// Applies actions: new arrays of observations, rewards, terminated, truncated and U; where episodes ended and were
    /// reset at once, their indices and last observations.
    fn step<'py>(
        &mut self,
        py: Python<'py>,
        actions: PyReadonlyArray2<'py, f32>,
    ) -> PyResult<Step<'py>> {
        let (count, width) = (self.environments.len(), self.action_size());
        if actions.shape() != [count, width] {
            let found = format!("actions: an array of shape {:?} is not allowed", actions.shape());
            return Err(invalid(format!("{found}; expected [{count}, {width}]")));
        }
        // A slice of an array in Fortran's order would be in that order.
        let actions = match actions.as_slice() {
            Ok(slice) if actions.is_c_contiguous() => slice,
            _ => return Err(invalid("actions: expected a C-contiguous array")),
        };
        if let Some(at) = actions.iter().position(|value| value.is_nan()) {
            let place = format!("actions[{}, {}]", at / width, at % width);
            return Err(invalid(format!("{place}: NaN is not allowed; expected a number")));
        }
        let size = self.observation_size();
        let (seen, left) = detach(py, || self.step_all(actions, size));
        let which: Vec<i64> =
            (0..count).filter(|i| left[*i].last.is_some()).map(|i| i as i64).collect();
        let last: Vec<f32> =
            left.iter().filter_map(|left| left.last.as_ref()).flatten().copied().collect();
        let of = |value: fn(&Left) -> f32| left.iter().map(value).collect::<Vec<f32>>();
        let flags = |value: fn(&Left) -> bool| left.iter().map(value).collect::<Vec<bool>>();
        let ended = which.len();
        Ok((
            Array2::from_shape_vec((count, size), seen).map_err(invalid)?.into_pyarray(py),
            Array1::from_vec(of(|left| left.reward)).into_pyarray(py),
            Array1::from_vec(flags(|left| left.terminated)).into_pyarray(py),
            Array1::from_vec(flags(|left| left.truncated)).into_pyarray(py),
            Array1::from_vec(of(|left| left.cost)).into_pyarray(py),
            Array1::from_vec(which).into_pyarray(py),
            Array2::from_shape_vec((ended, size), last).map_err(invalid)?.into_pyarray(py),
        ))
    }
}

impl Batch {
    fn step_all(&mut self, actions: &[f32], size: usize) -> (Vec<f32>, Vec<Left>) {
        let count = self.environments.len();
        let width = self.waypoints * self.dof;
        let mut seen = vec![0.0; count * size];
        let (problems, rules) = (&self.problems, &self.rules);
        let (next_step, disabled) = (self.next_step, self.disabled);
        let rows = self
            .environments
            .par_iter_mut()
            .with_min_len(16)
            .zip(actions.par_chunks(width))
            .zip(seen.par_chunks_mut(size))
            .zip(&mut self.waiting);
        let left = rows
            .map(|(((environment, action), seen), waiting)| {
                if std::mem::take(waiting) {
                    environment.reset(problems, count);
                    seen.copy_from_slice(environment.observation());
                    let (reward, cost) = (0.0, 0.0);
                    return Left { reward, cost, terminated: false, truncated: false, last: None };
                }
                let outcome = environment.step(action, rules);
                *waiting = next_step && outcome.done();
                let mut last = None;
                if outcome.done() && !next_step && !disabled {
                    last = Some(environment.observation().to_vec());
                    environment.reset(problems, count);
                }
                seen.copy_from_slice(environment.observation());
                Left {
                    reward: outcome.reward,
                    cost: outcome.cost.total,
                    terminated: outcome.solved,
                    truncated: outcome.truncated,
                    last,
                }
            })
            .collect();
        (seen, left)
    }
}
