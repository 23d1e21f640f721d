//! Policies: read, written, taken apart into arrays and put together again, and what they see and answer.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use numpy::ndarray::{ArrayD, IxDyn};
use numpy::{IntoPyArray, PyArray3, PyArrayDyn, PyReadonlyArray3, PyReadonlyArrayDyn};
use numpy::{PyUntypedArrayMethods, ndarray::Array3};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use rayon::prelude::*;
use sidestep::network::Network;
use sidestep::policy::{MAP_INPUTS, PolicyNetwork, Seen, shipped};
use sidestep::{InvalidInput, Profile, Query};

use crate::invalid;
use crate::tasks::Task;
use crate::threads::detach;

/// A trained policy: its numbers, and a card that says what it sees, what its output means and where it comes from.
///
/// `Policy(card, tensors)` makes one of a card (a dictionary, as `card` gives it) and float32 arrays by name, checked as a
/// policy file is; `Policy.load` reads a file or takes one that comes with the package.
#[pyclass(frozen, module = "sidestep")]
#[derive(Clone)]
pub struct Policy(pub Arc<sidestep::Policy>);

/// Reads a policy file.
pub fn read_policy(path: &std::path::Path) -> Result<sidestep::Policy, InvalidInput> {
    let bytes = std::fs::read(path).map_err(|error| {
        let found = format!("{path:?}, {error}");
        InvalidInput::new("policy", found, "a policy file (.safetensors)")
    })?;
    sidestep::Policy::from_safetensors(&bytes)
}

#[pymethods]
impl Policy {
    #[new]
    fn new(
        py: Python<'_>,
        card: Bound<'_, PyAny>,
        tensors: BTreeMap<String, PyReadonlyArrayDyn<'_, f32>>,
    ) -> PyResult<Self> {
        let text: String = py.import("json")?.call_method1("dumps", (card,))?.extract()?;
        let card: serde_json::Value = serde_json::from_str(&text).map_err(invalid)?;
        let numbers: Vec<_> = tensors
            .iter()
            .map(|(name, array)| {
                (name, array.shape(), array.as_array().iter().copied().collect::<Vec<f32>>())
            })
            .collect();
        let parts: Vec<_> = numbers
            .iter()
            .map(|(name, shape, values)| ((*name).clone(), shape.to_vec(), &values[..]))
            .collect();
        let policy = sidestep::Policy::from_tensors(&card, &parts).map_err(invalid)?;
        Ok(Self(Arc::new(policy)))
    }

    /// Reads a policy file, or takes the policy of a planner's name: `sidestep-1`, `sidestep-1-small`.
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        match path.to_str() {
            Some("sidestep-1") => Ok(Self(shipped::sidestep_1())),
            Some("sidestep-1-small") => Ok(Self(shipped::sidestep_1_small())),
            _ => {
                let policy = py
                    .detach(|| read_policy(&path))
                    .map_err(|error| invalid(format!("{}: {error}", path.display())))?;
                Ok(Self(Arc::new(policy)))
            }
        }
    }

    /// Reads the bytes of a policy file.
    #[staticmethod]
    fn from_bytes(bytes: &[u8]) -> PyResult<Self> {
        sidestep::Policy::from_safetensors(bytes).map(|p| Self(Arc::new(p))).map_err(invalid)
    }

    /// The bytes of its file.
    fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        Ok(PyBytes::new(py, &self.0.to_safetensors().map_err(invalid)?))
    }

    /// Writes its file, which `learned:PATH` plans with; the file is there whole or not at all.
    fn save(&self, path: PathBuf) -> PyResult<()> {
        let bytes = self.0.to_safetensors().map_err(invalid)?;
        let beside = path.with_extension("part");
        std::fs::write(&beside, bytes)
            .and_then(|()| std::fs::rename(&beside, &path))
            .map_err(|error| invalid(format!("{}: {error}", path.display())))
    }

    /// Everything but its numbers: architecture, sizes, observation, profile, action, training, licence.
    #[getter]
    fn card<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let text = serde_json::to_string(self.0.card()).map_err(invalid)?;
        py.import("json")?.call_method1("loads", (text,))
    }

    /// Where inputs lie, for who runs the network elsewhere: `image_at`, where the image begins in an observation, or None;
    /// `map`, None or a dictionary of the map's `cells` (a side), `channels`, `dilations` and `features`, the columns of a row
    /// from the first of its features to behind the last.
    #[getter]
    fn layout<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let layout = PyDict::new(py);
        let (mut image_at, mut map) = (None, None);
        match self.0.network() {
            PolicyNetwork::Whole { network: Network::Cnn(cnn), .. } => {
                image_at = Some(cnn.image_at())
            }
            PolicyNetwork::Waypoint { view, .. } => {
                if let (Some(shape), Some(features)) = (&view.map, view.features_at()) {
                    let of_map = PyDict::new(py);
                    of_map.set_item("cells", shape.cells)?;
                    of_map.set_item("channels", shape.channels)?;
                    of_map.set_item("dilations", shape.dilations.clone())?;
                    of_map.set_item("features", (features.start, features.end))?;
                    map = Some(of_map);
                }
            }
            _ => {}
        }
        layout.set_item("image_at", image_at)?;
        layout.set_item("map", map)?;
        Ok(layout)
    }

    /// Its numbers by name, float32, as in the file.
    fn tensors<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let all = PyDict::new(py);
        for (name, shape, values) in self.0.tensors() {
            let array = ArrayD::from_shape_vec(IxDyn(&shape), values.to_vec()).map_err(invalid)?;
            all.set_item(name, array.into_pyarray(py))?;
        }
        Ok(all)
    }

    /// What it sees of one trajectory of each task, float32 `[tasks, waypoints, dof]` in normalised units, as of a first one, and
    /// what it answers: a dictionary of inputs by the names of an exported network's, and the updates, float32
    /// `[tasks, waypoints, dof]`, clipped, not yet kept inside the field. A policy of waypoints in the plane answers along
    /// and across the line from start to goal.
    #[pyo3(signature = (tasks, x, *, profile=None))]
    fn look<'py>(
        &self,
        py: Python<'py>,
        tasks: Vec<PyRef<'_, Task>>,
        x: PyReadonlyArray3<'py, f32>,
        profile: Option<&str>,
    ) -> PyResult<(Bound<'py, PyDict>, Bound<'py, PyArray3<f32>>)> {
        let profile = profile.or(self.0.fixed_profile()).unwrap_or("default");
        let profile: Profile = profile.parse().map_err(invalid)?;
        let tasks: Vec<sidestep::Task> = tasks.iter().map(|task| task.0.clone()).collect();
        let &[count, waypoints, dof] = x.shape() else { return Err(invalid("x: no array")) };
        if tasks.is_empty() || count != tasks.len() || dof != self.0.card().dof {
            let found = format!("x: an array of shape {:?} is not allowed", x.shape());
            let (tasks, dof) = (tasks.len(), self.0.card().dof);
            return Err(invalid(format!(
                "{found}; expected [{tasks}, waypoints, {dof}], a trajectory of each of one or more tasks"
            )));
        }
        let values: Vec<f32> = x.as_array().iter().copied().collect();
        if values.iter().any(|value| !value.is_finite()) {
            return Err(invalid("x: expected finite numbers"));
        }
        let all: Result<Vec<Seen>, InvalidInput> = detach(py, || {
            let rows = values.par_chunks((waypoints * dof).max(1));
            tasks
                .par_iter()
                .zip(rows)
                .map(|(task, x)| self.see(task, &profile, waypoints, x))
                .collect()
        });
        let all = all.map_err(invalid)?;
        let inputs = PyDict::new(py);
        let put = |name: &str, shape: &[usize], of: &dyn Fn(&Seen) -> &[f32]| {
            let flat: Vec<f32> = all.iter().flat_map(of).copied().collect();
            let array = ArrayD::from_shape_vec(IxDyn(shape), flat).map_err(invalid)?;
            inputs.set_item(name, array.into_pyarray(py) as Bound<'_, PyArrayDyn<f32>>)
        };
        let row = self.0.card().sizes[0];
        match self.0.fixed_waypoints() {
            Some(_) => put("rows", &[count, row], &|seen| &seen.rows)?,
            None => put("rows", &[count, waypoints, row], &|seen| &seen.rows)?,
        }
        if let Some(map) = &all[0].map {
            let side = (map.cells.len() / MAP_INPUTS).isqrt();
            let places = map.places.len() / (2 * waypoints);
            put("map", &[count, side, side, MAP_INPUTS], &|seen| {
                seen.map.as_ref().map_or(&[], |map| &map.cells)
            })?;
            put("places", &[count, waypoints, places, 2], &|seen| {
                seen.map.as_ref().map_or(&[], |map| &map.places)
            })?;
        }
        if all[0].base.is_some() {
            put("base", &[count, waypoints, dof], &|seen| seen.base.as_deref().unwrap_or(&[]))?;
        }
        let flat: Vec<f32> = all.iter().flat_map(|seen| seen.update.iter().copied()).collect();
        let update = Array3::from_shape_vec((count, waypoints, dof), flat).map_err(invalid)?;
        Ok((inputs, update.into_pyarray(py)))
    }

    fn __repr__(&self) -> String {
        let card = self.0.card();
        format!(
            "Policy({} {:?}, sees {})",
            card.architecture,
            card.sizes,
            card.observation.join(" + ")
        )
    }

    fn __reduce__(&self, py: Python<'_>) -> PyResult<(Py<PyAny>, (Py<PyBytes>,))> {
        let read = py.get_type::<Self>().getattr("from_bytes")?.unbind();
        Ok((read, (self.to_bytes(py)?.unbind(),)))
    }
}

impl Policy {
    fn see(
        &self,
        task: &sidestep::Task,
        profile: &Profile,
        waypoints: usize,
        x: &[f32],
    ) -> Result<Seen, InvalidInput> {
        let query = Query::of(task, profile);
        let mut objective = sidestep::objective::Objective::new(&query, waypoints)?;
        self.0.look(&mut objective, x)
    }
}
