//! The blocked matrix product under the dense layers: `C = A B (+ bias)` or `C += A B`, any strides.
//!
//! Every output number is two chains of multiply-adds, over the first and the second half of the depth, added at
//! the end. That hides the latency of a single sample (batch 1 is what planning does); blocks of rows
//! and panels differ per instruction set but not the chains, so one row alone, the same row in a batch, AVX2
//! and AVX-512 all give the same bits.
#![allow(clippy::too_many_arguments, reason = "kernels take flat slices and sizes")]

use super::{AVX512, LANES, madd};

/// The left factor: element (row, depth) at `row * self.row + depth * self.depth`.
#[derive(Clone, Copy)]
pub(super) struct Left<'a> {
    pub values: &'a [f32],
    pub row: usize,
    pub depth: usize,
}

/// The right factor: [`LANES`] numbers of (panel, depth) from `panel * self.panel + depth * self.depth` on.
#[derive(Clone, Copy)]
pub(super) struct Right<'a> {
    pub values: &'a [f32],
    pub panel: usize,
    pub depth: usize,
}

/// `c [rows x c_stride] = a b (+ bias)`, or `c += a b` with `ACCUMULATE`; columns beyond `columns` stay.
#[inline(always)]
pub(super) fn product<const ISA: u8, const ACCUMULATE: bool>(
    rows: usize,
    columns: usize,
    depth: usize,
    a: Left,
    b: Right,
    bias: Option<&[f32]>,
    c: &mut [f32],
    c_stride: usize,
) {
    let out = Out { bias, values: c, stride: c_stride, columns };
    // Two chains per number: 5 x 2 panels fill 20 of 32 registers of AVX-512, 2 x 1 fill 8 of 16 of AVX2. Ten waypoints are
    // two blocks of 5.
    if ISA == AVX512 {
        let (out, done) = blocks::<ISA, ACCUMULATE, 5, 2>(0, rows, depth, a, b, out);
        let (out, done) = blocks::<ISA, ACCUMULATE, 4, 2>(done, rows, depth, a, b, out);
        blocks::<ISA, ACCUMULATE, 1, 4>(done, rows, depth, a, b, out);
    } else {
        let (out, done) = blocks::<ISA, ACCUMULATE, 2, 1>(0, rows, depth, a, b, out);
        blocks::<ISA, ACCUMULATE, 1, 2>(done, rows, depth, a, b, out);
    }
}

/// The result and what it starts from.
struct Out<'a, 'b> {
    bias: Option<&'b [f32]>,
    values: &'a mut [f32],
    stride: usize,
    columns: usize,
}

/// All whole blocks of `ROWS` rows in `from..to`; returns the first row not done.
#[inline(always)]
fn blocks<'a, 'b, const ISA: u8, const ACCUMULATE: bool, const ROWS: usize, const PANELS: usize>(
    from: usize,
    to: usize,
    depth: usize,
    a: Left,
    b: Right,
    mut out: Out<'a, 'b>,
) -> (Out<'a, 'b>, usize) {
    let panels = out.columns.div_ceil(LANES);
    let done = from + (to - from) / ROWS * ROWS;
    // Panels outside, rows inside: a panel of a wide layer stays in L1 while all rows pass it.
    let mut panel = 0;
    while panel + PANELS <= panels {
        for row in (from..done).step_by(ROWS) {
            tile::<ISA, ACCUMULATE, ROWS, PANELS>(row, panel, depth, a, b, &mut out);
        }
        panel += PANELS;
    }
    while panel < panels {
        for row in (from..done).step_by(ROWS) {
            tile::<ISA, ACCUMULATE, ROWS, 1>(row, panel, depth, a, b, &mut out);
        }
        panel += 1;
    }
    (out, done)
}

/// `ROWS` rows by `PANELS` panels of the result, held in registers over the whole depth.
#[inline(always)]
fn tile<const ISA: u8, const ACCUMULATE: bool, const ROWS: usize, const PANELS: usize>(
    row: usize,
    panel: usize,
    depth: usize,
    a: Left,
    b: Right,
    out: &mut Out,
) {
    let half = depth / 2;
    let mut low = [[[0.0_f32; LANES]; PANELS]; ROWS];
    let mut high = [[[0.0_f32; LANES]; PANELS]; ROWS];
    if let Some(bias) = out.bias {
        for p in 0..PANELS {
            let group = &bias[(panel + p) * LANES..][..LANES];
            for r in 0..ROWS {
                low[r][p].copy_from_slice(group);
            }
        }
    }
    if depth > 0 {
        assert!((row + ROWS - 1) * a.row + (depth - 1) * a.depth < a.values.len());
        assert!((panel + PANELS - 1) * b.panel + (depth - 1) * b.depth + LANES <= b.values.len());
    }
    // SAFETY: each `k < depth`, and the last elements that the steps read were asserted to exist.
    unsafe {
        for k in 0..half {
            step::<ISA, ROWS, PANELS>(&mut low, row, panel, k, a, b);
            step::<ISA, ROWS, PANELS>(&mut high, row, panel, half + k, a, b);
        }
        if depth % 2 == 1 {
            step::<ISA, ROWS, PANELS>(&mut high, row, panel, depth - 1, a, b);
        }
    }
    for r in 0..ROWS {
        for p in 0..PANELS {
            let first = (panel + p) * LANES;
            // A copy, so that a ragged edge does not force the accumulators out of the registers.
            let mut sums = low[r][p];
            for (sum, rest) in sums.iter_mut().zip(&high[r][p]) {
                *sum += rest;
            }
            let target = &mut out.values[(row + r) * out.stride + first..];
            if let (true, Some(whole)) =
                (first + LANES <= out.columns, target.first_chunk_mut::<LANES>())
            {
                add_or_set::<ACCUMULATE>(whole, &sums);
            } else {
                add_or_set::<ACCUMULATE>(&mut target[..out.columns - first], &sums);
            }
        }
    }
}

/// One multiply-add for each number of a tile, at depth `k`.
///
/// A function and not a closure: a closure that is not inlined would be compiled without the features.
///
/// # Safety
/// Element (row + ROWS - 1, k) of `a` and the lanes of (panel + PANELS - 1, k) of `b` must exist.
#[inline(always)]
unsafe fn step<const ISA: u8, const ROWS: usize, const PANELS: usize>(
    sums: &mut [[[f32; LANES]; PANELS]; ROWS],
    row: usize,
    panel: usize,
    k: usize,
    a: Left,
    b: Right,
) {
    for p in 0..PANELS {
        let at = (panel + p) * b.panel + k * b.depth;
        // SAFETY: strides are not negative, so this lies at or before the lanes that the caller vouches for.
        let weights = unsafe { b.values.get_unchecked(at..at + LANES) };
        for r in 0..ROWS {
            // SAFETY: as above, for `a`.
            let x = unsafe { *a.values.get_unchecked((row + r) * a.row + k * a.depth) };
            for lane in 0..LANES {
                sums[r][p][lane] = madd::<ISA>(x, weights[lane], sums[r][p][lane]);
            }
        }
    }
}

#[inline(always)]
fn add_or_set<const ACCUMULATE: bool>(target: &mut [f32], sums: &[f32; LANES]) {
    for (value, sum) in target.iter_mut().zip(sums) {
        *value = if ACCUMULATE { *value + sum } else { *sum };
    }
}
