//! What is asked of all lanes of a register together: its least number, which lanes are above a bound, neighbours.
//!
//! The compiler would take these apart into pairs of numbers, or send them through memory, which costs more than
//! what is computed in the lanes. All of it is the same on every instruction set.

use super::LANES;

/// Sixteen numbers.
type Lane = [f32; LANES];

/// A bit for each lane that is above `bound`; NaN is not.
#[inline(always)]
pub(crate) fn above<const ISA: u8>(lanes: &Lane, bound: f32) -> u32 {
    #[cfg(target_arch = "x86_64")]
    if ISA == super::AVX512 {
        // SAFETY: this `ISA` has AVX-512F.
        return unsafe { avx512::above(lanes, bound) };
    }
    #[cfg(target_arch = "x86_64")]
    if ISA == super::AVX2 {
        // SAFETY: this `ISA` has AVX2.
        return unsafe { avx2::above(lanes, bound) };
    }
    let mut bits = 0;
    for lane in 0..LANES {
        bits |= u32::from(lanes[lane] > bound) << lane;
    }
    bits
}

/// Whether every lane is above `bound`; NaN is not.
#[inline(always)]
pub(crate) fn all_above<const ISA: u8>(lanes: &Lane, bound: f32) -> bool {
    above::<ISA>(lanes, bound) == 0xffff
}

/// The least number of the lanes; of no use if one is NaN.
#[inline(always)]
pub(crate) fn lane_min<const ISA: u8>(lanes: &Lane) -> f32 {
    #[cfg(target_arch = "x86_64")]
    if ISA == super::AVX512 {
        // SAFETY: this `ISA` has AVX-512F.
        return unsafe { avx512::lane_min(lanes) };
    }
    folded(lanes, super::least)
}

/// The largest number of the lanes; of no use if one is NaN.
#[inline(always)]
pub(crate) fn lane_max<const ISA: u8>(lanes: &Lane) -> f32 {
    #[cfg(target_arch = "x86_64")]
    if ISA == super::AVX512 {
        // SAFETY: this `ISA` has AVX-512F.
        return unsafe { avx512::lane_max(lanes) };
    }
    folded(lanes, super::most)
}

/// Each lane's right neighbour; the last one's is itself.
#[inline(always)]
pub(crate) fn shifted<const ISA: u8>(lanes: &Lane) -> Lane {
    #[cfg(target_arch = "x86_64")]
    if ISA == super::AVX512 {
        // SAFETY: this `ISA` has AVX-512F.
        return unsafe { avx512::shifted(lanes) };
    }
    let mut next = *lanes;
    next[..LANES - 1].copy_from_slice(&lanes[1..]);
    next
}

/// The lanes put together as a balanced tree.
#[inline(always)]
fn folded(lanes: &Lane, together: impl Fn(f32, f32) -> f32) -> f32 {
    let mut folded = *lanes;
    let mut width = LANES / 2;
    while width > 0 {
        for lane in 0..width {
            folded[lane] = together(folded[lane], folded[lane + width]);
        }
        width /= 2;
    }
    folded[0]
}

#[cfg(target_arch = "x86_64")]
mod avx512 {
    use std::arch::x86_64::{
        __m512, _CMP_GT_OQ, _mm512_cmp_ps_mask, _mm512_loadu_ps, _mm512_permutexvar_ps,
        _mm512_reduce_max_ps, _mm512_reduce_min_ps, _mm512_set1_ps, _mm512_setr_epi32,
        _mm512_storeu_ps,
    };

    use super::Lane;

    #[target_feature(enable = "avx512f")]
    #[inline]
    fn load(lanes: &Lane) -> __m512 {
        // SAFETY: there are sixteen numbers.
        unsafe { _mm512_loadu_ps(lanes.as_ptr()) }
    }

    #[target_feature(enable = "avx512f")]
    #[inline]
    pub(super) fn above(lanes: &Lane, bound: f32) -> u32 {
        u32::from(_mm512_cmp_ps_mask::<_CMP_GT_OQ>(load(lanes), _mm512_set1_ps(bound)))
    }

    #[target_feature(enable = "avx512f")]
    #[inline]
    pub(super) fn lane_min(lanes: &Lane) -> f32 {
        _mm512_reduce_min_ps(load(lanes))
    }

    #[target_feature(enable = "avx512f")]
    #[inline]
    pub(super) fn lane_max(lanes: &Lane) -> f32 {
        _mm512_reduce_max_ps(load(lanes))
    }

    #[target_feature(enable = "avx512f")]
    #[inline]
    pub(super) fn shifted(lanes: &Lane) -> Lane {
        let next = _mm512_setr_epi32(1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 15);
        let mut out = [0.0; super::LANES];
        let moved = _mm512_permutexvar_ps(next, load(lanes));
        // SAFETY: there is room for sixteen numbers.
        unsafe { _mm512_storeu_ps(out.as_mut_ptr(), moved) };
        out
    }
}

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use std::arch::x86_64::{
        _CMP_GT_OQ, _mm256_cmp_ps, _mm256_loadu_ps, _mm256_movemask_ps, _mm256_set1_ps,
    };

    use super::Lane;

    #[target_feature(enable = "avx2")]
    #[inline]
    pub(super) fn above(lanes: &Lane, bound: f32) -> u32 {
        let bound = _mm256_set1_ps(bound);
        // SAFETY: there are sixteen numbers, eight and eight.
        let [low, high] =
            unsafe { [_mm256_loadu_ps(lanes.as_ptr()), _mm256_loadu_ps(lanes.as_ptr().add(8))] };
        let [low, high] = [low, high].map(|half| _mm256_cmp_ps::<_CMP_GT_OQ>(half, bound));
        let [low, high] = [_mm256_movemask_ps(low), _mm256_movemask_ps(high)];
        (low | high << 8) as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::{Isa, dispatch};

    dispatch! {
        fn answers(lanes: &Lane, bound: f32) -> (u32, f32, f32, Lane) = answers_body;
    }

    #[inline(always)]
    fn answers_body<const ISA: u8>(lanes: &Lane, bound: f32) -> (u32, f32, f32, Lane) {
        let ends = (lane_min::<ISA>(lanes), lane_max::<ISA>(lanes));
        (above::<ISA>(lanes, bound), ends.0, ends.1, shifted::<ISA>(lanes))
    }

    #[test]
    fn the_same_everywhere() {
        let lanes: Lane = std::array::from_fn(|lane| ((lane * 7 + 3) % 16) as f32 - 4.0);
        for isa in Isa::available() {
            let (bits, least, most, next) = answers(isa, &lanes, 2.0);
            for lane in 0..LANES {
                assert_eq!(bits >> lane & 1 == 1, lanes[lane] > 2.0);
                assert_eq!(next[lane], lanes[(lane + 1).min(LANES - 1)]);
            }
            assert_eq!((bits >> LANES, least, most), (0, -4.0, 11.0));
            let mut odd = lanes;
            odd[5] = f32::NAN;
            assert_eq!(answers(isa, &odd, -100.0).0, 0xffff ^ 1 << 5);
        }
    }
}
