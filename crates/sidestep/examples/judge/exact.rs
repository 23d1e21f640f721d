//! Whether a robot that sweeps a segment keeps clear of an obstacle, decided without rounding.
//!
//! Every question is the sign of a polynomial of the input's numbers, which are dyadic fractions. It is
//! evaluated in intervals that are rounded outwards, and where an interval holds 0, once more in rational numbers.
//! Nothing is shared with the certificate: segments are clipped against half planes (M. Cyrus and J. Beck,
//! Generalized two- and three-dimensional clipping, 1978, doi:10.1016/0097-8493(78)90021-3), and distances are
//! compared as squares.

use std::cmp::Ordering;

use num_rational::BigRational;
use num_traits::Signed;
use sidestep::Obstacle;
use sidestep::plane::geometry::Rect;

type Point = [f64; 2];

/// Numbers that the predicates compute with.
pub trait Number: Clone {
    /// The number itself; it is finite.
    fn of(value: f64) -> Self;
    fn plus(&self, other: &Self) -> Self;
    fn minus(&self, other: &Self) -> Self;
    fn times(&self, other: &Self) -> Self;
    /// The order to 0; none where it is not known.
    fn sign(&self) -> Option<Ordering>;
}

/// An interval that holds the number.
#[derive(Debug, Clone, Copy)]
pub struct Interval(f64, f64);

impl Number for Interval {
    fn of(value: f64) -> Self {
        Self(value, value)
    }

    fn plus(&self, other: &Self) -> Self {
        Self((self.0 + other.0).next_down(), (self.1 + other.1).next_up())
    }

    fn minus(&self, other: &Self) -> Self {
        Self((self.0 - other.1).next_down(), (self.1 - other.0).next_up())
    }

    fn times(&self, other: &Self) -> Self {
        let products = [self.0 * other.0, self.0 * other.1, self.1 * other.0, self.1 * other.1];
        let least = products.iter().copied().fold(f64::INFINITY, f64::min);
        let most = products.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        Self(least.next_down(), most.next_up())
    }

    fn sign(&self) -> Option<Ordering> {
        match (self.0.partial_cmp(&0.0)?, self.1.partial_cmp(&0.0)?) {
            (Ordering::Greater, _) => Some(Ordering::Greater),
            (_, Ordering::Less) => Some(Ordering::Less),
            (Ordering::Equal, Ordering::Equal) => Some(Ordering::Equal),
            _ => None,
        }
    }
}

impl Number for BigRational {
    fn of(value: f64) -> Self {
        Self::from_float(value).expect("a finite number")
    }

    fn plus(&self, other: &Self) -> Self {
        self + other
    }

    fn minus(&self, other: &Self) -> Self {
        self - other
    }

    fn times(&self, other: &Self) -> Self {
        self * other
    }

    fn sign(&self) -> Option<Ordering> {
        Some(if self.is_positive() {
            Ordering::Greater
        } else if self.is_negative() {
            Ordering::Less
        } else {
            Ordering::Equal
        })
    }
}

/// A solid in the plane, by the numbers that define it.
pub enum Solid {
    /// A convex polygon, counter-clockwise.
    Polygon(Vec<Point>),
    /// A disc.
    Disc(Point, f64),
    /// Cell `(column, row)` of a grid with this origin and resolution.
    Cell(Point, f64, [f64; 2]),
}

impl From<&Obstacle> for Solid {
    fn from(obstacle: &Obstacle) -> Self {
        match obstacle {
            Obstacle::Rect(rect) => Self::Polygon(rect.corners().to_vec()),
            Obstacle::Circle(circle) => Self::Disc(circle.center, circle.radius),
            Obstacle::Polygon(polygon) => Self::Polygon(polygon.vertices().to_vec()),
        }
    }
}

/// Whether the distance from segment `a b` to the solid is more than `radius`.
pub fn keeps_clear(solid: &Solid, a: Point, b: Point, radius: f64) -> bool {
    clear_in::<Interval>(solid, a, b, radius)
        .or_else(|| clear_in::<BigRational>(solid, a, b, radius))
        .expect("rational numbers have a sign")
}

/// Whether `p` lies in the closed bounds shrunk by `radius`.
pub fn is_inside(bounds: &Rect, p: Point, radius: f64) -> bool {
    let fits = |low: f64, high: f64| {
        let gap = |n: fn(f64) -> BigRational| n(high).minus(&n(low)).minus(&n(radius));
        let quick = Interval::of(high).minus(&Interval::of(low)).minus(&Interval::of(radius));
        quick.sign().or_else(|| gap(BigRational::of).sign()) != Some(Ordering::Less)
    };
    p.iter().all(|x| x.is_finite())
        && (0..2).all(|k| fits(bounds.min[k], p[k]) && fits(p[k], bounds.max[k]))
}

type Vector<N> = [N; 2];

fn vector<N: Number>(p: Point) -> Vector<N> {
    p.map(N::of)
}

fn sub<N: Number>(a: &Vector<N>, b: &Vector<N>) -> Vector<N> {
    [a[0].minus(&b[0]), a[1].minus(&b[1])]
}

fn dot<N: Number>(a: &Vector<N>, b: &Vector<N>) -> N {
    a[0].times(&b[0]).plus(&a[1].times(&b[1]))
}

fn cross<N: Number>(a: &Vector<N>, b: &Vector<N>) -> N {
    a[0].times(&b[1]).minus(&a[1].times(&b[0]))
}

/// [`keeps_clear`] in one kind of numbers; none where they do not decide.
pub fn clear_in<N: Number>(solid: &Solid, a: Point, b: Point, radius: f64) -> Option<bool> {
    let (a, b) = (vector::<N>(a), vector::<N>(b));
    let radius = N::of(radius);
    match solid {
        Solid::Disc(center, size) => {
            let reach = radius.plus(&N::of(*size));
            is_farther(&vector(*center), &a, &b, &reach.times(&reach))
        }
        Solid::Polygon(corners) => {
            let corners: Vec<_> = corners.iter().map(|&corner| vector(corner)).collect();
            polygon_is_clear(&corners, &a, &b, &radius)
        }
        Solid::Cell(origin, resolution, [column, row]) => {
            let line = |axis: usize, index: f64| {
                N::of(origin[axis]).plus(&N::of(index).times(&N::of(*resolution)))
            };
            let (left, right) = (line(0, *column), line(0, column + 1.0));
            let (low, high) = (line(1, *row), line(1, row + 1.0));
            let corners = [
                [left.clone(), low.clone()],
                [right.clone(), low],
                [right, high.clone()],
                [left, high],
            ];
            polygon_is_clear(&corners, &a, &b, &radius)
        }
    }
}

fn polygon_is_clear<N: Number>(
    corners: &[Vector<N>],
    a: &Vector<N>,
    b: &Vector<N>,
    radius: &N,
) -> Option<bool> {
    if meets(corners, a, b)? {
        return Some(false);
    }
    let square = radius.times(radius);
    for (i, corner) in corners.iter().enumerate() {
        let next = &corners[(i + 1) % corners.len()];
        if !(is_farther(corner, a, b, &square)?
            && is_farther(a, corner, next, &square)?
            && is_farther(b, corner, next, &square)?)
        {
            return Some(false);
        }
    }
    Some(true)
}

/// Whether segment `a b` meets the closed polygon: what is left of it between its half planes.
fn meets<N: Number>(corners: &[Vector<N>], a: &Vector<N>, b: &Vector<N>) -> Option<bool> {
    // Fractions of the way from a to b, as numerator and positive denominator.
    let (mut enter, mut leave) = ((N::of(0.0), N::of(1.0)), (N::of(1.0), N::of(1.0)));
    let less = |x: &(N, N), y: &(N, N)| {
        Some(x.0.times(&y.1).minus(&y.0.times(&x.1)).sign()? == Ordering::Less)
    };
    for (i, corner) in corners.iter().enumerate() {
        let edge = sub(&corners[(i + 1) % corners.len()], corner);
        let (at_a, at_b) = (cross(&edge, &sub(a, corner)), cross(&edge, &sub(b, corner)));
        match (at_a.sign()? == Ordering::Less, at_b.sign()? == Ordering::Less) {
            (true, true) => return Some(false),
            (true, false) => {
                let at = (N::of(0.0).minus(&at_a), at_b.minus(&at_a));
                enter = if less(&enter, &at)? { at } else { enter };
            }
            (false, true) => {
                let at = (at_a.clone(), at_a.minus(&at_b));
                leave = if less(&at, &leave)? { at } else { leave };
            }
            (false, false) => {}
        }
    }
    Some(!less(&leave, &enter)?)
}

/// Whether the square of the distance from `p` to segment `a b` is more than `square`.
fn is_farther<N: Number>(p: &Vector<N>, a: &Vector<N>, b: &Vector<N>, square: &N) -> Option<bool> {
    let (direction, offset) = (sub(b, a), sub(p, a));
    let more = |value: N, than: &N| Some(value.minus(than).sign()? == Ordering::Greater);
    let along = dot(&offset, &direction);
    let length = dot(&direction, &direction);
    if along.sign()? != Ordering::Greater {
        return more(dot(&offset, &offset), square);
    }
    if along.minus(&length).sign()? != Ordering::Less {
        let offset = sub(p, b);
        return more(dot(&offset, &offset), square);
    }
    let beside = cross(&direction, &offset);
    more(beside.times(&beside), &square.times(&length))
}
