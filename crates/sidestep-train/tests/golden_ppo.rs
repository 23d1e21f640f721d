//! Golden values by PyTorch's automatic differentiation in f64 (`oracle/ppo.py`): advantages,
//! networks, the Gaussian, whole PPO updates with every gradient, Adam, Adadelta and cloning.
//!
//! This code computes in f32: values agree to 2e-6 of their size plus 2e-6, and parameters after a
//! step to 2e-7.
#![allow(clippy::unwrap_used, reason = "helpers of tests; a malformed golden file is a failure")]

use serde_json::Value;
use sidestep::network::{Mlp, Network, Scratch};
use sidestep_train::paper::agent::{Agent, Gradient};
use sidestep_train::paper::gaussian;
use sidestep_train::paper::stages::cloning::{self, Samples};
use sidestep_train::paper::stages::ppo::advantage::{Steps, generalised_advantages};
use sidestep_train::paper::stages::ppo::{Minibatch, PpoConfig, loss_and_gradient};
use sidestep_train::parameters::{Optimizer, OptimizerKind, clip_factor};

fn golden() -> Value {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../oracle/golden/ppo.json");
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

/// All numbers of a value, in order, however nested.
fn flat(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(items) => items.iter().flat_map(flat).collect(),
        other => vec![other.as_f64().unwrap()],
    }
}

fn singles(value: &Value) -> Vec<f32> {
    flat(value).into_iter().map(|x| x as f32).collect()
}

/// Weight and bias of each layer in order, as the flat vector of a network holds them.
fn layers(value: &Value) -> Vec<f64> {
    let layers = value.as_array().unwrap();
    layers
        .iter()
        .flat_map(|layer| [flat(&layer["weight"]), flat(&layer["bias"])].concat())
        .collect()
}

/// Policy, value (zeros where the file has none) and log-std, as the flat vector of an agent holds
/// them.
fn parameters(value: &Value, value_count: usize) -> Vec<f64> {
    let critic = value.get("value").map_or_else(|| vec![0.0; value_count], layers);
    [layers(&value["policy"]), critic, flat(&value["log_std"])].concat()
}

fn network(value: &Value) -> Mlp {
    let sizes: Vec<usize> = std::iter::once(value[0]["weight"][0].as_array().unwrap().len())
        .chain(
            value.as_array().unwrap().iter().map(|layer| layer["bias"].as_array().unwrap().len()),
        )
        .collect();
    Mlp::new(&sizes, layers(value).into_iter().map(|x| x as f32).collect()).unwrap()
}

fn agent(value: &Value) -> Agent {
    let policy = network(&value["policy"]);
    let value_network = match value.get("value") {
        Some(layers) => network(layers),
        None => Mlp::new(&[policy.inputs(), 1], vec![0.0; policy.inputs() + 1]).unwrap(),
    };
    Agent { policy: policy.into(), value: value_network, log_std: singles(&value["log_std"]) }
}

fn all_parameters(agent: &Agent) -> Vec<f32> {
    [agent.policy.parameters(), agent.value.parameters(), &agent.log_std].concat()
}

#[track_caller]
fn check(what: &str, got: &[f32], expected: &[f64], tolerance: f64) {
    assert_eq!(got.len(), expected.len(), "{what}");
    for (index, (&got, &want)) in got.iter().zip(expected).enumerate() {
        let error = (f64::from(got) - want).abs();
        assert!(error <= tolerance * (1.0 + want.abs()), "{what}[{index}]: {got} is not {want}");
    }
}

#[test]
fn advantages() {
    for case in golden()["advantages"].as_array().unwrap() {
        let (steps, envs) = (6, 3);
        let column = |name: &str, env: usize| -> Vec<f32> {
            singles(&case[name]).into_iter().skip(env).step_by(envs).collect()
        };
        for env in 0..envs {
            let dones: Vec<bool> = case["dones"]
                .as_array()
                .unwrap()
                .iter()
                .map(|row| row[env].as_bool().unwrap())
                .collect();
            let (rewards, values) = (column("rewards", env), column("values", env));
            let last_value = singles(&case["last_values"])[env];
            let (mut advantages, mut returns) = (vec![0.0; steps], vec![0.0; steps]);
            let input = Steps { rewards: &rewards, values: &values, dones: &dones, last_value };
            let (gamma, lambda) = (singles(&case["gamma"])[0], singles(&case["lambda"])[0]);
            generalised_advantages(input, gamma, lambda, &mut advantages, &mut returns);
            let expected = |name: &str| -> Vec<f64> {
                flat(&case[name]).into_iter().skip(env).step_by(envs).collect()
            };
            check("advantages", &advantages, &expected("advantages"), 2e-6);
            check("returns", &returns, &expected("returns"), 2e-6);
        }
    }
}

#[test]
fn networks_and_gaussian() {
    let golden = golden();
    let case = &golden["network"];
    let agent = agent(&case["parameters"]);
    let mut scratch = Scratch::default();
    let mut outputs = |network: &Network| -> Vec<f32> {
        network.forward_batch(&singles(&case["inputs"]), &mut scratch);
        (0..scratch.rows()).flat_map(|row| scratch.output(row).to_vec()).collect()
    };
    let means = outputs(&agent.policy);
    check("policy", &means, &flat(&case["policy_outputs"]), 2e-6);
    check("value", &outputs(&agent.value.clone().into()), &flat(&case["value_outputs"]), 2e-6);
    let actions = singles(&case["actions"]);
    let density = gaussian::Density::new(&agent.log_std);
    let rows = actions.chunks(4).zip(means.chunks(4));
    let log_probs: Vec<f32> = rows.map(|(a, m)| density.log_prob(a, m)).collect();
    check("log prob", &log_probs, &flat(&case["log_probs"]), 2e-6);
    let entropies = vec![gaussian::entropy(&agent.log_std); 5];
    check("entropy", &entropies, &flat(&case["entropies"]), 2e-6);
}

#[test]
fn ppo_updates() {
    for case in golden()["updates"].as_array().unwrap() {
        let name = case["name"].as_str().unwrap();
        let mut agent = agent(&case["parameters"]);
        let batch = Minibatch {
            observations: singles(&case["observations"]),
            actions: singles(&case["actions"]),
            old_log_probs: singles(&case["old_log_probs"]),
            advantages: singles(&case["advantages"]),
            returns: singles(&case["returns"]),
        };
        let entropy = singles(&case["entropy_coefficient"])[0];
        let config = PpoConfig { entropy, ..PpoConfig::default() };
        let mut optimizer = Optimizer::new(OptimizerKind::Adam, agent.parameter_count());
        let mut gradient = Gradient::default();
        for (index, step) in case["steps"].as_array().unwrap().iter().enumerate() {
            let losses = loss_and_gradient(&agent, &batch, &config, &mut gradient);
            let found = [
                ("loss", losses.total),
                ("policy_loss", losses.policy),
                ("value_loss", losses.value),
                ("entropy", losses.entropy),
                ("approx_kl", losses.approx_kl),
                ("clip_fraction", losses.clip_fraction),
            ];
            for (key, value) in found {
                check(&format!("{name} {index} {key}"), &[value as f32], &flat(&step[key]), 2e-6);
            }
            let expected = parameters(&step["gradient"], 0);
            check(&format!("{name} {index} gradient"), gradient.values(), &expected, 2e-6);
            let norm = gradient.values().iter().map(|g| g * g).sum::<f32>().sqrt();
            check(&format!("{name} {index} norm"), &[norm], &flat(&step["gradient_norm"]), 2e-6);
            let scale = clip_factor(norm, config.max_gradient_norm);
            let clipped: Vec<f32> = gradient.values().iter().map(|g| g * scale).collect();
            check(name, &clipped, &parameters(&step["clipped_gradient"], 0), 2e-6);
            agent.step(&mut optimizer, 3e-4, scale, gradient.values());
            let after = parameters(&step["parameters_after"], 0);
            check(&format!("{name} {index} after"), &all_parameters(&agent), &after, 2e-7);
        }
    }
}

#[test]
fn optimizers() {
    let golden = golden();
    for (key, kind) in [("adam", OptimizerKind::Adam), ("adadelta", OptimizerKind::Adadelta)] {
        let case = &golden[key];
        let mut parameters = singles(&case["parameters"]);
        let mut optimizer = Optimizer::new(kind, parameters.len());
        let learning_rate = case["learning_rate"].as_f64().unwrap();
        for step in 0..2 {
            let gradient = singles(&case["gradients"][step]);
            optimizer.step(learning_rate, 1.0, &gradient, &mut [&mut parameters]);
            check(key, &parameters, &flat(&case["parameters_after"][step]), 2e-7);
        }
    }
}

#[test]
fn cloning_losses() {
    for case in golden()["cloning"].as_array().unwrap() {
        let agent = agent(&case["parameters"]);
        let batch =
            Samples { observations: singles(&case["inputs"]), targets: singles(&case["targets"]) };
        let noise = match case["name"].as_str().unwrap() {
            "mean" => Vec::new(),
            _ => singles(&case["noise"]),
        };
        let mut gradient = Gradient::default();
        let loss = cloning::loss_and_gradient(&agent, &batch, &noise, &mut gradient);
        check("loss", &[loss as f32], &flat(&case["loss"]), 2e-6);
        let expected = parameters(&case["gradient"], agent.value.parameters().len());
        check("gradient", gradient.values(), &expected, 2e-6);
    }
}
