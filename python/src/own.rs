//! What people bring in Python: an optimizer and a cost of their own. Each call takes the interpreter for as long as it lasts.

use std::sync::Arc;

use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use sidestep::optimizer::{Method, Own, Step};
use sidestep::plan::{Planner, parse_planner};
use sidestep::{InvalidInput, Query};

use crate::interrupt::Interrupt;
use crate::invalid;
use crate::policy::{Policy, read_policy};

/// The planner that an argument means: a name with settings, a policy, or an optimizer of one's own.
pub fn planner_of(
    argument: Option<&Bound<'_, PyAny>>,
    watch: &Arc<Interrupt>,
) -> PyResult<Planner> {
    let load = |path: &str| read_policy(path.as_ref()).map(Arc::new);
    let Some(argument) = argument else { return Ok(Planner::default()) };
    if let Ok(name) = argument.extract::<String>() {
        return parse_planner(&name, &mut { load }).map_err(invalid);
    }
    if let Ok(policy) = argument.cast::<Policy>() {
        return Ok(Planner::Optimizer(Method::Learned(policy.get().0.clone())));
    }
    if argument.is_callable() {
        let make = Arc::new(argument.clone().unbind());
        return Ok(Planner::Optimizer(Method::Own(optimizer(make, watch.clone()))));
    }
    let found = argument.get_type().name()?;
    Err(PyTypeError::new_err(format!(
        "planner: {found} is not allowed; expected a name, a Policy or a callable (waypoints, dof) -> step"
    )))
}

/// `make(waypoints, dof)` gives for each start what steps: `step(x, cost, gradient)` answers the next x, arrays `[waypoints, dof]`.
fn optimizer(make: Arc<Py<PyAny>>, watch: Arc<Interrupt>) -> Own {
    Own::new(move |objective| {
        let shape = (objective.waypoints(), objective.dof());
        let made = Python::attach(|py| make.call1(py, shape));
        let step = made.map_err(|error| watch.fail(error)).ok();
        let watch = watch.clone();
        let stepped: Step = Box::new(move |x, known, _| {
            let Some(step) = step.as_ref().filter(|_| !watch.is_pressed()) else { return };
            let moved = Python::attach(|py| {
                let arrays = [&*x, known.gradient].map(|values| array(py, shape, values));
                let [at, gradient] = arrays;
                let next = step.call1(py, (at?, known.cost.total, gradient?))?;
                copy_back(next.bind(py), "planner: its step", shape, x)
            });
            if let Err(error) = moved {
                watch.fail(error);
            }
        });
        stepped
    })
}

/// The question with a cost of one's own: `cost(path)` answers `(value, gradient)`, for the path `[waypoints + 2, dof]` with its
/// ends, where the gradient is that of the inner ones `[waypoints, dof]`.
pub fn with_cost(query: Query, cost: Option<&Arc<Py<PyAny>>>, watch: &Arc<Interrupt>) -> Query {
    let Some(cost) = cost.cloned() else { return query };
    let (watch, dof) = (watch.clone(), query.scene().dof());
    query.with_cost(move |[start, x, goal], gradient| {
        if watch.is_pressed() {
            return 0.0;
        }
        let (path, waypoints) = ([start, x, goal].concat(), x.len() / dof);
        let told = Python::attach(|py| {
            let path = array(py, (waypoints + 2, dof), &path)?;
            let answer = cost.call1(py, (path,))?;
            let (value, slopes): (f32, Bound<'_, PyAny>) = answer.bind(py).extract()?;
            if !value.is_finite() {
                return Err(invalid(format!(
                    "cost: {value} is not allowed; expected a finite number"
                )));
            }
            let mut own = vec![0.0; x.len()];
            copy_back(&slopes, "cost: its gradient", (waypoints, dof), &mut own)?;
            Ok((value, own))
        });
        match told {
            Ok((value, own)) => {
                if let Some(gradient) = gradient {
                    gradient.iter_mut().zip(own).for_each(|(sum, slope)| *sum += slope);
                }
                value
            }
            Err(error) => {
                watch.fail(error);
                0.0
            }
        }
    })
}

fn array<'py>(
    py: Python<'py>,
    shape: (usize, usize),
    values: &[f32],
) -> PyResult<Bound<'py, numpy::PyArray2<f32>>> {
    Ok(Array2::from_shape_vec(shape, values.to_vec()).map_err(invalid)?.into_pyarray(py))
}

/// Copies an array of that shape, of whatever numbers, if all are finite.
fn copy_back(
    found: &Bound<'_, PyAny>,
    what: &str,
    shape: (usize, usize),
    to: &mut [f32],
) -> PyResult<()> {
    let numpy = found.py().import("numpy")?;
    let array: PyReadonlyArray2<'_, f32> = numpy
        .call_method1("ascontiguousarray", (found, "float32"))?
        .extract()
        .map_err(|_| refused(what, "something else".into(), shape))?;
    if array.shape() != [shape.0, shape.1] {
        return Err(refused(what, format!("an array of shape {:?}", array.shape()), shape));
    }
    if array.as_array().iter().any(|value| !value.is_finite()) {
        return Err(refused(what, "NaN or infinity".into(), shape));
    }
    to.iter_mut().zip(array.as_array().iter()).for_each(|(to, from)| *to = *from);
    Ok(())
}

fn refused(what: &str, found: String, (waypoints, dof): (usize, usize)) -> PyErr {
    let allowed = format!("finite numbers [{waypoints}, {dof}]");
    invalid(InvalidInput::new(what, found, allowed))
}
