//! The four ways to look at a task, and the axes of each.

use crate::plane::Subject;

/// One of four ways to look at a task, which are the same task: from either end, and in a mirror that lies along the line from start to
/// goal. A policy that is asked what it sees need not answer alike; where it gets stuck one way it may get through the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Look {
    /// From goal to start.
    pub backwards: bool,
    /// With left and right exchanged.
    pub mirrored: bool,
}

impl Look {
    /// All four, the ordinary one first.
    pub const ALL: [Self; 4] = [
        Self { backwards: false, mirrored: false },
        Self { backwards: true, mirrored: false },
        Self { backwards: false, mirrored: true },
        Self { backwards: true, mirrored: true },
    ];
}

/// The axes of a look: along the line from one end to the other, and across it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Axes {
    /// Where the look begins.
    pub start: [f32; 2],
    /// Where it ends.
    pub goal: [f32; 2],
    /// From one to the other.
    pub length: f32,
    /// The direction of that, in field axes; (1, 0) where both are the same place.
    pub along: [f32; 2],
    /// 1, or in a mirror -1.
    side: f32,
}

impl Axes {
    pub fn new(subject: Subject<'_>, look: Look) -> Self {
        let (mut start, mut goal) = (subject.start, subject.goal);
        if look.backwards {
            std::mem::swap(&mut start, &mut goal);
        }
        let (dx, dy) = (goal[0] - start[0], goal[1] - start[1]);
        let length = dx.hypot(dy);
        let along = if length > 1e-6 { [dx / length, dy / length] } else { [1.0, 0.0] };
        Self { start, goal, length, along, side: if look.mirrored { -1.0 } else { 1.0 } }
    }

    /// A vector of field axes, from one along and across.
    pub fn turn(&self, [along, across]: [f32; 2]) -> [f32; 2] {
        let ([c, s], across) = (self.along, self.side * across);
        [c * along - s * across, s * along + c * across]
    }

    /// A vector along and across, from one of field axes.
    pub fn back(&self, [x, y]: [f32; 2]) -> [f32; 2] {
        let [c, s] = self.along;
        [c * x + s * y, self.side * (c * y - s * x)]
    }
}
