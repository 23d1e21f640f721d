//! Policies come back from their files bit for bit; every other file is refused in words.

use proptest::prelude::*;

use super::*;
use crate::network::WaypointShape;
use crate::profile::Profile;

fn card(observation: &[&str], waypoints: usize) -> PolicyCard {
    PolicyCard {
        dof: 2,
        format: String::new(),
        architecture: String::new(),
        sizes: Vec::new(),
        waypoints,
        observation: observation.iter().map(|name| (*name).to_string()).collect(),
        profile: "paper".into(),
        action: ActionRule::PAPER,
        training: serde_json::json!({"seed": 3}),
        licence: "MIT OR Apache-2.0".into(),
    }
}

fn policy() -> Policy {
    let sizes = [31, 6, 20];
    let count = Mlp::parameter_count(&sizes).unwrap();
    let parameters = (0..count).map(|i| (i as f32 * 0.7).sin()).collect();
    let network = Mlp::new(&sizes, parameters).unwrap();
    Policy::new(card(&["gradient", "obstacle-cost"], 10), network).unwrap()
}

fn mlp(policy: &Policy) -> &Network {
    match policy.network() {
        PolicyNetwork::Whole { network, .. } => network,
        _ => unreachable!("made as an mlp"),
    }
}

/// The file of `policy()` with its document changed by `change`.
fn changed(change: impl FnOnce(&mut serde_json::Value)) -> Vec<u8> {
    let policy = policy();
    let mut document = serde_json::to_value(policy.card()).unwrap();
    change(&mut document);
    tensors::write(&document, &parameter_tensors(mlp(&policy), "")).unwrap()
}

fn image_policy() -> Policy {
    let parts = [ObservationPart::Ends, ObservationPart::Image, ObservationPart::Gradient];
    let sizes = crate::policy::observation::sizes_for(&parts, 10, 2, &[3, 4], 20);
    let count = Cnn::parameter_count(&sizes, 4).unwrap();
    let parameters = (0..count).map(|i| (i as f32 * 0.7).sin()).collect();
    let network = Cnn::new(&sizes, 4, parameters).unwrap();
    Policy::new(card(&["ends", "image", "gradient"], 10), network).unwrap()
}

#[test]
fn an_image_policy_comes_back_and_needs_its_image() {
    let policy = image_policy();
    assert_eq!(policy.card().architecture, "cnn");
    let bytes = policy.to_safetensors().unwrap();
    assert_eq!(Policy::from_safetensors(&bytes).unwrap(), policy);
    let check = |change: &dyn Fn(&mut serde_json::Value), expected: &[&str]| {
        let mut document = serde_json::to_value(policy.card()).unwrap();
        change(&mut document);
        let bytes = tensors::write(&document, &parameter_tensors(mlp(&policy), "")).unwrap();
        let message = Policy::from_safetensors(&bytes).unwrap_err().to_string();
        assert!(expected.iter().all(|part| message.contains(part)), "{message}");
    };
    check(&|d| d["architecture"] = "mlp".into(), &["mlp", "cnn, which", "ends + image + gradient"]);
    let blind = serde_json::json!(["ends", "gradient"]);
    check(
        &|d| d["observation"] = blind.clone(),
        &["cnn", "mlp, which the observation ends + gradient"],
    );
    check(&|d| d["sizes"][1] = 7.into(), &["network.sizes", "2048"]);
    check(&|d| d["sizes"][2] = 5.into(), &["layers.0.weight", "F32 [5, 2048]"]);
    // The image's place is part of the network: the same parts in another order are another policy.
    let mlp_card = card(&["ends", "image", "gradient"], 10);
    let other = Mlp::new(&[4120, 3, 20], vec![0.0; 4121 * 3 + 4 * 20]).unwrap();
    let message = Policy::new(mlp_card, other).unwrap_err().to_string();
    assert!(message.contains("mlp") && message.contains("cnn"), "{message}");
}

#[test]
fn round_trip_is_exact() {
    let policy = policy();
    let bytes = policy.to_safetensors().unwrap();
    assert_eq!(Policy::from_safetensors(&bytes).unwrap(), policy);
    assert_eq!(bytes, policy.to_safetensors().unwrap(), "the same policy, the same bytes");
}

#[test]
fn contradictions_name_both_sides() {
    let check = |bytes: Vec<u8>, expected: &str| {
        let message = Policy::from_safetensors(&bytes).unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
    };
    check(changed(|d| d["format"] = "sidestep.policy/2".into()), "expected sidestep.policy/1");
    check(changed(|d| d["architecture"] = "conv".into()), "policy.architecture: conv");
    check(changed(|d| d["profile"] = "papr".into()), "policy.profile: `papr`");
    check(changed(|d| d["dof"] = 0.into()), "policy.dof: 0");
    check(changed(|d| d["dof"] = 3.into()), "policy.sizes");
    check(changed(|d| d["waypoints"] = 12.into()), "[37, .., 24]");
    check(changed(|d| d["waypoints"] = 0.into()), "policy.waypoints: 0");
    check(changed(|d| d["waypoints"] = u64::MAX.into()), "policy.waypoints");
    check(changed(|d| d["observation"] = serde_json::json!(["gradient"])), "[20, .., 20]");
    check(changed(|d| d["observation"] = serde_json::json!(["gradent"])), "gradent");
    check(changed(|d| d["observation"] = serde_json::json!([])), "at least one part");
    check(changed(|d| d["sizes"] = serde_json::json!([31, 7, 20])), "F32 [6, 31]");
    check(changed(|d| d["sizes"] = serde_json::json!([31, 1_u64 << 40, 20])), "parameters in all");
    check(changed(|d| d["sizes"] = serde_json::json!([])), "policy.sizes");
    check(changed(|d| d["action"]["limit"] = 0.into()), "policy.action.limit");
    check(changed(|d| d["action"]["scale"] = (-1).into()), "policy.action.scale");
    check(changed(|d| d["surprise"] = 1.into()), "unknown field `surprise`");
    check(changed(|d| d["licence"] = serde_json::Value::Null), "invalid type: null");
}

fn waypoint_policy() -> Policy {
    let card = card(&["waypoints", "probes:4x1", "map:5x16x1,2"], 10);
    let view = ViewParts::from_names(&card.observation).unwrap();
    let shape = WaypointShape {
        inputs: view.row_len(),
        width: 16,
        dilations: vec![1, 3],
        outputs: 2,
        map: view.map,
    };
    let count = shape.parameter_count().unwrap();
    let parameters = (0..count).map(|i| (i as f32 * 0.7).sin()).collect();
    Policy::of_waypoints(card, WaypointNet::new(&shape, parameters).unwrap()).unwrap()
}

#[test]
fn a_policy_of_joints_comes_back_and_others_are_refused() {
    let card = PolicyCard { dof: 3, ..card(&["joints:12"], 10) };
    let (inputs, dilations) = (12 * 3 + 3 * 12 + 17, vec![1, 2]);
    let shape = WaypointShape { inputs, width: 16, dilations, outputs: 3, map: None };
    let count = shape.parameter_count().unwrap();
    let network = WaypointNet::new(&shape, vec![0.5; count]).unwrap();
    let policy = Policy::of_waypoints(card.clone(), network.clone()).unwrap();
    assert!(matches!(policy.network(), PolicyNetwork::Joints { .. }));
    assert_eq!(Policy::from_safetensors(&policy.to_safetensors().unwrap()), Ok(policy));
    for (dof, observation, field) in [
        (4, "joints:12", "policy.sizes"),
        (3, "joints:9", "policy.sizes"),
        (3, "joints:0", "policy.observation"),
        (3, "joint:12", "policy.observation"),
    ] {
        let card = PolicyCard { dof, observation: vec![observation.into()], ..card.clone() };
        let error = Policy::of_waypoints(card, network.clone()).unwrap_err();
        assert_eq!(error.field, field);
    }
    let plane = PolicyCard { dof: 3, ..waypoint_policy().card().clone() };
    let error = Policy::of_waypoints(plane, network).unwrap_err();
    assert_eq!(error.field, "policy.dof");
}

#[test]
fn a_waypoint_policy_comes_back_and_others_are_refused() {
    let policy = waypoint_policy();
    let bytes = policy.to_safetensors().unwrap();
    assert_eq!(Policy::from_safetensors(&bytes).unwrap(), policy);
    let PolicyNetwork::Waypoint { network, .. } = policy.network() else { panic!() };
    let file = |document: &serde_json::Value, parameters: &[f32]| {
        let sizes = network.shape().layer_sizes();
        let tensors = layer_tensors(&sizes, network.layer_ranges(), parameters, "");
        tensors::write(document, &tensors).unwrap()
    };
    let document = serde_json::to_value(policy.card()).unwrap();
    let check = |bytes: &[u8], expected: &[&str]| {
        let message = Policy::from_safetensors(bytes).unwrap_err().to_string();
        assert!(expected.iter().all(|part| message.contains(part)), "{message}");
    };
    let mut parameters = network.parameters().to_vec();
    parameters[1000] = f32::NAN;
    check(&file(&document, &parameters), &["finite"]);
    check(&bytes[..bytes.len() - 5], &["policy"]);
    check(&bytes[..bytes.len() / 2], &["policy"]);
    let changed = |change: &dyn Fn(&mut serde_json::Value), expected: &[&str]| {
        let mut document = document.clone();
        change(&mut document);
        check(&file(&document, network.parameters()), expected);
    };
    let parts = |map: &str| serde_json::json!(["waypoints", "probes:4x1", map]);
    changed(&|d| d["observation"] = parts("map:5x24x1,2"), &["map:5x24x1,2", "a multiple of 16"]);
    changed(&|d| d["observation"] = parts("map:5x16x1,5"), &["map:5x16x1,5", "below the cells"]);
    changed(&|d| d["observation"] = parts("map:5x16"), &["map:GxCxD1,D2"]);
    changed(&|d| d["observation"] = parts("map:6x16x1"), &["layers"]);
    changed(&|d| d["observation"] = parts("gradent"), &["observation: gradent", "map:"]);
    changed(&|d| d["sizes"][0] = 129.into(), &["policy.sizes", "132, width"]);
    changed(&|d| d["sizes"][1] = 17.into(), &["network.width: 17"]);
    changed(&|d| d["sizes"][1] = (1_u64 << 40).into(), &["network.width"]);
    changed(&|d| d["sizes"][2] = 0.into(), &["network.dilations: 0"]);
    changed(&|d| d["architecture"] = "mlp".into(), &["waypoints"]);
}

#[test]
fn robots_of_other_coordinates_have_policies_and_are_not_mixed_up() {
    let card = PolicyCard { dof: 7, ..card(&["gradient", "ends"], 3) };
    let sizes = [7 * 3 + 14, 4, 7 * 3];
    let count = Mlp::parameter_count(&sizes).unwrap();
    let policy = Policy::new(card, Mlp::new(&sizes, vec![0.1; count]).unwrap()).unwrap();
    let bytes = policy.to_safetensors().unwrap();
    assert_eq!(Policy::from_safetensors(&bytes).unwrap(), policy);
    let task = crate::Suite::Easy.generate(1, 7, &Profile::PAPER).remove(0);
    let planner = crate::Planner::Optimizer(crate::Method::Learned(std::sync::Arc::new(policy)));
    let refused = crate::plan(&task, &planner, &planner.options().unwrap()).unwrap_err();
    assert_eq!((refused.field.as_str(), refused.value.as_str()), ("policy.dof", "7"));
    // The plane goes without saying, so files of the plane are as they were.
    assert!(!serde_json::to_string(self::policy().card()).unwrap().contains("dof"));
}

#[test]
fn waypoints_that_do_not_fit_are_named() {
    let message = policy().check_use(12, "paper").unwrap_err().to_string();
    assert_eq!(
        message,
        "waypoints: 12 is not allowed; expected 10, which the policy was trained for"
    );
}

#[test]
fn the_action_rule_clips_updates_and_positions() {
    let rule = ActionRule { scale: 2.0, limit: 1.0, keep_inside: true };
    let mut x = [1.0, 6.0, 0.5, 3.0, 2.0, 2.0];
    rule.apply(&[0.25, 0.3, -9.0, 0.1, f32::NAN, f32::INFINITY], &[[0.0, 6.4]; 2], &mut x);
    assert_eq!(x, [1.5, 6.4, 0.0, 3.2, 2.0, 3.0]);
    let mut free = [6.0, 6.0];
    ActionRule { keep_inside: false, ..rule }.apply(&[1.0, 0.0], &[[0.0, 6.4]; 2], &mut free);
    assert_eq!(free, [7.0, 6.0]);
}

proptest! {
    #[test]
    fn arbitrary_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        prop_assert!(Policy::from_safetensors(&bytes).is_err());
    }

    #[test]
    fn damaged_files_never_panic(
        cut in 0_usize..2000,
        changes in prop::collection::vec((0_usize..2000, any::<u8>()), 0..6),
    ) {
        let mut bytes = policy().to_safetensors().unwrap();
        for (at, byte) in changes {
            let length = bytes.len();
            bytes[at % length] = byte;
        }
        bytes.truncate(bytes.len() - cut.min(bytes.len()));
        if let Ok(policy) = Policy::from_safetensors(&bytes) {
            prop_assert!(mlp(&policy).parameters().iter().all(|p| p.is_finite()));
        }
    }

    #[test]
    fn damaged_headers_never_panic(
        at in 8_usize..1200,
        text in "[\\[\\]{}\",:0-9a-z]{0,12}",
    ) {
        let mut bytes = policy().to_safetensors().unwrap();
        let end = (at + text.len()).min(bytes.len());
        bytes[at..end].copy_from_slice(&text.as_bytes()[..end - at]);
        let _ = Policy::from_safetensors(&bytes);
    }
}
