//! Durations of time-optimal trajectories against values that toppra computed (`oracle/timing.py`).
#![allow(clippy::unwrap_used, reason = "a test")]

use serde_json::Value;
use sidestep::trajectory::timing::{Limits, Path, time_path};

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

#[test]
fn durations_are_those_of_toppra() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../oracle/golden/timing.json");
    let golden: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let tolerance = golden["tolerance"].as_f64().unwrap();
    let cases = golden["paths"].as_array().unwrap();
    assert_eq!(cases.len(), 7);
    for case in cases {
        let rows = case["waypoints"].as_array().unwrap();
        let waypoints: Vec<f64> = rows.iter().flat_map(numbers).collect();
        let limits =
            Limits::new(numbers(&case["velocity"]), numbers(&case["acceleration"])).unwrap();
        let path = Path::blended(&waypoints, limits.dof(), &numbers(&case["reach"])).unwrap();
        let found = time_path(&path, &limits).unwrap().duration();
        let expected = case["duration"].as_f64().unwrap();
        let ratio = found / expected;
        assert!((ratio - 1.0).abs() <= tolerance, "{found}, golden {expected}: {ratio}");
    }
}
