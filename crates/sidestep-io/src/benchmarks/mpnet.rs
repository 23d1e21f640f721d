//! The Simple2D worlds of MPNet: seven square blocks in a square room.
//!
//! Source: A. Qureshi, A. Simeonov, M. Bency, M. Yip, "Motion Planning Networks", ICRA 2019, DOI
//! 10.1109/ICRA.2019.8793889, and the loaders of its repository. `obs.dat` holds pairs of little-endian
//! f64, of which the first 20 are block centres; `obs_perm2.dat` rows of seven little-endian i32, each
//! the blocks of one world. Blocks have side 5; the room is `[-20, 20]` on both axes.
//!
//! MPNet's own starts and goals lie in files of their own, which few have; here they are drawn uniformly
//! from the room and kept where the robot is free.

use std::sync::Arc;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sidestep::plane::geometry::{Point, Rect};
use sidestep::{Obstacle, Robot, Task, World};

use crate::error::{FormatError, Place};

const FORMAT: &str = "MPNet Simple2D";
const CENTRES: usize = 20;
const BLOCKS: usize = 7;
const BLOCK_SIDE: f64 = 5.0;
const ROOM: Rect = Rect { min: [-20.0; 2], max: [20.0; 2] };

/// Draws after which a world counts as full; at least half of the room is free of blocks.
const MOST_DRAWS: usize = 10_000;

/// The worlds of the two files.
#[derive(Debug, Clone, PartialEq)]
pub struct Simple2d {
    centres: [Point; CENTRES],
    worlds: Vec<[u8; BLOCKS]>,
}

impl Simple2d {
    /// Reads the bytes of `obs.dat` and `obs_perm2.dat`.
    ///
    /// # Errors
    /// If a file is too short, a row is cut, or a row names a block that there is not.
    pub fn read(obs: &[u8], obs_perm: &[u8]) -> Result<Self, FormatError> {
        let numbers = obs.as_chunks::<8>().0;
        if numbers.len() < 2 * CENTRES {
            let found = format!("{} bytes", obs.len());
            let expected = format!("at least {} bytes: {CENTRES} pairs of f64", 16 * CENTRES);
            return Err(FormatError::new(FORMAT, Place::field("obs.dat"), found, expected));
        }
        let mut centres = [[0.0; 2]; CENTRES];
        for (i, &bytes) in numbers[..2 * CENTRES].iter().enumerate() {
            let value = f64::from_le_bytes(bytes);
            if !(-20.0..=20.0).contains(&value) {
                let place = Place::field(format!("obs.dat[{}][{}]", i / 2, i % 2));
                return Err(FormatError::new(FORMAT, place, value, "a number from -20 to 20"));
            }
            centres[i / 2][i % 2] = value;
        }
        let (indices, cut) = obs_perm.as_chunks::<4>();
        let (rows, rest) = indices.as_chunks::<BLOCKS>();
        if rows.is_empty() || !rest.is_empty() || !cut.is_empty() {
            let found = format!("{} bytes", obs_perm.len());
            let expected = format!("a multiple of {} bytes: rows of {BLOCKS} i32", 4 * BLOCKS);
            return Err(FormatError::new(FORMAT, Place::field("obs_perm2.dat"), found, expected));
        }
        let mut worlds = Vec::with_capacity(rows.len());
        for (i, row) in rows.iter().enumerate() {
            let mut world = [0; BLOCKS];
            for (j, &bytes) in row.iter().enumerate() {
                let index = i32::from_le_bytes(bytes);
                world[j] = match u8::try_from(index) {
                    Ok(block) if usize::from(block) < CENTRES => block,
                    _ => {
                        let place = Place::field(format!("obs_perm2.dat[{i}][{j}]"));
                        let expected = format!("a block from 0 to {}", CENTRES - 1);
                        return Err(FormatError::new(FORMAT, place, index, expected));
                    }
                };
            }
            worlds.push(world);
        }
        Ok(Self { centres, worlds })
    }

    /// Number of worlds; at least one.
    #[allow(clippy::len_without_is_empty, reason = "there is always a world")]
    pub fn len(&self) -> usize {
        self.worlds.len()
    }

    /// World number `index`.
    ///
    /// # Errors
    /// If there is no such world.
    pub fn world(&self, index: usize) -> Result<World, FormatError> {
        let blocks = self.worlds.get(index).ok_or_else(|| {
            let expected = format!("0 to {}", self.worlds.len() - 1);
            FormatError::new(FORMAT, Place::field("index"), index, expected)
        })?;
        let blocks = blocks.map(|block| {
            let centre = self.centres[usize::from(block)];
            Obstacle::Rect(Rect { min: centre, max: centre }.inflated(BLOCK_SIDE / 2.0))
        });
        Ok(World::new(ROOM, blocks.to_vec(), None))
    }

    /// A task in world number `index`, with start and goal drawn from the stream (`seed`, `index`)
    /// where the robot is free.
    ///
    /// # Errors
    /// If there is no such world, or no free place was found, which only a very large robot can cause.
    pub fn task(&self, index: usize, robot: Robot, seed: u64) -> Result<Task, FormatError> {
        let world = Arc::new(self.world(index)?);
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(index as u64);
        let (start, goal) = (draw(&world, robot, &mut random)?, draw(&world, robot, &mut random)?);
        let name = format!("mpnet2d/{index}");
        Task::in_plane(name, world, robot, start, goal).map_err(|invalid| {
            FormatError::new(FORMAT, Place::field(invalid.field), invalid.value, invalid.allowed)
        })
    }
}

fn draw(world: &World, robot: Robot, random: &mut ChaCha8Rng) -> Result<Point, FormatError> {
    let room = ROOM.inflated(-robot.radius());
    let free = |p: Point| {
        room.contains(p)
            && world.obstacles().iter().all(|block| block.signed_distance(p) > robot.radius())
    };
    let uniform =
        |random: &mut ChaCha8Rng, axis: usize| random.random_range(ROOM.min[axis]..ROOM.max[axis]);
    for _ in 0..MOST_DRAWS {
        let p = [uniform(random, 0), uniform(random, 1)];
        if free(p) {
            return Ok(p);
        }
    }
    let expected = "a robot that fits between the blocks of a 40 x 40 room";
    Err(FormatError::new(FORMAT, Place::field("robot.radius"), robot.radius(), expected))
}
