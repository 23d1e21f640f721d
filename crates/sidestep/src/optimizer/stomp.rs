//! STOMP (Kalakrishnan et al. 2011, doi:10.1109/ICRA.2011.5980280): noisy trajectories, weighed
//! waypoint by waypoint by the exponential of their cost.
//!
//! Noise has covariance R⁻¹ for R = AᵀA with second differences A, ends held; the weighted mean of
//! the noise is smoothed by M, which is R⁻¹ with each column scaled to a largest entry of 1/N.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::error::InvalidInput;
use crate::objective::Objective;

#[derive(Debug)]
pub(super) struct Stomp {
    rollouts: usize,
    dof: usize,
    rng: ChaCha8Rng,
    /// `[N x N]` L with L Lᵀ = noise² R⁻¹, its largest variance scaled to 1 first.
    factor: Vec<f32>,
    /// `[N x N]` M.
    smoothing: Vec<f32>,
    /// `[rollouts x N x dof]`.
    noise: Vec<f32>,
    /// `[rollouts x N]`.
    costs: Vec<f32>,
    trial: Vec<f32>,
}

/// How sharply the best rollouts are preferred (the publication's h).
const SENSITIVITY: f32 = 10.0;
/// Most waypoints: the noise needs matrices of N x N numbers and N³ steps to make them.
const MAX_WAYPOINTS: usize = 500;

impl Stomp {
    pub fn new(
        rollouts: usize,
        noise: f32,
        waypoints: usize,
        dof: usize,
        rng: ChaCha8Rng,
    ) -> Result<Self, InvalidInput> {
        if waypoints > MAX_WAYPOINTS {
            let allowed = format!("at most {MAX_WAYPOINTS} with stomp");
            return Err(InvalidInput::new("waypoints", waypoints, allowed));
        }
        let n = waypoints;
        let inverse = inverse_second_difference_metric(n);
        let largest = (0..n).map(|i| inverse[i * n + i]).fold(f64::MIN_POSITIVE, f64::max);
        let factor = cholesky(&inverse.iter().map(|v| v / largest).collect::<Vec<_>>(), n);
        let mut smoothing = vec![0.0; n * n];
        for column in 0..n {
            let peak =
                (0..n).map(|i| inverse[i * n + column].abs()).fold(f64::MIN_POSITIVE, f64::max);
            for row in 0..n {
                smoothing[row * n + column] = (inverse[row * n + column] / peak / n as f64) as f32;
            }
        }
        Ok(Self {
            rollouts,
            dof,
            rng,
            factor: factor.iter().map(|&v| v as f32 * noise).collect(),
            smoothing,
            noise: vec![0.0; rollouts * n * dof],
            costs: vec![0.0; rollouts * n],
            trial: vec![0.0; n * dof],
        })
    }

    pub fn step(&mut self, x: &mut [f32], objective: &mut Objective) {
        let (dof, dim) = (self.dof, x.len());
        let n = dim / dof;
        for k in 0..self.rollouts {
            let noise = &mut self.noise[k * dim..(k + 1) * dim];
            draw_noise(&mut self.rng, &self.factor, dof, noise);
            for ((trial, x), e) in self.trial.iter_mut().zip(&*x).zip(&*noise) {
                *trial = x + e;
            }
            objective.cost(&self.trial);
            let costs = &mut self.costs[k * n..(k + 1) * n];
            objective.local_costs(costs);
        }
        let mut update = vec![0.0f32; dim];
        for (i, update) in update.chunks_exact_mut(dof).enumerate() {
            let cost = |k: usize| self.costs[k * n + i];
            let least = (0..self.rollouts).map(cost).fold(f32::INFINITY, f32::min);
            let most = (0..self.rollouts).map(cost).fold(f32::NEG_INFINITY, f32::max);
            let range = (most - least).max(1e-9);
            let mut total = 0.0;
            for k in 0..self.rollouts {
                let weight = (-SENSITIVITY * (cost(k) - least) / range).exp();
                total += weight;
                let noise = &self.noise[k * dim + i * dof..][..dof];
                update.iter_mut().zip(noise).for_each(|(u, e)| *u += weight * e);
            }
            update.iter_mut().for_each(|u| *u /= total);
        }
        for (i, x) in x.chunks_exact_mut(dof).enumerate() {
            for (j, update) in update.chunks_exact(dof).enumerate() {
                let smoothing = self.smoothing[i * n + j];
                x.iter_mut().zip(update).for_each(|(x, u)| *x += smoothing * u);
            }
        }
    }
}

/// Fills `noise` (`[N x dof]`) with L z for standard normal z on each coordinate.
fn draw_noise(rng: &mut ChaCha8Rng, factor: &[f32], dof: usize, noise: &mut [f32]) {
    let n = noise.len() / dof;
    let pairs = noise.len().div_ceil(2);
    let normals: Vec<f32> = (0..pairs).flat_map(|_| normal_pair(rng)).collect();
    for (i, noise) in noise.chunks_exact_mut(dof).enumerate() {
        for (k, noise) in noise.iter_mut().enumerate() {
            *noise = (0..=i).map(|j| factor[i * n + j] * normals[dof * j + k]).sum();
        }
    }
}

/// Two standard normal numbers (Box & Muller 1958).
fn normal_pair(rng: &mut ChaCha8Rng) -> [f32; 2] {
    let radius = (-2.0 * (1.0 - rng.random::<f32>()).ln()).sqrt();
    let angle = std::f32::consts::TAU * rng.random::<f32>();
    [radius * angle.cos(), radius * angle.sin()]
}

/// (AᵀA)⁻¹ = K⁻¹ K⁻¹ for A = K, the tridiagonal second difference matrix, with
/// K⁻¹_ij = min(i, j) (n + 1 - max(i, j)) / (n + 1), counting from 1.
fn inverse_second_difference_metric(n: usize) -> Vec<f64> {
    let inverse =
        |i: usize, j: usize| (i.min(j) + 1) as f64 * (n - i.max(j)) as f64 / (n + 1) as f64;
    let entry = |i: usize, j: usize| (0..n).map(|k| inverse(i, k) * inverse(k, j)).sum();
    (0..n * n).map(|index| entry(index / n, index % n)).collect()
}

/// Lower triangular L with L Lᵀ = `matrix`.
fn cholesky(matrix: &[f64], n: usize) -> Vec<f64> {
    let mut l = vec![0.0; n * n];
    for i in 0..n {
        for j in 0..=i {
            let dot: f64 = (0..j).map(|k| l[i * n + k] * l[j * n + k]).sum();
            let rest = matrix[i * n + j] - dot;
            l[i * n + j] = if i == j { rest.max(1e-12).sqrt() } else { rest / l[j * n + j] };
        }
    }
    l
}
