//! Tasks: made, read from files of every kind that the program reads, drawn from suites, written.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use numpy::{IntoPyArray, PyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;
use sidestep::plane::geometry::Point;
use sidestep::{
    Circle, ConvexPolygon, Grid, Obstacle, Profile, Rect, Robot, Setting, Suite, World,
};
use sidestep_io::input::{self, Content, Question};
use sidestep_io::robots::{Moving, Preparation};
use sidestep_io::scenes::read_problems as problems_of;
use sidestep_io::{TaskFormat, write_tasks};

use crate::invalid;
use crate::robots::{robot_of, told};
use crate::threads::detach;

/// A motion planning task: a robot in its surroundings, a start and a goal.
///
/// `Task(bounds, start, goal, ...)` makes one in the plane: `bounds` is `((min_x, min_y), (max_x, max_y))`, `rects` a
/// list of `(min_x, min_y, max_x, max_y)`, `circles` of `(x, y, radius)`, `polygons` of lists of corners, `grid` an
/// array of bool `[rows, columns]`, True where occupied, the first row at the bottom, whose cells are `resolution` wide
/// from `origin` on. All in the same unit. A start in collision is no error here: planning answers it.
#[pyclass(frozen, module = "sidestep")]
#[derive(Clone)]
pub struct Task(pub sidestep::Task);

#[pymethods]
impl Task {
    #[new]
    #[pyo3(signature = (bounds, start, goal, *, rects=vec![], circles=vec![], polygons=vec![], grid=None, resolution=1.0, origin=[0.0, 0.0], robot_radius=0.0, name=String::new()))]
    #[allow(clippy::too_many_arguments, reason = "keywords in Python")]
    fn new(
        bounds: [Point; 2],
        start: Point,
        goal: Point,
        rects: Vec<[f64; 4]>,
        circles: Vec<[f64; 3]>,
        polygons: Vec<Vec<Point>>,
        grid: Option<PyReadonlyArray2<'_, bool>>,
        resolution: f64,
        origin: Point,
        robot_radius: f64,
        name: String,
    ) -> PyResult<Self> {
        let mut obstacles = Vec::new();
        let inside = |list: &str, i: usize, error: sidestep::InvalidInput| {
            invalid(error.inside(&format!("{list}[{i}]")))
        };
        for (i, [min_x, min_y, max_x, max_y]) in rects.into_iter().enumerate() {
            let rect = Rect::new([min_x, min_y], [max_x, max_y]);
            obstacles.push(Obstacle::Rect(rect.map_err(|error| inside("rects", i, error))?));
        }
        for (i, [x, y, radius]) in circles.into_iter().enumerate() {
            let circle = Circle::new([x, y], radius);
            obstacles.push(Obstacle::Circle(circle.map_err(|error| inside("circles", i, error))?));
        }
        for (i, corners) in polygons.into_iter().enumerate() {
            let polygon = ConvexPolygon::new(corners);
            obstacles
                .push(Obstacle::Polygon(polygon.map_err(|error| inside("polygons", i, error))?));
        }
        let grid = match grid {
            Some(cells) => {
                let [rows, columns] = [cells.shape()[0], cells.shape()[1]];
                let occupied: Vec<bool> = cells.as_array().iter().copied().collect();
                Some(Grid::new(columns, rows, resolution, origin, occupied).map_err(invalid)?)
            }
            None => None,
        };
        let bounds =
            Rect::new(bounds[0], bounds[1]).map_err(|error| invalid(error.inside("bounds")))?;
        let world = Arc::new(World::new(bounds, obstacles, grid));
        let robot = Robot::disc(robot_radius).map_err(invalid)?;
        sidestep::Task::in_plane(name, world, robot, start, goal).map(Self).map_err(invalid)
    }

    /// Its name.
    #[getter]
    fn name(&self) -> &str {
        &self.0.name
    }

    /// Numbers of a configuration: 2 in the plane, one a joint.
    #[getter]
    fn dof(&self) -> usize {
        self.0.setting.dof()
    }

    /// The start, float64 `[dof]`, in task units (rad or m of a robot with joints).
    #[getter]
    fn start<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.start.clone().into_pyarray(py)
    }

    /// The goal, float64 `[dof]`.
    #[getter]
    fn goal<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.goal.clone().into_pyarray(py)
    }

    /// Names of a configuration's numbers: `x`, `y`, or the joints.
    #[getter]
    fn coordinates(&self) -> Vec<String> {
        match &self.0.setting {
            Setting::Arm { arm, .. } => arm.joint_names(),
            _ => vec!["x".into(), "y".into()],
        }
    }

    /// The field `((min_x, min_y), (max_x, max_y))`; None of a robot with joints.
    #[getter]
    fn bounds(&self) -> Option<[Point; 2]> {
        let plane = self.0.plane().ok()?;
        let bounds = plane.world.bounds();
        Some([bounds.min, bounds.max])
    }

    /// The obstacles of the plane: `("rect", [min, max])`, `("circle", [center, (radius, 0)])`, `("polygon", corners)`.
    #[getter]
    fn obstacles(&self) -> Vec<(&'static str, Vec<Point>)> {
        let Ok(plane) = self.0.plane() else { return Vec::new() };
        let told = |obstacle: &Obstacle| match obstacle {
            Obstacle::Rect(rect) => ("rect", vec![rect.min, rect.max]),
            Obstacle::Circle(circle) => ("circle", vec![circle.center, [circle.radius, 0.0]]),
            Obstacle::Polygon(polygon) => ("polygon", polygon.vertices().to_vec()),
        };
        plane.world.obstacles().iter().map(told).collect()
    }

    /// The robot's radius; 0 of a point, None of a robot with joints.
    #[getter]
    fn robot_radius(&self) -> Option<f64> {
        self.0.plane().ok().map(|plane| plane.robot.radius())
    }

    /// The same task between other ends, in the same surroundings.
    #[pyo3(signature = (start=None, goal=None))]
    fn between(&self, start: Option<Vec<f64>>, goal: Option<Vec<f64>>) -> PyResult<Self> {
        let sidestep::Task { name, setting, start: from, goal: to } = self.0.clone();
        let task = sidestep::Task::new(name, setting, start.unwrap_or(from), goal.unwrap_or(to));
        task.map(Self).map_err(invalid)
    }

    fn __repr__(&self) -> String {
        format!(
            "Task({:?}, {} -> {:?})",
            self.0.name,
            format_args!("{:?}", self.0.start),
            self.0.goal
        )
    }

    /// As task JSON, which `Task.from_json` reads.
    fn to_json(&self) -> PyResult<String> {
        write_tasks(std::slice::from_ref(&self.0), TaskFormat::Json).map_err(invalid)
    }

    /// The one task of a task JSON text.
    #[staticmethod]
    fn from_json(text: &str) -> PyResult<Self> {
        let mut tasks = sidestep_io::read_tasks(text, TaskFormat::Json).map_err(invalid)?;
        match tasks.len() {
            1 => Ok(Self(tasks.remove(0))),
            count => Err(invalid(format!("{count} tasks where one was expected"))),
        }
    }

    fn __reduce__(&self, py: Python<'_>) -> PyResult<(Py<PyAny>, (String,))> {
        Ok((py.get_type::<Self>().getattr("from_json")?.unbind(), (self.to_json()?,)))
    }
}

/// Tasks of a file of any kind that the program reads, by its name or its first bytes: task JSON and JSON lines, ROS
/// maps, MovingAI maps and scenarios, BARN and MPNet worlds, pictures (dark is an obstacle). A map alone needs `start`
/// and `goal`.
#[pyfunction]
#[pyo3(signature = (path, *, start=None, goal=None, robot_radius=None, seed=0))]
pub fn read(
    py: Python<'_>,
    path: PathBuf,
    start: Option<Point>,
    goal: Option<Point>,
    robot_radius: Option<f64>,
    seed: u64,
) -> PyResult<Vec<Task>> {
    detach(py, || {
        let told = |error: &dyn std::fmt::Display| invalid(format!("{}: {error}", path.display()));
        let bytes = std::fs::read(&path).map_err(|error| told(&error))?;
        let question = Question { start, goal, robot_radius, seed, ..Question::default() };
        let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
        let mut load = |name: &str| std::fs::read(folder.join(name));
        let name = path.to_string_lossy();
        let read =
            input::read(&name, &bytes, &question, &mut load).map_err(|error| told(&error))?;
        let tasks = match read.content {
            Content::Tasks(tasks) => tasks,
            Content::Map(world) => {
                let (Some(start), Some(goal)) = (start, goal) else {
                    return Err(told(
                        &"a map has no start and goal: give start=(x, y), goal=(x, y)",
                    ));
                };
                let robot = Robot::disc(robot_radius.unwrap_or(0.0)).map_err(invalid)?;
                let name =
                    path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into());
                vec![sidestep::Task::in_plane(name, world, robot, start, goal).map_err(invalid)?]
            }
            Content::Problems(_) => {
                return Err(told(&"problems of a robot with joints: read_problems(path, urdf=..)"));
            }
        };
        Ok(tasks.into_iter().map(Task).collect())
    })
}

/// Problems of a robot with joints (`sidestep.problems/1`, or MotionBenchMaker's as JSON) as tasks of the robot of a
/// URDF, with an SRDF for the links that may touch. Shapes that are no balls are covered by balls that stick out by at
/// most `overhang` metres; meshes are found beside the URDF by the names that it gives them.
#[pyfunction]
#[pyo3(signature = (path, *, urdf, srdf=None, overhang=0.01))]
pub fn read_problems(
    py: Python<'_>,
    path: PathBuf,
    urdf: PathBuf,
    srdf: Option<PathBuf>,
    overhang: f64,
) -> PyResult<Vec<Task>> {
    detach(py, || {
        let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
        let mut load = |name: &str| std::fs::read(folder.join(name));
        let bytes = std::fs::read(&path).map_err(|error| told(&path, &error))?;
        let problems = problems_of(&bytes, &mut load).map_err(|error| told(&path, &error))?;
        let Some(first) = problems.first() else { return Err(told(&path, &"no problem")) };
        let moving = Moving::Joints(first.joints.to_vec());
        let preparation = Preparation { moving, held: first.fixed_joints.to_vec(), overhang };
        let (_, arm) = robot_of(&urdf, srdf.as_deref(), preparation)?;
        let arm = Arc::new(arm);
        let task = |problem: &sidestep_io::scenes::Problem| {
            let setting = Setting::Arm { arm: Arc::clone(&arm), world: Arc::clone(&problem.world) };
            let goal = problem.goals.first().cloned().unwrap_or_default();
            sidestep::Task::new(&problem.name, setting, problem.start.clone(), goal)
                .map(Task)
                .map_err(|error| told(&path, &error))
        };
        problems.iter().map(task).collect()
    })
}

/// The first `count` tasks of a suite and a seed: easy, hard, hard-training, mix, time, varied, rooms, blobs or scans.
#[pyfunction]
#[pyo3(signature = (name, count, *, seed=0))]
pub fn suite(py: Python<'_>, name: &str, count: usize, seed: u64) -> PyResult<Vec<Task>> {
    let suite: Suite = name.parse().map_err(invalid)?;
    if count > 1_000_000 {
        return Err(invalid(format!("count: {count} is not allowed; expected at most 1000000")));
    }
    Ok(detach(py, || suite.generate(count, seed, &Profile::PAPER).into_iter().map(Task).collect()))
}

/// Writes tasks of the plane to a file: task JSON, or one a line where the name ends in `.jsonl`.
#[pyfunction]
pub fn write(py: Python<'_>, path: PathBuf, tasks: Vec<PyRef<'_, Task>>) -> PyResult<()> {
    let tasks: Vec<sidestep::Task> = tasks.iter().map(|task| task.0.clone()).collect();
    detach(py, || {
        let lines = path.extension().is_some_and(|suffix| suffix.eq_ignore_ascii_case("jsonl"));
        let format = if lines { TaskFormat::JsonLines } else { TaskFormat::Json };
        let text = write_tasks(&tasks, format).map_err(invalid)?;
        // Whole or not there.
        let beside = path.with_extension("part");
        std::fs::write(&beside, text)
            .and_then(|()| std::fs::rename(&beside, &path))
            .map_err(|error| invalid(format!("{}: {error}", path.display())))
    })
}
