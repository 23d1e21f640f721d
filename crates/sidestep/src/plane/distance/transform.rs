//! The exact Euclidean distance transform in linear time (Felzenszwalb & Huttenlocher 2012,
//! doi:10.4086/toc.2012.v008a019): distances within columns, then lower envelopes of parabolas
//! along rows, or all pairs where rows are short.

use crate::kernels::{Isa, dispatch};

/// Squared distance, in cells, from each cell's centre to the nearest cell whose `seed` is true;
/// infinite where there is none. `seeds` is row-major in rows of `width`.
pub fn squared_distance_transform(seeds: &[bool], width: usize) -> Vec<f64> {
    let mut squared = column_distances(seeds, width);
    if width <= SMALL {
        small_rows(Isa::detect(), &mut squared, width);
        return squared.iter().map(|&v| f64::from(v)).collect();
    }
    let mut envelope = Envelope::with_capacity(width);
    let mut squared: Vec<f64> = squared.iter().map(|&v| f64::from(v)).collect();
    for row in squared.chunks_exact_mut(width) {
        envelope.transform(row);
    }
    squared
}

/// Rows up to this long are transformed by comparing all pairs, a block at a time: sums of squares stay
/// exact in f32, and it beats the envelope's branches.
const SMALL: usize = 128;

/// Squared distance to the nearest seed in the same column; exact in f32 up to 4096 rows, and past
/// that the nearest representable number.
fn column_distances(seeds: &[bool], width: usize) -> Vec<f32> {
    let mut squared = vec![f32::INFINITY; seeds.len()];
    let mut since = vec![f32::INFINITY; width];
    let mut sweep = |row: usize| {
        for column in 0..width {
            let i = row * width + column;
            since[column] = if seeds[i] { 0.0 } else { since[column] + 1.0 };
            squared[i] = squared[i].min(since[column] * since[column]);
        }
    };
    let height = seeds.len() / width.max(1);
    (0..height).for_each(&mut sweep);
    (0..height).rev().for_each(&mut sweep);
    squared
}

dispatch! {
    /// Replaces each row f by `min over q of f(q) + (p - q)^2`, comparing all pairs.
    fn small_rows(squared: &mut [f32], width: usize) = small_rows_body;
}

#[inline(always)]
fn small_rows_body<const ISA: u8>(squared: &mut [f32], width: usize) {
    let padded = width.next_multiple_of(16);
    let (mut nearest, mut position) = ([0.0f32; SMALL], [0.0f32; SMALL]);
    let (nearest, position) = (&mut nearest[..padded], &mut position[..padded]);
    position.iter_mut().enumerate().for_each(|(p, v)| *v = p as f32);
    for row in squared.chunks_exact_mut(width) {
        nearest.fill(f32::INFINITY);
        for (q, &f) in row.iter().enumerate() {
            let q = q as f32;
            for (nearest, p) in nearest.iter_mut().zip(&*position) {
                let candidate = f + (p - q) * (p - q);
                *nearest = nearest.min(candidate);
            }
        }
        row.copy_from_slice(&nearest[..width]);
    }
}

/// The lower envelope of the parabolas `f(q) + (p - q)^2`.
struct Envelope {
    /// Positions q and heights f(q) of the parabolas on the envelope.
    parabolas: Vec<(f64, f64)>,
    /// Where each parabola's part begins.
    begins: Vec<f64>,
}

impl Envelope {
    fn with_capacity(n: usize) -> Self {
        Self { parabolas: Vec::with_capacity(n), begins: Vec::with_capacity(n) }
    }

    /// Replaces `f` by `min over q of f(q) + (p - q)^2`.
    fn transform(&mut self, f: &mut [f64]) {
        self.clear();
        for (q, &height) in f.iter().enumerate().filter(|(_, height)| height.is_finite()) {
            self.add(q as f64, height);
        }
        if !self.parabolas.is_empty() {
            self.read(0, f, |value| value);
        }
    }

    /// The envelope for cells `begin..end`, a run of one kind: over the columns of its cells and the neighbours of the
    /// other kind at its ends.
    fn of_run(&mut self, away: &[u32], begin: usize, end: usize) {
        self.clear();
        if begin > 0 {
            self.add((begin - 1) as f64, 0.0);
        }
        for (q, &rows) in (begin..end).zip(&away[begin..end]).filter(|(_, rows)| **rows < NONE) {
            self.add(q as f64, f64::from(rows) * f64::from(rows));
        }
        if end < away.len() {
            self.add(end as f64, 0.0);
        }
    }

    fn clear(&mut self) {
        self.parabolas.clear();
        self.begins.clear();
    }

    /// Adds the parabola at `q`, to the right of all others.
    #[inline]
    fn add(&mut self, q: f64, height: f64) {
        let mut begin = f64::NEG_INFINITY;
        while let Some(&(r, other)) = self.parabolas.last() {
            begin = ((height + q * q) - (other + r * r)) / (2.0 * (q - r));
            if self.begins.last().is_some_and(|&b| begin <= b) {
                self.parabolas.pop();
                self.begins.pop();
                begin = f64::NEG_INFINITY;
            } else {
                break;
            }
        }
        self.parabolas.push((q, height));
        self.begins.push(begin);
    }

    /// Writes `measure` of the envelope from place `first` on; of infinity where it is empty.
    #[inline]
    fn read<T>(&self, first: usize, out: &mut [T], measure: impl Fn(f64) -> T) {
        let mut k = 0;
        for (p, out) in (first..).zip(out) {
            let p = p as f64;
            while k + 1 < self.begins.len() && self.begins[k + 1] < p {
                k += 1;
            }
            let square = |&(q, height): &(f64, f64)| height + (p - q) * (p - q);
            *out = measure(self.parabolas.get(k).map_or(f64::INFINITY, square));
        }
    }
}

/// Cells below which threads cost more than they save.
#[cfg(feature = "parallel")]
const FEW: usize = 1 << 15;
/// No cell of the other kind in this column; its square is more than that of any distance.
const NONE: u32 = u32::MAX / 2;

/// For each cell `measure` of the squared distance, in cells, from its centre to the nearest cell of the other
/// kind, negated for set cells; the square is infinite where all cells are of one kind. `set` is row-major in rows of
/// `width`. None once `go_on` is false.
///
/// Both transforms at once: between two neighbours of the other kind, a run of equal cells is nearest to one of
/// them or to what lies in its own columns, so each run has an envelope of its own.
pub(super) fn signed_distance_transform(
    set: &[bool],
    width: usize,
    measure: impl Fn(f64) -> f32 + Sync,
    go_on: &(dyn Fn() -> bool + Sync),
) -> Option<Vec<f32>> {
    let away = other_kind_in_column(set, width, go_on)?;
    let mut out = vec![0.0; set.len()];
    let transform = |envelope: &mut Envelope, (row, out): (usize, &mut [f32])| {
        if row.is_multiple_of(ROWS_A_QUESTION) && !go_on() {
            return None;
        }
        let range = row * width..(row + 1) * width;
        let (set, away) = (&set[range.clone()], &away[range]);
        let mut begin = 0;
        for run in set.chunk_by(|a, b| a == b) {
            let end = begin + run.len();
            envelope.of_run(away, begin, end);
            let sign = if run[0] { -1.0 } else { 1.0 };
            envelope.read(begin, &mut out[begin..end], |square| sign * measure(square));
            begin = end;
        }
        Some(())
    };
    #[cfg(feature = "parallel")]
    if set.len() >= FEW {
        use rayon::prelude::*;
        out.par_chunks_exact_mut(width)
            .enumerate()
            .try_for_each_init(|| Envelope::with_capacity(width), transform)?;
        return Some(out);
    }
    let mut envelope = Envelope::with_capacity(width);
    out.chunks_exact_mut(width).enumerate().try_for_each(|row| transform(&mut envelope, row))?;
    Some(out)
}

/// Rows from one question whether to go on to the next.
const ROWS_A_QUESTION: usize = 16;

/// For each cell how many rows the nearest cell of the other kind in its column is away, or [`NONE`].
fn other_kind_in_column(
    set: &[bool],
    width: usize,
    go_on: &(dyn Fn() -> bool + Sync),
) -> Option<Vec<u32>> {
    let mut away = vec![NONE; set.len()];
    let height = set.len() / width;
    // Upwards from the row below, then downwards from the row above.
    for row in 1..height {
        if row.is_multiple_of(ROWS_A_QUESTION) && !go_on() {
            return None;
        }
        let (before, here) = away.split_at_mut(row * width);
        let rows = set[(row - 1) * width..(row + 1) * width].split_at(width);
        step(&before[(row - 1) * width..], &mut here[..width], rows);
    }
    for row in (0..height.saturating_sub(1)).rev() {
        if row.is_multiple_of(ROWS_A_QUESTION) && !go_on() {
            return None;
        }
        let (here, before) = away.split_at_mut((row + 1) * width);
        let (lower, upper) = set[row * width..(row + 2) * width].split_at(width);
        step(&before[..width], &mut here[row * width..], (upper, lower));
    }
    Some(away)
}

/// One step of a sweep: from the row `before` to the row `here`, with the kinds of both.
fn step(before: &[u32], here: &mut [u32], (kind_before, kind_here): (&[bool], &[bool])) {
    let kinds = kind_before.iter().zip(kind_here);
    for ((here, before), (kind_before, kind_here)) in here.iter_mut().zip(before).zip(kinds) {
        let steps = if kind_before == kind_here { (before + 1).min(NONE) } else { 1 };
        *here = steps.min(*here);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn brute_force(seeds: &[bool], width: usize, height: usize) -> Vec<f64> {
        let cell = |i: usize| ((i % width) as f64, (i / width) as f64);
        (0..width * height)
            .map(|i| {
                let (x, y) = cell(i);
                (0..width * height)
                    .filter(|&j| seeds[j])
                    .map(|j| {
                        let (u, v) = cell(j);
                        (x - u).powi(2) + (y - v).powi(2)
                    })
                    .fold(f64::INFINITY, f64::min)
            })
            .collect()
    }

    proptest! {
        #[test]
        fn transform_matches_reference(
            size in prop_oneof![(1usize..12, 1usize..12), (120usize..140, 1usize..4)],
            bits in proptest::collection::vec(0u8..9, 600),
        ) {
            let (width, height) = size;
            let seeds: Vec<bool> = bits[..width * height].iter().map(|&b| b == 0).collect();
            let got = squared_distance_transform(&seeds, width);
            prop_assert_eq!(got, brute_force(&seeds, width, height));
            let free: Vec<bool> = seeds.iter().map(|&seed| !seed).collect();
            let (set, clear) = (brute_force(&free, width, height), brute_force(&seeds, width, height));
            let both = |i: usize| if seeds[i] { -set[i] as f32 } else { clear[i] as f32 };
            let expected: Vec<f32> = (0..seeds.len()).map(both).collect();
            let signed = signed_distance_transform(&seeds, width, |square| square as f32, &|| true);
            prop_assert_eq!(signed, Some(expected));
        }
    }
}
