//! Plan JSON: the answer to one task as one JSON object, and the waypoints of such a document (or of a
//! path that something else made) to start from.
//!
//! Numbers are numbers: what is not known is `null` as a whole field, and no coordinate ever is.

use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use serde::Serialize;
use sidestep::Trajectory;
use sidestep::error::MAX_COORDINATE;
use sidestep::objective::Objective;
use sidestep::plan::Plan;
use sidestep::plan::run::Iteration;
use sidestep::scene::Query;

use crate::drive::nav2_error_code;
use crate::error::{FormatError, Place};
use crate::input::without_mark;
use crate::json::{Json, Node, Source, parse};

const FORMAT: &str = "plan JSON";

/// One answer; docs/task-format.md says what each field means.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PlanDocument {
    /// `solved`, `unsolved`, `unsolvable` or `invalid`.
    pub status: &'static str,
    /// In words where not solved.
    pub reason: String,
    /// What nav2's planner action would answer: 0, or a code from 203 to 208.
    pub nav2_error_code: u16,
    /// The task's name.
    pub task: String,
    /// The planner's name as it was given.
    pub planner: String,
    /// What made the plan: which start, or the exact search. None without a plan.
    pub origin: Option<String>,
    /// Optimizer steps to the plan.
    pub iterations: usize,
    /// Microseconds from the task to the answer.
    pub time_us: f64,
    /// Length of a solved plan, in task units.
    pub length: Option<f64>,
    /// Length of the shortest path, where that is decided.
    pub optimal_length: Option<f64>,
    /// Least distance of the robot's body to obstacles and bounds, of a solved plan.
    pub clearance: Option<f64>,
    /// The sharpest turn between two segments of a solved plan, in degrees from 0 to 180.
    pub sharpest_turn_deg: Option<f64>,
    /// The least radius of arcs that round its corners, each touching both segments no further away than half the
    /// shorter one, in task units; none for a straight line.
    pub turning_radius: Option<f64>,
    /// Sum of squared second differences of 64 points spread evenly along a solved plan.
    pub roughness: Option<f64>,
    /// Whether the exact certificate passed the waypoints.
    pub certified: bool,
    /// What to know about how the task was read.
    pub warnings: Vec<String>,
    /// Names of a waypoint's numbers, of a robot with joints.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub joints: Option<Vec<String>>,
    /// From start to goal, `[points x dof]` in task units; where not solved, an optimizer's last attempt.
    pub waypoints: Vec<Vec<f64>>,
    /// Every iterate, where that was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub trace: Option<Vec<TraceStep>>,
}

/// One iterate.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TraceStep {
    /// Number of the start, from 0.
    pub start: usize,
    /// Number of the iterate, from 0, the start itself.
    pub iteration: usize,
    /// U.
    pub objective: f32,
    /// The obstacles' part of U.
    pub obstacle_cost: f32,
    /// The length's part of U.
    pub length_cost: f32,
    /// Whether the exact certificate passes the iterate.
    pub certified: bool,
    /// From start to goal, `[points x dof]` in task units.
    pub waypoints: Vec<Vec<f64>>,
}

impl TraceStep {
    /// An iterate in task units. Of methods that do not use U it is computed here.
    pub fn of(query: &Query, iteration: &Iteration<'_>) -> Self {
        let objective = Objective::new(query, iteration.waypoints.len() / query.scene().dof()).ok();
        let cost = iteration.cost.or_else(|| Some(objective.clone()?.cost(iteration.waypoints)));
        let cost = cost.unwrap_or_default();
        let trajectory = objective.map(|objective| objective.trajectory(iteration.waypoints));
        Self {
            start: iteration.start,
            iteration: iteration.index,
            objective: cost.total,
            obstacle_cost: cost.obstacle,
            length_cost: cost.length,
            certified: iteration.solved,
            waypoints: trajectory.as_ref().map_or_else(Vec::new, rows),
        }
    }
}

/// The configurations of a trajectory.
fn rows(path: &Trajectory) -> Vec<Vec<f64>> {
    path.configurations().map(<[f64]>::to_vec).collect()
}

/// Iterates as planners show them, from any thread.
#[derive(Debug)]
pub struct Trace {
    most: usize,
    steps: Mutex<Vec<TraceStep>>,
}

impl Trace {
    /// Keeps at most so many iterates.
    pub fn new(most: usize) -> Self {
        Self { most, steps: Mutex::default() }
    }

    /// Keeps an iterate, if there is room.
    pub fn see(&self, query: &Query, iteration: &Iteration<'_>) {
        // Steps of one who panicked are whole: they are made before they are kept.
        let steps = || self.steps.lock().unwrap_or_else(PoisonError::into_inner);
        if steps().len() < self.most {
            let step = TraceStep::of(query, iteration);
            steps().push(step);
        }
    }

    /// The iterates, start by start.
    pub fn into_steps(self) -> Vec<TraceStep> {
        let mut steps = self.steps.into_inner().unwrap_or_else(PoisonError::into_inner);
        steps.sort_by_key(|step| (step.start, step.iteration));
        steps
    }
}

impl PlanDocument {
    /// What came of a task: its name, and the planner's as it was given; `query` is what clearances are measured in. The length of
    /// the shortest path, warnings and iterates are left for who knows them.
    pub fn of(
        [task, planner]: [&str; 2],
        query: &Query,
        plan: &Plan,
        time: Duration,
        reason: String,
    ) -> Self {
        let certified = plan.certified();
        Self {
            status: plan.status.name(),
            reason,
            nav2_error_code: nav2_error_code(&plan.status),
            task: task.into(),
            planner: planner.into(),
            origin: certified.map(|_| plan.origin.to_string()),
            iterations: plan.steps,
            time_us: time.as_secs_f64() * 1e6,
            length: certified.map(Trajectory::length),
            optimal_length: None,
            clearance: certified.map(|path| query.scene().clearance(path)),
            sharpest_turn_deg: certified.map(|path| path.sharpest_turn().to_degrees()),
            turning_radius: certified.map(Trajectory::turning_radius),
            roughness: certified.map(Trajectory::roughness),
            certified: certified.is_some(),
            warnings: Vec::new(),
            joints: query.scene().arm().map(|scene| scene.arm().joint_names()),
            waypoints: plan.trajectory().map_or_else(Vec::new, rows),
            trace: None,
        }
    }

    /// The document's text, indented, with a final newline. What is no number is left out: an iterate of
    /// the trace that holds such, all waypoints, or the field.
    pub fn to_json(&self) -> String {
        let mut document = self.clone();
        let Self { length, optimal_length, clearance, sharpest_turn_deg, .. } = &mut document;
        let known = [length, optimal_length, clearance, sharpest_turn_deg];
        for value in known {
            *value = value.filter(|value| value.is_finite());
        }
        let Self { turning_radius, roughness, waypoints, trace, .. } = &mut document;
        for value in [turning_radius, roughness] {
            *value = value.filter(|value| value.is_finite());
        }
        if !is_finite(waypoints) {
            waypoints.clear();
        }
        if let Some(trace) = trace {
            trace.retain(|step| {
                let costs = [step.objective, step.obstacle_cost, step.length_cost];
                is_finite(&step.waypoints) && costs.iter().all(|cost| cost.is_finite())
            });
        }
        // Strings, numbers and lists of them: nothing that could fail.
        serde_json::to_string_pretty(&document).unwrap_or_default() + "\n"
    }
}

fn is_finite(points: &[Vec<f64>]) -> bool {
    points.iter().flatten().all(|value| value.is_finite())
}

/// The waypoints of a plan of `dof` numbers each: of a document as above, or of a JSON array of points
/// alone; at least two, start and goal included.
///
/// # Errors
/// If the text is no such document; the message names line, column and field.
pub fn read_waypoints(text: &str, dof: usize) -> Result<Trajectory, FormatError> {
    let text = without_mark(text);
    let json = parse(FORMAT, text, 1)?;
    let root = Node::root(Source { format: FORMAT, text, first_line: 1 }, &json);
    let point = if dof == 2 { "a point [x, y]".into() } else { format!("{dof} numbers") };
    let wanted = match dof {
        2 => "an array of at least 2 points [x, y]".into(),
        _ => format!("an array of at least 2 configurations of {dof} numbers"),
    };
    let waypoints = match json {
        Json::Array(_) => root,
        _ => root.required("waypoints", &wanted)?,
    };
    let mut values = Vec::new();
    for item in waypoints.items(&wanted)? {
        let before = values.len();
        for number in item.items(&point)? {
            let value = number.number()?;
            if value.abs() > MAX_COORDINATE {
                return Err(number.wrong("a number of magnitude at most 1e9"));
            }
            values.push(value);
        }
        let found = values.len() - before;
        if found != dof {
            return Err(item.found(format!("an array of {found}"), point));
        }
    }
    if values.len() < 2 * dof {
        let place = Place::field("waypoints");
        let found = format!("{} points", values.len() / dof);
        return Err(FormatError::new(FORMAT, place, found, wanted));
    }
    Ok(Trajectory::new(dof, values))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn document(waypoints: Vec<Vec<f64>>) -> PlanDocument {
        let step = TraceStep {
            start: 0,
            iteration: 0,
            objective: 1.0,
            obstacle_cost: f32::NAN,
            length_cost: 1.0,
            certified: false,
            waypoints: waypoints.clone(),
        };
        PlanDocument {
            status: "unsolved",
            reason: "500 steps".into(),
            nav2_error_code: 208,
            task: "two \"walls\"".into(),
            planner: "gd".into(),
            origin: None,
            iterations: 3,
            time_us: 1.5,
            length: Some(f64::INFINITY),
            optimal_length: None,
            clearance: Some(f64::NAN),
            sharpest_turn_deg: Some(3.0),
            turning_radius: Some(f64::INFINITY),
            roughness: Some(0.5),
            certified: false,
            warnings: vec![],
            joints: None,
            waypoints,
            trace: Some(vec![step.clone(), TraceStep { obstacle_cost: 0.5, ..step }]),
        }
    }

    #[test]
    fn waypoints_come_back_and_no_number_is_null() {
        let points = vec![vec![0.1, -1e9], vec![1.0 / 3.0, 5e-324], vec![7.0, 8.0]];
        let text = document(points.clone()).to_json();
        assert_eq!(read_waypoints(&text, 2), Ok(Trajectory::new(2, points.concat())));
        let value: serde_json::Value = serde_json::from_str(&text).unwrap();
        assert_eq!(
            (value["length"].is_null(), value["trace"].as_array().unwrap().len()),
            (true, 1)
        );
        let broken = document(vec![vec![0.0, 0.0], vec![f64::NAN, 1.0]]).to_json();
        assert!(!broken.contains("[\n      null"), "{broken}");
        let plain = Trajectory::new(2, vec![0.0, 1.0, 2.0, 3.5]);
        assert_eq!(read_waypoints("\u{feff}[[0, 1], [2, 3.5]]", 2), Ok(plain));
        let three = Trajectory::new(3, vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
        assert_eq!(read_waypoints("[[0, 1, 2], [3, 4, 5]]", 3), Ok(three));
        let error = read_waypoints("[[0, 1, 2], [3, 4]]", 3).unwrap_err().to_string();
        assert!(error.contains("[1]: found an array of 2; expected 3 numbers"), "{error}");
    }

    #[test]
    fn faults_are_named() {
        for (text, expected) in [
            (
                "{\n\"waypoints\": [[0, 0],\n [1, null]]}",
                "line 3, column 6, waypoints[1][1]: found null",
            ),
            (
                "{\"waypoints\": [[0, 0], [2e9, 1]]}",
                "waypoints[1][0]: found 2000000000; expected a number of",
            ),
            (
                "{\"waypoints\": [[0, 0], [1]]}",
                "waypoints[1]: found an array of 1; expected a point",
            ),
            (
                "{\"waypoints\": [[0, 0]]}",
                "waypoints: found 1 points; expected an array of at least 2",
            ),
            ("{\"waypoints\": 3}", "waypoints: found 3; expected an array of at least 2 points"),
            ("{}", "found no field \"waypoints\""),
            ("[]", "found 0 points"),
            ("7", "plan JSON, line 1, column 1"),
            ("x", "plan JSON, line 1, column 1"),
        ] {
            let error = read_waypoints(text, 2).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        }
    }
}
