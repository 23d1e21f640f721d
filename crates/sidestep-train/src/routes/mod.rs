//! Routes of a task as trajectories of N waypoints: what experts follow.
//!
//! In the plane there are two ways to find them, by how obstacles are grown before the search. They shape
//! what was trained with them, so neither replaces the other. Robots with joints have optimizers and
//! trees (`jointed.rs`).

pub mod evenly_grown;
pub mod jointed;
pub mod sparingly_grown;

/// Margins to obstacles that are tried, widest first, in normalised units.
const MARGINS: [f64; 5] = [0.25, 0.15, 0.08, 0.035, 0.005];
/// A margin m is taken if its path is no longer than `STRETCH L + SLACK m + ROOM`, L being the
/// shortest; normalised units.
const STRETCH: f64 = 1.12;
const SLACK: f64 = 4.0;
const ROOM: f64 = 0.2;
/// An alternative may be as long as `ALTERNATIVE_STRETCH L + ALTERNATIVE_ROOM`, in normalised
/// units.
const ALTERNATIVE_STRETCH: f64 = 1.6;
const ALTERNATIVE_ROOM: f64 = 1.2;
/// Mean distance of waypoints, in normalised units (5 pixels), from which on two routes are
/// different.
const DIFFERENT: f32 = 0.5;
/// How much of a route's extra length counts against it, beside its mean distance from the
/// trajectory.
const EXTRA: f32 = 0.15;

/// A route as an expert follows it.
#[derive(Debug, Clone, PartialEq)]
pub struct Target {
    /// The waypoints, `[N x dof]`, normalised units.
    pub waypoints: Vec<f32>,
    /// Length beyond the shortest path's, normalised units.
    pub extra: f32,
}

/// The route nearest to the waypoints `x [N x dof]`: least mean distance plus a share of the extra
/// length. Following the nearest and not the shortest keeps the two sides of an obstacle from
/// averaging into it.
pub fn nearest<'a>(dof: usize, targets: &'a [Target], x: &[f32]) -> Option<&'a [f32]> {
    let score = |target: &Target| mean_distance(dof, &target.waypoints, x) + EXTRA * target.extra;
    let best = targets.iter().min_by(|a, b| score(a).total_cmp(&score(b)))?;
    Some(&best.waypoints)
}

/// Mean distance of the waypoints of two trajectories `[N x dof]`.
pub fn mean_distance(dof: usize, a: &[f32], b: &[f32]) -> f32 {
    let distance = |(p, q): (&[f32], &[f32])| {
        let mut ways = p.iter().zip(q).map(|(p, q)| p - q);
        let first = ways.next().unwrap_or(0.0).abs();
        ways.fold(first, f32::hypot)
    };
    let sum: f32 = a.chunks_exact(dof).zip(b.chunks_exact(dof)).map(distance).sum();
    sum / (a.len() / dof).max(1) as f32
}
