//! Pictures: what a reader would see at chosen pixels, and that no values break the drawing.

#![allow(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

use std::sync::Arc;

use proptest::prelude::*;
use sidestep::plane::geometry::{Circle, Point, Rect};
use sidestep::{Grid, Obstacle, Robot, Task, Trajectory, World};
use sidestep_io::picture::{BandPoint, Bar, Chart, Picture, TaskPanel, palette};

const WHITE: [u8; 3] = [255; 3];
const OBSTACLE: [u8; 3] = [0x9f, 0xab, 0xb7];

/// A decoded PNG.
struct Pixels {
    width: usize,
    height: usize,
    rgb: Vec<u8>,
}

impl Pixels {
    fn of(png: &[u8]) -> Self {
        let mut reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
        let mut rgb = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut rgb).unwrap();
        assert_eq!(info.color_type, png::ColorType::Rgb);
        Self { width: info.width as usize, height: info.height as usize, rgb }
    }

    /// The colour at a position of the SVG, the bitmap being drawn at scale 2.
    fn at(&self, x: f64, y: f64) -> [u8; 3] {
        let index = 3 * ((2.0 * y) as usize * self.width + (2.0 * x) as usize);
        self.rgb[index..index + 3].try_into().unwrap()
    }

    fn count(&self, color: [u8; 3]) -> usize {
        self.rgb.as_chunks::<3>().0.iter().filter(|&&pixel| pixel == color).count()
    }
}

fn task() -> Task {
    let obstacles = vec![
        Obstacle::Rect(Rect::new([20.0, 0.0], [30.0, 40.0]).unwrap()),
        Obstacle::Circle(Circle::new([60.0, 60.0], 8.0).unwrap()),
    ];
    // The grid's lower left cell is occupied.
    let grid = Grid::new(2, 2, 5.0, [40.0, 0.0], vec![true, false, false, false]).unwrap();
    let bounds = Rect::new([0.0, 0.0], [100.0, 80.0]).unwrap();
    let world = Arc::new(World::new(bounds, obstacles, Some(grid)));
    Task::in_plane("<walls> & \u{1}", world, Robot::disc(3.0).unwrap(), [5.0, 5.0], [90.0, 5.0])
        .unwrap()
}

#[test]
fn a_task_shows_what_is_where() {
    let task = task();
    let over = Trajectory::from_points(&[[5.0, 5.0], [25.0, 60.0], [90.0, 5.0]]);
    let panel = TaskPanel::new(task.plane().unwrap()).title("").path("over", &over).shade(|p| p[1]);
    let picture = Picture::new().panel_width(500.0).panel(panel);
    let svg = picture.to_svg();
    assert!(svg.starts_with("<svg ") && svg.ends_with("</svg>\n"));
    let pixels = Pixels::of(&picture.to_png(2.0).unwrap());
    assert_eq!(pixels.width, 2 * 540);
    // 34 units for the axis; 4.66 of the SVG to one of the task; a margin of 20; y upwards.
    let at = |p: Point| pixels.at(54.0 + 4.66 * p[0], 20.0 + 4.66 * (80.0 - p[1]));
    assert_eq!(pixels.at(3.0, 3.0), WHITE);
    assert_eq!(at([22.0, 10.0]), OBSTACLE);
    assert_eq!(at([60.0, 65.0]), OBSTACLE);
    assert_eq!(at([42.5, 2.5]), OBSTACLE);
    assert_ne!(at([47.5, 2.5]), OBSTACLE);
    assert_eq!(at([57.5, 32.5]), palette(0).rgb, "on the path");
    // The shade is darker below; the swept disc tints it beside the path.
    assert!(at([80.0, 70.0])[0] > at([70.0, 2.0])[0]);
    assert_ne!(at([57.5, 34.5]), at([57.5, 40.0]));
}

#[test]
fn text_is_escaped_and_drawn() {
    let picture =
        |title: &str| Picture::new().panel(TaskPanel::new(task().plane().unwrap()).title(title));
    let named = Picture::new().panel(TaskPanel::new(task().plane().unwrap()));
    assert!(named.to_svg().contains(">&lt;walls&gt; &amp;  </text>"), "{}", named.to_svg());
    let dark = |title: &str| {
        let pixels = Pixels::of(&picture(title).to_png(2.0).unwrap());
        pixels.count([0x1f, 0x29, 0x33])
    };
    assert!(dark("WWWWWWWW") > dark("W") + 500, "a title must leave ink without any system font");
    let long = picture(&"a long title ".repeat(100));
    assert!(long.to_svg().contains("…</text>"));
}

#[test]
fn charts_show_curves_bars_and_levels() {
    let flat: Vec<BandPoint> =
        (0..=10).map(|i| BandPoint { x: f64::from(i), mean: 0.5, low: 0.3, high: 0.7 }).collect();
    let curve = Chart::new("curve", "x", "y").y_range(0.0, 1.0).curve("flat", &flat);
    let bar = Bar { value: 0.8, low: 0.7, high: 0.9 };
    let bars = Chart::new("bars", "", "y").categories(&["a", "b"]).bars("one", &[bar, bar]);
    let both = Picture::new().panel(curve.level("paper", 0.9)).panel(bars).columns(2);
    let pixels = Pixels::of(&both.to_png(2.0).unwrap());
    assert!(pixels.count(palette(0).rgb) > 20_000, "the bars");
    let svg = both.to_svg();
    for text in ["flat", "paper", "curve", "bars", "one", "a", "b", "0.5", "0.6"] {
        let found = svg.contains(&format!(">{text}</text>"));
        assert_eq!(found, text != "0.5", "{text}");
    }
    assert_eq!(both.to_png(2.0).unwrap(), both.to_png(2.0).unwrap());
}

#[test]
fn legends_are_shared_where_they_agree() {
    let (task, line) = (task(), Trajectory::from_points(&[[5.0, 5.0], [90.0, 5.0]]));
    let panel = |label: &str| TaskPanel::new(task.plane().unwrap()).path(label, &line);
    let legends = |picture: Picture| picture.to_svg().matches(">goal</text>").count();
    assert_eq!(legends(Picture::new().panel(panel("gd")).panel(panel("gd"))), 1);
    assert_eq!(legends(Picture::new().panel(panel("gd")).panel(panel("learned"))), 2);
    let own = TaskPanel::new(task.plane().unwrap()).path_in("learned", &line, palette(1));
    assert_eq!(legends(Picture::new().panel(panel("gd")).panel(own)), 1);
}

#[test]
fn a_bitmap_beyond_reason_is_refused() {
    for scale in [100.0, f64::NAN, f64::INFINITY] {
        let error = Picture::new()
            .panel(TaskPanel::new(task().plane().unwrap()))
            .to_png(scale)
            .unwrap_err();
        assert!(error.to_string().starts_with("PNG picture, width x height: found "), "{error}");
        assert!(error.to_string().contains("at most 16384 on either side"), "{error}");
    }
    let empty = Pixels::of(&Picture::new().to_png(0.001).unwrap());
    assert_eq!((empty.width, empty.height), (1, 1));
}

/// Whether no attribute but an image's data and no path holds a number that is none.
fn has_finite_numbers(svg: &str) -> bool {
    let attributes = svg.split(['<', '>']).flat_map(|tag| tag.split('"').skip(1).step_by(2));
    let mut numbers = attributes.filter(|value| !value.starts_with("data:"));
    numbers.all(|value| !value.contains("NaN") && !value.contains("inf"))
}

fn any_value() -> impl Strategy<Value = f64> {
    prop_oneof![4 => -10.0..10.0, 1 => any::<f64>()]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn no_numbers_break_a_chart(
        values in prop::collection::vec([any_value(), any_value(), any_value(), any_value()], 0..8),
        (log_x, log_y, range) in (any::<bool>(), any::<bool>(), prop::option::of([any_value(), any_value()])),
        label in any::<String>(),
    ) {
        let points: Vec<_> =
            values.iter().map(|v| BandPoint { x: v[0], mean: v[1], low: v[2], high: v[3] }).collect();
        let scattered: Vec<_> = values.iter().map(|v| [v[0], v[1]]).collect();
        let bars: Vec<_> =
            values.iter().map(|v| Bar { value: v[0], low: v[1], high: v[2] }).collect();
        let mut chart = Chart::new(label.clone(), &*label, "y");
        chart = if log_x { chart.log_x() } else { chart };
        chart = if log_y { chart.log_y() } else { chart };
        chart = if let Some([low, high]) = range { chart.y_range(low, high) } else { chart };
        let bars = chart.clone().categories(&[&label]).bars("bars", &bars);
        let curve = chart.curve(label, &points).points("points", &scattered);
        let picture = Picture::new().panel_width(150.0).panel(curve).panel(bars);
        prop_assert!(picture.to_svg().ends_with("</svg>\n"));
        prop_assert!(has_finite_numbers(&picture.to_svg()));
        prop_assert!(picture.to_png(1.0).is_ok());
    }

    #[test]
    fn no_numbers_break_a_task(
        values in prop::collection::vec([any_value(), any_value()], 0..6),
        size in [1e-6..1e6_f64, 1e-6..1e6_f64],
        circle in ([-1e9..1e9_f64, -1e9..1e9_f64], 1e-6..1e9_f64),
    ) {
        let bounds = Rect::new([0.0, 0.0], size).unwrap();
        let circle = Obstacle::Circle(Circle::new(circle.0, circle.1).unwrap());
        let world = Arc::new(World::new(bounds, vec![circle], None));
        let robot = Robot::disc(1e3).unwrap();
        let task = Task::in_plane("", world, robot, [0.0, 0.0], [1e9, -1e9]).unwrap();
        let trajectory = Trajectory::from_points(&values);
        let shade = values.first().copied().unwrap_or_default();
        let panel = TaskPanel::new(task.plane().unwrap())
            .path("path", &trajectory)
            .dashed_path("dashed", &trajectory)
            .trace("trace", &[trajectory.clone(), trajectory.clone()])
            .shade(|p| p[0] * shade[0] + shade[1]);
        let picture = Picture::new().panel_width(150.0).panel(panel);
        prop_assert!(has_finite_numbers(&picture.to_svg()));
        prop_assert!(picture.to_png(1.0).is_ok());
    }
}
