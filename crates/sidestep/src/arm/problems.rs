//! Problems in random scenes: a start and a goal that a robot can stand at.
//!
//! In the manner of MotionBenchMaker (`space/generate.rs` has the source): the tool is put where a
//! scene says by inverse kinematics, and what collides is drawn anew. Where a scene names no such
//! place, as around a planar arm, ends are drawn within the limits.

use std::sync::Arc;

use super::certificate::{Certifier, Work};
use super::inverse_kinematics::Tool;
use super::robot::Arm;
use crate::error::InvalidInput;
use crate::rng::{Purpose, stream};
use crate::space::generate::Family;
use crate::space::vector::Vector;
use crate::space::{Pose, World};

/// Scenes drawn for one problem before it is given up.
const SCENES: u64 = 50;
/// Starts of the inverse kinematics for each place.
const STARTS: usize = 8;
/// Configurations drawn for an end without a place.
const DRAWS: usize = 200;

/// How a robot meets scenes.
#[derive(Debug, Clone, PartialEq)]
pub struct Placement {
    /// What grasps: its x points at what is grasped.
    pub tool: Tool,
    /// Shifts the scenes for a robot whose base is not on the floor, metres.
    pub offset: Vector,
    /// Where the robot rests: the start wherever it is free and a scene does not say another.
    pub rest: Option<Vec<f64>>,
}

/// A world with two ends.
#[derive(Debug, Clone)]
pub struct SceneProblem {
    /// The scene's name.
    pub name: String,
    /// What is around the robot.
    pub world: Arc<World>,
    /// A free configuration.
    pub start: Vec<f64>,
    /// Another one.
    pub goal: Vec<f64>,
}

impl Arm {
    /// Problem number `index` of a family and a seed, the same on every machine but for the last
    /// bits of its mathematics library; nothing if fifty scenes had no free ends. Both ends are
    /// proved free; whether there is a way is not known.
    ///
    /// # Errors
    /// If the placement names no link of the robot, or its offset or rest are not allowed.
    pub fn scene_problem(
        self: &Arc<Self>,
        family: Family,
        placement: &Placement,
        seed: u64,
        index: u64,
    ) -> Result<Option<SceneProblem>, InvalidInput> {
        if let Some(rest) = &placement.rest {
            self.check("rest", rest)?;
        }
        for attempt in 0..SCENES {
            let scene = family.generate(seed, index * SCENES + attempt, placement.offset)?;
            let mut rng = stream(seed, Purpose::Query, index, attempt);
            let world = Arc::new(scene.world);
            let certifier = Certifier::new(Arc::clone(self), Arc::clone(&world));
            let mut work = certifier.work();
            let mut place = |places: &[Pose], work: &mut Work| -> Result<Option<Vec<f64>>, _> {
                let free = |q: &Vec<f64>, work: &mut Work| certifier.motion_is_free(q, q, work);
                if places.is_empty() {
                    let mut draws = (0..DRAWS).map(|_| self.drawn(&mut rng));
                    return Ok(draws.find(|q| free(q, work)));
                }
                for pose in places {
                    let found = self.inverse_kinematics(&placement.tool, pose, STARTS, &mut rng)?;
                    if let Some(q) = found.into_iter().find(|q| free(q, work)) {
                        return Ok(Some(q));
                    }
                }
                Ok::<_, InvalidInput>(None)
            };
            let Some(goal) = place(&scene.goals, &mut work)? else { continue };
            let rests = placement.rest.clone().filter(|_| scene.starts.is_empty());
            let start = match rests {
                Some(rest) => certifier.motion_is_free(&rest, &rest, &mut work).then_some(rest),
                None => place(&scene.starts, &mut work)?,
            };
            if let Some(start) = start {
                return Ok(Some(SceneProblem { name: scene.name, world, start, goal }));
            }
        }
        Ok(None)
    }
}

#[cfg(test)]
mod tests {
    use super::super::inverse_kinematics::tests::six_joints;
    use super::*;

    #[test]
    fn ends_are_free_and_where_they_should_be() {
        let arm = Arc::new(six_joints());
        let tool = Tool { link: "gripper".into(), frame: Pose::IDENTITY };
        let placement = Placement { tool, offset: [0.1, 0.0, -0.7], rest: None };
        for family in [Family::TablePick, Family::TableUnderPick, Family::BookshelfSmall] {
            let mut made = 0;
            for index in 0..5 {
                let found = arm.scene_problem(family, &placement, 3, index).unwrap();
                let Some(problem) = found else { continue };
                made += 1;
                let certifier = Certifier::new(Arc::clone(&arm), Arc::clone(&problem.world));
                let mut work = certifier.work();
                for end in [&problem.start, &problem.goal] {
                    assert!(certifier.motion_is_free(end, end, &mut work));
                }
                let again = arm.scene_problem(family, &placement, 3, index).unwrap().unwrap();
                assert_eq!((&again.start, &again.goal), (&problem.start, &problem.goal));
            }
            assert!(made >= 3, "{}: {made}", family.name());
        }
        let rest = Some(vec![9.0; 6]);
        let error = arm.scene_problem(Family::Cage, &Placement { rest, ..placement }, 3, 0);
        assert_eq!(error.unwrap_err().field, "rest.joint 0");
    }
}
