//! Tasks of many kinds, each from its own random stream: ordinary ones, and those that rounding does not like.

use std::f64::consts::TAU;
use std::sync::Arc;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sidestep::plane::geometry::{Circle, ConvexPolygon, Point, Rect};
use sidestep::suite::{candidate, varied};
use sidestep::{Certifier, Grid, InvalidInput, Obstacle, Robot, Task, World};

/// A kind of tasks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Family {
    /// The paper's generator.
    Easy,
    /// 1 to 40 rectangles and discs as robots.
    Varied,
    /// Shapes and robots on a lattice: shared sides, touching corners, gaps just as wide as the robot.
    Touching,
    /// Walls with a door that is a few tolerances wider or narrower than the robot.
    Gaps,
    /// Large coordinates, wide bounds, and shapes that reach far beyond the bounds.
    Far,
    /// Fields of a thousandth of a unit and far less.
    Tiny,
    /// Occupancy grids, some with shapes on them.
    Maps,
    /// Numbers that are hard to round.
    Nasty,
}

impl Family {
    /// All families with their names in reports.
    pub const ALL: [(Self, &'static str); 8] = [
        (Self::Easy, "easy"),
        (Self::Varied, "varied"),
        (Self::Touching, "touching"),
        (Self::Gaps, "gaps"),
        (Self::Far, "far"),
        (Self::Tiny, "tiny"),
        (Self::Maps, "maps"),
        (Self::Nasty, "nasty"),
    ];

    /// Task `index` of a seed.
    pub fn draw(self, seed: u64, index: u64) -> Task {
        let mut key = [0; 32];
        key[..8].copy_from_slice(&seed.to_le_bytes());
        key[8..16].copy_from_slice(&index.to_le_bytes());
        key[16] = self as u8;
        let mut rng = ChaCha8Rng::from_seed(key);
        // Now and then a draw is no world, such as a polygon without area: then the next one is.
        loop {
            let task = match self {
                Self::Easy => Ok(candidate(seed, index)),
                Self::Varied => Ok(varied(seed, index)),
                Self::Touching => touching(&mut rng, UNIT),
                Self::Gaps => gaps(&mut rng),
                Self::Far => far(&mut rng),
                Self::Tiny => tiny(&mut rng),
                Self::Maps => maps(&mut rng),
                Self::Nasty => nasty(&mut rng),
            };
            if let Ok(task) = task {
                return task;
            }
        }
    }
}

type Drawn = Result<Task, InvalidInput>;

/// Where a world drawn around the origin is placed.
#[derive(Clone, Copy)]
struct Frame {
    scale: f64,
    shift: Point,
}

const UNIT: Frame = Frame { scale: 1.0, shift: [0.0; 2] };

impl Frame {
    fn place(self, p: Point) -> Point {
        [0, 1].map(|axis| self.shift[axis] + self.scale * p[axis])
    }

    fn rect(self, min: Point, max: Point) -> Result<Rect, InvalidInput> {
        Rect::new(self.place(min), self.place(max))
    }
}

fn pick<T: Copy>(rng: &mut ChaCha8Rng, values: &[T]) -> T {
    values[rng.random_range(0..values.len())]
}

/// A task between two places that are free, if such are found among a few.
fn between(
    world: World,
    robot: Robot,
    rng: &mut ChaCha8Rng,
    place: impl Fn(&mut ChaCha8Rng) -> Point,
) -> Drawn {
    let certifier = Certifier::new(&world, robot);
    let mut end = || {
        let mut draws = std::iter::repeat_with(|| place(rng)).take(20);
        let last = draws.next().unwrap_or_default();
        let free = |p: &Point| certifier.point_is_free(*p);
        if free(&last) { last } else { draws.find(free).unwrap_or(last) }
    };
    let (start, goal) = (end(), end());
    Task::in_plane("", Arc::new(world), robot, start, goal)
}

/// Rectangles, circles and triangles on a lattice of halves, robots of a quarter, a half or one.
fn touching(rng: &mut ChaCha8Rng, frame: Frame) -> Drawn {
    let size = pick(rng, &[4, 8, 16]);
    let half = |i: i32| 0.5 * f64::from(i);
    let mut obstacles = Vec::new();
    for _ in 0..rng.random_range(1..=2 * size) {
        let [x, y] = [0, 1].map(|_| half(rng.random_range(-2..2 * size)));
        let [w, h] = [0, 1].map(|_| half(rng.random_range(1..=size)));
        obstacles.push(match rng.random_range(0..6) {
            0 => {
                let radius = frame.scale * half(rng.random_range(1..=3));
                Obstacle::Circle(Circle::new(frame.place([x, y]), radius)?)
            }
            1 => {
                let corners = [[x, y], [x + w, y], [x, y + h]].map(|p| frame.place(p));
                Obstacle::Polygon(ConvexPolygon::new(corners.to_vec())?)
            }
            _ => Obstacle::Rect(frame.rect([x, y], [x + w, y + h])?),
        });
    }
    let robot = Robot::disc(frame.scale * pick(rng, &[0.0, 0.0, 0.25, 0.5, 1.0]))?;
    let side = f64::from(size);
    let world = World::new(frame.rect([0.0; 2], [side; 2])?, obstacles, None);
    between(world, robot, rng, |rng| {
        frame.place([0, 1].map(|_| half(rng.random_range(0..=2 * size))))
    })
}

/// One or two walls across the field, each with a door.
fn gaps(rng: &mut ChaCha8Rng) -> Drawn {
    let scale = 10_f64.powi(rng.random_range(-6..5));
    let shift = pick(rng, &[0.0, 0.0, 0.1, 1e3, 5e6]);
    let frame = Frame { scale, shift: [shift, -shift] };
    let radius = if rng.random() { scale * pick(rng, &[1e-9, 1e-6, 0.1, 0.5, 0.75]) } else { 0.0 };
    let robot = Robot::disc(radius)?;
    let bounds = frame.rect([0.0; 2], [10.0; 2])?;
    let plain = Certifier::new(&World::new(bounds, Vec::new(), None), robot);
    let tolerance = plain.margin() - radius;
    let mut obstacles = Vec::new();
    for wall in 0..rng.random_range(1..=2) {
        let left = 3.0 + 3.0 * f64::from(wall);
        let (left, right) = (frame.place([left; 2])[0], frame.place([left + 0.5; 2])[0]);
        let door = frame.place([0.0, rng.random_range(2.0..8.0)])[1];
        let half = radius + tolerance * rng.random_range(-1.0..4.0);
        let (low, high) = (frame.place([0.0, -1.0])[1], frame.place([0.0, 11.0])[1]);
        let lower = Rect::new([left, low], [right, door - half])?;
        let upper = Rect::new([left, door + half], [right, high])?;
        for part in [lower, upper] {
            obstacles.push(match rng.random_range(0..4) {
                0 => Obstacle::Polygon(ConvexPolygon::new(part.corners().to_vec())?),
                _ => Obstacle::Rect(part),
            });
        }
        if rng.random_range(0..4) == 0 {
            // The door's upper side is round.
            let size = scale * rng.random_range(0.2..2.0);
            let center = [left, door + half + size];
            obstacles.push(Obstacle::Circle(Circle::new(center, size)?));
        }
    }
    let world = World::new(bounds, obstacles, None);
    let (start, goal) = (frame.place([1.5, 5.0]), frame.place([8.5, 5.0]));
    Task::in_plane("", Arc::new(world), robot, start, goal)
}

/// Shapes that come near the middle of the field from any side, however large they are.
fn far(rng: &mut ChaCha8Rng) -> Drawn {
    let power =
        |rng: &mut ChaCha8Rng, low: f64, high: f64| 10_f64.powf(rng.random_range(low..high));
    let scale = power(rng, -3.0, 4.0);
    let shift = [0, 1].map(|_| {
        let size = power(rng, 0.0, 8.5);
        pick(rng, &[0.0, -1.0, 1.0]) * size
    });
    let frame = Frame { scale, shift };
    // Bounds may be far wider than all that happens.
    let wide = pick(rng, &[1.0, 1.0, 1e2, 1e4, 1e6]);
    let bounds = frame.rect([5.0 - 5.0 * wide; 2], [5.0 + 5.0 * wide; 2])?;
    let mut obstacles = Vec::new();
    for _ in 0..rng.random_range(1..7) {
        let near = frame.place([0, 1].map(|_| rng.random_range(1.0..9.0)));
        let size = scale * pick(rng, &[0.3, 1.0, 3.0]);
        let large = power(rng, 0.0, 8.7).max(size);
        let angle = rng.random_range(0.0..TAU);
        let away = |by: f64, reach: f64| {
            [near[0] + reach * (angle + by).cos(), near[1] + reach * (angle + by).sin()]
        };
        obstacles.push(match rng.random_range(0..5) {
            0 => Obstacle::Rect(Rect::new([near[0] - large, near[1] - size], near)?),
            1 => Obstacle::Rect(Rect::new(near, [near[0] + size, near[1] + large])?),
            2 => Obstacle::Circle(Circle::new(away(0.0, large), large)?),
            3 => {
                let corners = vec![near, away(-0.5, large), away(0.5, large)];
                Obstacle::Polygon(ConvexPolygon::new(corners)?)
            }
            _ => Obstacle::Rect(Rect::new(
                [near[0] - size, near[1] - 0.1 * size],
                [near[0] + size, near[1] + 0.1 * size],
            )?),
        });
    }
    let radius = if rng.random() { 0.0 } else { scale * pick(rng, &[1e-6, 0.1, 0.5]) };
    let world = World::new(bounds, obstacles, None);
    between(world, Robot::disc(radius)?, rng, |rng| {
        frame.place([0, 1].map(|_| rng.random_range(0.5..9.5)))
    })
}

fn tiny(rng: &mut ChaCha8Rng) -> Drawn {
    let scale = 10_f64.powi(rng.random_range(-12..-2));
    let shift = [0, 1].map(|_| pick(rng, &[0.0, 0.0, 0.3, -2.0]) * scale.max(1e-6));
    touching(rng, Frame { scale, shift })
}

/// Random cells, or rooms with doors, of any resolution and place.
fn maps(rng: &mut ChaCha8Rng) -> Drawn {
    let [width, height] = [0, 1].map(|_| rng.random_range(4..48_usize));
    let resolution = pick(rng, &[1.0, 0.05, 0.1, 1.0 / 3.0, 2.5e-4, 7.0]);
    let origin = [0, 1].map(|_| pick(rng, &[0.0, -12.3, 0.1, 333.567, 1e6]));
    let density = pick(rng, &[0.05, 0.15, 0.3]);
    let rooms = rng.random();
    let mut cells: Vec<bool> = (0..width * height).map(|_| rng.random_bool(density)).collect();
    if rooms {
        for (i, cell) in cells.iter_mut().enumerate() {
            let (column, row) = (i % width, i / width);
            let is_wall = column % 8 == 5 || row % 8 == 6;
            *cell = is_wall && !rng.random_bool(0.15);
        }
    }
    let grid = Grid::new(width, height, resolution, origin, cells)?;
    let around = pick(rng, &[0.0, 0.0, 0.7, -0.8]) * resolution;
    let bounds = grid.rect().inflated(around);
    let bounds = Rect::new(bounds.min, bounds.max)?;
    let [low, high] = [bounds.min, bounds.max];
    let place = move |rng: &mut ChaCha8Rng| {
        [0, 1].map(|axis| low[axis] + rng.random::<f64>() * (high[axis] - low[axis]))
    };
    let mut obstacles = Vec::new();
    for _ in 0..pick(rng, &[0, 0, 3]) {
        let size = resolution * rng.random_range(0.5..3.0);
        let corner = place(rng);
        obstacles.push(match rng.random() {
            true => Obstacle::Circle(Circle::new(corner, size)?),
            false => Obstacle::Rect(Rect::new(corner, corner.map(|x| x + size))?),
        });
    }
    let radius = resolution * pick(rng, &[0.0, 0.0, 0.25, 0.49, 0.5, 0.7, 1.5]);
    let world = World::new(bounds, obstacles, Some(grid));
    between(world, Robot::disc(radius)?, rng, place)
}

/// Coordinates and sizes from a list of those that rounding does not like.
fn nasty(rng: &mut ChaCha8Rng) -> Drawn {
    let third = 1.0 / 3.0;
    let numbers = [
        0.0,
        -0.0,
        0.1,
        0.2,
        0.1 + 0.2,
        0.3,
        third,
        2.0 * third,
        0.7,
        1.0,
        1.0_f64.next_down(),
        1.0_f64.next_up(),
        0.5,
        1e-9,
        1e-16,
        5e-324,
        1e-300,
        1e-150,
        std::f64::consts::FRAC_1_SQRT_2,
        0.5 + 1e-9,
        0.5 - 1e-9,
        0.5 + 2e-9,
        -1e9,
        1e9,
    ];
    let number = |rng: &mut ChaCha8Rng| {
        let value = pick(rng, &numbers);
        if rng.random() { value } else { value * rng.random::<f64>() }
    };
    let size = |rng: &mut ChaCha8Rng| pick(rng, &numbers).abs().max(5e-324);
    let mut obstacles = Vec::new();
    for _ in 0..rng.random_range(1..8) {
        let corner = [0, 1].map(|_| number(rng));
        let shape = match rng.random_range(0..4) {
            0 => Circle::new(corner, size(rng)).map(Obstacle::Circle),
            1 => {
                let corners = (0..4).map(|_| [0, 1].map(|_| number(rng))).collect();
                ConvexPolygon::new(corners).map(Obstacle::Polygon)
            }
            _ => {
                let [w, h] = [0, 1].map(|_| 0.4 * size(rng).min(2e9));
                Rect::new(corner, [corner[0] + w, corner[1] + h]).map(Obstacle::Rect)
            }
        };
        obstacles.extend(shape);
    }
    let radius = pick(rng, &[0.0, 0.0, 1e-300, 1e-12, 1e-9, 0.05, 0.1, third]);
    let world = World::new(Rect::new([0.0; 2], [1.0; 2])?, obstacles, None);
    between(world, Robot::disc(radius)?, rng, |rng| {
        [0, 1].map(|_| pick(rng, &numbers).clamp(0.0, 1.0))
    })
}
