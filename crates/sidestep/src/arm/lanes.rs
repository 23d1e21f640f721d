//! Numbers and points of sixteen configurations at once, and what is asked of all lanes together.

use crate::kernels::{LANES, madd};

/// One number for each configuration of a block.
pub(super) type Lane = [f32; LANES];
/// A point for each: x, y, z.
pub(super) type Points = [Lane; 3];

/// Each lane's right neighbour; the last one's is itself.
#[inline(always)]
pub(super) fn shifted(lanes: &Lane) -> Lane {
    let mut next = *lanes;
    next[..LANES - 1].copy_from_slice(&lanes[1..]);
    next
}

#[inline(always)]
pub(super) fn shifted_points(points: &Points) -> Points {
    [shifted(&points[0]), shifted(&points[1]), shifted(&points[2])]
}

/// The least squared distance of two points over a block.
#[inline(always)]
pub(super) fn least_square<const ISA: u8>(a: &Points, b: &Points) -> f32 {
    let mut squares: Lane = [0.0; LANES];
    for lane in 0..LANES {
        let [x, y, z] = [0, 1, 2].map(|axis: usize| b[axis][lane] - a[axis][lane]);
        squares[lane] = madd::<ISA>(x, x, madd::<ISA>(y, y, z * z));
    }
    lane_min(&squares)
}

/// The least of the lanes.
#[inline(always)]
pub(super) fn lane_min(lanes: &Lane) -> f32 {
    folded(lanes, |a, b| if b < a { b } else { a })
}

/// The largest of the lanes.
#[inline(always)]
pub(super) fn lane_max(lanes: &Lane) -> f32 {
    folded(lanes, |a, b| if b > a { b } else { a })
}

/// The lanes put together as a balanced tree.
#[inline(always)]
fn folded(lanes: &Lane, together: impl Fn(f32, f32) -> f32) -> f32 {
    let mut folded = *lanes;
    let mut width = LANES / 2;
    while width > 0 {
        for lane in 0..width {
            folded[lane] = together(folded[lane], folded[lane + width]);
        }
        width /= 2;
    }
    folded[0]
}

/// The middle of the box around a block of points, and half its diagonal.
#[inline(always)]
pub(super) fn span(points: &Points) -> ([f32; 3], f32) {
    let mut center = [0.0; 3];
    let mut square = 0.0;
    for axis in 0..3 {
        let (low, high) = (lane_min(&points[axis]), lane_max(&points[axis]));
        center[axis] = 0.5 * (low + high);
        square += (0.5 * (high - low)).powi(2);
    }
    (center, square.sqrt() * (1.0 + 1e-6))
}
