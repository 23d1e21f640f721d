//! L-BFGS (Liu & Nocedal 1989, doi:10.1007/BF01589116) with Moré-Thuente line search.
//!
//! ```text
//! d = -H g    H from the last m pairs s = x' - x, y = g' - g by two loops (Nocedal 1980),
//!             beginning at γ = s·y / y·y of the newest pair
//! ```
//!
//! Vectors are f64 and U is f32. U has kinks where the nearest obstacle changes, and the line search
//! can search there for ever. It is cut off after [`MAX_EVALUATIONS`]; the method then goes on from
//! the best point seen, with an empty memory, and stays where it is once no point seen was better.
//! An iteration allocates only while the memory still grows.

mod line_search;
#[cfg(test)]
mod tests;

use std::collections::VecDeque;

use crate::objective::Objective;

/// Evaluations of U, and of its gradient, that one iteration may take.
const MAX_EVALUATIONS: usize = 40;

#[derive(Debug)]
pub(super) struct Lbfgs {
    memory: usize,
    /// Whether `x`, `cost` and `gradient` are those of the last iteration, to go on from.
    running: bool,
    /// No better point was found from here.
    stuck: bool,
    x: Vec<f64>,
    cost: f64,
    gradient: Vec<f64>,
    direction: Vec<f64>,
    /// Oldest first.
    pairs: VecDeque<Pair>,
    seen: Seen,
}

/// Two successive iterates: s = x' - x and y = g' - g.
#[derive(Debug)]
struct Pair {
    s: Vec<f64>,
    y: Vec<f64>,
    /// s · y
    sy: f64,
    /// y · y
    yy: f64,
    /// What the first loop leaves for the second.
    alpha: f64,
}

/// What the current iteration has seen of U: the last point, and the best one.
#[derive(Debug)]
struct Seen {
    evaluations: usize,
    x: Vec<f64>,
    rounded: Vec<f32>,
    gradient: Vec<f32>,
    best: Vec<f32>,
    best_cost: f32,
}

impl Lbfgs {
    pub fn new(memory: usize, n: usize) -> Self {
        Self {
            memory,
            running: false,
            stuck: false,
            x: vec![0.0; n],
            cost: 0.0,
            gradient: vec![0.0; n],
            direction: vec![0.0; n],
            pairs: VecDeque::new(),
            seen: Seen {
                evaluations: 0,
                x: vec![0.0; n],
                rounded: vec![0.0; n],
                gradient: vec![0.0; n],
                best: vec![0.0; n],
                best_cost: f32::INFINITY,
            },
        }
    }

    pub fn step(&mut self, x: &mut [f32], objective: &mut Objective) {
        if self.stuck {
            return;
        }
        self.seen.evaluations = 0;
        self.seen.best_cost = f32::INFINITY;
        self.running = self.iterate(x, objective).is_some();
        if self.running {
            x.iter_mut().zip(&self.x).for_each(|(x, &v)| *x = v as f32);
        } else if self.seen.best_cost < objective.cost(x).total {
            x.copy_from_slice(&self.seen.best);
        } else {
            self.stuck = true;
        }
    }

    /// One iteration, begun afresh at `x` where none is running; nothing where it fails.
    fn iterate(&mut self, x: &[f32], objective: &mut Objective) -> Option<()> {
        if !self.running {
            self.pairs.clear();
            self.seen.x.iter_mut().zip(x).for_each(|(seen, &v)| *seen = f64::from(v));
            self.cost = self.seen.evaluate(objective)?;
            self.take_gradient();
            self.x.copy_from_slice(&self.seen.x);
        }
        self.point_downhill();
        if self.cost.is_infinite() {
            self.seen.x.copy_from_slice(&self.x);
            self.cost = self.seen.cost_again(objective)?;
        }
        let Self { x, direction, seen, .. } = self;
        let slope = dot(&self.gradient, direction);
        let cost = line_search::search(self.cost, slope, |step| {
            for ((seen, x), d) in seen.x.iter_mut().zip(&*x).zip(&*direction) {
                *seen = x + d * step;
            }
            let cost = seen.evaluate(objective)?;
            let slope = direction.iter().zip(&seen.gradient).map(|(d, &g)| d * f64::from(g)).sum();
            Some([cost, slope])
        })?;
        self.seen.count(1)?;
        self.remember();
        self.cost = cost;
        self.take_gradient();
        self.x.copy_from_slice(&self.seen.x);
        self.x.iter().all(|v| v.is_finite()).then_some(())
    }

    /// d = -H g.
    fn point_downhill(&mut self) {
        let d = &mut self.direction;
        d.copy_from_slice(&self.gradient);
        for pair in self.pairs.iter_mut().rev() {
            pair.alpha = dot(&pair.s, d) * (1.0 / pair.sy);
            d.iter_mut().zip(&pair.y).for_each(|(d, y)| *d -= y * pair.alpha);
        }
        let gamma = self.pairs.back().map_or(1.0, |newest| newest.sy / newest.yy);
        d.iter_mut().for_each(|d| *d *= gamma);
        for pair in &self.pairs {
            let beta = dot(&pair.y, d) * (1.0 / pair.sy);
            d.iter_mut().zip(&pair.s).for_each(|(d, s)| *d += s * (pair.alpha - beta));
        }
        d.iter_mut().for_each(|d| *d *= -1.0);
    }

    /// The pair from the last iterate to the point seen last, in the place of the oldest where the
    /// memory is full.
    fn remember(&mut self) {
        let n = self.x.len();
        let mut pair = if self.pairs.len() < self.memory { None } else { self.pairs.pop_front() }
            .unwrap_or_else(|| Pair {
                s: vec![0.0; n],
                y: vec![0.0; n],
                sy: 0.0,
                yy: 0.0,
                alpha: 0.0,
            });
        for i in 0..n {
            pair.s[i] = self.seen.x[i] - self.x[i];
            pair.y[i] = f64::from(self.seen.gradient[i]) - self.gradient[i];
        }
        pair.sy = dot(&pair.s, &pair.y);
        pair.yy = dot(&pair.y, &pair.y);
        self.pairs.push_back(pair);
    }

    fn take_gradient(&mut self) {
        let seen = &self.seen.gradient;
        self.gradient.iter_mut().zip(seen).for_each(|(to, &from)| *to = f64::from(from));
    }
}

impl Seen {
    /// U and its gradient at `self.x`; nothing past the limit.
    fn evaluate(&mut self, objective: &mut Objective) -> Option<f64> {
        if self.evaluations + 1 == MAX_EVALUATIONS {
            self.cost_again(objective)?;
        }
        self.count(2)?;
        self.round();
        let cost = objective.cost_and_gradient(&self.rounded, &mut self.gradient).total;
        Some(self.compare(cost))
    }

    /// U alone at `self.x`.
    fn cost_again(&mut self, objective: &mut Objective) -> Option<f64> {
        self.count(1)?;
        self.round();
        let cost = objective.cost(&self.rounded).total;
        Some(self.compare(cost))
    }

    fn count(&mut self, evaluations: usize) -> Option<()> {
        self.evaluations += evaluations;
        (self.evaluations <= MAX_EVALUATIONS).then_some(())
    }

    fn round(&mut self) {
        self.rounded.iter_mut().zip(&self.x).for_each(|(rounded, &v)| *rounded = v as f32);
    }

    fn compare(&mut self, cost: f32) -> f64 {
        if cost < self.best_cost {
            self.best_cost = cost;
            self.best.copy_from_slice(&self.rounded);
        }
        f64::from(cost)
    }
}

/// Summed in order, so that the bits do not depend on the instruction set.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
