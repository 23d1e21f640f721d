//! Signed distance fields in normalised units, positive in free space.
//!
//! A [`Field`] answers distance and gradient for a block of points at once. Shapes are exact
//! (`shapes`), grids and the paper's profile are images (`image`); the bounds are walls.

mod boundary;
mod image;
mod index;
mod nearest;
mod pieces;
mod segments;
mod shapes;
mod transform;

use std::sync::Arc;

use crate::kernels::{Isa, dispatch};
use crate::plane::Robot;
use crate::plane::frame::Frame;
use crate::plane::world::{Obstacle, World};
use crate::profile::{DistanceKind, Profile};

pub use image::{ImageField, Interpolation};
pub use shapes::ShapeField;
pub use transform::squared_distance_transform;

/// Points are processed in blocks of this many lanes.
pub(crate) const LANES: usize = 16;

/// Points that tell the typical clearance; a multiple of [`LANES`].
const CLEARANCE_POINTS: usize = 1024;
/// Steps of the R2 sequence, 1/p and 1/p² for p³ = p + 1 (Roberts 2018, "The unreasonable
/// effectiveness of quasirandom sequences"): even, and on no lattice that a grid could share.
const R2: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_3];

/// Distances and gradients of a set of points, in slices of equal length (a multiple of [`LANES`]).
#[derive(Debug)]
pub(crate) struct Samples<'a> {
    pub distance: &'a mut [f32],
    pub gradient_x: &'a mut [f32],
    pub gradient_y: &'a mut [f32],
}

/// The distance field of a world for a robot.
#[derive(Debug, Clone)]
pub struct Field {
    shapes: Option<Arc<ShapeField>>,
    /// Shapes that were added to a field of shapes.
    more: Option<Arc<ShapeField>>,
    image: Option<Arc<ImageField>>,
    /// Normalised `[min_x, min_y, max_x, max_y]` of the bounds, where walls are not in the image.
    walls: Option<[f32; 4]>,
    radius: f32,
}

impl Field {
    /// Builds the field that the profile asks for.
    pub fn new(world: &World, robot: Robot, profile: &Profile) -> Self {
        Self::new_while(world, robot, profile, &|| true).expect("nobody breaks off")
    }

    /// [`Field::new`] that is broken off, with nothing, once `go_on` is false. It is asked every few microseconds.
    pub fn new_while(
        world: &World,
        robot: Robot,
        profile: &Profile,
        go_on: &(dyn Fn() -> bool + Sync),
    ) -> Option<Self> {
        let frame = Frame::new(profile, world.bounds());
        match profile.distance {
            DistanceKind::PaperImage => Some(Self {
                shapes: None,
                more: None,
                image: Some(Arc::new(ImageField::paper(world, &frame))),
                walls: None,
                radius: (robot.radius() / frame.scale) as f32,
            }),
            DistanceKind::Exact => Self::exact_while(world, robot, &frame, go_on),
        }
    }

    /// The exact field in the normalised units of `frame`, whatever the profile.
    pub fn exact(world: &World, robot: Robot, frame: &Frame) -> Self {
        Self::exact_while(world, robot, frame, &|| true).expect("nobody breaks off")
    }

    /// [`Field::exact`] that is broken off, with nothing, once `go_on` is false.
    pub fn exact_while(
        world: &World,
        robot: Robot,
        frame: &Frame,
        go_on: &(dyn Fn() -> bool + Sync),
    ) -> Option<Self> {
        let [min_x, min_y] = frame.to_normalised(world.bounds().min);
        let [max_x, max_y] = frame.to_normalised(world.bounds().max);
        let obstacles = world.obstacles();
        let shapes = match obstacles {
            [] => None,
            _ => {
                let size = [max_x - min_x, max_y - min_y];
                Some(Arc::new(ShapeField::new(obstacles, frame, size, go_on)?))
            }
        };
        let image = match world.grid().filter(|grid| grid.cells().contains(&true)) {
            None => None,
            Some(grid) => Some(Arc::new(ImageField::grid(grid, frame, go_on)?)),
        };
        Some(Self {
            shapes,
            more: None,
            image,
            walls: Some([min_x, min_y, max_x, max_y]),
            radius: (robot.radius() / frame.scale) as f32,
        })
    }

    /// An exact field's with more obstacles, in the same `frame`; what was prepared is shared. Inside what lies in shapes of both
    /// kinds, the distance is that of the deeper one alone. None once `go_on` is false.
    pub fn with(
        &self,
        more: &[Obstacle],
        frame: &Frame,
        go_on: &(dyn Fn() -> bool + Sync),
    ) -> Option<Self> {
        let mut field = self.clone();
        if !more.is_empty() {
            let [min_x, min_y, max_x, max_y] = self.walls.unwrap_or_default();
            let size = [max_x - min_x, max_y - min_y];
            let added = Some(Arc::new(ShapeField::new(more, frame, size, go_on)?));
            if field.shapes.is_none() { field.shapes = added } else { field.more = added }
        }
        Some(field)
    }

    /// Signed distance of the robot's body at one point and its gradient (both unquirked), in
    /// normalised units.
    pub fn at(&self, p: [f32; 2]) -> (f32, [f32; 2]) {
        let [mut distance, mut gradient_x, mut gradient_y] = [[0.0; LANES]; 3];
        let mut samples = Samples {
            distance: &mut distance,
            gradient_x: &mut gradient_x,
            gradient_y: &mut gradient_y,
        };
        self.sample(&[p[0]; LANES], &[p[1]; LANES], 1, &mut samples);
        (distance[0], [gradient_x[0], gradient_y[0]])
    }

    /// The median distance over the free part of a field of this size, at most its larger side; 0
    /// where nothing is free. In normalised units.
    pub fn typical_clearance(&self, size: [f32; 2]) -> f32 {
        let place = [0, 1].map(|axis| {
            let even = |i: usize| size[axis] * (R2[axis] * (i + 1) as f64).fract() as f32;
            std::array::from_fn::<f32, CLEARANCE_POINTS, _>(even)
        });
        let mut distances = [0.0; CLEARANCE_POINTS];
        self.probe_all(&place[0], &place[1], &mut distances);
        let mut free = 0;
        for i in 0..CLEARANCE_POINTS {
            if distances[i] > 0.0 {
                distances[free] = distances[i];
                free += 1;
            }
        }
        if free == 0 {
            return 0.0;
        }
        let (_, median, _) = distances[..free].select_nth_unstable_by(free / 2, f32::total_cmp);
        median.min(size[0].max(size[1]))
    }

    /// Samples the first `points` points; slices have equal length, a multiple of [`LANES`], and what
    /// lies after the points is filled with any finite values.
    #[inline(always)]
    pub(crate) fn sample(&self, x: &[f32], y: &[f32], points: usize, out: &mut Samples<'_>) {
        match (&self.shapes, &self.image) {
            (Some(shapes), None) => shapes.sample(x, y, out),
            (None, Some(image)) => image.sample(x, y, points, out),
            (None, None) => out.distance.fill(f32::INFINITY),
            (Some(shapes), Some(image)) => {
                shapes.sample(x, y, out);
                merge_image(image, x, y, out);
            }
        }
        if let Some(more) = &self.more {
            more.merge(x, y, out);
        }
        if let Some(walls) = self.walls {
            merge_walls(walls, x, y, out);
        }
        if self.radius > 0.0 {
            out.distance.iter_mut().for_each(|d| *d -= self.radius);
        }
    }
}

impl Field {
    /// [`Field::probe`] on this machine's instruction set.
    pub(crate) fn probe_all(&self, x: &[f32], y: &[f32], out: &mut [f32]) {
        probe_points(Isa::detect(), self, x, y, out);
    }

    /// Signed distances without gradients, quickly: exact in free space, and in obstacles at most as deep as
    /// [`Field::sample`] says. Slices have equal length, a multiple of [`LANES`].
    #[inline(always)]
    pub(crate) fn probe(&self, x: &[f32], y: &[f32], out: &mut [f32]) {
        match &self.shapes {
            Some(shapes) => shapes.probe(x, y, out),
            None => out.fill(f32::INFINITY),
        }
        if let Some(more) = &self.more {
            more.probe_nearer(x, y, out);
        }
        if let Some(image) = &self.image {
            for i in 0..x.len() {
                out[i] = out[i].min(image.at([x[i], y[i]]).0);
            }
        }
        let [min_x, min_y, max_x, max_y] = self.walls.unwrap_or([
            f32::NEG_INFINITY,
            f32::NEG_INFINITY,
            f32::INFINITY,
            f32::INFINITY,
        ]);
        let blocks = x.as_chunks::<LANES>().0.iter().zip(y.as_chunks::<LANES>().0);
        for ((x, y), out) in blocks.zip(out.as_chunks_mut::<LANES>().0) {
            for l in 0..LANES {
                let wall = (x[l] - min_x).min(max_x - x[l]).min(y[l] - min_y).min(max_y - y[l]);
                let nearest = if wall < out[l] { wall } else { out[l] };
                out[l] = nearest - self.radius;
            }
        }
    }
}

/// Keeps the nearer of what `out` holds and the image.
fn merge_image(image: &ImageField, x: &[f32], y: &[f32], out: &mut Samples<'_>) {
    for i in 0..x.len() {
        let (distance, gradient) = image.at([x[i], y[i]]);
        if distance < out.distance[i] {
            out.distance[i] = distance;
            out.gradient_x[i] = gradient[0];
            out.gradient_y[i] = gradient[1];
        }
    }
}

/// Keeps the nearer of what `out` holds and the walls. At a tie the shape's gradient stays.
#[inline(always)]
fn merge_walls(
    [min_x, min_y, max_x, max_y]: [f32; 4],
    x: &[f32],
    y: &[f32],
    out: &mut Samples<'_>,
) {
    for first in (0..x.len()).step_by(LANES) {
        let range = first..first + LANES;
        let [mut px, mut py, mut distance, mut gradient_x, mut gradient_y] = [[0.0; LANES]; 5];
        px.copy_from_slice(&x[range.clone()]);
        py.copy_from_slice(&y[range.clone()]);
        distance.copy_from_slice(&out.distance[range.clone()]);
        gradient_x.copy_from_slice(&out.gradient_x[range.clone()]);
        gradient_y.copy_from_slice(&out.gradient_y[range.clone()]);
        for l in 0..LANES {
            let candidates = [
                (px[l] - min_x, 1.0, 0.0),
                (max_x - px[l], -1.0, 0.0),
                (py[l] - min_y, 0.0, 1.0),
                (max_y - py[l], 0.0, -1.0),
            ];
            for (wall, wall_x, wall_y) in candidates {
                let nearer = wall < distance[l];
                distance[l] = if nearer { wall } else { distance[l] };
                gradient_x[l] = if nearer { wall_x } else { gradient_x[l] };
                gradient_y[l] = if nearer { wall_y } else { gradient_y[l] };
            }
        }
        out.distance[range.clone()].copy_from_slice(&distance);
        out.gradient_x[range.clone()].copy_from_slice(&gradient_x);
        out.gradient_y[range].copy_from_slice(&gradient_y);
    }
}

/// Points whose distances and gradients are asked for together.
#[derive(Debug, Clone, Default)]
pub struct Sampler {
    points: usize,
    x: Vec<f32>,
    y: Vec<f32>,
    distance: Vec<f32>,
    gradient_x: Vec<f32>,
    gradient_y: Vec<f32>,
}

impl Sampler {
    /// Forgets all points.
    pub fn clear(&mut self) {
        self.points = 0;
        self.x.clear();
        self.y.clear();
    }

    /// Adds a point, in normalised units.
    pub fn push(&mut self, p: [f32; 2]) {
        self.x.truncate(self.points);
        self.y.truncate(self.points);
        self.x.push(p[0]);
        self.y.push(p[1]);
        self.points += 1;
    }

    /// Signed distance and gradient at each point, in the order of the points.
    pub fn sample(&mut self, field: &Field) -> impl Iterator<Item = (f32, [f32; 2])> + '_ {
        let padded = self.points.next_multiple_of(LANES);
        for values in [&mut self.x, &mut self.y] {
            let last = values.last().copied().unwrap_or(0.0);
            values.resize(padded, last);
        }
        let Self { points, x, y, distance, gradient_x, gradient_y } = self;
        for values in [&mut *distance, gradient_x, gradient_y] {
            values.resize(padded, 0.0);
        }
        let mut samples = Samples { distance, gradient_x, gradient_y };
        sample_points(Isa::detect(), field, x, y, *points, &mut samples);
        let Self { distance, gradient_x, gradient_y, .. } = self;
        (0..self.points).map(move |i| (distance[i], [gradient_x[i], gradient_y[i]]))
    }
}

dispatch! {
    fn probe_points(field: &Field, x: &[f32], y: &[f32], out: &mut [f32]) = probe_points_body;
}

#[inline(always)]
fn probe_points_body<const ISA: u8>(field: &Field, x: &[f32], y: &[f32], out: &mut [f32]) {
    field.probe(x, y, out);
}

dispatch! {
    fn sample_points(field: &Field, x: &[f32], y: &[f32], points: usize, out: &mut Samples<'_>)
        = sample_points_body;
}

#[inline(always)]
fn sample_points_body<const ISA: u8>(
    field: &Field,
    x: &[f32],
    y: &[f32],
    points: usize,
    out: &mut Samples<'_>,
) {
    field.sample(x, y, points, out);
}
