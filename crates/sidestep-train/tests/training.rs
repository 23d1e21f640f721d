//! Whole trainings, small: they learn, they resume to the same bits, threads change nothing, damage
//! is refused.
#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use std::ops::ControlFlow;
use std::sync::Arc;

use sidestep::objective::Objective;
use sidestep::optimizer::{Method, Optimizer};
use sidestep::plan::run::{Until, run};
use sidestep::policy::observation::OwnPart;
use sidestep::policy::tensors;
use sidestep::policy::{Policy, PolicyNetwork};
use sidestep::profile::Profile;
use sidestep::rng::{Purpose, stream};
use sidestep::scene::Query;
use sidestep::suite::Suite;
use sidestep_train::training::Units;
use sidestep_train::{Recipe, TrainConfig, Trainer};

/// Seconds of work at most: 2 epochs of cloning, 3 rounds of DAgger, 4 updates with repair, and
/// every kind of state.
const SMALL: &str = r#"
    seed = 5
    environment_steps = 190
    observation = ["gradient", "previous-gradients:2", "obstacle-cost"]
    network.hidden = 24
    training = { suite = "mix", count = 8, seed = 1000 }
    environment.episode_limit = 7
    cloning = { epochs = 2, samples_per_task = 12 }
    ppo = { environments = 6, steps = 8, minibatch = 20, epochs = 3, initial_log_std = -1.0, schedule = "cosine" }
    validation = { count = 12, every = 2, steps = 30 }
    dagger = { rounds = 3, expert = "shortest-path", rollouts = 8, steps = 6, capacity = 60, minibatches = 7, minibatch = 16 }
    repair = { expert = "shortest-path", after = 3 }
"#;

/// The same for an image agent.
fn small_image() -> String {
    SMALL
        .replace(
            r#"["gradient", "previous-gradients:2", "obstacle-cost"]"#,
            r#"["ends", "image", "gradient"]"#,
        )
        .replace("environments = 6, steps = 8", "environments = 3, steps = 6")
        .replace("environment_steps = 190", "environment_steps = 70")
        .replace("count = 12, every = 2, steps = 30", "count = 4, every = 2, steps = 5")
}

fn config(text: &str) -> TrainConfig {
    TrainConfig::from_toml(text).unwrap()
}

fn trainer(text: &str) -> Trainer {
    Trainer::new(config(text)).unwrap()
}

fn finish(mut trainer: Trainer) -> Trainer {
    while trainer.step().unwrap().is_some() {}
    trainer
}

#[test]
fn ppo_learns_from_nothing() {
    // Zero updates solve what the straight line solves: 46 %. Over 20 seeds this training ended at
    // 82.9 % with a standard deviation of 0.9 % and a minimum of 81.0 %; the threshold is four
    // deviations below the mean.
    let trained = finish(trainer(
        r#"
        environment_steps = 40_000
        network.initialization = "orthogonal"
        cloning.epochs = 0
        environment.episode_limit = 40
        ppo = { environments = 50, steps = 20, initial_log_std = -1.0, learning_rate = 1e-3, gamma = 0.95 }
        validation.count = 300
        "#,
    ));
    let success: Vec<f64> =
        trained.curve().iter().filter_map(|p| p.validation).map(|v| v.success()).collect();
    assert!(success[0] < 0.56, "{success:?}");
    assert!(*success.last().unwrap() > 0.793, "{success:?}");
}

#[test]
fn cloning_learns_gradient_descent() {
    let trained = finish(trainer("environment_steps = 0\nvalidation.count = 300"));
    let progress = &trained.curve()[0];
    let losses = &progress.cloning_losses;
    assert_eq!(losses.len(), 157);
    let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
    assert!(mean(&losses[147..]) < 0.1 * mean(&losses[..10]), "{losses:?}");
    // 20 seeds: 80.3 to 81.0 %, mean 80.7, deviation 0.2; gradient descent itself 80.3.
    assert!(progress.validation.unwrap().success() > 0.79);
}

#[test]
fn dagger_brings_a_wide_observation_to_its_expert() {
    // The straight line alone solves 30 % of these tasks, the expert (gradient descent, step 0.5)
    // about half.
    let text = |rounds: usize| {
        format!(
            r#"
            environment_steps = {}
            observation = ["gradient", "trajectory", "ends", "nearest-obstacles:6"]
            network = {{ hidden = 64, initialization = "orthogonal" }}
            training = {{ suite = "mix", count = 200, seed = 1000 }}
            cloning.epochs = 0
            ppo = {{ environments = 1, steps = 1, learning_rate = 1e-9 }}
            dagger = {{ rounds = {rounds}, expert = "tuned-gradient-descent", minibatches = 150 }}
            validation = {{ suite = "mix", count = 200, steps = 40, every = 10 }}
            "#,
            // One update that changes nothing, so that there is a validation.
            u8::from(rounds == 0)
        )
    };
    let success = |rounds| finish(trainer(&text(rounds))).best().unwrap().validation.success();
    let (before, after) = (success(0), success(10));
    assert!(before < 0.35, "{before}");
    assert!(after > 0.4, "{after}");
}

#[test]
fn a_checkpoint_after_any_unit_goes_on_to_the_same_bits() {
    for text in [SMALL.to_string(), small_image()] {
        let mut uninterrupted = trainer(&text);
        let mut states = vec![uninterrupted.checkpoint().unwrap()];
        while uninterrupted.step().unwrap().is_some() {
            states.push(uninterrupted.checkpoint().unwrap());
        }
        assert_eq!(uninterrupted.units(), Units { done: 9, all: 9 });
        let last = states.last().unwrap();
        for state in &states {
            let resumed = Trainer::resume(config(&text), state).unwrap();
            assert_eq!(&resumed.checkpoint().unwrap(), state, "resuming alone changes nothing");
            let resumed = finish(resumed);
            assert_eq!(&resumed.checkpoint().unwrap(), last);
            assert_eq!(resumed.best_policy().unwrap(), uninterrupted.best_policy().unwrap());
        }
    }
}

#[test]
fn threads_change_nothing() {
    let large = SMALL
        .replace("minibatch = 20", "minibatch = 300")
        .replace("environments = 6", "environments = 60")
        .replace("environment_steps = 190", "environment_steps = 960");
    let image = small_image().replace("minibatch = 20", "minibatch = 200");
    let with = |text: &str, threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| finish(trainer(text)).checkpoint().unwrap())
    };
    for text in [large, image] {
        assert_eq!(with(&text, 1), with(&text, 3));
    }
}

#[test]
fn training_and_planning_run_the_same_policy() {
    for text in [SMALL.to_string(), small_image()] {
        same_policy(&text);
    }
}

/// Validation in training finds what the policy's file finds in planning.
fn same_policy(text: &str) {
    let trained = finish(trainer(text));
    let bytes = trained.policy().unwrap().to_safetensors().unwrap();
    let policy = Arc::new(Policy::from_safetensors(&bytes).unwrap());
    let (mut solved, mut iterations) = (0, 0);
    let checks = &trained.config().validation;
    for task in Suite::Easy.generate(checks.count, 7, &Profile::PAPER) {
        let mut objective = Objective::new(&Query::of(&task, &Profile::PAPER), 10).unwrap();
        let rng = stream(0, Purpose::Planner, 0, 0);
        let method = Method::Learned(policy.clone());
        let mut optimizer = Optimizer::new(&method, &objective, rng).unwrap();
        let mut x = vec![0.0; objective.dim()];
        objective.straight_line(&mut x);
        let run =
            run(&mut objective, &mut optimizer, &mut x, checks.steps, Until::Feasible, |_| {
                ControlFlow::Continue(())
            });
        solved += usize::from(run.first_feasible.is_some());
        iterations += run.first_feasible.unwrap_or(0);
    }
    let validation = trained.curve().last().unwrap().validation.unwrap();
    assert_eq!(validation.solved, solved);
    assert_eq!(validation.mean_iterations, iterations as f64 / solved as f64);
}

#[test]
fn a_finished_training_that_is_given_more_steps_goes_on_as_if_it_had_had_them() {
    // A constant rate, as others depend on the number of steps; no validation, as the last unit
    // always has one.
    let short = SMALL.replace("schedule = \"cosine\"", "schedule = \"constant\"");
    let short = short.replace("count = 12, every = 2", "count = 0, every = 2");
    let long = short.replace("environment_steps = 190", "environment_steps = 380");
    let state = finish(trainer(&short)).checkpoint().unwrap();
    let longer = finish(Trainer::resume(config(&long), &state).unwrap());
    let whole = finish(trainer(&long));
    assert_eq!(longer.policy().unwrap(), whole.policy().unwrap());
    assert_eq!(longer.environment_steps(), whole.environment_steps());
    let message = Trainer::resume(config(&short), &longer.checkpoint().unwrap()).err().unwrap();
    let expected = "environment_steps: 190 is not allowed; expected 380, which the checkpoint";
    assert!(message.to_string().contains(expected), "{message}");
}

#[test]
fn a_training_begins_from_the_weights_of_a_policy() {
    let policy = finish(trainer(SMALL)).policy().unwrap();
    let begun = |text: &str| {
        let mut trainer = trainer(text);
        trainer.begin_from(&policy).map(|()| trainer)
    };
    let fresh = trainer(SMALL);
    let from = begun(SMALL).unwrap();
    assert_eq!(from.policy().unwrap().network(), policy.network());
    assert_ne!(fresh.policy().unwrap().network(), policy.network());
    let check = |from: &str, to: &str, expected: &str| {
        let message = begun(&SMALL.replace(from, to)).err().unwrap().to_string();
        assert!(message.contains(expected), "{message}");
    };
    check("hidden = 24", "hidden = 25", "--init: sizes: [71, 24, 24, 20]");
    check("previous-gradients:2", "previous-gradients:1", "--init: observation");
    check("seed = 5", "profile = \"default\"", "--init: profile: paper");
    check(
        "environment.episode",
        "environment.action_limit = 0.5\n environment.episode",
        "--init: action",
    );
    let waypoint = Recipe::from_toml("architecture = \"waypoint\"").unwrap();
    let message = waypoint.begin(Some(&policy)).err().unwrap().to_string();
    assert!(message.contains("--init: architecture: mlp"), "{message}");
}

/// The file with its document and tensors changed, and a checksum that is right.
fn forged(bytes: &[u8], change: impl Fn(&mut serde_json::Value)) -> Vec<u8> {
    let file = safetensors::SafeTensors::deserialize(bytes).unwrap();
    let mut reader = tensors::Reader::new(bytes, "checkpoint", "sidestep.checkpoint/2").unwrap();
    let mut document = reader.document().unwrap();
    change(&mut document);
    let names = file.names();
    let mut tensor = |name: &str| reader.tensor(name, file.tensor(name).unwrap().shape()).unwrap();
    let values: Vec<Vec<f32>> = names.iter().map(|name| tensor(name)).collect();
    let shape = |name: &str| file.tensor(name).unwrap().shape().to_vec();
    let pairs = names.iter().zip(&values);
    let all: Vec<_> =
        pairs.map(|(name, values)| (name.to_string(), shape(name), &values[..])).collect();
    tensors::write(&document, &all).unwrap()
}

#[test]
fn damaged_checkpoints_are_refused_in_words() {
    let good = trainer(SMALL).checkpoint().unwrap();
    let check = |bytes: &[u8], expected: &str| {
        let message = Trainer::resume(config(SMALL), bytes).map(|_| ()).unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
    };
    check(&good[..good.len() / 2], "checkpoint file");
    check(&trainer(SMALL).policy().unwrap().to_safetensors().unwrap(), "checkpoint.format");
    for bit in (0..8 * good.len()).step_by(997) {
        let mut flipped = good.clone();
        flipped[bit / 8] ^= 1 << (bit % 8);
        assert!(Trainer::resume(config(SMALL), &flipped).is_err(), "bit {bit}");
    }
    check(
        &forged(&good, |document| document["config"]["network"]["hidden"] = 25.into()),
        "network.hidden: 24 is not allowed; expected 25, which the checkpoint was made with",
    );
    check(&forged(&good, |document| document["updates"] = 9.into()), "checkpoint.updates: 9");
    check(&forged(&good, |document| document["rounds"] = 2.into()), "checkpoint.rounds: 2");
    check(&forged(&good, |document| document["states"] = 7.into()), "checkpoint.states: 7");
    check(&forged(&good, |document| document["environments"][0]["task"] = 9.into()), "below 8");
    assert!(Trainer::resume(config(SMALL), &forged(&good, |_| {})).is_ok());
}

#[test]
fn divergence_is_told_and_leaves_a_state_to_go_on_from() {
    // Steps of 1000 bring the log-std so low that PPO's first probability divides by 0.
    let diverging =
        "epochs = 2, optimizer = \"adam\", learning_rate = 1000.0, prediction = \"sampled\",";
    let text = SMALL.replace("epochs = 2,", diverging);
    let mut trainer = trainer(&text);
    let (state, divergence) = loop {
        let state = trainer.checkpoint().unwrap();
        match trainer.step() {
            Ok(Some(_)) => {}
            Ok(None) => panic!("a rate of 1000 must diverge"),
            Err(divergence) => break (state, divergence),
        }
    };
    let words = divergence.to_string();
    assert!(words.contains("diverged: after unit 6 the parameters are not finite"), "{words}");
    assert!(trainer.checkpoint().unwrap() == state, "the training is as it was before");
    let mut resumed = Trainer::resume(config(&text), &state).unwrap();
    assert_eq!(resumed.step().unwrap_err(), divergence);
}

#[test]
fn a_gradient_whose_square_overflows_leaves_a_training_that_resumes() {
    let text = r#"
        environment_steps = 2000
        network.hidden = 8
        training.count = 3
        cloning.samples_per_task = 4
        validation = { count = 5, steps = 5 }
        ppo = { environments = 5, steps = 40, initial_log_std = 3.0, learning_rate = 1.0, clip = 1.0, epochs = 100 }
        environment = { keep_inside = false, action_limit = 1e6, action_scale = 1e6 }
    "#;
    let whole = finish(trainer(text));
    let norms = whole.curve().iter().filter_map(|progress| progress.update);
    assert!(norms.clone().any(|update| update.gradient_norm > 1e19), "{:?}", whole.curve());
    assert!(norms.map(|update| update.gradient_norm).all(f64::is_finite));
    let state = whole.checkpoint().unwrap();
    assert!(Trainer::resume(config(text), &state).unwrap().checkpoint().unwrap() == state);
}

#[test]
fn a_part_of_ones_own_trains_as_one_that_is_there() {
    let own = OwnPart {
        name: "slope",
        len: |waypoints, dof| waypoints * dof,
        write: |_, _, gradient, out| out.copy_from_slice(gradient),
    };
    let seeing = |name: &str| {
        let text = SMALL.replace(
            r#"["gradient", "previous-gradients:2", "obstacle-cost"]"#,
            r#"["gradient", "obstacle-cost"]"#,
        );
        let mut config = config(&text);
        config.observation[0] = name.into();
        config
    };
    let known = finish(Trainer::new(seeing("gradient")).unwrap());
    let mut trainer = Trainer::seeing(&[own], seeing("own:slope")).unwrap();
    for _ in 0..4 {
        trainer.step().unwrap();
    }
    let state = trainer.checkpoint().unwrap();
    let ours = finish(Trainer::resume_seeing(&[own], seeing("own:slope"), &state).unwrap());
    let bytes = ours.policy().unwrap().to_safetensors().unwrap();
    let numbers = |policy: &Policy| match policy.network() {
        PolicyNetwork::Whole { network, .. } => network.parameters().to_vec(),
        _ => unreachable!("a policy of a whole trajectory"),
    };
    let policy = Policy::read_seeing(&[own], &bytes).unwrap();
    assert_eq!(numbers(&policy), numbers(&known.policy().unwrap()));
    for error in [
        Policy::from_safetensors(&bytes).unwrap_err(),
        Trainer::new(seeing("own:slope")).err().unwrap(),
        Trainer::seeing(&[own], seeing("own:slop")).err().unwrap(),
    ] {
        assert!(error.to_string().contains("own:slop"), "{error}");
    }
    let empty = OwnPart { len: |_, _| 0, ..own };
    let error = Trainer::seeing(&[empty], seeing("own:slope")).err().unwrap();
    assert!(error.to_string().contains("0 numbers"), "{error}");
}
