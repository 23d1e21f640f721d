//! Makes a certified path shorter by certified short cuts.
//!
//! Two moves: *vertex removal* skips the points between two that see each other, and a *random short cut*
//! joins two random places on the path where the straight line between them is free (R. Geraerts and
//! M. Overmars, Creating high-quality paths for motion planning, IJRR 2007,
//! doi:10.1177/0278364907079280, section 4). Neither makes the path longer.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::plane::certificate::Certifier;
use crate::plane::geometry::{Point, distance, lerp};

/// Shortens a certified path in place; it stays certified and keeps its ends.
///
/// `rounds` random short cuts are tried, with vertex removal before and after them. Returns the
/// number of segments checked.
pub fn shortcut(
    points: &mut Vec<Point>,
    certifier: &Certifier,
    rounds: usize,
    rng: &mut ChaCha8Rng,
) -> usize {
    let mut checks = remove_vertices(points, certifier);
    for _ in 0..rounds {
        if points.len() < 3 {
            break;
        }
        let length: f64 = points.windows(2).map(|pair| distance(pair[0], pair[1])).sum();
        let mut at = [0, 1].map(|_| length * rng.random::<f64>());
        at.sort_by(f64::total_cmp);
        let [(i, p), (j, q)] = at.map(|along| place(points, along));
        if i < j {
            checks += 3;
            // The two pieces that are left of segments i and j are new segments to certify, since
            // rounding moves p and q off them by a hair.
            let free = |a, b| certifier.segment_is_free(a, b);
            if free(p, q) && free(points[i], p) && free(q, points[j + 1]) {
                points.splice(i + 1..=j, [p, q]);
            }
        }
    }
    checks + remove_vertices(points, certifier)
}

/// The segment at a length along the path, and the point there.
fn place(points: &[Point], mut along: f64) -> (usize, Point) {
    let last = points.len() - 2;
    for i in 0..last {
        let length = distance(points[i], points[i + 1]);
        if along <= length && length > 0.0 {
            return (i, lerp(points[i], points[i + 1], along / length));
        }
        along -= length;
    }
    let length = distance(points[last], points[last + 1]);
    let t = if length > 0.0 { (along / length).clamp(0.0, 1.0) } else { 0.0 };
    (last, lerp(points[last], points[last + 1], t))
}

/// From each point, goes straight on to the last one that it sees. Returns the number of checks.
fn remove_vertices(points: &mut Vec<Point>, certifier: &Certifier) -> usize {
    let mut checks = 0;
    let mut from = 0;
    while from + 2 < points.len() {
        let sees = |to: &usize| {
            checks += 1;
            certifier.segment_is_free(points[from], points[*to])
        };
        if let Some(to) = (from + 2..points.len()).rev().find(sees) {
            points.drain(from + 1..to);
        }
        from += 1;
    }
    checks
}
