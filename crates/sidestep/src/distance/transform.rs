//! The exact Euclidean distance transform in linear time (Felzenszwalb & Huttenlocher 2012,
//! doi:10.4086/toc.2012.v008a019): lower envelopes of parabolas, columns then rows.

/// Squared distance, in cells, from each cell's centre to the nearest cell whose `seed` is true;
/// infinite where there is none. `seeds` is row-major `[height x width]`.
pub fn squared_distance_transform(seeds: &[bool], width: usize, height: usize) -> Vec<f64> {
    let mut squared: Vec<f64> =
        seeds.iter().map(|&seed| if seed { 0.0 } else { f64::INFINITY }).collect();
    let longest = width.max(height);
    let mut line = vec![0.0; longest];
    let mut envelope = Envelope::with_capacity(longest);
    for column in 0..width {
        for row in 0..height {
            line[row] = squared[row * width + column];
        }
        envelope.transform(&mut line[..height]);
        for row in 0..height {
            squared[row * width + column] = line[row];
        }
    }
    for row in squared.chunks_exact_mut(width.max(1)) {
        envelope.transform(row);
    }
    squared
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
            width in 1usize..12,
            height in 1usize..12,
            bits in proptest::collection::vec(0u8..5, 144),
        ) {
            let seeds: Vec<bool> = bits[..width * height].iter().map(|&b| b == 0).collect();
            let got = squared_distance_transform(&seeds, width, height);
            prop_assert_eq!(got, brute_force(&seeds, width, height));
        }
    }
}
