//! The places where a shortest path may turn: the corners of the obstacles grown by the robot.
//!
//! A corner of a shape grown by a disc is an arc of radius R about the shape's corner, and a path
//! that wraps round it is approximated twice, over sub-arcs of at most `step`:
//! - *outside*, by the circumscribed polygon, whose corners lie at `R / cos(step / 2)` and whose
//!   sides touch the arc, so a path along it keeps R from the shape;
//! - *inside*, by the inscribed polygon, whose corners lie on the arc and whose sides come as near
//!   as `R cos(step / 2)`.
//!
//! With R of a rounding's size and one sub-arc, the circumscribed polygon is the mitred corner of a
//! point robot.

use std::f64::consts::{FRAC_PI_2, TAU};

use crate::plane::bit_grid::ones_of;
use crate::plane::certificate::Cells;
use crate::plane::geometry::{Circle, Point, add, cross, dot, norm, scale, sub};
use crate::plane::world::Obstacle;

/// A convex corner of a grown obstacle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Corner {
    /// Where the path turns.
    pub(crate) at: Point,
    /// Unit vector along the obstacle's border, back to the corner before it (counter-clockwise).
    pub(crate) before: Point,
    /// Unit vector along the border, on to the corner after it.
    pub(crate) after: Point,
}

/// How corners are rounded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Rounding {
    /// Radius R of the arc about a corner.
    pub(crate) radius: f64,
    /// Most angle of one sub-arc, at most a right angle; for circles too.
    pub(crate) step: f64,
    /// Whether the polygon is circumscribed (outside) or inscribed (inside).
    pub(crate) outside: bool,
}

impl Rounding {
    /// Calls `push` with every corner of a shape grown by this rounding.
    pub(crate) fn corners_of(&self, obstacle: &Obstacle, mut push: impl FnMut(Corner)) {
        match obstacle {
            Obstacle::Rect(rect) => {
                let normals = [[-1.0, 0.0], [0.0, -1.0], [1.0, 0.0], [0.0, 1.0]];
                for (i, corner) in rect.corners().into_iter().enumerate() {
                    self.arc(corner, normals[i], normals[(i + 1) % 4], &mut push);
                }
            }
            Obstacle::Circle(circle) => self.circle(circle, &mut push),
            Obstacle::Polygon(polygon) => {
                let mut edges = polygon.edges().filter(|(p, q)| p != q).collect::<Vec<_>>();
                edges.rotate_left(1);
                let normal = |(p, q): (Point, Point)| {
                    let edge = sub(q, p);
                    scale([edge[1], -edge[0]], 1.0 / norm(edge))
                };
                for i in 0..edges.len() {
                    let next = edges[(i + 1) % edges.len()];
                    self.arc(next.0, normal(edges[i]), normal(next), &mut push);
                }
            }
        }
    }

    /// Calls `push` with every corner round the occupied cells: about each lattice point that has
    /// exactly one occupied cell among its four.
    pub(crate) fn corners_of_cells(&self, cells: &Cells, mut push: impl FnMut(Corner)) {
        let bits = cells.bits();
        let words = bits.width() / 64 + 1;
        let empty = vec![0; words];
        let row = |row: usize| if row < bits.height() { bits.row(row) } else { &empty };
        let word = |row: &[u64], index: usize| row.get(index).copied().unwrap_or(0);
        // Bit x is the cell to the left of lattice point x.
        let left = |row: &[u64], index: usize| {
            word(row, index) << 1 | if index > 0 { word(row, index - 1) >> 63 } else { 0 }
        };
        for y in 0..=bits.height() {
            let (above, below) = (row(y), row(y.wrapping_sub(1)));
            for index in 0..words {
                let (ne, se) = (word(above, index), word(below, index));
                let (nw, sw) = (left(above, index), left(below, index));
                let two = (ne & se) | (nw & sw) | ((ne | se) & (nw | sw));
                for (occupied, normals) in [
                    (ne, [[-1.0, 0.0], [0.0, -1.0]]),
                    (nw, [[0.0, -1.0], [1.0, 0.0]]),
                    (sw, [[1.0, 0.0], [0.0, 1.0]]),
                    (se, [[0.0, 1.0], [-1.0, 0.0]]),
                ] {
                    for x in ones_of(occupied & !two, 64 * index) {
                        self.arc(cells.lattice_point(x, y), normals[0], normals[1], &mut push);
                    }
                }
            }
        }
    }

    /// The corners round one corner `center` of a shape, between the outward unit normals of the
    /// edges before and after it.
    fn arc(&self, center: Point, from: Point, to: Point, push: &mut impl FnMut(Corner)) {
        if self.outside && self.step >= FRAC_PI_2 && dot(from, to) >= 0.0 {
            // One mitred corner: at R (n + m) / (1 + n . m).
            let at = add(center, scale(add(from, to), self.radius / (1.0 + dot(from, to))));
            push(Corner { at, before: scale(along(from), -1.0), after: along(to) });
            return;
        }
        let sweep = cross(from, to).atan2(dot(from, to)).max(0.0);
        let steps = (sweep / self.step - 1e-9).ceil().max(1.0);
        let angle = sweep / steps;
        if self.outside {
            let reach = self.radius / (0.5 * angle).cos();
            for i in 0..steps as usize {
                let turn = |by: f64| rotate(from, (i as f64 + by) * angle);
                push(Corner {
                    at: add(center, scale(turn(0.5), reach)),
                    before: scale(along(turn(0.0)), -1.0),
                    after: along(turn(1.0)),
                });
            }
        } else {
            for i in 0..=steps as usize {
                // The chords' normals lie half way between the corners'; the flats' are the ends.
                let turn = |by: f64| rotate(from, ((i as f64 + by) * angle).clamp(0.0, sweep));
                push(Corner {
                    at: add(center, scale(turn(0.0), self.radius)),
                    before: scale(along(turn(-0.5)), -1.0),
                    after: along(turn(0.5)),
                });
            }
        }
    }

    /// The corners round a whole circle.
    fn circle(&self, circle: &Circle, push: &mut impl FnMut(Corner)) {
        let steps = (TAU / self.step - 1e-9).ceil().max(3.0);
        let angle = TAU / steps;
        let radius = circle.radius + self.radius;
        let reach = if self.outside { radius / (0.5 * angle).cos() } else { radius };
        for i in 0..steps as usize {
            let turn = |by: f64| rotate([1.0, 0.0], (i as f64 + by) * angle);
            push(Corner {
                at: add(circle.center, scale(turn(0.0), reach)),
                before: scale(along(turn(-0.5)), -1.0),
                after: along(turn(0.5)),
            });
        }
    }
}

/// The direction of a counter-clockwise border with this outward normal.
fn along(normal: Point) -> Point {
    [-normal[1], normal[0]]
}

/// `v` turned counter-clockwise.
fn rotate(v: Point, angle: f64) -> Point {
    let (sin, cos) = angle.sin_cos();
    [cos * v[0] - sin * v[1], sin * v[0] + cos * v[1]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::certificate::Growth;
    use crate::plane::geometry::{ConvexPolygon, Rect, distance};
    use crate::plane::world::Grid;

    fn corners(rounding: Rounding, obstacle: &Obstacle) -> Vec<Corner> {
        let mut corners = Vec::new();
        rounding.corners_of(obstacle, |corner| corners.push(corner));
        corners
    }

    #[test]
    fn borders_are_closed_and_at_the_right_distance() {
        let shapes = [
            Obstacle::Rect(Rect::new([1.0, 2.0], [4.0, 3.0]).unwrap()),
            Obstacle::Circle(Circle::new([1.0, 2.0], 3.0).unwrap()),
            Obstacle::Polygon(
                ConvexPolygon::new(vec![[0.0, 0.0], [9.0, 0.0], [9.0, 1.0], [8.0, 1.2]]).unwrap(),
            ),
        ];
        for shape in &shapes {
            for step in [FRAC_PI_2, FRAC_PI_2 / 3.0, 0.1] {
                for outside in [true, false] {
                    let rounding = Rounding { radius: 0.5, step, outside };
                    let corners = corners(rounding, shape);
                    for (i, corner) in corners.iter().enumerate() {
                        let next = corners[(i + 1) % corners.len()];
                        let edge = sub(next.at, corner.at);
                        let unit = scale(edge, 1.0 / norm(edge));
                        assert!(distance(unit, corner.after) < 1e-9, "{rounding:?} {shape:?}");
                        assert!(distance(unit, scale(next.before, -1.0)) < 1e-9, "{rounding:?}");
                        assert!(cross(corner.before, corner.after) < 0.0, "convex");
                        let gap = crate::plane::certificate::segment_obstacle_distance(
                            corner.at, next.at, shape,
                        );
                        let grown = if let Obstacle::Circle(c) = shape { c.radius } else { 0.0 };
                        let (low, high) = if outside {
                            (0.5, 0.5)
                        } else {
                            ((grown + 0.5) * (0.5 * step).cos() - grown, 0.5)
                        };
                        let within = low - 1e-9 <= gap && gap <= high + 1e-9;
                        assert!(within || gap == 0.0 && low < 0.0, "{rounding:?} {shape:?} {gap}");
                    }
                }
            }
        }
    }

    #[test]
    fn cells_have_corners_where_one_of_four_is_occupied() {
        // Two cells that touch in a corner: six convex corners, none at the pinch.
        let mut occupied = vec![false; 70 * 3];
        occupied[63] = true;
        occupied[70 + 64] = true;
        let grid = Grid::new(70, 3, 1.0, [0.0, 0.0], occupied).unwrap();
        let rounding = Rounding { radius: 0.25, step: FRAC_PI_2, outside: true };
        let mut found = Vec::new();
        rounding.corners_of_cells(&Cells::new(&grid, Growth::Square(0.0)), |corner| {
            found.push(corner.at)
        });
        let mut expected = [
            [62.75, -0.25],
            [64.25, -0.25],
            [62.75, 1.25],
            [65.25, 0.75],
            [63.75, 2.25],
            [65.25, 2.25],
        ];
        found.sort_by(|a, b| a.partial_cmp(b).unwrap());
        expected.sort_by(|a, b| a.partial_cmp(b).unwrap());
        assert_eq!(found, expected);
    }
}
