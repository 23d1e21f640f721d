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
        self.parabolas.clear();
        self.begins.clear();
        for (q, &height) in f.iter().enumerate().filter(|(_, height)| height.is_finite()) {
            let q = q as f64;
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
        if self.parabolas.is_empty() {
            return;
        }
        let mut k = 0;
        for (p, value) in f.iter_mut().enumerate() {
            let p = p as f64;
            while k + 1 < self.begins.len() && self.begins[k + 1] < p {
                k += 1;
            }
            let (q, height) = self.parabolas[k];
            *value = height + (p - q) * (p - q);
        }
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
        }
    }
}
