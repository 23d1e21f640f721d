//! A row of numbers in registers, moved by one.

use super::LANES;

/// `block` with its lanes moved one up and one down: `[the last of before, block[0], ..]` and `[.., block[15], the first of after]`.
///
/// The compiler would move them through memory, where what has just been stored takes long to load at another place.
#[inline(always)]
pub(crate) fn moved<const ISA: u8>(
    before: &[f32; LANES],
    block: &[f32; LANES],
    after: &[f32; LANES],
) -> [[f32; LANES]; 2] {
    #[cfg(target_arch = "x86_64")]
    if ISA == super::AVX512 {
        // SAFETY: this `ISA` has AVX-512F.
        return unsafe { moved_in_registers(before, block, after) };
    }
    let mut moved = [[before[LANES - 1]; LANES], [after[0]; LANES]];
    moved[0][1..].copy_from_slice(&block[..LANES - 1]);
    moved[1][..LANES - 1].copy_from_slice(&block[1..]);
    moved
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f")]
#[inline]
fn moved_in_registers(
    before: &[f32; LANES],
    block: &[f32; LANES],
    after: &[f32; LANES],
) -> [[f32; LANES]; 2] {
    use std::arch::x86_64::{_mm512_alignr_epi32, _mm512_loadu_si512, _mm512_storeu_si512};
    let load = |block: &[f32; LANES]| {
        // SAFETY: a block has the sixteen numbers that are loaded.
        unsafe { _mm512_loadu_si512(block.as_ptr().cast()) }
    };
    let [before, block, after] = [load(before), load(block), load(after)];
    let mut moved = [[0.0; LANES]; 2];
    let [up, down] = &mut moved;
    // SAFETY: each has room for the sixteen numbers that are stored.
    unsafe {
        _mm512_storeu_si512(up.as_mut_ptr().cast(), _mm512_alignr_epi32::<15>(block, before));
        _mm512_storeu_si512(down.as_mut_ptr().cast(), _mm512_alignr_epi32::<1>(after, block));
    }
    moved
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::{AVX512, Isa, PORTABLE};

    #[test]
    fn lanes_move_by_one() {
        let row: [f32; 3 * LANES] = std::array::from_fn(|i| i as f32);
        let [before, block, after] = [0, 1, 2].map(|b| *row[b * LANES..].first_chunk().unwrap());
        let expected: [[f32; LANES]; 2] =
            [LANES - 1, LANES + 1].map(|first| std::array::from_fn(|i| (first + i) as f32));
        assert_eq!(moved::<PORTABLE>(&before, &block, &after), expected);
        if Isa::available().any(|isa| isa.id() == AVX512) {
            assert_eq!(moved::<AVX512>(&before, &block, &after), expected);
        }
    }
}
