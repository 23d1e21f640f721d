//! Waypoints `[N x dof]` in normalised units, the ends left out: lines to begin from, and bends.

use rand_chacha::ChaCha8Rng;

use crate::rng::standard_normal;

/// Writes the evenly spaced straight line between two configurations `[dof]` to `x [N x dof]`.
pub fn straight_line(start: &[f32], goal: &[f32], x: &mut [f32]) {
    let dof = start.len();
    let segments = (x.len() / dof + 1) as f32;
    for (i, p) in x.chunks_exact_mut(dof).enumerate() {
        let t = (i + 1) as f32 / segments;
        for ((p, start), goal) in p.iter_mut().zip(start).zip(goal) {
            *p = start + t * (goal - start);
        }
    }
}

/// Spreads `x [N x dof]` evenly by length along the polyline through `corners [K x dof]`, at least two, its ends left out.
pub fn polyline(dof: usize, corners: &[f32], x: &mut [f32]) {
    let at = |corner: usize| &corners[corner * dof..][..dof];
    let length = |corner: usize| {
        let mut ways = at(corner).iter().zip(at(corner + 1)).map(|(a, b)| b - a);
        let first = ways.next().unwrap_or(0.0).abs();
        ways.fold(first, f32::hypot)
    };
    let legs: Vec<f32> = (0..corners.len() / dof - 1).map(length).collect();
    let total: f32 = legs.iter().sum();
    let segments = (x.len() / dof + 1) as f32;
    let mut leg = 0;
    let mut passed = 0.0;
    for (i, p) in x.chunks_exact_mut(dof).enumerate() {
        let target = total * (i + 1) as f32 / segments;
        while leg + 1 < legs.len() && passed + legs[leg] < target {
            passed += legs[leg];
            leg += 1;
        }
        let part = legs[leg];
        let t = if part > 0.0 { ((target - passed) / part).clamp(0.0, 1.0) } else { 0.0 };
        for ((p, a), b) in p.iter_mut().zip(at(leg)).zip(at(leg + 1)) {
            *p = a + t * (b - a);
        }
    }
}

/// Adds smooth noise to the waypoints `x [N x dof]`: sine modes 1 to 4 along the trajectory, mode k with standard
/// deviation `size` / k in each coordinate, in normalised units.
pub fn bend(dof: usize, x: &mut [f32], size: f32, rng: &mut ChaCha8Rng) {
    let segments = (x.len() / dof + 1) as f32;
    for mode in 1..=4 {
        let noise: Vec<f32> = (0..dof.div_ceil(2))
            .flat_map(|_| standard_normal(rng).map(|z| size / mode as f32 * z))
            .collect();
        for (i, p) in x.chunks_exact_mut(dof).enumerate() {
            let shape = (std::f32::consts::PI * mode as f32 * (i + 1) as f32 / segments).sin();
            p.iter_mut().zip(&noise).for_each(|(p, noise)| *p += shape * noise);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{Purpose, stream};

    #[test]
    fn lines_are_even_in_any_number_of_coordinates() {
        let (start, goal) = ([0.0, 1.0, -2.0], [4.0, 1.0, 2.0]);
        let (mut line, mut along) = ([0.0; 9], [0.0; 9]);
        straight_line(&start, &goal, &mut line);
        assert_eq!(line, [1.0, 1.0, -1.0, 2.0, 1.0, 0.0, 3.0, 1.0, 1.0]);
        polyline(3, &[start, goal].concat(), &mut along);
        assert!(line.iter().zip(along).all(|(a, b)| (a - b).abs() < 1e-6));
    }

    #[test]
    fn bends_move_every_coordinate_and_no_end() {
        let mut x = [0.0; 30];
        bend(3, &mut x, 1.0, &mut stream(0, Purpose::Start, 0, 0));
        for k in 0..3 {
            assert!(x.chunks_exact(3).any(|p| p[k].abs() > 0.1), "{k}: {x:?}");
        }
    }
}
