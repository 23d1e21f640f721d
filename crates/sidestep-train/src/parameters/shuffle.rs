//! A random order of rows.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// Fisher-Yates.
pub fn shuffle_in_place(order: &mut [u32], rng: &mut ChaCha8Rng) {
    for last in (1..order.len()).rev() {
        order.swap(last, rng.random_range(0..=last as u32) as usize);
    }
}
