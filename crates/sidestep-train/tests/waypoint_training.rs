//! The waypoint policy's training: resumes to the same bits, does not depend on threads, and
//! learns.
#![allow(clippy::unwrap_used, reason = "tests")]

use sidestep::network::WaypointNet;
use sidestep::policy::Policy;
use sidestep_train::WaypointTrainer;
use sidestep_train::waypoint::{StageConfig, StageKind, WaypointConfig};

fn config() -> WaypointConfig {
    let stage = |kind, updates, learning_rate| StageConfig { kind, updates, learning_rate };
    let mut config = WaypointConfig {
        observation: ["waypoints", "probes:4x0.5,1.5", "map:6x16x1,2"].map(String::from).into(),
        stages: vec![
            stage(StageKind::Imitation, 500, 2e-3),
            stage(StageKind::PolicyGradient, 250, 1e-4),
        ],
        ..WaypointConfig::default()
    };
    config.network.width = 16;
    config.network.dilations = vec![1];
    config.imitation.tasks = 4;
    config.imitation.steps = 1;
    config.policy_gradient.tasks = 3;
    config.policy_gradient.walks = 2;
    config.policy_gradient.steps = 4;
    config.policy_gradient.epochs = 2;
    config.validation.count = 30;
    config.validation.every = 1;
    config
}

fn finish(mut trainer: WaypointTrainer) -> Vec<u8> {
    while trainer.step().unwrap().is_some() {}
    trainer.checkpoint().unwrap()
}

fn with_threads<T: Send>(threads: usize, run: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(run)
}

/// A planar arm of two joints.
fn jointed() -> WaypointConfig {
    let mut config = config();
    config.observation = vec!["joints:8".into()];
    config.tasks.joints = 2;
    config.stages[0].updates = 250;
    config.policy_gradient.short_cuts = 4;
    config.validation.count = 60;
    config
}

/// Trains whole, and in pieces on other threads: to the same bits, which are returned.
fn is_resumed_to_the_same_bits(config: &WaypointConfig) -> Vec<u8> {
    let whole = with_threads(1, || finish(WaypointTrainer::new(config.clone()).unwrap()));
    let resumed = with_threads(3, || {
        let mut trainer = WaypointTrainer::new(config.clone()).unwrap();
        loop {
            let more = trainer.step().unwrap().is_some();
            let state = trainer.checkpoint().unwrap();
            trainer = WaypointTrainer::resume(config.clone(), &state).unwrap();
            if !more {
                return trainer.checkpoint().unwrap();
            }
        }
    });
    assert!(whole == resumed, "the checkpoints differ");
    whole
}

#[test]
fn trainings_for_joints_resume_and_their_policies_are_read_back() {
    let state = is_resumed_to_the_same_bits(&jointed());
    let trainer = WaypointTrainer::resume(jointed(), &state).unwrap();
    let policy = trainer.best_policy().unwrap();
    assert_eq!((policy.card().dof, &policy.card().observation[..]), (2, &["joints:8".into()][..]));
    assert_eq!(Policy::from_safetensors(&policy.to_safetensors().unwrap()).as_ref(), Ok(&policy));
    let found = trainer.best().unwrap().validation;
    assert!(found.easy.tasks > 10 && found.hard.tasks < found.easy.tasks, "{found:?}");
    assert!(found.easy.success() > 0.3, "{found:?}");
    let fine = WaypointTrainer::new(jointed()).unwrap().begin_from(&policy);
    assert_eq!(fine, Ok(()));
}

#[test]
fn resumed_at_any_unit_and_on_other_threads_it_ends_with_the_same_bits() {
    let whole = is_resumed_to_the_same_bits(&config());
    let error = WaypointTrainer::resume(config(), &whole[..whole.len() / 2]).err().unwrap();
    assert!(error.to_string().contains("checkpoint"), "{error}");
}

#[test]
fn a_checkpoint_of_another_configuration_is_refused_and_more_updates_are_welcome() {
    let state = WaypointTrainer::new(config()).unwrap().checkpoint().unwrap();
    let resumed = |change: &dyn Fn(&mut WaypointConfig)| {
        let mut config = config();
        change(&mut config);
        WaypointTrainer::resume(config, &state).map(|trainer| trainer.units().all)
    };
    assert_eq!(resumed(&|_| {}), Ok(3));
    assert_eq!(resumed(&|config| config.stages[1].updates = 1000), Ok(6));
    let check = |change: &dyn Fn(&mut WaypointConfig), expected: &str| {
        let message = resumed(change).unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
    };
    check(&|config| config.seed = 9, "seed: 9 is not allowed; expected 0, which the checkpoint");
    check(&|config| config.stages[0].updates = 1000, "stages[0].updates: 1000");
    check(&|config| config.network.width = 32, "network.width: 32");
    check(&|config| config.stages.truncate(1), "stages: ");
}

#[test]
fn divergence_is_told_and_leaves_a_state_to_go_on_from() {
    let mut trainer = WaypointTrainer::new(config()).unwrap();
    let shape = trainer.shape().clone();
    // Weights that are finite, with outputs that are not.
    let huge = vec![1e30; shape.parameter_count().unwrap()];
    let net = WaypointNet::new(&shape, huge).unwrap();
    let card = trainer.best_policy().unwrap().card().clone();
    trainer.begin_from(&Policy::of_waypoints(card, net).unwrap()).unwrap();
    let state = trainer.checkpoint().unwrap();
    let divergence = trainer.step().unwrap_err();
    let words = divergence.to_string();
    assert!(words.contains("unit 1 the parameters are not finite; try a stages[0]"), "{words}");
    assert!(trainer.checkpoint().unwrap() == state, "the training is as it was before");
    let mut resumed = WaypointTrainer::resume(config(), &state).unwrap();
    assert_eq!(resumed.step().unwrap_err(), divergence);
}

#[test]
fn a_gradient_whose_square_overflows_leaves_a_training_that_resumes() {
    let mut config = config();
    config.stages.truncate(1);
    config.network.action_pixels = 1000.0;
    config.network.action_limit_pixels = 1000.0;
    config.imitation.hinge = 100.0;
    config.stages[0].learning_rate = 1000.0;
    let mut trainer = WaypointTrainer::new(config.clone()).unwrap();
    while let Some(progress) = trainer.step().unwrap() {
        assert!(progress.gradient_norm.is_finite() && progress.loss.is_finite());
    }
    assert!(trainer.curve()[0].gradient_norm > 1e19, "{:?}", trainer.curve());
    let state = trainer.checkpoint().unwrap();
    assert!(WaypointTrainer::resume(config, &state).unwrap().checkpoint().unwrap() == state);
}

#[test]
fn imitation_learns() {
    let mut config = config();
    config.stages.truncate(1);
    config.stages[0].updates = 1500;
    config.validation.count = 150;
    config.validation.every = 6;
    let mut trainer = WaypointTrainer::new(config).unwrap();
    let mut results = Vec::new();
    while let Some(progress) = trainer.step().unwrap() {
        results.extend(progress.validation.map(|v| (progress.loss, v)));
    }
    // Straight lines that are free already: 46 % of the easy tasks; gradient descent solves 80 %.
    let (_, last) = results.last().unwrap();
    assert!(last.easy.success() >= 0.6, "{last:?}");
}

#[test]
fn bad_configurations_name_field_value_and_range() {
    let check = |text: &str, expected: &str| {
        let text = format!("architecture = \"waypoint\"\n{text}");
        let message = WaypointConfig::from_toml(&text).unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
    };
    check("[network]\nwidth = 70", "network.width: 70");
    check("[network]\nwidht = 64", "network.widht: an unknown key is not allowed; expected width");
    check("[network]\ndilations = [0]", "network.dilations: 0");
    check("[network]\ndilations = [\"a\"]", "network.dilations");
    check("observation = [\"gradient\"]", "observation: gradient");
    check("observation = [\"waypoints\", \"probes:0x1\"]", "observation: probes:0x1");
    check("[tasks]\nseed = 2", "tasks.seed: 2");
    check("[tasks]\njoints = 17", "tasks.joints: 17");
    check("[tasks]\njoints = 4", "expected [\"joints:16\"], where tasks.joints is 4");
    check("observation = [\"joints:16\"]", "observation: joints:16");
    check(
        "observation = [\"joints:8\"]\n[tasks]\njoints = 2\n[policy_gradient]\nrepair = 0.5",
        "policy_gradient.repair: 0.5",
    );
    check("[tasks]\nwaypoints = [9, 3]", "tasks.waypoints: [9, 3]");
    check("[validation]\nseed = 1", "validation.seed: 1");
    check("[imitation]\ntasks = 0", "imitation.tasks: 0");
    check(
        "[policy_gradient]\ntasks = 256\nwalks = 256\nsteps = 1000",
        "policy_gradient.walks: 256",
    );
    check("[validation]\ncount = 100000", "validation.count: 100000");
    check("[policy_gradient]\nepochs = 0", "policy_gradient.epochs: 0");
    check("[policy_gradient]\nsolved = 1.5", "policy_gradient.solved: 1.5");
    check(
        "observation = [\"waypoints\", \"probes:4x1\", \"map:3x16x1\"]",
        "observation: map:3x16x1",
    );
    check(
        "[[stages]]\nkind = \"imitation\"\nupdates = -1\nlearning_rate = 1.0",
        "stages.updates: -1",
    );
    check(
        "[[stages]]\nkind = \"imitation\"\nupdates = 10\nlearning_rate = 0",
        "stages[0].learning_rate: 0",
    );
}
