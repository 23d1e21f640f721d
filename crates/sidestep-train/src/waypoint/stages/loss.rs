//! The loss of imitation: how far an update is from the expert's, and a hinge on what still
//! collides.
//!
//! With u the update, x' = x + u, lengths in pixels (0.1 normalised) and d(p) the signed distance:
//!
//! ```text
//! u* = clip(0.5 (target - x), 8)          target = argmin over alternatives of mean |target - x| + 0.15 extra length
//! loss = sum over waypoints sqrt(|u - u*|^2 + 0.05) + w sum over points on x' of max(0, 0.6 - d)
//! ```
//!
//! The hinge has no gradient deeper than 2 px, where d says little about the way out. Robots with
//! joints have a pixel of 0.1 rad and no hinge: the step that the output is added to leads out of
//! obstacles as well as it would.

use sidestep::objective::Objective;
use sidestep::plane::Subject;
use sidestep::plane::distance::Sampler;

use crate::routes::{Target, nearest};

/// A pixel of the paper's field in normalised units.
pub(crate) const PIXEL: f32 = 0.1;
/// Points of each segment that the hinge sees.
const HINGE_POINTS: usize = 7;

/// A task's part of the loss.
pub(crate) struct Lesson<'a> {
    pub objective: &'a Objective,
    pub targets: &'a [Target],
    /// Direction from start to goal, in the plane.
    pub along: Option<[f32; 2]>,
    /// Normalised units per unit of output.
    pub scale: f32,
    pub hinge_weight: f32,
}

/// A step that a policy made; all `[N x dof]`, in normalised units but for the outputs.
#[derive(Clone, Copy)]
pub(crate) struct Made<'a> {
    pub before: &'a [f32],
    pub after: &'a [f32],
    pub outputs: &'a [f32],
    /// What was added to the outputs' part of the update; empty for nothing.
    pub base: &'a [f32],
}

/// Buffers of the loss.
#[derive(Debug, Default)]
pub(crate) struct LossScratch {
    sampler: Sampler,
    pull: Vec<[f32; 2]>,
}

impl Lesson<'_> {
    /// The loss of one step; its gradient with respect to the outputs is appended to `d_output`.
    pub fn loss(&self, made: Made<'_>, scratch: &mut LossScratch, d_output: &mut Vec<f32>) -> f64 {
        match self.along {
            Some(along) => self.in_plane(along, made, scratch, d_output),
            None => self.of_joints(made, d_output),
        }
    }

    fn of_joints(&self, made: Made<'_>, d_output: &mut Vec<f32>) -> f64 {
        let (dof, gain) = (self.objective.dof(), self.scale / PIXEL);
        let first = d_output.len();
        d_output.resize(first + made.outputs.len(), 0.0);
        let Some(target) = nearest(dof, self.targets, made.before) else { return 0.0 };
        let mut total = 0.0;
        let mut error = vec![0.0; dof];
        for i in 0..made.outputs.len() / dof {
            let at = i * dof..(i + 1) * dof;
            let [target, before] = [target, made.before].map(|x| &x[at.clone()]);
            let wish = |k: usize| 0.5 * (target[k] - before[k]) / PIXEL;
            let size = (0..dof).map(|k| wish(k) * wish(k)).sum::<f32>().sqrt();
            let factor = if size > 8.0 { 8.0 / size } else { 1.0 };
            for (k, error) in error.iter_mut().enumerate() {
                let base = made.base.get(i * dof + k).map_or(0.0, |base| base / PIXEL);
                *error = gain * made.outputs[i * dof + k] + base - factor * wish(k);
            }
            let root = (error.iter().map(|error| error * error).sum::<f32>() + 0.05).sqrt();
            total += f64::from(root);
            for (slope, error) in d_output[first..][at].iter_mut().zip(&error) {
                *slope = gain * error / root;
            }
        }
        total
    }

    fn in_plane(
        &self,
        [c, s]: [f32; 2],
        made: Made<'_>,
        scratch: &mut LossScratch,
        d_output: &mut Vec<f32>,
    ) -> f64 {
        let (from, to) = (made.before.as_chunks::<2>().0, made.after.as_chunks::<2>().0);
        let target = nearest(2, self.targets, made.before).map(|t| t.as_chunks::<2>().0);
        scratch.pull.clear();
        scratch.pull.resize(to.len(), [0.0; 2]);
        let mut total = self.hinge(to, scratch);
        for i in 0..from.len() {
            let output = [made.outputs[2 * i], made.outputs[2 * i + 1]];
            // From normalised units to pixels per unit of output.
            let gain = self.scale / PIXEL;
            // The hinge's pull is in field axes, the output in frame axes.
            let pull = scratch.pull[i];
            let mut slope =
                [gain * (c * pull[0] + s * pull[1]), gain * (c * pull[1] - s * pull[0])];
            if let Some(target) = target {
                let wish = [0, 1].map(|a| 0.5 * (target[i][a] - from[i][a]) / PIXEL);
                let size = wish[0].hypot(wish[1]);
                let factor = if size > 8.0 { 8.0 / size } else { 1.0 };
                let wish =
                    [factor * (c * wish[0] + s * wish[1]), factor * (c * wish[1] - s * wish[0])];
                let error = [gain * output[0] - wish[0], gain * output[1] - wish[1]];
                let root = (error[0] * error[0] + error[1] * error[1] + 0.05).sqrt();
                total += f64::from(root);
                slope[0] += gain * error[0] / root;
                slope[1] += gain * error[1] / root;
            }
            d_output.extend(slope);
        }
        total
    }

    /// The weighed hinge on a trajectory; its gradient per pixel of a waypoint's motion is added to
    /// the scratch's pull, in field axes.
    fn hinge(&self, points: &[[f32; 2]], scratch: &mut LossScratch) -> f64 {
        let LossScratch { sampler, pull } = scratch;
        let Some(Subject { scene, start, goal, .. }) = self.objective.plane() else { return 0.0 };
        let weight = self.hinge_weight;
        let mut from = start;
        let per_segment = HINGE_POINTS + 1;
        sampler.clear();
        for &to in points.iter().chain([&goal]) {
            for k in 1..=per_segment {
                let t = k as f32 / per_segment as f32;
                sampler.push([from[0] + t * (to[0] - from[0]), from[1] + t * (to[1] - from[1])]);
            }
            from = to;
        }
        let mut total = 0.0;
        for (index, (distance, gradient)) in sampler.sample(scene.exact_field()).enumerate() {
            let (segment, k) = (index / per_segment, index % per_segment + 1);
            let distance = distance / PIXEL;
            // The goal itself cannot move.
            if distance >= 0.6 || segment == points.len() && k == per_segment {
                continue;
            }
            total += f64::from(weight * (0.6 - distance.max(-2.0)));
            if distance <= -2.0 {
                continue;
            }
            let t = k as f32 / per_segment as f32;
            for axis in 0..2 {
                if segment > 0 {
                    pull[segment - 1][axis] -= weight * (1.0 - t) * gradient[axis];
                }
                if segment < points.len() {
                    pull[segment][axis] -= weight * t * gradient[axis];
                }
            }
        }
        total
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::routes::{jointed, sparingly_grown};
    use crate::waypoint::config::jointed_task;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use sidestep::plane::view::{Look, ViewParts, WaypointView};
    use sidestep::policy::ActionRule;
    use sidestep::profile::Profile;
    use sidestep::rng::standard_normal;
    use sidestep::scene::Query;
    use sidestep::suite::arms::planar_arm_alone;
    use sidestep::suite::candidate;

    #[test]
    fn slopes_of_joints_are_differences_of_the_loss() {
        let arm = Arc::new(planar_arm_alone(3).unwrap());
        let mut found = 0;
        for index in 0..12 {
            let Some(task) = jointed_task(&arm, 1000, index) else { continue };
            let objective = Objective::new(&Query::of(&task, &Profile::DEFAULT), 10).unwrap();
            let mut rng = ChaCha8Rng::seed_from_u64(index);
            let targets = jointed::targets(&objective, &mut rng);
            assert!(targets.iter().all(|target| objective.is_certified(&target.waypoints)));
            found += targets.len();
            let mut before = vec![0.0; 30];
            objective.straight_line(&mut before);
            let outputs: Vec<f32> = (0..15).flat_map(|_| standard_normal(&mut rng)).collect();
            let (objective, targets, base) = (&objective, &targets, &[0.1; 30]);
            let lesson = Lesson { objective, targets, along: None, scale: 0.4, hinge_weight: 1.0 };
            let value = |outputs: &[f32], slopes: &mut Vec<f32>| {
                let made = Made { before: &before, after: &before, outputs, base };
                lesson.loss(made, &mut LossScratch::default(), slopes)
            };
            let mut slopes = Vec::new();
            value(&outputs, &mut slopes);
            for at in 0..30 {
                let at_change = |change: f32| {
                    let mut moved = outputs.clone();
                    moved[at] += change;
                    value(&moved, &mut Vec::new())
                };
                let slope = (at_change(4e-3) - at_change(-4e-3)) / 8e-3;
                let error = (slope - f64::from(slopes[at])).abs();
                assert!(error <= 0.01 * (1.0 + slope.abs()), "{at}: {slope} {}", slopes[at]);
            }
        }
        assert!(found > 12, "{found}");
    }

    /// Slopes of the loss with respect to the outputs, one coordinate at a time, against
    /// differences of the loss.
    #[test]
    fn slopes_are_differences_of_the_loss() {
        let parts = ViewParts::from_names(&["waypoints".into(), "probes:4x1".into()]).unwrap();
        let rule = ActionRule { scale: 0.4, limit: 1.6, keep_inside: true };
        let (mut close, mut all) = (0, 0);
        for index in 0..12 {
            let task = candidate(1000, index);
            let objective = Objective::new(&Query::of(&task, &Profile::DEFAULT), 10).unwrap();
            let plane = task.plane().unwrap();
            let mut rng = ChaCha8Rng::seed_from_u64(index);
            let targets = sparingly_grown::targets(plane, &objective, &mut rng);
            let mut before = vec![0.0; 20];
            objective.straight_line(&mut before);
            let outputs: Vec<f32> = (0..10).flat_map(|_| standard_normal(&mut rng)).collect();
            let value = |outputs: &[f32], slopes: &mut Vec<f32>| {
                let mut view =
                    WaypointView::new(&parts, objective.plane().unwrap(), Look::default());
                let mut after = before.clone();
                view.apply(&rule, |i| [outputs[2 * i], outputs[2 * i + 1]], &mut after);
                let along = Some(view.along());
                let (objective, targets) = (&objective, &targets);
                let lesson =
                    Lesson { objective, targets, along, scale: rule.scale, hinge_weight: 1.0 };
                let made = Made { before: &before, after: &after, outputs, base: &[] };
                lesson.loss(made, &mut LossScratch::default(), slopes)
            };
            let mut slopes = Vec::new();
            value(&outputs, &mut slopes);
            for at in 0..20 {
                let h = 2e-3;
                let mut moved = outputs.clone();
                moved[at] += h;
                let above = value(&moved, &mut Vec::new());
                moved[at] -= 2.0 * h;
                let below = value(&moved, &mut Vec::new());
                let slope = (above - below) / f64::from(2.0 * h);
                all += 1;
                let error = (slope - f64::from(slopes[at])).abs();
                close += usize::from(error <= 0.02 * (1.0 + slope.abs()));
            }
        }
        // Elsewhere lies a kink of the distance or an end of the hinge, or a waypoint at a wall.
        assert!(close * 100 >= all * 93, "{close} of {all}");
    }
}
