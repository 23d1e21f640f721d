//! One approximation of the free space: a certifier, the corners of the grown obstacles, and, where
//! there are many corners, what sees which.

use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

use super::corners::{Corner, Rounding};
use super::search::CHECKS_A_QUESTION;
use super::sight::{MoreCorners, Sight};
use crate::plane::certificate::{Certifier, Growth};
use crate::plane::geometry::{ConvexPolygon, Rect};
use crate::plane::world::Obstacle;

/// Corners keep this many tolerances from their obstacle; one is the certificate's.
const CORNER_TOLERANCES: f64 = 2.0;
/// Slack of the rules about turning, in tolerances.
const SLACK_TOLERANCES: f64 = 100.0;
/// Above this many corners, candidates come from a walk over what can be seen.
const MOST_WITHOUT_SIGHT: usize = 192;
/// The same where shapes are added to a map that has no such walk: preparing one costs what the map costs.
const MOST_ADDED_WITHOUT_SIGHT: usize = 768;

/// A free space that holds all paths of the real one, or only such. What was prepared of a map is shared with the layers of the
/// same map with more shapes on it: some of its corners are not free there, and some can be seen only through these shapes,
/// which the certificate finds out.
#[derive(Debug, Clone)]
pub(crate) struct Layer {
    pub(crate) certifier: Certifier,
    /// The map's.
    pub(crate) corners: Arc<Vec<Corner>>,
    /// Those of the shapes on it, in the order of `more_rows`.
    pub(crate) more: Vec<Corner>,
    /// Distances below this do not count when turns are judged.
    pub(crate) slack: f64,
    pub(crate) sight: Option<Arc<Sight>>,
    /// Where the walk meets the corners of `more`.
    pub(crate) more_rows: MoreCorners,
    /// How far the polygons round arcs reach beyond them, at most. A free point with less clearance
    /// may lie in such a band, inside a grown obstacle.
    pub(crate) band: f64,
}

impl Layer {
    /// Every path over these corners that the certifier allows is a path of the robot. With the layer of a `map` whose
    /// obstacles are the certifier's first ones, only what is added costs. None once `go_on` is false.
    pub(crate) fn outside(
        certifier: Certifier,
        arcs_per_right_angle: u32,
        map: Option<&Self>,
        go_on: &dyn Fn() -> bool,
    ) -> Option<Self> {
        let known = map.map_or(0, |map| map.certifier.obstacles().len());
        let slack = SLACK_TOLERANCES * certifier.tolerance();
        let radius = certifier.radius() + CORNER_TOLERANCES * certifier.tolerance();
        let step = FRAC_PI_2 / f64::from(arcs_per_right_angle);
        let arcs = Rounding { radius, step, outside: true };
        let mitred = Rounding { radius, step: FRAC_PI_2, outside: true };
        let rounding = if certifier.radius() > 0.0 { arcs } else { mitred };
        let mut corners = Vec::with_capacity(4 * (certifier.obstacles().len() - known));
        for shape in &certifier.obstacles()[known..] {
            let is_circle = matches!(shape, Obstacle::Circle(_));
            (if is_circle { arcs } else { rounding }).corners_of(shape, |c| corners.push(c));
        }
        if let Some(cells) = certifier.cells().filter(|_| map.is_none()) {
            rounding.corners_of_cells(cells, |corner| corners.push(corner));
        }
        let widest = certifier.obstacles().iter().map(|shape| match shape {
            Obstacle::Circle(circle) => radius + circle.radius,
            _ => radius,
        });
        let reach = 1.0 / (0.5 * step).cos() - 1.0;
        let band = widest.fold(radius, f64::max) * reach + certifier.tolerance();
        let band = if Self::is_exact(&certifier) { 0.0 } else { band };
        Some(Self { band, ..Self::of(certifier, corners, slack, map, go_on)? })
    }

    /// No path of the robot is shorter than the shortest over these corners.
    ///
    /// A certified path keeps more than `reach = r + tolerance` from every shape, so it avoids the shape
    /// grown by the polygon that is inscribed in a disc of that radius. The corners are that polygon's;
    /// the checks grow the shape by a polygon one or a few quarter tolerances smaller, so that sides
    /// and corners stay allowed. Flat sides are therefore exact: a gap just as wide as the robot is
    /// closed. With the inside layer of a `map` as in [`Layer::outside`]. None once `go_on` is false.
    pub(crate) fn inside(
        outside: &Certifier,
        arcs_per_right_angle: u32,
        map: Option<&Self>,
        go_on: &dyn Fn() -> bool,
    ) -> Option<Self> {
        let known = map.map_or(0, |map| map.certifier.obstacles().len());
        let tolerance = outside.tolerance();
        let slack = SLACK_TOLERANCES * tolerance;
        let reach = outside.margin();
        let step = FRAC_PI_2 / f64::from(arcs_per_right_angle);
        let inscribed = |radius: f64| Rounding { radius, step, outside: false };
        // Of a robot that is hardly more than a point, corners are mitred, within the reach.
        let is_thin = outside.radius() < slack;
        let corner_arcs = if is_thin {
            Rounding { radius: 0.7 * reach, step: FRAC_PI_2, outside: true }
        } else {
            inscribed(reach)
        };
        let (grown, margin) = if is_thin {
            (0.0, 0.25 * reach)
        } else {
            (reach - 0.75 * tolerance, 0.25 * tolerance)
        };
        let (mut corners, mut shapes) = (Vec::new(), Vec::new());
        let polygon = |rounding: Rounding, shape: &Obstacle| {
            let mut vertices = Vec::new();
            rounding.corners_of(shape, |corner| vertices.push(corner.at));
            ConvexPolygon::from_convex(vertices)
        };
        for shape in &outside.obstacles()[known..] {
            let is_circle = matches!(shape, Obstacle::Circle(_));
            let arcs = if is_circle { inscribed(reach) } else { corner_arcs };
            arcs.corners_of(shape, |corner| corners.push(corner));
            shapes.push(if is_thin && !is_circle {
                shape.clone()
            } else {
                Obstacle::Polygon(polygon(inscribed(grown), shape))
            });
        }
        if let Some(map) = map {
            return Self::of(map.certifier.with(&shapes), corners, slack, Some(map), go_on);
        }
        let cells = outside.cells().map(|cells| {
            corner_arcs.corners_of_cells(cells, |corner| corners.push(corner));
            let side = cells.resolution();
            let square = Obstacle::Rect(Rect { min: [0.0, 0.0], max: [side, side] });
            cells.grown(if is_thin && outside.radius() == 0.0 {
                Growth::Square(margin)
            } else if is_thin {
                Growth::Round(margin)
            } else {
                Growth::Polygon {
                    polygon: polygon(inscribed(grown), &square),
                    inner: grown * (0.5 * step).cos() - margin,
                    outer: reach,
                }
            })
        });
        let certifier = Certifier::from_parts(outside.bounds(), 0.0, margin, shapes, cells);
        Self::of(certifier, corners, slack, None, go_on)
    }

    /// Keeps the corners that are free; `corners` are those that the map does not have.
    fn of(
        certifier: Certifier,
        mut corners: Vec<Corner>,
        slack: f64,
        map: Option<&Self>,
        go_on: &dyn Fn() -> bool,
    ) -> Option<Self> {
        let (mut checks, mut in_time) = (0_usize, true);
        corners.retain(|corner| {
            checks += 1;
            in_time &= !checks.is_multiple_of(CHECKS_A_QUESTION) || go_on();
            in_time && certifier.point_is_free(corner.at)
        });
        if !in_time {
            return None;
        }
        if let Some(map) = map {
            let count = map.corners.len() + corners.len();
            if map.sight.is_some() || count <= MOST_ADDED_WITHOUT_SIGHT {
                let sight = map.sight.clone();
                let more_rows = sight
                    .as_ref()
                    .map_or_else(MoreCorners::default, |view| view.more(&mut corners));
                let (known, more) = (map.corners.clone(), corners);
                return Some(Self {
                    certifier,
                    corners: known,
                    more,
                    slack,
                    sight,
                    more_rows,
                    band: 0.0,
                });
            }
            corners.extend(map.corners.iter());
        }
        let sight = match corners.len() > MOST_WITHOUT_SIGHT {
            true => Some(Arc::new(Sight::new(&certifier, &mut corners, go_on)?)),
            false => None,
        };
        let (corners, more, more_rows) = (Arc::new(corners), Vec::new(), MoreCorners::default());
        Some(Self { certifier, corners, more, slack, sight, more_rows, band: 0.0 })
    }

    /// How many corners there are.
    pub(crate) fn len(&self) -> usize {
        self.corners.len() + self.more.len()
    }

    /// A corner by its number, the map's first.
    #[inline]
    pub(crate) fn corner(&self, number: usize) -> &Corner {
        self.corners.get(number).unwrap_or_else(|| &self.more[number - self.corners.len()])
    }

    /// Whether the corners are exact but for a few tolerances: nothing is round.
    pub(crate) fn is_exact(certifier: &Certifier) -> bool {
        certifier.radius() == 0.0
            && !certifier.obstacles().iter().any(|shape| matches!(shape, Obstacle::Circle(_)))
    }
}
