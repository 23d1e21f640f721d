//! What a world, a robot and a profile prepare once, for every task there.

use std::sync::{Arc, OnceLock};

use crate::plane::certificate::Certifier;
use crate::plane::distance::Field;
use crate::plane::sampled_check::SampledCheck;
use crate::plane::shortest_path::ShortestPath;
use crate::plane::world::World;
use crate::profile::{DistanceKind, Feasibility, Frame, Profile};
use crate::robot::Robot;
use crate::task::Task;

/// A world of more shapes than this is a map.
pub const MOST_SHAPES_OF_A_FIELD: usize = 32;

/// All that a world, a robot and a profile determine, shared by every task and start in it. What
/// only some planners use is prepared when it is first asked for.
#[derive(Debug)]
pub struct Scene {
    world: Arc<World>,
    robot: Robot,
    pub(super) profile: Profile,
    pub(super) frame: Frame,
    field_size: [f32; 2],
    field: OnceLock<Field>,
    exact_field: OnceLock<Field>,
    typical_clearance: OnceLock<f64>,
    pub(super) sampled: Option<SampledCheck>,
    pub(super) certifier: Certifier,
    exact: OnceLock<ShortestPath>,
}

impl Scene {
    /// Prepares the checks.
    pub fn new(world: &Arc<World>, robot: Robot, profile: &Profile) -> Self {
        let frame = profile.frame(world.bounds());
        let sampled = match profile.feasibility {
            Feasibility::Sampled { substeps } => {
                Some(SampledCheck::new(world, robot, &frame, substeps))
            }
            Feasibility::Exact => None,
        };
        Self {
            world: world.clone(),
            robot,
            profile: profile.clone(),
            frame,
            field_size: world.bounds().size().map(|side| (side / frame.scale) as f32),
            field: OnceLock::new(),
            exact_field: OnceLock::new(),
            typical_clearance: OnceLock::new(),
            sampled,
            certifier: Certifier::new(world, robot),
            exact: OnceLock::new(),
        }
    }

    /// The scene of a task's world and robot.
    pub fn of(task: &Task, profile: &Profile) -> Self {
        Self::new(&task.world, task.robot, profile)
    }

    /// The profile that the scene was built for.
    pub fn profile(&self) -> &Profile {
        &self.profile
    }

    /// The map between task units and normalised units.
    pub fn frame(&self) -> Frame {
        self.frame
    }

    /// The world's bounds, in task units.
    pub fn bounds(&self) -> crate::plane::geometry::Rect {
        self.world.bounds()
    }

    /// Width and height of the bounds, in normalised units.
    pub fn field_size(&self) -> [f32; 2] {
        self.field_size
    }

    /// The signed distance field.
    pub fn field(&self) -> &Field {
        self.field.get_or_init(|| Field::new(&self.world, self.robot, &self.profile))
    }

    /// The exact signed distance field, whatever the profile's own is.
    pub fn exact_field(&self) -> &Field {
        match self.profile.distance {
            DistanceKind::Exact => self.field(),
            DistanceKind::PaperImage => {
                self.exact_field.get_or_init(|| Field::exact(&self.world, self.robot, &self.frame))
            }
        }
    }

    /// Half the width of a typical passage: the median distance over the free space, in normalised
    /// units.
    pub fn typical_clearance(&self) -> f64 {
        let clearance = || self.field().typical_clearance(self.field_size).into();
        *self.typical_clearance.get_or_init(clearance)
    }

    /// The clearance ε under which a point is penalised: the profile's, and on a map at most the
    /// typical clearance. A map is a world with a grid or more than [`MOST_SHAPES_OF_A_FIELD`]
    /// shapes; on one, the profile's ε would reach through walls into the next passage.
    pub fn epsilon(&self) -> f64 {
        let is_map =
            self.world.grid().is_some() || self.world.obstacles().len() > MOST_SHAPES_OF_A_FIELD;
        let epsilon = self.profile.epsilon;
        if !(is_map && self.profile.fits_epsilon_to_maps) {
            return epsilon;
        }
        match self.typical_clearance() {
            clearance if clearance > 0.0 => epsilon.min(clearance),
            _ => epsilon,
        }
    }

    /// The exact search; what it prepares is shared by all that ask for it.
    pub fn shortest_path(&self) -> ShortestPath {
        self.exact.get_or_init(|| ShortestPath::of(self.certifier.clone())).clone()
    }

    /// The exact certificate.
    pub fn certifier(&self) -> &Certifier {
        &self.certifier
    }
}
