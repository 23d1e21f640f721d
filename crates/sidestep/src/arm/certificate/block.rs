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
//! for the ball around a link, then for its balls, and only then for tangents. A ball at a distance p from the centre of its link,
//! which turns by at most h T on an interval (T the sum of |D_m| of what turns it), has chords longer than the centre's by at most h T p.
//! That is so of true places; places as computed are off by the rounding that the slack has room for.

use super::Certifier;
use crate::arm::kinematics::{Frame, point};
use crate::arm::lanes::{Lane, Points, shifted_points, span, squares};
use crate::kernels::lanes::{above, all_above, lane_max, shifted};
use crate::kernels::{LANES, dispatch, madd};
use crate::space::PieceId;

/// All lanes.
const ALL: u32 = 0xffff;

/// Buffers of a proof; made once by [`Certifier::work`] and used for any number of motions.
#[derive(Debug, Clone)]
pub struct Work {
    /// Where the motion begins, `[dof]`, and where it goes from there.
    pub(super) from: Vec<f64>,
    pub(super) delta: Vec<f64>,
    /// The block's configurations as parts of the motion.
    pub(super) times: [f64; LANES],
    /// `[coordinate][lane]`.
    q: Vec<Lane>,
    frames: Vec<Frame>,
    /// Centres of the balls around the parts, then of the balls.
    places: Vec<Points>,
    /// The longest chord of each part's centre in the block.
    chords: Vec<f32>,
    /// 1 for lanes that begin an interval, else 0.
    pub(super) begins: Lane,
    /// Whether the balls of a part are in `places` for this block.
    placed: Vec<bool>,
    /// M / 8 of each, in the order of `places`.
    pub(super) bulges: Vec<f32>,
    /// For `Reach::bulges`.
    pub(super) turned: Vec<f64>,
    pub(super) weights: Vec<f32>,
    near: Vec<PieceId>,
    pub(super) open: Vec<super::Interval>,
}

impl Work {
    pub(super) fn new(certifier: &Certifier) -> Self {
        let arm = &certifier.arm;
        let zero = [[0.0; LANES]; 3];
        Self {
            from: vec![0.0; arm.dof()],
            delta: vec![0.0; arm.dof()],
            times: [0.0; LANES],
            q: vec![[0.0; LANES]; arm.dof()],
            frames: vec![[[0.0; LANES]; 12]; certifier.program.frames()],
            places: vec![zero; arm.parts.len() + arm.balls.len()],
            chords: vec![0.0; arm.parts.len()],
            begins: [0.0; LANES],
            placed: vec![false; arm.parts.len()],
            bulges: vec![0.0; certifier.reach.stride()],
            turned: vec![0.0; certifier.program.frames()],
            weights: vec![0.0; certifier.program.frames() - 1],
            near: Vec::new(),
            open: Vec::new(),
        }
    }

    /// How far a part's centre can be from the nearest of its places in the block.
    #[inline(always)]
    fn sweep(&self, part: usize, squared: f32) -> f32 {
        (self.bulges[part] * squared + 0.5 * self.chords[part]) * UP
    }
}

/// Rounded up by more than what sums in f32 lose.
const UP: f32 = 1.0 + 1e-6;

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

/// The intervals, a bit each, on which a function of the place is not proved to stay above `bulge`: its values `f`, and slopes of
/// the chord behind each lane at its beginning, `before`, and at its end, `after` (in the lane of the beginning).
#[inline(always)]
fn unproved<const ISA: u8>(f: &Lane, before: &Lane, after: &Lane, bulge: f32) -> u32 {
    let next = shifted::<ISA>(f);
    let mut bound: Lane = [0.0; LANES];
    for lane in 0..LANES {
        let (a, s) = (f[lane], before[lane]);
        let (b, e) = (next[lane], after[lane]);
        // Where the tangents a + s t and b + e (t - 1) meet; not used unless s < 0 < e.
        let t = (b - e - a) / (s - e);
        let meet = s * t + a;
        let one_sided = if s >= 0.0 { a } else { b };
        bound[lane] = if s >= 0.0 || e <= 0.0 { one_sided } else { meet };
    }
    ALL & !above::<ISA>(&bound, bulge)
}

dispatch! {
    /// Tries to prove the intervals of `intervals` (bit k: from lane k to lane k + 1), each of width `width`, of the motion
    /// `work.from + work.times * work.delta`, whose bulges for width 1 are in `work.bulges`.
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
    let squared = width * width * UP;
    for (k, lanes) in work.q.iter_mut().enumerate() {
        let (from, delta) = (work.from[k], work.delta[k]);
        for lane in 0..LANES {
            lanes[lane] = (from + work.times[lane] * delta) as f32;
        }
    }
    certifier.program.place::<ISA>(&work.q, &mut work.frames);
    for (index, part) in arm.parts.iter().enumerate() {
        let center = certifier.around[index].0;
        let place = &mut work.places[index];
        point::<ISA>(&work.frames[part.slot], center, place);
        let next = shifted_points::<ISA>(place);
        let mut lengths = squares::<ISA>(place, &next);
        for lane in 0..LANES {
            lengths[lane] *= work.begins[lane];
        }
        work.chords[index] = lane_max::<ISA>(&lengths).sqrt();
        work.placed[index] = false;
    }
    let mut open = 0;
    // The far end of an arm meets most.
    for index in (certifier.first_moving..arm.parts.len()).rev() {
        match against_world::<ISA>(certifier, work, index, width, squared) {
            Outcome::Open(bits) => open |= bits,
            blocked => return blocked,
        }
    }
    for &[a, b] in &arm.pairs {
        match against_itself::<ISA>(certifier, work, [a, b], width, squared) {
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
    width: f32,
    squared: f32,
) -> Outcome {
    let arm = &certifier.arm;
    let count = arm.parts.len();
    let surroundings = &certifier.surroundings;
    let reach = certifier.around[index].1 + work.sweep(index, squared);
    let Work { near, places, .. } = &mut *work;
    let place = &places[index];
    surroundings.near::<ISA>(&span::<ISA>(place), reach + certifier.most_slack, near);
    // `near` shrinks to the pieces that are not clear of the part as a whole.
    let mut kept = 0;
    for at in 0..near.len() {
        let piece = near[at];
        let distances = surroundings.distances::<ISA>(piece, place);
        if !all_above::<ISA>(&distances, reach + certifier.slack[piece as usize]) {
            near[kept] = piece;
            kept += 1;
        }
    }
    if kept == 0 {
        return Outcome::Open(0);
    }
    place_balls::<ISA>(certifier, work, index);
    let part = &arm.parts[index];
    let turns = work.turned[part.slot] as f32 * width;
    let mut open = 0;
    for &piece in &work.near[..kept] {
        let slack = certifier.slack[piece as usize];
        for ball in part.balls.clone() {
            let place = &work.places[count + ball];
            let radius = certifier.balls[ball].1 + slack;
            let bulge = work.bulges[count + ball] * squared;
            let chord = work.chords[index] + turns * certifier.offsets[ball];
            let distances = surroundings.distances::<ISA>(piece, place);
            if all_above::<ISA>(&distances, radius + (bulge + 0.5 * chord) * UP) {
                continue;
            }
            let clear = above::<ISA>(&distances, radius);
            if clear != ALL {
                let lane = (!clear).trailing_zeros() as usize;
                return Outcome::Blocked { lane, contact: Contact::Piece { ball, piece } };
            }
            let (distances, normals) = surroundings.answer::<ISA>(piece, place);
            open |= take_ball::<ISA>(&distances, &normals, place, radius, bulge);
        }
    }
    Outcome::Open(open)
}

/// One ball against one piece: what is not proved.
#[inline(always)]
fn take_ball<const ISA: u8>(
    distance: &Lane,
    normal: &Points,
    place: &Points,
    radius: f32,
    bulge: f32,
) -> u32 {
    let next = shifted_points::<ISA>(place);
    let next_normal = shifted_points::<ISA>(normal);
    let mut f = *distance;
    let (mut before, mut after) = ([0.0; LANES], [0.0; LANES]);
    for lane in 0..LANES {
        f[lane] -= radius;
        let x = next[0][lane] - place[0][lane];
        let y = next[1][lane] - place[1][lane];
        let z = next[2][lane] - place[2][lane];
        let (n, m) = (normal, &next_normal);
        before[lane] = madd::<ISA>(n[0][lane], x, madd::<ISA>(n[1][lane], y, n[2][lane] * z));
        after[lane] = madd::<ISA>(m[0][lane], x, madd::<ISA>(m[1][lane], y, m[2][lane] * z));
    }
    unproved::<ISA>(&f, &before, &after, bulge)
}

/// Two parts of the body against each other.
#[inline(always)]
fn against_itself<const ISA: u8>(
    certifier: &Certifier,
    work: &mut Work,
    [a, b]: [usize; 2],
    width: f32,
    squared: f32,
) -> Outcome {
    let arm = &certifier.arm;
    let count = arm.parts.len();
    let around = [a, b].map(|part| certifier.around[part].1 + work.sweep(part, squared));
    let reach = around[0] + around[1] + certifier.self_slack;
    let apart = squares::<ISA>(&work.places[a], &work.places[b]);
    if all_above::<ISA>(&apart, reach * reach) {
        return Outcome::Open(0);
    }
    place_balls::<ISA>(certifier, work, a);
    place_balls::<ISA>(certifier, work, b);
    let turns = [a, b].map(|part| work.turned[arm.parts[part].slot] as f32 * width);
    let Work { places, chords, bulges, .. } = &*work;
    let mut open = 0;
    for i in arm.parts[a].balls.clone() {
        let (place, own) = (&places[count + i], certifier.balls[i].1 + certifier.self_slack);
        let first = bulges[count + i] * squared;
        let swept = own + (first + 0.5 * (chords[a] + turns[0] * certifier.offsets[i])) * UP;
        let reach = swept + around[1];
        if all_above::<ISA>(&squares::<ISA>(place, &places[b]), reach * reach) {
            continue;
        }
        for j in arm.parts[b].balls.clone() {
            let second = bulges[count + j] * squared;
            let radius = own + certifier.balls[j].1;
            let reach = swept
                + certifier.balls[j].1
                + (second + 0.5 * (chords[b] + turns[1] * certifier.offsets[j])) * UP;
            let apart = squares::<ISA>(place, &places[count + j]);
            if all_above::<ISA>(&apart, reach * reach) {
                continue;
            }
            let mut lengths: Lane = [0.0; LANES];
            for lane in 0..LANES {
                lengths[lane] = apart[lane].sqrt();
            }
            let clear = above::<ISA>(&lengths, radius);
            if clear != ALL {
                let lane = (!clear).trailing_zeros() as usize;
                return Outcome::Blocked { lane, contact: Contact::Balls(i, j) };
            }
            let other = &places[count + j];
            open |= take_pair::<ISA>(place, other, &lengths, radius, (first + second) * UP);
        }
    }
    Outcome::Open(open)
}

/// Two balls, `lengths` apart, against each other: what is not proved.
#[inline(always)]
fn take_pair<const ISA: u8>(
    a: &Points,
    b: &Points,
    lengths: &Lane,
    radius: f32,
    bulge: f32,
) -> u32 {
    let mut apart: Points = [[0.0; LANES]; 3];
    for axis in 0..3 {
        for lane in 0..LANES {
            apart[axis][lane] = b[axis][lane] - a[axis][lane];
        }
    }
    let (next, next_lengths) = (shifted_points::<ISA>(&apart), shifted::<ISA>(lengths));
    let mut f = *lengths;
    let (mut before, mut after) = ([0.0; LANES], [0.0; LANES]);
    for lane in 0..LANES {
        let d = [apart[0][lane], apart[1][lane], apart[2][lane]];
        let e = [next[0][lane], next[1][lane], next[2][lane]];
        let step = [e[0] - d[0], e[1] - d[1], e[2] - d[2]];
        let along = madd::<ISA>(d[0], step[0], madd::<ISA>(d[1], step[1], d[2] * step[2]));
        before[lane] = along / lengths[lane];
        let along = madd::<ISA>(e[0], step[0], madd::<ISA>(e[1], step[1], e[2] * step[2]));
        after[lane] = along / next_lengths[lane];
        f[lane] -= radius;
    }
    unproved::<ISA>(&f, &before, &after, bulge)
}

/// Places the balls of a part, unless this block has done so.
#[inline(always)]
fn place_balls<const ISA: u8>(certifier: &Certifier, work: &mut Work, index: usize) {
    if work.placed[index] {
        return;
    }
    work.placed[index] = true;
    let part = &certifier.arm.parts[index];
    let count = certifier.arm.parts.len();
    for ball in part.balls.clone() {
        let center = certifier.balls[ball].0;
        point::<ISA>(&work.frames[part.slot], center, &mut work.places[count + ball]);
    }
}
