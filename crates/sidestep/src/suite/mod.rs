//! The paper's task generator and its suites (paper, sections II.A and II.C).
//!
//! A field of 64 x 64 pixels with 10 rectangles: lower left corners U{0..63} and sizes U{10..19} per
//! axis, all integers; rectangles may overlap and cross the border. Start and goal are integer
//! pixels U{1..62}, both redrawn until neither lies in a closed rectangle. Candidate i of a seed has
//! a stream of its own, and a suite keeps the candidates that pass its filter, in order.

pub mod arms;
mod pictured;
pub mod queries;

use std::sync::Arc;

use rand::RngExt;

use crate::error::InvalidInput;
use crate::objective::Objective;
use crate::plan::parallel;
use crate::plane::Robot;
use crate::plane::certificate::Certifier;
use crate::plane::geometry::{Point, Rect};
use crate::plane::world::{Obstacle, World};
use crate::profile::Profile;
use crate::rng::{Purpose, stream};
use crate::scene::{Query, Setting, Task};

use pictured::{Kind, pictured};

/// A named distribution of tasks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Suite {
    /// Every candidate.
    Easy,
    /// Candidates that gradient descent (the profile's step, 200 steps) never solves.
    Hard,
    /// Candidates that gradient descent does not hold solved at the end of 200 steps: the paper's
    /// training version of hard.
    HardTraining,
    /// Alternately easy and hard (training version), half each.
    Mix,
    /// Candidates that gradient descent solves first after more than 10 and at most 100 steps; the
    /// paper also asks that the learned optimizer solves them within 100, which depends on it.
    Time,
    /// Not the paper's: 1 to 40 rectangles, smaller where there are more, and discs of up to 3 pixels as robots
    /// in half of the tasks. For policies that should serve worlds of many kinds.
    Varied,
    /// Not the paper's, as the next two: a map of rooms within rooms, joined by doors.
    Rooms,
    /// A map of smooth blobs.
    Blobs,
    /// A map as a scanner makes it: furniture at all angles, frayed edges, specks.
    Scans,
}

/// Steps of gradient descent that decide what is hard.
const HARD_STEPS: usize = 200;
const FIELD: f64 = 64.0;
const OBSTACLES: usize = 10;

impl Suite {
    /// All suites with their names.
    pub const NAMES: [(&'static str, Self); 9] = [
        ("easy", Self::Easy),
        ("hard", Self::Hard),
        ("hard-training", Self::HardTraining),
        ("mix", Self::Mix),
        ("time", Self::Time),
        ("varied", Self::Varied),
        ("rooms", Self::Rooms),
        ("blobs", Self::Blobs),
        ("scans", Self::Scans),
    ];

    /// The suite's name.
    pub fn name(&self) -> &'static str {
        Self::NAMES.iter().find(|(_, suite)| suite == self).map_or("", |&(name, _)| name)
    }

    /// The first `count` tasks of the suite for `seed`, the same on every machine and for every
    /// number of threads. `profile` says what gradient descent is for the filtered suites; the
    /// suites of the paper use [`Profile::PAPER`].
    pub fn generate(&self, count: usize, seed: u64, profile: &Profile) -> Vec<Task> {
        self.generate_watched(count, seed, profile, &|| {})
    }

    /// As [`Suite::generate`]; calls `kept` from any thread for each task that is kept, and at the
    /// end for some that are one too many.
    pub fn generate_watched(
        &self,
        count: usize,
        seed: u64,
        profile: &Profile,
        kept: &(dyn Fn() + Sync),
    ) -> Vec<Task> {
        let every = |draw: &(dyn Fn(u64, u64) -> Task + Sync)| {
            parallel::map(count, |i| {
                kept();
                draw(seed, i as u64)
            })
        };
        let pictures = |kind| every(&|seed, index| pictured(kind, seed, index));
        match self {
            Self::Easy => every(&candidate),
            Self::Varied => every(&varied),
            Self::Rooms => pictures(Kind::Rooms),
            Self::Blobs => pictures(Kind::Blobs),
            Self::Scans => pictures(Kind::Scans),
            Self::Mix => {
                let easy = Self::Easy.generate_watched(count.div_ceil(2), seed, profile, kept);
                let hard = Self::HardTraining.generate_watched(count / 2, seed, profile, kept);
                let mut hard = hard.into_iter();
                easy.into_iter().flat_map(|task| [Some(task), hard.next()]).flatten().collect()
            }
            Self::Hard | Self::HardTraining | Self::Time => {
                self.filtered(count, seed, profile, kept)
            }
        }
    }

    fn filtered(
        &self,
        count: usize,
        seed: u64,
        profile: &Profile,
        kept: &(dyn Fn() + Sync),
    ) -> Vec<Task> {
        let mut tasks = Vec::with_capacity(count);
        let mut next = 0u64;
        while tasks.len() < count {
            // Batches only spread the work; which candidates pass does not depend on their size.
            let batch = 256.max(2 * (count - tasks.len()) as u64);
            let passed = parallel::map(batch as usize, |i| {
                let task = candidate(seed, next + i as u64);
                self.keeps(&task, profile).then(|| {
                    kept();
                    task
                })
            });
            tasks.extend(passed.into_iter().flatten());
            next += batch;
        }
        tasks.truncate(count);
        tasks
    }

    fn keeps(&self, task: &Task, profile: &Profile) -> bool {
        let Some(outcome) = gradient_descent_outcome(task, profile) else { return false };
        match self {
            Self::Hard => outcome.first_feasible.is_none(),
            Self::HardTraining => !outcome.feasible_at_end,
            Self::Time => outcome.first_feasible.is_some_and(|step| (11..=100).contains(&step)),
            _ => true,
        }
    }
}

impl std::str::FromStr for Suite {
    type Err = InvalidInput;

    /// The suite of that name.
    fn from_str(name: &str) -> Result<Self, InvalidInput> {
        let found = Self::NAMES.iter().find(|(known, _)| *known == name);
        let unknown = || InvalidInput::unknown("suite", name, &Self::NAMES.map(|(known, _)| known));
        found.map(|&(_, suite)| suite).ok_or_else(unknown)
    }
}

impl std::fmt::Display for Suite {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

struct Outcome {
    /// Index of the first feasible iterate; 0 is the straight line itself.
    first_feasible: Option<usize>,
    feasible_at_end: bool,
}

fn gradient_descent_outcome(task: &Task, profile: &Profile) -> Option<Outcome> {
    let query = Query::of(task, profile);
    let mut objective = Objective::new(&query, profile.waypoints).ok()?;
    let mut x = vec![0.0; objective.dim()];
    let mut gradient = vec![0.0; objective.dim()];
    objective.straight_line(&mut x);
    let mut first_feasible = objective.is_feasible(&x).then_some(0);
    for step in 1..=HARD_STEPS {
        objective.cost_and_gradient(&x, &mut gradient);
        for (x, g) in x.iter_mut().zip(&gradient) {
            *x -= profile.gradient_step as f32 * g;
        }
        if first_feasible.is_none() && objective.is_feasible(&x) {
            first_feasible = Some(step);
        }
    }
    Some(Outcome { first_feasible, feasible_at_end: objective.is_feasible(&x) })
}

/// Candidate `index` of `seed`: the paper's generator, before any filter.
pub fn candidate(seed: u64, index: u64) -> Task {
    let mut rng = stream(seed, Purpose::Task, index, 0);
    let rects: Vec<Rect> = (0..OBSTACLES)
        .map(|_| {
            let min: Point = [(); 2].map(|()| f64::from(rng.random_range(0..64u32)));
            let size: Point = [(); 2].map(|()| f64::from(rng.random_range(10..20u32)));
            Rect { min, max: [min[0] + size[0], min[1] + size[1]] }
        })
        .collect();
    let (start, goal) = loop {
        let mut pixel = || [(); 2].map(|()| f64::from(rng.random_range(1..63u32)));
        let (start, goal): (Point, Point) = (pixel(), pixel());
        if !rects.iter().any(|rect| rect.contains(start) || rect.contains(goal)) {
            break (start, goal);
        }
    };
    let bounds = Rect { min: [0.0; 2], max: [FIELD; 2] };
    let obstacles = rects.into_iter().map(Obstacle::Rect).collect();
    let world = Arc::new(World::new(bounds, obstacles, None));
    let setting = Setting::Plane { world, robot: Robot::Point };
    let name = format!("seed {seed}, candidate {index}");
    Task { name, setting, start: start.into(), goal: goal.into() }
}

/// Task `index` of `seed` in [`Suite::Varied`].
pub fn varied(seed: u64, index: u64) -> Task {
    let mut rng = stream(seed, Purpose::Task, index, 1);
    let bounds = Rect { min: [0.0; 2], max: [FIELD; 2] };
    let robot = match rng.random_range(0..2u32) {
        0 => Robot::Point,
        _ => Robot::Disc { radius: rng.random_range(0.2..3.0) },
    };
    loop {
        let count = rng.random_range(1..=40u32);
        // About as much of the field is covered as in the paper, whatever the number.
        let side = 14.5 * (f64::from(OBSTACLES as u32) / f64::from(count)).sqrt().min(1.8);
        let side = side * rng.random_range(0.6..1.15);
        let rects: Vec<Rect> = (0..count)
            .map(|_| {
                let size: Point = [(); 2].map(|()| side * rng.random_range(0.5..1.5));
                let min: Point = size.map(|size| rng.random_range(-0.5 * size..FIELD));
                Rect { min, max: [min[0] + size[0], min[1] + size[1]] }
            })
            .collect();
        let obstacles = rects.into_iter().map(Obstacle::Rect).collect();
        let world = World::new(bounds, obstacles, None);
        let certifier = Certifier::new(&world, robot);
        for _ in 0..20 {
            let mut point = || [(); 2].map(|()| rng.random_range(1.0..FIELD - 1.0));
            let (start, goal): (Point, Point) = (point(), point());
            if certifier.point_is_free(start) && certifier.point_is_free(goal) {
                let name = format!("varied, seed {seed}, task {index}");
                let setting = Setting::Plane { world: Arc::new(world), robot };
                return Task { name, setting, start: start.into(), goal: goal.into() };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn value_stability() {
        let task = candidate(2, 0);
        let first = Rect { min: [2.0, 55.0], max: [21.0, 66.0] };
        let plane = task.plane().unwrap();
        assert_eq!(plane.world.obstacles()[0], Obstacle::Rect(first));
        assert_eq!((plane.start, plane.goal), ([4.0, 18.0], [12.0, 24.0]));
    }

    #[test]
    fn suites_do_not_depend_on_threads() {
        let generate = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| Suite::Mix.generate(40, 7, &Profile::PAPER))
        };
        assert_eq!(generate(1), generate(3));
    }
}
