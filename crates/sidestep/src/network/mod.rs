//! Networks that turn observations into updates: the paper's multi-layer perceptron ([`Mlp`]), its convolutional network for
//! images ([`Cnn`]), and the network with weights shared over waypoints ([`WaypointNet`]).
//!
//! One forward pass serves planning and training; the backward pass stands beside it. Parameters are one
//! flat f32 vector, so that an optimizer and a checkpoint need to know nothing about layers.

mod cnn;
mod convolution;
mod layer;
mod map_net;
mod mlp;
mod neighbours;
mod scratch;
mod waypoint_net;
mod waypoint_shape;

pub use cnn::{Cnn, FEATURES, IMAGE_SIDE, Part};
pub use map_net::{MAP_INPUTS, MapScratch, MapShape};
pub use mlp::{MAX_PARAMETERS, Mlp};
pub use scratch::Scratch;
pub use waypoint_net::{WaypointNet, WaypointScratch};
pub use waypoint_shape::WaypointShape;

/// The network of a policy that sees a whole trajectory: the observation decides which one it takes.
#[derive(Debug, Clone, PartialEq)]
pub enum Network {
    /// Dense layers.
    Mlp(Mlp),
    /// Convolutions over an image, then dense layers.
    Cnn(Box<Cnn>),
}

impl From<Mlp> for Network {
    fn from(mlp: Mlp) -> Self {
        Self::Mlp(mlp)
    }
}

impl From<Cnn> for Network {
    fn from(cnn: Cnn) -> Self {
        Self::Cnn(Box::new(cnn))
    }
}

impl Network {
    /// Name of the architecture, for files.
    pub fn architecture(&self) -> &'static str {
        match self {
            Self::Mlp(_) => "mlp",
            Self::Cnn(_) => "cnn",
        }
    }

    /// Sizes of the layers, observation first.
    pub fn sizes(&self) -> &[usize] {
        match self {
            Self::Mlp(mlp) => mlp.sizes(),
            Self::Cnn(cnn) => cnn.sizes(),
        }
    }

    /// Numbers that go in.
    pub fn inputs(&self) -> usize {
        self.sizes()[0]
    }

    /// Numbers that come out.
    pub fn outputs(&self) -> usize {
        self.sizes()[self.sizes().len() - 1]
    }

    /// The flat parameters.
    pub fn parameters(&self) -> &[f32] {
        match self {
            Self::Mlp(mlp) => mlp.parameters(),
            Self::Cnn(cnn) => cnn.parameters(),
        }
    }

    /// Changes the parameters in place.
    pub fn update(&mut self, change: impl FnOnce(&mut [f32])) {
        match self {
            Self::Mlp(mlp) => mlp.update(change),
            Self::Cnn(cnn) => cnn.update(change),
        }
    }

    /// The output `[outputs]` for one `input [inputs]`.
    ///
    /// # Panics
    /// If a slice is shorter than its size.
    pub fn forward(&self, input: &[f32], scratch: &mut Scratch, output: &mut [f32]) {
        self.forward_batch(&input[..self.inputs()], scratch);
        output[..self.outputs()].copy_from_slice(scratch.output(0));
    }

    /// The outputs for `inputs [rows x inputs]`, read from [`Scratch::output`].
    pub fn forward_batch(&self, inputs: &[f32], scratch: &mut Scratch) {
        match self {
            Self::Mlp(mlp) => mlp.forward_batch(inputs, scratch),
            Self::Cnn(cnn) => cnn.forward_batch(inputs, scratch),
        }
    }

    /// The flat parameters by name, for files.
    pub fn parts(&self) -> Vec<Part> {
        match self {
            Self::Mlp(mlp) => {
                let layers = mlp.layer_ranges().zip(mlp.sizes().windows(2)).enumerate();
                let parts = layers.flat_map(|(layer, ((weights, biases), pair))| {
                    let name = |what: &str| format!("layers.{layer}.{what}");
                    [
                        (name("weight"), vec![pair[1], pair[0]], weights),
                        (name("bias"), vec![pair[1]], biases),
                    ]
                });
                parts.collect()
            }
            Self::Cnn(cnn) => cnn.parts(),
        }
    }
}
