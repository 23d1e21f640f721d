//! CHOMP's covariant update (Ratliff et al. 2009, doi:10.1109/ROBOT.2009.5152817; Zucker et al.
//! 2013): ξ ← ξ - (1/η) A⁻¹ ∂U.
//!
//! A is that of `trajectory/covariant.rs`, so an update bends the whole trajectory smoothly. The objective is this
//! project's U, which weighs obstacle cost by point and not by arc length.

use crate::trajectory::Covariant;

#[derive(Debug)]
pub(super) struct Chomp {
    step: f32,
    covariant: Covariant,
}

impl Chomp {
    /// For trajectories of `waypoints` configurations of `dof` numbers.
    pub fn new(step: f32, waypoints: usize, dof: usize) -> Self {
        Self { step, covariant: Covariant::new(waypoints, dof) }
    }

    pub fn step(&mut self, x: &mut [f32], gradient: &[f32]) {
        let step = self.step;
        for (x, update) in x.iter_mut().zip(self.covariant.solve(gradient)) {
            *x -= step * update;
        }
    }
}
