//! What a world, a robot in the plane and a profile prepare once, for every task there.

use std::sync::{Arc, OnceLock};

use crate::kernels::{Block, LANES, clearance};
use crate::plane::Robot;
use crate::plane::certificate::Certifier;
use crate::plane::distance::{Field, Samples};
use crate::plane::frame::Frame;
use crate::plane::geometry::{Point, Rect};
use crate::plane::sampled_check::SampledCheck;
use crate::plane::shortest_path::ShortestPath;
use crate::plane::world::{Obstacle, World};
use crate::profile::{DistanceKind, Feasibility, Profile};

/// A world of more shapes than this is a map.
pub const MOST_SHAPES_OF_A_FIELD: usize = 32;

/// All that a world, a robot and a profile determine, shared by every task and start in it. What
/// only some planners use is prepared when it is first asked for.
#[derive(Debug)]
pub struct PlaneScene {
    world: Arc<World>,
    robot: Robot,
    profile: Profile,
    frame: Frame,
    limits: [[f64; 2]; 2],
    normalised_limits: [[f32; 2]; 2],
    own: Arc<Prepared>,
    /// The map's, where obstacles were added to one.
    map: Option<Arc<Prepared>>,
    typical_clearance: OnceLock<f64>,
    sampled: Option<SampledCheck>,
}

/// What scenes of a map with more obstacles on it share with the map's own.
#[derive(Debug)]
struct Prepared {
    certifier: Certifier,
    field: OnceLock<Field>,
    exact_field: OnceLock<Field>,
    exact: OnceLock<ShortestPath>,
}

impl Prepared {
    fn new(certifier: Certifier) -> Self {
        let (field, exact_field, exact) = Default::default();
        Self { certifier, field, exact_field, exact }
    }
}

impl PlaneScene {
    /// Prepares the checks.
    pub fn new(world: &Arc<World>, robot: Robot, profile: &Profile) -> Self {
        let own = Arc::new(Prepared::new(Certifier::new(world, robot)));
        Self::of(world, robot, profile, own, None)
    }

    /// The scene with more obstacles. What this scene has prepared, or prepares later, of its own world is shared, so that they
    /// cost what they cost and not what the world costs.
    pub fn with_obstacles(&self, more: &[Obstacle]) -> Self {
        let obstacles = [self.world.obstacles(), more].concat();
        let bounds = self.world.bounds();
        let world = Arc::new(World::new(bounds, obstacles, self.world.grid().cloned()));
        let map = self.map.as_ref().unwrap_or(&self.own);
        match map.certifier.over(&world, self.robot) {
            Some(certifier) => {
                let own = Arc::new(Prepared::new(certifier));
                Self::of(&world, self.robot, &self.profile, own, Some(map.clone()))
            }
            // Their coordinates ask for another tolerance.
            None => Self::new(&world, self.robot, &self.profile),
        }
    }

    fn of(
        world: &Arc<World>,
        robot: Robot,
        profile: &Profile,
        own: Arc<Prepared>,
        map: Option<Arc<Prepared>>,
    ) -> Self {
        let frame = Frame::new(profile, world.bounds());
        let sampled = match profile.feasibility {
            Feasibility::Sampled { substeps } => {
                Some(SampledCheck::new(world, robot, &frame, substeps))
            }
            Feasibility::Exact => None,
        };
        let Rect { min, max } = own.certifier.bounds();
        let size = world.bounds().size();
        Self {
            world: world.clone(),
            robot,
            profile: profile.clone(),
            frame,
            limits: [0, 1].map(|axis| [min[axis], max[axis]]),
            normalised_limits: size.map(|side| [0.0, (side / frame.scale) as f32]),
            own,
            map,
            typical_clearance: OnceLock::new(),
            sampled,
        }
    }

    /// The world.
    pub fn world(&self) -> &Arc<World> {
        &self.world
    }

    /// The robot.
    pub fn robot(&self) -> Robot {
        self.robot
    }

    /// The profile that the scene was built for.
    pub fn profile(&self) -> &Profile {
        &self.profile
    }

    /// The map between task units and normalised units.
    pub fn frame(&self) -> Frame {
        self.frame
    }

    /// Least and greatest x and y where the robot may be, in task units.
    pub fn limits(&self) -> &[[f64; 2]; 2] {
        &self.limits
    }

    /// 0 to width and 0 to height of the bounds, in normalised units.
    pub fn normalised_limits(&self) -> &[[f32; 2]; 2] {
        &self.normalised_limits
    }

    /// The signed distance field.
    pub fn field(&self) -> &Field {
        self.field_while(&|| true).expect("nobody breaks off")
    }

    /// Prepares the field, unless `go_on` becomes false meanwhile; whether it is prepared.
    pub fn prepare_field(&self, go_on: &(dyn Fn() -> bool + Sync)) -> bool {
        self.field_while(go_on).is_some()
    }

    fn field_while(&self, go_on: &(dyn Fn() -> bool + Sync)) -> Option<&Field> {
        match self.profile.distance {
            DistanceKind::Exact => self.exact_field_while(|prepared| &prepared.field, go_on),
            DistanceKind::PaperImage => {
                let new = || Field::new_while(&self.world, self.robot, &self.profile, go_on);
                once(&self.own.field, new)
            }
        }
    }

    /// The exact signed distance field, whatever the profile's own is.
    pub fn exact_field(&self) -> &Field {
        match self.profile.distance {
            DistanceKind::Exact => self.field(),
            DistanceKind::PaperImage => self
                .exact_field_while(|prepared| &prepared.exact_field, &|| true)
                .expect("nobody breaks off"),
        }
    }

    fn exact_field_while(
        &self,
        of: impl Fn(&Prepared) -> &OnceLock<Field>,
        go_on: &(dyn Fn() -> bool + Sync),
    ) -> Option<&Field> {
        once(of(&self.own), || {
            let Some(map) = &self.map else {
                return Field::exact_while(&self.world, self.robot, &self.frame, go_on);
            };
            let known = map.certifier.obstacles().len();
            let (obstacles, bounds) = (self.world.obstacles(), self.world.bounds());
            let whole = || {
                let grid = self.world.grid().cloned();
                let world = World::new(bounds, obstacles[..known].to_vec(), grid);
                Field::exact_while(&world, self.robot, &self.frame, go_on)
            };
            once(of(map), whole)?.with(&obstacles[known..], &self.frame, go_on)
        })
    }

    /// Half the width of a typical passage: the median distance over the free space, in normalised
    /// units.
    pub fn typical_clearance(&self) -> f64 {
        let size = self.normalised_limits.map(|[_, most]| most);
        let clearance = || self.field().typical_clearance(size).into();
        *self.typical_clearance.get_or_init(clearance)
    }

    /// Whether the world is a map: it has a grid, or more than [`MOST_SHAPES_OF_A_FIELD`] shapes.
    pub fn is_map(&self) -> bool {
        self.world.grid().is_some() || self.world.obstacles().len() > MOST_SHAPES_OF_A_FIELD
    }

    /// The clearance ε under which a point is penalised: the profile's, and on a map at most the
    /// typical clearance. A map is a world with a grid or more than [`MOST_SHAPES_OF_A_FIELD`]
    /// shapes; on one, the profile's ε would reach through walls into the next passage.
    pub fn epsilon(&self) -> f64 {
        let epsilon = self.profile.epsilon;
        if !(self.is_map() && self.profile.fits_epsilon_to_maps) {
            return epsilon;
        }
        match self.typical_clearance() {
            clearance if clearance > 0.0 => epsilon.min(clearance),
            _ => epsilon,
        }
    }

    /// The exact search; what it prepares is shared by all that ask for it.
    pub fn shortest_path(&self) -> ShortestPath {
        self.shortest_path_while(&|| true).expect("nobody breaks off")
    }

    /// [`PlaneScene::shortest_path`]; none where `go_on` becomes false while it is prepared.
    pub fn shortest_path_while(&self, go_on: &dyn Fn() -> bool) -> Option<ShortestPath> {
        let certifier = || self.own.certifier.clone();
        let exact = once(&self.own.exact, || match &self.map {
            None => ShortestPath::of_while(certifier(), go_on),
            Some(map) => once(&map.exact, || ShortestPath::of_while(map.certifier.clone(), go_on))?
                .over_while(certifier(), go_on),
        });
        exact.cloned()
    }

    /// The exact certificate.
    pub fn certifier(&self) -> &Certifier {
        &self.own.certifier
    }

    /// The profile's check by samples; none where feasible means certified.
    pub fn sampled_check(&self) -> Option<&SampledCheck> {
        self.sampled.as_ref()
    }

    /// Whether the robot may move from `start` over the waypoints `x [N x 2]`, in normalised units, to `goal`. Writes to
    /// `free [N + 1]` which segments it may move along; without it the first one that it may not ends the check.
    pub fn path_is_free(
        &self,
        start: Point,
        x: &[f32],
        goal: Point,
        free: Option<&mut [bool]>,
    ) -> bool {
        let (mut from, mut all) = (start, true);
        let waypoints = x.as_chunks::<2>().0;
        let to = |segment: usize| waypoints.get(segment).map_or(goal, |p| self.frame.to_task(*p));
        match free {
            Some(free) => {
                for (segment, free) in free.iter_mut().enumerate() {
                    let to = to(segment);
                    *free = self.own.certifier.segment_is_free(from, to);
                    all &= *free;
                    from = to;
                }
            }
            None => {
                for segment in 0..=waypoints.len() {
                    let to = to(segment);
                    if !self.own.certifier.segment_is_free(from, to) {
                        return false;
                    }
                    from = to;
                }
            }
        }
        all
    }

    /// Obstacle costs c(D) of the points of a block, and their weighted slopes where asked for.
    #[inline(always)]
    pub(crate) fn cost_and_slope(
        &self,
        block: &mut Block,
        epsilon: f32,
        factor: f32,
        slopes: bool,
    ) {
        let Block { count, padded, points, weights, distances, costs, slopes: gradients, .. } =
            block;
        let (x, y) = points.split_at(*padded);
        let (gradient_x, gradient_y) = gradients.split_at_mut(*padded);
        let mut samples = Samples { distance: distances, gradient_x, gradient_y };
        self.field().sample(x, y, *count, &mut samples);
        let Samples { distance, gradient_x, gradient_y } = samples;
        for first in (0..*padded).step_by(LANES) {
            let range = first..first + LANES;
            let distance = &distance[range.clone()];
            let costs = &mut costs[range.clone()];
            for l in 0..LANES {
                costs[l] = clearance::cost(epsilon, distance[l]);
            }
            if slopes {
                let weights = &weights[range.clone()];
                let (x, y) = (&mut gradient_x[range.clone()], &mut gradient_y[range]);
                for l in 0..LANES {
                    let slope = clearance::slope(epsilon, distance[l]) * factor * weights[l];
                    x[l] *= slope;
                    y[l] *= slope;
                }
            }
        }
    }
}

/// What is prepared once, unless it is broken off. Whoever is first keeps its own, which is the same.
fn once<T>(cell: &OnceLock<T>, new: impl FnOnce() -> Option<T>) -> Option<&T> {
    if cell.get().is_none() {
        let _ = cell.set(new()?);
    }
    cell.get()
}

/// One question in the plane as a policy sees it: the scene, and the ends of trajectories of so many waypoints, in normalised
/// units.
#[derive(Debug, Clone, Copy)]
pub struct Subject<'a> {
    /// Where the robot moves.
    pub scene: &'a PlaneScene,
    /// Start, in normalised units.
    pub start: [f32; 2],
    /// Goal, in normalised units.
    pub goal: [f32; 2],
    /// Waypoints between them.
    pub waypoints: usize,
}
