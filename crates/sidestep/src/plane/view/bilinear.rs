//! Reading between the nodes of a square.

/// Four nodes and their weights.
pub(super) type Corners = [(usize, f32); 4];

/// The four nodes around a place in a square of `side` x `side` nodes with their weights.
#[inline]
pub(super) fn bilinear(place: [f32; 2], side: usize) -> Corners {
    let last = (side - 1) as f32;
    let (x, y) = (place[0].clamp(0.0, last), place[1].clamp(0.0, last));
    let (column, row) = ((x as usize).min(side - 2), (y as usize).min(side - 2));
    let (u, v) = (x - column as f32, y - row as f32);
    let node = row * side + column;
    [
        (node, (1.0 - u) * (1.0 - v)),
        (node + 1, u * (1.0 - v)),
        (node + side, (1.0 - u) * v),
        (node + side + 1, u * v),
    ]
}
