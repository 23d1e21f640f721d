//! U, its gradient and the checks, for a trajectory of each of many tasks at once.

use std::sync::Arc;

use numpy::ndarray::{Array1, Array3};
use numpy::{IntoPyArray, PyArray1, PyArray3, PyReadonlyArray3, PyUntypedArrayMethods};
use pyo3::prelude::*;
use rayon::prelude::*;
use sidestep::{Profile, Query};

use crate::interrupt::Interrupt;
use crate::invalid;
use crate::own::with_cost;
use crate::tasks::Task;
use crate::threads::detach;

/// The objective U = F_obs + lambda F_len of tasks with one kind of robot, for trajectories of as many waypoints.
///
/// Arrays of trajectories are float32 `[tasks, waypoints, dof]` in normalised units (the field's larger side is 6.4;
/// joints as they are), without the ends. `to_task` and `to_normalised` turn them into task units and back.
/// `cost` is one of your own on top, as in `plan`.
#[pyclass(module = "sidestep")]
pub struct Objective {
    all: Vec<sidestep::objective::Objective>,
    waypoints: usize,
    dof: usize,
    /// What a cost of one's own raised.
    watch: Arc<Interrupt>,
}

type Trajectories<'py> = Bound<'py, PyArray3<f32>>;

#[pymethods]
impl Objective {
    #[new]
    #[pyo3(signature = (tasks, *, waypoints=10, profile="default", cost=None))]
    fn new(
        py: Python<'_>,
        tasks: Vec<PyRef<'_, Task>>,
        waypoints: usize,
        profile: &str,
        cost: Option<Py<PyAny>>,
    ) -> PyResult<Self> {
        let profile: Profile = profile.parse().map_err(invalid)?;
        let tasks: Vec<sidestep::Task> = tasks.iter().map(|task| task.0.clone()).collect();
        let Some(dof) = tasks.first().map(|task| task.setting.dof()) else {
            return Err(invalid("tasks: none is not allowed; expected at least one"));
        };
        if let Some(other) = tasks.iter().position(|task| task.setting.dof() != dof) {
            let found = tasks[other].setting.dof();
            let message = format!("tasks[{other}].dof: {found} is not allowed; expected {dof}");
            return Err(invalid(format!("{message}, as the first has")));
        }
        let (watch, cost) = (Arc::new(Interrupt::new(None)), cost.map(Arc::new));
        let all = detach(py, || {
            let one = |task: &sidestep::Task| {
                let query = with_cost(Query::of(task, &profile), cost.as_ref(), &watch);
                sidestep::objective::Objective::new(&query, waypoints)
            };
            tasks.par_iter().map(one).collect::<Result<Vec<_>, _>>()
        });
        Ok(Self { all: all.map_err(invalid)?, waypoints, dof, watch })
    }

    /// `(tasks, waypoints, dof)`.
    #[getter]
    fn shape(&self) -> (usize, usize, usize) {
        (self.all.len(), self.waypoints, self.dof)
    }

    /// The evenly spaced straight lines.
    fn straight_lines<'py>(&self, py: Python<'py>) -> PyResult<Trajectories<'py>> {
        let mut flat = vec![0.0; self.all.len() * self.waypoints * self.dof];
        let rows = flat.chunks_mut(self.waypoints * self.dof);
        rows.zip(&self.all).for_each(|(row, objective)| objective.straight_line(row));
        self.array(py, flat)
    }

    /// U of each trajectory, float32 `[tasks]`.
    fn cost<'py>(
        &mut self,
        py: Python<'py>,
        x: PyReadonlyArray3<'py, f32>,
    ) -> PyResult<Bound<'py, PyArray1<f32>>> {
        let rows = self.rows(&x)?;
        let size = self.waypoints * self.dof;
        let all = &mut self.all;
        let costs: Vec<f32> = detach(py, || {
            all.par_iter_mut().zip(rows.par_chunks(size)).map(|(u, x)| u.cost(x).total).collect()
        });
        self.watch.check_again()?;
        Ok(Array1::from_vec(costs).into_pyarray(py))
    }

    /// U of each trajectory, float32 `[tasks]`, and its gradient, of the trajectories' shape.
    fn cost_and_gradient<'py>(
        &mut self,
        py: Python<'py>,
        x: PyReadonlyArray3<'py, f32>,
    ) -> PyResult<(Bound<'py, PyArray1<f32>>, Trajectories<'py>)> {
        let rows = self.rows(&x)?;
        let size = self.waypoints * self.dof;
        let all = &mut self.all;
        let (costs, gradient) = detach(py, || {
            let mut gradient = vec![0.0; rows.len()];
            let costs: Vec<f32> = all
                .par_iter_mut()
                .zip(rows.par_chunks(size).zip(gradient.par_chunks_mut(size)))
                .map(|(u, (x, gradient))| u.cost_and_gradient(x, gradient).total)
                .collect();
            (costs, gradient)
        });
        self.watch.check_again()?;
        Ok((Array1::from_vec(costs).into_pyarray(py), self.array(py, gradient)?))
    }

    /// Which trajectories are certified free of collision, bool `[tasks]`.
    fn certified<'py>(
        &self,
        py: Python<'py>,
        x: PyReadonlyArray3<'py, f32>,
    ) -> PyResult<Bound<'py, PyArray1<bool>>> {
        let rows = self.rows(&x)?;
        let size = self.waypoints * self.dof;
        let free: Vec<bool> = detach(py, || {
            self.all.par_iter().zip(rows.par_chunks(size)).map(|(u, x)| u.is_certified(x)).collect()
        });
        Ok(Array1::from_vec(free).into_pyarray(py))
    }

    /// The trajectories with their ends in task units, float64 `[tasks, waypoints + 2, dof]`.
    fn to_task<'py>(
        &self,
        py: Python<'py>,
        x: PyReadonlyArray3<'py, f32>,
    ) -> PyResult<Bound<'py, PyArray3<f64>>> {
        let rows = self.rows(&x)?;
        let size = self.waypoints * self.dof;
        let flat: Vec<f64> = self
            .all
            .iter()
            .zip(rows.chunks(size))
            .flat_map(|(u, x)| u.trajectory(x).values().to_vec())
            .collect();
        let shape = (self.all.len(), self.waypoints + 2, self.dof);
        Ok(Array3::from_shape_vec(shape, flat).map_err(invalid)?.into_pyarray(py))
    }

    /// Inner waypoints in task units, float64 `[tasks, waypoints, dof]`, as the objective takes them.
    fn to_normalised<'py>(
        &self,
        py: Python<'py>,
        points: PyReadonlyArray3<'py, f64>,
    ) -> PyResult<Trajectories<'py>> {
        self.check(points.shape())?;
        let values: Vec<f64> = points.as_array().iter().copied().collect();
        let mut flat = vec![0.0; values.len()];
        let size = self.waypoints * self.dof;
        let rows = flat.chunks_mut(size).zip(values.chunks(size));
        for ((out, points), objective) in rows.zip(&self.all) {
            objective.scene().to_normalised(points, out);
        }
        self.array(py, flat)
    }
}

impl Objective {
    fn check(&self, found: &[usize]) -> PyResult<()> {
        let (tasks, waypoints, dof) = self.shape();
        if found == [tasks, waypoints, dof] {
            return Ok(());
        }
        let found = format!("x: an array of shape {found:?} is not allowed");
        Err(invalid(format!("{found}; expected [{tasks}, {waypoints}, {dof}]")))
    }

    /// The numbers of an array of trajectories, whatever its strides.
    fn rows(&self, x: &PyReadonlyArray3<'_, f32>) -> PyResult<Vec<f32>> {
        self.check(x.shape())?;
        // A slice of an array in Fortran's order would be in that order.
        let rows: Vec<f32> = match x.as_slice() {
            Ok(rows) if x.is_c_contiguous() => rows.to_vec(),
            _ => x.as_array().iter().copied().collect(),
        };
        match rows.iter().position(|value| !value.is_finite()) {
            None => Ok(rows),
            Some(at) => {
                let (size, dof) = (self.waypoints * self.dof, self.dof);
                let place = format!("x[{}, {}, {}]", at / size, at % size / dof, at % dof);
                Err(invalid(format!(
                    "{place}: {} is not allowed; expected a finite number",
                    rows[at]
                )))
            }
        }
    }

    fn array<'py>(&self, py: Python<'py>, flat: Vec<f32>) -> PyResult<Trajectories<'py>> {
        Ok(Array3::from_shape_vec(self.shape(), flat).map_err(invalid)?.into_pyarray(py))
    }
}
