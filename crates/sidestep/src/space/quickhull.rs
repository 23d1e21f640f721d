//! The convex hull of points.
//!
//! Quickhull (C. Barber, D. Dobkin, H. Huhdanpaa, "The Quickhull algorithm for convex hulls", ACM
//! TOMS 22(4), 1996): from a tetrahedron on, the point farthest in front of a face replaces all
//! faces that it sees by a cone over their rim. Points less than [`FLAT`] of the extent in front of
//! a face count as on it. What comes out is measured against every point before it is called a
//! hull.

use std::collections::HashMap;

use super::bounds::Bounds;
use super::hull::Hull;
use super::pose::finite_vector;
use super::vector::{Vector, cross, dot, norm, sub, unit};
use crate::error::InvalidInput;

/// Heights below this share of the points' extent are rounding.
const FLAT: f64 = 1e-11;

/// How far a point may stick out of the finished hull, as a share of the extent.
const SLACK: f64 = 1e-9;

impl Hull {
    /// The convex hull of points in metres. Points may lie outside it by 1e-9 of their extent.
    ///
    /// # Errors
    /// If a coordinate is not finite, or all points lie in a plane (to 1e-11 of their extent).
    pub fn around(points: &[Vector]) -> Result<Self, InvalidInput> {
        for (i, &point) in points.iter().enumerate() {
            finite_vector(&format!("points[{i}]"), point)?;
        }
        let refused = |found: &str| {
            let found = format!("{} points {found}", points.len());
            InvalidInput::new("points", found, "points around a volume")
        };
        let bounds = Bounds::around(points.iter().copied());
        let extent = (0..3).map(|k| bounds.max[k] - bounds.min[k]).fold(0.0, f64::max);
        let first = tetrahedron(points, FLAT * extent).ok_or_else(|| refused("in a plane"))?;
        let mut growing = Growing::new(points, FLAT * extent);
        let narrow = || refused("whose hull is too thin to be computed");
        growing.start(first).ok_or_else(narrow)?;
        while let Some(face) = growing.open.pop() {
            growing.grow(face).ok_or_else(narrow)?;
        }
        let hull = growing.finish();
        let farthest = points.iter().map(|&p| hull.distance(p).0).fold(0.0, f64::max);
        if farthest > SLACK * extent { Err(narrow()) } else { Ok(hull) }
    }
}

/// Four points that span a volume: two far apart, the farthest from their line, the farthest from
/// that plane; counter-clockwise seen from the side away from the last.
fn tetrahedron(points: &[Vector], flat: f64) -> Option<[u32; 4]> {
    let farthest = |height: &dyn Fn(Vector) -> f64| {
        let heights = points.iter().map(|&p| height(p)).enumerate();
        heights.filter(|(_, h)| *h > flat).max_by(|a, b| a.1.total_cmp(&b.1)).map(|(i, _)| i)
    };
    let from = *points.first()?;
    let a = farthest(&|p| norm(sub(p, from)))?;
    let b = farthest(&|p| norm(sub(p, points[a])))?;
    let line = unit(sub(points[b], points[a]))?;
    let c = farthest(&|p| norm(cross(line, sub(p, points[a]))))?;
    let normal = unit(cross(sub(points[b], points[a]), sub(points[c], points[a])))?;
    let d = farthest(&|p| dot(normal, sub(p, points[a])).abs())?;
    let front = dot(normal, sub(points[d], points[a])) > 0.0;
    Some(if front { [a, c, b, d] } else { [a, b, c, d] }.map(|i| i as u32))
}

/// A face of a hull that grows.
struct Face {
    corners: [u32; 3],
    normal: Vector,
    /// Points in front of this face that no other face has taken.
    outside: Vec<u32>,
    alive: bool,
}

struct Growing<'a> {
    points: &'a [Vector],
    flat: f64,
    faces: Vec<Face>,
    /// The living face left of a side.
    sides: HashMap<(u32, u32), usize>,
    /// Faces that had points outside when they were made.
    open: Vec<usize>,
}

impl<'a> Growing<'a> {
    fn new(points: &'a [Vector], flat: f64) -> Self {
        Self { points, flat, faces: Vec::new(), sides: HashMap::new(), open: Vec::new() }
    }

    fn point(&self, i: u32) -> Vector {
        self.points[i as usize]
    }

    fn height(&self, face: usize, p: u32) -> f64 {
        let face = &self.faces[face];
        dot(face.normal, sub(self.point(p), self.point(face.corners[0])))
    }

    /// Adds a face; nothing if a side has one already, which only rounding can cause.
    fn add(&mut self, corners: [u32; 3]) -> Option<usize> {
        let [a, b, c] = corners.map(|corner| self.point(corner));
        // A face too thin for a normal sees nothing.
        let normal = unit(cross(sub(b, a), sub(c, a))).unwrap_or([0.0; 3]);
        let at = self.faces.len();
        self.faces.push(Face { corners, normal, outside: Vec::new(), alive: true });
        let doubled = sides(corners).into_iter().any(|side| self.sides.insert(side, at).is_some());
        (!doubled).then_some(at)
    }

    /// Gives each point to the face that it is farthest in front of.
    fn hand_out(&mut self, points: impl Iterator<Item = u32>, faces: std::ops::Range<usize>) {
        for p in points {
            let heights = faces.clone().map(|face| (face, self.height(face, p)));
            let farthest = heights.max_by(|a, b| a.1.total_cmp(&b.1));
            if let Some((face, _)) = farthest.filter(|(_, height)| *height > self.flat) {
                self.faces[face].outside.push(p);
            }
        }
        self.open.extend(faces.filter(|&face| !self.faces[face].outside.is_empty()));
    }

    fn start(&mut self, [a, b, c, d]: [u32; 4]) -> Option<()> {
        for corners in [[a, b, c], [b, a, d], [c, b, d], [a, c, d]] {
            self.add(corners)?;
        }
        self.hand_out(0..self.points.len() as u32, 0..4);
        Some(())
    }

    /// Replaces what the farthest point outside of `face` sees.
    fn grow(&mut self, face: usize) -> Option<()> {
        if !self.faces[face].alive {
            return Some(());
        }
        let height = |&p: &u32| self.height(face, p);
        let outside = self.faces[face].outside.iter().copied();
        let apex = outside.max_by(|a, b| height(a).total_cmp(&height(b)))?;
        let mut seen = vec![face];
        let mut rim = Vec::new();
        self.faces[face].alive = false;
        let mut next = 0;
        while next < seen.len() {
            for (from, to) in sides(self.faces[seen[next]].corners) {
                let across = *self.sides.get(&(to, from))?;
                if !self.faces[across].alive {
                    continue;
                }
                if self.height(across, apex) > self.flat {
                    self.faces[across].alive = false;
                    seen.push(across);
                } else {
                    rim.push((from, to));
                }
            }
            next += 1;
        }
        let mut orphans = Vec::new();
        for &face in &seen {
            for side in sides(self.faces[face].corners) {
                self.sides.remove(&side);
            }
            orphans.append(&mut self.faces[face].outside);
        }
        let first = self.faces.len();
        for (from, to) in rim {
            self.add([from, to, apex])?;
        }
        self.hand_out(orphans.into_iter().filter(|&p| p != apex), first..self.faces.len());
        Some(())
    }

    /// The hull of the living faces, with only the corners that they have.
    fn finish(self) -> Hull {
        let mut new_name = HashMap::new();
        let mut vertices = Vec::new();
        let mut faces = Vec::new();
        for face in self.faces.iter().filter(|face| face.alive) {
            faces.push(face.corners.map(|corner| {
                *new_name.entry(corner).or_insert_with(|| {
                    vertices.push(self.points[corner as usize]);
                    vertices.len() as u32 - 1
                })
            }));
        }
        Hull::from_triangles(vertices, faces)
    }
}

/// The sides of a face, in its order.
fn sides([a, b, c]: [u32; 3]) -> [(u32, u32); 3] {
    [(a, b), (b, c), (c, a)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn volume(hull: &Hull) -> f64 {
        let corner = |i: u32| hull.vertices()[i as usize];
        let faces = hull.faces().iter();
        faces.map(|&[a, b, c]| dot(corner(a), cross(corner(b), corner(c))) / 6.0).sum()
    }

    /// A hull is right if it is valid, holds every point, and has only points as corners.
    fn check(points: &[Vector]) -> Hull {
        let hull = Hull::around(points).unwrap();
        let faces: Vec<Vec<u32>> = hull.faces().iter().map(|face| face.to_vec()).collect();
        Hull::new(hull.vertices().to_vec(), &faces).unwrap();
        for &p in points {
            assert!(hull.distance(p).0 < 1e-8, "{p:?} sticks out by {}", hull.distance(p).0);
        }
        assert!(hull.vertices().iter().all(|vertex| points.contains(vertex)));
        hull
    }

    proptest! {
        #[test]
        fn holds_every_point(
            points in prop::collection::vec(prop::array::uniform3(-1.0..1.0_f64), 5..100),
        ) {
            check(&points);
        }

        #[test]
        fn grids_have_many_points_in_a_plane(
            points in prop::collection::vec(prop::array::uniform3(-2..3_i32), 12..60),
        ) {
            let points: Vec<Vector> = points.iter().map(|p| p.map(|v| f64::from(v) / 7.0)).collect();
            if Hull::around(&points).is_ok() {
                check(&points);
            }
        }
    }

    #[test]
    fn well_known_solids() {
        let mut cube = Vec::new();
        for i in 0..125 {
            cube.push([i / 25, i / 5 % 5, i % 5].map(|v| f64::from(v) / 4.0));
        }
        let hull = check(&cube);
        assert!((volume(&hull) - 1.0).abs() < 1e-12);
        let ring = |z: f64| {
            (0..64).map(move |i| f64::from(i) * std::f64::consts::TAU / 64.0).map(move |a| {
                let (sin, cos) = a.sin_cos();
                [cos, sin, z]
            })
        };
        let prism: Vec<Vector> = ring(0.0).chain(ring(2.0)).collect();
        let area = 32.0 * (std::f64::consts::TAU / 64.0).sin();
        assert!((volume(&check(&prism)) - 2.0 * area).abs() < 1e-9);
    }

    #[test]
    fn refuses_what_has_no_volume() {
        let flat: Vec<Vector> = (0..20).map(|i| [f64::from(i), f64::from(i * i), 0.5]).collect();
        for points in [vec![], vec![[1.0; 3]; 9], flat[..2].to_vec(), flat] {
            assert_eq!(Hull::around(&points).unwrap_err().field, "points");
        }
        assert_eq!(Hull::around(&[[0.0, f64::NAN, 0.0]]).unwrap_err().field, "points[0][1]");
    }
}
