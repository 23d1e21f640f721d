//! Gauss-Newton steps with the damping of Levenberg and Marquardt: ξ ← ξ - (H + μ A)⁻¹ ∂U.
//!
//! H is the Gauss-Newton curvature of U (`objective/curvature.rs`), A the covariant metric of CHOMP, in which damping keeps the
//! trajectory smooth. The system is block-tridiagonal in the waypoints and is solved by blocks of Cholesky factors.
//! K. Levenberg, Quarterly of Applied Mathematics 2, 1944; D. Marquardt, SIAM Journal 11, 1963. On trajectories:
//! M. Mukadam et al., Continuous-time Gaussian process motion planning via probabilistic inference, IJRR 2018,
//! doi:10.1177/0278364918790369.

use crate::objective::Objective;
use crate::trajectory::BlockTridiagonal;

#[derive(Debug)]
pub(super) struct LevenbergMarquardt {
    damping: f32,
    system: BlockTridiagonal,
    /// `[N x dof]`.
    update: Vec<f32>,
}

impl LevenbergMarquardt {
    /// For trajectories of `waypoints` configurations of `dof` numbers.
    pub fn new(damping: f32, waypoints: usize, dof: usize) -> Self {
        let system = BlockTridiagonal::new(waypoints, dof);
        Self { damping, system, update: vec![0.0; waypoints * dof] }
    }

    pub fn step(&mut self, x: &mut [f32], gradient: &[f32], objective: &Objective) {
        objective.curvature(&mut self.system);
        self.system.add_metric(self.damping);
        self.update.copy_from_slice(gradient);
        self.system.solve_held(&mut self.update);
        x.iter_mut().zip(&self.update).for_each(|(x, update)| *x -= update);
    }
}
