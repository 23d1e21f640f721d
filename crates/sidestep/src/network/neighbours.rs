//! What the waypoint network's convolutions read: each waypoint's row beside those of its neighbours along the trajectory.

use crate::kernels::{LANES, dispatch};

dispatch! {
    /// Row i of `out [rows x 3 width]` becomes rows i - d, i and i + d of `h [rows x width]` within its trajectory.
    pub(super) fn gather(h: &[f32], waypoints: usize, width: usize, dilation: usize, out: &mut [f32]) = gather_body;
}

#[inline(always)]
fn gather_body<const ISA: u8>(
    h: &[f32],
    waypoints: usize,
    width: usize,
    dilation: usize,
    out: &mut [f32],
) {
    let trajectories = h.chunks_exact(waypoints * width);
    for (h, out) in trajectories.zip(out.chunks_exact_mut(3 * waypoints * width)) {
        for (i, out) in out.chunks_exact_mut(3 * width).enumerate() {
            let (before, rest) = out.split_at_mut(width);
            let (own, after) = rest.split_at_mut(width);
            match i.checked_sub(dilation) {
                Some(j) => copy(&h[j * width..][..width], before),
                None => before.fill(0.0),
            }
            copy(&h[i * width..][..width], own);
            match h.get((i + dilation) * width..(i + dilation + 1) * width) {
                Some(row) => copy(row, after),
                None => after.fill(0.0),
            }
        }
    }
}

dispatch! {
    /// Adds `h` to `next`.
    pub(super) fn add(h: &[f32], next: &mut [f32]) = add_body;
}

#[inline(always)]
fn add_body<const ISA: u8>(h: &[f32], next: &mut [f32]) {
    next.iter_mut().zip(h).for_each(|(next, h)| *next += h);
}

/// Copies a row of whole panels: a few registers, sooner done than a call that finds out how many.
#[inline(always)]
fn copy(from: &[f32], to: &mut [f32]) {
    for (to, from) in to.as_chunks_mut::<LANES>().0.iter_mut().zip(from.as_chunks::<LANES>().0) {
        *to = *from;
    }
}

/// Adds what flows back through [`gather`] to `d_h [rows x width]`.
pub(super) fn scatter(
    d_out: &[f32],
    waypoints: usize,
    width: usize,
    dilation: usize,
    d_h: &mut [f32],
) {
    let trajectories = d_h.chunks_exact_mut(waypoints * width);
    for (d_h, d_out) in trajectories.zip(d_out.chunks_exact(3 * waypoints * width)) {
        for (i, d) in d_out.chunks_exact(3 * width).enumerate() {
            let mut add = |row: usize, d: &[f32]| {
                let row = &mut d_h[row * width..][..width];
                row.iter_mut().zip(d).for_each(|(sum, d)| *sum += d);
            };
            if let Some(j) = i.checked_sub(dilation) {
                add(j, &d[..width]);
            }
            add(i, &d[width..2 * width]);
            if i + dilation < waypoints {
                add(i + dilation, &d[2 * width..]);
            }
        }
    }
}
