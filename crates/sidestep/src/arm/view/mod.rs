//! What a policy sees of a robot with joints: a row of numbers for each waypoint; and what its answer does.
//!
//! A step is that of Levenberg-Marquardt on what is seen, the *base*, and the network's answer on top of it:
//!
//! ```text
//! x <- x + clip(base + scale * output),   base = -(H + mu A)^-1 dU
//! ```
//!
//! with U the objective in the default profile, of three substeps a segment and the balls that are looked at (`measure.rs`), H its Gauss-Newton
//! curvature and A the covariant metric (`optimizer/levenberg_marquardt.rs`). A network that answers 0 is a classical optimizer; one that has learned leaves it where it is stuck.
//!
//! A row holds, for each joint: sine and cosine, place within the limits, offsets to start, goal and both neighbours, the last
//! update, the base, slopes of the cost at the waypoint and along both adjacent segments; for each ball that is looked at: its gap at the
//! waypoint and the least along both segments, near and far told apart for the least of all; and what all waypoints share
//! (`SHARED` numbers). Training and planning call the same code.

mod measure;
mod sensor;

#[cfg(test)]
mod tests;

use super::scene::ArmScene;
use super::sincos::sin_cos;
use crate::arm::Arm;
use crate::error::InvalidInput;
use crate::trajectory::ActionRule;
use measure::{HORIZON, seen_count};
pub use sensor::ArmSensor;

/// The name of the view in files, before `:` and how many balls are looked at.
pub const PART: &str = "joints";
/// Most balls that are looked at.
const MAX_BALLS: usize = 1024;
/// Numbers of a row for each joint.
const PER_JOINT: usize = 12;
/// Numbers of a row that are for no joint and no ball.
const SHARED: usize = 17;
/// Substeps of a segment that are measured.
const SUBSTEPS: usize = 3;
/// Points from one waypoint to the next.
const PERIOD: usize = SUBSTEPS + 1;
/// The gap, in metres, that small numbers resolve.
const FINE: f32 = 0.03;

/// Sizes of a view.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ArmViewShape {
    /// Joints that move.
    pub dof: usize,
    /// Balls of the body that are looked at.
    pub balls: usize,
}

impl ArmViewShape {
    /// That of an arm.
    pub fn of(arm: &Arm) -> Self {
        Self { dof: arm.dof(), balls: seen_count(arm) }
    }

    /// The shape that names in a file stand for: `joints:16`.
    ///
    /// # Errors
    /// If there is another name, or the number of balls is out of range.
    pub fn from_names(names: &[String], dof: usize) -> Result<Self, InvalidInput> {
        let refuse = || {
            let allowed = format!("[\"{PART}:BALLS\"] with 1 to {MAX_BALLS} balls");
            InvalidInput::new("observation", format!("{names:?}"), allowed)
        };
        let [name] = names else { return Err(refuse()) };
        let count = name.strip_prefix(PART).and_then(|rest| rest.strip_prefix(':'));
        let balls = count.and_then(|count| count.parse().ok()).unwrap_or(0);
        if !(1..=MAX_BALLS).contains(&balls) {
            return Err(refuse());
        }
        Ok(Self { dof, balls })
    }

    /// The names that stand for it in a file.
    pub fn names(&self) -> Vec<String> {
        vec![format!("{PART}:{}", self.balls)]
    }

    /// Whether names in a file are those of such a view.
    pub fn is_named(names: &[String]) -> bool {
        names.first().is_some_and(|name| name.split(':').next() == Some(PART))
    }

    /// Numbers of a row.
    pub fn row_len(&self) -> usize {
        PER_JOINT * self.dof + 3 * self.balls + SHARED
    }
}

/// A question to a robot with joints, as its policies see it.
#[derive(Debug, Clone, Copy)]
pub struct ArmSubject<'a> {
    /// The robot in its world.
    pub scene: &'a ArmScene,
    /// Start `[dof]`.
    pub start: &'a [f32],
    /// Goal `[dof]`.
    pub goal: &'a [f32],
    /// Waypoints between them.
    pub waypoints: usize,
}

impl ArmSubject<'_> {
    /// The waypoint of that number, 0 being the start.
    fn point<'x>(&'x self, x: &'x [f32], index: usize) -> &'x [f32] {
        let dof = self.start.len();
        match index {
            0 => self.start,
            index if index > self.waypoints => self.goal,
            index => &x[(index - 1) * dof..index * dof],
        }
    }
}

/// What one trajectory carries from step to step.
#[derive(Debug, Clone)]
pub struct ArmView {
    /// `[N x dof]`, rad or m.
    base: Vec<f32>,
    /// The last update, `[N x dof]`.
    last: Vec<f32>,
    age: u32,
}

impl ArmView {
    /// At the beginning of a walk.
    pub fn new(subject: ArmSubject<'_>) -> Self {
        let zeros = vec![0.0; subject.start.len() * subject.waypoints];
        Self { base: zeros.clone(), last: zeros, age: 0 }
    }

    /// Back to the beginning of a walk.
    pub fn reset(&mut self) {
        self.last.fill(0.0);
        self.age = 0;
    }

    /// What is added to the network's answer, `[N x dof]`, rad or m.
    pub fn base(&self) -> &[f32] {
        &self.base
    }

    /// Writes what the network sees of `x [N x dof]`, whose segments are `free [N + 1]` or not, to `rows [N x stride]`.
    pub fn encode(
        &mut self,
        subject: ArmSubject<'_>,
        sensor: &mut ArmSensor,
        (x, free): (&[f32], &[bool]),
        rows: &mut [f32],
        stride: usize,
    ) {
        sensor.look(subject, x);
        sensor.slope(subject, x);
        for (base, step) in self.base.iter_mut().zip(sensor.step(subject.waypoints)) {
            *base = -step;
        }
        for (i, row) in rows.chunks_exact_mut(stride).enumerate().take(subject.waypoints) {
            let end = self.write_joints(subject, sensor, x, i, row);
            let end = write_balls(sensor, i, &mut row[end..]) + end;
            self.write_shared(subject, sensor, free, i, &mut row[end..]);
        }
    }

    /// What is told of each joint; returns how many numbers.
    fn write_joints(
        &self,
        subject: ArmSubject<'_>,
        sensor: &ArmSensor,
        x: &[f32],
        i: usize,
        row: &mut [f32],
    ) -> usize {
        let limits = subject.scene.normalised_limits();
        let (dof, [before, at, after]) = (limits.len(), [0, 1, 2].map(|k| subject.point(x, i + k)));
        for k in 0..dof {
            let out = &mut row[k * PER_JOINT..][..PER_JOINT];
            let [sin, cos] = sin_cos::<{ crate::kernels::PORTABLE }>(at[k]);
            let [least, most] = limits[k];
            let slopes = &sensor.slopes[k * sensor.points + i * PERIOD..];
            let along = |from: usize| slopes[from..from + SUBSTEPS].iter().sum::<f32>();
            out.copy_from_slice(&[
                sin,
                cos,
                (2.0 * at[k] - least - most) / (most - least).max(1e-3),
                0.5 * (at[k] - subject.start[k]),
                0.5 * (subject.goal[k] - at[k]),
                2.0 * (before[k] - at[k]),
                2.0 * (after[k] - at[k]),
                2.5 * self.last[i * dof + k],
                (5.0 * self.base[i * dof + k]).clamp(-4.0, 4.0),
                squashed(slopes[SUBSTEPS]),
                squashed(along(0) / SUBSTEPS as f32),
                squashed(along(PERIOD) / SUBSTEPS as f32),
            ]);
        }
        dof * PER_JOINT
    }

    /// What is told of the whole; returns how many numbers.
    fn write_shared(
        &self,
        subject: ArmSubject<'_>,
        sensor: &ArmSensor,
        free: &[bool],
        i: usize,
        row: &mut [f32],
    ) {
        let (waypoints, first) = (subject.waypoints as f32, i * PERIOD);
        let squares = subject.start.iter().zip(subject.goal).map(|(a, b)| (b - a) * (b - a));
        let blocked = free.iter().filter(|free| !**free).count();
        let yes = |value: bool| f32::from(u8::from(value));
        let least = |point: usize| {
            let gaps = sensor.gaps.chunks_exact(sensor.points).map(|gaps| gaps[point]);
            gaps.fold(HORIZON, |least, gap| if gap < least { gap } else { least })
        };
        let along = |from: usize| [0, 1, 2].map(|j| least(from + j));
        let (before, after) = (along(first), along(first + PERIOD));
        let smallest = |gaps: [f32; SUBSTEPS]| gaps[0].min(gaps[1]).min(gaps[2]);
        let own = |from: usize, count: usize| {
            let sum: f32 = sensor.own[from..from + count].iter().sum();
            sum / (0.2 + sum)
        };
        row[..SHARED].copy_from_slice(&[
            squares.sum::<f32>().sqrt() / 4.0,
            (self.age as f32 / 20.0).min(2.0),
            blocked as f32 / (waypoints + 1.0),
            waypoints / 15.0,
            (i + 1) as f32 / (waypoints + 1.0),
            yes(free[i]),
            yes(free[i + 1]),
            fine(least(first + SUBSTEPS)),
            fine(smallest(before)),
            fine(smallest(after)),
            coarse(before[0]),
            coarse(before[2]),
            coarse(after[0]),
            coarse(after[2]),
            own(first + SUBSTEPS, 1),
            own(first, SUBSTEPS),
            own(first + PERIOD, SUBSTEPS),
        ]);
    }

    /// Moves the waypoints `x [N x dof]` by the base and the network's `output` of each waypoint `[dof]`. A NaN counts as no update.
    pub fn apply<'o>(
        &mut self,
        subject: ArmSubject<'_>,
        rule: &ActionRule,
        output: impl Fn(usize) -> &'o [f32],
        x: &mut [f32],
    ) {
        let dof = subject.start.len();
        for i in 0..subject.waypoints {
            for (k, &output) in output(i).iter().enumerate().take(dof) {
                let at = i * dof + k;
                let update = (self.base[at] + rule.scale * output).clamp(-rule.limit, rule.limit);
                let update = if update.is_nan() { 0.0 } else { update };
                let [least, most] = subject.scene.normalised_limits()[k];
                x[at] = (x[at] + update).max(least).min(most);
                self.last[at] = update;
            }
        }
        self.age += 1;
    }
}

/// What is told of each ball; returns how many numbers.
fn write_balls(sensor: &ArmSensor, i: usize, row: &mut [f32]) -> usize {
    let first = i * PERIOD;
    for (gaps, out) in sensor.gaps.chunks_exact(sensor.points).zip(row.chunks_exact_mut(3)) {
        let along = |from: usize| gaps[from..from + SUBSTEPS].iter().copied().fold(1e3, f32::min);
        out[0] = coarse(gaps[first + SUBSTEPS]);
        out[1] = coarse(along(first));
        out[2] = coarse(along(first + PERIOD));
    }
    3 * sensor.gaps.len() / sensor.points
}

/// A gap as far as the view sees.
fn coarse(gap: f32) -> f32 {
    2.0 * (gap / HORIZON).max(-1.0)
}

/// A gap near contact.
fn fine(gap: f32) -> f32 {
    (gap / FINE).clamp(-1.0, 1.0)
}

/// A slope, whose size may be any, as a number between -1 and 1.
fn squashed(slope: f32) -> f32 {
    let slope = 0.05 * slope;
    slope / (1.0 + slope.abs())
}
