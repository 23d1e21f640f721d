//! Distance fields of the plane as arrays.

use numpy::ndarray::{Array1, Array2};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;
use rayon::prelude::*;
use sidestep::{Profile, Scene};

use crate::invalid;
use crate::tasks::Task;
use crate::threads::detach;

/// Signed distances of the robot's body to everything around it, walls included, where its centre is at points, float64
/// `[points, 2]`, of a task in the plane: float32 `[points]` in task units, negative where they overlap, and their
/// gradients, float32 `[points, 2]`.
#[pyfunction]
#[allow(clippy::type_complexity, reason = "two arrays")]
pub fn distances<'py>(
    py: Python<'py>,
    task: &Task,
    points: PyReadonlyArray2<'py, f64>,
) -> PyResult<(Bound<'py, PyArray1<f32>>, Bound<'py, PyArray2<f32>>)> {
    task.0.plane().map_err(invalid)?;
    let count = points.shape()[0];
    if points.shape()[1] != 2 {
        let found = format!("points: an array of shape {:?} is not allowed", points.shape());
        return Err(invalid(format!("{found}; expected [points, 2]")));
    }
    let values: Vec<f64> = points.as_array().iter().copied().collect();
    if values.iter().any(|value| !value.is_finite()) {
        return Err(invalid("points: expected finite numbers"));
    }
    let found: Vec<(f32, [f32; 2])> = detach(py, || {
        let scene = Scene::of(&task.0, &Profile::DEFAULT);
        let Some(scene) = scene.plane() else { return Vec::new() };
        let (field, frame) = (scene.exact_field(), scene.frame());
        let unit = (frame.to_task([1.0, 0.0])[0] - frame.to_task([0.0, 0.0])[0]) as f32;
        let points = values.as_chunks::<2>().0.par_iter().with_min_len(256);
        let at = |p: &[f64; 2]| {
            let (distance, gradient) = field.at(frame.to_normalised(*p));
            (unit * distance, gradient)
        };
        points.map(at).collect()
    });
    let gradients: Vec<f32> = found.iter().flat_map(|(_, gradient)| *gradient).collect();
    let distances = Array1::from_vec(found.into_iter().map(|(distance, _)| distance).collect());
    let gradients = Array2::from_shape_vec((count, 2), gradients).map_err(invalid)?;
    Ok((distances.into_pyarray(py), gradients.into_pyarray(py)))
}
