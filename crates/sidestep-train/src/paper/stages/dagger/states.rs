//! The aggregated data of DAgger: where the policy has been, and what the expert would have done
//! there.
//!
//! A state is kept as its task, waypoints and what the encoder remembered, and is observed anew for
//! each minibatch: 160 bytes in place of the 16 kB of an image. That is also what a checkpoint
//! holds.

use rayon::prelude::*;

use crate::environments::Problem;
use crate::paper::stages::cloning::Samples;

/// States with the expert's answers, oldest first; each list has one row per state.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct States {
    /// Index of the task in the training set.
    pub tasks: Vec<u32>,
    /// The waypoints, `[states x dim]`.
    pub waypoints: Vec<f32>,
    /// What the encoder remembered before it saw them, `[states x memory]`.
    pub memories: Vec<f32>,
    /// The expert's answers, `[states x dim]`.
    pub answers: Vec<f32>,
}

impl States {
    /// How many.
    pub fn len(&self) -> usize {
        self.tasks.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.tasks.is_empty()
    }

    /// Adds one state.
    pub fn push(&mut self, task: usize, waypoints: &[f32], memory: &[f32], answer: &[f32]) {
        self.tasks.push(task as u32);
        self.waypoints.extend_from_slice(waypoints);
        self.memories.extend_from_slice(memory);
        self.answers.extend_from_slice(answer);
    }

    /// Adds all of `other`, then drops the oldest beyond `capacity`.
    pub fn append(&mut self, mut other: Self, capacity: usize) {
        self.tasks.append(&mut other.tasks);
        self.waypoints.append(&mut other.waypoints);
        self.memories.append(&mut other.memories);
        self.answers.append(&mut other.answers);
        let (count, excess) = (self.len(), self.len().saturating_sub(capacity));
        if excess > 0 {
            for values in [&mut self.waypoints, &mut self.memories, &mut self.answers] {
                values.drain(..excess * (values.len() / count));
            }
            self.tasks.drain(..excess);
        }
    }

    /// Observations and answers of the states `rows`, in that order.
    pub fn observe(&self, rows: &[u32], problems: &[Problem]) -> Samples {
        let count = self.len().max(1);
        let (dim, memory) = (self.waypoints.len() / count, self.memories.len() / count);
        let Some(first) = problems.first() else { return Samples::default() };
        let wide = first.encoder.len(&first.objective);
        let mut samples = Samples {
            observations: vec![0.0; rows.len() * wide],
            targets: Vec::with_capacity(rows.len() * dim),
        };
        let observe = |(observation, &row): (&mut [f32], &u32)| {
            let row = row as usize;
            let mut problem = problems[self.tasks[row] as usize].clone();
            let mut gradient = vec![0.0; dim];
            problem.encoder.restore(&self.memories[row * memory..][..memory]);
            let x = &self.waypoints[row * dim..][..dim];
            problem.observe(x, &mut gradient, observation);
        };
        samples.observations.par_chunks_mut(wide).zip(rows).for_each(observe);
        for &row in rows {
            samples.targets.extend_from_slice(&self.answers[row as usize * dim..][..dim]);
        }
        samples
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sidestep::policy::observation::ObservationPart;
    use sidestep::profile::Profile;
    use sidestep::suite::Suite;

    #[test]
    fn the_oldest_are_dropped() {
        let mut states = States::default();
        for round in 0..3 {
            let mut fresh = States::default();
            for state in 0..4 {
                let number = (4 * round + state) as f32;
                fresh.push(4 * round + state, &[number; 2], &[number; 3], &[-number; 2]);
            }
            states.append(fresh, 6);
        }
        assert_eq!(states.tasks, [6, 7, 8, 9, 10, 11]);
        assert_eq!((states.waypoints[0], states.waypoints.len()), (6.0, 12));
        assert_eq!((states.memories[0], states.memories.len()), (6.0, 18));
        assert_eq!((states.answers[11], states.answers.len()), (-11.0, 12));
    }

    #[test]
    fn a_stored_state_is_observed_as_it_was() {
        let parts = [ObservationPart::Gradient, ObservationPart::PreviousGradients { count: 2 }];
        let tasks = Suite::Hard.generate(2, 1000, &Profile::PAPER);
        let problems: Vec<Problem> = tasks
            .iter()
            .map(|task| Problem::new(task, &Profile::PAPER, 10, &parts).unwrap())
            .collect();
        let (mut states, mut seen) = (States::default(), Vec::new());
        for (index, problem) in problems.iter().enumerate() {
            let mut problem = problem.clone();
            let (mut x, mut gradient) = (vec![0.0; 20], vec![0.0; 20]);
            problem.objective.straight_line(&mut x);
            for _ in 0..4 {
                let memory = problem.encoder.memory().to_vec();
                let mut observation = vec![0.0; 60];
                problem.observe(&x, &mut gradient, &mut observation);
                states.push(index, &x, &memory, &gradient);
                seen.push(observation);
                x.iter_mut().zip(&gradient).for_each(|(x, g)| *x -= 0.5 * g);
            }
        }
        let samples = states.observe(&[6, 1, 3], &problems);
        assert_eq!(samples.observations, [&seen[6][..], &seen[1], &seen[3]].concat());
        assert_eq!(samples.targets[20..40], states.answers[20..40]);
    }
}
