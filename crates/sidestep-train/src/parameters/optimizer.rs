//! First-order optimizers of parameters: Adam and Adadelta, over one flat vector.
//!
//! ```text
//! Adam (Kingma and Ba 2015)    m <- b1 m + (1 - b1) g;  v <- b2 v + (1 - b2) g^2
//!                              p <- p - lr (m / (1 - b1^t)) / (sqrt(v / (1 - b2^t)) + eps)
//! Adadelta (Zeiler 2012)       s <- rho s + (1 - rho) g^2;  d = sqrt(u + eps) / sqrt(s + eps) g
//!                              u <- rho u + (1 - rho) d^2;  p <- p - lr d
//! ```
//!
//! Both carry two moments per parameter, so one state type serves both and checkpoints need not
//! tell them apart.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use sidestep::kernels::AdamStep;

/// Adam's decays; PyTorch's and Stable-Baselines3's defaults.
const BETAS: [f64; 2] = [0.9, 0.999];
/// Adam's epsilon: 1e-5, not the usual 1e-8 (detail 3 of Huang et al. 2022).
const ADAM_EPSILON: f64 = 1e-5;
/// Adadelta's decay and epsilon, PyTorch's defaults.
const RHO: f32 = 0.9;
const ADADELTA_EPSILON: f32 = 1e-6;

/// Which optimizer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum OptimizerKind {
    /// Adam with epsilon 1e-5.
    #[default]
    Adam,
    /// Adadelta with rho 0.9, epsilon 1e-6.
    Adadelta,
}

/// An optimizer's state for a flat vector of parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Optimizer {
    kind: OptimizerKind,
    steps: u64,
    /// Adam's m and v, or Adadelta's u and s; `[parameters]` each.
    moments: [Vec<f32>; 2],
}

impl Optimizer {
    /// A fresh optimizer for so many parameters.
    pub fn new(kind: OptimizerKind, parameters: usize) -> Self {
        Self { kind, steps: 0, moments: [vec![0.0; parameters], vec![0.0; parameters]] }
    }

    /// One that goes on from a saved state.
    pub fn resumed(kind: OptimizerKind, steps: u64, moments: [Vec<f32>; 2]) -> Self {
        Self { kind, steps, moments }
    }

    /// Steps made so far.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Both moments, `[parameters]` each.
    pub fn moments(&self) -> &[Vec<f32>; 2] {
        &self.moments
    }

    /// One step on consecutive `parts` of the parameters with their `gradient [parameters]`, each
    /// gradient scaled first.
    pub fn step(
        &mut self,
        learning_rate: f64,
        gradient_scale: f32,
        gradient: &[f32],
        parts: &mut [&mut [f32]],
    ) {
        self.steps += 1;
        let adam = AdamStep::new(self.steps, learning_rate, BETAS, ADAM_EPSILON, gradient_scale);
        let mut at = 0;
        let [first, second] = &mut self.moments;
        for part in parts {
            let range = at..at + part.len();
            at = range.end;
            let (first, second) = (&mut first[range.clone()], &mut second[range.clone()]);
            match self.kind {
                OptimizerKind::Adam => adam.apply(part, &gradient[range], first, second),
                OptimizerKind::Adadelta => {
                    let lr = learning_rate as f32;
                    adadelta(lr, gradient_scale, part, &gradient[range], first, second);
                }
            }
        }
    }
}

fn adadelta(
    learning_rate: f32,
    gradient_scale: f32,
    parameters: &mut [f32],
    gradient: &[f32],
    updates: &mut [f32],
    squares: &mut [f32],
) {
    let moments = updates.iter_mut().zip(squares);
    for ((p, g), (u, s)) in parameters.iter_mut().zip(gradient).zip(moments) {
        let g = g * gradient_scale;
        *s = RHO * *s + (1.0 - RHO) * g * g;
        let update = (*u + ADADELTA_EPSILON).sqrt() / (*s + ADADELTA_EPSILON).sqrt() * g;
        *u = RHO * *u + (1.0 - RHO) * update * update;
        *p -= learning_rate * update;
    }
}
