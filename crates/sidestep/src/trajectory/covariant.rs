//! The covariant metric of trajectories: A⁻¹ for A = KᵀK with first differences K and both ends held, the tridiagonal matrix
//! with 2 on and -1 beside the diagonal. A gradient that it is multiplied with bends the whole trajectory smoothly
//! (CHOMP: Ratliff et al. 2009, doi:10.1109/ROBOT.2009.5152817).

/// Solves A s = g for trajectories of a certain size; allocates nothing.
#[derive(Debug, Clone)]
pub(crate) struct Covariant {
    dof: usize,
    /// Thomas' algorithm: the eliminated upper diagonal c'_i = -1 / (2 + c'_{i-1}).
    upper: Vec<f32>,
    /// `[N x dof]`.
    solution: Vec<f32>,
}

impl Covariant {
    /// For trajectories of `waypoints` configurations of `dof` numbers.
    pub fn new(waypoints: usize, dof: usize) -> Self {
        let mut upper = Vec::with_capacity(waypoints);
        let mut last = 0.0f32;
        for _ in 0..waypoints {
            last = -1.0 / (2.0 + last);
            upper.push(last);
        }
        Self { dof, upper, solution: vec![0.0; waypoints * dof] }
    }

    /// A⁻¹ times the gradient, both `[N x dof]`.
    pub fn solve(&mut self, gradient: &[f32]) -> &[f32] {
        let Self { dof, upper, solution } = self;
        for i in 0..solution.len() {
            // 1 / (2 + c'_{i-1}) = -c'_i
            let before = if i < *dof { 0.0 } else { solution[i - *dof] };
            solution[i] = (gradient[i] + before) * -upper[i / *dof];
        }
        for i in (0..solution.len().saturating_sub(*dof)).rev() {
            solution[i] -= upper[i / *dof] * solution[i + *dof];
        }
        solution
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_the_tridiagonal_system() {
        let gradient = [1.0, -2.0, 0.5, 3.0, -1.0, 0.25, 2.0, 0.0];
        let mut covariant = Covariant::new(4, 2);
        let x = covariant.solve(&gradient).to_vec();
        let at = |i: i32, axis: usize| {
            if (0..4).contains(&i) { x[2 * i as usize + axis] } else { 0.0 }
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
