//! Problems for robots with joints: random scenes in the manner of MotionBenchMaker ([`Family`]) with a start and a goal
//! that the robot can take, and planar arms among boxes.
//!
//! Problem i of a seed has streams of its own; the scenes that are looked at for it are numbered by it. A problem is kept as
//! soon as both ends are free; whether there is a way between them is not looked at.

use std::collections::HashMap;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::arm::certificate::Certifier;
use crate::arm::{Arm, Body, BodyShape, Joint, JointKind, Limits, Link, Model, Tool};
use crate::error::InvalidInput;
use crate::optimizer::Method;
use crate::plan::rrt_connect::RrtConnect;
use crate::plan::{Options, Planner, parallel, plan};
use crate::profile::Profile;
use crate::rng::{Purpose, stream};
use crate::scene::{Query, Setting, Task};
use crate::space::generate::Family;
use crate::space::{Pose, World};
use std::sync::Arc;

/// A named distribution of problems.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ArmSuite {
    /// Boxes around a planar arm.
    PlanarArm,
    /// Those whose straight line is not free, and for which RRT-Connect finds a way.
    PlanarBlocked,
    /// Those of them that CHOMP does not solve from the straight line.
    PlanarHard,
    /// Shelves of three kinds in turn.
    Shelf,
    /// Above and under a crowded table, in turn.
    Table,
    /// One family of scenes.
    Of(Family),
}

/// Scenes that are looked at for one problem.
const MOST_SCENES: u64 = 100;
/// Starts of the inverse kinematics for one pose.
const IK_STARTS: usize = 12;
/// Configurations that are drawn for an end in one scene.
const DRAWS: usize = 200;
/// How far a joint may stand from the middle of its limits at the start, as a share of them.
const NEAR_REST: f64 = 0.12;

impl ArmSuite {
    /// All suites with their names.
    pub const NAMES: [(&'static str, Self); 12] = [
        ("planar-arm", Self::PlanarArm),
        ("planar-arm-blocked", Self::PlanarBlocked),
        ("planar-arm-hard", Self::PlanarHard),
        ("box", Self::Of(Family::Box)),
        ("shelf", Self::Shelf),
        ("table", Self::Table),
        ("cage", Self::Of(Family::Cage)),
        ("bookshelf_small", Self::Of(Family::BookshelfSmall)),
        ("bookshelf_tall", Self::Of(Family::BookshelfTall)),
        ("bookshelf_thin", Self::Of(Family::BookshelfThin)),
        ("table_pick", Self::Of(Family::TablePick)),
        ("table_under_pick", Self::Of(Family::TableUnderPick)),
    ];

    /// The suite's name.
    pub fn name(&self) -> &'static str {
        Self::NAMES.iter().find(|(_, suite)| suite == self).map_or("", |&(name, _)| name)
    }

    /// The family of a problem's scene.
    fn family(&self, index: u64) -> Family {
        let of = |families: &[Family]| families[(index % families.len() as u64) as usize];
        match self {
            Self::PlanarArm | Self::PlanarBlocked | Self::PlanarHard => Family::PlanarBoxes,
            Self::Shelf => {
                of(&[Family::BookshelfSmall, Family::BookshelfTall, Family::BookshelfThin])
            }
            Self::Table => of(&[Family::TablePick, Family::TableUnderPick]),
            Self::Of(family) => *family,
        }
    }

    /// Whether the suite makes its own robot, a planar arm.
    pub fn is_planar(&self) -> bool {
        self.family(0) == Family::PlanarBoxes
    }

    /// The first `count` problems of a seed, the same on every machine and for every number of threads. `tool` is what
    /// reaches for things, its frame's x forwards and its origin where a hand begins; without one, and for planar arms,
    /// goals are drawn as configurations. The scenes stand on a floor z = 0, and the robot's base `base_height` metres above
    /// it: where none is given, 0.9 for a box, which is reached into from above, 0.2 for a cage and else 0. Calls `kept` from
    /// any thread for each problem.
    ///
    /// # Errors
    /// If the robot has no such link, the height is not finite, or no scene of 100 has free ends: the robot may be too
    /// short for them, or stand in them.
    pub fn generate(
        &self,
        arm: &Arc<Arm>,
        tool: Option<&Tool>,
        base_height: Option<f64>,
        count: usize,
        seed: u64,
        kept: &(dyn Fn() + Sync),
    ) -> Result<Vec<ArmProblem>, InvalidInput> {
        let drawn = parallel::map(count, |index| {
            let problem = self.problem(arm, tool, base_height, seed, index as u64);
            kept();
            problem
        });
        drawn.into_iter().collect()
    }

    /// Problem `index` of a seed: that of [`Self::generate`].
    ///
    /// # Errors
    /// As [`Self::generate`].
    pub fn problem(
        &self,
        arm: &Arc<Arm>,
        tool: Option<&Tool>,
        base_height: Option<f64>,
        seed: u64,
        index: u64,
    ) -> Result<ArmProblem, InvalidInput> {
        let family = self.family(index);
        let usual = match family {
            Family::Box => 0.9,
            Family::Cage => 0.2,
            _ => 0.0,
        };
        let offset = [0.0, 0.0, -base_height.unwrap_or(usual)];
        let mut rng = stream(seed, Purpose::Query, index, 1);
        for attempt in 0..MOST_SCENES {
            let scene = family.generate(seed, index * MOST_SCENES + attempt, offset)?;
            let world = Arc::new(scene.world);
            let ends = Ends { certifier: Certifier::new(arm.clone(), world.clone()), tool };
            let goal = ends.toward(&scene.goals, &mut rng)?;
            let Some(goal) = goal else { continue };
            let start = match scene.starts.is_empty() || tool.is_none() {
                true => ends.near_rest(&mut rng),
                false => ends.toward(&scene.starts, &mut rng)?,
            };
            let Some(start) = start.filter(|start| *start != goal) else { continue };
            let name = format!("{}/{index}", family.name());
            let problem = ArmProblem { name, world, start, goal };
            if self.takes(arm, &problem, &mut rng)? {
                return Ok(problem);
            }
        }
        let found = format!("{} for {}", self.name(), arm.name());
        let allowed = format!(
            "a robot that reaches what there is to reach without standing in it, in one of {MOST_SCENES} scenes"
        );
        Err(InvalidInput::new("suite", found, allowed))
    }
}

/// Samples of RRT-Connect, twice, before a problem counts as unsolved.
const SAMPLES: usize = 20_000;
/// Steps that CHOMP has, and its step: the best of several for planar arms of four joints on seed 7.
const CHOMP: (usize, f32) = (100, 0.02);

impl ArmSuite {
    /// Whether a problem with free ends is one of the suite's.
    fn takes(
        &self,
        arm: &Arc<Arm>,
        problem: &ArmProblem,
        rng: &mut ChaCha8Rng,
    ) -> Result<bool, InvalidInput> {
        if !matches!(self, Self::PlanarBlocked | Self::PlanarHard) {
            return Ok(true);
        }
        let ArmProblem { name, world, start, goal } = problem.clone();
        let task = Task::new(name, Setting::Arm { arm: arm.clone(), world }, start, goal)?;
        let query = Query::of(&task, &Profile::DEFAULT);
        if query.scene().motion_is_free(query.start(), query.goal()) {
            return Ok(false);
        }
        if *self == Self::PlanarHard {
            let chomp = Planner::Optimizer(Method::Chomp { step: Some(CHOMP.1) });
            let options = Options { steps: CHOMP.0, ..Options::default() };
            if plan(&task, &chomp, &options)?.is_solved() {
                return Ok(false);
            }
        }
        let trees =
            RrtConnect { max_samples: SAMPLES, shortcut_rounds: 0, ..RrtConnect::default() };
        Ok((0..2).any(|_| trees.plan(&query, rng).trajectory.is_some()))
    }
}

impl std::str::FromStr for ArmSuite {
    type Err = InvalidInput;

    /// The suite of that name.
    fn from_str(name: &str) -> Result<Self, InvalidInput> {
        let found = Self::NAMES.iter().find(|(known, _)| *known == name);
        let unknown = || InvalidInput::unknown("suite", name, &Self::NAMES.map(|(known, _)| known));
        found.map(|&(_, suite)| suite).ok_or_else(unknown)
    }
}

/// A world, and two configurations that are free in it.
#[derive(Debug, Clone)]
pub struct ArmProblem {
    /// Such as `cage/3`.
    pub name: String,
    /// What is around the robot, in the frame of its base.
    pub world: Arc<World>,
    /// Where it starts: a number for each joint, rad or m.
    pub start: Vec<f64>,
    /// Where it should go.
    pub goal: Vec<f64>,
}

/// Looks for free configurations in one scene.
struct Ends<'a> {
    certifier: Certifier,
    tool: Option<&'a Tool>,
}

impl Ends<'_> {
    fn is_free(&self, q: &[f64]) -> bool {
        self.certifier.motion_is_free(q, q, &mut self.certifier.work())
    }

    /// A free configuration that puts the tool at one of the poses; without a tool, any free one.
    fn toward(
        &self,
        poses: &[Pose],
        rng: &mut ChaCha8Rng,
    ) -> Result<Option<Vec<f64>>, InvalidInput> {
        let arm = self.certifier.arm();
        let Some(tool) = self.tool.filter(|_| !poses.is_empty()) else {
            let mut drawn = (0..DRAWS).map(|_| arm.drawn(rng));
            return Ok(drawn.find(|q| self.is_free(q)));
        };
        let pose = &poses[rng.random_range(0..poses.len())];
        let found = arm.inverse_kinematics(tool, pose, IK_STARTS, rng)?;
        Ok(found.into_iter().find(|q| self.is_free(q)))
    }

    /// A free configuration around the middle of the limits.
    fn near_rest(&self, rng: &mut ChaCha8Rng) -> Option<Vec<f64>> {
        let arm = self.certifier.arm();
        let share = if self.tool.is_some() { NEAR_REST } else { 0.5 };
        let mut drawn = (0..DRAWS).map(|_| {
            let place = |joint: &crate::arm::ArmJoint| {
                let (middle, size) = (0.5 * (joint.lower + joint.upper), joint.upper - joint.lower);
                middle + share * size * (2.0 * rng.random::<f64>() - 1.0)
            };
            arm.joints().iter().map(place).collect::<Vec<f64>>()
        });
        drawn.find(|q| self.is_free(q))
    }
}

/// Most links of [`planar_arm`].
pub const MAX_PLANAR: usize = 16;
/// Half the width of a planar arm.
const THICK: f64 = 0.02;
/// Distance between the spheres of a planar arm.
const SPACING: f64 = 0.02;
/// How far a planar arm's joints turn to either side, rad.
const TURN: f64 = 2.9;

/// An arm of so many equal links in the plane z = 0, of reach 1: joints `joint_1`, .. that turn by 2.9 rad to either side,
/// bodies of spheres 2 cm thick, no faster than 2 rad/s.
///
/// # Errors
/// If there is no link or more than [`MAX_PLANAR`].
pub fn planar_arm(count: usize) -> Result<Model, InvalidInput> {
    if !(1..=MAX_PLANAR).contains(&count) {
        return Err(InvalidInput::new("links", count, format!("1 to {MAX_PLANAR}")));
    }
    // The tip's ball ends at 1.
    let length = (1.0 - THICK) / count as f64;
    let balls = (length / SPACING).ceil() as usize;
    let body = |i: usize| -> Result<Body, InvalidInput> {
        let center = [length * i as f64 / balls as f64, 0.0, 0.0];
        Ok(Body { origin: Pose::at(center)?, shape: BodyShape::Sphere { radius: THICK } })
    };
    let mut links = vec![Link { name: "base".into(), bodies: Vec::new() }];
    let mut joints = Vec::new();
    for i in 0..count {
        let bodies = (0..=balls).map(body).collect::<Result<_, _>>()?;
        links.push(Link { name: format!("link_{}", i + 1), bodies });
        let at = [if i == 0 { 0.0 } else { length }, 0.0, 0.0];
        let (lower, upper) = (-TURN, TURN);
        joints.push(Joint {
            name: format!("joint_{}", i + 1),
            kind: JointKind::Revolute,
            parent: i,
            child: i + 1,
            origin: Pose::at(at)?,
            axis: [0.0, 0.0, 1.0],
            limits: Some(Limits { lower, upper, velocity: Some(2.0), effort: None }),
            mimic: None,
        });
    }
    Model::new(format!("planar arm of {count}"), links, joints)
}

/// [`planar_arm`] compiled, whose links must not touch each other but for neighbours.
///
/// # Errors
/// If there is no link or more than [`MAX_PLANAR`].
pub fn planar_arm_alone(count: usize) -> Result<Arm, InvalidInput> {
    let arm = Arm::new(&planar_arm(count)?, &[], &HashMap::new())?;
    let next = |i: usize| (format!("link_{i}"), format!("link_{}", i + 1));
    arm.with_self_collisions(&(1..count).map(next).collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn planar(count: usize) -> Arc<Arm> {
        Arc::new(planar_arm_alone(count).unwrap())
    }

    #[test]
    fn ends_are_free_and_do_not_depend_on_threads() {
        let arm = planar(3);
        assert!((arm.reach() - 1.0).abs() < 1e-6, "{}", arm.reach());
        let draw = |threads, seed| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                ArmSuite::PlanarArm.generate(&arm, None, None, 12, seed, &|| {}).unwrap()
            })
        };
        let (one, three, other) = (draw(1, 7), draw(3, 7), draw(1, 8));
        for (a, b) in one.iter().zip(&three) {
            assert_eq!((&a.start, &a.goal, &*a.world), (&b.start, &b.goal, &*b.world));
            let certifier = Certifier::new(arm.clone(), a.world.clone());
            for end in [&a.start, &a.goal] {
                assert!(certifier.motion_is_free(end, end, &mut certifier.work()));
            }
        }
        assert_ne!(one[0].start, other[0].start);
        assert!(one.iter().any(|problem| !problem.world.objects().is_empty()));
    }

    #[test]
    fn problems_that_are_blocked_and_hard_are_what_they_say() {
        let arm = planar(3);
        for (suite, steps) in [(ArmSuite::PlanarBlocked, 1), (ArmSuite::PlanarHard, 100)] {
            for problem in suite.generate(&arm, None, None, 4, 1001, &|| {}).unwrap() {
                let setting = Setting::Arm { arm: arm.clone(), world: problem.world };
                let task = Task::new("", setting, problem.start, problem.goal).unwrap();
                let options = Options { steps, ..Options::default() };
                let chomp = Planner::Optimizer(Method::Chomp { step: Some(CHOMP.1) });
                let tried = plan(&task, &chomp, &options).unwrap();
                assert!(tried.steps > 0 && (steps == 1 || !tried.is_solved()), "{tried:?}");
                assert!(plan(&task, &Planner::default(), &options).unwrap().is_solved());
            }
        }
    }

    #[test]
    fn a_robot_that_reaches_nothing_is_refused() {
        let arm = planar(2);
        let tool = Tool { link: "link_2".into(), frame: Pose::IDENTITY };
        let cage = ArmSuite::Of(Family::Cage);
        let error = cage.generate(&arm, Some(&tool), Some(50.0), 1, 0, &|| {}).unwrap_err();
        assert_eq!(error.field, "suite");
        assert!(planar_arm(0).is_err() && planar_arm(17).is_err());
        assert_eq!("shelf".parse::<ArmSuite>().unwrap().name(), "shelf");
    }
}
