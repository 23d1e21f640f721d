//! A cost of one's own beside obstacles and length: a plan that would rather keep to the upper half of the field.
//! `cargo run --release -p sidestep --example own_cost`.
#![allow(clippy::print_stdout, reason = "an example")]

use std::sync::Arc;

use sidestep::plan::{Watch, plan_in};
use sidestep::{InvalidInput, Obstacle, Options, Planner, Profile, Query, Rect, Robot, Stop};
use sidestep::{Task, World};

fn main() -> Result<(), InvalidInput> {
    let bounds = Rect::new([0.0, 0.0], [64.0, 64.0])?;
    let block = Obstacle::Rect(Rect::new([28.0, 24.0], [36.0, 38.0])?);
    let world = Arc::new(World::new(bounds, vec![block], None));
    let task = Task::in_plane("block", world, Robot::Point, [6.0, 30.0], [58.0, 30.0])?;

    // In normalised units the field is 6.4 high: what lies below 3.2 costs 0.1 (3.2 - y)² a waypoint.
    let upper_half = |[_, x, _]: [&[f32]; 3], gradient: Option<&mut [f32]>| {
        let below = |y: f32| (3.2 - y).max(0.0);
        if let Some(gradient) = gradient {
            for (slope, p) in gradient.chunks_exact_mut(2).zip(x.chunks_exact(2)) {
                slope[1] -= 0.2 * below(p[1]);
            }
        }
        x.chunks_exact(2).map(|p| 0.1 * below(p[1]).powi(2)).sum()
    };

    let planner: Planner = "adam".parse()?;
    let options = Options { stop: Stop::Best, ..Options::default() };
    let plain = Query::of(&task, &Profile::DEFAULT);
    let own = plain.clone().with_cost(upper_half);
    for (name, query) in [("obstacles and length", plain), ("and the upper half", own)] {
        let plan = plan_in(&query, &planner, &options, Watch::NONE)?;
        let path = plan.trajectory().map(sidestep::plane::points).unwrap_or_default();
        let mean = path.iter().map(|p| p[1]).sum::<f64>() / path.len() as f64;
        println!("{name}: {}, mean height {mean:.1}", plan.status.name());
    }
    Ok(())
}
