//! Starts and goals where the robot cannot stand as it was asked to: moved to where it can ([`snapped`]), or left with less than
//! the margin ([`Relaxed`]).
//!
//! A robot that stands nearer to something than its margin leads to a place where it has the margin, or comes from one: within
//! that distance of the end only the robot itself counts, everywhere else the robot with its margin.

use crate::error::InvalidInput;
use crate::plane::certificate::Certifier;
use crate::plane::geometry::{Point, distance, lerp, sub};
use crate::plane::{PlaneScene, PlaneTask, Robot, place_near};
use crate::trajectory::Trajectory;

/// A place with the margin is looked for within this many margins of an end without.
const FAR: f64 = 2.0;

/// An end that a plan does not have where, or as, it was asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EndChange {
    /// `start` or `goal`.
    pub end: &'static str,
    /// Where it was asked to be.
    pub place: Point,
    /// What was changed.
    pub change: Change,
}

/// How an end was changed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Change {
    /// It is here now.
    Moved(Point),
    /// The plan need not keep the margin within `radius` of it; `clearance` is what the robot has there.
    Relaxed {
        /// Distance from the end, in task units.
        radius: f64,
        /// From the robot's body to what is nearest.
        clearance: f64,
    },
}

impl std::fmt::Display for EndChange {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { end, place: [x, y], change } = self;
        match change {
            Change::Moved(to) => {
                let by = distance(*to, self.place);
                write!(
                    f,
                    "the {end} ({x}, {y}) is not free and was moved by {by:.3} to ({:.3}, {:.3})",
                    to[0], to[1]
                )
            }
            Change::Relaxed { radius, clearance } => write!(
                f,
                "the {end} ({x}, {y}) has a clearance of {clearance:.3} only; the margin is not kept within {radius:.3} of it"
            ),
        }
    }
}

/// Ends where the robot can stand: one that is not free is moved by at most `most`, to where the robot has the margin if there is
/// such a place, and else to where it is free. Ends that are free stay, with or without the margin.
///
/// # Errors
/// If `margin` or `most` is not allowed.
pub fn snapped(
    task: &PlaneTask<'_>,
    margin: f64,
    most: f64,
) -> Result<([Point; 2], Vec<EndChange>), InvalidInput> {
    let extent = task.world.bounds().extent();
    if !(0.0..=extent).contains(&most) {
        let allowed = format!("a number from 0 to {extent}, the field's extent");
        return Err(InvalidInput::new("snap", most, allowed));
    }
    let own = Certifier::new(task.world, task.robot);
    let wide = Certifier::new(task.world, Robot::disc(task.robot.radius() + margin)?);
    let (mut ends, mut changes) = ([task.start, task.goal], Vec::new());
    for (end, place) in ["start", "goal"].into_iter().zip(&mut ends) {
        if own.point_is_free(*place) {
            continue;
        }
        let near = |certifier: &Certifier| place_near(*place, most, |p| certifier.point_is_free(p));
        if let Some(to) = near(&wide).or_else(|| near(&own)) {
            changes.push(EndChange { end, place: *place, change: Change::Moved(to) });
            *place = to;
        }
    }
    Ok((ends, changes))
}

/// Ends of which one or both have less than the margin, and places near these with it.
#[derive(Debug, Clone)]
pub struct Relaxed<'a> {
    own: &'a PlaneScene,
    wide: &'a PlaneScene,
    ends: [Point; 2],
    /// The ends themselves where they have the margin.
    places: [Point; 2],
    /// Round which ends the margin is not kept, and how far.
    pub changes: Vec<EndChange>,
}

impl<'a> Relaxed<'a> {
    /// The ends of a question, `own` being the scene of the robot itself and `wide` that of the robot with its margin. None
    /// where both have the margin, one is not free, or there is no such place near.
    pub fn of(own: &'a PlaneScene, wide: &'a PlaneScene, ends: [&[f64]; 2]) -> Option<Self> {
        let margin = wide.robot().radius() - own.robot().radius();
        let ends = ends.map(|end| [end[0], end[1]]);
        let (mut places, mut changes, mut reach) = (ends, Vec::new(), 0.0);
        for (index, end) in ["start", "goal"].into_iter().enumerate() {
            let place = ends[index];
            if wide.certifier().point_is_free(place) {
                continue;
            }
            places[index] = place_near(place, FAR * margin, |p| {
                wide.certifier().point_is_free(p) && own.certifier().segment_is_free(place, p)
            })?;
            let clearance = own.certifier().clearance(&Trajectory::from_points(&[place]));
            // A hair more, so that the place itself does not count.
            let radius = distance(place, places[index]) * (1.0 + 1e-6);
            reach += radius;
            changes.push(EndChange { end, place, change: Change::Relaxed { radius, clearance } });
        }
        let some_is_kept = distance(ends[0], ends[1]) > reach;
        (!changes.is_empty() && some_is_kept).then_some(Self { own, wide, ends, places, changes })
    }

    /// Where the margin begins to be kept, and where it ends, `[dof]` each.
    pub fn places(&self) -> [&[f64]; 2] {
        [&self.places[0], &self.places[1]]
    }

    /// A path between the places, led on to the ends.
    pub fn joined(&self, path: &Trajectory) -> Trajectory {
        let beyond =
            |i: usize| if self.ends[i] == self.places[i] { &[][..] } else { &self.ends[i] };
        Trajectory::new(2, [beyond(0), path.values(), beyond(1)].concat())
    }

    /// Whether the robot may move straight from `a` to `b`, with the margin but where it is relaxed.
    pub fn motion_is_free(&self, a: &[f64], b: &[f64]) -> bool {
        let (a, b) = ([a[0], a[1]], [b[0], b[1]]);
        let wide = self.wide.certifier();
        self.own.certifier().segment_is_free(a, b)
            && (self.kept(a, b).into_iter())
                .all(|[from, to]| wide.segment_is_free(lerp(a, b, from), lerp(a, b, to)))
    }

    /// The parts of a segment that are not near such an end, as parameters from 0 to 1.
    fn kept(&self, a: Point, b: Point) -> Vec<[f64; 2]> {
        let d = sub(b, a);
        let square = d[0] * d[0] + d[1] * d[1];
        let mut parts = vec![[0.0, 1.0]];
        for change in &self.changes {
            let Change::Relaxed { radius, .. } = change.change else { continue };
            let from = sub(a, change.place);
            let half = from[0] * d[0] + from[1] * d[1];
            let rest = from[0] * from[0] + from[1] * from[1] - radius * radius;
            let root = half * half - square * rest;
            let inside = if square > 0.0 {
                let at = |sign: f64| (-half + sign * root.sqrt()) / square;
                (root >= 0.0).then(|| [at(-1.0), at(1.0)])
            } else {
                // A point is in it or not.
                (rest <= 0.0).then_some([0.0, 1.0])
            };
            if let Some([enter, leave]) = inside {
                let cut = |[from, to]: [f64; 2]| [[from, enter.min(to)], [leave.max(from), to]];
                parts = parts.into_iter().flat_map(cut).filter(|[from, to]| from < to).collect();
            }
        }
        parts
    }
}
