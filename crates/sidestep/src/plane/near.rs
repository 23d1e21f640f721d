//! Places near a point: rings around it, the nearest first, and from places on the first that has some straight towards the point.

use crate::plane::geometry::{Point, add, distance, lerp, scale};

/// Directions in which a place is looked for.
const DIRECTIONS: usize = 64;
/// Rings, each 2^(1/4) times as wide as the one before.
const RINGS: i32 = 48;
/// Bisections towards the point.
const BISECTIONS: u32 = 20;

/// A place at most `most` from `p` that will do: the nearest in all directions of the first ring that has one. None where no
/// ring has one.
pub fn place_near(p: Point, most: f64, will_do: impl Fn(Point) -> bool) -> Option<Point> {
    let on_ring = |ring: i32| {
        let radius = most * 2f64.powf(0.25 * f64::from(ring - RINGS));
        (0..DIRECTIONS).map(move |k| {
            let angle = std::f64::consts::TAU * k as f64 / DIRECTIONS as f64;
            add(p, scale([angle.cos(), angle.sin()], radius))
        })
    };
    let found = |ring: i32| on_ring(ring).filter(|&place| will_do(place)).collect::<Vec<_>>();
    let found = (0..=RINGS).map(found).find(|places| !places.is_empty())?;
    let nearest = |mut place: Point| {
        let mut not = p;
        for _ in 0..BISECTIONS {
            let middle = lerp(not, place, 0.5);
            *(if will_do(middle) { &mut place } else { &mut not }) = middle;
        }
        place
    };
    found.into_iter().map(nearest).min_by(|a, b| distance(*a, p).total_cmp(&distance(*b, p)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_is_near_and_none_is_none() {
        let p = [3.0, -2.0];
        let beyond = |least: f64| place_near(p, 10.0, |q| distance(p, q) >= least);
        for least in [1e-2, 0.5, 3.0, 9.9] {
            let away = distance(p, beyond(least).unwrap());
            assert!((least..least + 1e-4).contains(&away), "{least} {away}");
        }
        assert_eq!(beyond(10.1), None);
    }
}
