//! Plane geometry in f64: points, segments and the obstacle shapes.
//!
//! Signed distances are in task units, positive outside a shape, negative inside.

mod circle;
mod point;
mod polygon;
mod rect;
mod ring;
mod segment;

pub use circle::Circle;
pub use point::{Point, add, cross, distance, dot, lerp, norm, scale, sub};
pub use polygon::ConvexPolygon;
pub use rect::Rect;
pub use segment::{closest_on_segment, point_segment_distance, segments_distance};
