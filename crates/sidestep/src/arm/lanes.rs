//! Numbers and points of sixteen configurations at once, and what is asked of all lanes together.

use crate::kernels::lanes::{lane_max, lane_min, shifted};
use crate::kernels::{LANES, madd};

/// One number for each configuration of a block.
pub(super) type Lane = [f32; LANES];
/// A point for each: x, y, z.
pub(super) type Points = [Lane; 3];

/// [`shifted`] of each coordinate.
#[inline(always)]
pub(super) fn shifted_points<const ISA: u8>(points: &Points) -> Points {
    [shifted::<ISA>(&points[0]), shifted::<ISA>(&points[1]), shifted::<ISA>(&points[2])]
}

/// The squared distance of two points in each lane.
#[inline(always)]
pub(super) fn squares<const ISA: u8>(a: &Points, b: &Points) -> Lane {
    let mut squares: Lane = [0.0; LANES];
    for lane in 0..LANES {
        let x = b[0][lane] - a[0][lane];
        let y = b[1][lane] - a[1][lane];
        let z = b[2][lane] - a[2][lane];
        squares[lane] = madd::<ISA>(x, x, madd::<ISA>(y, y, z * z));
    }
    squares
}

/// The box around a block of points: least and largest coordinates.
#[inline(always)]
pub(super) fn span<const ISA: u8>(points: &Points) -> [[f32; 3]; 2] {
    let [x, y, z] = points;
    [
        [lane_min::<ISA>(x), lane_min::<ISA>(y), lane_min::<ISA>(z)],
        [lane_max::<ISA>(x), lane_max::<ISA>(y), lane_max::<ISA>(z)],
    ]
}
