//! Makes a certified path shorter by certified short cuts.
//!
//! Vertex removal and random short cuts as in the plane (R. Geraerts and M. Overmars, Creating
//! high-quality paths for motion planning, IJRR 2007, doi:10.1177/0278364907079280, section 4). Neither
//! makes the path longer.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::{along, distance};
use crate::arm::certificate::{Certifier, Work};

/// Shortens a certified path `[waypoints x dof]` in place; it stays certified and keeps its ends.
///
/// `rounds` random short cuts are tried, with vertex removal before and after them. Returns the
/// number of motions judged.
pub fn shortcut(
    path: &mut Vec<f64>,
    certifier: &Certifier,
    work: &mut Work,
    rounds: usize,
    rng: &mut ChaCha8Rng,
) -> usize {
    let dof = certifier.arm().dof();
    let mut checks = remove_vertices(path, certifier, work);
    let (mut p, mut q) = (vec![0.0; dof], vec![0.0; dof]);
    for _ in 0..rounds {
        let count = path.len() / dof;
        if count < 3 {
            break;
        }
        let node = |i: usize| &path[i * dof..][..dof];
        let length: f64 = (1..count).map(|i| distance(node(i - 1), node(i))).sum();
        let mut at = [0, 1].map(|_| length * rng.random::<f64>());
        at.sort_by(f64::total_cmp);
        let i = place(path, dof, at[0], &mut p);
        let j = place(path, dof, at[1], &mut q);
        if i == j {
            continue;
        }
        // The two pieces that are left of segments i and j are new motions to certify, since rounding moves p and q off
        // them by a hair.
        checks += 1;
        if !certifier.motion_is_free(&p, &q, work) {
            continue;
        }
        checks += 2;
        if certifier.motion_is_free(node(i), &p, work)
            && certifier.motion_is_free(&q, node(j + 1), work)
        {
            path.splice((i + 1) * dof..(j + 1) * dof, p.iter().chain(&q).copied());
        }
    }
    checks + remove_vertices(path, certifier, work)
}

/// The segment at a length along the path; `out` is the configuration there.
fn place(path: &[f64], dof: usize, mut length: f64, out: &mut [f64]) -> usize {
    let last = path.len() / dof - 2;
    let mut segment = 0;
    loop {
        let (a, b) = (&path[segment * dof..][..dof], &path[(segment + 1) * dof..][..dof]);
        let whole = distance(a, b);
        if length <= whole || segment == last {
            let t = if whole > 0.0 { (length / whole).clamp(0.0, 1.0) } else { 0.0 };
            along(a, b, t, out);
            return segment;
        }
        length -= whole;
        segment += 1;
    }
}

/// From each waypoint, goes straight on to the last one that it sees. Returns the number of checks.
fn remove_vertices(path: &mut Vec<f64>, certifier: &Certifier, work: &mut Work) -> usize {
    let dof = certifier.arm().dof();
    let (mut checks, mut from) = (0, 0);
    while (from + 2) * dof < path.len() {
        let node = |i: usize| &path[i * dof..][..dof];
        let seen = (from + 2..path.len() / dof).rev().find(|&to| {
            checks += 1;
            certifier.motion_is_free(node(from), node(to), work)
        });
        if let Some(to) = seen {
            path.drain((from + 1) * dof..to * dof);
        }
        from += 1;
    }
    checks
}
