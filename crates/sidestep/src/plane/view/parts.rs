//! The parts of a waypoint view by name: `waypoints`, `probes:..` and, if wanted, `map:..`.

use super::OWN;
use super::map::read_len;
use crate::error::InvalidInput;
use crate::network::MapShape;

/// Most probes of a waypoint.
const MAX_PROBES: usize = 1024;

/// Name of the part of the observation that every view has.
pub const PART: &str = "waypoints";

/// What a view is made of.
#[derive(Debug, Clone, PartialEq)]
pub struct ViewParts {
    /// Distances around each waypoint.
    pub probes: Probes,
    /// The map of the task, where the view has one.
    pub map: Option<MapShape>,
}

/// The probes of a view, as in `probes:12x0.25,0.6,1.1`: so many directions on circles of these radii.
#[derive(Debug, Clone, PartialEq)]
pub struct Probes {
    /// Directions per circle.
    pub directions: usize,
    /// Radii, in normalised units.
    pub radii: Vec<f32>,
}

impl ViewParts {
    /// The view of an observation: the parts [`PART`], `probes:..` and perhaps `map:..`, in that order.
    ///
    /// # Errors
    /// If the parts are others, or one is out of range.
    pub fn from_names(parts: &[String]) -> Result<Self, InvalidInput> {
        match parts {
            [first, probes] if first == PART => {
                Ok(Self { probes: Probes::named(probes)?, map: None })
            }
            [first, probes, map] if first == PART => {
                Ok(Self { probes: Probes::named(probes)?, map: Some(map_named(map)?) })
            }
            _ => {
                let allowed =
                    format!("{PART}, then probes:KxR1,R2,.. and perhaps map:GxCxD1,D2,..");
                Err(InvalidInput::new("observation", parts.join(", "), allowed))
            }
        }
    }

    /// Numbers of a view's row.
    pub fn row_len(&self) -> usize {
        OWN + self.probes.count() + self.map.as_ref().map_or(0, |map| read_len(map.channels))
    }
}

impl Probes {
    /// The probes of that name.
    ///
    /// # Errors
    /// If the text is not `probes:KxR1,R2,..` with K and the radii in range.
    pub fn named(name: &str) -> Result<Self, InvalidInput> {
        let parsed = name.strip_prefix("probes:").and_then(|rest| {
            let (directions, radii) = rest.split_once('x')?;
            Some(Self { directions: directions.parse().ok()?, radii: list(radii)? })
        });
        parsed
            .filter(|probes| {
                let radii = probes.radii.iter().all(|r| *r > 0.0 && *r <= 100.0);
                radii
                    && (1..=MAX_PROBES).contains(&probes.directions)
                    && probes.radii.len() <= MAX_PROBES / probes.directions
            })
            .ok_or_else(|| {
                InvalidInput::new(
                    "observation",
                    name,
                    format!("probes:KxR1,R2,.. with radii above 0 and up to {MAX_PROBES} probes"),
                )
            })
    }

    /// The name of these probes.
    pub fn name(&self) -> String {
        let radii: Vec<String> = self.radii.iter().map(f32::to_string).collect();
        format!("probes:{}x{}", self.directions, radii.join(","))
    }

    /// Probes of a waypoint.
    pub fn count(&self) -> usize {
        self.directions * self.radii.len()
    }

    /// Offsets in frame axes, circle by circle.
    pub(super) fn offsets(&self) -> impl Iterator<Item = [f32; 2]> + '_ {
        self.radii.iter().flat_map(move |&radius| {
            (0..self.directions).map(move |k| {
                let angle = k as f64 / self.directions as f64 * std::f64::consts::TAU;
                [radius * angle.cos() as f32, radius * angle.sin() as f32]
            })
        })
    }
}

/// The map of that name, as in `map:12x16x1,2,4`: cells per side, channels, dilations of its convolutions.
fn map_named(name: &str) -> Result<MapShape, InvalidInput> {
    let parsed = name.strip_prefix("map:").and_then(|rest| {
        let (cells, rest) = rest.split_once('x')?;
        let (channels, dilations) = rest.split_once('x')?;
        Some(MapShape {
            cells: cells.parse().ok()?,
            channels: channels.parse().ok()?,
            dilations: list(dilations)?,
        })
    });
    parsed.filter(MapShape::is_allowed).ok_or_else(|| {
        InvalidInput::new(
            "observation",
            name,
            format!("map:GxCxD1,D2,.. with {}", MapShape::ALLOWED),
        )
    })
}

fn list<T: std::str::FromStr>(text: &str) -> Option<Vec<T>> {
    text.split(',').map(|value| value.parse().ok()).collect()
}
