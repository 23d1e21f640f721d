//! Transposing a square of numbers in registers.

/// Rows and columns of a square.
pub(crate) const SQUARE: usize = 8;

/// The square with rows and columns exchanged, by shuffles of whole rows where the instruction set has them; the compiler moves
/// every number by itself.
#[inline(always)]
pub(crate) fn transposed<const ISA: u8>(rows: &[[f32; SQUARE]; SQUARE]) -> [[f32; SQUARE]; SQUARE] {
    #[cfg(target_arch = "x86_64")]
    if ISA != super::PORTABLE {
        // SAFETY: an `ISA` above the baseline has AVX2, and so AVX.
        return unsafe { shuffled(rows) };
    }
    std::array::from_fn(|column| std::array::from_fn(|row| rows[row][column]))
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx")]
#[inline]
fn shuffled(rows: &[[f32; SQUARE]; SQUARE]) -> [[f32; SQUARE]; SQUARE] {
    use std::arch::x86_64::{
        __m256, _mm256_loadu_ps, _mm256_permute2f128_ps, _mm256_setzero_ps, _mm256_shuffle_ps,
        _mm256_storeu_ps, _mm256_unpackhi_ps, _mm256_unpacklo_ps,
    };
    let mut a = [_mm256_setzero_ps(); SQUARE];
    for (a, row) in a.iter_mut().zip(rows) {
        // SAFETY: a row has the eight numbers that are loaded.
        *a = unsafe { _mm256_loadu_ps(row.as_ptr()) };
    }
    // Pairs of rows, then fours, within the halves of a register; then the halves.
    let mut b = a;
    for i in (0..SQUARE).step_by(2) {
        b[i] = _mm256_unpacklo_ps(a[i], a[i + 1]);
        b[i + 1] = _mm256_unpackhi_ps(a[i], a[i + 1]);
    }
    for i in (0..SQUARE).step_by(4) {
        a[i] = _mm256_shuffle_ps::<0x44>(b[i], b[i + 2]);
        a[i + 1] = _mm256_shuffle_ps::<0xee>(b[i], b[i + 2]);
        a[i + 2] = _mm256_shuffle_ps::<0x44>(b[i + 1], b[i + 3]);
        a[i + 3] = _mm256_shuffle_ps::<0xee>(b[i + 1], b[i + 3]);
    }
    let mut out = [[0.0; SQUARE]; SQUARE];
    let mut store = |column: usize, value: __m256| {
        // SAFETY: a row of the result has room for the eight numbers that are stored.
        unsafe { _mm256_storeu_ps(out[column].as_mut_ptr(), value) };
    };
    for i in 0..SQUARE / 2 {
        store(i, _mm256_permute2f128_ps::<0x20>(a[i], a[i + 4]));
        store(i + 4, _mm256_permute2f128_ps::<0x31>(a[i], a[i + 4]));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::{AVX2, Isa, PORTABLE};

    #[test]
    fn rows_become_columns() {
        let rows: [[f32; SQUARE]; SQUARE] =
            std::array::from_fn(|i| std::array::from_fn(|j| (i * SQUARE + j) as f32));
        let expected: [[f32; SQUARE]; SQUARE] =
            std::array::from_fn(|i| std::array::from_fn(|j| (j * SQUARE + i) as f32));
        assert_eq!(transposed::<PORTABLE>(&rows), expected);
        if Isa::available().any(|isa| isa.id() == AVX2) {
            assert_eq!(transposed::<AVX2>(&rows), expected);
        }
    }
}
