//! Plans: one task, many tasks, what the certificate says of a path, and the exact answer.

use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use numpy::ndarray::{Array2, Array3};
use numpy::{IntoPyArray, PyArray2, PyArray3, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;
use rayon::prelude::*;
use sidestep::objective::Objective;
use sidestep::plan::run::Iteration;
use sidestep::plan::starts::StartStrategy;
use sidestep::plan::{Options, PLANNERS, Planner, Stop, Watch, by_setting, plan_in};
use sidestep::plane::shortest_path::{Route, ShortestPath};
use sidestep::{InvalidInput, Policy, Profile, Query, Scene, Trajectory};

use crate::interrupt::Interrupt;
use crate::invalid;
use crate::own::{planner_of, with_cost};
use crate::tasks::Task;
use crate::threads::{detach, run};

/// The answer to a task.
#[pyclass(frozen, module = "sidestep")]
pub struct Plan {
    plan: sidestep::Plan,
    query: Query,
    time: Duration,
    trace: Vec<(usize, Vec<f64>)>,
    task: Task,
}

#[pymethods]
impl Plan {
    /// `solved`, `unsolved`, `unsolvable` (proved) or `invalid` (an end is not free).
    #[getter]
    fn status(&self) -> &'static str {
        self.plan.status.name()
    }

    /// Whether there is a plan; it is proved free of collision.
    #[getter]
    fn solved(&self) -> bool {
        self.plan.is_solved()
    }

    /// Why it is not solved; empty where it is.
    #[getter]
    fn reason(&self) -> String {
        self.plan.status.reason()
    }

    /// From start to goal, float64 `[points, dof]` in task units; where not solved, an optimizer's last attempt, or None.
    #[getter]
    fn waypoints<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        let Some(path) = self.plan.trajectory() else { return Ok(None) };
        let shape = (path.len(), path.dof());
        let array = Array2::from_shape_vec(shape, path.values().to_vec()).map_err(invalid)?;
        Ok(Some(array.into_pyarray(py)))
    }

    /// Length of a solved plan in task units (rad of a robot with joints), else None.
    #[getter]
    fn length(&self) -> Option<f64> {
        self.plan.certified().map(Trajectory::length)
    }

    /// Least distance of the body to everything along a solved plan, in task units; None if nothing is around.
    #[getter]
    fn clearance(&self) -> Option<f64> {
        let clearance = self.query.scene().clearance(self.plan.certified()?);
        clearance.is_finite().then_some(clearance)
    }

    /// Optimizer steps to the plan.
    #[getter]
    fn iterations(&self) -> usize {
        self.plan.steps
    }

    /// What made the plan, in words.
    #[getter]
    fn origin(&self) -> String {
        self.plan.origin.to_string()
    }

    /// Microseconds from the task to the answer.
    #[getter]
    fn time_us(&self) -> f64 {
        self.time.as_secs_f64() * 1e6
    }

    /// The task.
    #[getter]
    fn task(&self) -> Task {
        self.task.clone()
    }

    /// With `trace=True` every iterate of the first start, float64 `[iterations, points, dof]`; else None.
    #[getter]
    fn trace<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray3<f64>>>> {
        let Some((start, first)) = self.trace.first() else { return Ok(None) };
        let dof = self.query.scene().dof();
        let rows = self.trace.iter().filter(|(s, row)| s == start && row.len() == first.len());
        let rows: Vec<&Vec<f64>> = rows.map(|(_, row)| row).collect();
        let shape = (rows.len(), first.len() / dof, dof);
        let flat: Vec<f64> = rows.into_iter().flatten().copied().collect();
        Ok(Some(Array3::from_shape_vec(shape, flat).map_err(invalid)?.into_pyarray(py)))
    }

    fn __repr__(&self) -> String {
        match self.length() {
            Some(length) => format!("Plan(solved, length {length:.3}, {})", self.plan.origin),
            None => format!("Plan({}: {})", self.status(), self.reason()),
        }
    }
}

/// What a planner may use.
struct Settings {
    planner: Planner,
    options: Options,
    margin: f64,
    deadline: Option<Duration>,
}

/// Reads the keywords that `plan` and `plan_batch` share.
#[allow(clippy::too_many_arguments, reason = "keywords in Python")]
fn settings(
    planner: Planner,
    seed: u64,
    steps: usize,
    starts: usize,
    start_strategy: &str,
    waypoints: Option<usize>,
    profile: Option<&str>,
    margin: f64,
    budget_ms: Option<f64>,
    best: bool,
) -> PyResult<Settings> {
    let policy = planner.policy();
    let profile = profile.or(policy.and_then(Policy::fixed_profile)).unwrap_or("default");
    let deadline = match budget_ms {
        Some(ms) if !(ms > 0.0 && ms <= 1e9) => {
            return Err(invalid(format!("budget_ms: {ms} is not above 0 and at most 1e9")));
        }
        ms => ms.map(|ms| Duration::from_secs_f64(ms / 1e3)),
    };
    let options = Options {
        profile: profile.parse::<Profile>().map_err(invalid)?,
        waypoints: waypoints.or(policy.and_then(Policy::fixed_waypoints)),
        starts,
        strategy: start_strategy.parse::<StartStrategy>().map_err(invalid)?,
        steps,
        stop: if best || deadline.is_some() { Stop::Best } else { Stop::First },
        seed,
        prove: true,
        ..Options::default()
    };
    options.check().map_err(invalid)?;
    Ok(Settings { planner, options, margin, deadline })
}

/// Plans one task: the first certified plan, or with `best` or `budget_ms` the best one found.
///
/// `planner` is a name with settings as on the command line: `auto`, `sidestep-1`, `gd:step=0.5`, `adam`, `chomp`,
/// `lbfgs`, `stomp`, `rrt-connect`, `shortest-path`, `learned:policy.safetensors` (`sidestep.planners()` lists them); `auto` where None.
/// `margin` is kept from everything, as if the robot were so much larger. Ctrl-C ends it.
///
/// It may be a `Policy` too, or an optimizer of your own: `planner(waypoints, dof)` is called once for each start and answers
/// what steps; that is called as `step(x, cost, gradient)` in every iteration and answers the next `x`, arrays
/// `[waypoints, dof]` in normalised units. `cost` adds one of your own to U: `cost(path)` answers `(value, gradient)` for
/// a path `[waypoints + 2, dof]` in normalised units, the gradient being that of the inner points. Both are as slow as Python.
#[pyfunction]
#[pyo3(signature = (task, planner=None, *, seed=0, steps=200, starts=1, start_strategy="via-point", waypoints=None, profile=None, margin=0.0, budget_ms=None, best=false, trace=false, cost=None))]
#[allow(clippy::too_many_arguments, reason = "keywords in Python")]
pub fn plan(
    py: Python<'_>,
    task: &Task,
    planner: Option<Bound<'_, PyAny>>,
    seed: u64,
    steps: usize,
    starts: usize,
    start_strategy: &str,
    waypoints: Option<usize>,
    profile: Option<&str>,
    margin: f64,
    budget_ms: Option<f64>,
    best: bool,
    trace: bool,
    cost: Option<Py<PyAny>>,
) -> PyResult<Plan> {
    let interrupt = Arc::new(Interrupt::new(None));
    let planner = planner_of(planner.as_ref(), &interrupt)?;
    let settings = settings(
        planner,
        seed,
        steps,
        starts,
        start_strategy,
        waypoints,
        profile,
        margin,
        budget_ms,
        best,
    )?;
    let (own, cost) = (Interrupt::new(settings.deadline), cost.map(Arc::new));
    let task = task.clone();
    let plan = detach(py, || {
        let begin = Instant::now();
        let asked = task.0.with_margin(settings.margin)?;
        let query = Query::of(&asked, &settings.options.profile);
        let query = with_cost(query, cost.as_ref(), &interrupt);
        let both = Pair(&interrupt, &own);
        one(&query, &settings, &settings.options, &both, trace, (begin, task))
    });
    interrupt.check()?;
    plan.map_err(invalid)
}

/// One task in its scene.
fn one(
    query: &Query,
    settings: &Settings,
    options: &Options,
    interrupt: &Pair<'_>,
    trace: bool,
    (begin, task): (Instant, Task),
) -> Result<Plan, InvalidInput> {
    let kept = Mutex::new(Vec::new());
    let see = |iteration: &Iteration<'_>| {
        let waypoints = iteration.waypoints.len() / query.scene().dof();
        if trace
            && let Ok(objective) = Objective::new(query, waypoints)
            && let Ok(mut kept) = kept.lock()
        {
            let values = objective.trajectory(iteration.waypoints).values().to_vec();
            kept.push(((iteration.start, iteration.index), values));
        }
    };
    let watch = Watch { see: &see, go_on: &|| interrupt.go_on() };
    let plan = plan_in(query, &settings.planner, options, watch)?;
    let time = begin.elapsed();
    let mut kept = kept.into_inner().unwrap_or_default();
    kept.sort_by_key(|(place, _)| *place);
    let trace = kept.into_iter().map(|((start, _), row)| (start, row)).collect();
    Ok(Plan { plan, query: query.clone(), time, trace, task })
}

/// Plans many tasks on all cores: a list of plans, in order. Tasks that stand side by side in one world share what is
/// prepared for it. The answers are those of `plan` with the same keywords, but that task i draws from random stream i.
#[pyfunction]
#[pyo3(signature = (tasks, planner=None, *, seed=0, steps=200, starts=1, start_strategy="via-point", waypoints=None, profile=None, margin=0.0, budget_ms=None, best=false, cost=None))]
#[allow(clippy::too_many_arguments, reason = "keywords in Python")]
pub fn plan_batch(
    py: Python<'_>,
    tasks: Vec<PyRef<'_, Task>>,
    planner: Option<Bound<'_, PyAny>>,
    seed: u64,
    steps: usize,
    starts: usize,
    start_strategy: &str,
    waypoints: Option<usize>,
    profile: Option<&str>,
    margin: f64,
    budget_ms: Option<f64>,
    best: bool,
    cost: Option<Py<PyAny>>,
) -> PyResult<Vec<Plan>> {
    // The budget is each task's own.
    let interrupt = Arc::new(Interrupt::new(None));
    let planner = planner_of(planner.as_ref(), &interrupt)?;
    let settings = settings(
        planner,
        seed,
        steps,
        starts,
        start_strategy,
        waypoints,
        profile,
        margin,
        budget_ms,
        best,
    )?;
    let tasks: Vec<sidestep::Task> = tasks.iter().map(|task| task.0.clone()).collect();
    let cost = cost.map(Arc::new);
    let plans = py.detach(|| {
        interrupt.beside(|| {
            run(|| {
                let asked: Result<Vec<sidestep::Task>, InvalidInput> =
                    tasks.iter().map(|task| task.with_margin(settings.margin)).collect();
                let asked = asked?;
                let groups: Result<Vec<Vec<Plan>>, InvalidInput> = by_setting(&asked)
                    .into_par_iter()
                    .map(|(first, group)| {
                        let scene = Arc::new(Scene::of(&group[0], &settings.options.profile));
                        let plan_one = |(offset, asked): (usize, &sidestep::Task)| {
                            let index = first + offset;
                            let begin = Instant::now();
                            let query = Query::new(&scene, asked)?;
                            let query = with_cost(query, cost.as_ref(), &interrupt);
                            let options =
                                Options { index: index as u64, ..settings.options.clone() };
                            let own = Interrupt::new(settings.deadline);
                            let both = Pair(&interrupt, &own);
                            let task = Task(tasks[index].clone());
                            one(&query, &settings, &options, &both, false, (begin, task))
                        };
                        group.par_iter().enumerate().map(plan_one).collect()
                    })
                    .collect();
                groups
            })
        })
    });
    interrupt.check()?;
    Ok(plans.map_err(invalid)?.into_iter().flatten().collect())
}

/// Ctrl-C and errors for all, a budget for each.
struct Pair<'a>(&'a Interrupt, &'a Interrupt);

impl Pair<'_> {
    fn go_on(&self) -> bool {
        self.0.go_on() && self.1.is_time_left()
    }
}

/// Whether a path, float64 `[points, dof]` in task units, is certified free of collision from the task's start to its
/// goal: None if so, else why not.
#[pyfunction]
pub fn certify(task: &Task, path: PyReadonlyArray2<'_, f64>) -> PyResult<Option<String>> {
    let dof = task.0.setting.dof();
    let [points, columns] = [path.shape()[0], path.shape()[1]];
    if columns != dof || points == 0 {
        let found = format!("path: an array of shape ({points}, {columns})");
        return Err(invalid(format!(
            "{found} is not allowed; expected (points, {dof}), at least one"
        )));
    }
    let trajectory = Trajectory::new(dof, path.as_array().iter().copied().collect());
    Ok(sidestep::certify(&task.0, &trajectory).err().map(|violation| violation.to_string()))
}

/// The exact shortest path of a task in the plane: `(length, waypoints)`, where waypoints is float64 `[points, 2]`;
/// None where it is proved that there is no path, and an error where it could not be decided.
#[pyfunction]
pub fn shortest_path<'py>(
    py: Python<'py>,
    task: &Task,
) -> PyResult<Option<(f64, Bound<'py, PyArray2<f64>>)>> {
    let plane = task.0.plane().map_err(invalid)?;
    let route =
        detach(py, || ShortestPath::new(plane.world, plane.robot).find(plane.start, plane.goal));
    match route {
        Route::Found { length, trajectory, .. } => {
            let shape = (trajectory.len(), 2);
            let array =
                Array2::from_shape_vec(shape, trajectory.values().to_vec()).map_err(invalid)?;
            Ok(Some((length, array.into_pyarray(py))))
        }
        Route::Unsolvable(_) => Ok(None),
        Route::Undecided(doubt) => Err(invalid(format!("undecided: {doubt}"))),
    }
}

/// The planners by name.
#[pyfunction]
pub fn planners() -> Vec<&'static str> {
    PLANNERS.iter().map(|planner| planner.name).collect()
}
