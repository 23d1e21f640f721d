//! Sizes of the waypoint network.

use serde::{Deserialize, Serialize};

use super::MAX_PARAMETERS;
use super::map_net::MapShape;
use crate::error::InvalidInput;
use crate::kernels::LANES;

/// Most numbers per waypoint that come out.
const MAX_OUTPUTS: usize = 64;

/// Sizes of a waypoint network.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WaypointShape {
    /// Numbers per waypoint that go in.
    pub inputs: usize,
    /// Hidden units per waypoint, a multiple of 16.
    pub width: usize,
    /// One residual block each, with its convolution's dilation.
    pub dilations: Vec<usize>,
    /// Numbers per waypoint that come out: an update in each direction.
    pub outputs: usize,
    /// The map of the task that the last inputs were read from, if any.
    pub map: Option<MapShape>,
}

impl WaypointShape {
    /// Number of parameters.
    ///
    /// # Errors
    /// If the width is no multiple of 16, a size is 0 or too large, or there would be more than [`MAX_PARAMETERS`].
    pub fn parameter_count(&self) -> Result<usize, InvalidInput> {
        let refuse = |field: &str, value: usize, allowed: String| {
            Err(InvalidInput::new(format!("network.{field}"), value, allowed))
        };
        if !(1..=4096).contains(&self.inputs) {
            return refuse("inputs", self.inputs, "a number from 1 to 4096".into());
        }
        if !(LANES..=1024).contains(&self.width) || !self.width.is_multiple_of(LANES) {
            return refuse("width", self.width, format!("a multiple of {LANES} up to 1024"));
        }
        if !(1..=MAX_OUTPUTS).contains(&self.outputs) {
            return refuse("outputs", self.outputs, format!("a number from 1 to {MAX_OUTPUTS}"));
        }
        if self.dilations.len() > 64 {
            return refuse("dilations", self.dilations.len(), "up to 64 blocks".into());
        }
        if let Some(map) = self.map.as_ref().filter(|map| !map.is_allowed()) {
            let (found, allowed) = (format!("{map:?}"), MapShape::ALLOWED);
            return Err(InvalidInput::new("network.map", found, allowed));
        }
        if let Some(&dilation) = self.dilations.iter().find(|d| !(1..=1024).contains(*d)) {
            return refuse("dilations", dilation, "numbers from 1 to 1024".into());
        }
        let count = self.layer_sizes().iter().map(|(i, o)| (i + 1) * o).sum();
        if count > MAX_PARAMETERS {
            return refuse("width", self.width, format!("at most {MAX_PARAMETERS} parameters"));
        }
        Ok(count)
    }

    /// `(inputs, outputs)` of each layer, in the order of the parameters: first, then convolution and outward layer of
    /// each block, the head, and the map's.
    pub fn layer_sizes(&self) -> Vec<(usize, usize)> {
        let block = [(3 * self.width, self.width), (self.width, self.width)];
        let blocks = self.dilations.iter().flat_map(|_| block);
        let first = std::iter::once((self.inputs, self.width));
        let map = self.map.iter().flat_map(MapShape::layer_sizes);
        first.chain(blocks).chain([(self.width, self.outputs)]).chain(map).collect()
    }
}
