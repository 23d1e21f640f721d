//! `robot`: what is read of robots with joints, the file that keeps it, and what is refused.

use std::fmt::Write;
use std::path::Path;

use tempfile::TempDir;

use crate::check;

const PANDA: &str = include_str!("../../../sidestep-io/tests/robots/panda_spherized.urdf");
const PANDA_SRDF: &str = include_str!("../../../sidestep-io/tests/robots/panda.srdf");

/// A cube of 20 cm as a mesh.
const CUBE: &str = "v -.1 -.1 -.1\nv .1 -.1 -.1\nv -.1 .1 -.1\nv .1 .1 -.1\nv -.1 -.1 .1\nv .1 -.1 .1\nv -.1 .1 .1\n\
                    v .1 .1 .1\nf 1 2 3\nf 2 3 4\nf 5 6 7\nf 6 7 8\nf 1 2 5\nf 2 5 6\nf 3 4 7\nf 4 7 8\n";

/// Two links and a joint between them; `joint` stands within it, `collision` in the second link.
fn two_links(joint: &str, collision: &str) -> String {
    format!(
        "<robot name='two'>\n<link name='base'><collision><geometry><sphere radius='0.1'/></geometry></collision></link>\n\
         <link name='arm'>{collision}</link>\n<joint name='turn' type='revolute'>\n<parent link='base'/><child link='arm'/>\n\
         <origin xyz='0 0 0.5'/><axis xyz='0 0 1'/>{joint}</joint>\n</robot>\n"
    )
}

const LIMIT: &str = "<limit lower='-1' upper='1' velocity='2' effort='9'/>";

fn write(folder: &Path, name: &str, text: &str) {
    let path = folder.join(name);
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    std::fs::write(path, text).unwrap();
}

fn pandas() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), "panda.urdf", PANDA);
    write(folder.path(), "panda.srdf", PANDA_SRDF);
    folder
}

#[test]
fn a_robot_is_described_and_kept() {
    let folder = pandas();
    let line = "robot panda.urdf --srdf panda.srdf --group panda_arm";
    let parts =
        ["7 move", "59 spheres: as they were given", "panda_joint4", "21 pairs", "group hand"];
    check(folder.path(), &format!("{line} --out a.json --picture a.svg"), 0, &parts);
    let told = check(folder.path(), &format!("{line} --json"), 0, &[]).json();
    assert_eq!(told["moving"][3]["name"], "panda_joint4");
    assert_eq!(told["spheres"], 59);
    // The kept robot reads to the same file, without URDF and SRDF.
    check(folder.path(), "robot a.json --out b.json", 0, &["59 spheres", "21 pairs"]);
    let read = |name| std::fs::read_to_string(folder.path().join(name)).unwrap();
    assert_eq!(read("a.json"), read("b.json"));
    assert!(read("a.svg").starts_with("<svg"));
    write(folder.path(), "bare.urdf", PANDA);
    // Without an SRDF neighbours may touch, and what was found is said.
    let parts = ["8 move", "that a joint joins (no SRDF)", "panda_link1 - panda_link2"];
    check(
        folder.path(),
        "robot bare.urdf --joints panda_joint1,panda_joint2,panda_joint3,panda_joint4,panda_joint5,panda_joint6,panda_joint7",
        0,
        &parts[1..],
    );
}

#[test]
fn shapes_are_covered_and_packages_found() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = |file: &str| {
        two_links(
            LIMIT,
            &format!("<collision><geometry><mesh filename='{file}'/></geometry></collision>"),
        )
    };
    write(folder.path(), "mine/urdf/two.urdf", &mesh("package://mine/meshes/cube.obj"));
    write(folder.path(), "mine/meshes/cube.obj", CUBE);
    write(folder.path(), "away.urdf", &mesh("package://other/cube.obj"));
    let covered = check(folder.path(), "robot mine/urdf/two.urdf", 0, &["cover 1 x mesh"]);
    assert!(covered.stdout.contains("stick out by"));
    let given = "robot away.urdf --package other=mine/meshes";
    check(folder.path(), &format!("{given} --overhang 0.03"), 0, &["cover 1 x mesh"]);
    check(folder.path(), "robot away.urdf", 2, &["package \"other\"", "--package other=DIR"]);
    check(folder.path(), &format!("{given} --overhang 0"), 2, &["--overhang", "above 0"]);
    let finest = format!("{given} --overhang 0.000001");
    check(folder.path(), &finest, 2, &["link arm.collision[0]", "overhang"]);
    let none = "robot away.urdf --package other=nowhere";
    check(folder.path(), none, 2, &["nowhere/cube.obj", "No such file"]);
}

#[test]
fn broken_robots_are_told_from_each_other() {
    let folder = tempfile::tempdir().unwrap();
    let good = two_links(LIMIT, "");
    let mut many = String::from("<robot name='many'>\n");
    for i in 0..10_001 {
        writeln!(many, "<link name='l{i}'/>").unwrap();
    }
    many += "</robot>";
    let mut bomb =
        String::from("<?xml version='1.0'?>\n<!DOCTYPE robot [<!ENTITY a0 'aaaaaaaaaa'>");
    for i in 1..12 {
        let entity = format!("&a{};", i - 1);
        write!(bomb, "<!ENTITY a{i} '{}'>", entity.repeat(10)).unwrap();
    }
    bomb += "]><robot name='&a11;'><link name='base'/></robot>";
    let circle = good.replace(
        "</robot>",
        "<joint name='back' type='fixed'><parent link='arm'/><child link='base'/></joint></robot>",
    );
    let rows: [(&str, &str, &[&str]); 12] = [
        ("no.urdf", "", &["no.urdf", "URDF"]),
        ("text.urdf", "robot", &["text.urdf"]),
        ("cut.urdf", &good[..good.len() / 2], &["cut.urdf", "line"]),
        ("limit.urdf", &two_links("", ""), &["joint turn.limit", "line 4"]),
        ("nan.urdf", &good.replace("0 0 0.5", "0 nan 0.5"), &["line 6", "origin", "finite"]),
        ("far.urdf", &good.replace("upper='1'", "upper='-2'"), &["joint turn", "line 4"]),
        ("circle.urdf", &circle, &["circle"]),
        ("link.urdf", &good.replace("child link='arm'", "child link='arms'"), &["arms", "line 5"]),
        ("many.urdf", &many, &["10000 links"]),
        ("bomb.urdf", &bomb, &["bomb.urdf"]),
        ("float.urdf", &good.replace("'revolute'", "'floating'"), &["floating", "line 4"]),
        ("own.json", "{\"format\": \"sidestep.robot/9\"}", &["sidestep.robot/1", "line 1"]),
    ];
    for (name, text, parts) in rows {
        write(folder.path(), name, text);
        check(folder.path(), &format!("robot {name}"), 2, parts);
    }
    write(folder.path(), "good.urdf", &good);
    write(folder.path(), "alone.urdf", &good);
    write(folder.path(), "bad.srdf", "<robot name='two'><group name='g'><joint/></group></robot>");
    write(
        folder.path(),
        "good.srdf",
        "<robot name='two'><group name='g'><joint name='turn'/></group></robot>",
    );
    let rows: [(&str, &[&str]); 7] = [
        ("robot good.urdf --srdf bad.srdf", &["bad.srdf", "line 1", "name"]),
        ("robot good.urdf --srdf none.srdf", &["none.srdf", "No such file"]),
        ("robot alone.urdf --group g", &["group", "an SRDF"]),
        ("robot good.urdf --srdf good.srdf --group f", &["\"f\"", "there are g"]),
        ("robot good.urdf --joints turns", &["\"turns\"", "such as \"turn\""]),
        ("robot good.urdf --held turns=1", &["\"turns\""]),
        ("robot good.urdf --out good.urdf", &["--out", ".json"]),
    ];
    for (line, parts) in rows {
        check(folder.path(), line, 2, parts);
    }
    // Nothing was written over.
    assert_eq!(std::fs::read_to_string(folder.path().join("good.urdf")).unwrap(), good);
}

#[test]
fn own_files_are_checked() {
    let folder = pandas();
    check(folder.path(), "robot panda.urdf --srdf panda.srdf --out good.json", 0, &[]);
    let good = std::fs::read_to_string(folder.path().join("good.json")).unwrap();
    let rows: [(&str, &str, &[&str]); 6] = [
        ("\"type\":\"revolute\"", "\"type\":\"round\"", &["joints[", "type", "revolute"]),
        ("\"parent\":\"panda_link0\"", "\"parent\":\"nobody\"", &["parent", "a link's name"]),
        ("\"overhang\": 0.0", "\"overhang\": -1", &["overhang", "at least 0"]),
        ("\"moving\": [\"panda_joint1\"", "\"moving\": [\"panda_joint9\"", &["panda_joint9"]),
        ("\"may_touch\": [[\"", "\"may_touch\": [[\"un", &["unpanda", "a link's name"]),
        ("\"links\": [\n{", "\"links\": [\n{\"mass\": 3, ", &["line 4", "mass"]),
    ];
    for (from, to, parts) in rows {
        assert!(good.contains(from), "{from}");
        write(folder.path(), "bad.json", &good.replacen(from, to, 1));
        check(folder.path(), "robot bad.json", 2, parts);
    }
}
