//! Fairing: a certified path bends less and stays certified at every move.
//!
//! Around each corner the path is given points at a distance h, and each of them is moved in turn to where
//! tension and bending of the line through its neighbours are least:
//!
//! E = ½ Σ |x_{i+1} − x_i|² + ½ (l / h)² Σ |x_{i−1} − 2 x_i + x_{i+1}|²
//!
//! A move is made as far as the certificate passes the two segments that it changes, or along the path alone
//! where it passes nothing else. So E falls, nothing is ever in collision, and whoever breaks off has a
//! plan. E's minimum is a spline in tension: it leaves a corner's neighbourhood like exp(−s / l), which is why
//! points are needed there only, and why the cost grows with the corners and not with the map.
//! Corners that stay sharper than wished are faired again with more points, then, because there may be no room for
//! so wide a bend, at half the length l, and so on; of all rounds the one counts that comes nearest to the wishes.

use crate::plan::polish::Wishes;
use crate::plane::opened;
use crate::trajectory::{Trajectory, distance};

/// Points to each length l around a corner, in turn: few points find the shape, many make it fine.
const POINTS_PER_LENGTH: [f64; 3] = [2.0, 4.0, 8.0];
/// How far around a corner points are moved, in lengths l.
const WINDOW: f64 = 4.0;
/// How often each point is moved, at each length.
const SWEEPS: usize = 30;
/// Rounds, three at each length l, which is then halved.
const ROUNDS: i32 = 12;
/// Parts of a move that are tried: beyond 1 it is over-relaxed, and below 2 E falls.
const PARTS: [f64; 4] = [1.6, 1.0, 0.5, 0.2];
/// Sweeps end where no point moves further than this part of h.
const STILL: f64 = 2e-3;
/// Turns above this are rounded whatever is wished, in radians.
const ROUNDED: f64 = 0.02;
/// Points come no nearer to each other than this part of h.
const SHORTEST: f64 = 0.4;
/// Most points that a window is given.
const MOST_POINTS: usize = 4000;

/// Fairs a certified path until it keeps the wishes, or nothing helps. `length` is l to
/// begin with, in task units; `is_free` is the certificate of a motion, and `go_on` is asked at each sweep.
/// The path keeps its ends, and is returned as it is where it bends nowhere.
pub fn fair(
    path: &Trajectory,
    length: f64,
    wishes: &Wishes,
    is_free: &dyn Fn(&[f64], &[f64]) -> bool,
    go_on: &dyn Fn() -> bool,
) -> Trajectory {
    let mut best = path.clone();
    let mut last = opened(path, length, is_free);
    let mut shortfall = f64::INFINITY;
    for round in 0..ROUNDS {
        // The first time every corner is rounded, then what is left of them.
        let (turn, radius) =
            if round == 0 { (wishes.turn.min(ROUNDED), 0.0) } else { (wishes.turn, wishes.radius) };
        let corners = corners(&last, turn, radius);
        if corners.is_empty() || !go_on() {
            break;
        }
        let length = length * 0.5f64.powi(round / 3);
        last =
            around(&last, &corners, length, POINTS_PER_LENGTH[round as usize % 3], is_free, go_on);
        let found = wishes.shortfall(&last);
        if found < shortfall {
            (shortfall, best) = (found, last.clone());
        }
    }
    best
}

/// Lengths along the path of the corners that are sharper than `turn` or tighter than `radius`.
fn corners(path: &Trajectory, turn: f64, radius: f64) -> Vec<f64> {
    let points: Vec<&[f64]> = path.configurations().collect();
    let mut passed = 0.0;
    let mut corners = Vec::new();
    for p in points.windows(3) {
        passed += distance(p[0], p[1]);
        let three = Trajectory::new(path.dof(), p.concat());
        if three.sharpest_turn() > turn || three.turning_radius() < radius {
            corners.push(passed);
        }
    }
    corners
}

/// Fairs the path within [`WINDOW`] lengths of the corners.
fn around(
    path: &Trajectory,
    corners: &[f64],
    length: f64,
    points_per_length: f64,
    is_free: &dyn Fn(&[f64], &[f64]) -> bool,
    go_on: &dyn Fn() -> bool,
) -> Trajectory {
    let total = path.length();
    // Windows begin and end at points that are there, where there is one near: else a short segment is left over.
    let mut places = vec![0.0];
    for (a, b) in path.segments() {
        places.push(places[places.len() - 1] + distance(a, b));
    }
    let snapped = |at: f64| {
        let after = places.partition_point(|&place| place < at);
        let near = [after.saturating_sub(1), after.min(places.len() - 1)].map(|i| places[i]);
        let near = if at - near[0] < near[1] - at { near[0] } else { near[1] };
        if (near - at).abs() < length / points_per_length { near } else { at }
    };
    let mut windows: Vec<[f64; 2]> = Vec::new();
    for corner in corners {
        let [from, to] = [corner - WINDOW * length, corner + WINDOW * length].map(&snapped);
        match windows.last_mut() {
            Some(last) if from <= last[1] => last[1] = to.min(total),
            _ => windows.push([from.max(0.0), to.min(total)]),
        }
    }
    let dof = path.dof();
    let mut faired: Vec<f64> = Vec::with_capacity(path.values().len());
    let mut done = 0.0;
    for [from, to] in windows {
        push_part(path, done, from, &mut faired);
        let part = part(path, from, to);
        let count = (points_per_length * (to - from) / length).ceil() as usize;
        let mut points = divided(dof, &part, count.clamp(2, MOST_POINTS));
        relax(dof, &mut points, length, is_free, go_on);
        push(dof, &mut faired, &points);
        done = to;
    }
    push_part(path, done, total, &mut faired);
    let certain = |faired: &Trajectory| faired.segments().all(|(a, b)| is_free(a, b));
    // The places where windows begin are rounded: a segment may have moved by that.
    let mut faired = Trajectory::new(dof, faired);
    set_ends(&mut faired, path);
    if certain(&faired) { faired } else { path.clone() }
}

/// Moves each inner point of `points [.. x dof]` in turn.
fn relax(
    dof: usize,
    points: &mut [f64],
    length: f64,
    is_free: &dyn Fn(&[f64], &[f64]) -> bool,
    go_on: &dyn Fn() -> bool,
) {
    let count = points.len() / dof;
    if count < 3 {
        return;
    }
    let whole: f64 = (1..count)
        .map(|i| distance(&points[(i - 1) * dof..i * dof], &points[i * dof..(i + 1) * dof]))
        .sum();
    let h = whole / (count - 1) as f64;
    let bending = (length / h).powi(2);
    let mut to = vec![0.0; dof];
    for sweep in 0..SWEEPS {
        let mut farthest = 0.0_f64;
        for step in 1..count - 1 {
            let i = if sweep % 2 == 0 { step } else { count - 1 - step };
            target(dof, points, i, bending, &mut to);
            farthest = farthest.max(shift(dof, points, i, &mut to, SHORTEST * h, is_free));
        }
        if farthest < STILL * h || !go_on() {
            break;
        }
    }
}

/// Where E is least for point `i`, all others being as they are.
fn target(dof: usize, points: &[f64], i: usize, bending: f64, to: &mut [f64]) {
    let count = points.len() / dof;
    for k in 0..dof {
        let at = |i: usize| points[i * dof + k];
        let (mut sum, mut weight) = (at(i - 1) + at(i + 1), 2.0);
        // Second differences around i − 1, i and i + 1, as far as there are such.
        sum += bending * 2.0 * (at(i - 1) + at(i + 1));
        weight += bending * 4.0;
        if i >= 2 {
            sum += bending * (2.0 * at(i - 1) - at(i - 2));
            weight += bending;
        }
        if i + 2 < count {
            sum += bending * (2.0 * at(i + 1) - at(i + 2));
            weight += bending;
        }
        to[k] = sum / weight;
    }
}

/// Moves point `i` towards `to` as far as that is free; how far it moved.
fn shift(
    dof: usize,
    points: &mut [f64],
    i: usize,
    to: &mut [f64],
    shortest: f64,
    is_free: &dyn Fn(&[f64], &[f64]) -> bool,
) -> f64 {
    let (before, rest) = points.split_at_mut(i * dof);
    let (here, after) = rest.split_at_mut(dof);
    let (from, next) = (&before[(i - 1) * dof..], &after[..dof]);
    for (to, here) in to.iter_mut().zip(here.iter()) {
        *to -= here;
    }
    let mut attempt = |way: &[f64], part: f64| {
        let place: [f64; MOST_DOF] =
            std::array::from_fn(|k| if k < dof { here[k] + part * way[k] } else { 0.0 });
        let place = &place[..dof];
        // Points must not gather at an obstacle.
        let keeps = |at: &[f64]| distance(at, place) >= shortest.min(distance(at, here));
        let free = keeps(from) && keeps(next) && is_free(from, place) && is_free(place, next);
        if free {
            here.copy_from_slice(place);
        }
        free
    };
    let size = |way: &[f64]| way.iter().map(|x| x * x).sum::<f64>().sqrt();
    for part in PARTS {
        if attempt(to, part) {
            return part * size(to);
        }
    }
    // Along the path alone: it evens out the distances between points that lie on an obstacle.
    let chord = distance(from, next);
    if chord > 0.0 {
        let dot: f64 = (0..dof).map(|k| to[k] * (next[k] - from[k])).sum::<f64>() / (chord * chord);
        for k in 0..dof {
            to[k] = dot * (next[k] - from[k]);
        }
        if attempt(to, 1.0) {
            return size(to);
        }
    }
    0.0
}

/// Most coordinates of a configuration that is faired.
pub const MOST_DOF: usize = 64;

/// The path between two lengths along it, `[.. x dof]`.
fn part(path: &Trajectory, from: f64, to: f64) -> Vec<f64> {
    let mut points = Vec::new();
    push_part(path, from, to, &mut points);
    points
}

/// Appends the path between two lengths along it; the first point is left out where it is there already.
fn push_part(path: &Trajectory, from: f64, to: f64, points: &mut Vec<f64>) {
    if to <= from {
        return;
    }
    let dof = path.dof();
    let mut passed = 0.0;
    for (a, b) in path.segments() {
        let length = distance(a, b);
        let (begin, end) = (from.max(passed), to.min(passed + length));
        if end > begin || length == 0.0 && begin == end && from == begin {
            let at = |along: f64| -> Vec<f64> {
                let t = ((along - passed) / length).clamp(0.0, 1.0);
                match t {
                    0.0 => a.to_vec(),
                    1.0 => b.to_vec(),
                    _ => a.iter().zip(b).map(|(a, b)| a + t * (b - a)).collect(),
                }
            };
            if length > 0.0 {
                push(dof, points, &at(begin));
                push(dof, points, &at(end));
            }
        }
        passed += length;
    }
}

/// Appends points that do not repeat the last one, as far as rounding can tell.
fn push(dof: usize, to: &mut Vec<f64>, points: &[f64]) {
    for point in points.chunks_exact(dof) {
        let size = point.iter().fold(1e-300_f64, |size, x| size.max(x.abs()));
        let repeats = to.len() >= dof && distance(&to[to.len() - dof..], point) < 1e-12 * size;
        if !repeats {
            to.extend_from_slice(point);
        }
    }
}

/// The points of a path `[.. x dof]` with others between them, so that there are some `count` in all.
fn divided(dof: usize, points: &[f64], count: usize) -> Vec<f64> {
    let path = Trajectory::new(dof, points.to_vec());
    let h = path.length() / count as f64;
    let mut all = Vec::with_capacity((count + path.len()) * dof);
    for (a, b) in path.segments() {
        let parts = (distance(a, b) / h).round().max(1.0) as usize;
        for part in 0..parts {
            let t = part as f64 / parts as f64;
            all.extend(a.iter().zip(b).map(|(a, b)| a + t * (b - a)));
        }
    }
    all.extend_from_slice(&points[points.len() - dof..]);
    all
}

/// Gives a path the exact ends of another.
fn set_ends(path: &mut Trajectory, of: &Trajectory) {
    let (dof, mut values) = (path.dof(), path.values().to_vec());
    let last = values.len() - dof;
    values[..dof].copy_from_slice(&of.values()[..dof]);
    values[last..].copy_from_slice(&of.values()[of.values().len() - dof..]);
    *path = Trajectory::new(dof, values);
}
