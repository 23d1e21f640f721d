//! Optimisation-based motion planning with classical and learned optimizers, every plan certified.
//!
//! A [`Task`] asks for a path of a robot through its surroundings. [`plan()`] answers it with a [`Plan`]: a trajectory that
//! the exact certificate has passed, or the reason why there is none.
//!
//! ```
//! use std::sync::Arc;
//! use sidestep::{Obstacle, Options, Planner, Rect, Robot, Status, Task, World, plan};
//!
//! let table = Obstacle::Rect(Rect::new([3.0, 1.0], [5.0, 4.0])?);
//! let room = Arc::new(World::new(Rect::new([0.0, 0.0], [8.0, 5.0])?, vec![table], None));
//! let task = Task::in_plane("round the table", room, Robot::disc(0.3)?, [1.0, 2.0], [7.0, 2.0])?;
//!
//! let plan = plan(&task, &Planner::default(), &Options::default())?;
//! match &plan.status {
//!     Status::Solved(certified) => println!("{:.2} long", certified.trajectory().length()),
//!     other => println!("{}: {}", other.name(), other.reason()),
//! }
//! assert!(plan.is_solved());
//! # Ok::<(), sidestep::InvalidInput>(())
//! ```
//!
//! Other planners go by name (`"adam:step=0.2"`), and what they may use is in [`Options`]:
//!
//! ```
//! use sidestep::{Options, Planner, Profile, Suite, plan_batch};
//!
//! let planner: Planner = "adam".parse()?;
//! let options = Options { starts: 4, steps: 100, ..Options::default() };
//! let plans = plan_batch(&Suite::Easy.generate(20, 7, &Profile::PAPER), &planner, &options)?;
//! assert!(plans.iter().filter(|plan| plan.is_solved()).count() >= 15);
//! assert!("adma".parse::<Planner>().unwrap_err().to_string().contains("did you mean adam?"));
//! # Ok::<(), sidestep::InvalidInput>(())
//! ```
//!
//! # Where to look
//!
//! | you want | see |
//! | --- | --- |
//! | many questions in one world | [`Scene`], [`Query`], [`plan_in`](plan::plan_in) |
//! | to plan again from the last plan | [`Options::warm_start`] |
//! | a distance to keep | [`Task::with_margin`] |
//! | a time budget, every iterate | [`Watch`](plan::Watch) |
//! | a path checked that comes from elsewhere | [`certify`] |
//! | the shortest path, or a proof that there is none | [`plane::shortest_path`] |
//! | a cost of your own | [`Query::with_cost`] |
//! | an optimizer of your own | [`optimizer::Own`] |
//! | something of your own that a policy sees | [`policy::observation::OwnPart`] |
//! | a trained policy | [`Policy::from_safetensors`], [`Method::Learned`] |
//! | U and ∂U | [`objective`] |
//! | worlds in space, robots with joints | [`space`], [`arm`] |
//!
//! The crate opens no file, reads no clock and asks for no entropy; results are the same for any number of threads. Without the
//! feature `parallel` (on by default) it starts none.

pub mod arm;
pub mod error;
pub mod kernels;
pub mod network;
pub mod objective;
pub mod optimizer;
pub mod plan;
pub mod plane;
pub mod policy;
pub mod profile;
pub mod rng;
pub mod scene;
pub mod space;
pub mod suite;
pub mod trajectory;

pub use error::InvalidInput;
pub use optimizer::Method;
pub use plan::{Options, Plan, Planner, Status, Stop, plan, plan_batch};
pub use plane::Robot;
pub use plane::certificate::Certifier;
pub use plane::geometry::{Circle, ConvexPolygon, Rect};
pub use plane::shortest_path::{Route, ShortestPath};
pub use plane::world::{Grid, Obstacle, World};
pub use policy::Policy;
pub use profile::Profile;
pub use scene::{Certified, PlaneTask, Query, Scene, Setting, Task, certify};
pub use suite::Suite;
pub use trajectory::{Trajectory, Violation};

/// The README's examples are tests.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;
