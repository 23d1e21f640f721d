//! A point or vector of the plane and its arithmetic.

/// A point or vector `[x, y]`, in task units.
pub type Point = [f64; 2];

/// `a + b`.
#[inline]
pub fn add(a: Point, b: Point) -> Point {
    [a[0] + b[0], a[1] + b[1]]
}

/// `a - b`.
#[inline]
pub fn sub(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}

/// `factor * a`.
#[inline]
pub fn scale(a: Point, factor: f64) -> Point {
    [a[0] * factor, a[1] * factor]
}

/// The inner product.
#[inline]
pub fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// The z component of the cross product; positive when `b` lies to the left of `a`.
#[inline]
pub fn cross(a: Point, b: Point) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

/// The Euclidean length.
#[inline]
pub fn norm(a: Point) -> f64 {
    dot(a, a).sqrt()
}

/// The Euclidean distance between two points.
#[inline]
pub fn distance(a: Point, b: Point) -> f64 {
    norm(sub(a, b))
}

/// The point at fraction `t` of the way from `a` to `b`.
#[inline]
pub fn lerp(a: Point, b: Point, t: f64) -> Point {
    [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]
}
