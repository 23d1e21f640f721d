//! A path of straight pieces and parabolas, by its arc: `q(s)`.
//!
//! A corner between directions u and v is cut r before and after it by the parabola with those
//! three control points: for t in [0, 1], `q = (1-t)^2 (c - r u) + 2 t (1-t) c + t^2 (c + r v)`,
//! with s = 2 r t, so that `q' = u + t (v - u)` goes on without a jump and `q'' = (v - u) / (2 r)`
//! is constant. The parabola stays in the triangle of its control points, and passes the corner at
//! `r |v - u| / 4`. A corner that is not cut is stopped at. Lengths are Euclidean in joint space.

use crate::error::{InvalidInput, finite};

/// Below this length (rad or m) two configurations are the same one.
const SAME: f64 = 1e-9;

/// A corner whose directions are nearly opposite is stopped at: |u + v| below this.
const TURN_BACK: f64 = 0.1;

/// A path through configurations, `[N x dof]` flat.
#[derive(Debug, Clone, PartialEq)]
pub struct Path {
    dof: usize,
    pieces: Vec<Piece>,
}

/// A part of a path on which `q''` is constant.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Piece {
    /// Where it begins, and how long it is in s.
    pub(super) start: f64,
    pub(super) length: f64,
    /// q, q' at its beginning and q'' on all of it, each `[dof]`.
    pub(super) position: Vec<f64>,
    pub(super) slope: Vec<f64>,
    pub(super) bend: Vec<f64>,
    /// Whether the robot stands still at its beginning.
    pub(super) stop: bool,
}

impl Path {
    /// Straight lines between configurations (`[N x dof]`, N at least 2), with a stop at each.
    ///
    /// # Errors
    /// As [`Self::blended`].
    pub fn polyline(waypoints: &[f64], dof: usize) -> Result<Self, InvalidInput> {
        let corners = waypoints.len().checked_div(dof).unwrap_or(0).saturating_sub(2);
        Self::blended(waypoints, dof, &vec![0.0; corners])
    }

    /// Straight lines between configurations (`[N x dof]`, N at least 2); the inner corner i is cut
    /// `reach[i]` (rad or m, in joint space) before and after it, and stopped at where that is 0 or
    /// the path turns back. Whether the robot may go there has to be certified by who asks.
    ///
    /// # Errors
    /// If a number is not finite, the lengths do not fit `dof`, all waypoints are one, or reaches
    /// overlap.
    pub fn blended(waypoints: &[f64], dof: usize, reach: &[f64]) -> Result<Self, InvalidInput> {
        if dof == 0 || waypoints.len() < 2 * dof || !waypoints.len().is_multiple_of(dof) {
            let found = format!("{} numbers for {dof} joints", waypoints.len());
            return Err(InvalidInput::new("waypoints", found, "two whole configurations or more"));
        }
        for (i, &value) in waypoints.iter().enumerate() {
            finite(&format!("waypoints[{}][{}]", i / dof, i % dof), value)?;
        }
        let n = waypoints.len() / dof;
        if reach.len() != n - 2 {
            let found = format!("{} reaches", reach.len());
            return Err(InvalidInput::new("reach", found, format!("{}, one a corner", n - 2)));
        }
        for (i, &reach) in reach.iter().enumerate() {
            if !(reach >= 0.0 && reach.is_finite()) {
                return Err(InvalidInput::new(format!("reach[{i}]"), reach, "at least 0"));
            }
        }
        // Each waypoint that is not its predecessor again, with what is cut from its corner.
        let mut corners: Vec<(&[f64], f64)> = vec![(&waypoints[..dof], 0.0)];
        for (i, waypoint) in waypoints.chunks_exact(dof).enumerate().skip(1) {
            let cut = if i < n - 1 { reach[i - 1] } else { 0.0 };
            if distance(corners[corners.len() - 1].0, waypoint) > SAME {
                corners.push((waypoint, cut));
            }
        }
        if corners.len() < 2 {
            return Err(InvalidInput::new("waypoints", "one configuration", "two that differ"));
        }
        if let Some(last) = corners.last_mut() {
            last.1 = 0.0;
        }
        Self::through(&corners, dof)
    }

    fn through(corners: &[(&[f64], f64)], dof: usize) -> Result<Self, InvalidInput> {
        let mut pieces: Vec<Piece> = Vec::new();
        let mut start = 0.0;
        let mut cut_before = 0.0;
        // Whether the robot stands still where the next piece begins.
        let mut stop = true;
        for i in 0..corners.len() - 1 {
            let ((from, _), (to, mut cut)) = (corners[i], corners[i + 1]);
            let length = distance(from, to);
            let direction: Vec<f64> =
                from.iter().zip(to).map(|(from, to)| (to - from) / length).collect();
            let next = corners.get(i + 2).map(|(next, _)| {
                let length = distance(to, next);
                to.iter().zip(*next).map(|(to, next)| (next - to) / length).collect::<Vec<f64>>()
            });
            let turns_back = next.as_ref().is_none_or(|next| {
                let sum = direction.iter().zip(next).map(|(u, v)| (u + v) * (u + v));
                sum.sum::<f64>().sqrt() < TURN_BACK
            });
            if turns_back || cut < SAME {
                cut = 0.0;
            }
            let straight = length - cut_before - cut;
            if straight < -1e-12 * length {
                let found = format!("{cut_before} and {cut} on a side of {length}");
                let allowed = "two that fit on the side between them";
                return Err(InvalidInput::new("reach", found, allowed));
            }
            if straight > SAME {
                let position = along(from, &direction, cut_before);
                pieces.push(Piece {
                    start,
                    length: straight,
                    position,
                    slope: direction.clone(),
                    bend: vec![0.0; dof],
                    stop,
                });
                start += straight;
                stop = false;
            }
            if let Some(next) = next.filter(|_| cut > 0.0) {
                let bend = direction.iter().zip(&next).map(|(u, v)| (v - u) / (2.0 * cut));
                pieces.push(Piece {
                    start,
                    length: 2.0 * cut,
                    position: along(to, &direction, -cut),
                    bend: bend.collect(),
                    slope: direction,
                    stop,
                });
                start += 2.0 * cut;
                stop = false;
            }
            stop |= cut == 0.0;
            cut_before = cut;
        }
        Ok(Self { dof, pieces })
    }

    /// Numbers of a configuration.
    pub fn dof(&self) -> usize {
        self.dof
    }

    /// Length of the whole in s: rad or m; a parabola counts as its two tangents.
    pub fn length(&self) -> f64 {
        self.pieces.last().map_or(0.0, |piece| piece.start + piece.length)
    }

    pub(super) fn pieces(&self) -> &[Piece] {
        &self.pieces
    }
}

impl Piece {
    /// `q'_j` at `ds` behind its beginning.
    pub(super) fn slope_at(&self, j: usize, ds: f64) -> f64 {
        self.slope[j] + self.bend[j] * ds
    }

    /// `q_j` at `ds` behind its beginning.
    pub(super) fn position_at(&self, j: usize, ds: f64) -> f64 {
        self.position[j] + ds * (self.slope[j] + 0.5 * self.bend[j] * ds)
    }
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

fn along(from: &[f64], direction: &[f64], by: f64) -> Vec<f64> {
    from.iter().zip(direction).map(|(from, direction)| from + by * direction).collect()
}
