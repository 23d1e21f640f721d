//! Pairs of links that touch whatever the joints do: found by sampling.
//!
//! Balls that stand for neighbouring links overlap at the joint between them, and an SRDF need not know of all links that
//! somebody gave balls. Such a pair would make every configuration a collision. MoveIt's setup assistant drops a pair that
//! touches in all of many random configurations; so does this, and says which.

use rand::RngExt;

use super::robot::Arm;
use crate::rng::{Purpose, stream};
use crate::space::vector::{norm, sub};

/// Configurations that are drawn.
const SAMPLES: u64 = 256;

impl Arm {
    /// The same robot without the checks of those pairs of links that touch in all of 256 random configurations, and the
    /// names of these pairs. The draw is always the same.
    pub fn without_lasting_contacts(mut self) -> (Self, Vec<(String, String)>) {
        let mut lasting = self.pairs.clone();
        let mut rng = stream(0, Purpose::Contacts, 0, 0);
        for _ in 0..SAMPLES {
            if lasting.is_empty() {
                break;
            }
            let draw = |joint: &super::ArmJoint| {
                joint.lower + rng.random::<f64>() * (joint.upper - joint.lower)
            };
            let configuration: Vec<f64> = self.joints().iter().map(draw).collect();
            let balls = self.balls_at(&configuration);
            lasting.retain(|&[a, b]| {
                let of = |part: usize| &balls[self.parts[part].balls.clone()];
                of(a).iter().any(|p| {
                    of(b).iter().any(|q| norm(sub(p.center, q.center)) <= p.radius + q.radius)
                })
            });
        }
        self.pairs.retain(|pair| !lasting.contains(pair));
        let name = |part: usize| self.parts[part].name.clone();
        let names = lasting.iter().map(|&[a, b]| (name(a), name(b))).collect();
        (self, names)
    }
}
