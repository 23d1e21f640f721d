//! The proof of a block of intervals of one motion: lanes are its configurations, in order.
//!
//! At every configuration each ball must be clear of every obstacle piece. Between two of them, a and b, a ball's centre is
//! within its bulge h² M / 8 of the chord from c(a) to c(b) (`reach.rs`). The signed distance d to a convex piece is a convex
//! function, so along the chord f = d - radius lies above its tangents at both ends, with the slopes
//! s = n . (c(b) - c(a)):
//!
//! ```text
//! bound = f(a) if s(a) >= 0;   f(b) if s(b) <= 0;   else where the tangents meet
//! free if bound > bulge
//! ```
//!
//! The same for two balls of the body, whose difference of centres has the sum of their bulges (|.| is convex).
//!
//! Most are far from most, so cheaper questions come first: every place on a chord is within half its length of one of its ends,
//! so if no configuration is nearer than bulge + half the longest chord (its *sweep*), nothing is open. That is asked
//! for the ball around a link, then for its balls, and only then for tangents.

use super::Certifier;
use crate::arm::kinematics::{Frame, point};
use crate::arm::lanes::{
    Lane, Points, lane_max, lane_min, least_square, shifted, shifted_points, span,
};
use crate::kernels::{LANES, dispatch, madd};
use crate::space::PieceId;

/// Buffers of a proof; made once by [`Certifier::work`] and used for any number of motions.
#[derive(Debug, Clone)]
pub struct Work {
    /// `[coordinate][lane]`.
    pub(super) q: Vec<Lane>,
    frames: Vec<Frame>,
    /// Centres of the balls around the parts, then of the balls.
    places: Vec<Points>,
    /// How far each can be from the nearest of the block's configurations, in the same order.
    sweeps: Vec<f32>,
    /// 1 for lanes that begin an interval, else 0.
    pub(super) begins: Lane,
    /// Whether the balls of a part are in `places` for this block.
    placed: Vec<bool>,
    /// M / 8 of each, in the order of `places`.
    pub(super) bulges: Vec<f32>,
    /// For `Reach::bulges`.
    pub(super) turned: Vec<f64>,
    near: Vec<PieceId>,
    distances: Vec<Lane>,
    normals: Vec<Points>,
    pub(super) open: Vec<super::Interval>,
    pub(super) delta: Vec<f64>,
}

impl Work {
    pub(super) fn new(certifier: &Certifier) -> Self {
        let arm = &certifier.arm;
        let most = arm.parts.iter().map(|part| part.balls.len()).max().unwrap_or(0).max(1);
        let zero = [[0.0; LANES]; 3];
        Self {
            q: vec![[0.0; LANES]; arm.dof()],
            frames: vec![[[0.0; LANES]; 12]; certifier.program.frames()],
            places: vec![zero; arm.parts.len() + arm.balls.len()],
            sweeps: vec![0.0; arm.parts.len() + arm.balls.len()],
            begins: [0.0; LANES],
            placed: vec![false; arm.parts.len()],
            bulges: vec![0.0; certifier.reach.stride()],
            turned: vec![0.0; certifier.program.frames()],
            near: Vec::new(),
            distances: vec![[0.0; LANES]; most],
            normals: vec![zero; most],
            open: Vec::new(),
            delta: vec![0.0; arm.dof()],
        }
    }
}

/// What met what.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Contact {
    /// A ball and a piece of the world.
    Piece { ball: usize, piece: PieceId },
    /// Two balls of the body.
    Balls(usize, usize),
}

/// What a block proved.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Outcome {
    /// At lane `lane` a ball is not clear of something.
    Blocked { lane: usize, contact: Contact },
    /// Every configuration is free; the intervals whose bits are set are not proved.
    Open(u32),
}

/// The least values so far: of each configuration, and of each interval behind it.
struct Least {
    sample: Lane,
    interval: Lane,
}

impl Least {
    #[inline(always)]
    fn new() -> Self {
        Self { sample: [f32::INFINITY; LANES], interval: [f32::INFINITY; LANES] }
    }

    /// Takes in a function of the configuration with its gradient along the chord: values `f`, slopes of
    /// the chord behind each lane at its beginning, `before`, and at its end, `after` (in the lane of
    /// the end), less `bulge`.
    #[inline(always)]
    fn take(&mut self, f: &Lane, before: &Lane, next: &Lane, after: &Lane, bulge: f32) {
        for lane in 0..LANES {
            let (a, s) = (f[lane], before[lane]);
            let (b, e) = (next[lane], after[lane]);
            // Where the tangents a + s t and b + e (t - 1) meet; not used unless s < 0 < e.
            let t = (b - e - a) / (s - e);
            let meet = s * t + a;
            let bound = if s >= 0.0 {
                a
            } else if e <= 0.0 {
                b
            } else {
                meet
            };
            let bound = bound - bulge;
            self.sample[lane] = if a < self.sample[lane] { a } else { self.sample[lane] };
            self.interval[lane] =
                if bound < self.interval[lane] { bound } else { self.interval[lane] };
        }
    }

    /// The bits of the lanes of `lanes` that are not above zero (NaN counts as not).
    #[inline(always)]
    fn bits(lanes: &Lane) -> u32 {
        let mut bits = 0;
        for lane in 0..LANES {
            bits |= (u32::from(lanes[lane] > 0.0) ^ 1) << lane;
        }
        bits
    }
}

dispatch! {
    /// Tries to prove the intervals of `intervals` (bit k: from lane k to lane k + 1), each of width `width`, of the motion
    /// whose configurations are in `work.q` and whose bulges for width 1 are in `work.bulges`.
    pub(super) fn prove(certifier: &Certifier, work: &mut Work, width: f32, intervals: u32) -> Outcome = prove_body;
}

#[inline(always)]
fn prove_body<const ISA: u8>(
    certifier: &Certifier,
    work: &mut Work,
    width: f32,
    intervals: u32,
) -> Outcome {
    let arm = &certifier.arm;
    let squared = width * width;
    certifier.program.place::<ISA>(&work.q, &mut work.frames);
    for (index, part) in arm.parts.iter().enumerate() {
        let center = certifier.around[index].0;
        let place = &mut work.places[index];
        point::<ISA>(&work.frames[part.slot], center, place);
        work.sweeps[index] = sweep::<ISA>(place, &work.begins, work.bulges[index] * squared);
        work.placed[index] = false;
    }
    let mut open = 0;
    // The far end of an arm meets most.
    for index in (certifier.first_moving..arm.parts.len()).rev() {
        match against_world::<ISA>(certifier, work, index, squared, intervals) {
            Outcome::Open(bits) => open |= bits,
            blocked => return blocked,
        }
    }
    for &[a, b] in &arm.pairs {
        match against_itself::<ISA>(certifier, work, a, b, squared, intervals) {
            Outcome::Open(bits) => open |= bits,
            blocked => return blocked,
        }
    }
    Outcome::Open(open & intervals)
}

/// One part of the body against the pieces near to it.
#[inline(always)]
fn against_world<const ISA: u8>(
    certifier: &Certifier,
    work: &mut Work,
    index: usize,
    squared: f32,
    intervals: u32,
) -> Outcome {
    let arm = &certifier.arm;
    let count = arm.parts.len();
    let radius = certifier.around[index].1;
    let bulge = work.bulges[index] * squared;
    let (center, half) = span(&work.places[index]);
    let grown = f64::from(half + radius + bulge) + certifier.most_slack;
    let Work { near, places, sweeps, distances, normals, .. } = &mut *work;
    certifier.world.near(center.map(f64::from), grown, near);
    let reach = radius + sweeps[index];
    // `near` shrinks to the pieces that are not clear of the part as a whole.
    let mut kept = 0;
    for at in 0..near.len() {
        let piece = near[at];
        certifier.world.block_distances(piece, &places[index..=index], distances, normals);
        if lane_min(&distances[0]) <= reach + certifier.slack[piece as usize] {
            near[kept] = piece;
            kept += 1;
        }
    }
    if kept == 0 {
        return Outcome::Open(0);
    }
    place_balls::<ISA>(certifier, work, index, squared);
    let range = arm.parts[index].balls.clone();
    let Work { near, places, sweeps, bulges, distances, normals, .. } = &mut *work;
    let balls = &places[count + range.start..count + range.end];
    let mut least = Least::new();
    for &piece in &near[..kept] {
        let slack = certifier.slack[piece as usize];
        certifier.world.block_distances(piece, balls, distances, normals);
        for (at, ball) in range.clone().enumerate() {
            let radius = certifier.balls[ball].1 + slack;
            if lane_min(&distances[at]) > radius + sweeps[count + ball] {
                continue;
            }
            let bulge = bulges[count + ball] * squared;
            take_ball::<ISA>(&mut least, &distances[at], &normals[at], &balls[at], radius, bulge);
        }
        let blocked = Least::bits(&least.sample);
        if blocked != 0 {
            let lane = blocked.trailing_zeros() as usize;
            let clear = |at: usize| distances[at][lane] - certifier.balls[range.start + at].1;
            let deepest =
                (0..range.len()).min_by(|&a, &b| clear(a).total_cmp(&clear(b))).unwrap_or(0);
            let contact = Contact::Piece { ball: range.start + deepest, piece };
            return Outcome::Blocked { lane, contact };
        }
    }
    Outcome::Open(Least::bits(&least.interval) & intervals)
}

/// One ball against one piece.
#[inline(always)]
fn take_ball<const ISA: u8>(
    least: &mut Least,
    distance: &Lane,
    normal: &Points,
    place: &Points,
    radius: f32,
    bulge: f32,
) {
    let next = shifted_points(place);
    let next_normal = shifted_points(normal);
    let mut f = *distance;
    for lane in 0..LANES {
        f[lane] -= radius;
    }
    let next_f = shifted(&f);
    let (mut before, mut after) = ([0.0; LANES], [0.0; LANES]);
    for lane in 0..LANES {
        let step = [0, 1, 2].map(|axis: usize| next[axis][lane] - place[axis][lane]);
        let n = [0, 1, 2].map(|axis: usize| normal[axis][lane]);
        let m = [0, 1, 2].map(|axis: usize| next_normal[axis][lane]);
        before[lane] = madd::<ISA>(n[0], step[0], madd::<ISA>(n[1], step[1], n[2] * step[2]));
        after[lane] = madd::<ISA>(m[0], step[0], madd::<ISA>(m[1], step[1], m[2] * step[2]));
    }
    least.take(&f, &before, &next_f, &after, bulge);
}

/// Two parts of the body against each other.
#[inline(always)]
fn against_itself<const ISA: u8>(
    certifier: &Certifier,
    work: &mut Work,
    a: usize,
    b: usize,
    squared: f32,
    intervals: u32,
) -> Outcome {
    let arm = &certifier.arm;
    let count = arm.parts.len();
    let slack = certifier.self_slack;
    let around = |part: usize| certifier.around[part].1;
    let reach = around(a) + around(b) + slack + work.sweeps[a] + work.sweeps[b];
    if least_square::<ISA>(&work.places[a], &work.places[b]) > reach * reach {
        return Outcome::Open(0);
    }
    place_balls::<ISA>(certifier, work, a, squared);
    place_balls::<ISA>(certifier, work, b, squared);
    let Work { places, sweeps, bulges, .. } = &*work;
    let mut open = 0;
    for i in arm.parts[a].balls.clone() {
        let (place, own) = (&places[count + i], certifier.balls[i].1 + slack);
        let swept = own + sweeps[count + i];
        let reach = swept + around(b) + sweeps[b];
        if least_square::<ISA>(place, &places[b]) > reach * reach {
            continue;
        }
        for j in arm.parts[b].balls.clone() {
            let other = certifier.balls[j].1;
            let reach = swept + other + sweeps[count + j];
            if least_square::<ISA>(place, &places[count + j]) > reach * reach {
                continue;
            }
            let bulge = (bulges[count + i] + bulges[count + j]) * squared;
            let mut least = Least::new();
            take_pair::<ISA>(&mut least, place, &places[count + j], own + other, bulge);
            let blocked = Least::bits(&least.sample);
            if blocked != 0 {
                let lane = blocked.trailing_zeros() as usize;
                return Outcome::Blocked { lane, contact: Contact::Balls(i, j) };
            }
            open |= Least::bits(&least.interval);
        }
    }
    Outcome::Open(open & intervals)
}

/// Two balls against each other.
#[inline(always)]
fn take_pair<const ISA: u8>(least: &mut Least, a: &Points, b: &Points, radius: f32, bulge: f32) {
    let mut apart: Points = [[0.0; LANES]; 3];
    let mut length: Lane = [0.0; LANES];
    for lane in 0..LANES {
        let d = [0, 1, 2].map(|axis: usize| b[axis][lane] - a[axis][lane]);
        (apart[0][lane], apart[1][lane], apart[2][lane]) = (d[0], d[1], d[2]);
        length[lane] = madd::<ISA>(d[0], d[0], madd::<ISA>(d[1], d[1], d[2] * d[2])).sqrt();
    }
    let (next, next_length) = (shifted_points(&apart), shifted(&length));
    let (mut f, mut next_f) = (length, next_length);
    let (mut before, mut after) = ([0.0; LANES], [0.0; LANES]);
    for lane in 0..LANES {
        let d = [0, 1, 2].map(|axis: usize| apart[axis][lane]);
        let e = [0, 1, 2].map(|axis: usize| next[axis][lane]);
        let step = [0, 1, 2].map(|axis: usize| e[axis] - d[axis]);
        let along =
            |v: [f32; 3]| madd::<ISA>(v[0], step[0], madd::<ISA>(v[1], step[1], v[2] * step[2]));
        before[lane] = along(d) / length[lane];
        after[lane] = along(e) / next_length[lane];
        f[lane] -= radius;
        next_f[lane] -= radius;
    }
    least.take(&f, &before, &next_f, &after, bulge);
}

/// Places the balls of a part, unless this block has done so.
#[inline(always)]
fn place_balls<const ISA: u8>(certifier: &Certifier, work: &mut Work, index: usize, squared: f32) {
    if work.placed[index] {
        return;
    }
    work.placed[index] = true;
    let part = &certifier.arm.parts[index];
    let count = certifier.arm.parts.len();
    for ball in part.balls.clone() {
        let (at, center) = (count + ball, certifier.balls[ball].0);
        point::<ISA>(&work.frames[part.slot], center, &mut work.places[at]);
        work.sweeps[at] = sweep::<ISA>(&work.places[at], &work.begins, work.bulges[at] * squared);
    }
}

/// How far a point can be from the nearest of its places in a block: its bulge, and half the longest
/// chord of an interval.
#[inline(always)]
fn sweep<const ISA: u8>(place: &Points, begins: &Lane, bulge: f32) -> f32 {
    let next = shifted_points(place);
    let mut squares: Lane = [0.0; LANES];
    for lane in 0..LANES {
        let [x, y, z] = [0, 1, 2].map(|axis: usize| next[axis][lane] - place[axis][lane]);
        squares[lane] = madd::<ISA>(x, x, madd::<ISA>(y, y, z * z)) * begins[lane];
    }
    bulge + 0.5 * lane_max(&squares).sqrt()
}
