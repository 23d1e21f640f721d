//! Pages hold what they were given, are small, and run nothing of it.

use super::*;
use sidestep::plane::geometry::lerp;
use sidestep::{Suite, Task};

fn page(title: &str, planner: &str, runs: usize, frames: usize) -> String {
    let task: Task = Suite::Easy.generate(1, 3, &sidestep::Profile::PAPER).remove(0);
    let plane = task.plane().unwrap();
    let path = |bend: f64| {
        let points: Vec<Point> = (0..12)
            .map(|i| {
                let t = f64::from(i) / 11.0;
                let [x, y] = lerp(plane.start, plane.goal, t);
                [x + bend * t * (1.0 - t), y]
            })
            .collect();
        Trajectory::from_points(&points)
    };
    let frame = |i: usize| Frame {
        label: i.to_string(),
        costs: Some([1.0 / (i + 1) as f64, 0.123_456_78]),
        clearance: -0.25,
        free: false,
        trajectory: path(i as f64),
    };
    let run = Run {
        planner: planner.into(),
        text: title.into(),
        frames: (0..frames).map(frame).collect(),
        blocked: Some(Block { segment: 3, place: [30.0, 20.0], obstacle: Some(1) }),
    };
    let replay = Replay {
        title: title.into(),
        lines: vec![title.into()],
        task: plane,
        epsilon: 5.0,
        shortest: None,
        runs: vec![run; runs],
        most_frames: MOST_FRAMES,
    };
    replay.to_html(|p| p[0] - 30.0)
}

fn data(html: &str) -> Value {
    let begin = html.find("id=\"data\">").unwrap() + 10;
    let end = begin + html[begin..].find("</script>").unwrap();
    serde_json::from_str(&html[begin..end]).unwrap()
}

#[test]
fn forty_iterations_of_four_planners_are_small() {
    let html = page("four", "gd", 4, 41);
    assert!(html.len() < 150_000, "{}", html.len());
    let data = data(&html);
    assert_eq!(data["runs"].as_array().unwrap().len(), 4);
    let frames = data["runs"][3]["frames"].as_array().unwrap();
    assert_eq!(frames.len(), 41);
    assert_eq!(frames[40]["obstacles"], 0.12346);
    assert_eq!(frames[40]["points"].as_array().unwrap().len(), 12);
}

#[test]
fn many_frames_are_thinned_and_keep_the_last() {
    let html = page("long", "gd", 4, 3001);
    assert!(html.len() < 300_000, "{}", html.len());
    let data = data(&html);
    let frames = data["runs"][0]["frames"].as_array().unwrap();
    assert!(frames.len() <= MOST_FRAMES / 4 + 1, "{}", frames.len());
    assert_eq!(frames.last().unwrap()["label"], "3000");
}

#[test]
fn nothing_of_the_input_is_code() {
    let evil = "</script><script>alert(1)</script><img src=x onerror=alert(1)>SCRIPT DATA VIEW";
    let html = page(evil, evil, 1, 2);
    assert!(!html.contains("<script>alert") && !html.contains("<img"));
    assert_eq!(html.matches("<script").count(), 2);
    assert_eq!(data(&html)["title"], evil);
}

#[test]
fn grids_are_told_cell_by_cell_and_coarser_where_large() {
    let cells: Vec<bool> = (0..6).map(|i| i == 0 || i == 5).collect();
    let small = grid(&Grid::new(3, 2, 0.5, [1.0, 2.0], cells).unwrap());
    assert_eq!(small["cells"], "84");
    let side = 2000;
    let cells = (0..side * side).map(|i| i == side * side - 1).collect();
    let large = grid(&Grid::new(side, side, 1.0, [0.0, 0.0], cells).unwrap());
    assert_eq!(large["width"], 500);
    assert_eq!(large["resolution"], 4.0);
    assert!(large["cells"].as_str().unwrap().ends_with('1'));
}

#[test]
fn the_field_spans_the_hinge() {
    let html = page("field", "gd", 1, 1);
    let world = &data(&html)["world"];
    let values = world["field"]["values"].as_str().unwrap();
    assert_eq!(values.len(), 96 * 96);
    assert!(values.starts_with('0') && values.ends_with('z'));
    assert_eq!(world["radius"], 0.0);
}
