//! Proofs that motions are free: the straight line between two configurations, as a whole.
//!
//! A motion q(t) = a + t D is cut into intervals; `block.rs` proves fifteen of them at once or finds a configuration
//! that is not free; what it leaves open is cut again. So a motion is *free* by proof, *blocked* by a witness,
//! or *undecided* when its intervals have become so short that nothing moves farther than [`RESOLUTION`];
//! undecided counts as not free. Limits need no proof of their own: what lies between two
//! configurations within them is within them.
//!
//! F. Schwarzer, M. Saha and J.-C. Latombe, Adaptive dynamic collision checking for single and multiple
//! articulated robots in complex environments, IEEE T-RO 2005, doi:10.1109/TRO.2004.838012, bisect
//! by the first-order bound (distance against travel); the second-order one here needs intervals as long as the
//! square root of the clearance allows, so some thirty configurations a plan instead of two hundred.
//!
//! **Rounding.** Everything is evaluated in f32. A place is off by at most the kinematics' rounding, a
//! distance by at most the world's `block_error`; the tangents' slopes are those of a convex function at a place that
//! near, rounded by 16 u. Their sum is added to every radius as *slack* (some 30 um at a reach of 1 m).

mod block;

use std::sync::Arc;

use super::kinematics::Program;
use super::reach::Reach;
use super::robot::Arm;
use super::spheres::Part;
use super::surroundings::Surroundings;
use crate::kernels::{Isa, LANES};
use crate::space::World;
use crate::space::vector::{norm, sub};

pub use block::Work;
use block::{Contact, Outcome, prove};

/// When no ball moves farther than this within an interval, in metres, it is not cut again.
pub const RESOLUTION: f64 = 1e-6;

/// Most blocks that one motion may take.
const MOST_BLOCKS: usize = 4096;

/// An arm in a world, ready to judge motions.
#[derive(Debug, Clone)]
pub struct Certifier {
    pub(super) arm: Arc<Arm>,
    pub(super) world: Arc<World>,
    pub(super) surroundings: Surroundings,
    pub(super) program: Program,
    reach: Reach,
    /// Centre and radius of the ball around each part, f32.
    pub(super) around: Vec<([f32; 3], f32)>,
    /// Centre and radius of each ball, f32; radii rounded up.
    pub(super) balls: Vec<([f32; 3], f32)>,
    /// How far the centre of each ball is from that of the ball around its part, metres, rounded up.
    offsets: Vec<f32>,
    /// The first part that moves.
    pub(super) first_moving: usize,
    /// For each piece of the world what is added to every radius.
    slack: Vec<f32>,
    most_slack: f32,
    self_slack: f32,
    /// What the part of the body that never moves touches.
    stuck: Option<Hit>,
}

/// Something that is not free.
#[derive(Debug, Clone, PartialEq)]
pub struct Hit {
    /// The link of the body.
    pub link: String,
    /// What it meets.
    pub with: Met,
    /// Where on the motion, from 0 to 1.
    pub t: f64,
    /// The configuration there.
    pub configuration: Vec<f64>,
    /// How deep the two are in each other there, in metres, f64; below zero by less than the arm's margin where an object
    /// is only nearer than that.
    pub depth: f64,
}

/// What a link meets.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Met {
    /// An object of the world, by name.
    Object(String),
    /// Another link, by name.
    Link(String),
}

/// What is known of a motion.
#[derive(Debug, Clone, PartialEq)]
pub enum Verdict {
    /// Proved free.
    Free,
    /// Not free: where and why.
    Blocked(Hit),
    /// Neither, within [`RESOLUTION`] of this t: too near to touching.
    Undecided(f64),
}

/// An interval of t.
#[derive(Debug, Clone, Copy)]
pub(super) struct Interval {
    start: f64,
    width: f64,
}

/// What a motion came to, without words.
enum Found {
    Free,
    Blocked(f64, Contact),
    Undecided(f64),
}

impl Certifier {
    /// Prepares an arm in a world. The world's frame is that of the arm's root link.
    pub fn new(arm: Arc<Arm>, world: Arc<World>) -> Self {
        const U: f64 = 1.0 / (1 << 24) as f64;
        let program = Program::new(&arm);
        let reach = arm.reach();
        let own = program.rounding + 32.0 * U * reach;
        let margin = arm.margin();
        let slack = |piece: usize| margin + 2.0 * own + world.block_error(piece as u32, reach);
        let slack: Vec<f32> = (0..world.pieces()).map(|piece| up(slack(piece))).collect();
        let narrow = |center: [f64; 3], radius: f64| (center.map(|v| v as f32), up(radius));
        let offsets = |part: &Part| -> Vec<f32> {
            let balls = arm.balls[part.balls.clone()].iter();
            balls.map(|ball| up(norm(sub(ball.center, part.around.center)))).collect()
        };
        let mut certifier = Self {
            surroundings: Surroundings::new(Arc::clone(&world)),
            reach: Reach::new(&arm),
            around: arm.parts.iter().map(|p| narrow(p.around.center, p.around.radius)).collect(),
            balls: arm.balls.iter().map(|ball| narrow(ball.center, ball.radius)).collect(),
            first_moving: arm.parts.iter().take_while(|part| part.slot == 0).count(),
            offsets: arm.parts.iter().flat_map(offsets).collect(),
            most_slack: slack.iter().copied().fold(0.0, f32::max),
            slack,
            self_slack: up(4.0 * own),
            stuck: None,
            program,
            arm,
            world,
        };
        certifier.stuck = certifier.stuck();
        certifier
    }

    /// The arm.
    pub fn arm(&self) -> &Arc<Arm> {
        &self.arm
    }

    /// How far balls can be from the joints' axes.
    pub(super) fn reach(&self) -> &Reach {
        &self.reach
    }

    /// The world.
    pub fn world(&self) -> &Arc<World> {
        &self.world
    }

    /// Buffers for proofs of this certifier.
    pub fn work(&self) -> Work {
        Work::new(self)
    }

    /// Whether the motion from one configuration straight to another is proved free.
    ///
    /// Both have [`Arm::dof`] numbers within the limits.
    pub fn motion_is_free(&self, from: &[f64], to: &[f64], work: &mut Work) -> bool {
        matches!(self.search(from, to, work), Found::Free)
    }

    /// What is known of a motion, with a witness in words if it is not free.
    ///
    /// Both have [`Arm::dof`] numbers within the limits.
    pub fn judge(&self, from: &[f64], to: &[f64], work: &mut Work) -> Verdict {
        if let Some(hit) = &self.stuck {
            return Verdict::Blocked(Hit { configuration: from.to_vec(), ..hit.clone() });
        }
        match self.search(from, to, work) {
            Found::Free => Verdict::Free,
            Found::Undecided(t) => Verdict::Undecided(t),
            Found::Blocked(t, contact) => {
                let hit = self.hit(from, to, t, contact);
                let apart = match contact {
                    Contact::Piece { .. } => self.arm.margin(),
                    Contact::Balls(..) => 0.0,
                };
                // In f32 and with the slack it was not clear; in f64 it may be, by a hair.
                if hit.depth > -apart { Verdict::Blocked(hit) } else { Verdict::Undecided(t) }
            }
        }
    }

    /// Proves, refutes or gives up.
    fn search(&self, from: &[f64], to: &[f64], work: &mut Work) -> Found {
        if self.stuck.is_some() {
            return Found::Undecided(0.0);
        }
        let isa = Isa::detect();
        for ((delta, &a), &b) in work.delta.iter_mut().zip(from).zip(to) {
            *delta = b - a;
        }
        work.from.copy_from_slice(from);
        let Work { delta, turned, weights, bulges, .. } = &mut *work;
        let speed = self.reach.bulges(isa, delta, turned, weights, bulges);
        if !speed.is_finite() {
            return Found::Undecided(0.0);
        }
        work.open.clear();
        work.open.push(Interval { start: 0.0, width: 1.0 });
        for _ in 0..MOST_BLOCKS {
            let Some(&Interval { start, width }) = work.open.last() else { return Found::Free };
            if width < 1.0 && width * speed < RESOLUTION {
                return Found::Undecided(start);
            }
            // As many open intervals of one width as a block can take, each cut into as many pieces as it can hold.
            let alike = work.open.iter().rev().take_while(|open| open.width == width).count();
            let together = alike.min(LANES / 3);
            let pieces = LANES / together - 1;
            let narrow = width / pieces as f64;
            let times = &mut work.times;
            let mut intervals = 0;
            work.begins = [0.0; LANES];
            for k in 0..together {
                let Some(open) = work.open.pop() else { break };
                for piece in 0..=pieces {
                    let lane = k * (pieces + 1) + piece;
                    let last = piece == pieces;
                    times[lane] = open.start + if last { width } else { narrow * piece as f64 };
                    intervals |= u32::from(!last) << lane;
                    work.begins[lane] = if last { 0.0 } else { 1.0 };
                }
            }
            let used = together * (pieces + 1);
            let last = times[used - 1];
            times[used..].fill(last);
            match prove(isa, self, work, up(narrow * (1.0 + 1e-9)), intervals) {
                Outcome::Blocked { lane, contact } => {
                    return Found::Blocked(work.times[lane], contact);
                }
                Outcome::Open(bits) => {
                    for lane in 0..LANES {
                        if bits >> lane & 1 == 1 {
                            work.open.push(Interval { start: work.times[lane], width: narrow });
                        }
                    }
                }
            }
        }
        Found::Undecided(work.open.last().map_or(1.0, |open| open.start))
    }

    /// A contact in words, measured in f64.
    fn hit(&self, from: &[f64], to: &[f64], t: f64, contact: Contact) -> Hit {
        let configuration: Vec<f64> = from.iter().zip(to).map(|(a, b)| a + t * (b - a)).collect();
        let balls = self.arm.balls_at(&configuration);
        let name = |ball: usize| self.arm.link_of_ball(ball).to_string();
        let (link, with, depth) = match contact {
            Contact::Piece { ball, piece } => {
                // Of the link's balls the one that is deepest.
                let part = self.arm.parts.iter().find(|part| part.balls.contains(&ball));
                let deep = |ball: usize| {
                    balls[ball].radius - self.world.distance(piece, balls[ball].center).0
                };
                let range = part.map_or(ball..ball + 1, |part| part.balls.clone());
                let depth = range.map(deep).fold(deep(ball), f64::max);
                (name(ball), Met::Object(self.world.name_of(piece).to_string()), depth)
            }
            Contact::Balls(a, b) => {
                let distance = norm(sub(balls[a].center, balls[b].center));
                let with = Met::Link(name(b));
                (name(a), with, balls[a].radius + balls[b].radius - distance)
            }
        };
        Hit { link, with, t, configuration, depth }
    }

    /// What the parts that never move touch, in f64.
    fn stuck(&self) -> Option<Hit> {
        let mut near = Vec::new();
        for part in &self.arm.parts[..self.first_moving] {
            for ball in &self.arm.balls[part.balls.clone()] {
                let radius = ball.radius + self.arm.margin();
                self.world.near(ball.center, radius, &mut near);
                for &piece in &near {
                    let (distance, _) = self.world.distance(piece, ball.center);
                    if distance <= radius {
                        let with = Met::Object(self.world.name_of(piece).to_string());
                        let depth = ball.radius - distance;
                        let link = part.name.clone();
                        return Some(Hit { link, with, t: 0.0, configuration: Vec::new(), depth });
                    }
                }
            }
        }
        None
    }
}

/// The least f32 that is not below a positive number, or the next.
fn up(value: f64) -> f32 {
    (value as f32).next_up()
}
