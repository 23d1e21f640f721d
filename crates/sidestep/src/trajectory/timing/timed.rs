//! A path with its timing: where the robot is at a time.

use super::limits::Limits;
use super::path::{Path, Piece};
use super::reachability::fastest;
use crate::error::InvalidInput;

/// Intervals of the whole path; a piece has at least [`LEAST`] of them. On paths of up to twelve
/// waypoints the times are then within 0.4 % of those on a grid without end.
const INTERVALS: f64 = 800.0;
const LEAST: usize = 64;

/// A path and when the robot passes each of its points.
#[derive(Debug, Clone, PartialEq)]
pub struct TimedPath {
    dof: usize,
    pieces: Vec<Piece>,
    knots: Vec<Knot>,
    duration: f64,
}

/// The beginning of an interval with constant `s̈`.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Knot {
    time: f64,
    piece: usize,
    /// How far behind the piece's beginning.
    ds: f64,
    /// `ṡ` and `s̈`.
    speed: f64,
    acceleration: f64,
}

/// Where joints are at a time and how they move, each `[dof]`; rad and s, or m.
#[derive(Debug, Clone, PartialEq)]
pub struct Moment {
    /// Seconds from the start.
    pub time: f64,
    /// Configuration.
    pub position: Vec<f64>,
    /// Its first derivative.
    pub velocity: Vec<f64>,
    /// Its second derivative; where it jumps, from then on.
    pub acceleration: Vec<f64>,
}

/// The fastest timing of a path, from rest to rest, that keeps every joint within its limits all
/// the time.
///
/// The times are those of a grid of some 800 intervals, and up to half a percent above the least.
///
/// # Errors
/// If there are not as many limits as joints.
pub fn time_path(path: &Path, limits: &Limits) -> Result<TimedPath, InvalidInput> {
    if limits.dof() != path.dof() {
        let found = format!("{} joints", limits.dof());
        return Err(InvalidInput::new("limits", found, format!("{}, as the path has", path.dof())));
    }
    let pieces = path.pieces();
    let (total, mut knots, mut time) = (path.length(), Vec::new(), 0.0);
    let mut first = 0;
    while first < pieces.len() {
        let rest = pieces[first + 1..].iter().position(|piece| piece.stop);
        let end = rest.map_or(pieces.len(), |i| first + 1 + i);
        let mut grid = Vec::new();
        for piece in first..end {
            let length = pieces[piece].length;
            let count = ((INTERVALS * length / total).ceil() as usize).max(LEAST);
            let at = |i: usize| length * i as f64 / count as f64;
            grid.extend((0..count).map(|i| (piece, at(i), at(i + 1))));
        }
        let x = fastest(pieces, &grid, limits);
        for (i, &(piece, ds, to)) in grid.iter().enumerate() {
            let (speed, next) = (x[i].sqrt(), x[i + 1].sqrt());
            let acceleration = 0.5 * (x[i + 1] - x[i]) / (to - ds);
            knots.push(Knot { time, piece, ds, speed, acceleration });
            time += 2.0 * (to - ds) / (speed + next);
        }
        first = end;
    }
    Ok(TimedPath { dof: path.dof(), pieces: pieces.to_vec(), knots, duration: time })
}

impl TimedPath {
    /// Seconds from start to end.
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// Numbers of a configuration.
    pub fn dof(&self) -> usize {
        self.dof
    }

    /// Where the robot is `time` seconds after its start; before that at the start, after the end
    /// at the end, at rest in both cases.
    pub fn at(&self, time: f64) -> Moment {
        let after = self.knots.partition_point(|knot| knot.time <= time);
        let knot = &self.knots[after.saturating_sub(1)];
        let piece = &self.pieces[knot.piece];
        let dt = (time.min(self.duration) - knot.time).max(0.0);
        let ds = knot.ds + dt * (knot.speed + 0.5 * knot.acceleration * dt);
        let resting = !(0.0..self.duration).contains(&time);
        let ds = if time >= self.duration { piece.length } else { ds.min(piece.length) };
        let speed = if resting { 0.0 } else { (knot.speed + knot.acceleration * dt).max(0.0) };
        let acceleration = if resting { 0.0 } else { knot.acceleration };
        let joints = 0..self.dof;
        let slope = |j: usize| piece.slope_at(j, ds);
        Moment {
            time,
            position: joints.clone().map(|j| piece.position_at(j, ds)).collect(),
            velocity: joints.clone().map(|j| slope(j) * speed).collect(),
            acceleration: joints
                .map(|j| slope(j) * acceleration + piece.bend[j] * speed * speed)
                .collect(),
        }
    }

    /// Moments every `period` seconds from the start, and the end; strictly increasing in time.
    ///
    /// # Errors
    /// If the period is not a number above 0, or there would be more than ten million.
    pub fn sampled(&self, period: f64) -> Result<Vec<Moment>, InvalidInput> {
        let most = 1e7;
        if !(period > 0.0 && period.is_finite() && self.duration / period <= most) {
            let allowed = format!("a number of seconds of at least {}", self.duration / most);
            return Err(InvalidInput::new("period", period, allowed));
        }
        // A last period of next to nothing would make two moments of one.
        let count = (self.duration / period - 1e-6).ceil().max(1.0) as usize;
        let mut moments: Vec<Moment> = (0..count).map(|i| self.at(i as f64 * period)).collect();
        moments.push(self.at(self.duration));
        Ok(moments)
    }
}
