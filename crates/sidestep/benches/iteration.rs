//! One optimizer iteration per task, in a batch on one core: the fast path beside its plain f64
//! twin, objective and gradient alone and with the feasibility check; and the learned optimizer of hidden
//! size 64 on one trajectory alone and on many in step.
//!
//! `cargo bench -p sidestep --bench iteration`
#![allow(missing_docs, clippy::unwrap_used, reason = "a benchmark")]

use std::sync::Arc;

use divan::counter::ItemsCount;
use sidestep::network::Scratch;
use sidestep::objective::Objective;
use sidestep::objective::reference;
use sidestep::optimizer::{Known, Method, Optimizer};
use sidestep::plane::view::TaskMap;
use sidestep::policy::observation::Encoder;
use sidestep::policy::{Policy, PolicyNetwork};
use sidestep::profile::Profile;
use sidestep::rng::{Purpose, stream};
use sidestep::scene::{Query, Scene};
use sidestep::suite::Suite;

fn main() {
    divan::main();
}

const TASKS: usize = 256;

struct Batch {
    objectives: Vec<Objective>,
    x: Vec<Vec<f32>>,
}

/// Tasks half-way through gradient descent.
fn batch(profile: &Profile) -> Batch {
    let tasks = Suite::Easy.generate(TASKS, 7, &Profile::PAPER);
    let mut batch = Batch { objectives: Vec::new(), x: Vec::new() };
    for task in &tasks {
        let mut objective = Objective::new(&Query::of(task, profile), 10).unwrap();
        let mut x = vec![0.0; 20];
        objective.straight_line(&mut x);
        for _ in 0..20 {
            step(&mut objective, profile, &mut x);
        }
        batch.objectives.push(objective);
        batch.x.push(x);
    }
    batch
}

fn step(objective: &mut Objective, profile: &Profile, x: &mut [f32]) {
    let mut gradient = [0.0; 20];
    objective.cost_and_gradient(x, &mut gradient);
    x.iter_mut().zip(&gradient).for_each(|(x, g)| *x -= profile.gradient_step as f32 * g);
}

fn profile(name: &str) -> Profile {
    name.parse::<Profile>().unwrap()
}

#[divan::bench(args = Profile::NAMES)]
fn gradient_descent(bencher: divan::Bencher, name: &str) {
    let profile = profile(name);
    let mut batch = batch(&profile);
    bencher.counter(ItemsCount::new(TASKS)).bench_local(|| {
        for (objective, x) in batch.objectives.iter_mut().zip(&mut batch.x) {
            step(objective, &profile, x);
        }
    });
}

#[divan::bench(args = Profile::NAMES)]
fn gradient_descent_with_check(bencher: divan::Bencher, name: &str) {
    let profile = profile(name);
    let mut batch = batch(&profile);
    bencher.counter(ItemsCount::new(TASKS)).bench_local(|| {
        let mut feasible = 0;
        for (objective, x) in batch.objectives.iter_mut().zip(&mut batch.x) {
            step(objective, &profile, x);
            feasible += usize::from(objective.is_feasible(x));
        }
        feasible
    });
}

/// The committed policy of Table I: hidden size 64, profile `paper`.
const POLICY: &[u8] = include_bytes!("../../../policies/paper-mlp-80k.safetensors");

/// Objective, gradient, observation, policy and update of one trajectory at a time, as planning does it.
#[divan::bench]
fn learned_alone(bencher: divan::Bencher) {
    let mut batch = batch(&Profile::PAPER);
    let method = Method::Learned(Arc::new(Policy::from_safetensors(POLICY).unwrap()));
    let mut optimizers: Vec<Optimizer> = batch
        .objectives
        .iter()
        .map(|objective| {
            let rng = stream(0, Purpose::Planner, 0, 0);
            Optimizer::new(&method, objective, rng).unwrap()
        })
        .collect();
    let mut gradient = [0.0; 20];
    bencher.counter(ItemsCount::new(TASKS)).bench_local(|| {
        let trajectories = batch.objectives.iter_mut().zip(&mut batch.x);
        for ((objective, x), optimizer) in trajectories.zip(&mut optimizers) {
            let cost = objective.cost_and_gradient(x, &mut gradient);
            optimizer.step(x, Known { cost, gradient: &gradient, free: &[] }, objective);
        }
    });
}

/// One step of the shipped policies: what they see, the network and the update, one trajectory at a time.
#[divan::bench(args = sidestep::policy::shipped::NAMES)]
fn shipped_alone(bencher: divan::Bencher, name: &str) {
    let mut batch = batch(&Profile::DEFAULT);
    let policy = if name == sidestep::policy::shipped::NAMES[0] {
        sidestep::policy::shipped::sidestep_1()
    } else {
        sidestep::policy::shipped::sidestep_1_small()
    };
    let mut optimizers: Vec<Optimizer> = batch
        .objectives
        .iter()
        .map(|objective| {
            let method = Method::Learned(policy.clone());
            Optimizer::new(&method, objective, stream(0, Purpose::Planner, 0, 0)).unwrap()
        })
        .collect();
    let mut free = [false; 11];
    let costs: Vec<_> = batch.objectives.iter_mut().zip(&batch.x).map(|(o, x)| o.cost(x)).collect();
    bencher.counter(ItemsCount::new(TASKS)).bench_local(|| {
        let trajectories = batch.objectives.iter_mut().zip(&mut batch.x).zip(&costs);
        for (((objective, x), cost), optimizer) in trajectories.zip(&mut optimizers) {
            objective.free_segments(x, &mut free);
            optimizer.step(x, Known { cost: *cost, gradient: &[], free: &free }, objective);
        }
    });
}

/// The map of a task, which `sidestep-1` reads once: distances, ways and convolutions.
#[divan::bench]
fn shipped_map(bencher: divan::Bencher) {
    let batch = batch(&Profile::DEFAULT);
    let policy = sidestep::policy::shipped::sidestep_1();
    let PolicyNetwork::Waypoint { view, network } = policy.network() else { return };
    let Some(shape) = &view.map else { return };
    bencher.counter(ItemsCount::new(TASKS)).bench_local(|| {
        for objective in &batch.objectives {
            network.read_map(
                divan::black_box(TaskMap::new(view, shape, objective.plane().unwrap())).scratch(),
            );
        }
    });
}

/// The perceptron for all tasks in step on one core: one product per layer for so many trajectories.
#[divan::bench(args = [64, 256])]
fn learned_in_a_batch(bencher: divan::Bencher, together: usize) {
    let mut batch = batch(&Profile::PAPER);
    let policy = Policy::from_safetensors(POLICY).unwrap();
    let PolicyNetwork::Whole { network, parts } = policy.network() else { unreachable!() };
    let mut encoders: Vec<Encoder> =
        batch.objectives.iter().map(|objective| Encoder::new(parts, objective).unwrap()).collect();
    let (mut gradient, mut scratch) = ([0.0; 20], Scratch::default());
    let mut observations = vec![0.0; 20 * together];
    bencher.counter(ItemsCount::new(TASKS)).bench_local(|| {
        let groups = batch.objectives.chunks_mut(together).zip(batch.x.chunks_mut(together));
        for ((objectives, xs), encoders) in groups.zip(encoders.chunks_mut(together)) {
            let rows = observations.chunks_exact_mut(20).zip(&mut *encoders);
            for ((objective, x), (row, encoder)) in objectives.iter_mut().zip(&*xs).zip(rows) {
                objective.cost_and_gradient(x, &mut gradient);
                encoder.encode(objective, x, &gradient, row);
            }
            network.forward_batch(&observations, &mut scratch);
            for (index, (objective, x)) in objectives.iter().zip(xs).enumerate() {
                let limits = objective.scene().normalised_limits();
                policy.card().action.apply(scratch.output(index), limits, x);
            }
        }
    });
}

#[divan::bench(args = Profile::NAMES)]
fn reference(bencher: divan::Bencher, name: &str) {
    let profile = profile(name);
    let batch = batch(&profile);
    bencher.counter(ItemsCount::new(TASKS)).bench_local(|| {
        let mut total = 0.0;
        for (objective, x) in batch.objectives.iter().zip(&batch.x) {
            let field = objective.plane().unwrap().scene.field();
            let cost_of = |p: &[f64]| {
                let (distance, gradient) = field.at([p[0] as f32, p[1] as f32]);
                let (cost, slope) = reference::clearance_cost(distance.into(), profile.epsilon);
                (cost, gradient.map(|g| slope * f64::from(g)).to_vec())
            };
            let (start, goal) = (objective.start(), objective.goal());
            total += reference::cost_and_gradient(cost_of, &profile, start, goal, x).0;
        }
        total
    });
}

#[divan::bench(args = Profile::NAMES)]
fn prepare_scene(bencher: divan::Bencher, name: &str) {
    let profile = profile(name);
    let tasks = Suite::Easy.generate(TASKS, 7, &Profile::PAPER);
    bencher.counter(ItemsCount::new(TASKS)).bench_local(|| {
        for task in &tasks {
            divan::black_box(Scene::of(task, &profile).plane().unwrap().field());
        }
    });
}
