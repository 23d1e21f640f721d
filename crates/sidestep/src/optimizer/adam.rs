//! Adam (Kingma & Ba 2015, arXiv:1412.6980) on the waypoints.

const DECAY: f32 = 0.9;
const DECAY_SQUARE: f32 = 0.999;
const EPSILON: f32 = 1e-8;

#[derive(Debug)]
pub(super) struct Adam {
    step: f32,
    mean: Vec<f32>,
    square: Vec<f32>,
    /// β₁ᵗ and β₂ᵗ.
    decayed: f32,
    decayed_square: f32,
}

impl Adam {
    pub fn new(step: f32, n: usize) -> Self {
        Self { step, mean: vec![0.0; n], square: vec![0.0; n], decayed: 1.0, decayed_square: 1.0 }
    }

    pub fn step(&mut self, x: &mut [f32], gradient: &[f32]) {
        self.decayed *= DECAY;
        self.decayed_square *= DECAY_SQUARE;
        let (unbias, unbias_square) =
            (1.0 / (1.0 - self.decayed), 1.0 / (1.0 - self.decayed_square));
        for (i, (x, g)) in x.iter_mut().zip(gradient).enumerate() {
            self.mean[i] = DECAY * self.mean[i] + (1.0 - DECAY) * g;
            self.square[i] = DECAY_SQUARE * self.square[i] + (1.0 - DECAY_SQUARE) * g * g;
            *x -= self.step * self.mean[i] * unbias
                / ((self.square[i] * unbias_square).sqrt() + EPSILON);
        }
    }
}
