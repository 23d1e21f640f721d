//! The parts of a waypoint view by name: `waypoints` or `picture:..`, `probes:..` and, if wanted, `map:..` and `gradient`.

use super::OWN;
use super::map::{PLACES, read_len};
use crate::error::InvalidInput;
use crate::network::MapShape;

/// Most probes of a waypoint.
const MAX_PROBES: usize = 1024;

/// Name of the part of the observation that every view of distances has.
pub const PART: &str = "waypoints";
/// What the name of that part begins with where a picture is all that is seen, as in `picture:64`.
const PICTURE: &str = "picture:";
/// Name of the part that adds the gradient of U.
const GRADIENT: &str = "gradient";
/// Least and most pixels along a side of a picture; a multiple of 16.
const PIXELS: std::ops::RangeInclusive<usize> = 32..=256;

/// What a view is made of.
#[derive(Debug, Clone, PartialEq)]
pub struct ViewParts {
    /// Pixels along a side of the picture that is seen in place of distances, if any.
    pub picture: Option<usize>,
    /// Whether the gradient of U is seen.
    pub gradient: bool,
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
    /// The view of an observation: the parts [`PART`] or `picture:..`, `probes:..` and perhaps `map:..` and
    /// `gradient`, in that order.
    ///
    /// # Errors
    /// If the parts are others, or one is out of range.
    pub fn from_names(parts: &[String]) -> Result<Self, InvalidInput> {
        let refuse = || {
            let allowed = format!(
                "{PART} or {PICTURE}P (P pixels, a multiple of 16 from {} to {}), then \
                 probes:KxR1,R2,.. and perhaps map:GxCxD1,D2,.. and {GRADIENT}",
                PIXELS.start(),
                PIXELS.end()
            );
            InvalidInput::new("observation", parts.join(", "), allowed)
        };
        let [first, probes, rest @ ..] = parts else { return Err(refuse()) };
        let picture = match first.strip_prefix(PICTURE) {
            Some(pixels) => {
                let pixels = pixels.parse().ok().filter(|p| PIXELS.contains(p) && p % 16 == 0);
                Some(pixels.ok_or_else(refuse)?)
            }
            None if first == PART => None,
            None => return Err(refuse()),
        };
        let (rest, gradient) = match rest {
            [rest @ .., last] if last == GRADIENT => (rest, true),
            _ => (rest, false),
        };
        let map = match rest {
            [] => None,
            [map] => Some(map_named(map)?),
            _ => return Err(refuse()),
        };
        Ok(Self { picture, gradient, probes: Probes::named(probes)?, map })
    }

    /// Whether the parts are those of a view of waypoints, by their first.
    pub fn are_named(parts: &[String]) -> bool {
        parts.first().is_some_and(|first| first == PART || first.starts_with(PICTURE))
    }

    /// Where the features of the task's map are in a row, where there is a map.
    pub fn features_at(&self) -> Option<std::ops::Range<usize>> {
        let map = self.map.as_ref()?;
        let first = self.row_len() - read_len(map.channels);
        Some(first..first + PLACES * map.channels)
    }

    /// Numbers of a view's row.
    pub fn row_len(&self) -> usize {
        let gradient = if self.gradient { 2 } else { 0 };
        let map = self.map.as_ref().map_or(0, |map| read_len(map.channels));
        OWN + gradient + self.probes.count() + map
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
