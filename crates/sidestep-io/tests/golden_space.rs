//! Distances in space against values that coal computed (`oracle/space.py`).
#![allow(clippy::unwrap_used, reason = "a test")]

use serde_json::{Value, json};
use sidestep_io::scenes::{SceneOptions, read_scene};

#[test]
fn distances_are_those_of_coal() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../oracle/golden/space.json");
    let golden: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let tolerance = golden["tolerance"].as_f64().unwrap();
    let mut none = |_: &str| Err(std::io::Error::other("no file"));
    let mut seen = 0;
    for case in golden["shapes"].as_array().unwrap() {
        let objects = json!([{"name": "shape", "shapes": [case["shape"]]}]);
        let scene = json!({"format": "sidestep.scene/1", "objects": objects}).to_string();
        let options = SceneOptions::default();
        let world = read_scene("a.json", scene.as_bytes(), options, &mut none).unwrap();
        let points = case["points"].as_array().unwrap();
        for (point, expected) in points.iter().zip(case["distances"].as_array().unwrap()) {
            let p = [0, 1, 2].map(|k| point[k].as_f64().unwrap());
            let pieces = 0..world.pieces() as u32;
            let found = pieces.map(|i| world.distance(i, p).0).fold(f64::INFINITY, f64::min);
            let expected = expected.as_f64().unwrap();
            assert!((found - expected).abs() <= tolerance, "{}: {found} {expected}", case["shape"]);
            seen += 1;
        }
    }
    assert_eq!(seen, 340);
}
