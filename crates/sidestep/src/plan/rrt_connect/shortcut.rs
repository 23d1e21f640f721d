//! Makes a certified path shorter by certified short cuts.
//!
//! Two moves: *vertex removal* skips the points between two that see each other, and a *random short cut*
//! joins two random places on the path where the straight line between them is free (R. Geraerts and
//! M. Overmars, Creating high-quality paths for motion planning, IJRR 2007,
//! doi:10.1177/0278364907079280, section 4). Neither makes the path longer.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::lerp;
use crate::trajectory::{Trajectory, distance};

/// With more than two coordinates, a short cut at least this part of what it cuts off is not worth its proof.
const WORTH: f64 = 0.999;

/// Shortens a certified path in place; it stays certified, as `is_free(from, to)` says of motions, and keeps its ends.
///
/// `rounds` random short cuts are tried, with vertex removal before and after them. Returns the
/// number of segments checked.
pub fn shortcut(
    path: &mut Trajectory,
    is_free: impl Fn(&[f64], &[f64]) -> bool,
    rounds: usize,
    rng: &mut ChaCha8Rng,
) -> usize {
    // Two coordinates have a copy of their own, whose loops the compiler unrolls.
    match path.dof() {
        2 => shortcut_in(2, path, is_free, rounds, rng),
        dof => shortcut_in(dof, path, is_free, rounds, rng),
    }
}

#[inline(always)]
fn shortcut_in(
    dof: usize,
    path: &mut Trajectory,
    is_free: impl Fn(&[f64], &[f64]) -> bool,
    rounds: usize,
    rng: &mut ChaCha8Rng,
) -> usize {
    let mut points = path.values().to_vec();
    let mut checks = remove_vertices(dof, &mut points, &is_free);
    // Two places on the path, one after the other.
    let mut cut = vec![0.0; 2 * dof];
    for _ in 0..rounds {
        if points.len() < 3 * dof {
            break;
        }
        let at = |i: usize| &points[i * dof..][..dof];
        let length: f64 = (0..points.len() / dof - 1).map(|i| distance(at(i), at(i + 1))).sum();
        let mut along = [0, 1].map(|_| length * rng.random::<f64>());
        along.sort_by(f64::total_cmp);
        let (p, q) = cut.split_at_mut(dof);
        let (i, j) = (place(dof, &points, along[0], p), place(dof, &points, along[1], q));
        // Where the path is as good as straight there is nothing to win.
        let wins = dof == 2 || distance(p, q) < WORTH * (along[1] - along[0]);
        if i < j && wins {
            checks += 3;
            // The two pieces that are left of segments i and j are new segments to certify, since
            // rounding moves p and q off them by a hair.
            if is_free(p, q) && is_free(at(i), p) && is_free(q, at(j + 1)) {
                points.splice((i + 1) * dof..(j + 1) * dof, cut.iter().copied());
            }
        }
    }
    checks += remove_vertices(dof, &mut points, &is_free);
    *path = Trajectory::new(dof, points);
    checks
}

/// The segment at a length along the path `points [.. x dof]`; the configuration there is written to `out`.
#[inline(always)]
fn place(dof: usize, points: &[f64], mut along: f64, out: &mut [f64]) -> usize {
    let at = |i: usize| &points[i * dof..][..dof];
    let last = points.len() / dof - 2;
    for i in 0..last {
        let length = distance(at(i), at(i + 1));
        if along <= length && length > 0.0 {
            lerp(at(i), at(i + 1), along / length, out);
            return i;
        }
        along -= length;
    }
    let length = distance(at(last), at(last + 1));
    let t = if length > 0.0 { (along / length).clamp(0.0, 1.0) } else { 0.0 };
    lerp(at(last), at(last + 1), t, out);
    last
}

/// From each configuration, goes straight on to the last one that it sees. Returns the number of checks.
#[inline(always)]
pub fn remove_vertices(
    dof: usize,
    points: &mut Vec<f64>,
    is_free: &impl Fn(&[f64], &[f64]) -> bool,
) -> usize {
    let mut checks = 0;
    let mut from = 0;
    while from + 2 < points.len() / dof {
        let at = |i: usize| &points[i * dof..][..dof];
        let sees = |to: &usize| {
            checks += 1;
            is_free(at(from), at(*to))
        };
        if let Some(to) = (from + 2..points.len() / dof).rev().find(sees) {
            points.drain((from + 1) * dof..to * dof);
        }
        from += 1;
    }
    checks
}
