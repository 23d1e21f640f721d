//! What the waypoint policy sees: one row of numbers per waypoint, the same for every number of waypoints.
//!
//! Lengths are normalised (1 is 10 px of the paper's field), directions are along and across the line from start to goal, and
//! distances are the exact signed distances of the robot's body, walls included. A row holds
//!
//! | numbers | what |
//! | --- | --- |
//! | 2, 2 | offset from the start, and to the goal (/3.2) |
//! | 2, 2 | offset to the point before, and to the one after (x2) |
//! | 2 | the last update (x2.5) |
//! | 1, 1, 1 | distance from start to goal (/3.2), place i / (N + 1), N + 1 (/11) |
//! | 1, 1, 1 | steps so far (/20), whether the first trajectory was not the straight line, share of segments that are not free |
//! | 1, 1, 2 | signed distance at the waypoint: coarse (clamped to 1.2, /0.6), fine (clamped to 0.15, /0.15); its gradient |
//! | 8, 8 | of the segment before, and of the one after: coarse distance at 3 of 7 points; the least of the 7 fine, its gradient and its place on the segment (0 to 1); whether it is free by the certificate |
//! | R x K | coarse distance at K directions on each of R circles around the waypoint |
//! | 2 | of a view with the gradient of U, that downhill (x2) |
//! | 5 x (C + 2), 2 | of a view with a map ([`TaskMap`]), its features at the waypoint and around it, then the detour through there and how far along it is; offset to the shortest way (x0.6) |
//!
//! A view of a picture ([`Picture`]) has shades of its pixels where another has distances, and is told no ways; whether
//! a segment is free it judges by shades.

mod bilinear;
mod look;
mod map;
mod measure;
mod parts;
mod picture;
mod sweeps;
mod ways;

use std::sync::Arc;

use crate::kernels::Isa;
use crate::plane::Subject;
use crate::plane::distance::LANES;
use crate::trajectory::ActionRule;
use look::Axes;
use measure::{Buffers, ON_SEGMENT, Seen, measure};

pub use look::Look;
pub use map::TaskMap;
pub use parts::{PART, Probes, ViewParts};
pub use picture::Picture;

/// Numbers of a row besides the probes.
const OWN: usize = 36;
/// Coarse distances are clamped to this, and halved.
const COARSE: f32 = 1.2;
/// Fine distances are clamped to this.
const FINE: f32 = 0.15;
/// Gradients are multiplied by this.
const GRADIENT: f32 = 2.0;

/// A trajectory as a view is shown it.
#[derive(Debug, Clone, Copy)]
pub struct Iterate<'a> {
    /// The waypoints `[N x 2]`, in normalised units.
    pub x: &'a [f32],
    /// Which segments are certified, `[N + 1]`.
    pub free: &'a [bool],
    /// The gradient of U, `[N x 2]`; read only where the view has that part.
    pub gradient: &'a [f32],
}

/// The view of one trajectory of one task, with what it remembers from earlier steps.
#[derive(Debug, Clone)]
pub struct WaypointView {
    waypoints: usize,
    look: Look,
    axes: Axes,
    /// Where waypoints may be: `[min_x, min_y, max_x, max_y]`.
    room: [f32; 4],
    /// Offsets of the probes, in field axes.
    offsets: Vec<[f32; 2]>,
    /// Last update of each waypoint, along and across, in the order of the look.
    previous: Vec<[f32; 2]>,
    age: u32,
    is_bent: bool,
    buffers: Buffers,
    /// What is seen in place of distances.
    picture: Option<Arc<Picture>>,
    /// Whether the gradient of U is seen.
    gradient: bool,
    isa: Isa,
}

impl WaypointView {
    /// A view of the trajectories of `subject`.
    pub fn new(parts: &ViewParts, subject: Subject<'_>, look: Look) -> Self {
        let probes = &parts.probes;
        let waypoints = subject.waypoints;
        let axes = Axes::new(subject, look);
        let start = axes.start;
        let scene = subject.scene;
        let bounds = scene.certifier().bounds();
        let [min_x, min_y] = scene.frame().to_normalised(bounds.min);
        let [max_x, max_y] = scene.frame().to_normalised(bounds.max);
        // Half a hair inside, so that rounding to f32 puts no waypoint into a wall.
        let hair = 1e-5;
        let offsets: Vec<[f32; 2]> = probes.offsets().map(|p| axes.turn(p)).collect();
        let points = (2 * waypoints + 1).next_multiple_of(LANES);
        let on_segments = (ON_SEGMENT * (waypoints + 1)).next_multiple_of(LANES);
        let probed = (waypoints * offsets.len()).next_multiple_of(LANES);
        // Prepared here, so that no iteration pays for it.
        scene.exact_field();
        Self {
            waypoints,
            look,
            axes,
            room: [min_x + hair, min_y + hair, max_x - hair, max_y - hair],
            offsets,
            previous: vec![[0.0; 2]; waypoints],
            age: 0,
            is_bent: false,
            buffers: Buffers {
                points: vec![start; waypoints],
                x: vec![start[0]; points],
                y: vec![start[1]; points],
                distance: vec![0.0; points],
                gradient_x: vec![0.0; points],
                gradient_y: vec![0.0; points],
                least: vec![0; waypoints + 1],
                free: vec![false; waypoints + 1],
                segment_x: vec![start[0]; on_segments],
                segment_y: vec![start[1]; on_segments],
                segment: vec![0.0; on_segments],
                probe_x: vec![start[0]; probed],
                probe_y: vec![start[1]; probed],
                probe: vec![0.0; probed],
            },
            picture: parts.picture.map(|pixels| Arc::new(Picture::draw(scene, pixels))),
            gradient: parts.gradient,
            isa: Isa::detect(),
        }
    }

    /// Forgets earlier steps: the next trajectory is a first one.
    pub fn reset(&mut self) {
        self.previous.fill([0.0; 2]);
        self.age = 0;
    }

    /// Writes the rows of a trajectory's waypoints to `out [N x stride]`, in the order of the look, `stride` at least the row's
    /// length; `map` is the task's of the same look, read by the network, where the view has one.
    pub fn encode(
        &mut self,
        subject: Subject<'_>,
        Iterate { x, free, gradient }: Iterate<'_>,
        map: Option<&TaskMap>,
        out: &mut [f32],
        stride: usize,
    ) {
        self.buffers.points.copy_from_slice(x.as_chunks::<2>().0);
        self.buffers.free.copy_from_slice(free);
        if self.look.backwards {
            self.buffers.points.reverse();
            self.buffers.free.reverse();
        }
        if self.age == 0 {
            self.is_bent = self.bends();
        }
        let Axes { start, goal, length, .. } = self.axes;
        let seen = match &self.picture {
            Some(picture) => Seen::Picture(picture),
            None => Seen::Field(subject.scene.exact_field()),
        };
        measure(self.isa, seen, &mut self.buffers, &self.offsets, start, goal);
        if self.picture.is_some() {
            self.buffers.judge_by_shades();
        }
        let blocked = self.buffers.free.iter().filter(|free| !**free).count();
        let shared = [
            length / 3.2,
            (self.waypoints + 1) as f32 / 11.0,
            (self.age as f32 / 20.0).min(2.0),
            f32::from(u8::from(self.is_bent)),
            blocked as f32 / (self.waypoints + 1) as f32,
        ];
        for (i, row) in out.chunks_exact_mut(stride).take(self.waypoints).enumerate() {
            let mut rest = self.write_row(i, &shared, row);
            if self.gradient {
                let place = if self.look.backwards { self.waypoints - 1 - i } else { i };
                let (head, tail) = rest.split_at_mut(2);
                let slope = gradient.as_chunks::<2>().0[place];
                head.copy_from_slice(&self.axes.back(slope.map(|s| -GRADIENT * s)));
                rest = tail;
            }
            rest.fill(0.0);
            if let Some(map) = map {
                map.read(i, self.buffers.points[i], rest);
            }
        }
    }

    /// Writes all but the gradient and the map's features, and returns what is left of the row.
    fn write_row<'a>(&self, i: usize, shared: &[f32; 5], row: &'a mut [f32]) -> &'a mut [f32] {
        let (points, axes) = (&self.buffers.points, &self.axes);
        let before = if i > 0 { points[i - 1] } else { axes.start };
        let after = points.get(i + 1).copied().unwrap_or(axes.goal);
        let Buffers { distance, gradient_x, gradient_y, .. } = &self.buffers;
        let at = points[i];
        let mut row = RowWriter(row);
        let offset = |from: [f32; 2], to: [f32; 2], factor: f32| {
            axes.back([factor * (to[0] - from[0]), factor * (to[1] - from[1])])
        };
        row.put(offset(axes.start, at, 1.0 / 3.2));
        row.put(offset(at, axes.goal, 1.0 / 3.2));
        row.put(offset(at, before, 2.0));
        row.put(offset(at, after, 2.0));
        row.put(self.previous[i].map(|u| 2.5 * u));
        row.put(*shared);
        row.put([(i + 1) as f32 / (self.waypoints + 1) as f32]);
        row.put([coarse(distance[i]), fine(distance[i])]);
        row.put(axes.back([gradient_x[i], gradient_y[i]]));
        for segment in [i, i + 1] {
            let (first, least) = (ON_SEGMENT * segment, self.waypoints + segment);
            row.put([1, 3, 5].map(|k| coarse(self.buffers.segment[first + k])));
            row.put([fine(distance[least])]);
            row.put(axes.back([gradient_x[least], gradient_y[least]]));
            row.put([(self.buffers.least[segment] + 1) as f32 / (ON_SEGMENT + 1) as f32]);
            row.put([f32::from(u8::from(self.buffers.free[segment]))]);
        }
        let probes = self.offsets.len();
        let (head, tail) = row.0.split_at_mut(probes);
        for (out, &distance) in head.iter_mut().zip(&self.buffers.probe[i * probes..]) {
            *out = coarse(distance);
        }
        tail
    }

    /// Whether the waypoints leave the straight line by more than half a pixel.
    fn bends(&self) -> bool {
        let segments = (self.waypoints + 1) as f32;
        let Axes { start, goal, .. } = self.axes;
        self.buffers.points.iter().enumerate().any(|(i, p)| {
            let t = (i + 1) as f32 / segments;
            (0..2).any(|axis| {
                let line = start[axis] + t * (goal[axis] - start[axis]);
                (p[axis] - line).abs() > 0.05
            })
        })
    }

    /// Moves the waypoints `x [N x 2]` by the network's `output(i)` for each row, along and across, as `rule` says, and
    /// remembers the update. A NaN counts as 0.
    pub fn apply(&mut self, rule: &ActionRule, output: impl Fn(usize) -> [f32; 2], x: &mut [f32]) {
        let [min_x, min_y, max_x, max_y] = self.room;
        for (place, p) in x.as_chunks_mut::<2>().0.iter_mut().enumerate() {
            let i = if self.look.backwards { self.waypoints - 1 - place } else { place };
            let update = output(i).map(|value| {
                let update = (rule.scale * value).clamp(-rule.limit, rule.limit);
                if update.is_nan() { 0.0 } else { update }
            });
            let moved = self.axes.turn(update);
            let mut next = [p[0] + moved[0], p[1] + moved[1]];
            if rule.keep_inside {
                next = [next[0].max(min_x).min(max_x), next[1].max(min_y).min(max_y)];
            }
            *p = next;
            self.previous[i] = update;
        }
        self.age += 1;
    }

    /// The direction from start to goal, or from goal to start: the first axis.
    pub fn along(&self) -> [f32; 2] {
        self.axes.along
    }
}

/// What is left of a row to write.
struct RowWriter<'a>(&'a mut [f32]);

impl RowWriter<'_> {
    /// Writes the next numbers. Their count is known, so that they are stored and not copied by a call.
    #[inline(always)]
    fn put<const N: usize>(&mut self, values: [f32; N]) {
        let (head, tail) = std::mem::take(&mut self.0).split_at_mut(N);
        head.copy_from_slice(&values);
        self.0 = tail;
    }
}

fn coarse(distance: f32) -> f32 {
    distance.clamp(-COARSE, COARSE) / 0.6
}

fn fine(distance: f32) -> f32 {
    distance.clamp(-FINE, FINE) / FINE
}

#[cfg(test)]
mod tests;
