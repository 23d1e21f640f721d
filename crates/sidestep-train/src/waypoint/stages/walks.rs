//! Noisy walks of the policy on a task, and what they are worth; [`super::gradient`] learns from
//! them.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use sidestep::network::{WaypointNet, WaypointScratch};
use sidestep::objective::Objective;
use sidestep::plan::rrt_connect::shortcut;
use sidestep::plan::starts::StartStrategy;
use sidestep::rng::{Purpose, stream};
use sidestep::trajectory::waypoints::bend;

use super::imitation::{Ingredients, Sums};
use super::loss::PIXEL;
use crate::routes::Target;
use crate::waypoint::config::PolicyGradientConfig;
use crate::waypoint::ready::{Ready, reference_length};
use crate::waypoint::sight::View;
use sidestep::rng::standard_normal;

/// Shapes of noise along the trajectory.
pub(crate) const MODES: usize = 8;

/// Walks of a task that are repaired.
const REPAIRED: usize = 2;

/// One walk and what it is worth.
#[derive(Debug, Clone)]
pub(crate) struct Walk {
    x: Vec<f32>,
    pub view: View,
    /// Steps until it was free.
    solved: Option<usize>,
    /// Rows that went into the network, step by step.
    pub seen: Vec<f32>,
    /// Where the waypoints were then, `[steps x N x dof]`.
    pub places: Vec<f32>,
    /// Noise z, `[steps x MODES x dof]`.
    pub noise: Vec<f32>,
    /// What is learned from it.
    pub worth: Worth,
}

/// What is learned from a walk.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Worth {
    /// Nothing: all walks of the task are worth the same.
    Nothing,
    /// To do more of the same, or less: A.
    Advantage(f32),
    /// What the expert would have done, for no walk of the task got through.
    Repair,
}

/// The walks on one task.
#[derive(Debug)]
pub(crate) struct Walked {
    pub waypoints: usize,
    pub shapes: Shapes,
    pub ready: Ready,
    pub walks: Vec<Walk>,
    /// The expert's answers where walks are to be repaired.
    pub targets: Vec<Target>,
}

/// What all walks have in common.
#[derive(Clone, Copy)]
pub(crate) struct Walker<'a> {
    pub net: &'a WaypointNet,
    pub ingredients: &'a Ingredients,
    pub settings: &'a PolicyGradientConfig,
}

impl Walker<'_> {
    /// Standard deviation of the first mode, in units of output.
    pub fn sigma(&self) -> f32 {
        self.settings.noise_pixels / (self.ingredients.rule.scale / PIXEL)
    }

    /// The walks on task `index` of update `update`.
    pub fn walk(
        &self,
        update: u64,
        index: u64,
        scratch: &mut WaypointScratch,
        sums: &mut Sums,
    ) -> Walked {
        let mut number = 1 << 44 | (update * 256 + index) << 16;
        loop {
            number += 1;
            if let Some(walked) = self.walk_task(number, scratch, sums) {
                return walked;
            }
        }
    }

    /// None if the task is not worth walking.
    fn walk_task(
        &self,
        number: u64,
        scratch: &mut WaypointScratch,
        sums: &mut Sums,
    ) -> Option<Walked> {
        let Self { net, ingredients, settings } = *self;
        let mut rng = stream(ingredients.seed, Purpose::Environment, number, 0);
        let task = ingredients.tasks.draw(&ingredients.sight, number, &mut rng)?;
        let query = Ready::query(&task);
        if query.scene().motion_is_free(query.start(), query.goal()) {
            return None;
        }
        let waypoints = ingredients.tasks.draw_waypoints(&mut rng);
        let objective = Objective::new(&query, waypoints).ok()?;
        let x = self.start(&objective, &mut rng);
        let mut ready = Ready::new(&ingredients.sight, objective)?;
        let view = ready.view(&ingredients.sight)?;
        ready.begin_map(net);
        let keeps = rng.random::<f32>() < settings.solved;
        let policy = (net, &ingredients.rule);
        let mut solves = |scratch: &mut WaypointScratch| {
            let (view, x) = (view.clone(), x.clone());
            ready.first_free(view, x, policy, settings.steps, scratch).is_some()
        };
        if !keeps && solves(scratch) {
            return None;
        }
        let shortest = reference_length(&query, &mut rng)?;
        let walk = Walk {
            x,
            view,
            solved: None,
            seen: Vec::new(),
            places: Vec::new(),
            noise: Vec::new(),
            worth: Worth::Nothing,
        };
        let mut walks = vec![walk; settings.walks];
        let shapes = Shapes::new(waypoints);
        self.go(&mut ready, &shapes, &mut walks, scratch, &mut rng);
        let mut score = |walk: &Walk| match walk.solved {
            Some(t) => {
                let length = length(&ready.objective, &walk.x, settings.short_cuts, &mut rng);
                let longer = ((length / shortest - 1.0) as f32).clamp(0.0, 1.0);
                1.0 - settings.haste * t as f32 / settings.steps as f32 - settings.stretch * longer
            }
            None => 0.0,
        };
        let returns: Vec<f32> = walks.iter().map(&mut score).collect();
        let count = returns.len() as f32;
        let mean = returns.iter().sum::<f32>() / count;
        let spread = (returns.iter().map(|r| (r - mean) * (r - mean)).sum::<f32>() / count).sqrt();
        sums.loss -= f64::from(mean) * f64::from(count);
        sums.ended += f64::from(count);
        sums.solved += walks.iter().filter(|walk| walk.solved.is_some()).count() as f64;
        let dim = waypoints * net.input_stride();
        for (walk, r) in walks.iter_mut().zip(&returns) {
            sums.steps += (walk.seen.len() / dim) as f64;
            if spread >= 1e-6 {
                walk.worth = Worth::Advantage((r - mean) / (spread + 0.1));
            }
        }
        let mut targets = Vec::new();
        if settings.repair > 0.0 && walks.iter().all(|walk| walk.solved.is_none()) {
            targets = ready.targets(&task, &mut rng);
            if !targets.is_empty() {
                walks.iter_mut().take(REPAIRED).for_each(|walk| walk.worth = Worth::Repair);
            }
        }
        Some(Walked { waypoints, shapes, ready, walks, targets })
    }

    /// The straight line, or a random bend of it or via-point.
    fn start(&self, objective: &Objective, rng: &mut ChaCha8Rng) -> Vec<f32> {
        let mut x = vec![0.0; objective.dim()];
        objective.straight_line(&mut x);
        if rng.random::<f32>() < self.settings.other_starts {
            if rng.random::<bool>() {
                StartStrategy::ViaPoint.draw(objective, rng, &mut x);
            } else {
                bend(objective.dof(), &mut x, 1.0, rng);
            }
        }
        x
    }

    /// Walks until free, or all steps.
    fn go(
        &self,
        ready: &mut Ready,
        shapes: &Shapes,
        walks: &mut [Walk],
        scratch: &mut WaypointScratch,
        rng: &mut ChaCha8Rng,
    ) {
        let Self { net, ingredients, settings } = *self;
        let (waypoints, stride) = (ready.objective.waypoints(), net.input_stride());
        let (dim, sigma) = (waypoints * stride, self.sigma());
        let (dof, mut free, mut outputs) = (ready.objective.dof(), Vec::new(), Vec::new());
        for step in 0..=settings.steps {
            let mut active = Vec::with_capacity(walks.len());
            let input = scratch.input(walks.len() * waypoints, stride);
            for (index, walk) in walks.iter_mut().enumerate() {
                if walk.solved.is_some() {
                    continue;
                }
                if ready.is_free(&walk.x, &mut free) {
                    walk.solved = Some(step);
                } else if step < settings.steps {
                    let block = &mut input[active.len() * dim..][..dim];
                    ready.see(&mut walk.view, &walk.x, &free, block, stride);
                    walk.seen.extend_from_slice(block);
                    walk.places.extend_from_slice(&walk.x);
                    active.push(index);
                }
            }
            if active.is_empty() {
                break;
            }
            scratch.input(active.len() * waypoints, stride);
            net.forward(scratch, waypoints);
            for (place, &index) in active.iter().enumerate() {
                let walk = &mut walks[index];
                let draws = (MODES * dof).div_ceil(2);
                let mut z: Vec<f32> = (0..draws).flat_map(|_| standard_normal(rng)).collect();
                z.truncate(MODES * dof);
                scratch.outputs(place * waypoints..(place + 1) * waypoints, &mut outputs);
                for (i, out) in outputs.chunks_exact_mut(dof).enumerate() {
                    for (mode, z) in z.chunks_exact(dof).enumerate() {
                        let size = sigma / (mode + 1) as f32 * shapes.values[mode][i];
                        out.iter_mut().zip(z).for_each(|(out, z)| *out += size * z);
                    }
                }
                walk.view.apply(&ready.objective, &ingredients.rule, &outputs, &mut walk.x);
                walk.noise.extend(z);
            }
        }
    }
}

/// The length of a free trajectory, after so many random short cuts.
fn length(objective: &Objective, x: &[f32], rounds: usize, rng: &mut ChaCha8Rng) -> f64 {
    let mut path = objective.trajectory(x);
    if rounds > 0 {
        let is_free = |from: &[f64], to: &[f64]| objective.scene().motion_is_free(from, to);
        shortcut(&mut path, is_free, rounds, rng);
    }
    path.length()
}

/// The noise modes over the waypoints; orthogonal where there are no fewer waypoints than modes.
#[derive(Debug)]
pub(crate) struct Shapes {
    pub values: [Vec<f32>; MODES],
    pub squares: [f32; MODES],
}

impl Shapes {
    pub fn new(waypoints: usize) -> Self {
        let angle = std::f32::consts::PI / (waypoints + 1) as f32;
        let values = std::array::from_fn(|mode| {
            (1..=waypoints).map(|i| ((mode + 1) as f32 * i as f32 * angle).sin()).collect()
        });
        let squares = std::array::from_fn(|mode| {
            let values: &Vec<f32> = &values[mode];
            values.iter().map(|v| v * v).sum::<f32>().max(1e-3)
        });
        Self { values, squares }
    }
}
