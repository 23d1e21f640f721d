//! A profile: the constants and choices that turn a task into an optimisation problem.
//!
//! The `paper` profile reproduces the published system, its quirks included; the `default` profile
//! does the same job right. A profile is data, so both share every line of code.

use crate::error::InvalidInput;

/// How the obstacle cost averages waypoints and substeps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Averaging {
    /// One mean over all points, as the paper's code does.
    Pooled,
    /// The mean over waypoints plus the mean over substeps, as the paper's formula says.
    Grouped,
}

/// Where distances come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DistanceKind {
    /// The paper's image: the field as 64 pixels, a distance transform of the obstacle image minus
    /// that of its complement inside a one-pixel frame of obstacle, read bilinearly.
    PaperImage,
    /// The exact signed distance to the union of shapes; grids by distance transform, read bicubically.
    Exact,
}

/// When the profile calls a trajectory feasible.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Feasibility {
    /// Start, goal, waypoints and this many substeps per segment are outside every open obstacle
    /// and strictly inside the bounds. It can miss a corner cut between samples.
    Sampled {
        /// Substeps per segment.
        substeps: usize,
    },
    /// The exact certificate of the swept body.
    Exact,
}

/// The constants of the objective and of the feasibility check. Lengths are in normalised units:
/// the larger side of the bounds is 6.4 of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Profile {
    /// Name in reports and on the command line.
    pub name: &'static str,
    /// Waypoints N between start and goal, unless the caller says otherwise.
    pub waypoints: usize,
    /// Cost substeps S per segment.
    pub substeps: usize,
    /// Obstacle clearance ε under which a point is penalised, in normalised units.
    pub epsilon: f64,
    /// Whether ε is at most the typical clearance where the world is a map, whose passages are
    /// narrow beside its extent ([`crate::Scene::epsilon`]).
    pub fits_epsilon_to_maps: bool,
    /// Weight λ of the length cost.
    pub lambda: f64,
    /// How the obstacle cost is averaged.
    pub averaging: Averaging,
    /// Where distances come from.
    pub distance: DistanceKind,
    /// Factor on the obstacle gradient only; 8 reproduces the paper's undivided Sobel filter.
    pub obstacle_gradient_factor: f64,
    /// When a trajectory is feasible.
    pub feasibility: Feasibility,
    /// Default step γ of gradient descent.
    pub gradient_step: f64,
}

/// Normalised units along the larger side of the bounds (the paper's 64 pixels of 0.1).
pub const NORMALISED_EXTENT: f64 = 6.4;

/// Most waypoints that a trajectory may have.
pub const MAX_WAYPOINTS: usize = 100_000;

impl Profile {
    /// The published system (`original code`, constants in METHODOLOGY.md).
    pub const PAPER: Self = Self {
        name: "paper",
        waypoints: 10,
        substeps: 5,
        epsilon: 1.0,
        fits_epsilon_to_maps: false,
        lambda: 0.1,
        averaging: Averaging::Pooled,
        distance: DistanceKind::PaperImage,
        obstacle_gradient_factor: 8.0,
        feasibility: Feasibility::Sampled { substeps: 10 },
        gradient_step: 0.1,
    };

    /// The corrected form. λ is an eighth of the paper's: the paper's gradient weighs obstacles
    /// eight times, and without that weight every optimizer does worse (METHODOLOGY.md).
    pub const DEFAULT: Self = Self {
        name: "default",
        waypoints: 10,
        substeps: 8,
        epsilon: 1.0,
        fits_epsilon_to_maps: true,
        lambda: 0.0125,
        averaging: Averaging::Grouped,
        distance: DistanceKind::Exact,
        obstacle_gradient_factor: 1.0,
        feasibility: Feasibility::Exact,
        gradient_step: 2.0,
    };

    /// Names of the profiles.
    pub const NAMES: [&'static str; 2] = ["default", "paper"];
}

impl std::str::FromStr for Profile {
    type Err = InvalidInput;

    /// The profile of that name.
    fn from_str(name: &str) -> Result<Self, InvalidInput> {
        match name {
            "default" => Ok(Self::DEFAULT),
            "paper" => Ok(Self::PAPER),
            _ => Err(InvalidInput::unknown("profile", name, &Self::NAMES)),
        }
    }
}
