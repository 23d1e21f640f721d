//! On-policy imitation of experts' routes (DAgger: Ross, Gordon and Bagnell 2011, arXiv:1011.0686),
//! with a set of answers for each task and a hinge on what still collides ([`super::loss`]).
//!
//! The policy walks trajectories of random tasks; at each step the target is the expert's
//! trajectory nearest to the *present* one, so that both sides of an obstacle do not average into
//! it. Each task has four trajectories: one from the straight line, one bent at random, two through
//! random via-points.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use sidestep::network::{WaypointNet, WaypointScratch};
use sidestep::objective::Objective;
use sidestep::plan::starts::StartStrategy;
use sidestep::policy::ActionRule;
use sidestep::profile::Profile;
use sidestep::rng::{Purpose, stream};
use sidestep::trajectory::waypoints::bend;

use super::loss::{Lesson, LossScratch, Made};
use crate::routes::Target;
use crate::waypoint::config::{ImitationConfig, TaskConfig};
use crate::waypoint::ready::Ready;
use crate::waypoint::sight::{Sight, View};

/// Tasks of an update that one thread takes together.
pub(crate) const TASKS_PER_PART: usize = 4;
/// Trajectories per task.
pub(crate) const MEMBERS: usize = 4;
/// Candidate tasks that a slot may draw in a unit; keeps the slots' tasks apart.
const TASKS_PER_SLOT: u64 = 1 << 24;
/// Failed tasks that a slot remembers.
const MOST_FAILED: usize = 32;

/// What the cases are made of, the same for all slots.
#[derive(Debug, Clone)]
pub(crate) struct Ingredients {
    pub sight: Sight,
    pub rule: ActionRule,
    pub tasks: TaskConfig,
    pub imitation: ImitationConfig,
    pub seed: u64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    Straight,
    Bent,
    Via,
}

const KINDS: [Kind; MEMBERS] = [Kind::Straight, Kind::Bent, Kind::Via, Kind::Via];

#[derive(Debug, Clone)]
struct Member {
    kind: Kind,
    x: Vec<f32>,
    view: View,
    /// Whether it was free at any time of the task's life.
    solved: bool,
}

/// A task, its answers and the trajectories that walk on it.
#[derive(Debug, Clone)]
struct Case {
    task: u64,
    ready: Ready,
    targets: Vec<Target>,
    members: Vec<Member>,
    /// Steps until another task takes its place.
    left: u32,
}

/// A place for one case after the other, with its buffers.
#[derive(Debug)]
pub(crate) struct Slot {
    case: Case,
    draws: Draws,
    scratch: WaypointScratch,
    loss_scratch: LossScratch,
    before: Vec<f32>,
    free: Vec<bool>,
    outputs: Vec<f32>,
    d_output: Vec<f32>,
}

/// What some tasks of an update add up to; parts are made in parallel and added up in order.
#[derive(Debug, Default)]
pub(crate) struct Part {
    pub gradient: Vec<f32>,
    pub sums: Sums,
}

impl Part {
    /// The parts of an update of so many tasks.
    pub fn for_tasks(tasks: usize) -> Vec<Self> {
        std::iter::repeat_with(Self::default).take(tasks.div_ceil(TASKS_PER_PART)).collect()
    }

    /// Nothing yet, for a network of so many parameters.
    pub fn clear(&mut self, parameters: usize) {
        self.gradient.clear();
        self.gradient.resize(parameters, 0.0);
        self.sums = Sums::default();
    }
}

/// Sums over the steps of an update.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Sums {
    /// Trajectory steps.
    pub steps: f64,
    /// Loss.
    pub loss: f64,
    /// Cases that ended, and those whose first trajectory was solved.
    pub ended: f64,
    pub solved: f64,
}

impl Slot {
    /// Slot `index` at the start of unit `unit` of the training.
    pub fn new(ingredients: &Ingredients, net: &WaypointNet, unit: u64, index: u64) -> Self {
        let mut rng = stream(ingredients.seed, Purpose::Imitation, unit, index);
        let waypoints = ingredients.tasks.draw_waypoints(&mut rng);
        let next_task = (unit * 1024 + index) * TASKS_PER_SLOT;
        let mut draws = Draws { rng, waypoints, next_task, failed: Vec::new() };
        Self {
            case: draws.draw(ingredients, net),
            draws,
            scratch: WaypointScratch::default(),
            loss_scratch: LossScratch::default(),
            before: Vec::new(),
            free: vec![false; waypoints + 1],
            outputs: Vec::new(),
            d_output: Vec::new(),
        }
    }

    /// Steps every trajectory `steps` times with `net`, and adds the gradient of the summed loss to
    /// `part`.
    pub fn run(
        &mut self,
        net: &WaypointNet,
        ingredients: &Ingredients,
        steps: usize,
        part: &mut Part,
    ) {
        self.case.ready.read_map(net);
        for _ in 0..steps {
            self.step(net, ingredients, part);
        }
        self.case.ready.learn_map(net, &mut part.gradient);
    }

    fn step(&mut self, net: &WaypointNet, ingredients: &Ingredients, part: &mut Part) {
        let Self { case, draws, scratch, loss_scratch, before, free, outputs, d_output } = self;
        let Part { gradient, sums } = part;
        let (waypoints, stride) = (draws.waypoints, net.input_stride());
        let input = scratch.input(MEMBERS * waypoints, stride);
        before.clear();
        for (member, rows) in
            case.members.iter_mut().zip(input.chunks_exact_mut(waypoints * stride))
        {
            if case.ready.is_free(&member.x, free) {
                member.solved = true;
                // From the straight line it would only walk the same way again.
                let kind = if member.kind == Kind::Straight { Kind::Bent } else { member.kind };
                begin(kind, &case.ready.objective, &mut draws.rng, member);
                case.ready.is_free(&member.x, free);
            }
            case.ready.see(&mut member.view, &member.x, free, rows, stride);
            before.extend_from_slice(&member.x);
        }
        net.forward(scratch, waypoints);
        d_output.clear();
        for (place, member) in case.members.iter_mut().enumerate() {
            let objective = &case.ready.objective;
            scratch.outputs(place * waypoints..(place + 1) * waypoints, outputs);
            member.view.apply(objective, &ingredients.rule, outputs, &mut member.x);
            let lesson = Lesson {
                objective,
                targets: &case.targets,
                along: member.view.along(),
                scale: ingredients.rule.scale,
                hinge_weight: match KINDS[place] {
                    Kind::Straight => ingredients.imitation.hinge_straight,
                    _ => ingredients.imitation.hinge,
                },
            };
            let before = &before[place * member.x.len()..][..member.x.len()];
            let base = member.view.base();
            let made = Made { before, after: &member.x, outputs, base };
            sums.loss += lesson.loss(made, loss_scratch, d_output);
            sums.steps += 1.0;
            if draws.rng.random::<f32>() < ingredients.imitation.kick_probability {
                bend(objective.dof(), &mut member.x, ingredients.imitation.kick, &mut draws.rng);
            }
        }
        // Long trajectories would outweigh the others.
        let share = Profile::DEFAULT.waypoints as f32 / waypoints as f32;
        d_output.iter_mut().for_each(|slope| *slope *= share);
        net.backward(d_output, scratch, gradient);
        if let Some(map) = case.ready.map() {
            map.collect_rows(before, scratch.input_slopes(), stride, ingredients.sight.row_len());
        }
        case.left -= 1;
        if case.left == 0 {
            case.ready.learn_map(net, gradient);
            let solved = case.members[0].solved;
            sums.ended += 1.0;
            sums.solved += f64::from(u8::from(solved));
            if !solved && draws.failed.len() < MOST_FAILED {
                draws.failed.push(case.task);
            }
            *case = draws.draw(ingredients, net);
        }
    }
}

/// Where a slot's cases come from.
#[derive(Debug)]
struct Draws {
    rng: ChaCha8Rng,
    waypoints: usize,
    next_task: u64,
    failed: Vec<u64>,
}

impl Draws {
    /// A new case: a failed task again, or a fresh one that has an answer.
    fn draw(&mut self, ingredients: &Ingredients, net: &WaypointNet) -> Case {
        let settings = &ingredients.imitation;
        loop {
            let again = self.rng.random::<f32>() < settings.retry && !self.failed.is_empty();
            let number = if again {
                let which = self.rng.random_range(0..self.failed.len());
                self.failed.swap_remove(which)
            } else {
                self.next_task += 1;
                self.next_task
            };
            // What a number stands for must not depend on when it is drawn.
            let mut own = stream(ingredients.seed, Purpose::Imitation, number, 1 << 40);
            let Some(task) = ingredients.tasks.draw(&ingredients.sight, number, &mut own) else {
                continue;
            };
            let query = Ready::query(&task);
            let is_direct = query.scene().motion_is_free(query.start(), query.goal());
            if is_direct && own.random::<f32>() >= ingredients.tasks.direct {
                continue;
            }
            let Ok(objective) = Objective::new(&query, self.waypoints) else { continue };
            let Some(mut ready) = Ready::new(&ingredients.sight, objective) else { continue };
            let targets = ready.targets(&task, &mut own);
            if targets.is_empty() {
                continue;
            }
            let Some(view) = ready.view(&ingredients.sight) else { continue };
            let members = KINDS.map(|kind| {
                let (x, view) = (vec![0.0; ready.objective.dim()], view.clone());
                let mut member = Member { kind, x, view, solved: false };
                begin(kind, &ready.objective, &mut self.rng, &mut member);
                member
            });
            let long = self.rng.random::<f32>() < settings.long_share;
            let left = if long { settings.long_life } else { settings.life };
            ready.begin_map(net);
            let members = members.into();
            return Case { task: number, ready, targets, members, left };
        }
    }
}

/// Puts a member at the start of a walk.
fn begin(kind: Kind, objective: &Objective, rng: &mut ChaCha8Rng, member: &mut Member) {
    member.kind = kind;
    member.view.reset();
    match kind {
        Kind::Straight => objective.straight_line(&mut member.x),
        Kind::Bent => {
            objective.straight_line(&mut member.x);
            let size = rng.random_range(0.2..1.5);
            bend(objective.dof(), &mut member.x, size, rng);
        }
        Kind::Via => StartStrategy::ViaPoint.draw(objective, rng, &mut member.x),
    }
}
