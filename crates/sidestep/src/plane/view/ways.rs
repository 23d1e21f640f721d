//! The shortest ways of a task round its obstacles, on a square of points: what a map shows of them.
//!
//! The points cover the field; in the paper's they are the middles of its pixels. Distances d from both ends come from
//! [`super::sweeps`]. A point on a shortest way has the least sum of the two; what the sum is beyond that is the detour of a way
//! through the point.

use super::bilinear::bilinear;
use super::sweeps::{SIDE, Sweeps};
use crate::plane::Subject;
use crate::plane::distance::LANES;
use crate::profile::NORMALISED_EXTENT;
use crate::trajectory::waypoints::polyline;

/// Numbers that say what the ways are at a place: the detour, and how far along from start (-1) to goal (1) it is.
pub(super) const WAYS: usize = 2;
/// A detour of this, in normalised units, counts half of the most.
const DETOUR: f32 = 1.0;

/// The ways of one task.
#[derive(Debug, Clone)]
pub(super) struct Ways {
    /// The first point.
    first: [f32; 2],
    /// From one point to the next.
    step: f32,
    /// What [`Ways::read`] returns between the points, `[SIDE x SIDE]`.
    values: Vec<[f32; WAYS]>,
    /// The shortest way, as N waypoints evenly spaced.
    route: Vec<[f32; 2]>,
    longer: f32,
}

impl Ways {
    /// The ways of the subject's task.
    pub fn new(subject: Subject<'_>) -> Self {
        let (start, goal) = (subject.start, subject.goal);
        let length = (goal[0] - start[0]).hypot(goal[1] - start[1]);
        let scene = subject.scene;
        let bounds = scene.certifier().bounds();
        let [min, max] = [bounds.min, bounds.max].map(|p| scene.frame().to_normalised(p));
        let width = NORMALISED_EXTENT as f32;
        let step = width / SIDE as f32;
        let first = [0, 1].map(|a| 0.5 * (min[a] + max[a]) - 0.5 * (width - step));
        let mut x = [0.0; SIDE * SIDE];
        let mut y = [0.0; SIDE * SIDE];
        let rows = x.chunks_exact_mut(SIDE).zip(y.chunks_exact_mut(SIDE));
        for (row, (x, y)) in rows.enumerate() {
            y.fill(first[1] + row as f32 * step);
            x.iter_mut().enumerate().for_each(|(i, x)| *x = first[0] + i as f32 * step);
        }
        let mut distance = [0.0; SIDE * SIDE];
        const { assert!((SIDE * SIDE).is_multiple_of(LANES)) };
        scene.exact_field().probe_all(&x, &y, &mut distance);
        let place = |p: [f32; 2]| [0, 1].map(|a| (p[a] - first[a]) / step);
        let sweeps = Sweeps::new(&distance, step, [place(start), place(goal)]);
        let [mut detours, mut places] = [[0.0; SIDE * SIDE]; WAYS];
        let rows = detours.chunks_exact_mut(SIDE).zip(places.chunks_exact_mut(SIDE));
        let mut least = [f32::INFINITY; SIDE];
        for (row, (sums, places)) in rows.enumerate() {
            let [from, to] = sweeps.row(row);
            for i in 0..SIDE {
                sums[i] = from[i] + to[i];
                places[i] = (from[i] - to[i]) / sums[i].max(1.0);
                least[i] = least[i].min(sums[i]);
            }
        }
        let shortest = least.into_iter().fold(f32::INFINITY, f32::min);
        for detour in &mut detours {
            let beyond = (*detour - shortest) * step;
            *detour = 2.0 * beyond / (beyond + DETOUR);
        }
        let mut route = vec![[0.0; 2]; subject.waypoints];
        let points = descend(&sweeps, [place(start), place(goal)]);
        let inner = points.iter().map(|p| [0, 1].map(|a| first[a] + p[a] as f32 * step));
        let corners: Vec<[f32; 2]> = [start].into_iter().chain(inner).chain([goal]).collect();
        polyline(2, corners.as_flattened(), route.as_flattened_mut());
        Self {
            first,
            step,
            values: detours
                .into_iter()
                .zip(places)
                .map(|(detour, place)| [detour, place])
                .collect(),
            route,
            longer: (shortest * step / length.max(step) - 1.0).clamp(0.0, 3.0),
        }
    }

    /// Detour and place along at `p`, the latter from goal to start where it is read backwards; bilinear between the points.
    pub fn read(&self, p: [f32; 2], backwards: bool) -> [f32; WAYS] {
        let place = [(p[0] - self.first[0]) / self.step, (p[1] - self.first[1]) / self.step];
        let mut out = [0.0; WAYS];
        for (point, weight) in bilinear(place, SIDE) {
            out.iter_mut().zip(self.values[point]).for_each(|(out, way)| *out += weight * way);
        }
        if backwards {
            out[1] = -out[1];
        }
        out
    }

    /// The shortest way, as N waypoints evenly spaced.
    pub fn route(&self) -> &[[f32; 2]] {
        &self.route
    }

    /// Length of the shortest way over the straight line's, less 1, at most 3.
    pub fn longer(&self) -> f32 {
        self.longer
    }
}

/// The points of a shortest way between the ends (column, row), these left out.
fn descend(sweeps: &Sweeps, ends: [[f32; 2]; 2]) -> Vec<[usize; 2]> {
    let last = (SIDE - 1) as f32;
    let [mut at, goal] = ends.map(|end| end.map(|v| v.round().clamp(0.0, last) as usize));
    let mut points = Vec::new();
    // The distance falls with every step, so no point comes twice.
    while at != goal {
        let weight = sweeps.weight(at[0], at[1]);
        let (mut least, mut next) = (f32::INFINITY, goal);
        for row in at[1].saturating_sub(1)..=(at[1] + 1).min(SIDE - 1) {
            for column in at[0].saturating_sub(1)..=(at[0] + 1).min(SIDE - 1) {
                let straight = column == at[0] || row == at[1];
                let length = if straight { 1.0 } else { std::f32::consts::SQRT_2 };
                let way = sweeps.get(column, row)[1] + length * weight;
                if [column, row] != at && way < least {
                    (least, next) = (way, [column, row]);
                }
            }
        }
        if sweeps.get(next[0], next[1])[1] >= sweeps.get(at[0], at[1])[1] {
            break;
        }
        at = next;
        if at != goal {
            points.push(at);
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::objective::Objective;
    use crate::plane::shortest_path::Route;
    use crate::profile::Profile;
    use crate::scene::Query;
    use crate::suite::Suite;

    #[test]
    fn ways_are_as_long_as_the_shortest_path() {
        let (mut solvable, mut wrong) = (0, 0);
        for task in Suite::HardTraining.generate(150, 1000, &Profile::PAPER) {
            let query = Query::of(&task, &Profile::DEFAULT);
            let path = query.scene().exact(query.start(), query.goal(), &|| true);
            let Some(Route::Found { length, .. }) = path else { continue };
            let objective = Objective::new(&query, 200).unwrap();
            let ways = Ways::new(objective.plane().unwrap());
            let points: Vec<f32> = ways.route().iter().flatten().copied().collect();
            let way = objective.trajectory(&points).length();
            solvable += 1;
            // Of eight directions, and round what is a pixel wide or wider.
            wrong += usize::from(!(0.97 * length..1.3 * length + 2.0).contains(&way));
            // The way itself is no detour and runs from the start's end to the goal's.
            for i in [50, 100, 150] {
                let [detour, along] = ways.read(ways.route()[i], false);
                assert!(detour < 0.7 && along.abs() <= 1.0, "{detour} {along}");
            }
            let places = [20, 100, 180].map(|i| ways.read(ways.route()[i], false)[1]);
            assert!(places.is_sorted(), "{places:?}");
        }
        assert!(wrong * 50 <= solvable, "{wrong} of {solvable}");
    }
}
