//! When a robot is where: time-optimal timing of a path under limits of velocity and acceleration.
//!
//! A path says where a robot goes, `q(s)`; timing says how fast, `s(t)`. [`time_path`] finds the
//! fastest timing by two passes over a grid of s (`reachability.rs`), on a path whose corners are
//! cut by parabolas or stopped at (`path.rs`). On such a path the accelerations between two grid
//! points lie between those at them, so the limits hold everywhere and not only on the grid.
//!
//! ```
//! use sidestep::trajectory::timing::{Limits, Path, time_path};
//!
//! // Two joints, three configurations; the corner is cut 0.1 rad before and after it.
//! let path = Path::blended(&[0.0, 0.0, 1.0, 0.0, 1.0, 1.0], 2, &[0.1]).unwrap();
//! let limits = Limits::new(vec![1.0, 1.0], vec![4.0, 4.0]).unwrap();
//! let timed = time_path(&path, &limits).unwrap();
//! let there = timed.at(timed.duration());
//! assert!((there.position[1] - 1.0).abs() < 1e-9 && there.velocity == [0.0, 0.0]);
//! ```

mod limits;
mod path;
mod reachability;
#[cfg(test)]
mod tests;
mod timed;

pub use limits::Limits;
pub use path::Path;
pub use timed::{Moment, TimedPath, time_path};
