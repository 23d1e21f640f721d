//! On-policy imitation of exact paths (DAgger: Ross, Gordon and Bagnell 2011, arXiv:1011.0686), with a set of answers
//! for each task and a hinge on what still collides.
//!
//! The policy walks trajectories of random tasks; at each step the target is the expert's trajectory nearest to the *present*
//! one, so that both sides of an obstacle do not average into it. With u the update, x' = x + u, lengths in pixels (0.1
//! normalised) and d(p) the signed distance:
//!
//! ```text
//! u* = clip(0.5 (target - x), 8)          target = argmin over alternatives of mean |target - x| + 0.15 extra length
//! loss = sum over waypoints sqrt(|u - u*|^2 + 0.05) + w sum over points on x' of max(0, 0.6 - d)
//! ```
//!
//! The hinge has no gradient deeper than 2 px, where d says little about the way out. Each task has four
//! trajectories: one from the straight line, one bent at random, two through random via-points.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use sidestep::network::{WaypointNet, WaypointScratch};
use sidestep::objective::{Objective, Scene};
use sidestep::policy::ActionRule;
use sidestep::profile::Profile;
use sidestep::rng::{Purpose, stream};
use sidestep::starts::{StartStrategy, bend};
use sidestep::waypoint_view::{Probes, WaypointView};
use std::sync::Arc;

use super::config::{ImitationConfig, TaskConfig};
use super::routes;
use crate::expert::routes::{Target, nearest};

/// Tasks of one case group; groups run in parallel and are added up in order.
pub(super) const GROUP: usize = 4;
/// Trajectories per task.
pub(super) const MEMBERS: usize = 4;
/// A pixel of the paper's field in normalised units.
pub(super) const PIXEL: f32 = 0.1;
/// Points of each segment that the hinge sees.
const HINGE_POINTS: usize = 4;
/// Candidate tasks that a group may draw in a unit; keeps the groups' tasks apart.
const TASKS_PER_GROUP: u64 = 1 << 24;
/// Failed tasks that a group remembers.
const MOST_FAILED: usize = 32;

/// What the cases are made of, the same for all groups.
#[derive(Debug, Clone)]
pub(super) struct Recipe {
    pub probes: Probes,
    pub rule: ActionRule,
    pub tasks: TaskConfig,
    pub imitation: ImitationConfig,
    pub seed: u64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    Straight,
    Bent,
    Via,
}

const KINDS: [Kind; MEMBERS] = [Kind::Straight, Kind::Bent, Kind::Via, Kind::Via];

#[derive(Debug, Clone)]
struct Member {
    kind: Kind,
    x: Vec<f32>,
    view: WaypointView,
    /// Whether it was free at any time of the task's life.
    solved: bool,
}

/// A task, its answers and the trajectories that walk on it.
#[derive(Debug, Clone)]
struct Case {
    task: u64,
    objective: Objective,
    targets: Vec<Target>,
    members: Vec<Member>,
    /// Steps until another task takes its place.
    left: u32,
}

/// Some cases that one thread works on, with its buffers.
#[derive(Debug)]
pub(super) struct Group {
    rng: ChaCha8Rng,
    waypoints: usize,
    next_task: u64,
    failed: Vec<u64>,
    cases: Vec<Case>,
    scratch: WaypointScratch,
    d_output: Vec<[f32; 2]>,
    pub gradient: Vec<f32>,
    pub sums: Sums,
}

/// Sums over the steps of an update.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Sums {
    /// Trajectory steps.
    pub steps: f64,
    /// Loss.
    pub loss: f64,
    /// Cases that ended, and those whose first trajectory was solved.
    pub ended: f64,
    pub solved: f64,
}

impl Group {
    /// Group `index` at the start of unit `unit` of the training.
    pub fn new(recipe: &Recipe, unit: u64, index: u64) -> Self {
        let mut rng = stream(recipe.seed, Purpose::Imitation, unit, index);
        let counts = &recipe.tasks.waypoints;
        let usual = Profile::DEFAULT.waypoints;
        let waypoints = if rng.random::<f32>() < recipe.tasks.other_waypoints {
            rng.random_range(counts[0]..=counts[1])
        } else {
            usual
        };
        let mut group = Self {
            rng,
            waypoints,
            next_task: (unit * 1024 + index) * TASKS_PER_GROUP,
            failed: Vec::new(),
            cases: Vec::new(),
            scratch: WaypointScratch::default(),
            d_output: Vec::new(),
            gradient: Vec::new(),
            sums: Sums::default(),
        };
        for _ in 0..GROUP {
            let case = group.draw(recipe);
            group.cases.push(case);
        }
        group
    }

    /// Steps every trajectory `steps` times with `net`, and leaves the gradient of the summed loss.
    pub fn run(&mut self, net: &WaypointNet, recipe: &Recipe, steps: usize) {
        self.gradient.clear();
        self.gradient.resize(net.parameters().len(), 0.0);
        self.sums = Sums::default();
        for _ in 0..steps {
            self.step(net, recipe);
        }
        // Long trajectories would outweigh the others.
        let share = Profile::DEFAULT.waypoints as f32 / self.waypoints as f32;
        self.gradient.iter_mut().for_each(|g| *g *= share);
    }

    fn step(&mut self, net: &WaypointNet, recipe: &Recipe) {
        let (waypoints, stride) = (self.waypoints, net.input_stride());
        let rows = GROUP * MEMBERS * waypoints;
        let input = self.scratch.input(rows, stride);
        let mut blocks = input.chunks_exact_mut(waypoints * stride);
        for case in &mut self.cases {
            for (member, rows) in case.members.iter_mut().zip(&mut blocks) {
                member.view.encode(&case.objective, &member.x, rows, stride);
                if member.view.is_free() {
                    member.solved = true;
                    // From the straight line it would only walk the same way again.
                    let kind = if member.kind == Kind::Straight { Kind::Bent } else { member.kind };
                    begin(kind, &case.objective, &mut self.rng, member);
                    member.view.encode(&case.objective, &member.x, rows, stride);
                }
            }
        }
        net.forward(&mut self.scratch, waypoints);
        self.d_output.clear();
        for (index, case) in self.cases.iter_mut().enumerate() {
            for (place, member) in case.members.iter_mut().enumerate() {
                let first = (index * MEMBERS + place) * waypoints;
                let outputs = |i: usize| self.scratch.output(first + i);
                let weight = match KINDS[place] {
                    Kind::Straight => recipe.imitation.hinge_straight,
                    _ => recipe.imitation.hinge,
                };
                let before = member.x.clone();
                member.view.apply(&recipe.rule, outputs, &mut member.x);
                self.sums.loss += loss(
                    &case.objective,
                    &case.targets,
                    member.view.along(),
                    &before,
                    &member.x,
                    outputs,
                    recipe.rule.scale,
                    weight,
                    &mut self.d_output,
                );
                self.sums.steps += 1.0;
                if self.rng.random::<f32>() < recipe.imitation.kick_probability {
                    bend(&mut member.x, recipe.imitation.kick, &mut self.rng);
                }
            }
        }
        net.backward(&self.d_output, &mut self.scratch, &mut self.gradient);
        for index in 0..self.cases.len() {
            self.cases[index].left -= 1;
            if self.cases[index].left == 0 {
                self.end(index);
                self.cases[index] = self.draw(recipe);
            }
        }
    }

    fn end(&mut self, index: usize) {
        let case = &self.cases[index];
        let solved = case.members[0].solved;
        self.sums.ended += 1.0;
        self.sums.solved += f64::from(u8::from(solved));
        if !solved && self.failed.len() < MOST_FAILED {
            self.failed.push(case.task);
        }
    }

    /// A new case: a failed task again, or a fresh one that has an answer.
    fn draw(&mut self, recipe: &Recipe) -> Case {
        let settings = &recipe.imitation;
        loop {
            let again = self.rng.random::<f32>() < settings.retry && !self.failed.is_empty();
            let number = if again {
                let which = self.rng.random_range(0..self.failed.len());
                self.failed.swap_remove(which)
            } else {
                self.next_task += 1;
                self.next_task
            };
            // What a number stands for must not depend on when it is drawn.
            let mut own = stream(recipe.seed, Purpose::Imitation, number, 1 << 40);
            let task = recipe.tasks.draw(number, &mut own);
            let scene = Arc::new(Scene::of(&task, &Profile::DEFAULT));
            let is_direct = scene.certifier().segment_is_free(task.start, task.goal);
            if is_direct && own.random::<f32>() >= recipe.tasks.direct {
                continue;
            }
            let Ok(objective) = Objective::new(&task, scene, self.waypoints) else { continue };
            let targets = routes::targets(&task, &objective, &mut own);
            if targets.is_empty() {
                continue;
            }
            let members = KINDS.map(|kind| {
                let view = WaypointView::new(&recipe.probes, &objective);
                let x = vec![0.0; objective.dim()];
                let mut member = Member { kind, x, view, solved: false };
                begin(kind, &objective, &mut self.rng, &mut member);
                member
            });
            let long = self.rng.random::<f32>() < settings.long_share;
            let left = if long { settings.long_life } else { settings.life };
            return Case { task: number, objective, targets, members: members.into(), left };
        }
    }
}

/// Puts a member at the start of a walk.
fn begin(kind: Kind, objective: &Objective, rng: &mut ChaCha8Rng, member: &mut Member) {
    member.kind = kind;
    member.view.reset();
    match kind {
        Kind::Straight => objective.straight_line(&mut member.x),
        Kind::Bent => {
            objective.straight_line(&mut member.x);
            let size = rng.random_range(0.2..1.5);
            bend(&mut member.x, size, rng);
        }
        Kind::Via => StartStrategy::ViaPoint.draw(objective, rng, &mut member.x),
    }
}

/// The loss of one step from `before` to `after` (`[N x 2]`); its gradient with respect to the network's outputs is
/// appended to `d_output`.
#[allow(clippy::too_many_arguments, reason = "one formula, and all it is made of")]
fn loss(
    objective: &Objective,
    targets: &[Target],
    along: [f32; 2],
    before: &[f32],
    after: &[f32],
    outputs: impl Fn(usize) -> [f32; 2],
    scale: f32,
    hinge_weight: f32,
    d_output: &mut Vec<[f32; 2]>,
) -> f64 {
    let (from, to) = (before.as_chunks::<2>().0, after.as_chunks::<2>().0);
    let target = nearest(targets, before).map(|target| target.as_chunks::<2>().0);
    let mut pull = vec![[0.0_f32; 2]; to.len()];
    let mut total = hinge(objective, to, hinge_weight, &mut pull);
    let [c, s] = along;
    for i in 0..from.len() {
        let output = outputs(i);
        // From normalised units to pixels per unit of output.
        let gain = scale / PIXEL;
        // The hinge's pull is in field axes, the output in frame axes.
        let mut slope =
            [gain * (c * pull[i][0] + s * pull[i][1]), gain * (c * pull[i][1] - s * pull[i][0])];
        if let Some(target) = target {
            let wish = [0, 1].map(|a| 0.5 * (target[i][a] - from[i][a]) / PIXEL);
            let size = wish[0].hypot(wish[1]);
            let factor = if size > 8.0 { 8.0 / size } else { 1.0 };
            let wish = [factor * (c * wish[0] + s * wish[1]), factor * (c * wish[1] - s * wish[0])];
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

/// The weighed hinge on a trajectory; its gradient per pixel of a waypoint's motion is added to `pull`, in field axes.
fn hinge(objective: &Objective, points: &[[f32; 2]], weight: f32, pull: &mut [[f32; 2]]) -> f64 {
    let field = objective.scene().exact_field();
    let mut sampler = sidestep::distance::Sampler::default();
    let (start, goal) = (objective.start(), objective.goal());
    let mut from = start;
    let per_segment = HINGE_POINTS + 1;
    for &to in points.iter().chain([&goal]) {
        for k in 1..=per_segment {
            let t = k as f32 / per_segment as f32;
            sampler.push([from[0] + t * (to[0] - from[0]), from[1] + t * (to[1] - from[1])]);
        }
        from = to;
    }
    let mut total = 0.0;
    for (index, (distance, gradient)) in sampler.sample(field).enumerate() {
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

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::rand_core::SeedableRng;
    use sidestep::rng::standard_normal;
    use sidestep::suite::candidate;

    /// Slopes of the loss with respect to the outputs, one coordinate at a time, against differences of the loss.
    #[test]
    fn slopes_are_differences_of_the_loss() {
        let probes = Probes::named("probes:4x1").unwrap();
        let rule = ActionRule { scale: 0.4, limit: 1.6, keep_inside: true };
        let (mut close, mut all) = (0, 0);
        for index in 0..12 {
            let task = candidate(1000, index);
            let scene = Arc::new(Scene::of(&task, &Profile::DEFAULT));
            let objective = Objective::new(&task, scene, 10).unwrap();
            let mut rng = ChaCha8Rng::seed_from_u64(index);
            let targets = routes::targets(&task, &objective, &mut rng);
            let mut before = vec![0.0; 20];
            objective.straight_line(&mut before);
            let outputs: Vec<[f32; 2]> = (0..10).map(|_| standard_normal(&mut rng)).collect();
            let value = |outputs: &[[f32; 2]], slopes: &mut Vec<[f32; 2]>| {
                let mut view = WaypointView::new(&probes, &objective);
                let mut after = before.clone();
                view.apply(&rule, |i| outputs[i], &mut after);
                let along = view.along();
                let of = |i: usize| outputs[i];
                loss(&objective, &targets, along, &before, &after, of, rule.scale, 1.0, slopes)
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
