//! Random questions on a map that comes without any: start and goal uniform over the places where
//! the robot may stand. Nothing says that a path joins them.

use std::sync::Arc;

use rand::RngExt;

use crate::error::InvalidInput;
use crate::plane::Robot;
use crate::plane::certificate::Certifier;
use crate::plane::geometry::Point;
use crate::plane::world::World;
use crate::rng::{Purpose, stream};
use crate::scene::Task;

/// Draws after which a world counts as full; finds a free part of a thousandth almost surely.
const MOST_DRAWS: usize = 20_000;

/// `count` tasks named `name/0`, `name/1`, ...; task i draws from stream i of `seed`.
///
/// # Errors
/// If no place was found where the robot may stand.
pub fn random_queries(
    name: &str,
    world: &Arc<World>,
    robot: Robot,
    count: usize,
    seed: u64,
) -> Result<Vec<Task>, InvalidInput> {
    let certifier = Certifier::new(world, robot);
    let bounds = certifier.bounds();
    let query = |index: usize| {
        let mut rng = stream(seed, Purpose::Query, index as u64, 0);
        let mut place = || -> Option<Point> {
            let draw = || {
                [0, 1].map(|axis| {
                    let t: f64 = rng.random();
                    bounds.min[axis] + t * (bounds.max[axis] - bounds.min[axis])
                })
            };
            std::iter::repeat_with(draw).take(MOST_DRAWS).find(|&p| certifier.point_is_free(p))
        };
        let (Some(start), Some(goal)) = (place(), place()) else {
            let allowed = "a radius that leaves the robot a place to stand";
            return Err(InvalidInput::new("robot.radius", robot.radius(), allowed));
        };
        Task::in_plane(format!("{name}/{index}"), world.clone(), robot, start, goal)
    };
    (0..count).map(query).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::geometry::Rect;
    use crate::plane::world::Obstacle;

    #[test]
    fn places_are_free_and_their_own_streams() {
        let wall = Obstacle::Rect(Rect::new([4.0, 0.0], [6.0, 9.0]).unwrap());
        let bounds = Rect::new([0.0; 2], [10.0; 2]).unwrap();
        let world = Arc::new(World::new(bounds, vec![wall], None));
        let robot = Robot::disc(0.5).unwrap();
        let tasks = random_queries("wall", &world, robot, 40, 3).unwrap();
        let certifier = Certifier::new(&world, robot);
        for task in &tasks {
            assert!(
                [&task.start, &task.goal]
                    .iter()
                    .all(|end| certifier.point_is_free([end[0], end[1]]))
            );
        }
        assert!(tasks.iter().any(|task| (task.start[0] < 4.0) != (task.goal[0] < 4.0)));
        assert_eq!(tasks[..7], random_queries("wall", &world, robot, 7, 3).unwrap());
        assert_ne!(tasks[0].start, random_queries("wall", &world, robot, 1, 4).unwrap()[0].start);
        let large = Robot::disc(4.9).unwrap();
        let refused = random_queries("wall", &world, large, 1, 3).unwrap_err();
        assert_eq!(refused.field, "robot.radius");
    }
}
