//! Planning again when an obstacle has moved, from the last plan: `cargo run --release -p sidestep --example replan`.
#![allow(clippy::print_stdout, reason = "an example")]

use std::sync::Arc;

use sidestep::{
    InvalidInput, Obstacle, Options, Planner, Rect, Robot, Task, Trajectory, World, plan,
};

fn main() -> Result<(), InvalidInput> {
    let bounds = Rect::new([0.0, 0.0], [64.0, 64.0])?;
    let planner: Planner = "sidestep-1".parse()?;
    let mut last: Option<Trajectory> = None;
    for step in 0..10 {
        // A box drifts across the way.
        let x = 20.0 + 2.0 * f64::from(step);
        let moving = Obstacle::Rect(Rect::new([x, 20.0], [x + 10.0, 44.0])?);
        let wall = Obstacle::Rect(Rect::new([44.0, 0.0], [50.0, 30.0])?);
        let world = Arc::new(World::new(bounds, vec![moving, wall], None));
        let task = Task::in_plane("drift", world, Robot::disc(1.0)?, [6.0, 30.0], [58.0, 30.0])?;

        let options = Options { warm_start: last.clone(), ..Options::default() };
        let plan = plan(&task, &planner, &options)?;
        let length = plan.certified().map_or(f64::NAN, Trajectory::length);
        println!("step {step}: {}, {} updates, {length:.2} long", plan.status.name(), plan.steps);
        last = plan.certified().cloned();
    }
    Ok(())
}
