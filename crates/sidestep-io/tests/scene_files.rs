//! Scenes, meshes and clouds in everybody's formats: the same world from each, and every fault told.
#![allow(clippy::unwrap_used, reason = "a test")]

use sidestep::space::World;
use sidestep_io::scenes::{
    SceneOptions, mesh, points, read_problems, read_request, read_scene, write_problems,
};

const JSON: &str = r#"{"format": "sidestep.scene/1", "objects": [
  {"name": "table", "shapes": [{"box": {"half_extents": [0.4, 0.6, 0.02]}, "position": [0.5, 0, 0.3]}]},
  {"name": "can", "shapes": [{"cylinder": {"radius": 0.03, "length": 0.12},
    "position": [0.5, 0.1, 0.38], "quaternion_wxyz": [0.8, 0, 0.6, 0]}]},
  {"name": "ball", "shapes": [{"sphere": {"radius": 0.1}, "position": [0, 0, 1]}]}]}"#;

const PLANNING_SCENE: &str = "
name: (noname)
robot_model_name: panda
world:
  collision_objects:
    - header: {frame_id: world}
      id: table
      primitives:
        - type: box
          dimensions: [0.8, 1.2, 0.04]
      primitive_poses:
        - position: [0.5, 0, 0.3]
          orientation: [0, 0, 0, 1]
    - id: can
      pose: {position: {x: 0.5, y: 0.1, z: 0.38}, orientation: {x: 0, y: 0.6, z: 0, w: 0.8}}
      primitives:
        - {type: 3, dimensions: [0.12, 0.03]}
      primitive_poses:
        - position: [0, 0, 0]
      operation: add
    - id: ball
      primitives: [{type: sphere, dimensions: [0.1]}]
      primitive_poses: [{position: [0, 0, 1], orientation: [0, 0, 0, 1]}]
  octomap: {header: {frame_id: world}}
";

const SCENE_TEXT: &str = "(noname)+
* table
0.5 0 0
0 0 0 1
1
box
0.8 1.2 0.04
0 0 0.3
0 0 0 1
0 0 0 0
0
* can
0 0 0
0 0 0 1
1
cylinder
0.03 0.12
0.5 0.1 0.38
0 0.6 0 0.8
0 0 0 0
1
frame
1 2 3
0 0 0 1
* ball
0 0 1
0 0 0 1
1
sphere
0.1
0 0 0
0 0 0 1
0 0 0 0
0
.
";

const OLD_SCENE_TEXT: &str = "scene
* table
1
box
0.8 1.2 0.04
0.5 0 0.3
0 0 0 1
0 0 0 0
* can
1
cylinder
0.03 0.12
0.5 0.1 0.38
0 0.6 0 0.8
0 0 0 0
* ball
1
sphere
0.1
0 0 1
0 0 0 1
0 0 0 0
.
";

const CUROBO: &str = "
cuboid:
  table: {dims: [0.8, 1.2, 0.04], pose: [0.5, 0, 0.3, 1, 0, 0, 0], color: [1, 0, 0, 1]}
cylinder:
  can: {radius: 0.03, height: 0.12, pose: [0.5, 0.1, 0.38, 0.8, 0, 0.6, 0]}
sphere:
  ball: {radius: 0.1, position: [0, 0, 1]}
";

fn scene(name: &str, bytes: &[u8]) -> Result<World, String> {
    let mut files = |name: &str| match name {
        "tetrahedron.obj" => Ok(TETRAHEDRON.as_bytes().to_vec()),
        "cloud.xyz" => Ok(b"0 0 0\n1 1 1\n".to_vec()),
        _ => Err(std::io::Error::other("no such file")),
    };
    read_scene(name, bytes, SceneOptions::default(), &mut files).map_err(|error| error.to_string())
}

/// The name and the distance of each piece, at a few points.
fn fingerprint(world: &World) -> Vec<(String, Vec<f64>)> {
    let points = [[0.0; 3], [0.5, 0.1, 0.5], [1.0, -1.0, 0.3], [0.51, 0.1, 0.39]];
    let at = |piece| points.iter().map(|&p| world.distance(piece, p).0).collect();
    (0..world.pieces() as u32).map(|piece| (world.name_of(piece).to_owned(), at(piece))).collect()
}

#[test]
fn every_format_gives_the_same_world() {
    let expected = fingerprint(&scene("scene.json", JSON.as_bytes()).unwrap());
    assert_eq!(expected.len(), 3);
    let marked = format!("\u{feff}{JSON}");
    for (name, text) in [
        ("with a byte order mark.json", marked.as_str()),
        ("planning_scene.yaml", PLANNING_SCENE),
        ("today.scene", SCENE_TEXT),
        ("old.scene", OLD_SCENE_TEXT),
        ("curobo.yml", CUROBO),
    ] {
        let found = fingerprint(&scene(name, text.as_bytes()).unwrap());
        for (object, distances) in &expected {
            let (_, same) = found.iter().find(|(other, _)| other == object).unwrap();
            for (a, b) in distances.iter().zip(same) {
                assert!((a - b).abs() < 1e-9, "{name}, {object}: {a} and {b}");
            }
        }
    }
}

#[test]
fn every_shape_of_our_json() {
    let shapes = r#"{"format": "sidestep.scene/1", "objects": [{"name": "all", "shapes": [
        {"sphere": {"radius": 1}}, {"box": {"half_extents": [1, 1, 1]}, "rpy": [0, 0, 1.5]},
        {"cylinder": {"radius": 1, "length": 2}}, {"capsule": {"radius": 1, "length": 0}},
        {"hull": {"vertices": [[0,0,0],[1,0,0],[0,1,0],[0,0,1],[0.1,0.1,0.1]]}},
        {"hull": {"file": "tetrahedron.obj"}, "quaternion_xyzw": [0, 0, 0, 1]},
        {"mesh": {"file": "tetrahedron.obj", "scale": [2, 2, 2]}},
        {"mesh": {"vertices": [[0,0,0],[1,0,0],[0,1,0]], "triangles": [[0, 1, 2]]}},
        {"height_map": {"resolution": 0.1, "base": -1, "rows": [[0, 1], [2, 3], [-1, 0]]}},
        {"points": {"file": "cloud.xyz", "radius": 0.05}},
        {"points": {"positions": [[1, 2, 3]], "radius": 0}}]},
        {"name": "all", "shapes": [{"sphere": {"radius": 1}}]}]}"#;
    let world = scene("scene.json", shapes.as_bytes()).unwrap();
    assert_eq!(world.pieces(), 4 + 2 + 4 + 1 + 6 + 2 + 1 + 1);
    let kinds: Vec<_> = world.objects()[0].shapes().iter().map(|(_, s)| s.kind()).collect();
    let expected = ["sphere", "box", "cylinder", "capsule", "hull", "hull", "mesh", "mesh"];
    assert_eq!(kinds[..8], expected);
    assert_eq!(world.objects()[1].name(), "all (2)");
}

#[test]
fn faults_of_scenes_are_told() {
    let json = |from: &str, to: &str| JSON.replacen(from, to, 1);
    let yaml = |from: &str, to: &str| PLANNING_SCENE.replacen(from, to, 1);
    let text = |from: &str, to: &str| SCENE_TEXT.replacen(from, to, 1);
    let curobo = |from: &str, to: &str| CUROBO.replacen(from, to, 1);
    let deep = format!("{}1{}", "[".repeat(100_000), "]".repeat(100_000));
    let bomb = (0..40).fold("a0: &a0 [x, x]\n".to_owned(), |bomb, i| {
        format!("{bomb}a{}: &a{} [*a{i}, *a{i}]\n", i + 1, i + 1)
    });
    for (name, text, parts) in [
        ("a.json", json("/1", "/7"), "line 1, column 12, format: found \"sidestep.scene/7\""),
        ("a.json", json("0.02]", "-1]"), "objects[0].shapes[0].box.half_extents[2]: found -1"),
        ("a.json", json("0.02]", "NaN]"), "line 2"),
        ("a.json", json("0.3]", "1e400]"), "line 2"),
        ("a.json", json("0.8, 0", "2, 0"), "shapes[0].quaternion_wxyz: found [2.0, 0.0, 0.6"),
        ("a.json", json("\"box\"", "\"bux\""), "did you mean \"box\"?"),
        ("a.json", json("\"radius\": 0.1", "\"radius\": 0"), "objects[2].shapes[0].sphere.radius"),
        ("a.json", json("\"name\": \"can\", ", ""), "objects[1]: found no field \"name\""),
        ("a.json", json("{\"sphere\": {\"radius\": 0.1}, ", "{"), "exactly one of sphere, box"),
        ("a.json", "{".into(), "line 1"),
        ("a.json", format!("{{\"format\": {deep}}}"), "line 1"),
        ("a.yaml", yaml("type: box", "type: cone"), "primitives[0].type: found \"cone\""),
        ("a.yaml", yaml("1.2, ", ""), "primitives[0].dimensions: found 2 numbers"),
        ("a.yaml", yaml("0.04]", ".nan]"), "line 10, column 34"),
        ("a.yaml", yaml("[0, 0, 0, 1]", "[0, 0, 0, 0]"), "primitive_poses[0].orientation: found"),
        ("a.yaml", yaml("operation: add", "operation: remove"), "operation: found \"remove\""),
        ("a.yaml", yaml("        - position: [0, 0, 0]\n", "        []\n"), "found 0 poses"),
        ("a.yaml", yaml("id: can", "xd: can"), "no field \"id\""),
        ("a.yaml", yaml("id: can", "id: [can"), "line "),
        ("a.yaml", bomb, "found a fault"),
        ("a.yaml", format!("world: {}", "[".repeat(100_000)), "found a fault"),
        ("a.yaml", format!("world: {}", "{a: ".repeat(100_000)), "found a fault"),
        ("a.yaml", String::new(), "a.yaml"),
        ("a.scene", text("box", "bax"), "line 6: found \"bax\"; expected box, sphere"),
        ("a.scene", text("0.8 1.2 0.04", "0.8 1.2 x"), "line 7: found \"x\""),
        ("a.scene", text("0.8 1.2", "0.8 -1.2"), "line 7, half_extents[1]: found -0.6"),
        ("a.scene", text(".\n", ""), "found the end of the file"),
        ("a.scene", text("1\nbox", "4000000000\nbox"), "line "),
        ("a.scene", text("* table", "table"), "line 2: found \"table\""),
        ("a.scene", String::new(), "found the end of the file"),
        ("a.yml", curobo("dims", "dim"), "cuboid.table"),
        ("a.yml", curobo("cuboid", "cubiod"), "did you mean \"cuboid\"?"),
        ("a.yml", curobo("1, 0, 0, 0]", "1, 0, 0]"), "cuboid.table.pose: found 6 numbers"),
        ("a.yml", "mesh: {m: {file_path: no.obj, pose: [0,0,0,1,0,0,0]}}".into(), "\"no.obj\""),
    ] {
        let error = match scene(name, text.as_bytes()) {
            Err(error) => error,
            Ok(world) => panic!("{parts}: read {} pieces", world.pieces()),
        };
        // An empty file is any format; what it lacks is told.
        assert!(error.contains(parts) || parts == "a.yaml", "{error}\nlacks {parts}");
    }
    assert!(scene("a.json", b"{\"format\": \"\xff\"}").unwrap_err().contains("UTF-8"));
}

const TETRAHEDRON: &str = "# a comment\nv 0 0 0\nv 1 0 0 1.0\nv 0 1 0\nvn 0 0 1\nv 0 0 1\n\
    f 1 3 2\nf 1/1 2/2 4/3\nf -3//1 -2//1 -1//1\nf 3 1 4\n";

fn binary_stl(triangles: u32) -> Vec<u8> {
    let mut bytes = b"solid though binary".to_vec();
    bytes.resize(80, b' ');
    bytes.extend(triangles.to_le_bytes());
    let numbers = [[0.0, 0.0, 1.0], [0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0_f32]];
    bytes.extend(numbers.as_flattened().iter().flat_map(|v| v.to_le_bytes()));
    bytes.extend([0, 0]);
    bytes
}

const STL: &str = "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n\
    vertex 0 1e0 0\nendloop\nendfacet\nendsolid s\n";

#[test]
fn meshes_are_read() {
    let obj = mesh::read("a.OBJ", TETRAHEDRON.as_bytes()).unwrap();
    assert_eq!(obj.triangles, [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]);
    let text = mesh::read("a.stl", STL.as_bytes()).unwrap();
    assert_eq!(text, mesh::read("a.stl", &binary_stl(1)).unwrap());
    assert_eq!((text.vertices.len(), text.triangles.len()), (3, 1));
    let options = SceneOptions { hull: true, ..SceneOptions::default() };
    let mut none = |_: &str| Err(std::io::Error::other("no file"));
    let hull = read_scene("a.obj", TETRAHEDRON.as_bytes(), options, &mut none).unwrap();
    assert!(hull.distance(0, [0.1, 0.1, 0.1]).0 < 0.0);
}

#[test]
fn faults_of_meshes_are_told() {
    for (name, bytes, part) in [
        ("a.stl", binary_stl(2), "134 bytes for 2 triangles"),
        ("a.stl", binary_stl(u32::MAX), "134 bytes for 4294967295 triangles"),
        ("a.stl", STL.replace("1e0", "one").into_bytes(), "line 6"),
        ("a.stl", STL.replace("vertex 1 0 0\n", "").into_bytes(), "line 7: found a facet with 2"),
        ("a.stl", STL.replace("endfacet\n", "").into_bytes(), "the end within a facet"),
        ("a.stl", vec![], "nothing"),
        ("a.obj", TETRAHEDRON.replace("f 1 3 2", "f 1 3 9").into_bytes(), "line 7"),
        ("a.obj", TETRAHEDRON.replace("f 1 3 2", "f 1 3").into_bytes(), "line 7"),
        ("a.obj", TETRAHEDRON.replace("f 1 3 2", "f 0 1 2").into_bytes(), "line 7"),
        ("a.obj", TETRAHEDRON.replace("v 0 1 0", "v 0 1").into_bytes(), "line 4"),
        ("a.obj", TETRAHEDRON.replace("v 0 1 0", "v 0 nan 0").into_bytes(), "vertices[2][1]"),
        ("a.obj", vec![], "triangles"),
    ] {
        let error = scene(name, &bytes).unwrap_err();
        assert!(error.contains(part), "{error}\nlacks {part}");
    }
}

fn pcd(data: &str, points: usize) -> Vec<u8> {
    format!(
        "# .PCD v0.7\nVERSION 0.7\nFIELDS x rgb y z\nSIZE 4 4 8 4\nTYPE F U F F\nCOUNT 1 2 1 1\n\
         WIDTH {points}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {points}\nDATA {data}\n"
    )
    .into_bytes()
}

/// The two points of each cloud below, and one that is not finite.
const CLOUD: [[f32; 3]; 3] = [[0.5, -1.0, 2.0], [f32::NAN, 0.0, 0.0], [3.0, 4.0, 5.0]];

fn cloud_bytes(by_field: bool) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut field = |point: &[f32; 3], field: usize| match field {
        0 => bytes.extend(point[0].to_le_bytes()),
        1 => bytes.extend([7; 8]),
        2 => bytes.extend(f64::from(point[1]).to_le_bytes()),
        _ => bytes.extend(point[2].to_le_bytes()),
    };
    if by_field {
        (0..4).for_each(|i| CLOUD.iter().for_each(|point| field(point, i)));
    } else {
        CLOUD.iter().for_each(|point| (0..4).for_each(|i| field(point, i)));
    }
    bytes
}

fn packed(bytes: &[u8]) -> Vec<u8> {
    let plain = bytes.chunks(32).flat_map(|run| [&[run.len() as u8 - 1][..], run].concat());
    let plain: Vec<u8> = plain.collect();
    let lengths = [plain.len() as u32, bytes.len() as u32].map(u32::to_le_bytes);
    [lengths.as_flattened(), &plain].concat()
}

fn ply(format: &str) -> Vec<u8> {
    format!(
        "ply\nformat {format} 1.0\ncomment c\nelement camera 1\nproperty short s\nelement vertex 3\n\
         property float x\nproperty uchar i\nproperty double y\nproperty float z\n\
         element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    )
    .into_bytes()
}

fn ply_bytes(big: bool) -> Vec<u8> {
    let mut bytes = vec![1, 2];
    for point in CLOUD {
        let (x, y, z) = (point[0], f64::from(point[1]), point[2]);
        if big {
            bytes.extend(x.to_be_bytes().iter().chain(&[9]));
            bytes.extend(y.to_be_bytes().iter().chain(&z.to_be_bytes()));
        } else {
            bytes.extend(x.to_le_bytes().iter().chain(&[9]));
            bytes.extend(y.to_le_bytes().iter().chain(&z.to_le_bytes()));
        }
    }
    bytes
}

#[test]
fn clouds_are_read() {
    let expected = [[0.5, -1.0, 2.0], [3.0, 4.0, 5.0]];
    let text = b"0.5 1 1 -1 2\nnan 1 1 0 0\n3 1 1 4 5\n".to_vec();
    let ply_text = b"1\n0.5 9 -1 2\nnan 9 0 0\n3 9 4 5\n3 0 1 2\n".to_vec();
    for (name, bytes) in [
        ("a.pcd", [pcd("ascii", 3), text].concat()),
        ("a.pcd", [pcd("binary", 3), cloud_bytes(false)].concat()),
        ("a.pcd", [pcd("binary_compressed", 3), packed(&cloud_bytes(true))].concat()),
        ("a.ply", [ply("ascii"), ply_text].concat()),
        ("a.ply", [ply("binary_little_endian"), ply_bytes(false)].concat()),
        ("a.ply", [ply("binary_big_endian"), ply_bytes(true)].concat()),
        ("a.xyz", b"# x y z\n0.5,-1,2,255\n\nnan 0 0\n3;4;5 # five\n".to_vec()),
    ] {
        assert_eq!(points::read(name, &bytes).unwrap(), expected, "{name}");
    }
}

#[test]
fn faults_of_clouds_are_told() {
    let with = |bytes: Vec<u8>, from: &str, to: &str| {
        String::from_utf8(bytes).unwrap().replacen(from, to, 1).into_bytes()
    };
    let huge = usize::MAX.to_string();
    for (name, bytes, part) in [
        ("a.pcd", pcd("ascii", 3), "found 0 points; expected 3, as POINTS says"),
        ("a.pcd", pcd("binary", 3), "too few bytes for 3 points of 24"),
        ("a.pcd", pcd("binary", usize::MAX), "too few bytes"),
        ("a.pcd", pcd("binary_compressed", 3), "found 0 bytes"),
        ("a.pcd", [pcd("binary_compressed", 3), vec![0xff; 40]].concat(), "do not unpack"),
        ("a.pcd", with(pcd("binary", 3), "COUNT 1 2", &format!("COUNT 1 {huge}")), "COUNT"),
        ("a.pcd", with(pcd("binary", 3), "x rgb", "u rgb"), "FIELDS: found no x"),
        ("a.pcd", with(pcd("binary", 3), "SIZE 4 4", "SIZE 4"), "SIZE: found 3 values"),
        ("a.pcd", with(pcd("binary", 3), "SIZE 4", "SIZE 3"), "TYPE: found F of 3 bytes"),
        ("a.pcd", with(pcd("binary", 3), "DATA binary", "DATA zip"), "line 11"),
        ("a.pcd", b"hello".to_vec(), "line 1: found \"hello\""),
        ("a.pcd", vec![], "the end of the file"),
        ("a.ply", ply("ascii"), "found 0 vertices"),
        ("a.ply", ply("binary_big_endian"), "lists before the vertices"),
        ("a.ply", with(ply("ascii"), "vertex 3", &format!("vertex {huge}")), "vertices"),
        ("a.ply", with(ply("ascii"), "property float x", "property floot x"), "line 7"),
        ("a.ply", with(ply("ascii"), "end_header\n", ""), "without its end"),
        ("a.ply", b"plu\n".to_vec(), "line 1"),
        ("a.xyz", b"1 2\n".to_vec(), "line 1: found \"1 2\""),
        ("a.las", vec![], "a PCD, PLY or XYZ file"),
    ] {
        let error = points::read(name, &bytes).unwrap_err().to_string();
        assert!(error.contains(part), "{error}\nlacks {part}");
    }
}

const PROBLEMS: &str = r#"{"format": "sidestep.problems/1", "robot": "two.urdf", "joints": ["a", "b"],
  "fixed_joints": {"finger": 0.04},
  "problems": [{"name": "reach", "start": [0, 1], "goals": [[1, 2], [2, 3]], "objects":
    [{"name": "wall", "shapes": [{"box": {"half_extents": [1, 1, 1]}, "position": [3, 0, 0]}]}]}]}"#;

const CONVERTED: &str = r#"{"format": "sidestep-arm-problems/0", "source": "s", "robot": "panda",
  "units": "m, rad", "quaternion": "wxyz", "joints": ["a"], "fixed_joints": {"f": [0.065]},
  "problems": [{"set": "cage", "index": 3, "start": [0.5], "goals": [[1.5]], "obstacles": [
    {"name": "Can", "shape": "cylinder", "length": 0.2, "radius": 0.1, "position": [1, 0, 0], "quaternion": [1, 0, 0, 0]},
    {"name": "Can", "shape": "box", "half_extents": [0.1, 0.1, 0.1], "position": [0, 1, 0], "quaternion": [1, 0, 0, 0]}]}]}"#;

#[test]
fn problems_are_read() {
    let mut none = |_: &str| Err(std::io::Error::other("no file"));
    let ours = read_problems(PROBLEMS.as_bytes(), &mut none).unwrap();
    let problem = &ours[0];
    assert_eq!((problem.name.as_str(), &*problem.robot), ("reach", "two.urdf"));
    assert_eq!((problem.start.len(), problem.goals.len()), (2, 2));
    assert_eq!(problem.fixed_joints[..], [("finger".to_owned(), 0.04)]);
    assert!((problem.world.distance(0, [0.0; 3]).0 - 2.0).abs() < 1e-12);
    let converted = &read_problems(CONVERTED.as_bytes(), &mut none).unwrap()[0];
    assert_eq!((converted.name.as_str(), converted.world.pieces()), ("cage/3", 2));
    assert_eq!(converted.world.name_of(1), "Can (2)");
    assert_eq!(converted.fixed_joints[..], [("f".to_owned(), 0.065)]);
    for (from, to, part) in [
        ("problems/1", "problem/1", "did you mean \"sidestep.problems/1\"?"),
        ("[0, 1]", "[0]", "problems[0].start: found 1 numbers; expected 2 numbers"),
        ("[1, 2]", "[1, \"2\"]", "problems[0].goals[0][1]: found \"2\""),
        ("[[1, 2], [2, 3]]", "[]", "problems[0].goals: found an empty array"),
        ("\"b\"]", "\"a\"]", "joints[1]: found \"a\"; expected each joint once"),
        ("[\"a\", \"b\"]", "[]", "joints: found an empty array"),
        ("\"robot\": \"two.urdf\", ", "", "no field \"robot\""),
        ("[1, 1, 1]", "[1, 0, 1]", "problems[0].objects[0].shapes[0].box.half_extents[1]"),
    ] {
        let text = PROBLEMS.replacen(from, to, 1);
        let error = read_problems(text.as_bytes(), &mut none).unwrap_err().to_string();
        assert!(error.contains(part), "{error}\nlacks {part}");
    }
}

#[test]
fn problems_come_back() {
    let mut none = |_: &str| Err(std::io::Error::other("no file"));
    for text in [PROBLEMS, CONVERTED, EVERY_SHAPE] {
        let problems = read_problems(text.as_bytes(), &mut none).unwrap();
        let again = read_problems(write_problems(&problems).as_bytes(), &mut none).unwrap();
        assert_eq!(problems.len(), again.len());
        for (a, b) in problems.iter().zip(&again) {
            assert_eq!((&a.name, &a.start, &a.goals), (&b.name, &b.start, &b.goals));
            assert_eq!(
                (&a.robot, &a.joints, &a.fixed_joints),
                (&b.robot, &b.joints, &b.fixed_joints)
            );
            let (a, b) = (fingerprint(&a.world), fingerprint(&b.world));
            assert_eq!(a.len(), b.len());
            for ((name, a), (other, b)) in a.iter().zip(&b) {
                assert_eq!(name, other);
                assert!(a.iter().zip(b).all(|(a, b)| a == b || (a - b).abs() < 1e-12), "{name}");
            }
        }
    }
}

const EVERY_SHAPE: &str = r#"{"format": "sidestep.problems/1", "robot": "r", "joints": ["a"],
  "problems": [{"name": "all", "start": [0.1], "goals": [[0.30000000000000004]], "objects":
    [{"name": "all", "shapes": [
        {"sphere": {"radius": 1}}, {"box": {"half_extents": [1, 0.1, 1]}, "rpy": [0.3, 3, 1.5]},
        {"cylinder": {"radius": 1, "length": 2}, "position": [1, 2, 3]},
        {"capsule": {"radius": 1, "length": 0}},
        {"hull": {"vertices": [[0,0,0],[1,0,0],[0,1,0],[0,0,1],[0.1,0.1,0.1]]}},
        {"mesh": {"vertices": [[0,0,0],[1,0,0],[0,1,0]], "triangles": [[0, 1, 2]]}},
        {"height_map": {"resolution": 0.1, "base": -1, "rows": [[0, 1], [2, 3], [-1, 0]]}},
        {"points": {"positions": [[1, 2, 3]], "radius": 0}}]}]}]}"#;

#[test]
fn requests_are_read() {
    const REQUEST: &str = "
group_name: arm
start_state: {joint_state: {name: [a, b], position: [0.5, 1e-3]}}
goal_constraints:
  - joint_constraints:
      - {joint_name: a, position: 1, tolerance_above: 0.1, weight: 1}
      - {joint_name: b, position: 2}
";
    let request = read_request(REQUEST.as_bytes()).unwrap();
    let pairs = |a, b| vec![("a".to_owned(), a), ("b".to_owned(), b)];
    assert_eq!(request.group, "arm");
    assert_eq!((request.start, request.goals), (pairs(0.5, 0.001), vec![pairs(1.0, 2.0)]));
    for (from, to, part) in [
        ("[0.5, 1e-3]", "[0.5]", "start_state.joint_state.position: found 1 numbers"),
        ("joint_name: b", "joint: b", "joint_constraints[1]: found no field \"joint_name\""),
        ("group_name: arm", "", "\"group_name\""),
    ] {
        let error = read_request(REQUEST.replacen(from, to, 1).as_bytes()).unwrap_err().to_string();
        assert!(error.contains(part), "{error}\nlacks {part}");
    }
}
