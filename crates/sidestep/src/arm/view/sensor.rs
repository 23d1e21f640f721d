//! What is measured along a trajectory, and the step of the classical optimizer that a policy builds on.

use super::measure::Measure;
use super::{ArmSubject, PERIOD, SUBSTEPS};
use crate::kernels::LANES;
use crate::profile::Profile;
use crate::trajectory::{BlockTridiagonal, DAMPING};

/// Measures trajectories; one serves all trajectories of a question, one after the other.
#[derive(Debug, Clone)]
pub struct ArmSensor {
    measure: Measure,
    system: BlockTridiagonal,
    /// `[balls x points]`: gaps at substeps and waypoints, in the objective's order.
    pub(super) gaps: Vec<f32>,
    /// `[dof x points]`.
    pub(super) slopes: Vec<f32>,
    /// `[points]`.
    pub(super) own: Vec<f32>,
    /// `[points]`: the costs that the slopes are of.
    costs: Vec<f32>,
    /// `[N x dof]`.
    pub(super) gradient: Vec<f32>,
    pub(super) points: usize,
}

impl ArmSensor {
    /// For the trajectories of a question.
    pub fn new(subject: ArmSubject<'_>) -> Self {
        let measure = Measure::new(subject.scene.certifier());
        let (dof, waypoints) = (subject.start.len(), subject.waypoints);
        let points = ((waypoints + 1) * PERIOD - 1).next_multiple_of(LANES);
        Self {
            gaps: vec![0.0; measure.gaps.len() * points],
            slopes: vec![0.0; dof * points],
            own: vec![0.0; points],
            gradient: vec![0.0; waypoints * dof],
            system: BlockTridiagonal::new(waypoints, dof),
            costs: vec![0.0; points],
            measure,
            points,
        }
    }

    /// Measures the points of `x [N x dof]`.
    pub(super) fn look(&mut self, subject: ArmSubject<'_>, x: &[f32]) {
        let Self { measure, gaps, slopes, own, costs, points, .. } = self;
        let epsilon = Profile::DEFAULT.epsilon as f32;
        let last = (subject.waypoints + 1) * PERIOD - 2;
        for first in (0..*points).step_by(LANES) {
            for lane in 0..LANES {
                // Padding stands where the last point stands.
                let point = (first + lane).min(last);
                let (segment, t) = (point / PERIOD, (point % PERIOD + 1) as f32 / PERIOD as f32);
                let (from, to) = (subject.point(x, segment), subject.point(x, segment + 1));
                for (k, q) in measure.q().iter_mut().enumerate() {
                    q[lane] = if point % PERIOD == SUBSTEPS {
                        to[k]
                    } else {
                        from[k] + t * (to[k] - from[k])
                    };
                }
            }
            measure.measure(subject.scene.certifier(), epsilon);
            let copy = |from: &[[f32; LANES]], to: &mut [f32]| {
                for (from, to) in from.iter().zip(to.chunks_exact_mut(*points)) {
                    to[first..first + LANES].copy_from_slice(from);
                }
            };
            copy(&measure.gaps, gaps);
            copy(measure.slopes(), slopes);
            own[first..first + LANES].copy_from_slice(&measure.own);
            costs[first..first + LANES].copy_from_slice(&measure.costs);
        }
    }

    /// The gradient of U at what was measured.
    pub(super) fn slope(&mut self, subject: ArmSubject<'_>, x: &[f32]) {
        let (dof, waypoints) = (subject.start.len(), subject.waypoints);
        let lambda = Profile::DEFAULT.lambda as f32;
        let at_waypoint = 1.0 / waypoints as f32;
        let at_substep = 1.0 / ((waypoints + 1) * SUBSTEPS) as f32;
        for i in 0..waypoints {
            let [before, at, after] = [0, 1, 2].map(|k| subject.point(x, i + k));
            for k in 0..dof {
                let slopes = &self.slopes[k * self.points + i * PERIOD..];
                let mut sum = at_waypoint * slopes[SUBSTEPS];
                for j in 0..SUBSTEPS {
                    let t = (j + 1) as f32 / PERIOD as f32;
                    sum += at_substep * (t * slopes[j] + (1.0 - t) * slopes[PERIOD + j]);
                }
                let length = 2.0 * lambda * (2.0 * at[k] - before[k] - after[k]);
                self.gradient[i * dof + k] = sum + length;
            }
        }
    }

    /// The step of Levenberg-Marquardt at what was measured, `[N x dof]`.
    pub(super) fn step(&mut self, waypoints: usize) -> &[f32] {
        let at_waypoint = 1.0 / waypoints as f32;
        let at_substep = 1.0 / ((waypoints + 1) * SUBSTEPS) as f32;
        let Self { system, slopes, costs, gradient, points, .. } = self;
        system.clear();
        for at in 0..(waypoints + 1) * PERIOD - 1 {
            if costs[at] > 0.0 {
                let weight = if at % PERIOD == SUBSTEPS { at_waypoint } else { at_substep };
                let t = (at % PERIOD + 1) as f32 / PERIOD as f32;
                let slope = |k: usize| slopes[k * *points + at];
                system.add_square(at / PERIOD, t, weight / (2.0 * costs[at]), slope);
            }
        }
        system.add_metric(2.0 * Profile::DEFAULT.lambda as f32 + DAMPING);
        system.solve_held(gradient);
        gradient
    }
}
