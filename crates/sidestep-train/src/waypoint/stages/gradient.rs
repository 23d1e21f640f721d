//! Policy gradient on success (REINFORCE: Williams 1992) with the task's own walks as the baseline,
//! and PPO on the same walks (Schulman et al. 2017, arXiv:1707.06347) where they are learned from
//! more than once.
//!
//! Each task is walked K times from one start, mostly the straight line, with smooth noise on every
//! step: with shapes phi_k(i) = sin(pi k i / (N + 1)) and z standard normal,
//!
//! ```text
//! step = output + noise,   noise = sum over k = 1..8 of (sigma / k) z_k phi_k        (in each direction)
//! R = 1 - haste t / T - stretch min(length / shortest - 1, 1) where the walk is free after t of T steps, else 0
//! A = (R - mean of the task) / (standard deviation of the task + 0.1)
//! d(-A log density) / d output_i = -A sum over k of z_k phi_k(i) / (sigma / k) / |phi_k|^2
//! ```
//!
//! which is the score of the noise modes: what lies outside of them is not explored and not learned
//! here. Tasks whose walks all end alike teach nothing.
//!
//! Where no walk of a task got through there is nothing to compare; then some of its walks are
//! learned from by imitation ([`super::loss`]), as repair does for PPO
//! ([`crate::paper::stages::ppo`]).
//!
//! After the first epoch the output has moved from what was walked by, so that the same step is
//! another noise, and counts by the ratio of densities, clipped as PPO does:
//!
//! ```text
//! z'_k = z_k + (old output - output) . phi_k / |phi_k|^2 / (sigma / k)
//! r = exp(sum of (z^2 - z'^2) / 2);   loss = -min(r A, clamp(r, 1 - clip, 1 + clip) A)
//! ```

use sidestep::network::WaypointScratch;
use sidestep::objective::Objective;

use super::imitation::Part;
use super::loss::{Lesson, LossScratch, Made};
use super::walks::{MODES, Shapes, Walk, Walked, Walker, Worth};
use crate::routes::Target;

/// The walks on some tasks of an update, with the buffers to learn from them.
#[derive(Debug, Default)]
pub(crate) struct Lessons {
    scratch: WaypointScratch,
    walked: Vec<Walked>,
    /// Outputs that each walk that teaches was walked by, in order.
    old: Vec<Vec<f32>>,
    now: Vec<f32>,
    d_output: Vec<f32>,
    loss_scratch: LossScratch,
}

impl Lessons {
    /// Walks these tasks of an update.
    pub fn walk(
        &mut self,
        walker: Walker<'_>,
        update: u64,
        tasks: std::ops::Range<u64>,
        part: &mut Part,
    ) {
        self.walked.clear();
        self.old.clear();
        for task in tasks {
            let walked = walker.walk(update, task, &mut self.scratch, &mut part.sums);
            self.walked.push(walked);
        }
    }

    /// Adds the gradient summed over walks to `part`; the first call after [`Lessons::walk`] is the
    /// first epoch.
    pub fn learn(&mut self, walker: Walker<'_>, part: &mut Part) {
        let Self { scratch, walked, old, now, d_output, loss_scratch } = self;
        let (net, row_len) = (walker.net, walker.ingredients.sight.row_len());
        let stride = net.input_stride();
        let mut place = 0;
        for Walked { waypoints, shapes, ready, walks, targets } in walked {
            let is_first = old.len() == place;
            if !is_first {
                ready.read_map(net);
            }
            for walk in walks.iter() {
                if walk.worth == Worth::Nothing {
                    continue;
                }
                let rows = walk.seen.len() / stride;
                scratch.input(rows, stride).copy_from_slice(&walk.seen);
                if let (Some(map), false) = (ready.map(), is_first) {
                    map.read_rows(&walk.places, scratch.input(rows, stride), stride, row_len);
                }
                net.forward(scratch, *waypoints);
                if is_first {
                    let mut outputs = Vec::new();
                    scratch.outputs(0..rows, &mut outputs);
                    old.push(outputs);
                }
                d_output.clear();
                match walk.worth {
                    Worth::Nothing => {}
                    Worth::Advantage(advantage) => {
                        scratch.outputs(0..rows, now);
                        let moved = Moved { old: &old[place], now };
                        slopes(walker, walk, advantage, shapes, moved, d_output);
                    }
                    Worth::Repair => {
                        let objective = &ready.objective;
                        repair(walker, walk, objective, targets, scratch, loss_scratch, d_output);
                    }
                }
                place += 1;
                net.backward(d_output, scratch, &mut part.gradient);
                if let Some(map) = ready.map() {
                    map.collect_rows(&walk.places, scratch.input_slopes(), stride, row_len);
                }
            }
            ready.learn_map(net, &mut part.gradient);
        }
    }
}

/// Outputs of a walk `[steps x N x dof]`: those that it was walked by, and those of the network as it is now.
#[derive(Clone, Copy)]
struct Moved<'a> {
    old: &'a [f32],
    now: &'a [f32],
}

/// Appends the loss's slopes with respect to the outputs, `[steps x N x dof]`.
fn slopes(
    walker: Walker<'_>,
    walk: &Walk,
    advantage: f32,
    shapes: &Shapes,
    moved: Moved<'_>,
    d_output: &mut Vec<f32>,
) {
    let (sigma, clip, waypoints) = (walker.sigma(), walker.settings.clip, shapes.values[0].len());
    let dof = walker.ingredients.sight.dof();
    let mut own = vec![0.0; MODES * dof];
    for (step, z) in walk.noise.chunks_exact(MODES * dof).enumerate() {
        let outputs = step * waypoints * dof..(step + 1) * waypoints * dof;
        let (old, now) = (&moved.old[outputs.clone()], &moved.now[outputs]);
        own.copy_from_slice(z);
        for (mode, own) in own.chunks_exact_mut(dof).enumerate() {
            let size = sigma / (mode + 1) as f32 * shapes.squares[mode];
            for i in 0..waypoints {
                for axis in 0..dof {
                    let at = i * dof + axis;
                    own[axis] += (old[at] - now[at]) * shapes.values[mode][i] / size;
                }
            }
        }
        let exponent = z.iter().zip(&own).map(|(z, n)| 0.5 * (z * z - n * n)).sum::<f32>();
        let ratio = exponent.clamp(-20.0, 20.0).exp();
        let is_clipped = if advantage > 0.0 { ratio > 1.0 + clip } else { ratio < 1.0 - clip };
        let weight = if is_clipped { 0.0 } else { advantage * ratio };
        for i in 0..waypoints {
            let first = d_output.len();
            d_output.resize(first + dof, 0.0);
            for (mode, own) in own.chunks_exact(dof).enumerate() {
                let factor =
                    (mode + 1) as f32 / sigma * shapes.values[mode][i] / shapes.squares[mode];
                let slopes = d_output[first..].iter_mut().zip(own);
                slopes.for_each(|(slope, own)| *slope -= weight * factor * own);
            }
        }
    }
}

/// The slopes of imitation with respect to the outputs that `scratch` holds, `[steps x N x dof]`.
fn repair(
    walker: Walker<'_>,
    walk: &Walk,
    objective: &Objective,
    targets: &[Target],
    scratch: &WaypointScratch,
    loss_scratch: &mut LossScratch,
    d_output: &mut Vec<f32>,
) {
    let (rule, dim) = (&walker.ingredients.rule, objective.dim());
    let (waypoints, mut outputs) = (objective.waypoints(), Vec::new());
    let lesson = Lesson {
        objective,
        targets,
        along: walk.view.along(),
        scale: rule.scale,
        hinge_weight: walker.ingredients.imitation.hinge_straight,
    };
    // In the plane, as the configuration's check sees to: other views have a base at each step.
    let mut view = walk.view.clone();
    for (step, before) in walk.places.chunks_exact(dim).enumerate() {
        scratch.outputs(step * waypoints..(step + 1) * waypoints, &mut outputs);
        let mut after = before.to_vec();
        view.apply(objective, rule, &outputs, &mut after);
        let made = Made { before, after: &after, outputs: &outputs, base: &[] };
        lesson.loss(made, loss_scratch, d_output);
    }
    d_output.iter_mut().for_each(|slope| *slope *= walker.settings.repair);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::waypoint::config::{TaskConfig, WaypointConfig};
    use crate::waypoint::sight::Sight;
    use crate::waypoint::stages::imitation::Ingredients;
    use sidestep::network::{WaypointNet, WaypointShape};
    use sidestep::plane::view::ViewParts;
    use sidestep::policy::ActionRule;

    /// The clipped loss of one walk, from densities, in f64.
    fn loss(walker: Walker<'_>, walk: &Walk, old: &[f32], now: &[f32]) -> f64 {
        let (sigma, clip) = (f64::from(walker.sigma()), f64::from(walker.settings.clip));
        let shapes = Shapes::new(10);
        let Worth::Advantage(advantage) = walk.worth else { panic!("{:?}", walk.worth) };
        let advantage = f64::from(advantage);
        let mut total = 0.0;
        for (step, z) in walk.noise.chunks_exact(2 * MODES).enumerate() {
            let mut exponent = 0.0;
            for mode in 0..MODES {
                let size = sigma / (mode + 1) as f64;
                for axis in 0..2 {
                    let moved: f64 = (0..10)
                        .map(|i| {
                            let at = 2 * (10 * step + i) + axis;
                            let (was, is) = (old[at], now[at]);
                            f64::from(shapes.values[mode][i]) * (f64::from(was) - f64::from(is))
                        })
                        .sum();
                    let z = f64::from(z[2 * mode + axis]);
                    let other = z + moved / f64::from(shapes.squares[mode]) / size;
                    exponent += 0.5 * (z * z - other * other);
                }
            }
            let ratio = exponent.exp();
            total -= (ratio * advantage).min(ratio.clamp(1.0 - clip, 1.0 + clip) * advantage);
        }
        total
    }

    #[test]
    fn slopes_are_differences_of_the_clipped_loss() {
        let names = ["waypoints", "probes:4x1"].map(String::from);
        let view = ViewParts::from_names(&names).unwrap();
        let shape = WaypointShape {
            inputs: view.row_len(),
            width: 16,
            dilations: vec![1],
            outputs: 2,
            map: None,
        };
        let count = shape.parameter_count().unwrap();
        let draw = |i: usize| 0.1 * (i as f32 * 0.7).sin();
        let mut net = WaypointNet::new(&shape, (0..count).map(draw).collect()).unwrap();
        let config = WaypointConfig::default();
        let ingredients = Ingredients {
            sight: Sight::Plane(view),
            rule: ActionRule { scale: 0.4, limit: 1.6, keep_inside: true },
            tasks: TaskConfig { other_waypoints: 0.0, ..config.tasks },
            imitation: config.imitation,
            seed: 0,
        };
        let settings = config.policy_gradient;
        let mut lessons = Lessons::default();
        let mut part = Part::default();
        part.clear(count);
        let walker = Walker { net: &net, ingredients: &ingredients, settings: &settings };
        lessons.walk(walker, 3, 0..6, &mut part);
        lessons.learn(walker, &mut part);
        net.update(|parameters| parameters.iter_mut().for_each(|p| *p *= 1.3));
        let walker = Walker { net: &net, ingredients: &ingredients, settings: &settings };
        let walks = lessons.walked.iter().flat_map(|walked| &walked.walks);
        let walks: Vec<&Walk> =
            walks.filter(|walk| matches!(walk.worth, Worth::Advantage(_))).collect();
        assert!(!walks.is_empty());
        let (mut scratch, mut found) = (WaypointScratch::default(), Vec::new());
        let (mut clipped, mut close, mut all) = (0, 0, 0);
        for (walk, old) in walks.iter().zip(&lessons.old).take(12) {
            let rows = walk.seen.len() / net.input_stride();
            scratch.input(rows, net.input_stride()).copy_from_slice(&walk.seen);
            net.forward(&mut scratch, 10);
            let Worth::Advantage(advantage) = walk.worth else { continue };
            found.clear();
            let mut now = Vec::new();
            scratch.outputs(0..rows, &mut now);
            let moved = Moved { old, now: &now };
            slopes(walker, walk, advantage, &Shapes::new(10), moved, &mut found);
            clipped += found.chunks(20).filter(|step| step.iter().all(|s| *s == 0.0)).count();
            for row in (0..rows).step_by(7) {
                let h = 1e-3;
                let at = |change: f32| {
                    let mut now = now.clone();
                    now[2 * row + 1] += change;
                    loss(walker, walk, old, &now)
                };
                let slope = (at(h) - at(-h)) / f64::from(2.0 * h);
                let got = f64::from(found[2 * row + 1]);
                all += 1;
                close += usize::from((slope - got).abs() <= 0.02 * (1.0 + slope.abs()));
            }
        }
        // A step just at the clip's edge has no slope.
        assert!(close * 100 >= all * 95, "{close} of {all}");
        assert!(clipped > 0, "nothing was clipped");
    }
}
