//! Good and bad task documents: what the reader says, and that the published JSON Schema agrees.

#![allow(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

use serde_json::Value;
use sidestep_io::{TaskFormat, read_tasks, write_tasks};

/// What the schema and the reader make of a document.
#[derive(Clone, Copy, PartialEq)]
enum Verdict {
    Good,
    /// Refused by both; the reader's message holds the text.
    Bad(&'static str),
    /// Refused by the reader alone, for something that a schema cannot say.
    BadBeyondSchema(&'static str),
}

use Verdict::{Bad, BadBeyondSchema, Good};

/// A document with `fields` in the place of or beside those of a plain good task; `null` removes one.
fn document(fields: &str) -> String {
    let mut task: Value = serde_json::from_str(
        r#"{"format": "sidestep.task/1", "bounds": [[0, 0], [64, 48]], "start": [1, 1], "goal": [60, 40]}"#,
    )
    .unwrap();
    let changes: Value = serde_json::from_str(&format!("{{{fields}}}")).unwrap();
    for (key, value) in changes.as_object().unwrap() {
        if key == "format" && value.is_null() {
            task.as_object_mut().unwrap().remove(key);
        } else {
            task[key] = value.clone();
        }
    }
    task.to_string()
}

const TABLE: &[(&str, Verdict)] = &[
    ("", Good),
    (r#""name": "x", "obstacles": [], "grid": null, "robot": "point""#, Good),
    (
        r#""obstacles": [{"rect": [[0, 0], [1, 1e-9]]}, {"circle": {"center": [1, 2], "radius": 3}}]"#,
        Good,
    ),
    (r#""obstacles": [{"polygon": [[0, 0], [0, 1], [1, 0]]}]"#, Good),
    (r##""grid": {"resolution": 0.5, "origin": [-1, 2], "rows": ["3.2#", "....#"]}"##, Good),
    (r#""robot": {"disc": {"radius": 0.5}}"#, Good),
    (r#""robot": {"disc": {"radius": 0}}"#, Good),
    (r#""format": null"#, Bad(r#"found no field "format"; expected "format": "sidestep.task/1""#)),
    (
        r#""format": "sidestep.task/2""#,
        Bad(r#"format: found "sidestep.task/2"; expected "sidestep.task/1""#),
    ),
    (r#""format": 1"#, Bad("format: found 1; expected a string")),
    (r#""bounds": null"#, Bad("bounds: found null; expected [[x0, y0], [x1, y1]]")),
    (r#""bounds": [[0, 0], [64, 48], [1, 1]]"#, Bad("bounds: found an array of 3; expected [[x0")),
    (
        r#""bounds": [[0, 0], [-1, 48]]"#,
        BadBeyondSchema("bounds[1][0]: found -1; expected more than [0][0] = 0"),
    ),
    (
        r#""bounds": [[0, 0], [2e9, 48]]"#,
        Bad("bounds[1][0]: found 2000000000; expected a finite number of magnitude"),
    ),
    (
        r#""stat": [1, 2]"#,
        Bad(
            r#"stat: found the unknown field "stat"; expected one of format, name, bounds, obstacles, grid, robot, start, goal (did you mean "start"?)"#,
        ),
    ),
    (r#""colour": 1"#, Bad(r#"found the unknown field "colour"; expected one of format"#)),
    (r#""name": 3"#, Bad("name: found 3; expected a string")),
    (r#""start": [1]"#, Bad("start: found an array of 1; expected a point [x, y]")),
    (r#""start": ["1", 2]"#, Bad(r#"start[0]: found "1"; expected a number"#)),
    (r#""goal": {"x": 1}"#, Bad("goal: found an object; expected a point [x, y]")),
    (r#""goal": [1, 1e12]"#, Bad("goal[1]: found 1000000000000; expected a finite number")),
    (r#""obstacles": {}"#, Bad("obstacles: found an empty object; expected an array of obstacles")),
    (
        r#""obstacles": [{"rectangle": [[0, 0], [1, 1]]}]"#,
        Bad(
            r#"obstacles[0].rectangle: found the unknown field "rectangle"; expected one of rect, circle, polygon"#,
        ),
    ),
    (r#""obstacles": [{"cirle": 1}]"#, Bad(r#"(did you mean "circle"?)"#)),
    (
        r#""obstacles": [{}]"#,
        Bad(
            "obstacles[0]: found an object with 0 fields; expected exactly one of rect, circle, polygon",
        ),
    ),
    (
        r#""obstacles": [{"rect": [[1, 0], [1, 1]]}]"#,
        BadBeyondSchema("obstacles[0].rect[1][0]: found 1; expected more than [0][0] = 1"),
    ),
    (
        r#""obstacles": [{"circle": {"center": [0, 0], "radius": -1}}]"#,
        Bad("obstacles[0].circle.radius: found -1; expected a number above 0"),
    ),
    (
        r#""obstacles": [{"circle": {"center": [0, 0]}}]"#,
        Bad(r#"obstacles[0].circle: found no field "radius"; expected "radius": a number above 0"#),
    ),
    (
        r#""obstacles": [{"polygon": [[0, 0], [1, 1]]}]"#,
        Bad("obstacles[0].polygon: found 2 different vertices; expected at least 3"),
    ),
    (
        r#""obstacles": [{"polygon": [[0, 0], [1, 1], [2, 2]]}]"#,
        BadBeyondSchema("obstacles[0].polygon: found 3 vertices on one line"),
    ),
    (
        r#""robot": "disc""#,
        Bad(r#"robot: found "disc"; expected "point" or {"disc": {"radius": r}}"#),
    ),
    (
        r#""robot": {"disc": {"radius": -0.5}}"#,
        Bad("robot.disc.radius: found -0.5; expected a number of at least 0"),
    ),
    (
        r#""grid": {"resolution": 0, "rows": ["."]}"#,
        Bad("grid.resolution: found 0; expected a number above 0"),
    ),
    (
        r#""grid": {"resolution": 1, "rows": []}"#,
        Bad("grid.rows: found no row; expected at least one row"),
    ),
    (
        r#""grid": {"resolution": 1, "rows": ["...", ".."]}"#,
        BadBeyondSchema("grid.rows[1]: found a row of 2 cells; expected 3 cells"),
    ),
    (
        r#""grid": {"resolution": 1, "rows": ["..x"]}"#,
        Bad("grid.rows[0]: found 'x' at character 3; expected '.' (free) or '#' (occupied)"),
    ),
    (
        r#""grid": {"resolution": 1, "rows": ["999999999."]}"#,
        BadBeyondSchema("grid.rows[0]: found a repeat count of 999999999"),
    ),
    (
        r#""grid": {"resolution": 1, "rows": ["200000000.", "200000000."]}"#,
        BadBeyondSchema(
            "grid.rows: found more than 0 rows of 200000000 cells in 10 bytes; expected at most 67108864 cells",
        ),
    ),
    (
        r#""grid": {"resolution": 1, "width": 3, "rows": ["..."]}"#,
        Bad(r#"grid.width: found the unknown field "width""#),
    ),
];

#[test]
fn reader_and_schema_agree() {
    let schema: Value =
        serde_json::from_str(include_str!("../../../schemas/task-1.schema.json")).unwrap();
    for &(fields, verdict) in TABLE {
        let text = document(fields);
        let allowed = schema_allows(&schema, &schema, &serde_json::from_str(&text).unwrap());
        assert_eq!(allowed, !matches!(verdict, Bad(_)), "schema on {fields}");
        match (read_tasks(&text, TaskFormat::Json), verdict) {
            (Ok(tasks), Good) => assert_eq!(tasks.len(), 1),
            (Err(error), Bad(message) | BadBeyondSchema(message)) => {
                let error = error.to_string();
                assert!(
                    error.contains(message),
                    "{fields}\n     got: {error}\nexpected: {message}"
                );
                assert!(error.starts_with("task JSON, line 1, column "), "{error}");
            }
            (result, _) => panic!("{fields}: {result:?}"),
        }
    }
}

#[test]
fn faults_of_whole_files_are_placed() {
    use TaskFormat::{Json, JsonLines};
    let good = document("");
    for (text, format, message) in [
        (
            "",
            Json,
            "task JSON, line 1, column 1: found EOF while parsing a value; expected valid JSON",
        ),
        ("[]", Json, "task JSON: found no task; expected at least one task"),
        ("\n\n", JsonLines, "task JSON: found no task"),
        ("7", Json, "line 1, column 1: found 7; expected an object with the fields format"),
        ("{\n \"start\": [NaN, 1]}", Json, "line 2, column 12: found what is not a value"),
        (
            "{\n \"start\": [1e999, 1]}",
            Json,
            "line 2, column 16: found number out of range; expected a number of magnitude",
        ),
        (
            "{\"start\": [Infinity, 1]}",
            Json,
            "found what is not a value; expected valid JSON (no NaN, Infinity",
        ),
        (
            "{\"start\": 1,\n\"start\": 2}",
            Json,
            "line 2, column 11: found the key \"start\" twice; expected each key once",
        ),
        (
            &format!("{good}\n\n{{\"a\": 1}}"),
            JsonLines,
            "task JSON, line 3, column 7, a: found the unknown field",
        ),
        (&format!("{good}\n{{"), JsonLines, "task JSON, line 2, column 1: found EOF"),
        (
            &format!("[{good},\n{}]", document("\"start\": 5")),
            Json,
            "[1].start: found 5; expected a point",
        ),
        (&format!("[{good}, 3]"), Json, "[1]: found 3; expected an object"),
        (&"[".repeat(100_000), Json, "recursion limit exceeded"),
    ] {
        let error = read_tasks(text, format).unwrap_err().to_string();
        let shown: String = text.chars().take(200).collect();
        assert!(error.contains(message), "{shown}\n     got: {error}\nexpected: {message}");
    }
}

/// The example at the repository's root is a task of the paper's kind, laid out as the writer does.
#[test]
fn the_example_is_canonical() {
    let text = include_str!("../../../examples/rectangles.json");
    let tasks = read_tasks(text, TaskFormat::Json).unwrap();
    assert_eq!(tasks[0].plane().unwrap().world.obstacles().len(), 10);
    assert_eq!(tasks[0].plane().unwrap().world.bounds().max, [64.0, 64.0]);
    assert_eq!(write_tasks(&tasks, TaskFormat::Json).unwrap(), text);
}

/// A check of the draft 2020-12 keywords that our schema uses; any other keyword fails the test.
fn schema_allows(root: &Value, schema: &Value, value: &Value) -> bool {
    let number = |v: &Value| v.as_f64().unwrap();
    let length = |v: &Value| v.as_u64().unwrap() as usize;
    schema.as_object().unwrap().iter().all(|(keyword, rule)| match keyword.as_str() {
        "$schema" | "$id" | "title" | "description" | "default" | "$defs" => true,
        "$ref" => {
            let pointer = rule.as_str().unwrap().strip_prefix('#').unwrap();
            schema_allows(root, root.pointer(pointer).unwrap(), value)
        }
        "oneOf" => {
            let options = rule.as_array().unwrap().iter();
            options.filter(|option| schema_allows(root, option, value)).count() == 1
        }
        "const" => value == rule,
        "type" => match rule.as_str().unwrap() {
            "object" => value.is_object(),
            "array" => value.is_array(),
            "string" => value.is_string(),
            "number" => value.is_number(),
            "null" => value.is_null(),
            other => panic!("type {other}"),
        },
        "minimum" => !value.is_number() || number(value) >= number(rule),
        "maximum" => !value.is_number() || number(value) <= number(rule),
        "exclusiveMinimum" => !value.is_number() || number(value) > number(rule),
        "items" => value
            .as_array()
            .is_none_or(|items| items.iter().all(|item| schema_allows(root, rule, item))),
        "minItems" => value.as_array().is_none_or(|items| items.len() >= length(rule)),
        "maxItems" => value.as_array().is_none_or(|items| items.len() <= length(rule)),
        "minProperties" => value.as_object().is_none_or(|fields| fields.len() >= length(rule)),
        "maxProperties" => value.as_object().is_none_or(|fields| fields.len() <= length(rule)),
        "properties" => value.as_object().is_none_or(|fields| {
            let known = rule.as_object().unwrap();
            known.iter().all(|(key, rule)| {
                fields.get(key).is_none_or(|field| schema_allows(root, rule, field))
            })
        }),
        "required" => value.as_object().is_none_or(|fields| {
            rule.as_array().unwrap().iter().all(|key| fields.contains_key(key.as_str().unwrap()))
        }),
        "additionalProperties" => value.as_object().is_none_or(|fields| {
            let known = schema["properties"].as_object().unwrap();
            rule == &Value::Bool(false) && fields.keys().all(|key| known.contains_key(key))
        }),
        "pattern" => {
            assert_eq!(rule, "^(([1-9][0-9]{0,8})?[.#])+$");
            value.as_str().is_none_or(is_runs)
        }
        other => panic!("the schema uses {other}, which this check does not know"),
    })
}

/// `^(([1-9][0-9]{0,8})?[.#])+$`
fn is_runs(text: &str) -> bool {
    text.ends_with(['.', '#'])
        && text.split_inclusive(['.', '#']).all(|run| {
            let count = &run[..run.len() - 1];
            count.is_empty()
                || (count.len() <= 9
                    && !count.starts_with('0')
                    && count.bytes().all(|digit| digit.is_ascii_digit()))
        })
}
