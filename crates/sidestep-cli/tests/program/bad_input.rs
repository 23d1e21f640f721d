//! Bad input and usage: exit code 2, a message that says what to mend, and nothing on standard output.

use std::fs;
use std::path::Path;

use crate::{check, folder, task};

/// Files that hold something wrong.
fn write_bad_files(folder: &Path) {
    let good = task("");
    let files: [(&str, String); 24] = [
        ("empty.json", String::new()),
        ("words.json", "this is not JSON".into()),
        ("comma.json", good.replace("\"point\",", "\"point\",,")),
        ("version.json", good.replace("task/1", "task/9")),
        ("no-format.json", good.replace("\"format\": \"sidestep.task/1\", ", "")),
        ("nan.json", good.replace("[1, 1]", "[1, NaN]")),
        ("infinite.json", good.replace("[1, 1]", "[1, 1e999]")),
        ("far.json", good.replace("[1, 1]", "[1, 1e300]")),
        ("unknown-field.json", good.replace("\"robot\"", "\"robbot\"")),
        ("no-goal.json", good.replace(", \"goal\": [9, 9]", "")),
        ("bounds.json", good.replace("[10, 10]", "[-10, 10]")),
        ("rect.json", task(r#"{"rect": [[5, 5], [4, 6]]}"#)),
        ("circle.json", task(r#"{"circle": {"center": [5, 5], "radius": -2}}"#)),
        ("polygon.json", task(r#"{"polygon": [[5, 5], [6, 6]]}"#)),
        ("radius.json", good.replace("\"point\"", r#"{"disc": {"radius": -1}}"#)),
        ("lines.jsonl", format!("{}\n{{\"format\": 1}}\n", good.replace('\n', " "))),
        ("none.jsonl", String::new()),
        (
            "huge.map",
            format!("type octile\nheight 100000\nwidth 100000\nmap\n{}", ".".repeat(1000)),
        ),
        ("kind.map", "type hexagonal\nheight 1\nwidth 1\nmap\n.\n".into()),
        ("cut.pgm", "P5\n100 100\n255\nabc".into()),
        ("cut.yaml", map_yaml("cut.pgm")),
        ("lost.yaml", map_yaml("nowhere.pgm")),
        ("huge.pgm", "P5\n100000 100000\n255\nabc".into()),
        ("huge.yaml", map_yaml("huge.pgm")),
    ];
    for (name, text) in files {
        fs::write(folder.join(name), text).unwrap();
    }
    fs::write(folder.join("bytes.json"), b"\xff\xfe\x00").unwrap();
}

fn map_yaml(image: &str) -> String {
    format!(
        "image: {image}\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\n\
         free_thresh: 0.196\n"
    )
}

/// Command line and what its message must hold.
type Row = (&'static str, &'static [&'static str]);

fn check_rows(rows: &[Row]) {
    let folder = folder();
    write_bad_files(folder.path());
    for (line, parts) in rows {
        let outcome = check(folder.path(), line, 2, parts);
        assert_eq!(outcome.stdout, "", "sidestep {line}");
        assert!(outcome.stderr.starts_with("error: "), "sidestep {line}\n{}", outcome.stderr);
        assert!(!outcome.stderr.contains("panicked"), "sidestep {line}\n{}", outcome.stderr);
    }
}

#[test]
fn files() {
    check_rows(&[
        ("plan nowhere.json", &["nowhere.json", "cannot be read"]),
        ("plan .", &["it is a folder"]),
        ("plan free.txt", &["free.txt", "cannot be read"]),
        ("plan bytes.json", &["bytes.json", "text in UTF-8"]),
        ("plan empty.json", &["empty.json", "line 1", "valid JSON"]),
        ("plan words.json", &["words.json", "line 1, column 2", "valid JSON"]),
        ("plan comma.json", &["line 2", "valid JSON"]),
        ("plan version.json", &["sidestep.task/9", "sidestep.task/1"]),
        ("plan no-format.json", &["format"]),
        ("plan nan.json", &["valid JSON (no NaN"]),
        ("plan infinite.json", &["number out of range", "1e9"]),
        ("plan far.json", &["start[1]", "finite number of magnitude at most 1e9"]),
        ("plan unknown-field.json", &["robbot", "did you mean \"robot\"?"]),
        ("plan no-goal.json", &["goal"]),
        ("plan bounds.json", &["bounds[1][0]", "-10", "more than"]),
        ("plan rect.json", &["obstacles[0].rect[1][0]", "found 4", "more than [0][0] = 5"]),
        ("plan circle.json", &["obstacles[0].circle.radius", "-2", "above 0"]),
        ("plan polygon.json", &["obstacles[0].polygon", "found 2", "at least 3"]),
        ("plan radius.json", &["robot.disc.radius", "-1", "at least 0"]),
        ("plan lines.jsonl", &["line 2", "format"]),
        ("plan none.jsonl", &["none.jsonl", "found no task"]),
        ("plan huge.map --start 1,1 --goal 2,2", &["100000 x 100000", "file of 1043 bytes"]),
        ("plan kind.map --start 1,1 --goal 2,2", &["hexagonal", "octile"]),
        ("plan cut.yaml --start 1,1 --goal 2,2", &["100 x 100", "may be cut short"]),
        ("plan lost.yaml --start 1,1 --goal 2,2", &["nowhere.pgm", "No such file"]),
        ("plan huge.yaml --start 1,1 --goal 2,2", &["100000 x 100000", "268435456"]),
        ("plan EXAMPLES/office.yaml", &["--start X,Y", "--goal X,Y", "[20.0, 12.5]"]),
        ("plan free.json --warm-start words.json", &["words.json", "plan JSON, line 1"]),
        ("plan free.json --warm-start nowhere.json", &["nowhere.json", "cannot be read"]),
        ("plan free.json --out free.json", &["--out", "free.json, which is read"]),
        ("plan free.json --out both --png both", &["--png", "the file of --out too"]),
        ("plan EXAMPLES/office.yaml --start 1,1 --goal 2,2 --png EXAMPLES/office.png", &["read"]),
        ("bench --tasks free.json --planner gd --out free.json", &["--out", "which is read"]),
        ("plan free.json --out nowhere/plan.json", &["nowhere/plan.json", "no such folder"]),
        ("plan free.json --png nowhere/plan.png", &["nowhere/plan.png", "no such folder"]),
        ("plan free.json --svg .", &["cannot be written", "it is a folder"]),
        ("plan free.json --out free.json/plan.json", &["cannot be written", "not a directory"]),
        ("plan free.json --planner learned:nowhere", &["nowhere", "policy file (.safetensors)"]),
        ("plan free.json --planner learned:words.json", &["words.json"]),
        ("shortest nowhere.json", &["nowhere.json", "cannot be read"]),
        ("shortest version.json", &["sidestep.task/9"]),
        ("bench --tasks version.json --planner gd", &["sidestep.task/9"]),
        ("table nowhere.json", &["nowhere.json", "cannot be read"]),
        ("table words.json", &["words.json", "is not a report"]),
        ("table free.json", &["free.json", "sidestep.task/1", "sidestep.report/1"]),
    ]);
}

#[test]
fn flags() {
    check_rows(&[
        ("fly free.json", &["unrecognized subcommand 'fly'"]),
        ("pla free.json", &["similar subcommand", "'plan'"]),
        ("plan free.json --threads 8000", &["--threads: 8000", "0 (all cores) to 512"]),
        ("plan free.json --threads -1", &["--threads", "-1"]),
        ("plan free.json --compare nope", &["nope", "one of auto"]),
        ("plan free.json --compare gd", &["--compare", "--png FILE, --svg FILE or --html FILE"]),
        ("plan free.json --no-such-flag", &["--no-such-flag"]),
        ("plan free.json --planer gd", &["--planer", "'--planner'"]),
        ("plan", &["nothing to plan"]),
        ("plan free.json --planner gdd", &["gdd", "did you mean gd?"]),
        ("plan free.json --planner rrtconnect", &["did you mean rrt-connect?"]),
        ("plan free.json --planner xyzzy12345", &["one of auto, sidestep-1"]),
        ("plan free.json --planner gd:size=1", &["planner.gd", "size", "gd[:step=NUMBER]"]),
        ("plan free.json --planner shortest-path:step=1", &["planner.shortest-path", "no option"]),
        ("plan free.json --planner gd:step=0", &["planner.gd.step", "0.000000001 to 1000000"]),
        ("plan free.json --planner gd:step=-0.1", &["planner.gd.step", "-0.1"]),
        ("plan free.json --planner gd:step=nan", &["planner.gd.step", "NaN"]),
        ("plan free.json --planner gd:step=inf", &["planner.gd.step", "inf"]),
        ("plan free.json --planner gd:step=x", &["planner.gd.step", "`x`", "a number"]),
        ("info nowhere", &["nowhere: cannot be read", "policy file"]),
        ("info free.json", &["free.json"]),
        ("plan free.json --planner momentum:decay=1", &["planner.momentum.decay", "0.999"]),
        ("plan free.json --planner stomp:rollouts=0", &["planner.stomp.rollouts", "from 1"]),
        ("plan free.json --profile papr", &["profile", "papr", "one of default, paper"]),
        ("plan free.json --start-strategy zigzag", &["zigzag", "via-point"]),
        ("plan free.json --starts 0", &["starts", "0", "1 to 1000000"]),
        ("plan free.json --starts -1", &["--starts", "-1"]),
        ("plan free.json --waypoints 0", &["waypoints", "0", "1 to 10000"]),
        ("plan free.json --waypoints 10001", &["waypoints", "10001", "1 to 10000"]),
        ("plan free.json --steps 100000001", &["steps", "100000000"]),
        ("plan free.json --steps 1.5", &["--steps", "1.5"]),
        ("plan free.json --epsilon 0", &["--epsilon", "above 0"]),
        ("plan free.json --epsilon nan", &["--epsilon", "NaN"]),
        ("plan free.json --epsilon -1", &["--epsilon", "-1"]),
        ("plan free.json --robot-radius -1", &["robot.radius", "-1", "at least 0"]),
        ("plan free.json --robot-radius inf", &["robot.radius", "inf", "finite"]),
        ("plan free.json --budget-ms 0", &["--budget-ms", "above 0"]),
        ("plan free.json --budget-ms -5", &["--budget-ms", "-5", "above 0"]),
        ("plan free.json --index 1", &["--index", "1 of 1 tasks"]),
        ("plan free.json --start 1", &["--start", "expected X,Y"]),
        ("plan free.json --start 1,nan", &["--start", "not finite"]),
        ("plan free.json --start 1,1e999", &["--start", "not finite"]),
        ("plan free.json --goal 1,two", &["--goal", "`two` is not a number"]),
        ("plan free.json --start 1,1e300", &["start[1]", "at most 1e9"]),
        ("generate --suite easy --count 0 --seed 1 --out t.jsonl", &["--count", "from 1"]),
        ("generate --suite easy --count -1 --seed 1 --out t.jsonl", &["--count", "-1"]),
        ("generate --suite easy --count 1000001 --seed 1 --out t.jsonl", &["--count", "1000000"]),
        (
            "generate --suite eazy --count 1 --seed 1 --out t.jsonl",
            &["suite", "eazy", "easy, hard"],
        ),
        ("generate --suite easy --count 1 --seed -1 --out t.jsonl", &["--seed", "-1"]),
        ("generate --suite easy --count 1 --seed 1 --out t.txt", &["t.txt", ".jsonl"]),
        (
            "generate --suite easy --count 1 --seed 1 --out x/t.json",
            &["x/t.json", "no such folder"],
        ),
        ("generate --suite easy --count 1 --seed 1 --profile no --out t.json", &["profile", "no"]),
        ("bench --suite easy --count 0 --planner gd", &["--count", "0", "at least 1"]),
        (
            "bench --suite hard --count 18446744073709551615 --seeds 2 --planner gd",
            &["--count", "at most 1000000"],
        ),
        ("bench --suite easy --count 400000 --planner gd", &["times 5 seed(s)", "1000000"]),
        ("bench --suite hard --planner gd --starts 0", &["starts", "0", "1 to 1000000"]),
        ("bench --suite easy --seeds 1,x --planner gd", &["--seeds", "x"]),
        ("bench --suite none --planner gd", &["suite", "none", "easy, hard"]),
        ("bench --suite easy", &["--planner"]),
        ("bench --planner gd", &["--suite"]),
        ("bench --suite easy --tasks free.json --planner gd", &["--tasks", "cannot be used with"]),
        ("bench --tasks free.json --planner adm", &["adm", "did you mean adam?"]),
        ("bench --tasks free.json --planner gd --starts 0", &["starts", "0"]),
        ("bench --tasks free.json --planner gd --out no/r.json", &["no/r.json", "no such folder"]),
        ("bench --suite easy --count 5 --planner gd --robot-radius 1", &["--robot-radius"]),
        ("bench --suite easy --count 5 --planner gd --limit 1", &["--limit"]),
        ("table free.json --format html", &["--format", "markdown, csv"]),
    ]);
}
