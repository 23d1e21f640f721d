//! Opens the arcs of a path: where it hugs an obstacle over many short segments, the lines before and after meet
//! in one corner outside of the arc, if that is free. So there is room to bend, and points can be spread evenly.

use crate::trajectory::Trajectory;

/// An arc that is opened turns by no more than this, in radians: else its corner lies far out.
const MOST_TURN: f64 = 1.9;
/// Scales at which arcs are looked for, each half of the one before.
const SCALES: i32 = 4;

/// The path in the plane with its arcs of at most `scale` opened, then those of half of it, and so on.
pub fn opened(
    path: &Trajectory,
    scale: f64,
    is_free: &dyn Fn(&[f64], &[f64]) -> bool,
) -> Trajectory {
    if path.dof() != 2 || path.len() < 4 {
        return path.clone();
    }
    let mut points = path.values().as_chunks::<2>().0.to_vec();
    for halving in 0..SCALES {
        open_once(&mut points, scale * 0.5f64.powi(halving), is_free);
    }
    Trajectory::from_points(&points)
}

fn open_once(points: &mut Vec<[f64; 2]>, scale: f64, is_free: &dyn Fn(&[f64], &[f64]) -> bool) {
    let mut i = 0;
    while i + 3 < points.len() {
        // The longest arc between the segment that begins at i and one that ends at j + 1.
        let mut opened = None;
        let (mut turn, mut length) = (0.0_f64, 0.0);
        for j in i + 1..points.len() - 1 {
            let next = turn_at(points[j - 1], points[j], points[j + 1]);
            if j > i + 1 {
                length += segment(points[j - 1], points[j]);
            }
            if turn * next < 0.0 || (turn + next).abs() > MOST_TURN || length > scale {
                break;
            }
            turn += next;
            if j > i + 1
                && let Some(corner) = meet(points[i], points[i + 1], points[j], points[j + 1])
                && is_free(&points[i], &corner)
                && is_free(&corner, &points[j + 1])
            {
                opened = Some((j, corner));
            }
        }
        if let Some((j, corner)) = opened {
            points.splice(i + 1..=j, [corner]);
        }
        i += 1;
    }
}

fn segment(a: [f64; 2], b: [f64; 2]) -> f64 {
    (b[0] - a[0]).hypot(b[1] - a[1])
}

/// The signed turn at b, in radians.
fn turn_at(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    let (u, v) = ([b[0] - a[0], b[1] - a[1]], [c[0] - b[0], c[1] - b[1]]);
    (u[0] * v[1] - u[1] * v[0]).atan2(u[0] * v[0] + u[1] * v[1])
}

/// Where the line a b beyond b meets the line c d before c.
fn meet(a: [f64; 2], b: [f64; 2], c: [f64; 2], d: [f64; 2]) -> Option<[f64; 2]> {
    let (u, v, w) =
        ([b[0] - a[0], b[1] - a[1]], [d[0] - c[0], d[1] - c[1]], [c[0] - a[0], c[1] - a[1]]);
    let cross = u[0] * v[1] - u[1] * v[0];
    let (s, t) = ((w[0] * v[1] - w[1] * v[0]) / cross, (w[0] * u[1] - w[1] * u[0]) / cross);
    let corner = [a[0] + s * u[0], a[1] + s * u[1]];
    (s >= 1.0 && t <= 0.0 && corner[0].is_finite() && corner[1].is_finite()).then_some(corner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_arc_becomes_a_corner_where_that_is_free() {
        let arc = |i: usize| {
            let angle = std::f64::consts::FRAC_PI_2 * (i as f64 / 8.0 - 1.0);
            [5.0 + 0.5 * angle.cos(), 0.5 + 0.5 * angle.sin()]
        };
        let points: Vec<[f64; 2]> =
            [[0.0, 0.0]].into_iter().chain((0..=8).map(arc)).chain([[5.5, 6.0]]).collect();
        let path = Trajectory::from_points(&points);
        let open = opened(&path, 1.0, &|_, _| true);
        assert_eq!(open.len(), 3, "{open:?}");
        assert!(segment([open.values()[2], open.values()[3]], [5.5, 0.0]) < 1e-9);
        assert_eq!(opened(&path, 1.0, &|_, _| false), path);
        // Too long an arc stays at this scale.
        assert!(opened(&path, 0.1, &|_, _| true).len() > 5);
    }
}
