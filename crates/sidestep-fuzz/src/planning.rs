//! Planners against each other: a small world is drawn from the bytes, with sides and gaps that nearly
//! touch, and several planners answer. No answer may contradict another, and no plan may collide.

use std::sync::Arc;

use sidestep::plan::{Options, Plan, Status, parse_planner, plan};
use sidestep::plane::geometry::{Circle, ConvexPolygon, Point, Rect};
use sidestep::{InvalidInput, Obstacle, PlaneTask, Robot, Task, Trajectory, World, certify};

/// Samples of a segment that is looked at again.
const SAMPLES: usize = 64;

pub fn planning(bytes: &[u8]) {
    let Some(task) = draw(&mut Draw(bytes)) else { return };
    let options = Options { steps: 20, prove: true, ..Options::default() };
    let none = |_: &str| Err(InvalidInput::new("policy", "none", "a file"));
    let plans: Vec<(&str, Plan)> = ["shortest-path", "gd", "lbfgs", "rrt-connect:samples=200"]
        .map(|name| {
            let planner = parse_planner(name, &mut { none }).unwrap();
            (name, plan(&task, &planner, &options).unwrap())
        })
        .into();
    for (name, plan) in &plans {
        if let Status::Solved(certified) = &plan.status {
            judge(&task, name, certified.trajectory());
        }
    }
    let having = |wanted: fn(&Status) -> bool| plans.iter().find(|(_, plan)| wanted(&plan.status));
    let proof = having(|status| matches!(status, Status::Unsolvable(_)));
    if let (Some((solver, _)), Some((prover, _))) =
        (having(|s| matches!(s, Status::Solved(_))), proof)
    {
        panic!("{solver} has a plan and {prover} a proof that there is none: {task:?}");
    }
    let invalid = plans.iter().filter(|(_, p)| matches!(p.status, Status::Invalid(_))).count();
    assert!(invalid == 0 || invalid == plans.len(), "invalid for some only: {task:?}");
}

/// A solved plan joins the ends, passes the certificate again, and comes nowhere within the radius of an
/// obstacle by its signed distances, which share nothing with the certificate.
fn judge(task: &Task, name: &str, path: &Trajectory) {
    certify(task, path).unwrap_or_else(|violation| panic!("{name}: {violation}: {task:?}"));
    let PlaneTask { world, robot, start, goal, .. } = task.plane().unwrap();
    let values = path.values();
    assert_eq!((&values[..2], &values[values.len() - 2..]), (&start[..], &goal[..]), "{task:?}");
    let bounds = world.bounds();
    let rounding = 1e-14 * (bounds.extent() + bounds.max[0].abs() + bounds.max[1].abs());
    for (from, to) in path.segments() {
        for k in 0..=SAMPLES {
            let t = k as f64 / SAMPLES as f64;
            let p = [0, 1].map(|axis| from[axis] + t * (to[axis] - from[axis]));
            for obstacle in world.obstacles() {
                let distance = obstacle.signed_distance(p);
                let least = robot.radius() - rounding;
                assert!(
                    distance > least,
                    "{name}: {p:?} is {distance} from {obstacle:?}: {task:?}"
                );
            }
        }
    }
}

/// Bytes as a source of small numbers; 0 once there are none left.
struct Draw<'a>(&'a [u8]);

impl Draw<'_> {
    fn byte(&mut self) -> u8 {
        let Some((&first, rest)) = self.0.split_first() else { return 0 };
        self.0 = rest;
        first
    }

    /// A whole coordinate from 0 to 10, for one byte in two moved by a few billionths, at which the
    /// certificate decides.
    fn coordinate(&mut self) -> f64 {
        let whole = self.byte();
        let nudge = if whole >= 128 { f64::from(self.byte() as i8) * 2.5e-9 } else { 0.0 };
        f64::from(whole % 11) + nudge
    }

    fn point(&mut self) -> Point {
        [self.coordinate(), self.coordinate()]
    }
}

/// A task on a field of 10 by 10, moved and scaled by the first bytes.
fn draw(from: &mut Draw<'_>) -> Option<Task> {
    let scale = [1.0, 1e-6, 1e6, 0.1][usize::from(from.byte() % 4)];
    let shift = [0.0, -5.0, 1e4, 3.0][usize::from(from.byte() % 4)];
    let place = |p: Point| p.map(|v| (v + shift) * scale);
    let radius = [0.0, 0.0, 0.25, 0.5, 1.0][usize::from(from.byte() % 5)] * scale;
    let (start, goal) = (place(from.point()), place(from.point()));
    let count = from.byte() % 8;
    let obstacles = (0..count).filter_map(|_| match from.byte() % 4 {
        0 | 1 => {
            let (a, b) = (place(from.point()), place(from.point()));
            let [low, high] = [f64::min, f64::max].map(|of| [of(a[0], b[0]), of(a[1], b[1])]);
            Rect::new(low, high).ok().map(Obstacle::Rect)
        }
        2 => {
            let center = place(from.point());
            Circle::new(center, from.coordinate() * 0.5 * scale).ok().map(Obstacle::Circle)
        }
        _ => {
            let corners = (0..3 + from.byte() % 3).map(|_| place(from.point())).collect();
            ConvexPolygon::new(corners).ok().map(Obstacle::Polygon)
        }
    });
    let obstacles = obstacles.collect();
    let bounds = Rect::new(place([0.0, 0.0]), place([10.0, 10.0])).ok()?;
    let world = Arc::new(World::new(bounds, obstacles, None));
    let robot = if radius > 0.0 { Robot::disc(radius).ok()? } else { Robot::Point };
    Task::in_plane("drawn", world, robot, start, goal).ok()
}
