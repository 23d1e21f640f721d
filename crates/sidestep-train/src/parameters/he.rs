//! Initial parameters of a waypoint policy's network.

use sidestep::InvalidInput;
use sidestep::network::WaypointShape;
use sidestep::rng::{Purpose, standard_normal, stream};

/// He initialisation (2015) of rectified layers, outward layers at a half of it shared among the
/// blocks, a small head; zero biases.
pub fn he(shape: &WaypointShape, seed: u64) -> Result<Vec<f32>, InvalidInput> {
    let mut rng = stream(seed, Purpose::Parameters, 0, 0);
    let mut parameters = Vec::with_capacity(shape.parameter_count()?);
    let sizes = shape.layer_sizes();
    let blocks = shape.dilations.len().max(1) as f32;
    let head = 2 * shape.dilations.len() + 1;
    let map_blocks = shape.map.as_ref().map_or(1, |map| map.dilations.len().max(1)) as f32;
    for (index, &(inputs, outputs)) in sizes.iter().enumerate() {
        let he = (2.0 / inputs as f32).sqrt();
        let deviation = if index == head {
            0.1 * he
        } else if index > head + 1 {
            he / map_blocks.sqrt()
        } else if index > head {
            he
        } else if index > 0 && index % 2 == 0 {
            0.5 * he / blocks.sqrt()
        } else {
            he
        };
        let draws = (0..(inputs * outputs).div_ceil(2)).flat_map(|_| standard_normal(&mut rng));
        parameters.extend(draws.take(inputs * outputs).map(|z| deviation * z));
        parameters.extend(std::iter::repeat_n(0.0, outputs));
    }
    Ok(parameters)
}
