//! CHOMP's covariant update (Ratliff et al. 2009, doi:10.1109/ROBOT.2009.5152817; Zucker et al.
//! 2013): ξ ← ξ - (1/η) A⁻¹ ∂U.
//!
//! A = KᵀK for first differences K with both ends held, the tridiagonal matrix with 2 on and -1
//! beside the diagonal, so an update bends the whole trajectory smoothly. The objective is this
//! project's U, which weighs obstacle cost by point and not by arc length.

#[derive(Debug)]
pub(super) struct Chomp {
    step: f32,
    dof: usize,
    /// Thomas' algorithm: the eliminated upper diagonal c'_i = -1 / (2 + c'_{i-1}).
    upper: Vec<f32>,
    /// `[N x dof]`.
    solution: Vec<f32>,
}

impl Chomp {
    /// For trajectories of `waypoints` configurations of `dof` numbers.
    pub fn new(step: f32, waypoints: usize, dof: usize) -> Self {
        let mut upper = Vec::with_capacity(waypoints);
        let mut last = 0.0f32;
        for _ in 0..waypoints {
            last = -1.0 / (2.0 + last);
            upper.push(last);
        }
        Self { step, dof, upper, solution: vec![0.0; waypoints * dof] }
    }

    pub fn step(&mut self, x: &mut [f32], gradient: &[f32]) {
        let Self { step, dof, upper, solution } = self;
        for i in 0..solution.len() {
            // 1 / (2 + c'_{i-1}) = -c'_i
            let before = if i < *dof { 0.0 } else { solution[i - *dof] };
            solution[i] = (gradient[i] + before) * -upper[i / *dof];
        }
        for i in (0..solution.len().saturating_sub(*dof)).rev() {
            solution[i] -= upper[i / *dof] * solution[i + *dof];
        }
        for (x, update) in x.iter_mut().zip(solution) {
            *x -= *step * *update;
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
        Chomp::new(1.0, 4, 2).step(&mut x, &gradient);
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
