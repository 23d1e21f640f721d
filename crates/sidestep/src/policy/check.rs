//! Whether a card allows a policy: each number in its range, and all of them fit each other.

use super::observation::{ObservationPart, OwnPart, architecture_for, observation_len};
use super::{CNN, MAX_DOF, MLP, PolicyCard, PolicyNetwork, WAYPOINT, is_plane};
use crate::arm::view::ArmViewShape;
use crate::error::InvalidInput;
use crate::network::{WaypointNet, WaypointShape};
use crate::plane::view::ViewParts;
use crate::profile::{MAX_WAYPOINTS, Profile};

/// Checks what all architectures have in common.
pub(super) fn check_card(card: &PolicyCard) -> Result<(), InvalidInput> {
    if ![MLP, CNN, WAYPOINT].contains(&card.architecture.as_str()) {
        let allowed = format!("{MLP}, {CNN} or {WAYPOINT}");
        return Err(InvalidInput::new("policy.architecture", &card.architecture, allowed));
    }
    card.profile.parse::<Profile>().map_err(|error| error.inside("policy"))?;
    if !(1..=MAX_WAYPOINTS).contains(&card.waypoints) {
        let allowed = format!("a number from 1 to {MAX_WAYPOINTS}");
        return Err(InvalidInput::new("policy.waypoints", card.waypoints, allowed));
    }
    if !(1..=MAX_DOF).contains(&card.dof) {
        let allowed = format!("a number from 1 to {MAX_DOF}");
        return Err(InvalidInput::new("policy.dof", card.dof, allowed));
    }
    card.action.check()
}

/// What a policy of the architecture [`WAYPOINT`] sees.
pub(super) enum Sight {
    Plane(ViewParts),
    Joints(ArmViewShape),
}

impl Sight {
    /// With the network behind it.
    pub(super) fn with(self, network: WaypointNet) -> PolicyNetwork {
        match self {
            Self::Plane(view) => PolicyNetwork::Waypoint { view, network },
            Self::Joints(view) => PolicyNetwork::Joints { view, network },
        }
    }
}

/// The view and the network's shape of a card of the architecture [`WAYPOINT`].
pub(super) fn check_waypoint(card: &PolicyCard) -> Result<(Sight, WaypointShape), InvalidInput> {
    let inside = |error: InvalidInput| error.inside("policy");
    let (view, row, map) = if ArmViewShape::is_named(&card.observation) {
        let view = ArmViewShape::from_names(&card.observation, card.dof).map_err(inside)?;
        (Sight::Joints(view), view.row_len(), None)
    } else {
        let view = ViewParts::from_names(&card.observation).map_err(inside)?;
        if !is_plane(&card.dof) {
            return Err(InvalidInput::new("policy.dof", card.dof, "2 for this observation"));
        }
        let (row, map) = (view.row_len(), view.map.clone());
        (Sight::Plane(view), row, map)
    };
    match card.sizes[..] {
        [inputs, width, ref dilations @ ..] if inputs == row => {
            let dilations = dilations.to_vec();
            let shape = WaypointShape { inputs, width, dilations, outputs: card.dof, map };
            shape.parameter_count().map_err(inside)?;
            Ok((view, shape))
        }
        _ => Err(InvalidInput::new(
            "policy.sizes",
            format!("{:?}", card.sizes),
            format!("[{row}, width, dilation..] for {}", card.observation.join(" + ")),
        )),
    }
}

/// The parts of the observation of a card of the architectures [`MLP`] and [`CNN`].
pub(super) fn check_whole(
    card: &PolicyCard,
    own: &[OwnPart],
) -> Result<Vec<ObservationPart>, InvalidInput> {
    let named: Result<Vec<_>, _> =
        card.observation.iter().map(|name| ObservationPart::named(name, own)).collect();
    let parts = named.map_err(|error| error.inside("policy"))?;
    let length = observation_len(&parts, card.waypoints, card.dof)
        .map_err(|error| error.inside("policy"))?;
    let expected = architecture_for(&parts);
    if card.architecture != expected {
        let observation = card.observation.join(" + ");
        let allowed = format!("{expected}, which the observation {observation} takes");
        return Err(InvalidInput::new("policy.architecture", &card.architecture, allowed));
    }
    let (first, last) = (card.sizes.first().copied(), card.sizes.last().copied());
    if card.sizes.len() < 2 || first != Some(length) || last != Some(card.dof * card.waypoints) {
        return Err(InvalidInput::new(
            "policy.sizes",
            format!("{:?}", card.sizes),
            format!(
                "[{length}, .., {}] for the observation {} of {} waypoints",
                card.dof * card.waypoints,
                card.observation.join(" + "),
                card.waypoints
            ),
        ));
    }
    Ok(parts)
}
