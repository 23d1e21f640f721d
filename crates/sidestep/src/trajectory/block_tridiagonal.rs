//! A symmetric block-tridiagonal matrix over the waypoints of a trajectory: curvature of a cost that looks at places between
//! waypoints, with damping in the covariant metric ([`super::covariant`]), and its solution by blocks of Cholesky factors.

/// Damping of Levenberg-Marquardt steps in the covariant metric. Chosen on planar arms of 3, 4 and 6 joints and the Panda in
/// shelves and cages, tasks of seeds that no suite uses; in the plane, too, nothing from 0 to 0.1 is better or worse.
pub(crate) const DAMPING: f32 = 0.01;
/// Largest move of a coordinate in a step, in normalised units.
const LONGEST: f32 = 0.5;

/// In blocks of `dof x dof`; allocates nothing once made.
#[derive(Debug, Clone)]
pub(crate) struct BlockTridiagonal {
    dof: usize,
    /// Blocks on the diagonal `[N x dof x dof]`.
    diagonal: Vec<f32>,
    /// Blocks of each waypoint (rows) and the next (columns), in a room of N.
    beside: Vec<f32>,
}

impl BlockTridiagonal {
    /// Zero, for trajectories of `waypoints` configurations of `dof` numbers.
    pub fn new(waypoints: usize, dof: usize) -> Self {
        let zero = vec![0.0; waypoints * dof * dof];
        Self { dof, diagonal: zero.clone(), beside: zero }
    }

    /// Back to zero.
    pub fn clear(&mut self) {
        self.diagonal.fill(0.0);
        self.beside.fill(0.0);
    }

    /// Adds `scale` times the square of a slope at fraction `t` of a segment, segment 0 beginning at the start.
    pub fn add_square(&mut self, segment: usize, t: f32, scale: f32, slope: impl Fn(usize) -> f32) {
        let Self { dof, diagonal, beside } = self;
        let (dof, square) = (*dof, *dof * *dof);
        let add = |blocks: &mut [f32], index: usize, share: f32| {
            let Some(block) = blocks.get_mut(index * square..(index + 1) * square) else { return };
            for (row, out) in block.chunks_exact_mut(dof).enumerate() {
                let left = share * scale * slope(row);
                out.iter_mut().enumerate().for_each(|(k, value)| *value += left * slope(k));
            }
        };
        add(diagonal, segment, t * t);
        if segment > 0 && t < 1.0 {
            add(diagonal, segment - 1, (1.0 - t) * (1.0 - t));
            add(beside, segment - 1, t * (1.0 - t));
        }
    }

    /// Adds `weight` times the covariant metric: 2 on the diagonal and -1 beside it.
    pub fn add_metric(&mut self, weight: f32) {
        let (step, square) = (self.dof + 1, self.dof * self.dof);
        for block in self.diagonal.chunks_exact_mut(square) {
            block.iter_mut().step_by(step).for_each(|value| *value += 2.0 * weight);
        }
        for block in self.beside.chunks_exact_mut(square) {
            block.iter_mut().step_by(step).for_each(|value| *value -= weight);
        }
    }

    /// As [`Self::solve`], shortened where a number would be above [`LONGEST`], and zero where it is none.
    pub fn solve_held(&mut self, right: &mut [f32]) {
        self.solve(right);
        let longest = right.iter().fold(0.0_f32, |most, value| most.max(value.abs()));
        let scale = if longest > LONGEST { LONGEST / longest } else { 1.0 };
        let is_finite = right.iter().all(|value| value.is_finite());
        right.iter_mut().for_each(|value| *value = if is_finite { scale * *value } else { 0.0 });
    }

    /// Solves in place: `right` `[N x dof]` becomes the solution, the matrix its factors.
    ///
    /// With L_i L_iᵀ = D_i - B_{i-1}ᵀ and B_i = L_i⁻¹ E_i, forward and back as for numbers.
    pub fn solve(&mut self, right: &mut [f32]) {
        let Self { dof, diagonal, beside } = self;
        let (dof, square) = (*dof, *dof * *dof);
        let count = right.len() / dof;
        for i in 0..count {
            let block = &mut diagonal[i * square..][..square];
            if i > 0 {
                let before = &beside[(i - 1) * square..][..square];
                for row in 0..dof {
                    for column in 0..=row {
                        let sum =
                            (0..dof).map(|k| before[k * dof + row] * before[k * dof + column]);
                        block[row * dof + column] -= sum.sum::<f32>();
                    }
                    let sum = (0..dof).map(|k| before[k * dof + row] * right[(i - 1) * dof + k]);
                    right[i * dof + row] -= sum.sum::<f32>();
                }
            }
            factor(dof, block);
            lower(dof, block, &mut right[i * dof..][..dof], 1);
            if i + 1 < count {
                // All columns of the block beside at once, row by row.
                lower(dof, block, &mut beside[i * square..][..square], dof);
            }
        }
        for i in (0..count).rev() {
            let (own, next) = right.split_at_mut((i + 1) * dof);
            let own = &mut own[i * dof..];
            if i + 1 < count {
                let block = &beside[i * square..][..square];
                for row in 0..dof {
                    own[row] -= (0..dof).map(|k| block[row * dof + k] * next[k]).sum::<f32>();
                }
            }
            upper(dof, &diagonal[i * square..][..square], own);
        }
    }
}

/// The lower Cholesky factor of a block, in its lower triangle.
fn factor(dof: usize, block: &mut [f32]) {
    for row in 0..dof {
        for column in 0..=row {
            let sum: f32 =
                (0..column).map(|k| block[row * dof + k] * block[column * dof + k]).sum();
            let rest = block[row * dof + column] - sum;
            block[row * dof + column] = match row == column {
                // Rounding may leave less than nothing of what is above 0.
                true => rest.max(1e-12).sqrt(),
                false => rest / block[column * dof + column],
            };
        }
    }
}

/// L⁻¹ times a matrix of `columns` columns, in place.
fn lower(dof: usize, factor: &[f32], right: &mut [f32], columns: usize) {
    for row in 0..dof {
        let (above, own) = right.split_at_mut(row * columns);
        let own = &mut own[..columns];
        for k in 0..row {
            let share = factor[row * dof + k];
            let known = &above[k * columns..][..columns];
            own.iter_mut().zip(known).for_each(|(own, known)| *own -= share * known);
        }
        let scale = 1.0 / factor[row * dof + row];
        own.iter_mut().for_each(|own| *own *= scale);
    }
}

/// L⁻ᵀ times a vector, in place.
fn upper(dof: usize, factor: &[f32], right: &mut [f32]) {
    for row in (0..dof).rev() {
        let sum: f32 = (row + 1..dof).map(|k| factor[k * dof + row] * right[k]).sum();
        right[row] = (right[row] - sum) / factor[row * dof + row];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_the_block_tridiagonal_system() {
        let (dof, count) = (3, 4);
        let square = dof * dof;
        let mut matrix = BlockTridiagonal::new(count, dof);
        // Sums of squares, as curvatures are.
        let mut seed = 1_u32;
        let mut number = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (seed >> 8) as f32 / (1 << 24) as f32 - 0.5
        };
        for i in 0..count {
            let g: Vec<f32> = (0..dof).map(|_| number()).collect();
            matrix.add_square(i, 0.5, 1.5, |k| g[k]);
            matrix.add_square(i, 1.0, 0.5, |k| g[(k + 1) % dof]);
        }
        matrix.add_metric(0.3);
        let (whole, right): (_, Vec<f32>) =
            (matrix.clone(), (0..dof * count).map(|_| number()).collect());
        let mut x = right.clone();
        matrix.solve(&mut x);
        for i in 0..count {
            for row in 0..dof {
                let mut product = 0.0;
                for k in 0..dof {
                    product += whole.diagonal[i * square + row * dof + k] * x[i * dof + k];
                    if i + 1 < count {
                        product += whole.beside[i * square + row * dof + k] * x[(i + 1) * dof + k];
                    }
                    if i > 0 {
                        let above = whole.beside[(i - 1) * square + k * dof + row];
                        product += above * x[(i - 1) * dof + k];
                    }
                }
                let expected = right[i * dof + row];
                assert!((product - expected).abs() < 1e-4, "{i} {row}: {product} {expected}");
            }
        }
    }
}
