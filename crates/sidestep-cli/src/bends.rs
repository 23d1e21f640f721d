//! Flags that wish for gentle bends, and the answer where they cannot be kept.

use clap::Args;
use sidestep::Trajectory;
use sidestep::error::{InvalidInput, MAX_COORDINATE};
use sidestep::plan::Wishes;

/// What is wished of a plan's bends.
#[derive(Args, Clone)]
pub struct BendArgs {
    /// Wish for no corner sharper than this, in degrees from 0 to 180; the answer says where it cannot be
    /// kept [default: 20]
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true)]
    max_turn: Option<f64>,
    /// Wish for no turn tighter than this radius, in task units
    #[arg(long, value_name = "RADIUS", allow_negative_numbers = true)]
    min_radius: Option<f64>,
}

impl BendArgs {
    /// Checks the flags.
    pub fn check(&self) -> Result<(), InvalidInput> {
        if let Some(turn) = self.max_turn.filter(|turn| !(0.0..=180.0).contains(turn)) {
            return Err(InvalidInput::new("--max-turn", turn, "degrees from 0 to 180"));
        }
        let radius = self.min_radius.filter(|radius| !(0.0..=MAX_COORDINATE).contains(radius));
        radius.map_or(Ok(()), |radius| {
            Err(InvalidInput::new("--min-radius", radius, "a number from 0 to 1e9"))
        })
    }

    /// The wishes; none where no flag says anything.
    pub fn wishes(&self) -> Option<Wishes> {
        let Wishes { turn, radius } = Wishes::default();
        (self.max_turn.is_some() || self.min_radius.is_some()).then(|| Wishes {
            turn: self.max_turn.map_or(turn, f64::to_radians),
            radius: self.min_radius.unwrap_or(radius),
        })
    }
}

/// The wish that a path does not keep, in words.
pub fn broken(wishes: &Wishes, path: &Trajectory) -> Option<String> {
    let (turn, radius) = (path.sharpest_turn(), path.turning_radius());
    if turn > wishes.turn {
        let [turn, asked] = [turn, wishes.turn].map(f64::to_degrees);
        Some(format!(
            "the sharpest corner has {turn:.1} degrees, above the {asked:.1} that were wished"
        ))
    } else if radius < wishes.radius {
        let asked = wishes.radius;
        Some(format!(
            "the least turning radius is {radius:.4}, below the {asked:.4} that was wished"
        ))
    } else {
        None
    }
}
