//! What a policy says that it sees and answers is what planning with it does.
#![allow(clippy::unwrap_used, reason = "a test")]

use sidestep::objective::Objective;
use sidestep::optimizer::{Known, Method, Optimizer};
use sidestep::policy::{PolicyNetwork, shipped};
use sidestep::rng::{Purpose, stream};
use sidestep::{Policy, Profile, Query, Suite};

fn read(name: &str) -> Policy {
    let path = format!("{}/../../policies/{name}", env!("CARGO_MANIFEST_DIR"));
    Policy::from_safetensors(&std::fs::read(path).unwrap()).unwrap()
}

#[test]
fn an_answer_moves_the_waypoints_as_planning_does() {
    for policy in [
        (*shipped::sidestep_1()).clone(),
        (*shipped::sidestep_1_small()).clone(),
        read("paper-mlp-80k.safetensors"),
        read("picture.safetensors"),
    ] {
        let profile = policy.fixed_profile().unwrap_or("default").parse::<Profile>().unwrap();
        let waypoints = policy.fixed_waypoints().unwrap_or(7);
        let policy = std::sync::Arc::new(policy);
        for task in Suite::Hard.generate(20, 11, &profile) {
            let query = Query::of(&task, &profile);
            let mut objective = Objective::new(&query, waypoints).unwrap();
            let mut x = vec![0.0; objective.dim()];
            objective.straight_line(&mut x);
            // Off the line, so that nothing is zero by symmetry.
            x.iter_mut().enumerate().for_each(|(i, x)| *x += 0.1 * (i as f32).sin());
            let limits = objective.scene().normalised_limits().to_vec();
            let room = |x: &[f32]| {
                let inside = |(x, [least, most]): (&f32, &[f32; 2])| x > least && x < most;
                x.iter().zip(limits.iter().cycle()).all(inside)
            };
            let seen = policy.look(&mut objective, &x).unwrap();
            let is_flat = matches!(policy.network(), PolicyNetwork::Whole { .. });
            let (start, goal) = (objective.start(), objective.goal());
            let (dx, dy) = (goal[0] - start[0], goal[1] - start[1]);
            let [c, s] = [dx / dx.hypot(dy), dy / dx.hypot(dy)];
            let mut expected = x.clone();
            for (p, u) in expected.chunks_exact_mut(2).zip(seen.update.chunks_exact(2)) {
                let by =
                    if is_flat { [u[0], u[1]] } else { [c * u[0] - s * u[1], s * u[0] + c * u[1]] };
                p.iter_mut().zip(by).for_each(|(p, by)| *p += by);
            }
            let (mut gradient, mut free) = (vec![0.0; x.len()], vec![false; waypoints + 1]);
            let cost = objective.cost_and_gradient(&x, &mut gradient);
            objective.free_segments(&x, &mut free);
            let method = Method::Learned(policy.clone());
            let rng = stream(1, Purpose::Environment, 0, 0);
            let mut optimizer = Optimizer::new(&method, &objective, rng).unwrap();
            let known = Known { cost, gradient: &gradient, free: &free };
            optimizer.step(&mut x, known, &mut objective);
            if room(&expected) {
                let far = x.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                assert!(far < 1e-5, "{}: {far}", policy.card().architecture);
            }
        }
    }
}

#[test]
fn a_policy_is_its_card_and_its_tensors() {
    let policy = shipped::sidestep_1();
    let card = serde_json::to_value(policy.card()).unwrap();
    assert_eq!(Policy::from_tensors(&card, &policy.tensors()).unwrap(), *policy);
    let error = Policy::from_tensors(&card, &policy.tensors()[1..]).unwrap_err().to_string();
    assert!(error.contains("missing tensor"), "{error}");
}
