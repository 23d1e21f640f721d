//! Initial parameters of policy and value networks. Biases are zero throughout.
//!
//! The paper says "weights are initialized with identity matrix" (section II.B). Its published code
//! sets that and then hands the networks to a library that overwrites it in every layer with the
//! orthogonal initialisation, with the gains of detail 2 of Huang et al., "The 37 Implementation
//! Details of PPO" (ICLR blog track 2022).

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use sidestep::InvalidInput;
use sidestep::network::{Cnn, Mlp, Network};
use sidestep::policy::observation::{ObservationPart, image_place, sizes_for};

use sidestep::rng::standard_normal;

/// How weights begin.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Initialization {
    /// Every weight matrix is a rectangular identity: 1 where row = column, else 0 (the paper's
    /// text). It cannot learn much: hidden units beyond the observation's length stay dead, for
    /// nothing goes into them or comes out.
    Identity,
    /// Orthogonal rows or columns, gain sqrt(2) in hidden layers, 0.01 at the policy's head, 1 at
    /// the value's. It is what ran when the paper's results were made, so it is the default.
    #[default]
    Orthogonal,
}

/// What a network is for; some initialisations treat the two differently.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// From observation to update.
    Policy,
    /// From observation to expected return.
    Value,
}

impl Initialization {
    /// A new network of these sizes; draws from `rng` only where the initialisation is random.
    ///
    /// # Errors
    /// If [`Mlp::new`] refuses the sizes.
    pub fn network(
        self,
        sizes: &[usize],
        role: Role,
        rng: &mut ChaCha8Rng,
    ) -> Result<Mlp, InvalidInput> {
        let mut parameters = Vec::with_capacity(Mlp::parameter_count(sizes)?);
        let layers = sizes.len() - 1;
        for (layer, pair) in sizes.windows(2).enumerate() {
            let (inputs, outputs) = (pair[0], pair[1]);
            let last = layer + 1 == layers;
            let weights = match self {
                Self::Identity => identity(inputs, outputs),
                Self::Orthogonal => {
                    let gain = match (last, role) {
                        (false, _) => std::f64::consts::SQRT_2,
                        (true, Role::Policy) => 0.01,
                        (true, Role::Value) => 1.0,
                    };
                    orthogonal(inputs, outputs, gain, rng)
                }
            };
            parameters.extend(weights);
            parameters.extend(std::iter::repeat_n(0.0, outputs));
        }
        Mlp::new(sizes, parameters)
    }
}

impl Initialization {
    /// A new policy that sees `parts` of so many waypoints, with two hidden layers. Convolutions
    /// begin uniform in +-sqrt(6 / inputs), which keeps the variance through ReLU (He et al. 2015,
    /// doi:10.1109/ICCV.2015.123), whatever the initialisation says of dense layers; a skip
    /// connection begins at 0.
    ///
    /// # Errors
    /// If a size is 0 or too large.
    pub fn policy(
        self,
        parts: &[ObservationPart],
        waypoints: usize,
        hidden: usize,
        rng: &mut ChaCha8Rng,
    ) -> Result<Network, InvalidInput> {
        let sizes = sizes_for(parts, waypoints, 2, &[hidden, hidden], 2 * waypoints);
        let Some(image_at) = image_place(parts, waypoints, 2) else {
            return Ok(self.network(&sizes, Role::Policy, rng)?.into());
        };
        let head = self.network(&sizes[1..], Role::Policy, rng)?;
        let mut parameters = vec![0.0; Cnn::parameter_count(&sizes, image_at)?];
        for (inputs, range) in Cnn::convolution_weights() {
            let gain = 6.0_f32.sqrt();
            let weights = uniform(inputs, range.len() / inputs, rng);
            parameters[range].iter_mut().zip(weights).for_each(|(p, w)| *p = gain * w);
        }
        parameters[Cnn::head_range(&sizes, image_at)?].copy_from_slice(head.parameters());
        Ok(Cnn::new(&sizes, image_at, parameters)?.into())
    }
}

/// `[outputs x inputs]`, 1 on the diagonal.
fn identity(inputs: usize, outputs: usize) -> Vec<f32> {
    let entry = |index: usize| if index / inputs == index % inputs { 1.0 } else { 0.0 };
    (0..inputs * outputs).map(entry).collect()
}

/// `[outputs x inputs]`, uniform in +-1/sqrt(inputs).
fn uniform(inputs: usize, outputs: usize, rng: &mut ChaCha8Rng) -> Vec<f32> {
    let bound = 1.0 / (inputs as f32).sqrt();
    (0..inputs * outputs).map(|_| bound * (2.0 * rng.random::<f32>() - 1.0)).collect()
}

/// `[outputs x inputs]` with orthonormal rows (or columns, if there are more rows) times `gain`: a
/// Gaussian matrix orthonormalised by modified Gram-Schmidt in f64, done twice, which is enough
/// (Giraud et al. 2005). Its distribution is that of QR with positive diagonal.
fn orthogonal(inputs: usize, outputs: usize, gain: f64, rng: &mut ChaCha8Rng) -> Vec<f32> {
    let (count, length) = (inputs.min(outputs), inputs.max(outputs));
    let mut vectors: Vec<Vec<f64>> = Vec::with_capacity(count);
    while vectors.len() < count {
        let mut vector: Vec<f64> = (0..length.div_ceil(2))
            .flat_map(|_| standard_normal(rng))
            .take(length)
            .map(f64::from)
            .collect();
        for _ in 0..2 {
            for earlier in &vectors {
                let along: f64 = earlier.iter().zip(&vector).map(|(a, b)| a * b).sum();
                vector.iter_mut().zip(earlier).for_each(|(v, e)| *v -= along * e);
            }
        }
        let norm = vector.iter().map(|v| v * v).sum::<f64>().sqrt();
        // A draw in the span of the earlier ones has probability 0; draw again rather than divide
        // by 0.
        if norm > 1e-6 {
            vector.iter_mut().for_each(|v| *v /= norm);
            vectors.push(vector);
        }
    }
    let entry = |row: usize, column: usize| {
        let value = if outputs <= inputs { vectors[row][column] } else { vectors[column][row] };
        (gain * value) as f32
    };
    (0..outputs)
        .flat_map(|row| (0..inputs).map(move |column| (row, column)))
        .map(|(r, c)| entry(r, c))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use sidestep::rng::{Purpose, stream};

    fn weights(init: Initialization, role: Role, sizes: &[usize], layer: usize) -> Vec<f32> {
        let mlp = init.network(sizes, role, &mut stream(1, Purpose::Parameters, 0, 0)).unwrap();
        let ranges: Vec<_> = mlp.layer_ranges().collect();
        assert!(ranges.iter().all(|(_, b)| mlp.parameters()[b.clone()].iter().all(|&x| x == 0.0)));
        mlp.parameters()[ranges[layer].0.clone()].to_vec()
    }

    #[test]
    fn identity_is_rectangular() {
        let eye = weights(Initialization::Identity, Role::Policy, &[2, 3, 2], 0);
        assert_eq!(eye, [1.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
    }

    #[test]
    fn orthogonal_rows_or_columns() {
        let check = |role, sizes: &[usize], layer: usize, gain: f32| {
            let (inputs, outputs) = (sizes[layer], sizes[layer + 1]);
            let w = weights(Initialization::Orthogonal, role, sizes, layer);
            let at = |r: usize, c: usize| w[r * inputs + c];
            let (count, length) = (inputs.min(outputs), inputs.max(outputs));
            for i in 0..count {
                for j in 0..count {
                    let dot: f32 = (0..length)
                        .map(|k| {
                            if outputs <= inputs {
                                at(i, k) * at(j, k)
                            } else {
                                at(k, i) * at(k, j)
                            }
                        })
                        .sum();
                    let expected = if i == j { gain * gain } else { 0.0 };
                    assert!((dot - expected).abs() <= 1e-6 * (1.0 + expected), "{dot} {expected}");
                }
            }
        };
        let (hidden, sizes) = (2.0_f32.sqrt(), [5, 8, 8, 3]);
        check(Role::Policy, &sizes, 0, hidden);
        check(Role::Policy, &sizes, 1, hidden);
        check(Role::Policy, &sizes, 2, 0.01);
        check(Role::Value, &sizes, 2, 1.0);
    }
}
