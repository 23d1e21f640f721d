//! A part of an observation of one's own: a name and two functions.

use crate::error::InvalidInput;
use crate::objective::Objective;

/// Most numbers that a part of one's own may take.
const MAX_LEN: usize = 65_536;

/// Writes a part: the objective at whose waypoints `x [N x dof]` U was just computed, `x`, the `gradient [N x dof]` there, and what to fill.
pub type Write = fn(objective: &Objective, x: &[f32], gradient: &[f32], out: &mut [f32]);

/// A part of one's own, `own:NAME` in a configuration's or policy's list. Functions and not closures: what a policy sees
/// must not depend on anything but the task and its trajectory, or a file of it would not be whole.
///
/// ```
/// use sidestep::policy::observation::{ObservationPart, OwnPart};
///
/// // How far each waypoint is along the way, which the paper's agents have to guess from the order.
/// let progress = OwnPart {
///     name: "progress",
///     len: |waypoints, _| waypoints,
///     write: |_, _, _, out| {
///         let count = out.len() as f32;
///         out.iter_mut().enumerate().for_each(|(i, out)| *out = (i + 1) as f32 / (count + 1.0));
///     },
/// };
/// let part = ObservationPart::named("own:progress", &[progress])?;
/// assert_eq!(part.len(10, 2), 10);
/// # Ok::<(), sidestep::InvalidInput>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct OwnPart {
    /// What follows `own:`.
    pub name: &'static str,
    /// How many numbers it takes for so many waypoints of so many coordinates, from 1 to 65,536.
    pub len: fn(waypoints: usize, dof: usize) -> usize,
    /// What they are.
    pub write: Write,
}

impl OwnPart {
    pub(super) fn check(&self, waypoints: usize, dof: usize) -> Result<(), InvalidInput> {
        let len = (self.len)(waypoints, dof);
        if (1..=MAX_LEN).contains(&len) {
            return Ok(());
        }
        let (field, found) = (format!("observation.own:{}", self.name), format!("{len} numbers"));
        Err(InvalidInput::new(field, found, format!("from 1 to {MAX_LEN} numbers")))
    }
}

impl PartialEq for OwnPart {
    /// Parts are told apart by their names.
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl Eq for OwnPart {}

impl std::hash::Hash for OwnPart {
    fn hash<H: std::hash::Hasher>(&self, state: &mut H) {
        self.name.hash(state);
    }
}
