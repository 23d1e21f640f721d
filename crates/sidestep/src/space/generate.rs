//! Random scenes in the manner of MotionBenchMaker, and boxes around a planar arm.
//!
//! Source: C. Chamzas et al., "MotionBenchMaker: A Tool to Generate and Benchmark Motion Planning
//! Datasets", IEEE RA-L 7(2), 2022, DOI 10.1109/LRA.2021.3133603, and the sizes and variations of
//! its configurations: a nominal scene, turned and shifted as a whole about the robot's base, its
//! movable objects shifted on their boards. Departures: thickness and size of each family vary by a
//! tenth, so that no two scenes have the same boards, and all numbers are drawn from this crate's
//! streams, so none is a scene of the benchmark.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::pose::Pose;
use super::shape::Shape;
use super::vector::{Vector, add};
use super::world::{Object, World};
use crate::error::InvalidInput;
use crate::rng::{Purpose, stream};

/// A kind of scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Family {
    /// An open box with a lid half up and a can in it.
    Box,
    /// One board with sides and a top; three cans.
    BookshelfSmall,
    /// Three boards between high sides; nine cans.
    BookshelfTall,
    /// Narrow boards on legs, split by an upright board; ten cans.
    BookshelfThin,
    /// Walls and bars around a cube.
    Cage,
    /// A can on a crowded table.
    TablePick,
    /// The same, from below the table.
    TableUnderPick,
    /// Five to ten upright boxes around an arm of reach 1 in the plane z = 0, none within 0.2 of
    /// its base.
    PlanarBoxes,
}

/// A scene and what there is to reach for in it.
#[derive(Debug, Clone)]
pub struct RandomScene {
    /// Such as `cage, seed 7, scene 3`.
    pub name: String,
    /// What is around the robot, in the frame of its base.
    pub world: World,
    /// Where a gripper may start; where there is none, the robot's own rest will do.
    pub starts: Vec<Pose>,
    /// Where it may go: in front of, or above, something to grasp, x towards it.
    pub goals: Vec<Pose>,
}

/// Most that a scene is turned about the robot, to either side: nearly a quarter.
const QUARTER: f64 = 1.57;

impl Family {
    /// All families with their names.
    pub const NAMES: [(&'static str, Self); 8] = [
        ("box", Self::Box),
        ("bookshelf_small", Self::BookshelfSmall),
        ("bookshelf_tall", Self::BookshelfTall),
        ("bookshelf_thin", Self::BookshelfThin),
        ("cage", Self::Cage),
        ("table_pick", Self::TablePick),
        ("table_under_pick", Self::TableUnderPick),
        ("planar_boxes", Self::PlanarBoxes),
    ];

    /// The family's name.
    pub fn name(self) -> &'static str {
        Self::NAMES.iter().find(|(_, family)| *family == self).map_or("", |&(name, _)| name)
    }

    /// Scene number `index` of `seed`, the same on every machine. The nominal scenes stand on the
    /// floor z = 0 with the robot at the origin; `offset` (metres) shifts them for a robot whose
    /// base is elsewhere: one that stands on a table 0.7 high sees them 0.7 lower.
    ///
    /// # Errors
    /// If the offset is not finite.
    pub fn generate(
        self,
        seed: u64,
        index: u64,
        offset: Vector,
    ) -> Result<RandomScene, InvalidInput> {
        super::pose::finite_vector("offset", offset)?;
        let number = Self::NAMES.iter().position(|(_, family)| *family == self).unwrap_or(0);
        let mut draw = Draw(stream(seed, Purpose::Task, index, 1000 + number as u64));
        let mut builder = Builder::default();
        let lift = match self {
            Self::BookshelfSmall => 0.4,
            Self::BookshelfTall | Self::BookshelfThin => 0.0,
            _ => 0.1,
        };
        match self {
            Self::Box => open_box(&mut builder, &mut draw),
            Self::BookshelfSmall => bookshelf_small(&mut builder, &mut draw),
            Self::BookshelfTall => bookshelf_tall(&mut builder, &mut draw),
            Self::BookshelfThin => bookshelf_thin(&mut builder, &mut draw),
            Self::Cage => cage(&mut builder, &mut draw),
            Self::TablePick => table(&mut builder, &mut draw, false),
            Self::TableUnderPick => table(&mut builder, &mut draw, true),
            Self::PlanarBoxes => planar_boxes(&mut builder, &mut draw),
        }
        let whole = if self == Self::PlanarBoxes {
            Pose::at(offset)?
        } else {
            let at = [draw.around(0.1), draw.around(0.1), draw.around(lift)];
            let turn = if self == Self::Cage { 0.5 } else { QUARTER };
            Pose::from_rpy([0.0, 0.0, draw.around(turn)], add(at, offset))?
        };
        let placed = |poses: Vec<Pose>| poses.iter().map(|pose| whole.compose(pose)).collect();
        let objects = builder
            .objects
            .into_iter()
            .map(|(name, pose, shape)| Object::new(name, vec![(whole.compose(&pose), shape)]));
        Ok(RandomScene {
            name: format!("{}, seed {seed}, scene {index}", self.name()),
            world: World::new(objects.collect())?,
            starts: placed(builder.starts),
            goals: placed(builder.goals),
        })
    }
}

impl std::str::FromStr for Family {
    type Err = InvalidInput;

    /// The family of that name.
    fn from_str(name: &str) -> Result<Self, InvalidInput> {
        let found = Self::NAMES.iter().find(|(known, _)| *known == name);
        let unknown =
            || InvalidInput::unknown("family", name, &Self::NAMES.map(|(known, _)| known));
        found.map(|&(_, family)| family).ok_or_else(unknown)
    }
}

impl std::fmt::Display for Family {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// Uniform numbers of one stream.
struct Draw(ChaCha8Rng);

impl Draw {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0.random_range(low..high)
    }

    /// Between -`most` and `most`; 0 where that is 0.
    fn around(&mut self, most: f64) -> f64 {
        if most > 0.0 { self.between(-most, most) } else { 0.0 }
    }

    /// A size that varies by a tenth.
    fn size(&mut self, nominal: f64) -> f64 {
        nominal * self.between(0.9, 1.1)
    }
}

/// A scene in the making, in its nominal place. Sizes are above 0 by construction.
#[derive(Default)]
struct Builder {
    objects: Vec<(String, Pose, Shape)>,
    starts: Vec<Pose>,
    goals: Vec<Pose>,
}

/// How a gripper comes to a thing.
#[derive(Clone, Copy)]
enum Approach {
    /// From the robot's side, level, this far before it and above its middle.
    Front(f64, f64),
    /// From above, pointing down.
    Above(f64),
}

impl Builder {
    fn cuboid(&mut self, name: &str, size: Vector, at: Vector, yaw: f64) {
        self.turned(name, size, at, [0.0, 0.0, yaw]);
    }

    fn turned(&mut self, name: &str, size: Vector, at: Vector, rpy: Vector) {
        let shape = Shape::Box { half_extents: size.map(|size| 0.5 * size) };
        if let Ok(pose) = Pose::from_rpy(rpy, at) {
            self.objects.push((name.to_owned(), pose, shape));
        }
    }

    fn cylinder(&mut self, name: &str, radius: f64, length: f64, at: Vector) {
        let shape = Shape::Cylinder { radius, half_length: 0.5 * length };
        if let Ok(pose) = Pose::at(at) {
            self.objects.push((name.to_owned(), pose, shape));
        }
    }

    /// A can to grasp from the front.
    fn can(&mut self, name: &str, length: f64, at: Vector, above: f64) {
        self.cylinder(name, 0.03, length, at);
        self.goal(at, Approach::Front(0.2, above));
    }

    fn goal(&mut self, at: Vector, approach: Approach) {
        self.goals.extend(gripper(at, approach));
    }
}

fn gripper([x, y, z]: Vector, approach: Approach) -> Option<Pose> {
    match approach {
        Approach::Front(before, above) => Pose::at([x - before, y, z + above]),
        Approach::Above(above) => {
            Pose::from_rpy([0.0, std::f64::consts::FRAC_PI_2, 0.0], [x, y, z + above])
        }
    }
    .ok()
}

fn open_box(builder: &mut Builder, draw: &mut Draw) {
    let (wide, board, high) = (draw.size(0.7), draw.size(0.04), draw.size(0.7));
    let (x, base) = (0.8, 0.44);
    let (half, middle) = (0.5 * wide, base + 0.5 * high);
    let can = [x, draw.around(0.2), base + 0.11];
    builder.cylinder("can", 0.03, 0.14, can);
    builder.goal(can, Approach::Above(0.5));
    builder.goal(can, Approach::Above(0.25));
    builder.cuboid("base", [wide, wide, board], [x, 0.0, base], 0.0);
    builder.cuboid("side_left", [wide, board, high], [x, -half, middle], 0.0);
    builder.cuboid("side_right", [wide, board, high], [x, half, middle], 0.0);
    let front = high - 0.1;
    builder.cuboid("side_front", [board, wide, front], [x - half, 0.0, middle - 0.1], 0.0);
    builder.cuboid("side_back", [board, wide, high], [x + half, 0.0, middle], 0.0);
    let lid = [x + 0.1, 0.0, base + high + 0.21];
    let tilt = draw.size(std::f64::consts::FRAC_PI_4);
    builder.turned("lid", [wide, wide, board], lid, [0.0, tilt, 0.0]);
}

fn bookshelf_small(builder: &mut Builder, draw: &mut Draw) {
    let (deep, wide, board) = (draw.size(1.2), draw.size(1.0), draw.size(0.04));
    let room = draw.size(0.3);
    for (i, x) in [0.9, 0.7, 0.5].into_iter().enumerate() {
        let y = draw.around(0.45 * wide);
        builder.can(&format!("can_{}", i + 1), 0.14, [x, y, 1.08], 0.05);
    }
    for (name, z) in [("shelf_bottom", 1.0), ("shelf_top", 1.0 + room)] {
        builder.cuboid(name, [deep, wide, board], [1.0, 0.0, z], 0.0);
    }
    for (name, side) in [("side_left", -0.5), ("side_right", 0.5)] {
        let at = [1.0, side * wide, 1.0 + 0.5 * room];
        builder.cuboid(name, [deep, board, room + board], at, 0.0);
    }
}

fn bookshelf_tall(builder: &mut Builder, draw: &mut Draw) {
    let (deep, wide, board) = (draw.size(1.2), draw.size(1.0), draw.size(0.04));
    let room = draw.size(0.3);
    let level = |i: usize| 0.7 + room * i as f64;
    for row in 0..3 {
        for (i, x) in [0.9, 0.7, 0.5].into_iter().enumerate() {
            let at = [x, draw.around(0.45 * wide), level(row) + 0.08];
            builder.can(&format!("can_{}", 3 * row + i + 1), 0.14, at, 0.05);
        }
    }
    for i in 0..4 {
        let at = [1.0, 0.0, level(i)];
        builder.cuboid(&format!("shelf_{}", i + 1), [deep, wide, board], at, 0.0);
    }
    let high = level(3) + board;
    for (name, side) in [("side_left", -0.5), ("side_right", 0.5)] {
        let at = [1.0, side * wide, 0.5 * high];
        builder.cuboid(name, [deep + 0.1, board, high], at, 0.0);
    }
}

fn bookshelf_thin(builder: &mut Builder, draw: &mut Draw) {
    let (deep, wide, board) = (draw.size(0.62), draw.size(1.0), draw.size(0.04));
    let room = draw.size(0.25);
    let level = |i: usize| 0.35 + room * i as f64;
    for row in 0..5 {
        let side = if row % 2 == 0 { 0.25 } else { -0.25 };
        for (i, x) in [1.1, 0.8].into_iter().enumerate() {
            let at = [x, (side + draw.around(0.2)) * wide, level(row) + 0.09];
            builder.can(&format!("can_{}", 2 * row + i + 1), 0.14, at, 0.05);
        }
    }
    for i in 0..6 {
        let at = [1.0, 0.0, level(i)];
        builder.cuboid(&format!("shelf_{}", i + 1), [deep, wide, board], at, 0.0);
    }
    let high = level(5);
    let upright = [1.0, 0.0, 0.5 * (level(0) + high)];
    builder.cuboid("shelf_upright", [deep, board, high - level(0)], upright, 0.0);
    for (name, x, y) in
        [("leg_1", -0.5, 0.5), ("leg_2", -0.5, -0.5), ("leg_3", 0.5, 0.5), ("leg_4", 0.5, -0.5)]
    {
        let at = [1.0 + x * deep, y * wide, 0.5 * (high + board)];
        builder.cuboid(name, [board, board, high + board], at, 0.0);
    }
}

fn cage(builder: &mut Builder, draw: &mut Draw) {
    let (wide, board, high) = (draw.size(0.7), draw.size(0.04), draw.size(0.7));
    let (x, base) = (0.8, 0.44);
    let (half, middle) = (0.5 * wide, base + 0.5 * high);
    let cube = [x, 0.0, base + 0.08];
    builder.cuboid("cube", [0.07; 3], cube, 0.0);
    builder.goal(cube, Approach::Above(0.21));
    builder.cuboid("base", [wide, wide, board], [x, 0.0, base], 0.0);
    builder.cuboid("side_left", [wide, board, high], [x, -half, middle], 0.0);
    builder.cuboid("side_right", [wide, board, high], [x, half, middle], 0.0);
    for (name, up) in [("bar_low", 0.23), ("bar_high", 0.66)] {
        let at = [x - half, 0.0, base + up * high];
        builder.cuboid(name, [board, wide, board], at, 0.0);
    }
    let top = [wide - 0.05, wide - 0.05, board];
    builder.cuboid("top", top, [x + 0.05, 0.0, base + high + 0.01], 0.0);
    builder.cuboid("side_back", [board, wide, high], [x + half, 0.0, middle], 0.0);
}

fn table(builder: &mut Builder, draw: &mut Draw, under: bool) {
    let (deep, wide, board) = (draw.size(1.2), draw.size(2.0), draw.size(0.04));
    let top = 0.7;
    let on = top + 0.5 * board;
    let can = [0.85 + draw.around(0.05), draw.around(0.05), on + 0.065];
    builder.can("can", 0.12, can, 0.025);
    builder.cuboid("table_top", [deep, wide, board], [1.05, 0.0, top], 0.0);
    for (name, x, y) in
        [("leg_1", -0.4, 0.42), ("leg_2", 0.4, 0.42), ("leg_3", -0.4, -0.42), ("leg_4", 0.4, -0.42)]
    {
        let at = [1.05 + x * deep, y * wide, 0.5 * top];
        builder.cuboid(name, [0.05, 0.05, top], at, 0.0);
    }
    let sizes = [
        ("cube", [0.25, 0.25, 0.25], [0.75, 0.4]),
        ("object_1", [0.2, 0.02, 0.4], [1.05, -0.2]),
        ("object_2", [0.02, 0.2, 0.4], [0.65, 0.2]),
        ("object_3", [0.2, 0.05, 0.35], [0.65, -0.2]),
        ("object_4", [0.2, 0.05, 0.35], [1.05, 0.2]),
    ];
    for (name, size, [x, y]) in sizes {
        let size = size.map(|size| draw.size(size));
        let at = [x + draw.around(0.1), y + draw.around(0.1), on + 0.5 * size[2]];
        let yaw = draw.around(QUARTER);
        builder.cuboid(name, size, at, yaw);
    }
    let at = [1.35 + draw.around(0.1), draw.around(0.1), on + 0.175];
    builder.cylinder("object_5", 0.05, 0.35, at);
    if under {
        builder.starts.extend(gripper([1.05, 0.0, top], Approach::Front(0.5, -0.3)));
    }
}

fn planar_boxes(builder: &mut Builder, draw: &mut Draw) {
    let count = draw.0.random_range(5..=10_usize);
    while builder.objects.len() < count {
        let at = [draw.between(-1.0, 1.0), draw.between(-1.0, 1.0), 0.0];
        let half = [draw.between(0.03, 0.15), draw.between(0.03, 0.15), 0.5];
        let gap = |k: usize| (at[k].abs() - half[k]).max(0.0);
        if (0.2..1.0).contains(&gap(0).hypot(gap(1))) {
            let name = format!("box_{}", builder.objects.len() + 1);
            builder.cuboid(&name, half.map(|half| 2.0 * half), at, 0.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_come_back() {
        for (name, family) in Family::NAMES {
            assert_eq!((name.parse(), family.to_string()), (Ok(family), name.to_owned()));
        }
        let error = "cages".parse::<Family>().unwrap_err();
        assert!(error.allowed.ends_with("did you mean cage?"));
    }

    #[test]
    fn value_stability() {
        let scene = Family::Cage.generate(7, 3, [0.0, 0.0, -0.18]).unwrap();
        let [x, y, z] = scene.goals[0].translation();
        assert_eq!(scene.name, "cage, seed 7, scene 3");
        let rounded = [x, y, z].map(|v| (v * 1e6).round() / 1e6);
        assert_eq!(rounded, [0.813_76, 0.274_906, 0.593_646]);
    }

    /// Goals are free of everything but what is to be grasped, and objects do not float or sink.
    #[test]
    fn goals_are_free_and_the_base_is_too() {
        for (_, family) in Family::NAMES {
            let mut free = 0;
            for index in 0..50 {
                let scene = family.generate(1, index, [0.0; 3]).unwrap();
                let other = family.generate(1, index + 1, [0.0; 3]).unwrap();
                assert_ne!(scene.world.distance(0, [0.0; 3]), other.world.distance(0, [0.0; 3]));
                assert_eq!(family == Family::PlanarBoxes, scene.goals.is_empty());
                assert_eq!(family == Family::TableUnderPick, !scene.starts.is_empty());
                let clearance = |p: Vector| {
                    let pieces = 0..scene.world.pieces() as u32;
                    pieces.map(|i| scene.world.distance(i, p).0).fold(f64::INFINITY, f64::min)
                };
                let ends = scene.goals.iter().chain(&scene.starts);
                free += ends.filter(|pose| clearance(pose.translation()) > 0.02).count();
                if family == Family::PlanarBoxes {
                    assert!(clearance([0.0; 3]) >= 0.2 && (5..=10).contains(&scene.world.pieces()));
                }
            }
            assert!(family == Family::PlanarBoxes || free > 25, "{}: {free}", family.name());
        }
    }
}
