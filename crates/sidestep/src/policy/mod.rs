//! A policy: a network with the card that says what it sees, what its output means and where it comes from.
//!
//! There are two architectures: `mlp`, the paper's, sees a trajectory of a certain number of waypoints as a whole; `waypoint`
//! has one network for each waypoint ([`WaypointNet`]), and serves any number of them and either profile.
//!
//! On file it is a safetensors file ([`crate::policy::tensors`]) with tensors `layers.L.weight [outputs x inputs]` and
//! `layers.L.bias [outputs]`, and the card as its document. A file is checked as a whole before it is used:
//! version, observation, sizes, every tensor's shape, every number finite.

mod check;
pub mod observation;
mod seen;
pub mod shipped;
pub mod tensors;

use std::ops::Range;

use serde::{Deserialize, Serialize};

use crate::arm::view::ArmViewShape;
use crate::error::InvalidInput;
use crate::network::{Cnn, Mlp, Network, Part, WaypointNet};
use crate::plane::view::ViewParts;
use crate::policy::observation::{ObservationPart, OwnPart, image_place};
use crate::policy::tensors::{Reader, Tensor};

pub use crate::network::MAP_INPUTS;
pub use crate::trajectory::ActionRule;
use check::{check_card, check_waypoint, check_whole};
pub use seen::{Seen, SeenMap};

/// The version of the policy file that this program writes and reads.
pub const FORMAT: &str = "sidestep.policy/1";

/// Dense layers over a whole trajectory: tanh, tanh, .., linear.
const MLP: &str = "mlp";
/// Convolutions over an image before them.
const CNN: &str = "cnn";
/// One network for every waypoint.
const WAYPOINT: &str = "waypoint";

/// What a policy is: everything but its numbers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PolicyCard {
    /// [`FORMAT`].
    pub format: String,
    /// `mlp`; `cnn` where the observation has an image; or `waypoint`.
    pub architecture: String,
    /// Of an `mlp`, the layers' sizes `[observation, hidden.., waypoints x dof]`; of a `cnn` the same, with
    /// the features of the image second; of a `waypoint` network
    /// `[row, width, dilation..]`.
    pub sizes: Vec<usize>,
    /// Waypoints N of the trajectories that it updates; a `waypoint` network was trained mostly for so many.
    pub waypoints: usize,
    /// Coordinates of the robot's configurations; 2, the plane, where a file does not say.
    #[serde(default = "plane", skip_serializing_if = "is_plane")]
    pub dof: usize,
    /// Names of the observation's parts, in order; see [`ObservationPart`] and [`ViewParts::from_names`].
    pub observation: Vec<String>,
    /// Name of the profile that it was trained in; an `mlp` serves no other.
    pub profile: String,
    /// What its output means.
    pub action: ActionRule,
    /// Where it comes from: configuration, seeds, curve; free-form.
    pub training: serde_json::Value,
    /// Licence of the weights, as an SPDX expression.
    pub licence: String,
}

fn plane() -> usize {
    2
}

fn is_plane(dof: &usize) -> bool {
    *dof == plane()
}

/// Most coordinates of a configuration.
const MAX_DOF: usize = 64;

/// What a policy sees and thinks with.
#[derive(Debug, Clone, PartialEq)]
pub enum PolicyNetwork {
    /// Sees the trajectory as a whole.
    Whole {
        /// The observation's parts, in order.
        parts: Vec<ObservationPart>,
        /// From observation to update.
        network: Network,
    },
    /// Sees each waypoint of a robot with joints.
    Joints {
        /// What the view is made of.
        view: ArmViewShape,
        /// From the view's rows to updates.
        network: WaypointNet,
    },
    /// Sees each waypoint of a robot in the plane with its surroundings.
    Waypoint {
        /// What the view is made of.
        view: ViewParts,
        /// From the view's rows to updates.
        network: WaypointNet,
    },
}

/// A network that updates trajectories, with its card.
#[derive(Debug, Clone, PartialEq)]
pub struct Policy {
    card: PolicyCard,
    network: PolicyNetwork,
}

impl Policy {
    /// A policy of a whole trajectory; the card's format, architecture and sizes are filled in from the network.
    ///
    /// # Errors
    /// If the observation, the network and the number of waypoints do not fit each other, or a number of the card is not allowed.
    pub fn new(card: PolicyCard, network: impl Into<Network>) -> Result<Self, InvalidInput> {
        Self::seeing(&[], card, network)
    }

    /// The same, where parts of the observation are one's `own`.
    ///
    /// # Errors
    /// As [`Policy::new`].
    pub fn seeing(
        own: &[OwnPart],
        mut card: PolicyCard,
        network: impl Into<Network>,
    ) -> Result<Self, InvalidInput> {
        let network = network.into();
        card.format = FORMAT.into();
        card.architecture = network.architecture().into();
        card.sizes = network.sizes().to_vec();
        check_card(&card)?;
        let parts = check_whole(&card, own)?;
        Ok(Self { card, network: PolicyNetwork::Whole { parts, network } })
    }

    /// A policy with weights shared over waypoints; the card's format, architecture and sizes are filled in from the network.
    ///
    /// # Errors
    /// If the observation and the network do not fit each other, or a number of the card is not allowed.
    pub fn of_waypoints(mut card: PolicyCard, network: WaypointNet) -> Result<Self, InvalidInput> {
        card.format = FORMAT.into();
        card.architecture = WAYPOINT.into();
        let shape = network.shape();
        card.sizes = vec![shape.inputs, shape.width];
        card.sizes.extend_from_slice(&shape.dilations);
        check_card(&card)?;
        let (sight, shape) = check_waypoint(&card)?;
        if shape != *network.shape() {
            let found = format!("{:?}", network.shape());
            return Err(InvalidInput::new("policy.sizes", found, format!("{shape:?}")));
        }
        Ok(Self { card, network: sight.with(network) })
    }

    /// The card.
    pub fn card(&self) -> &PolicyCard {
        &self.card
    }

    /// The network with what it sees.
    pub fn network(&self) -> &PolicyNetwork {
        &self.network
    }

    /// The number of waypoints that the policy is bound to, if it is.
    pub fn fixed_waypoints(&self) -> Option<usize> {
        match self.network {
            PolicyNetwork::Whole { .. } => Some(self.card.waypoints),
            PolicyNetwork::Waypoint { .. } | PolicyNetwork::Joints { .. } => None,
        }
    }

    /// The profile that the policy is bound to, if it is.
    pub fn fixed_profile(&self) -> Option<&str> {
        match self.network {
            PolicyNetwork::Whole { .. } => Some(&self.card.profile),
            PolicyNetwork::Waypoint { .. } | PolicyNetwork::Joints { .. } => None,
        }
    }

    /// Checks that the policy can update trajectories of so many waypoints in the profile of that name.
    ///
    /// # Errors
    /// If it was trained for another number or profile and is bound to it; the message names both.
    pub fn check_use(&self, waypoints: usize, profile: &str) -> Result<(), InvalidInput> {
        if let Some(fixed) = self.fixed_waypoints().filter(|fixed| *fixed != waypoints) {
            let allowed = format!("{fixed}, which the policy was trained for");
            return Err(InvalidInput::new("waypoints", waypoints, allowed));
        }
        if let Some(fixed) = self.fixed_profile().filter(|fixed| *fixed != profile) {
            let allowed = format!("{fixed}, which the policy was trained in");
            return Err(InvalidInput::new("profile", profile, allowed));
        }
        Ok(())
    }

    /// The policy file.
    ///
    /// # Errors
    /// Never for a policy made by this module; kept for the writer's sake.
    pub fn to_safetensors(&self) -> Result<Vec<u8>, InvalidInput> {
        tensors::write(&self.card, &self.tensors())
    }

    /// The numbers by name, as in the file.
    pub fn tensors(&self) -> Vec<Tensor<'_>> {
        match &self.network {
            PolicyNetwork::Whole { network, .. } => parameter_tensors(network, ""),
            PolicyNetwork::Waypoint { network, .. } | PolicyNetwork::Joints { network, .. } => {
                let sizes = network.shape().layer_sizes();
                layer_tensors(&sizes, network.layer_ranges(), network.parameters(), "")
            }
        }
    }

    /// A policy of a card and numbers by name, checked as its file would be; the card as JSON.
    ///
    /// # Errors
    /// As [`Policy::from_safetensors`].
    pub fn from_tensors(
        card: &serde_json::Value,
        tensors: &[Tensor<'_>],
    ) -> Result<Self, InvalidInput> {
        Self::from_safetensors(&tensors::write(card, tensors)?)
    }

    /// Reads a policy file.
    ///
    /// # Errors
    /// If the file is truncated, oversized, of another version, contradicts itself, lacks a tensor or holds one of
    /// another shape, one that is not finite, or one too many. The message names what was found and expected.
    pub fn from_safetensors(bytes: &[u8]) -> Result<Self, InvalidInput> {
        Self::read_seeing(&[], bytes)
    }

    /// Reads the file of a policy some of whose parts of the observation are one's `own`.
    ///
    /// # Errors
    /// As [`Policy::from_safetensors`], and if a part is not among them.
    pub fn read_seeing(own: &[OwnPart], bytes: &[u8]) -> Result<Self, InvalidInput> {
        let mut reader = Reader::new(bytes, "policy", FORMAT)?;
        let card: PolicyCard = reader.document()?;
        check_card(&card)?;
        let network = match card.architecture.as_str() {
            WAYPOINT => {
                let (sight, shape) = check_waypoint(&card)?;
                let parameters = read_layers(&mut reader, &shape.layer_sizes(), "")?;
                sight.with(WaypointNet::new(&shape, parameters)?)
            }
            _ => {
                let parts = check_whole(&card, own)?;
                let shape = (card.waypoints, card.dof);
                let network = read_parameters(&mut reader, &parts, shape, &card.sizes, "")?;
                PolicyNetwork::Whole { parts, network }
            }
        };
        reader.finish()?;
        Ok(Self { card, network })
    }
}

/// The tensors of the network of a whole trajectory, each name with the prefix.
pub fn parameter_tensors<'a>(network: &'a Network, prefix: &str) -> Vec<Tensor<'a>> {
    let parameters = network.parameters();
    let tensor =
        |(name, shape, range): Part| (format!("{prefix}{name}"), shape, &parameters[range]);
    network.parts().into_iter().map(tensor).collect()
}

/// Reads back what [`parameter_tensors`] wrote, for a network over `parts` of so many waypoints of `dof` coordinates.
///
/// # Errors
/// If a tensor is missing or is not finite f32 of the shape that `sizes` asks for.
pub fn read_parameters(
    reader: &mut Reader,
    parts: &[ObservationPart],
    (waypoints, dof): (usize, usize),
    sizes: &[usize],
    prefix: &str,
) -> Result<Network, InvalidInput> {
    let Some(image_at) = image_place(parts, waypoints, dof) else {
        return Ok(read_network(reader, sizes, prefix)?.into());
    };
    // Of zeros, for the names and shapes; a file that holds far less is refused before they are made, and
    // a tensor of another shape is named below.
    let count = Cnn::parameter_count(sizes, image_at)?;
    reader.check_holds(count / 4)?;
    let mut network = Network::from(Cnn::new(sizes, image_at, vec![0.0; count])?);
    let mut parameters = Vec::with_capacity(count);
    for (name, shape, _) in network.parts() {
        parameters.extend(reader.tensor(&format!("{prefix}{name}"), &shape)?);
    }
    network.update(|own| own.copy_from_slice(&parameters));
    Ok(network)
}

/// The tensors `PREFIXlayers.L.weight` and `PREFIXlayers.L.bias` of a network.
pub fn network_tensors<'a>(network: &'a Mlp, prefix: &str) -> Vec<Tensor<'a>> {
    let sizes: Vec<_> = network.sizes().windows(2).map(|pair| (pair[0], pair[1])).collect();
    layer_tensors(&sizes, network.layer_ranges(), network.parameters(), prefix)
}

fn layer_tensors<'a>(
    sizes: &[(usize, usize)],
    ranges: impl Iterator<Item = (Range<usize>, Range<usize>)>,
    parameters: &'a [f32],
    prefix: &str,
) -> Vec<Tensor<'a>> {
    let mut tensors = Vec::new();
    for (layer, (&(inputs, outputs), (weights, biases))) in sizes.iter().zip(ranges).enumerate() {
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
    let layers: Vec<_> = sizes.windows(2).map(|pair| (pair[0], pair[1])).collect();
    Mlp::new(sizes, read_layers(reader, &layers, prefix)?)
}

fn read_layers(
    reader: &mut Reader,
    sizes: &[(usize, usize)],
    prefix: &str,
) -> Result<Vec<f32>, InvalidInput> {
    let mut parameters = Vec::new();
    for (layer, &(inputs, outputs)) in sizes.iter().enumerate() {
        let name = format!("{prefix}layers.{layer}");
        parameters.extend(reader.tensor(&format!("{name}.weight"), &[outputs, inputs])?);
        parameters.extend(reader.tensor(&format!("{name}.bias"), &[outputs])?);
    }
    Ok(parameters)
}

#[cfg(test)]
mod tests;
