//! `generate` for robots with joints.

use serde_json::Value;

use crate::check;

const PANDA: &str = include_str!("../../../sidestep-io/tests/robots/panda_spherized.urdf");
const PANDA_SRDF: &str = include_str!("../../../sidestep-io/tests/robots/panda.srdf");

#[test]
fn planar_arms_come_with_their_robot() {
    let folder = tempfile::tempdir().unwrap();
    let line = "generate --suite planar-arm --dof 4 --count 6 --out out.json";
    check(folder.path(), &format!("{line} --seed 3"), 0, &["6 problems of planar-arm (seed 3)"]);
    let read = |name| std::fs::read_to_string(folder.path().join(name)).unwrap();
    let first = read("out.json");
    let problems: Value = serde_json::from_str(&first).unwrap();
    assert_eq!(problems["format"], "sidestep.problems/1");
    assert_eq!(problems["robot"], "planar-arm-4.json");
    assert_eq!(problems["problems"].as_array().unwrap().len(), 6);
    assert_eq!(problems["problems"][5]["start"].as_array().unwrap().len(), 4);
    check(folder.path(), "robot planar-arm-4.json", 0, &["4 move", "reach 1.00 m"]);
    // The seed alone decides.
    check(folder.path(), &format!("{line} --seed 3 --threads 1 --json"), 0, &["\"tasks\": 6"]);
    assert_eq!(read("out.json"), first);
    check(folder.path(), &format!("{line} --seed 4"), 0, &[]);
    assert_ne!(read("out.json"), first);
}

#[test]
fn scenes_are_drawn_for_a_robot() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("panda.urdf"), PANDA).unwrap();
    std::fs::write(folder.path().join("panda.srdf"), PANDA_SRDF).unwrap();
    let robot = "--robot panda.urdf --srdf panda.srdf --group panda_arm --tool panda_hand";
    let line = format!("generate {robot} --count 6 --seed 1");
    for suite in ["shelf", "table"] {
        let line = format!("{line} --suite {suite} --out {suite}.json");
        check(folder.path(), &line, 0, &["6 problems"]);
        let text = std::fs::read_to_string(folder.path().join(format!("{suite}.json"))).unwrap();
        let problems: Value = serde_json::from_str(&text).unwrap();
        assert_eq!(problems["robot"], "panda.urdf");
        assert_eq!(problems["joints"][6], "panda_joint7");
        assert!(problems["problems"][0]["objects"].as_array().unwrap().len() > 3);
    }
    let bad: [(&str, &[&str]); 8] = [
        ("--suite cag --count 1 --seed 1 --out a.json", &["cag", "easy", "planar-arm", "cage"]),
        ("--suite cage --count 1 --seed 1 --out a.json", &["--robot"]),
        ("--suite cage --count 0 --seed 1 --out a.json", &["--count", "1000000"]),
        ("--suite cage --count 1 --seed 1 --out a.jsonl", &["--out", ".json"]),
        ("--suite planar-arm --dof 17 --count 1 --seed 1 --out a.json", &["--dof", "16"]),
        ("--suite planar-arm --count 1 --seed 1 --out a.json --robot panda.urdf", &["--robot"]),
        ("--suite easy --count 1 --seed 1 --out a.json --robot panda.urdf", &["plane"]),
        (
            "--suite cage --count 1 --seed 1 --out a.json --robot panda.urdf --tool nolink",
            &["tool.link", "nolink"],
        ),
    ];
    for (line, parts) in bad {
        check(folder.path(), &format!("generate {line}"), 2, parts);
    }
    assert!(!folder.path().join("a.json").exists());
}
