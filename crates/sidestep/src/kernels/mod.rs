//! Hot loops, compiled once per instruction set and chosen at run time.
//!
//! Each kernel is one generic `#[inline(always)]` body `fn body<const ISA: u8>(...)` in plain safe
//! Rust wherever that is fast enough. `dispatch!` compiles it for AVX-512, for AVX2 + FMA and for
//! the target's baseline, and picks by an `Isa` token, which only exists for instruction sets
//! that this machine has.
//!
//! **Bits.** Rust never reorders or contracts float arithmetic, so a body gives the same bits on
//! AVX-512 and AVX2, however it is vectorised, as long as it multiplies and adds through `madd` and
//! does not let `ISA` change the order of a sum. Sums therefore use a fixed lane structure: `[f32; LANES]`
//! accumulators folded by `lane_sum`. The portable kernels round the product (no `fma` instruction)
//! and differ in the last bits; on aarch64 fused multiply-add is part of the baseline, so they agree.
//! Only what multiplies matrices is concerned, policies and their training: distances, the objective, classical
//! optimizers, the exact search and the certificate have the same bits everywhere. [`Kernels::limit`] reproduces
//! elsewhere what a machine without AVX2 answers.
//!
//! `-C target-cpu=native` for the whole program was measured 1.3-3.5 times slower; hence dispatch.
#![allow(unsafe_code, reason = "calling functions compiled for detected CPU features")]

mod adam;
pub(crate) mod clearance;
pub(crate) mod conv;
pub(crate) mod dense;
pub(crate) mod lanes;
mod norm;
mod product;
pub(crate) mod shift;
mod tanh;
pub(crate) mod transpose;

use std::sync::atomic::{AtomicU8, Ordering};

pub use adam::AdamStep;
pub(crate) use clearance::Block;
pub use norm::squared_norm;

use crate::error::InvalidInput;

/// Lanes of an accumulator: one AVX-512 register, two of AVX2, four of SSE2 or NEON.
pub const LANES: usize = 16;

/// The lesser number, and `b` if one is NaN: one instruction, where `f32::min` needs three.
#[inline(always)]
pub(crate) fn least(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// The greater number, and `b` if one is NaN.
#[inline(always)]
pub(crate) fn most(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// `ISA` of a body compiled for the target's baseline.
pub(crate) const PORTABLE: u8 = 0;
/// `ISA` of a body compiled for AVX2 + FMA.
pub(crate) const AVX2: u8 = 1;
/// `ISA` of a body compiled for AVX-512 (F, VL, BW, DQ) with AVX2 + FMA.
pub(crate) const AVX512: u8 = 2;

/// The kernels of an instruction set.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum Kernels {
    /// Those of the target's baseline: on x86-64 and wasm, products are rounded before they are added.
    Portable = PORTABLE,
    /// AVX2 and fused multiply-add.
    Avx2 = AVX2,
    /// AVX-512 F, VL, BW and DQ; the same bits as AVX2.
    Avx512 = AVX512,
}

/// The most that [`Isa::detect`] answers.
static MOST: AtomicU8 = AtomicU8::new(AVX512);

impl Kernels {
    /// All kernels with their names, narrowest first.
    pub const NAMES: [(&'static str, Self); 3] =
        [("portable", Self::Portable), ("avx2", Self::Avx2), ("avx512", Self::Avx512)];

    /// The kernels of that name.
    ///
    /// # Errors
    /// If there are none.
    pub fn named(name: &str) -> Result<Self, InvalidInput> {
        let known = Self::NAMES.iter().find(|(known, _)| *known == name);
        let allowed = || Self::NAMES.map(|(known, _)| known).join(", ");
        known
            .map(|&(_, kernels)| kernels)
            .ok_or_else(|| InvalidInput::new("kernels", name, allowed()))
    }

    /// From now on uses none wider than these in this process, even where the machine has them: to reproduce the bits of
    /// another machine. Objectives and networks that exist already keep theirs.
    pub fn limit(self) {
        MOST.store(self as u8, Ordering::Relaxed);
    }
}

/// An instruction set that this machine has: the proof that `dispatch!` needs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Isa(u8);

impl Isa {
    /// The best one for this machine within [`Kernels::limit`]. Costs a few loads: std caches the detection.
    #[inline]
    pub(crate) fn detect() -> Self {
        Self(Self::widest().0.min(MOST.load(Ordering::Relaxed)))
    }

    #[inline]
    fn widest() -> Self {
        #[cfg(target_arch = "x86_64")]
        if std::is_x86_feature_detected!("avx2") && std::is_x86_feature_detected!("fma") {
            let wide = std::is_x86_feature_detected!("avx512f")
                && std::is_x86_feature_detected!("avx512vl")
                && std::is_x86_feature_detected!("avx512bw")
                && std::is_x86_feature_detected!("avx512dq");
            return Self(if wide { AVX512 } else { AVX2 });
        }
        Self(PORTABLE)
    }

    /// Every one that this machine has, portable first; for tests that compare them.
    #[cfg(test)]
    pub(crate) fn available() -> impl Iterator<Item = Self> {
        (PORTABLE..=Self::widest().0).map(Self)
    }

    /// One of `PORTABLE`, `AVX2`, `AVX512`.
    #[cfg(target_arch = "x86_64")]
    #[inline]
    pub(crate) fn id(self) -> u8 {
        self.0
    }
}

/// `a * b + c`: one rounding where the instruction set has fused multiply-add, else two.
///
/// The portable x86 and wasm builds must not call `mul_add`: it would be a libm call per element.
#[inline(always)]
pub(crate) fn madd<const ISA: u8>(a: f32, b: f32, c: f32) -> f32 {
    if ISA != PORTABLE || cfg!(target_arch = "aarch64") { a.mul_add(b, c) } else { a * b + c }
}

/// Sum of the lanes as a balanced tree, the same on every instruction set.
#[inline(always)]
pub(crate) fn lane_sum(lanes: [f32; LANES]) -> f32 {
    let mut sums = lanes;
    let mut width = LANES / 2;
    while width > 0 {
        for lane in 0..width {
            sums[lane] += sums[lane + width];
        }
        width /= 2;
    }
    sums[0]
}

/// Defines a kernel's entry point: `dispatch! { /// docs  pub(crate) fn name(args) -> ret = body; }`
/// makes `name(isa: Isa, args) -> ret`, which runs `body::<ISA>(args)` compiled for `isa`.
///
/// `body` must be `#[inline(always)]`, else it is compiled without the features.
macro_rules! dispatch {
    ($(#[$meta:meta])* $vis:vis fn $name:ident($($arg:ident: $ty:ty),* $(,)?) $(-> $ret:ty)? = $body:ident;) => {
        $(#[$meta])*
        #[allow(unsafe_code, reason = "calls a function compiled for detected CPU features")]
        #[allow(clippy::too_many_arguments, reason = "kernels take flat slices and sizes")]
        #[inline]
        $vis fn $name(isa: $crate::kernels::Isa, $($arg: $ty),*) $(-> $ret)? {
            #[cfg(target_arch = "x86_64")]
            {
                #[target_feature(enable = "avx512f,avx512vl,avx512bw,avx512dq,avx2,fma")]
                fn avx512($($arg: $ty),*) $(-> $ret)? {
                    $body::<{ $crate::kernels::AVX512 }>($($arg),*)
                }
                #[target_feature(enable = "avx2,fma")]
                fn avx2($($arg: $ty),*) $(-> $ret)? {
                    $body::<{ $crate::kernels::AVX2 }>($($arg),*)
                }
                if isa.id() == $crate::kernels::AVX512 {
                    // SAFETY: an `Isa` with this id is only made when all of these features were detected.
                    return unsafe { avx512($($arg),*) };
                }
                if isa.id() == $crate::kernels::AVX2 {
                    // SAFETY: as above, for AVX2 and FMA.
                    return unsafe { avx2($($arg),*) };
                }
            }
            let _ = isa;
            $body::<{ $crate::kernels::PORTABLE }>($($arg),*)
        }
    };
}
pub(crate) use dispatch;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lane_sum_adds_all_lanes() {
        let lanes: [f32; LANES] = std::array::from_fn(|lane| (1 << lane) as f32);
        assert_eq!(lane_sum(lanes), 65535.0);
    }

    #[test]
    fn names_are_ordered_and_others_refused() {
        for pair in Kernels::NAMES.windows(2) {
            assert!(pair[0].1 < pair[1].1);
            assert_eq!(Kernels::named(pair[0].0), Ok(pair[0].1));
        }
        let refused = Kernels::named("sse9").unwrap_err();
        assert_eq!(refused.allowed, "portable, avx2, avx512");
    }

    #[test]
    fn portable_is_always_available() {
        assert_eq!(Isa::available().next(), Some(Isa(PORTABLE)));
        assert!(Isa::available().any(|isa| isa == Isa::widest()));
    }
}
