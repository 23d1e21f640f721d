//! Policy gradient on success (REINFORCE: Williams 1992) with the task's own walks as the baseline.
//!
//! Each task is walked K times from one start, mostly the straight line, with smooth noise on every step: with shapes phi_k(i) = sin(pi k i / (N + 1))
//! and z standard normal,
//!
//! ```text
//! step = output + noise,   noise = sum over k = 1..4 of (sigma / k) z_k phi_k        (in both directions)
//! R = 1 - haste t / T - stretch min(length / shortest - 1, 1) where the walk is free after t of T steps, else 0
//! A = (R - mean of the task) / (standard deviation of the task + 0.1)
//! d(-A log density) / d output_i = -A sum over k of z_k phi_k(i) / (sigma / k) / |phi_k|^2
//! ```
//!
//! which is the score of the noise modes: what lies outside of them is not explored and not learned here. Tasks whose
//! walks all end alike teach nothing.

use rand::RngExt;
use sidestep::network::{WaypointNet, WaypointScratch};
use sidestep::objective::{Objective, Scene};
use sidestep::profile::Profile;
use sidestep::rng::{Purpose, stream};
use sidestep::starts::{StartStrategy, bend};
use sidestep::waypoint_view::{TaskMap, WaypointView};
use std::sync::Arc;

use super::config::PolicyGradientConfig;
use super::imitation::{Part, Recipe};
use super::loss::PIXEL;
use crate::gaussian::standard_normal;

const MODES: usize = 4;

/// Walks on one task after the other, with their buffers.
#[derive(Debug, Default)]
pub(super) struct Walks {
    scratch: WaypointScratch,
}

#[derive(Clone)]
struct Walk {
    x: Vec<f32>,
    view: WaypointView,
    /// Steps until it was free.
    solved: Option<usize>,
    /// Rows that went into the network, step by step.
    seen: Vec<f32>,
    /// Where the waypoints were then, `[steps x N x 2]`.
    places: Vec<f32>,
    /// Noise `[steps x 2 x MODES]`.
    noise: Vec<f32>,
}

impl Walks {
    /// Walks task `index` of update `update`; adds the gradient summed over walks to `part`.
    pub fn run(
        &mut self,
        net: &WaypointNet,
        recipe: &Recipe,
        settings: &PolicyGradientConfig,
        update: u64,
        index: u64,
        part: &mut Part,
    ) {
        let mut number = 1 << 44 | (update * 256 + index) << 16;
        loop {
            number += 1;
            if self.walk_task(net, recipe, settings, number, part) {
                break;
            }
        }
    }

    /// Whether the task was worth walking.
    fn walk_task(
        &mut self,
        net: &WaypointNet,
        recipe: &Recipe,
        settings: &PolicyGradientConfig,
        number: u64,
        part: &mut Part,
    ) -> bool {
        let mut rng = stream(recipe.seed, Purpose::Environment, number, 0);
        let task = recipe.tasks.draw(number, &mut rng);
        let waypoints = Profile::DEFAULT.waypoints;
        let scene = Arc::new(Scene::of(&task, &Profile::DEFAULT));
        if scene.certifier().segment_is_free(task.start, task.goal) {
            return false;
        }
        let Ok(objective) = Objective::new(&task, scene.clone(), waypoints) else { return false };
        let mut x = vec![0.0; objective.dim()];
        objective.straight_line(&mut x);
        if rng.random::<f32>() < settings.other_starts {
            if rng.random::<bool>() {
                StartStrategy::ViaPoint.draw(&objective, &mut rng, &mut x);
            } else {
                bend(&mut x, 1.0, &mut rng);
            }
        }
        let view = WaypointView::new(&recipe.view.probes, &objective);
        let mut map = recipe.view.map.as_ref().map(|shape| {
            let mut map = TaskMap::new(shape, &objective);
            net.begin_map(map.scratch());
            net.read_map(map.scratch());
            map
        });
        let keeps = rng.random::<f32>() < settings.solved;
        if !keeps && self.solves(net, recipe, settings, &objective, view.clone(), map.as_ref(), &x)
        {
            return false;
        }
        let route = scene.shortest_path().find(task.start, task.goal);
        let Some(shortest) = route.length() else { return false };
        let walk =
            Walk { x, view, solved: None, seen: Vec::new(), places: Vec::new(), noise: Vec::new() };
        let mut walks = vec![walk; settings.walks];
        let (stride, dim) = (net.input_stride(), waypoints * net.input_stride());
        let shapes = Shapes::new(waypoints);
        let gain = recipe.rule.scale / PIXEL;
        let sigma = settings.noise_pixels / gain;
        for step in 0..=settings.steps {
            let mut active = Vec::with_capacity(walks.len());
            let rows = walks.len() * waypoints;
            let input = self.scratch.input(rows, stride);
            for (index, walk) in walks.iter_mut().enumerate() {
                if walk.solved.is_some() {
                    continue;
                }
                let block = &mut input[active.len() * dim..][..dim];
                walk.view.encode(&objective, &walk.x, map.as_ref(), block, stride);
                if walk.view.is_free() {
                    walk.solved = Some(step);
                } else if step < settings.steps {
                    walk.seen.extend_from_slice(block);
                    walk.places.extend_from_slice(&walk.x);
                    active.push(index);
                }
            }
            if active.is_empty() {
                break;
            }
            self.scratch.input(active.len() * waypoints, stride);
            net.forward(&mut self.scratch, waypoints);
            for (place, &index) in active.iter().enumerate() {
                let walk = &mut walks[index];
                let z: Vec<f32> = (0..MODES).flat_map(|_| standard_normal(&mut rng)).collect();
                let output = |i: usize| {
                    let mut out = self.scratch.output(place * waypoints + i);
                    for mode in 0..MODES {
                        let size = sigma / (mode + 1) as f32 * shapes.values[mode][i];
                        out[0] += size * z[2 * mode];
                        out[1] += size * z[2 * mode + 1];
                    }
                    out
                };
                walk.view.apply(&recipe.rule, output, &mut walk.x);
                walk.noise.extend(z);
            }
        }
        let score = |walk: &Walk| match walk.solved {
            Some(t) => {
                let length = objective.trajectory(&walk.x).length();
                let longer = ((length / shortest - 1.0) as f32).clamp(0.0, 1.0);
                1.0 - settings.haste * t as f32 / settings.steps as f32 - settings.stretch * longer
            }
            None => 0.0,
        };
        let returns: Vec<f32> = walks.iter().map(score).collect();
        let count = returns.len() as f32;
        let mean = returns.iter().sum::<f32>() / count;
        let spread = (returns.iter().map(|r| (r - mean) * (r - mean)).sum::<f32>() / count).sqrt();
        part.sums.loss -= f64::from(mean) * f64::from(count);
        part.sums.ended += f64::from(count);
        part.sums.solved += walks.iter().filter(|walk| walk.solved.is_some()).count() as f64;
        for (walk, r) in walks.iter().zip(&returns) {
            part.sums.steps += (walk.seen.len() / dim) as f64;
            let advantage = (r - mean) / (spread + 0.1);
            if spread < 1e-6 {
                continue;
            }
            self.learn(net, walk, waypoints, advantage, sigma, &shapes, &mut part.gradient);
            if let Some(map) = &mut map {
                let (slopes, row_len) = (self.scratch.input_slopes(), recipe.view.row_len());
                map.collect_rows(&walk.places, slopes, stride, row_len);
            }
        }
        if let Some(map) = &mut map {
            net.map_backward(map.scratch(), &mut part.gradient);
        }
        true
    }

    /// Whether the policy walks from `x` to a free trajectory without noise.
    #[allow(clippy::too_many_arguments, reason = "all that a walk is made of")]
    fn solves(
        &mut self,
        net: &WaypointNet,
        recipe: &Recipe,
        settings: &PolicyGradientConfig,
        objective: &Objective,
        mut view: WaypointView,
        map: Option<&TaskMap>,
        x: &[f32],
    ) -> bool {
        let (waypoints, stride) = (objective.waypoints(), net.input_stride());
        let mut x = x.to_vec();
        for step in 0..=settings.steps {
            let rows = self.scratch.input(waypoints, stride);
            view.encode(objective, &x, map, rows, stride);
            if view.is_free() {
                return true;
            }
            if step < settings.steps {
                net.forward(&mut self.scratch, waypoints);
                view.apply(&recipe.rule, |i| self.scratch.output(i), &mut x);
            }
        }
        false
    }

    #[allow(clippy::too_many_arguments, reason = "one formula, and all it is made of")]
    fn learn(
        &mut self,
        net: &WaypointNet,
        walk: &Walk,
        waypoints: usize,
        advantage: f32,
        sigma: f32,
        shapes: &Shapes,
        gradient: &mut [f32],
    ) {
        let stride = net.input_stride();
        let rows = walk.seen.len() / stride;
        self.scratch.input(rows, stride).copy_from_slice(&walk.seen);
        net.forward(&mut self.scratch, waypoints);
        let mut d_output = Vec::with_capacity(rows);
        for z in walk.noise.chunks_exact(2 * MODES) {
            for i in 0..waypoints {
                let mut slope = [0.0; 2];
                for mode in 0..MODES {
                    let factor =
                        (mode + 1) as f32 / sigma * shapes.values[mode][i] / shapes.squares[mode];
                    slope[0] -= advantage * factor * z[2 * mode];
                    slope[1] -= advantage * factor * z[2 * mode + 1];
                }
                d_output.push(slope);
            }
        }
        net.backward(&d_output, &mut self.scratch, gradient);
    }
}

/// The noise modes over the waypoints.
struct Shapes {
    values: [Vec<f32>; MODES],
    squares: [f32; MODES],
}

impl Shapes {
    fn new(waypoints: usize) -> Self {
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
