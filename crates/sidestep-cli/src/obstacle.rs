//! Obstacles in words: `rect:X0,Y0,X1,Y1`, `circle:X,Y,R`, `polygon:X,Y;X,Y;X,Y`.

use std::sync::Arc;

use sidestep::plane::geometry::{Circle, ConvexPolygon, Point, Rect};
use sidestep::{Obstacle, Setting, Task, World};

use crate::failure::Failure;

/// The forms, for help and errors.
pub const FORMS: &str = "rect:X0,Y0,X1,Y1, circle:X,Y,RADIUS or polygon:X,Y;X,Y;X,Y";

/// Parses an obstacle, in task units.
pub fn parse_obstacle(text: &str) -> Result<Obstacle, String> {
    let unknown = || format!("expected {FORMS}");
    let (kind, places) = text.split_once(':').ok_or_else(unknown)?;
    match kind {
        "rect" => {
            let [x0, y0, x1, y1] = numbers(places, "rect:X0,Y0,X1,Y1")?;
            let rect = Rect::new([x0.min(x1), y0.min(y1)], [x0.max(x1), y0.max(y1)]);
            rect.map(Obstacle::Rect).map_err(|error| error.inside("rect").to_string())
        }
        "circle" => {
            let [x, y, radius] = numbers(places, "circle:X,Y,RADIUS")?;
            Circle::new([x, y], radius).map(Obstacle::Circle).map_err(|error| error.to_string())
        }
        "polygon" => {
            let corner = |corner: &str| numbers(corner, "polygon:X,Y;X,Y;X,Y");
            let corners = places.split([';', ' ']).filter(|corner| !corner.is_empty());
            let corners: Vec<Point> = corners.map(corner).collect::<Result<_, _>>()?;
            ConvexPolygon::new(corners).map(Obstacle::Polygon).map_err(|error| error.to_string())
        }
        _ => Err(unknown()),
    }
}

/// So many numbers with commas between them.
fn numbers<const N: usize>(text: &str, form: &str) -> Result<[f64; N], String> {
    let number = |part: &str| -> Result<f64, String> {
        let value = part.trim().parse().map_err(|_| format!("`{part}` is not a number"))?;
        if f64::is_finite(value) { Ok(value) } else { Err(format!("`{part}` is not finite")) }
    };
    let values: Vec<f64> = text.split(',').map(number).collect::<Result<_, _>>()?;
    let found = values.len();
    values.try_into().map_err(|_| format!("expected {form}, found {found} number(s)"))
}

/// The task with these obstacles beside its own, numbered after them.
pub fn with_obstacles(task: Task, obstacles: &[Obstacle]) -> Result<Task, Failure> {
    if obstacles.is_empty() {
        return Ok(task);
    }
    let plane = task.plane()?;
    let every = plane.world.obstacles().iter().chain(obstacles).cloned().collect();
    let world = World::new(plane.world.bounds(), every, plane.world.grid().cloned());
    let setting = Setting::Plane { world: Arc::new(world), robot: plane.robot };
    Ok(Task { setting, ..task })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn obstacles_in_words() {
        let rect = Obstacle::Rect(Rect { min: [1.0, 2.0], max: [3.0, 4.0] });
        for text in ["rect:1,2,3,4", "rect:3,4,1,2", "rect: 1, 2, 3, 4"] {
            assert_eq!(parse_obstacle(text), Ok(rect.clone()), "{text}");
        }
        let circle = Obstacle::Circle(Circle::new([-1.5, 0.0], 2.0).unwrap());
        assert_eq!(parse_obstacle("circle:-1.5,0,2"), Ok(circle));
        let corners = vec![[0.0, 0.0], [2.0, 0.0], [1.0, 2.0]];
        let polygon = Obstacle::Polygon(ConvexPolygon::new(corners).unwrap());
        for text in ["polygon:0,0;2,0;1,2", "polygon:0,0 2,0 1,2"] {
            assert_eq!(parse_obstacle(text), Ok(polygon.clone()), "{text}");
        }
        for (text, part) in [
            ("box:1,2,3,4", "expected rect:X0,Y0,X1,Y1, circle:X,Y,RADIUS or polygon"),
            ("1,2,3,4", "expected rect:"),
            ("rect:1,2,3", "expected rect:X0,Y0,X1,Y1, found 3 number(s)"),
            ("rect:1,2,3,x", "`x` is not a number"),
            ("rect:1,2,1,4", "rect"),
            ("circle:1,2,-3", "-3"),
            ("circle:1,2,inf", "not finite"),
            ("polygon:1,2;3,4", "at least 3"),
        ] {
            let error = parse_obstacle(text).unwrap_err();
            assert!(error.contains(part), "{text}: {error}");
        }
    }
}
