//! `serve`: requests answered in order, bad ones too, and cancelled plans.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Command, Stdio};

use serde_json::Value;

use crate::folder;

/// The answers to requests on standard input.
fn answers(requests: &[u8]) -> Vec<Value> {
    let folder = folder();
    let mut server = Command::new(env!("CARGO_BIN_EXE_sidestep"))
        .args(["serve", "block.json"])
        .current_dir(folder.path())
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    server.stdin.take().unwrap().write_all(requests).unwrap();
    let mut text = String::new();
    server.stdout.take().unwrap().read_to_string(&mut text).unwrap();
    assert!(server.wait().unwrap().success());
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

#[test]
fn obstacles_come_and_go_and_plans_go_round_them() {
    let plan = r#"{"op":"plan","id":7,"start":[1,1],"goal":[9,9],"warm":true}"#;
    let requests = [
        plan,
        r#"{"op":"set","name":"b","obstacle":"rect:7.5,3,9.5,6"}"#,
        plan,
        r#"{"op":"set","name":"b","obstacle":"rect:-1,2,11,3"}"#,
        plan,
        r#"{"op":"remove","name":"b"}"#,
        plan,
        r#"{"op":"info","id":"i"}"#,
        r#"{"op":"plan","start":[-0.5,1],"goal":[9,9],"snap":1}"#,
    ]
    .join("\n");
    let answers = answers(requests.as_bytes());
    let status = |i: usize| answers[i]["status"].as_str().unwrap();
    assert_eq!(answers.len(), 9);
    assert!(answers[8]["warnings"][0].as_str().unwrap().contains("was moved by 0.500"));
    assert!(answers[0]["warnings"].as_array().unwrap().is_empty());
    assert!(answers[2]["clearance"].as_f64().unwrap() >= 0.0);
    assert_eq!(
        [status(0), status(2), status(4), status(6)],
        ["solved", "solved", "unsolvable", "solved"]
    );
    assert_eq!((&answers[0]["id"], &answers[7]["id"]), (&Value::from(7), &Value::from("i")));
    assert!(answers[2]["origin"].as_str().unwrap().contains("warm start"), "{}", answers[2]);
    assert_eq!(answers[4]["nav2_error_code"], 208);
    let poses = answers[0]["poses"].as_array().unwrap();
    assert_eq!((&poses[0][0], &poses[0][1]), (&Value::from(1.0), &Value::from(1.0)));
    assert!(poses.windows(2).all(|pair| pair[0][3].as_f64() < pair[1][3].as_f64()));
}

#[test]
fn bad_requests_are_answered_and_end_nothing() {
    let long = vec![b'x'; (1 << 20) + 5];
    let requests: Vec<&[u8]> = vec![
        b"nonsense",
        b"{\"op\":\"fly\"}",
        b"{\"op\":\"plan\",\"start\":[1,1]}",
        b"{\"op\":\"plan\",\"start\":[1,1],\"goal\":[9,9],\"budget_ms\":-1}",
        b"{\"op\":\"plan\",\"start\":[1,1],\"goal\":[9,9],\"planner\":\"nobody\"}",
        b"{\"op\":\"plan\",\"start\":[1,1],\"goal\":[1e300,9]}",
        b"{\"op\":\"set\",\"name\":\"a\",\"obstacle\":\"rect:1\"}",
        b"{\"op\":\"remove\",\"name\":\"a\"}",
        &long,
        b"\xff\xfe",
        b"[[[[[[[[",
        b"",
        b"{\"op\":\"plan\",\"start\":[1,1],\"goal\":[90,9]}",
        b"{\"op\":\"plan\",\"start\":[1,1],\"goal\":[9,9]}",
        b"{\"op\":\"pl",
    ];
    let answers = answers(&requests.join(&b'\n'));
    assert_eq!(answers.len(), 14);
    for (index, answer) in answers.iter().enumerate() {
        let is_plan = (11..13).contains(&index);
        assert_eq!(answer["ok"], is_plan, "{index}: {answer}");
        assert!(is_plan || !answer["error"].as_str().unwrap().is_empty());
    }
    assert_eq!(
        (&answers[11]["status"], &answers[11]["nav2_error_code"]),
        (&"invalid".into(), &204.into())
    );
    assert_eq!(answers[12]["status"], "solved");
}

#[test]
fn clients_of_a_port_have_obstacles_of_their_own() {
    let folder = folder();
    let mut server = Command::new(env!("CARGO_BIN_EXE_sidestep"))
        .args(["serve", "block.json", "--port", "0"])
        .current_dir(folder.path())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut line = String::new();
    BufReader::new(server.stdout.as_mut().unwrap()).read_line(&mut line).unwrap();
    let listening: Value = serde_json::from_str(&line).unwrap();
    let address = listening["listening"].as_str().unwrap();
    let mut clients: Vec<TcpStream> =
        (0..5).map(|_| TcpStream::connect(address).unwrap()).collect();
    let mut ask = |client: usize, request: &str| -> Value {
        writeln!(clients[client], "{request}").unwrap();
        let mut line = String::new();
        BufReader::new(&clients[client]).read_line(&mut line).unwrap();
        serde_json::from_str(&line).unwrap()
    };
    ask(0, r#"{"op":"set","name":"wall","obstacle":"rect:-1,2,11,3"}"#);
    let plan = r#"{"op":"plan","start":[1,1],"goal":[9,9],"budget_ms":200}"#;
    assert_eq!(ask(0, plan)["status"], "unsolvable");
    for client in 1..5 {
        assert_eq!(ask(client, plan)["status"], "solved");
    }
    // A client that leaves in the middle of a request takes nobody with it.
    clients[0].write_all(b"{\"op\":").unwrap();
    drop(clients.remove(0));
    let mut line = String::new();
    writeln!(clients[0], "{plan}").unwrap();
    BufReader::new(&clients[0]).read_line(&mut line).unwrap();
    assert!(line.contains("solved"));
    server.kill().unwrap();
    server.wait().unwrap();
}

/// The code between ```LANGUAGE and ``` in docs/serve.md.
fn example(language: &str) -> String {
    let page = include_str!("../../../../docs/serve.md");
    let code = page.split(&format!("```{language}\n")).nth(1).unwrap();
    code.split("```").next().unwrap().to_owned()
}

/// Runs a command where the repository is, with the program on the path; none where there is no such command.
fn ran(program: &str, arguments: &[&str]) -> Option<String> {
    let here = std::path::Path::new(env!("CARGO_BIN_EXE_sidestep")).parent().unwrap();
    let path = format!("{}:{}", here.display(), std::env::var("PATH").unwrap_or_default());
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
    let run = Command::new(program).args(arguments).current_dir(root).env("PATH", path).output();
    let Ok(run) = run else {
        eprintln!("skipped: there is no {program}");
        return None;
    };
    assert!(run.status.success(), "{program}: {}", String::from_utf8_lossy(&run.stderr));
    Some(String::from_utf8(run.stdout).unwrap())
}

#[cfg(unix)]
#[test]
fn the_documented_clients_get_their_plans() {
    let python = ran("python3", &["-c", &example("python")]);
    if let Some(said) = python {
        let count: usize = said.trim().strip_prefix("solved ").unwrap().parse().unwrap();
        assert!(count > 100, "{said}");
    }
    let folder = folder();
    let (source, client) = (folder.path().join("client.cpp"), folder.path().join("client"));
    std::fs::write(&source, example("cpp")).unwrap();
    let [source, client] = [&source, &client].map(|path| path.to_str().unwrap());
    if ran("c++", &["-std=c++17", source, "-o", client]).is_some() {
        assert_eq!(ran(client, &[]).unwrap(), "solved\n");
    }
}
