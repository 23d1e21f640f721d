//! Counter-based randomness: one independent ChaCha8 stream per purpose, task and start.
//!
//! A stream is named by numbers, never by the order in which threads ask, so that the number of
//! threads cannot change a result.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

/// What a stream is for; keeps the streams of one seed apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Purpose {
    /// Drawing a task of a suite.
    Task = 1,
    /// Drawing a start trajectory.
    Start = 2,
    /// A planner that samples.
    Planner = 3,
    /// Initial network parameters.
    Parameters = 4,
    /// An environment's action noise.
    Environment = 5,
    /// Shuffling of training samples.
    Shuffle = 6,
    /// Drawing of imitation data.
    Imitation = 7,
    /// Drawing starts and goals on a map.
    Query = 8,
    /// Alternative routes of the shortest-path expert.
    Expert = 9,
    /// A rollout of DAgger.
    Dagger = 10,
    /// Looking for links of a robot that always touch.
    Contacts = 11,
}

/// The stream for a purpose, numbered by `index` (a task) and `sub` (a start, an environment).
pub fn stream(seed: u64, purpose: Purpose, index: u64, sub: u64) -> ChaCha8Rng {
    let mut key = [0u8; 32];
    key[..8].copy_from_slice(&seed.to_le_bytes());
    key[8..16].copy_from_slice(&index.to_le_bytes());
    key[16..24].copy_from_slice(&sub.to_le_bytes());
    key[24] = purpose as u8;
    ChaCha8Rng::from_seed(key)
}

/// Two independent standard normal numbers (Box and Muller 1958). It always takes four words of the stream, so a
/// stream's position tells how many were drawn; 53 bits of the uniform reach to 8.6 standard deviations.
pub fn standard_normal(rng: &mut ChaCha8Rng) -> [f32; 2] {
    // 1 - u lies in (0, 1], so the logarithm is finite.
    let radius = (-2.0 * (1.0 - rng.random::<f64>()).ln()).sqrt();
    let (sin, cos) = (std::f64::consts::TAU * rng.random::<f64>()).sin_cos();
    [(radius * cos) as f32, (radius * sin) as f32]
}
