//! A policy: a network with the card that says what it sees, what its output means and where it comes from.
//!
//! On file it is a safetensors file ([`crate::tensors`]) with tensors `layers.L.weight [outputs x inputs]` and
//! `layers.L.bias [outputs]`, and the card as its document. A file is checked as a whole before it is used:
//! version, observation, sizes, every tensor's shape, every number finite.

use serde::{Deserialize, Serialize};

use crate::error::InvalidInput;
use crate::network::{Mlp, Scratch};
use crate::observation::{ObservationPart, observation_len};
use crate::profile::{MAX_WAYPOINTS, Profile};
use crate::tensors::{self, Reader, Tensor};

/// The version of the policy file that this program writes and reads.
pub const FORMAT: &str = "sidestep.policy/1";

/// The one architecture so far: tanh, tanh, .., linear.
const ARCHITECTURE: &str = "mlp";

/// From a network's output to an update of the trajectory.
///
/// ```text
/// x <- keep_inside(x + clamp(scale * output, -limit, limit))
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ActionRule {
    /// Normalised units per unit of output; the paper's is 1.
    pub scale: f32,
    /// Largest update of a coordinate, in normalised units; the paper's is 1 (10 px).
    pub limit: f32,
    /// Whether waypoints are clipped to the field, as in the paper's code.
    pub keep_inside: bool,
}

impl ActionRule {
    /// The paper's rule.
    pub const PAPER: Self = Self { scale: 1.0, limit: 1.0, keep_inside: true };

    /// Moves the waypoints `x [N x 2]` by the network output `action [N x 2]` in a field `[0, width] x [0, height]`,
    /// all in normalised units. Training and planning both call this. A NaN in `action` counts as 0.
    pub fn apply(&self, action: &[f32], field: [f32; 2], x: &mut [f32]) {
        for (index, (x, &output)) in x.iter_mut().zip(action).enumerate() {
            let update = (self.scale * output).clamp(-self.limit, self.limit);
            *x += if update.is_nan() { 0.0 } else { update };
            if self.keep_inside {
                *x = x.max(0.0).min(field[index % 2]);
            }
        }
    }

    fn check(&self) -> Result<(), InvalidInput> {
        for (name, value) in [("scale", self.scale), ("limit", self.limit)] {
            if !(value > 0.0 && value <= 1e6) {
                let field = format!("policy.action.{name}");
                return Err(InvalidInput::new(field, value, "a number above 0 and up to 1e6"));
            }
        }
        Ok(())
    }
}

/// What a policy is: everything but its numbers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PolicyCard {
    /// [`FORMAT`].
    pub format: String,
    /// `mlp`: dense layers, tanh between them.
    pub architecture: String,
    /// Layer sizes `[observation, hidden.., 2 x waypoints]`.
    pub sizes: Vec<usize>,
    /// Waypoints N of the trajectories that it updates.
    pub waypoints: usize,
    /// Names of the observation's parts, in order; see [`ObservationPart::named`].
    pub observation: Vec<String>,
    /// Name of the profile whose objective it was trained on.
    pub profile: String,
    /// What its output means.
    pub action: ActionRule,
    /// Where it comes from: configuration, seeds, curve; free-form.
    pub training: serde_json::Value,
    /// Licence of the weights, as an SPDX expression.
    pub licence: String,
}

/// A network that updates trajectories, with its card.
#[derive(Debug, Clone, PartialEq)]
pub struct Policy {
    card: PolicyCard,
    parts: Vec<ObservationPart>,
    network: Mlp,
}

impl Policy {
    /// A policy from its parts; the card's format, architecture and sizes are filled in from the network.
    ///
    /// # Errors
    /// If the observation, the network and the number of waypoints do not fit each other, or a number of the card is not allowed.
    pub fn new(mut card: PolicyCard, network: Mlp) -> Result<Self, InvalidInput> {
        card.format = FORMAT.into();
        card.architecture = ARCHITECTURE.into();
        card.sizes = network.sizes().to_vec();
        let parts = check_card(&card)?;
        Ok(Self { card, parts, network })
    }

    /// The card.
    pub fn card(&self) -> &PolicyCard {
        &self.card
    }

    /// The observation's parts, in order.
    pub fn observation(&self) -> &[ObservationPart] {
        &self.parts
    }

    /// The network.
    pub fn network(&self) -> &Mlp {
        &self.network
    }

    /// Checks that the policy can update trajectories of so many waypoints.
    ///
    /// # Errors
    /// If it was trained for another number; the message names both.
    pub fn check_waypoints(&self, waypoints: usize) -> Result<(), InvalidInput> {
        if waypoints == self.card.waypoints {
            return Ok(());
        }
        let allowed = format!("{}, which the policy was trained for", self.card.waypoints);
        Err(InvalidInput::new("waypoints", waypoints, allowed))
    }

    /// One iteration: moves the waypoints `x [N x 2]` as the network says at `observation`. `field` is the extent of the
    /// bounds in normalised units; `action [N x 2]` receives the network's output.
    pub fn step(
        &self,
        observation: &[f32],
        scratch: &mut Scratch,
        field: [f32; 2],
        action: &mut [f32],
        x: &mut [f32],
    ) {
        self.network.forward(observation, scratch, action);
        self.card.action.apply(action, field, x);
    }

    /// The policy file.
    ///
    /// # Errors
    /// Never for a policy made by this module; kept for the writer's sake.
    pub fn to_safetensors(&self) -> Result<Vec<u8>, InvalidInput> {
        tensors::write(&self.card, &network_tensors(&self.network, ""))
    }

    /// Reads a policy file.
    ///
    /// # Errors
    /// If the file is truncated, oversized, of another version, contradicts itself, lacks a tensor or holds one of
    /// another shape, one that is not finite, or one too many. The message names what was found and expected.
    pub fn from_safetensors(bytes: &[u8]) -> Result<Self, InvalidInput> {
        let mut reader = Reader::new(bytes, "policy", FORMAT)?;
        let card: PolicyCard = reader.document()?;
        let parts = check_card(&card)?;
        let network = read_network(&mut reader, &card.sizes, "")?;
        reader.finish()?;
        Ok(Self { card, parts, network })
    }
}

/// The tensors `PREFIXlayers.L.weight` and `PREFIXlayers.L.bias` of a network.
pub fn network_tensors<'a>(network: &'a Mlp, prefix: &str) -> Vec<Tensor<'a>> {
    let parameters = network.parameters();
    let mut tensors = Vec::new();
    for (layer, (weights, biases)) in network.layer_ranges().enumerate() {
        let (inputs, outputs) = (network.sizes()[layer], network.sizes()[layer + 1]);
        let name = format!("{prefix}layers.{layer}");
        tensors.push((format!("{name}.weight"), vec![outputs, inputs], &parameters[weights]));
        tensors.push((format!("{name}.bias"), vec![outputs], &parameters[biases]));
    }
    tensors
}

/// Reads back what [`network_tensors`] wrote.
///
/// # Errors
/// If a tensor is missing or is not finite f32 of the shape that `sizes` asks for.
pub fn read_network(
    reader: &mut Reader,
    sizes: &[usize],
    prefix: &str,
) -> Result<Mlp, InvalidInput> {
    Mlp::parameter_count(sizes)?;
    let mut parameters = Vec::new();
    for (layer, pair) in sizes.windows(2).enumerate() {
        let name = format!("{prefix}layers.{layer}");
        parameters.extend(reader.tensor(&format!("{name}.weight"), &[pair[1], pair[0]])?);
        parameters.extend(reader.tensor(&format!("{name}.bias"), &[pair[1]])?);
    }
    Mlp::new(sizes, parameters)
}

fn check_card(card: &PolicyCard) -> Result<Vec<ObservationPart>, InvalidInput> {
    if card.architecture != ARCHITECTURE {
        return Err(InvalidInput::new("policy.architecture", &card.architecture, ARCHITECTURE));
    }
    Profile::named(&card.profile).map_err(|error| error.inside("policy"))?;
    if !(1..=MAX_WAYPOINTS).contains(&card.waypoints) {
        let allowed = format!("a number from 1 to {MAX_WAYPOINTS}");
        return Err(InvalidInput::new("policy.waypoints", card.waypoints, allowed));
    }
    card.action.check()?;
    let named: Result<Vec<_>, _> =
        card.observation.iter().map(|name| ObservationPart::named(name)).collect();
    let parts = named.map_err(|error| error.inside("policy"))?;
    let length = observation_len(&parts, card.waypoints).map_err(|error| error.inside("policy"))?;
    let (first, last) = (card.sizes.first().copied(), card.sizes.last().copied());
    if card.sizes.len() < 2 || first != Some(length) || last != Some(2 * card.waypoints) {
        return Err(InvalidInput::new(
            "policy.sizes",
            format!("{:?}", card.sizes),
            format!(
                "[{length}, .., {}] for the observation {} of {} waypoints",
                2 * card.waypoints,
                card.observation.join(" + "),
                card.waypoints
            ),
        ));
    }
    Ok(parts)
}

#[cfg(test)]
mod tests;
