//! A question and the scene that it is asked in, bound together.

use std::sync::Arc;

use super::{Certified, Scene, Task};
use crate::error::InvalidInput;
use crate::profile::Profile;
use crate::trajectory::{Trajectory, Violation};

/// Start and goal in a prepared scene: what planners answer. Made from a task and a scene that belong together.
#[derive(Debug, Clone)]
pub struct Query {
    scene: Arc<Scene>,
    /// Start and goal, `[2 x dof]`.
    ends: Vec<f64>,
    terms: Vec<CostTerm>,
}

/// A cost of one's own, added to U: see [`Query::with_cost`].
#[derive(Clone)]
pub struct CostTerm(Arc<TermFunction>);

/// From start `[dof]`, waypoints `[N x dof]` and goal `[dof]`, in normalised units, to a cost; its slopes are added to the gradient
/// `[N x dof]`, where there is one.
type TermFunction = dyn Fn([&[f32]; 3], Option<&mut [f32]>) -> f32 + Send + Sync;

impl std::fmt::Debug for CostTerm {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("CostTerm(..)")
    }
}

impl CostTerm {
    /// The cost of the waypoints `x [N x dof]`; adds its slopes to `gradient [N x dof]`.
    pub fn add(&self, [start, x, goal]: [&[f32]; 3], gradient: Option<&mut [f32]>) -> f32 {
        self.0([start, x, goal], gradient)
    }
}

/// A trajectory that is not certified.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{violation}")]
pub struct Refused {
    /// The first violation found.
    pub violation: Violation,
    /// The trajectory.
    pub trajectory: Trajectory,
}

impl Query {
    /// The question of a task in its scene, prepared before.
    ///
    /// # Errors
    /// If the scene was prepared for another world or robot.
    pub fn new(scene: &Arc<Scene>, task: &Task) -> Result<Self, InvalidInput> {
        if !scene.serves(&task.setting) {
            return Err(InvalidInput::new("scene", &task.name, "the scene of the task's setting"));
        }
        Ok(Self::unchecked(scene.clone(), task))
    }

    /// The question of a task in a scene made for it.
    pub fn of(task: &Task, profile: &Profile) -> Self {
        Self::unchecked(Arc::new(Scene::of(task, profile)), task)
    }

    pub(super) fn unchecked(scene: Arc<Scene>, task: &Task) -> Self {
        Self { scene, ends: [&task.start[..], &task.goal].concat(), terms: Vec::new() }
    }

    /// The same question between two other configurations `[dof]`, in task units.
    pub(crate) fn between(&self, start: &[f64], goal: &[f64]) -> Self {
        Self { scene: self.scene.clone(), ends: [start, goal].concat(), terms: self.terms.clone() }
    }

    /// The same question with a cost of one's own in U besides obstacles and length. `term` sees start `[dof]`, waypoints `[N x dof]`
    /// and goal `[dof]` in normalised units, returns what they cost, and adds the slopes of that to the gradient `[N x dof]`
    /// where there is one. What is certified does not change, only what is preferred; planners that use no gradient
    /// of U (the shipped policies, RRT-Connect, the exact search) see it only where they choose between plans by U.
    /// `examples/own_cost.rs` is one.
    pub fn with_cost(
        mut self,
        term: impl Fn([&[f32]; 3], Option<&mut [f32]>) -> f32 + Send + Sync + 'static,
    ) -> Self {
        self.terms.push(CostTerm(Arc::new(term)));
        self
    }

    /// Costs of one's own.
    pub fn terms(&self) -> &[CostTerm] {
        &self.terms
    }

    /// The scene.
    pub fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    /// Start `[dof]`, in task units.
    pub fn start(&self) -> &[f64] {
        &self.ends[..self.ends.len() / 2]
    }

    /// Goal `[dof]`, in task units.
    pub fn goal(&self) -> &[f64] {
        &self.ends[self.ends.len() / 2..]
    }

    /// The straight line from start to goal.
    pub fn line(&self) -> Trajectory {
        Trajectory::new(self.ends.len() / 2, self.ends.clone())
    }

    /// Whether start and goal are themselves free.
    ///
    /// # Errors
    /// What is wrong with them.
    pub fn check_ends(&self) -> Result<(), Violation> {
        let stands = |end: &[f64]| self.scene.motion_is_free(end, end);
        if stands(self.start()) && stands(self.goal()) {
            return Ok(());
        }
        self.scene.check(&self.line())
    }

    /// Certifies a trajectory as an answer: free of collision, and exactly from start to goal. This is the only place where a
    /// [`Certified`] is made.
    ///
    /// # Errors
    /// The first violation found, with the trajectory.
    pub fn certify(&self, trajectory: Trajectory) -> Result<Certified, Refused> {
        let mut configurations = trajectory.configurations();
        let (first, last) = (configurations.next(), trajectory.configurations().next_back());
        let checked = match (first, last) {
            (Some(first), _) if first != self.start() => Err(Violation::WrongStart),
            (_, Some(last)) if last != self.goal() => Err(Violation::WrongGoal),
            _ if self.scene.is_free(&trajectory) => Ok(()),
            _ => self.scene.check(&trajectory),
        };
        match checked {
            Ok(()) => Ok(Certified(trajectory)),
            Err(violation) => Err(Refused { violation, trajectory }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::geometry::Rect;
    use crate::{Robot, World};

    fn task() -> Task {
        let bounds = Rect::new([0.0; 2], [10.0; 2]).unwrap();
        let world = Arc::new(World::new(bounds, Vec::new(), None));
        Task::in_plane("t", world, Robot::Point, [1.0, 1.0], [9.0, 9.0]).unwrap()
    }

    #[test]
    fn a_query_certifies_its_own_ends_only() {
        let query = Query::of(&task(), &Profile::DEFAULT);
        let check = |points: &[[f64; 2]], expected| {
            let answer = query.certify(Trajectory::from_points(points));
            assert_eq!(answer.map(|_| ()).map_err(|refused| refused.violation), expected);
        };
        check(&[[1.0, 1.0], [9.0, 9.0]], Ok(()));
        check(&[[1.0, 1.1], [9.0, 9.0]], Err(Violation::WrongStart));
        check(&[[1.0, 1.0]], Err(Violation::WrongGoal));
        check(&[], Err(Violation::EmptyTrajectory));
    }

    #[test]
    fn a_scene_answers_no_task_of_another_world() {
        let scene = Arc::new(Scene::of(&task(), &Profile::DEFAULT));
        // An equal world, but another one: what is prepared for a world is not looked up by its looks.
        let refused = Query::new(&scene, &task()).unwrap_err();
        assert_eq!((refused.field.as_str(), refused.value.as_str()), ("scene", "t"));
    }
}
