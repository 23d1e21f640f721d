//! What a view measures of a trajectory: distances of its waypoints, of points on its segments, and of
//! probes around them; or the shades of a picture there.

use super::picture::Picture;
use crate::kernels::dispatch;
use crate::plane::distance::{Field, Samples};

/// Points on each segment.
pub(super) const ON_SEGMENT: usize = 7;

/// What is measured: distances, or the shades of a picture.
#[derive(Clone, Copy)]
pub(super) enum Seen<'a> {
    Field(&'a Field),
    Picture(&'a Picture),
}

impl Seen<'_> {
    #[inline(always)]
    fn probe(self, x: &[f32], y: &[f32], out: &mut [f32]) {
        match self {
            Self::Field(field) => field.probe(x, y, out),
            Self::Picture(picture) => picture.probe(x, y, out),
        }
    }

    #[inline(always)]
    fn sample(self, x: &[f32], y: &[f32], points: usize, out: &mut Samples<'_>) {
        match self {
            Self::Field(field) => field.sample(x, y, points, out),
            Self::Picture(picture) => picture.sample(x, y, out),
        }
    }
}

#[derive(Debug, Clone)]
pub(super) struct Buffers {
    /// Waypoints in the order of the look.
    pub points: Vec<[f32; 2]>,
    /// Waypoints, then the point of each segment that is nearest to an obstacle, or deepest in one.
    pub x: Vec<f32>,
    pub y: Vec<f32>,
    pub distance: Vec<f32>,
    pub gradient_x: Vec<f32>,
    pub gradient_y: Vec<f32>,
    /// Per segment, which of its points that is.
    pub least: Vec<usize>,
    /// Per segment, whether it is free.
    pub free: Vec<bool>,
    /// [`ON_SEGMENT`] points of each segment.
    pub segment_x: Vec<f32>,
    pub segment_y: Vec<f32>,
    pub segment: Vec<f32>,
    /// Probes of all waypoints.
    pub probe_x: Vec<f32>,
    pub probe_y: Vec<f32>,
    pub probe: Vec<f32>,
}

impl Buffers {
    /// A segment is taken for free where all of its points and both ends are lighter than grey.
    pub fn judge_by_shades(&mut self) {
        let waypoints = self.points.len();
        for (index, free) in self.free.iter_mut().enumerate() {
            let is_light = |i: usize| self.distance[i] > 0.0;
            let ends =
                (index == 0 || is_light(index - 1)) && (index == waypoints || is_light(index));
            *free = ends && is_light(waypoints + index);
        }
    }
}

dispatch! {
    /// Fills distances and gradients of waypoints and points on segments, and the distances of the probes.
    pub(super) fn measure(
        seen: Seen<'_>,
        buffers: &mut Buffers,
        offsets: &[[f32; 2]],
        start: [f32; 2],
        goal: [f32; 2],
    ) = measure_body;
}

// The same plain arithmetic on every instruction set, so the same bits.
#[inline(always)]
fn measure_body<const ISA: u8>(
    seen: Seen<'_>,
    buffers: &mut Buffers,
    offsets: &[[f32; 2]],
    start: [f32; 2],
    goal: [f32; 2],
) {
    let Buffers {
        points,
        x,
        y,
        distance: waypoint_distance,
        gradient_x,
        gradient_y,
        least,
        segment_x,
        segment_y,
        segment,
        probe_x,
        probe_y,
        probe,
        ..
    } = buffers;
    let mut from = start;
    let lines = segment_x.chunks_exact_mut(ON_SEGMENT).zip(segment_y.chunks_exact_mut(ON_SEGMENT));
    for ((x, y), &to) in lines.zip(points.iter().chain([&goal])) {
        for k in 0..ON_SEGMENT {
            let t = (k + 1) as f32 / (ON_SEGMENT + 1) as f32;
            x[k] = from[0] + t * (to[0] - from[0]);
            y[k] = from[1] + t * (to[1] - from[1]);
        }
        from = to;
    }
    seen.probe(segment_x, segment_y, segment);
    let lines = segment.as_chunks::<ON_SEGMENT>().0.iter();
    for (index, (least, distances)) in least.iter_mut().zip(lines).enumerate() {
        // Without branches, which nothing could predict.
        let (mut place, mut distance) = (0, distances[0]);
        for (k, &other) in distances.iter().enumerate().skip(1) {
            let nearer = other < distance;
            distance = if nearer { other } else { distance };
            place = std::hint::select_unpredictable(nearer, k, place);
        }
        *least = place;
        let (at, first) = (points.len() + index, ON_SEGMENT * index);
        (x[at], y[at]) = (segment_x[first + place], segment_y[first + place]);
    }
    let probes = offsets.len();
    for (i, p) in points.iter().enumerate() {
        (x[i], y[i]) = (p[0], p[1]);
        let (px, py) = (&mut probe_x[i * probes..][..probes], &mut probe_y[i * probes..][..probes]);
        for ((px, py), offset) in px.iter_mut().zip(py).zip(offsets) {
            *px = p[0] + offset[0];
            *py = p[1] + offset[1];
        }
    }
    let mut samples = Samples { distance: waypoint_distance, gradient_x, gradient_y };
    seen.sample(x, y, 2 * points.len() + 1, &mut samples);
    seen.probe(probe_x, probe_y, probe);
}
