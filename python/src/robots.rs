//! Robots with joints and what they move among.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray2};
use pyo3::prelude::*;
use sidestep::arm::Arm;
use sidestep::space::{Shape, World};
use sidestep::{InvalidInput, Setting};
use sidestep_io::robots::{
    Moving, Preparation, RobotFile, prepare, read_robot, read_srdf, read_urdf,
};
use sidestep_io::scenes::{SCENE_FORMAT, SceneOptions, mesh, read_scene};

use crate::invalid;
use crate::tasks::Task;
use crate::threads::detach;

/// A robot with joints; its configurations are float64 `[dof]`, rad or m.
#[pyclass(frozen, module = "sidestep")]
pub struct Robot {
    file: RobotFile,
    arm: Arc<Arm>,
}

/// An error with the file that it is in.
pub fn told(path: &Path, error: &dyn std::fmt::Display) -> PyErr {
    invalid(format!("{}: {error}", path.display()))
}

pub fn text(path: &Path) -> PyResult<String> {
    std::fs::read_to_string(path).map_err(|error| told(path, &error))
}

/// The robot of a URDF, `held` joints that it lacks left out; meshes are found beside it.
pub fn robot_of(
    urdf: &Path,
    srdf: Option<&Path>,
    mut preparation: Preparation,
) -> PyResult<(RobotFile, Arm)> {
    let model = read_urdf(&text(urdf)?).map_err(|error| told(urdf, &error))?;
    let srdf = match srdf {
        Some(path) => Some(read_srdf(&text(path)?).map_err(|error| told(path, &error))?),
        None => None,
    };
    preparation.held.retain(|(name, _)| model.joint(name).is_some());
    let beside = urdf.parent().unwrap_or(Path::new("")).to_path_buf();
    let prepared = prepare(model, srdf.as_ref(), &preparation, &mut |file, scale| {
        let refused = |found: String| {
            InvalidInput::new(format!("mesh {file:?}"), found, "an STL or OBJ file")
        };
        let path = beside.join(file.trim_start_matches("package://"));
        let bytes = std::fs::read(path).map_err(|error| refused(error.to_string()))?;
        match mesh::shape(file, &bytes, scale, true).map_err(|e| refused(e.to_string()))? {
            Shape::Hull(hull) => Ok(hull),
            other => Err(refused(other.kind().to_string())),
        }
    });
    let prepared = prepared.map_err(|error| told(urdf, &error))?;
    Ok((prepared.file, prepared.arm))
}

#[pymethods]
impl Robot {
    /// The robot of a URDF, with an SRDF for the links that may touch. `joints` move, all that can where None, in the order of a
    /// configuration's numbers; others stand where `held` says. Shapes that are no balls are covered by balls that stick out
    /// by at most `overhang` metres.
    #[staticmethod]
    #[pyo3(signature = (urdf, *, srdf=None, joints=None, held=std::collections::BTreeMap::new(), overhang=0.01))]
    fn from_urdf(
        py: Python<'_>,
        urdf: PathBuf,
        srdf: Option<PathBuf>,
        joints: Option<Vec<String>>,
        held: std::collections::BTreeMap<String, f64>,
        overhang: f64,
    ) -> PyResult<Self> {
        let moving = joints.map_or(Moving::All, Moving::Joints);
        let preparation = Preparation { moving, held: held.into_iter().collect(), overhang };
        let (file, arm) = detach(py, || robot_of(&urdf, srdf.as_deref(), preparation))?;
        Ok(Self { file, arm: Arc::new(arm) })
    }

    /// The robot of a robot file, which `sidestep robot --out` and `to_json` write.
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        detach(py, || Self::read(&text(&path)?).map_err(|error| told(&path, &error)))
    }

    /// The robot of a robot file's text.
    #[staticmethod]
    fn from_json(text: &str) -> PyResult<Self> {
        Self::read(text)
    }

    /// The text of its robot file.
    fn to_json(&self) -> String {
        self.file.to_json()
    }

    /// Its name.
    #[getter]
    fn name(&self) -> &str {
        self.arm.name()
    }

    /// How many joints move.
    #[getter]
    fn dof(&self) -> usize {
        self.arm.dof()
    }

    /// Their names.
    #[getter]
    fn joints(&self) -> Vec<String> {
        self.arm.joint_names()
    }

    /// The least and the greatest value of each that a plan may take, float64 `[dof, 2]`, rad or m.
    #[getter]
    fn limits<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let world = Arc::new(World::default());
        let setting = Setting::Arm { arm: self.arm.clone(), world };
        let scene = sidestep::Scene::new(&setting, &sidestep::Profile::DEFAULT);
        let flat = scene.limits().as_flattened().to_vec();
        let array = Array2::from_shape_vec((self.arm.dof(), 2), flat).map_err(invalid)?;
        Ok(array.into_pyarray(py))
    }

    /// A task: from `start` to `goal` among what is in `scene`. Tasks of one robot in one scene share what is prepared for it.
    #[pyo3(signature = (scene, start, goal, *, name=String::new()))]
    fn task(&self, scene: &Scene, start: Vec<f64>, goal: Vec<f64>, name: String) -> PyResult<Task> {
        let setting = Setting::Arm { arm: self.arm.clone(), world: scene.world.clone() };
        sidestep::Task::new(name, setting, start, goal).map(Task).map_err(invalid)
    }

    fn __repr__(&self) -> String {
        format!("Robot({:?}, {} joints, {} balls)", self.name(), self.dof(), self.arm.ball_count())
    }

    fn __reduce__(&self, py: Python<'_>) -> PyResult<(Py<PyAny>, (String,))> {
        Ok((py.get_type::<Self>().getattr("from_json")?.unbind(), (self.to_json(),)))
    }
}

impl Robot {
    fn read(text: &str) -> PyResult<Self> {
        let file = read_robot(text).map_err(invalid)?;
        let arm = Arc::new(file.arm().map_err(invalid)?);
        Ok(Self { file, arm })
    }
}

/// What is around a robot with joints, in metres and in the frame of its base; it never changes, `with_objects` and `without` give
/// others.
///
/// `Scene(objects)` makes one of dictionaries as in scene files: `{"name": "table", "shapes": [{"box": {"half_extents":
/// [0.4, 0.6, 0.02]}, "position": [0.5, 0, 0.3]}]}`; none at all is allowed.
#[pyclass(frozen, module = "sidestep")]
pub struct Scene {
    world: Arc<World>,
}

#[pymethods]
impl Scene {
    #[new]
    #[pyo3(signature = (objects=None))]
    fn new(py: Python<'_>, objects: Option<Bound<'_, PyAny>>) -> PyResult<Self> {
        let Some(objects) = objects else { return Ok(Self { world: Arc::default() }) };
        let text: String = py.import("json")?.call_method1("dumps", (objects,))?.extract()?;
        let text = format!("{{\"format\":\"{SCENE_FORMAT}\",\"objects\":{text}}}");
        let nothing = |name: &str| {
            let found = format!("{name}: a file is read by Scene.load alone");
            Err(std::io::Error::other(found))
        };
        let options = SceneOptions::default();
        let world = read_scene("objects.json", text.as_bytes(), options, &mut { nothing });
        Ok(Self { world: Arc::new(world.map_err(invalid)?) })
    }

    /// The scene of a file of any kind that the program reads: ours, MoveIt's, cuRobo's, clouds of points, meshes.
    #[staticmethod]
    #[pyo3(signature = (path, *, point_radius=0.01))]
    fn load(py: Python<'_>, path: PathBuf, point_radius: f64) -> PyResult<Self> {
        detach(py, || {
            let bytes = std::fs::read(&path).map_err(|error| told(&path, &error))?;
            let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
            let mut load = |name: &str| std::fs::read(folder.join(name));
            let options = SceneOptions { point_radius, ..SceneOptions::default() };
            let world = read_scene(&path.to_string_lossy(), &bytes, options, &mut load);
            Ok(Self { world: Arc::new(world.map_err(|error| told(&path, &error))?) })
        })
    }

    /// Names of the objects.
    #[getter]
    fn names(&self) -> Vec<String> {
        self.world.objects().iter().map(|object| object.name().to_owned()).collect()
    }

    /// This scene and these objects as well.
    fn with_objects(&self, py: Python<'_>, objects: Bound<'_, PyAny>) -> PyResult<Self> {
        let more = Self::new(py, Some(objects))?;
        let all = [self.world.objects(), more.world.objects()].concat();
        Ok(Self { world: Arc::new(World::new(all).map_err(invalid)?) })
    }

    /// This scene without the objects of these names.
    fn without(&self, names: Vec<String>) -> PyResult<Self> {
        let known = self.names();
        if let Some(name) = names.iter().find(|name| !known.contains(name)) {
            let allowed = format!("one of {}", known.join(", "));
            return Err(invalid(InvalidInput::new("names", format!("{name:?}"), allowed)));
        }
        let mut left = self.world.objects().to_vec();
        left.retain(|object| !names.iter().any(|name| name == object.name()));
        Ok(Self { world: Arc::new(World::new(left).map_err(invalid)?) })
    }

    fn __repr__(&self) -> String {
        format!("Scene({} objects)", self.world.objects().len())
    }
}
