//! CHOMP's covariant update (Ratliff et al. 2009, doi:10.1109/ROBOT.2009.5152817; Zucker et al.
//! 2013): ξ ← ξ - (1/η) A⁻¹ ∂U.
//!
//! A = KᵀK for first differences K with both ends held, the tridiagonal matrix with 2 on and -1
//! beside the diagonal, so an update bends the whole trajectory smoothly. The objective is this
//! project's U, which weighs obstacle cost by point and not by arc length.

#[derive(Debug)]
pub(super) struct Chomp {
    step: f32,
    /// Thomas' algorithm: the eliminated upper diagonal c'_i = -1 / (2 + c'_{i-1}).
    upper: Vec<f32>,
    solution: Vec<[f32; 2]>,
}

impl Chomp {
    /// For a flat state of length `n`.
    pub fn new(step: f32, n: usize) -> Self {
        let mut upper = Vec::with_capacity(n / 2);
        let mut last = 0.0f32;
        for _ in 0..n / 2 {
            last = -1.0 / (2.0 + last);
            upper.push(last);
        }
        Self { step, upper, solution: vec![[0.0; 2]; n / 2] }
    }

    pub fn step(&mut self, x: &mut [f32], gradient: &[f32]) {
        let gradient = gradient.as_chunks::<2>().0;
        let n = gradient.len();
        for i in 0..n {
            // 1 / (2 + c'_{i-1}) = -c'_i
            let before = if i > 0 { self.solution[i - 1] } else { [0.0; 2] };
            for axis in 0..2 {
                self.solution[i][axis] = (gradient[i][axis] + before[axis]) * -self.upper[i];
            }
        }
        for i in (0..n.saturating_sub(1)).rev() {
            for axis in 0..2 {
                self.solution[i][axis] -= self.upper[i] * self.solution[i + 1][axis];
            }
        }
        for (x, update) in x.as_chunks_mut::<2>().0.iter_mut().zip(&self.solution) {
            for axis in 0..2 {
                x[axis] -= self.step * update[axis];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_the_tridiagonal_system() {
        let gradient = [1.0, -2.0, 0.5, 3.0, -1.0, 0.25, 2.0, 0.0];
        let mut x = [0.0; 8];
        Chomp::new(1.0, 8).step(&mut x, &gradient);
        let at = |i: i32, axis: usize| {
            if (0..4).contains(&i) { -x[2 * i as usize + axis] } else { 0.0 }
        };
        for i in 0..4 {
            for axis in 0..2 {
                let product = 2.0 * at(i, axis) - at(i - 1, axis) - at(i + 1, axis);
                let expected = gradient[2 * i as usize + axis];
                assert!((product - expected).abs() < 1e-5, "{i} {axis}: {product} {expected}");
            }
        }
    }
}
