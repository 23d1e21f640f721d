//! A room of one's own, planned and certified: `cargo run --release -p sidestep --example plan_a_room`.
#![allow(clippy::print_stdout, reason = "an example")]

use std::sync::Arc;

use sidestep::plane::points;
use sidestep::{
    Circle, InvalidInput, Obstacle, Options, Planner, Rect, Robot, Status, Task, World, plan,
};

fn main() -> Result<(), InvalidInput> {
    // Lengths are in metres: 8 by 5, a table, and a pillar between it and the wall.
    let bounds = Rect::new([0.0, 0.0], [8.0, 5.0])?;
    let table = Obstacle::Rect(Rect::new([3.0, 0.0], [5.0, 3.2])?);
    let pillar = Obstacle::Circle(Circle::new([4.0, 4.6], 0.25)?);
    let room = Arc::new(World::new(bounds, vec![table, pillar], None));
    let robot = Robot::disc(0.3)?;
    let task = Task::in_plane("round the table", room, robot, [1.0, 1.0], [7.0, 1.0])?;

    let plan = plan(&task, &Planner::default(), &Options::default())?;
    match &plan.status {
        Status::Solved(certified) => {
            let path = certified.trajectory();
            println!("{:.2} m, {}", path.length(), plan.origin);
            for [x, y] in points(path) {
                println!("{x:6.3} {y:6.3}");
            }
        }
        other => println!("{}: {}", other.name(), other.reason()),
    }

    // The same, 0.3 m away from everything: too much for the gap of 1.15 m, and that is proved.
    let wide = task.with_margin(0.3)?;
    let plan = sidestep::plan(&wide, &Planner::default(), &Options::default())?;
    println!("with a margin of 0.3 m: {} {}", plan.status.name(), plan.status.reason());
    Ok(())
}
