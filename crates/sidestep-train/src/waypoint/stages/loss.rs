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
//! The hinge has no gradient deeper than 2 px, where d says little about the way out.

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
    /// Direction from start to goal.
    pub along: [f32; 2],
    /// Normalised units per unit of output.
    pub scale: f32,
    pub hinge_weight: f32,
}

/// Buffers of the loss.
#[derive(Debug, Default)]
pub(crate) struct LossScratch {
    sampler: Sampler,
    pull: Vec<[f32; 2]>,
}

impl Lesson<'_> {
    /// The loss of one step from `before` to `after` (`[N x 2]`) by the network's `outputs`; its
    /// gradient with respect to these is appended to `d_output`.
    pub fn loss(
        &self,
        before: &[f32],
        after: &[f32],
        outputs: impl Fn(usize) -> [f32; 2],
        scratch: &mut LossScratch,
        d_output: &mut Vec<[f32; 2]>,
    ) -> f64 {
        let (from, to) = (before.as_chunks::<2>().0, after.as_chunks::<2>().0);
        let target = nearest(self.targets, before).map(|target| target.as_chunks::<2>().0);
        scratch.pull.clear();
        scratch.pull.resize(to.len(), [0.0; 2]);
        let mut total = self.hinge(to, scratch);
        let [c, s] = self.along;
        for i in 0..from.len() {
            let output = outputs(i);
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
            d_output.push(slope);
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
    use super::*;
    use crate::routes::sparingly_grown;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use sidestep::plane::view::{Look, ViewParts, WaypointView};
    use sidestep::policy::ActionRule;
    use sidestep::profile::Profile;
    use sidestep::rng::standard_normal;
    use sidestep::scene::Query;
    use sidestep::suite::candidate;

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
            let outputs: Vec<[f32; 2]> = (0..10).map(|_| standard_normal(&mut rng)).collect();
            let value = |outputs: &[[f32; 2]], slopes: &mut Vec<[f32; 2]>| {
                let mut view =
                    WaypointView::new(&parts, objective.plane().unwrap(), Look::default());
                let mut after = before.clone();
                view.apply(&rule, |i| outputs[i], &mut after);
                let along = view.along();
                let (objective, targets) = (&objective, &targets);
                let lesson =
                    Lesson { objective, targets, along, scale: rule.scale, hinge_weight: 1.0 };
                lesson.loss(&before, &after, |i| outputs[i], &mut LossScratch::default(), slopes)
            };
            let mut slopes = Vec::new();
            value(&outputs, &mut slopes);
            for i in 0..10 {
                for axis in 0..2 {
                    let h = 2e-3;
                    let mut moved = outputs.clone();
                    moved[i][axis] += h;
                    let above = value(&moved, &mut Vec::new());
                    moved[i][axis] -= 2.0 * h;
                    let below = value(&moved, &mut Vec::new());
                    let slope = (above - below) / f64::from(2.0 * h);
                    all += 1;
                    let error = (slope - f64::from(slopes[i][axis])).abs();
                    close += usize::from(error <= 0.02 * (1.0 + slope.abs()));
                }
            }
        }
        // Elsewhere lies a kink of the distance or an end of the hinge, or a waypoint at a wall.
        assert!(close * 100 >= all * 93, "{close} of {all}");
    }
}
