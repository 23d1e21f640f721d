//! Gradient descent with heavy-ball momentum (Polyak 1964): v ← β v - γ ∂U, ξ ← ξ + v.

#[derive(Debug)]
pub(super) struct Momentum {
    step: f32,
    decay: f32,
    velocity: Vec<f32>,
}

impl Momentum {
    pub fn new(step: f32, decay: f32, n: usize) -> Self {
        Self { step, decay, velocity: vec![0.0; n] }
    }

    pub fn step(&mut self, x: &mut [f32], gradient: &[f32]) {
        for ((x, v), g) in x.iter_mut().zip(&mut self.velocity).zip(gradient) {
            *v = self.decay * *v - self.step * g;
            *x += *v;
        }
    }
}
