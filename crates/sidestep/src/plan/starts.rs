//! Start trajectories: where the optimizer begins.
//!
//! Start 0 of every strategy is the straight line; the others are random, each from its own stream.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::error::InvalidInput;
use crate::objective::Objective;
use crate::rng::standard_normal;

/// How random start trajectories are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum StartStrategy {
    /// The straight line every time.
    Line,
    /// Start, one uniform random via-point, goal, evenly spaced by length.
    #[default]
    ViaPoint,
    /// Uniform random waypoints, sorted along the direction from start to goal.
    Sorted,
    /// Uniform random waypoints in the order they are drawn.
    Random,
    /// The paper's code: uniform random waypoints, each coordinate sorted ascending on its own, so
    /// that every start runs from lower left to upper right whatever the task.
    Paper,
}

impl StartStrategy {
    /// All strategies with their names.
    pub const NAMES: [(&'static str, Self); 5] = [
        ("line", Self::Line),
        ("via-point", Self::ViaPoint),
        ("sorted", Self::Sorted),
        ("random", Self::Random),
        ("paper", Self::Paper),
    ];

    /// The strategy of that name.
    ///
    /// # Errors
    /// If there is none.
    pub fn named(name: &str) -> Result<Self, InvalidInput> {
        Self::NAMES
            .iter()
            .find(|(known, _)| *known == name)
            .map(|&(_, strategy)| strategy)
            .ok_or_else(|| {
                InvalidInput::new(
                    "start-strategy",
                    name,
                    Self::NAMES.map(|(known, _)| known).join(", "),
                )
            })
    }

    /// The strategy's name.
    pub fn name(&self) -> &'static str {
        Self::NAMES.iter().find(|(_, strategy)| strategy == self).map_or("", |&(name, _)| name)
    }

    /// Writes a start trajectory for `objective` to `x` (`[N x 2]`, normalised units).
    pub fn draw(&self, objective: &Objective, rng: &mut ChaCha8Rng, x: &mut [f32]) {
        let field = NormalisedField::new(objective.scene().field_size());
        let points = x.as_chunks_mut::<2>().0;
        match self {
            Self::Line => objective.straight_line(x),
            Self::ViaPoint => {
                let via = field.draw(rng);
                polyline(&[objective.start(), via, objective.goal()], points);
            }
            Self::Random => points.fill_with(|| field.draw(rng)),
            Self::Sorted => {
                points.fill_with(|| field.draw(rng));
                let (start, goal) = (objective.start(), objective.goal());
                let along =
                    |p: &[f32; 2]| p[0] * (goal[0] - start[0]) + p[1] * (goal[1] - start[1]);
                points.sort_by(|p, q| along(p).total_cmp(&along(q)));
            }
            Self::Paper => {
                points.fill_with(|| field.draw(rng));
                for axis in 0..2 {
                    let mut values: Vec<f32> = points.iter().map(|p| p[axis]).collect();
                    values.sort_by(f32::total_cmp);
                    points.iter_mut().zip(values).for_each(|(p, value)| p[axis] = value);
                }
            }
        }
    }
}

/// Adds smooth noise to the waypoints `x [N x 2]`: sine modes 1 to 4 along the trajectory, mode k with standard
/// deviation `size` / k, in normalised units.
pub fn bend(x: &mut [f32], size: f32, rng: &mut ChaCha8Rng) {
    let points = x.as_chunks_mut::<2>().0;
    let segments = (points.len() + 1) as f32;
    for mode in 1..=4 {
        let noise = standard_normal(rng).map(|z| size / mode as f32 * z);
        for (i, p) in points.iter_mut().enumerate() {
            let shape = (std::f32::consts::PI * mode as f32 * (i + 1) as f32 / segments).sin();
            p[0] += shape * noise[0];
            p[1] += shape * noise[1];
        }
    }
}

/// The field less a margin of 0.1 normalised units (the paper's one pixel) on each side.
struct NormalisedField {
    min: [f32; 2],
    size: [f32; 2],
}

impl NormalisedField {
    fn new(size: [f32; 2]) -> Self {
        let margin = 0.1;
        let [width, height] = size;
        Self { min: [margin; 2], size: [width - 2.0 * margin, height - 2.0 * margin] }
    }

    fn draw(&self, rng: &mut ChaCha8Rng) -> [f32; 2] {
        let x = self.min[0] + rng.random::<f32>() * self.size[0];
        let y = self.min[1] + rng.random::<f32>() * self.size[1];
        [x, y]
    }
}

/// Spreads `out` evenly by length along the polyline through `corners`, its ends left out.
pub fn polyline(corners: &[[f32; 2]], out: &mut [[f32; 2]]) {
    let length = |a: [f32; 2], b: [f32; 2]| (b[0] - a[0]).hypot(b[1] - a[1]);
    let total: f32 = corners.windows(2).map(|w| length(w[0], w[1])).sum();
    let segments = (out.len() + 1) as f32;
    let mut corner = 0;
    let mut passed = 0.0;
    for (i, p) in out.iter_mut().enumerate() {
        let target = total * (i + 1) as f32 / segments;
        while corner + 2 < corners.len()
            && passed + length(corners[corner], corners[corner + 1]) < target
        {
            passed += length(corners[corner], corners[corner + 1]);
            corner += 1;
        }
        let (a, b) = (corners[corner], corners[corner + 1]);
        let part = length(a, b);
        let t = if part > 0.0 { ((target - passed) / part).clamp(0.0, 1.0) } else { 0.0 };
        *p = [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])];
    }
}
