//! On-policy imitation of exact paths (DAgger: Ross, Gordon and Bagnell 2011, arXiv:1011.0686), with a set of answers
//! for each task and a hinge on what still collides ([`super::loss`]).
//!
//! The policy walks trajectories of random tasks; at each step the target is the expert's trajectory nearest to the *present*
//! one, so that both sides of an obstacle do not average into it. Each task has four trajectories: one from the straight line,
//! one bent at random, two through random via-points.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use sidestep::network::{WaypointNet, WaypointScratch};
use sidestep::objective::Objective;
use sidestep::plan::starts::{StartStrategy, bend};
use sidestep::plane::view::{Look, TaskMap, ViewParts, WaypointView};
use sidestep::policy::ActionRule;
use sidestep::profile::Profile;
use sidestep::rng::{Purpose, stream};
use sidestep::scene::Scene;
use std::sync::Arc;

use super::loss::{Lesson, LossScratch};
use crate::routes::{Target, sparingly_grown};
use crate::waypoint::config::{ImitationConfig, TaskConfig};

/// Trajectories per task.
pub(crate) const MEMBERS: usize = 4;
/// Candidate tasks that a slot may draw in a unit; keeps the slots' tasks apart.
const TASKS_PER_SLOT: u64 = 1 << 24;
/// Failed tasks that a slot remembers.
const MOST_FAILED: usize = 32;

/// What the cases are made of, the same for all slots.
#[derive(Debug, Clone)]
pub(crate) struct Recipe {
    pub view: ViewParts,
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
    view: WaypointView,
    /// Whether it was free at any time of the task's life.
    solved: bool,
}

/// A task, its answers and the trajectories that walk on it.
#[derive(Debug, Clone)]
struct Case {
    task: u64,
    objective: Objective,
    map: Option<TaskMap>,
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
    d_output: Vec<[f32; 2]>,
}

/// What some tasks of an update add up to; parts are made in parallel and added up in order.
#[derive(Debug, Default)]
pub(crate) struct Part {
    pub gradient: Vec<f32>,
    pub sums: Sums,
}

impl Part {
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
    pub fn new(recipe: &Recipe, net: &WaypointNet, unit: u64, index: u64) -> Self {
        let mut rng = stream(recipe.seed, Purpose::Imitation, unit, index);
        let waypoints = recipe.tasks.draw_waypoints(&mut rng);
        let next_task = (unit * 1024 + index) * TASKS_PER_SLOT;
        let mut draws = Draws { rng, waypoints, next_task, failed: Vec::new() };
        Self {
            case: draws.draw(recipe, net),
            draws,
            scratch: WaypointScratch::default(),
            loss_scratch: LossScratch::default(),
            before: Vec::new(),
            d_output: Vec::new(),
        }
    }

    /// Steps every trajectory `steps` times with `net`, and adds the gradient of the summed loss to `part`.
    pub fn run(&mut self, net: &WaypointNet, recipe: &Recipe, steps: usize, part: &mut Part) {
        if let Some(map) = &mut self.case.map {
            net.read_map(map.scratch());
        }
        for _ in 0..steps {
            self.step(net, recipe, part);
        }
        self.case.learn_map(net, &mut part.gradient);
    }

    fn step(&mut self, net: &WaypointNet, recipe: &Recipe, part: &mut Part) {
        let Self { case, draws, scratch, loss_scratch, before, d_output } = self;
        let Part { gradient, sums } = part;
        let (waypoints, stride) = (draws.waypoints, net.input_stride());
        let input = scratch.input(MEMBERS * waypoints, stride);
        before.clear();
        for (member, rows) in
            case.members.iter_mut().zip(input.chunks_exact_mut(waypoints * stride))
        {
            let map = case.map.as_ref();
            member.view.encode(&case.objective, &member.x, map, rows, stride);
            if member.view.is_free() {
                member.solved = true;
                // From the straight line it would only walk the same way again.
                let kind = if member.kind == Kind::Straight { Kind::Bent } else { member.kind };
                begin(kind, &case.objective, &mut draws.rng, member);
                member.view.encode(&case.objective, &member.x, map, rows, stride);
            }
            before.extend_from_slice(&member.x);
        }
        net.forward(scratch, waypoints);
        d_output.clear();
        for (place, member) in case.members.iter_mut().enumerate() {
            let outputs = |i: usize| scratch.output(place * waypoints + i);
            member.view.apply(&recipe.rule, outputs, &mut member.x);
            let lesson = Lesson {
                objective: &case.objective,
                targets: &case.targets,
                along: member.view.along(),
                scale: recipe.rule.scale,
                hinge_weight: match KINDS[place] {
                    Kind::Straight => recipe.imitation.hinge_straight,
                    _ => recipe.imitation.hinge,
                },
            };
            let from = &before[place * 2 * waypoints..][..2 * waypoints];
            sums.loss += lesson.loss(from, &member.x, outputs, loss_scratch, d_output);
            sums.steps += 1.0;
            if draws.rng.random::<f32>() < recipe.imitation.kick_probability {
                bend(&mut member.x, recipe.imitation.kick, &mut draws.rng);
            }
        }
        // Long trajectories would outweigh the others.
        let share = Profile::DEFAULT.waypoints as f32 / waypoints as f32;
        d_output.iter_mut().flatten().for_each(|slope| *slope *= share);
        net.backward(d_output, scratch, gradient);
        if let Some(map) = &mut case.map {
            map.collect_rows(before, scratch.input_slopes(), stride, recipe.view.row_len());
        }
        case.left -= 1;
        if case.left == 0 {
            case.learn_map(net, gradient);
            let solved = case.members[0].solved;
            sums.ended += 1.0;
            sums.solved += f64::from(u8::from(solved));
            if !solved && draws.failed.len() < MOST_FAILED {
                draws.failed.push(case.task);
            }
            *case = draws.draw(recipe, net);
        }
    }
}

impl Case {
    /// Adds the gradient of what the map collected.
    fn learn_map(&mut self, net: &WaypointNet, gradient: &mut [f32]) {
        if let Some(map) = &mut self.map {
            net.map_backward(map.scratch(), gradient);
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
    fn draw(&mut self, recipe: &Recipe, net: &WaypointNet) -> Case {
        let settings = &recipe.imitation;
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
            let mut own = stream(recipe.seed, Purpose::Imitation, number, 1 << 40);
            let task = recipe.tasks.draw(number, &mut own);
            let scene = Arc::new(Scene::of(&task, &Profile::DEFAULT));
            let is_direct = scene.certifier().segment_is_free(task.start, task.goal);
            if is_direct && own.random::<f32>() >= recipe.tasks.direct {
                continue;
            }
            let Ok(objective) = Objective::new(&task, scene, self.waypoints) else { continue };
            let targets = sparingly_grown::targets(&task, &objective, &mut own);
            if targets.is_empty() {
                continue;
            }
            let members = KINDS.map(|kind| {
                let view = WaypointView::new(&recipe.view, &objective, Look::default());
                let x = vec![0.0; objective.dim()];
                let mut member = Member { kind, x, view, solved: false };
                begin(kind, &objective, &mut self.rng, &mut member);
                member
            });
            let long = self.rng.random::<f32>() < settings.long_share;
            let left = if long { settings.long_life } else { settings.life };
            let map = recipe.view.map.as_ref().map(|shape| {
                let mut map = TaskMap::new(&recipe.view, shape, &objective);
                net.begin_map(map.scratch());
                net.read_map(map.scratch());
                map
            });
            let members = members.into();
            return Case { task: number, objective, map, targets, members, left };
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
            bend(&mut member.x, size, rng);
        }
        Kind::Via => StartStrategy::ViaPoint.draw(objective, rng, &mut member.x),
    }
}
