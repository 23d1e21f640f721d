//! What people type by mistake: it works as meant, or the message says what to type.

use std::fs;

use crate::{check, folder};

#[test]
fn natural_mistakes_are_answered() {
    let folder = folder();
    fs::create_dir(folder.path().join("run")).unwrap();
    let rows: &[(&str, i32, &[&str])] = &[
        ("plan free.json --planer gd", 2, &["--planer", "'--planner'"]),
        (
            "plan free.json --planner gradient-descent",
            2,
            &["did you mean gd?", "`sidestep planners`"],
        ),
        ("plan free.json --planner astar", 2, &["did you mean shortest-path?"]),
        ("plan free.json --planner help", 0, &["gd[:step=NUMBER]", "gradient descent", "0.999"]),
        ("plan --planner help", 0, &["stomp[:rollouts=NUMBER,noise=NUMBER]"]),
        ("plan free.json --start 1 2", 0, &["solved"]),
        ("plan free.json --start 1, 2 --goal 8 8", 0, &["solved"]),
        ("plan free.json --start=1,2", 0, &["solved"]),
        ("plan free.json --start -1,2", 2, &["(-1, 2) is not in [0, 0] to [10, 10]"]),
        ("plan free.json --start -1 2", 2, &["(-1, 2) is not in [0, 0] to [10, 10]"]),
        ("plan free.json --start 1", 2, &["expected X,Y"]),
        ("plan free.json --start 1.5,1.5,0", 2, &["--start", "X,Y", "two numbers"]),
        ("plan free.json --start 1.5 1.5 0", 2, &["--start", "X,Y", "two numbers"]),
        ("plan free.json --radius 0.2", 0, &["solved"]),
        ("plan free.json --planner learned", 2, &["learned:PATH", "a policy file"]),
        ("plan free.json --planner learned:run", 2, &["run/policy.safetensors: cannot be read"]),
        (
            "plan free.json --planner learned:nowhere",
            2,
            &["nowhere: cannot be read", "policy file"],
        ),
        ("plan free.json --out plan.txt", 2, &["--out", "plan.txt", ".json or .csv"]),
        ("plan free.json --png out.jpg", 2, &["--png", "out.jpg", ".png"]),
        ("plan free.json --svg out.png", 2, &["--svg", "out.png", ".svg"]),
        ("plan free.json --waypoints 100000", 2, &["--waypoints", "100000", "1 to 10000"]),
        ("bench --planner gd", 2, &["--suite NAME", "varied", "--tasks FILE"]),
        ("bench --help", 0, &["--tasks", "varied", "Examples:"]),
        ("plan --help", 0, &["Examples:", "Task:", "Planner:", "Output:"]),
        ("--version", 0, &["sidestep ", "(commit "]),
        ("plan EXAMPLES/office.yaml --start 11,18 --goal 1,1", 2, &["x and y swapped"]),
        ("plan EXAMPLES/office.yaml --start 100,60 --goal 1,1", 2, &["in cells of 0.05"]),
        ("plan free.json --robot-radius 6", 2, &["a robot of radius 6", "does not fit"]),
        ("plan free.json --margin 1.5", 0, &["the margin is not kept within 0.707 of it"]),
        ("plan free.json --margin 6", 2, &["a margin of 6", "does not fit"]),
    ];
    for (line, code, parts) in rows {
        check(folder.path(), line, *code, parts);
    }
}

#[test]
fn obstacles_on_the_line_are_part_of_the_task() {
    let folder = folder();
    check(folder.path(), "plan free.json --planner gd --steps 0", 0, &["solved"]);
    let line = "plan free.json --obstacle rect:3,2,7,7 --json --planner";
    let typed = check(folder.path(), &format!("{line} shortest-path"), 0, &[]).json();
    let filed =
        check(folder.path(), "plan block.json --planner shortest-path --json", 0, &[]).json();
    assert_eq!(typed["length"], filed["length"]);
    let wall = "plan free.json --obstacle polygon:4,-1;5,-1;5,11;4,11 --obstacle circle:8,2,0.5";
    check(folder.path(), wall, 1, &["unsolvable"]);
    check(folder.path(), "plan free.json --obstacle circle:1,1,0.5", 2, &["in collision"]);
    check(folder.path(), "plan free.json --obstacle box:1,2,3,4", 2, &["--obstacle", "rect:X0"]);
    check(folder.path(), "plan free.json --obstacle rect:1,2,3", 2, &["found 3 number(s)"]);
}

#[test]
fn the_suffix_decides_the_format() {
    let folder = folder();
    check(folder.path(), "plan block.json --out plan.csv", 0, &["solved"]);
    let csv = fs::read_to_string(folder.path().join("plan.csv")).unwrap();
    assert!(csv.starts_with("x,y,yaw,t,v,kappa\n1,1,"), "{csv}");
    assert!(csv.lines().last().unwrap().starts_with("9,9,"), "{csv}");
}
