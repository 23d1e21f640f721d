//! Iterates of L-BFGS, frozen from another implementation of the same method.

use crate::objective::{Cost, Objective};
use crate::optimizer::{Known, Method, Optimizer};
use crate::profile::Profile;
use crate::rng::{Purpose, stream};
use crate::scene::{Query, Task};
use crate::suite::Suite;

/// FNV-1a over the bits of all iterates of `steps` steps from the straight line.
fn fingerprint(task: &Task, profile: &Profile, memory: usize) -> u64 {
    let mut objective = Objective::new(&Query::of(task, profile), 10).unwrap();
    let rng = stream(7, Purpose::Planner, 0, 0);
    let mut optimizer = Optimizer::new(&Method::Lbfgs { memory }, &objective, rng).unwrap();
    let mut x = vec![0.0; objective.dim()];
    objective.straight_line(&mut x);
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    for _ in 0..60 {
        let known = Known { cost: Cost::default(), gradient: &[], free: &[] };
        optimizer.step(&mut x, known, &mut objective);
        assert!(x.iter().all(|v| v.is_finite()), "{x:?}");
        for byte in x.iter().flat_map(|v| v.to_bits().to_le_bytes()) {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
    hash
}

#[test]
fn iterates_are_those_of_argmin() {
    let suites = [Suite::Easy, Suite::Hard].map(|suite| suite.generate(24, 7, &Profile::PAPER));
    let mut wrong = Vec::new();
    for (index, frozen) in FROZEN.into_iter().enumerate() {
        let task = &suites[index % 2][index];
        let profile = &[Profile::DEFAULT, Profile::PAPER][index / 2 % 2];
        let memory = [7, 1, 3][index / 4 % 3];
        let got = fingerprint(task, profile, memory);
        if got != frozen {
            wrong.push((index, got));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#x?}");
}

/// What the argmin crate 0.11 gave: easy and hard by turns, profiles `default` and `paper` by pairs.
#[rustfmt::skip]
const FROZEN: [u64; 24] = [
    0xb6bd_0462_b875_cfbf, 0xebdb_737a_1b57_9e96, 0x2fbf_48eb_c1e1_c55d, 0x205f_c198_4521_6ce0,
    0x699e_a4a0_a3e8_461f, 0xe772_d280_a2fc_468c, 0xbee6_2fc1_a49c_a788, 0x92e0_ac82_5e16_1360,
    0xdd8a_e61c_a688_f376, 0x5c2a_30eb_5c59_6e5a, 0xa9a8_381f_d9a3_5398, 0x2bd3_76d4_f328_36ee,
    0xa3ed_8043_0a6e_f31c, 0x0fe4_42d3_2182_a49a, 0xcdbe_117f_06f4_8bbf, 0xe654_50db_c611_f023,
    0xc1ca_0eee_2f8a_7f1d, 0xf018_e466_d286_73cb, 0x92e0_ac82_5e16_1360, 0xa56e_0bdc_582d_36ed,
    0x7866_edd3_d3a7_337c, 0x249d_676d_523b_b327, 0x0082_6196_67b7_7b05, 0xbccf_ca47_4680_ef60,
];
