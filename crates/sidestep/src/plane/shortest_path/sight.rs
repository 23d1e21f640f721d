//! Which corners may be seen from a point: a walk over rows of open cells with a fan of rays.
//!
//! The fan that leaves a row through an open run of cells enters the next row, where blocked cells
//! split it into narrower fans; this is how Anya (D. Harabor, A. Grastien, D. Oez and V. Aksakalli,
//! Optimal any-angle pathfinding in practice, JAIR 2016, doi:10.1613/jair.5007) projects intervals.
//! Corners in the swept cells are candidates: every corner in sight is among them, and the
//! certificate decides about each.

use std::f64::consts::{PI, TAU};

use super::corners::Corner;
use super::raster::{Raster, runs};
use crate::plane::certificate::Certifier;
use crate::plane::geometry::Point;

/// Open runs of cells row by row, and the corners in each row from left to right.
#[derive(Debug, Clone)]
pub(crate) struct Sight {
    raster: Raster,
    /// Open columns `begin..end`, by row, ascending.
    runs: Vec<(u32, u32)>,
    /// Where each row's runs begin; one more than there are rows.
    row_runs: Vec<u32>,
    /// Connected part of the open cells that each run belongs to.
    parts: Vec<u32>,
    /// Column coordinates of the corners, in the corners' order.
    columns: Vec<f64>,
    /// Where each row's corners begin.
    row_corners: Vec<u32>,
    /// Rounding slack, in cells: half the certificate's tolerance.
    hair: f64,
}

/// Corners that are not the map's, where the walk over the map meets them: row and column of each, ascending.
#[derive(Debug, Clone, Default)]
pub(crate) struct MoreCorners {
    places: Vec<(usize, f64)>,
    /// The number of the first one.
    first: usize,
}

impl MoreCorners {
    /// Visits those of a row between two columns.
    fn visit_row(&self, row: usize, left: f64, right: f64, visit: &mut impl FnMut(usize)) {
        let outside = |&(first, _): &(usize, f64)| row < first;
        if self.places.first().is_none_or(outside) || self.places.last().is_some_and(|l| l.0 < row)
        {
            return;
        }
        let begin = self.places.partition_point(|&place| place < (row, left));
        let seen = |&&place: &&(usize, f64)| place <= (row, right);
        let count = self.places[begin..].iter().take_while(seen).count();
        (self.first + begin..self.first + begin + count).for_each(visit);
    }
}

/// Fans still to be followed.
pub(crate) type Stack = Vec<Fan>;

/// The rays from the viewpoint that enter a row, by their change of column per row, away from the viewpoint.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Fan {
    row: usize,
    up: bool,
    left: f64,
    right: f64,
}

impl Sight {
    /// Prepares the walk and sorts the corners by row and column. None once `go_on` is false.
    pub(crate) fn new(
        certifier: &Certifier,
        corners: &mut [Corner],
        go_on: &dyn Fn() -> bool,
    ) -> Option<Self> {
        let raster = Raster::new(certifier, go_on)?;
        let height = raster.height();
        let row_of = |corner: &Corner| Raster::index(raster.local(corner.at)[1], height);
        corners.sort_by(|a, b| row_of(a).cmp(&row_of(b)).then(a.at[0].total_cmp(&b.at[0])));
        let mut row_corners = vec![0; height + 1];
        for corner in corners.iter() {
            row_corners[row_of(corner) + 1] += 1;
        }
        for row in 0..height {
            row_corners[row + 1] += row_corners[row];
        }
        let columns = corners.iter().map(|corner| raster.local(corner.at)[0]).collect();
        let hair = 0.5 * certifier.tolerance() / raster.resolution;
        let (runs, row_runs, parts) = Default::default();
        let sight = Self { raster, runs, row_runs, parts, columns, row_corners, hair };
        Some(sight.with_runs())
    }

    /// With the open runs of the raster and their parts.
    fn with_runs(mut self) -> Self {
        self.runs.clear();
        self.row_runs.clear();
        self.row_runs.push(0);
        for row in 0..self.raster.height() {
            let open = runs(self.raster.blocked.row(row), self.raster.width(), 0);
            self.runs.extend(open.map(|(begin, end)| (begin as u32, end as u32)));
            self.row_runs.push(self.runs.len() as u32);
        }
        self.parts = connect(&self.runs, &self.row_runs);
        self
    }

    /// Whether the certifier's obstacles from number `known` on leave the open cells of two points unconnected.
    pub(crate) fn is_cut(&self, certifier: &Certifier, known: usize, ends: [Point; 2]) -> bool {
        let (columns, row_corners) = Default::default();
        let (raster, runs, row_runs) = (self.raster.clone(), Vec::new(), Vec::new());
        let mut cut = Self {
            raster,
            runs,
            row_runs,
            parts: Vec::new(),
            columns,
            row_corners,
            hair: self.hair,
        };
        for obstacle in &certifier.obstacles()[known..] {
            cut.raster.block_near(obstacle, certifier);
        }
        let cut = cut.with_runs();
        let [from, to] = ends.map(|end| cut.part(end));
        from.is_some() && to.is_some() && from != to
    }

    /// Corners beside those that the walk was prepared for, which get their order.
    pub(crate) fn more(&self, corners: &mut [Corner]) -> MoreCorners {
        let place = |corner: &Corner| {
            let [x, y] = self.raster.local(corner.at);
            (Raster::index(y, self.raster.height()), x)
        };
        let order = |a: (usize, f64), b: (usize, f64)| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1));
        corners.sort_by(|a, b| order(place(a), place(b)));
        MoreCorners { places: corners.iter().map(place).collect(), first: self.columns.len() }
    }

    /// Calls `visit` with every corner that may be seen from `at`, some of them twice; with a `cone`
    /// (first angle, counter-clockwise sweep), with at least those that may be seen in it.
    pub(crate) fn visit(
        &self,
        stack: &mut Stack,
        more: &MoreCorners,
        at: Point,
        cone: Option<(f64, f64)>,
        visit: &mut impl FnMut(usize),
    ) {
        let [x, y] = self.raster.local(at);
        let height = self.raster.height();
        let upward = cone.map_or(Some(EVERYWHERE), |(from, sweep)| slopes(from, sweep));
        let downward = cone.map_or(Some(EVERYWHERE), |(from, sweep)| slopes(-from - sweep, sweep));
        stack.clear();
        let (lowest, highest) =
            (Raster::index(y - self.hair, height), Raster::index(y + self.hair, height));
        for row in lowest..=highest {
            for run in self.runs_near(row, x, x) {
                let (begin, end) = self.ends(run);
                self.visit_row(row, begin, end, visit);
                more.visit_row(row, begin, end, visit);
                for (up, slopes, to_line) in
                    [(true, upward, (row + 1) as f64 - y), (false, downward, y - row as f64)]
                {
                    let Some((left, right)) = slopes else { continue };
                    let rows = to_line.max(1e-12);
                    let fan = Fan {
                        row,
                        up,
                        left: left.max((begin - x) / rows),
                        right: right.min((end - x) / rows),
                    };
                    self.push_next(stack, fan);
                }
            }
        }
        while let Some(fan) = stack.pop() {
            let (enter, leave) = if fan.up {
                (fan.row as f64 - y, (fan.row + 1) as f64 - y)
            } else {
                (y - (fan.row + 1) as f64, y - fan.row as f64)
            };
            let (enter, leave) = (enter.max(1e-12), leave.max(1e-12));
            for run in self.runs_near(fan.row, x + fan.left * enter, x + fan.right * enter) {
                let (begin, end) = self.ends(run);
                let left = fan.left.max((begin - x) / enter);
                let right = fan.right.min((end - x) / enter);
                if left > right {
                    continue;
                }
                let least = x + (left * enter).min(left * leave);
                let most = x + (right * enter).max(right * leave);
                let (least, most) = (least.max(begin), most.min(end));
                self.visit_row(fan.row, least, most, visit);
                more.visit_row(fan.row, least, most, visit);
                self.push_next(
                    stack,
                    Fan {
                        left: left.max((begin - x) / leave),
                        right: right.min((end - x) / leave),
                        ..fan
                    },
                );
            }
        }
    }

    /// The connected part of the open cells that holds a point; none where its cell is blocked.
    pub(crate) fn part(&self, at: Point) -> Option<u32> {
        let [x, y] = self.raster.local(at);
        let row = Raster::index(y, self.raster.height());
        let column = Raster::index(x, self.raster.width()) as u32;
        let range = self.row_runs[row] as usize..self.row_runs[row + 1] as usize;
        let run = range.clone().find(|&run| column < self.runs[run].1)?;
        (self.runs[run].0 <= column).then(|| self.parts[run])
    }

    /// Follows a fan into the next row, if there is one and rays are left.
    fn push_next(&self, stack: &mut Stack, fan: Fan) {
        let last = if fan.up { fan.row + 1 == self.raster.height() } else { fan.row == 0 };
        if !last && fan.left <= fan.right {
            let row = if fan.up { fan.row + 1 } else { fan.row - 1 };
            stack.push(Fan { row, ..fan });
        }
    }

    /// A run's ends, wider by the slack.
    fn ends(&self, run: usize) -> (f64, f64) {
        let (begin, end) = self.runs[run];
        (f64::from(begin) - self.hair, f64::from(end) + self.hair)
    }

    /// The runs of a row that meet columns `left..=right`.
    fn runs_near(&self, row: usize, left: f64, right: f64) -> std::ops::Range<usize> {
        let range = self.row_runs[row] as usize..self.row_runs[row + 1] as usize;
        let runs = &self.runs[range.clone()];
        let first = runs.partition_point(|run| f64::from(run.1) + self.hair < left);
        let count = runs[first..].partition_point(|run| f64::from(run.0) - self.hair <= right);
        range.start + first..range.start + first + count
    }

    /// Visits the corners of a row between two columns.
    fn visit_row(&self, row: usize, left: f64, right: f64, visit: &mut impl FnMut(usize)) {
        let range = self.row_corners[row] as usize..self.row_corners[row + 1] as usize;
        let columns = &self.columns[range.clone()];
        let first = columns.partition_point(|&column| column < left);
        let visible = columns[first..].iter().take_while(|&&column| column <= right).count();
        (range.start + first..range.start + first + visible).for_each(visit);
    }
}

/// All slopes.
const EVERYWHERE: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

/// The part of a cone that points upward, as a range of columns per row: the cotangents.
fn slopes(from: f64, sweep: f64) -> Option<(f64, f64)> {
    let from = from.rem_euclid(TAU);
    // The upper half plane begins at 0 and, once round, again.
    [0.0, TAU].into_iter().find_map(|zero| {
        let (low, high) = ((from - zero).max(0.0), (from + sweep - zero).min(PI));
        let cotangent = |angle: f64| angle.cos() / angle.sin();
        let right = if low <= 0.0 { f64::INFINITY } else { cotangent(low) };
        let left = if high >= PI { f64::NEG_INFINITY } else { cotangent(high) };
        (low < high).then_some((left, right))
    })
}

/// Numbers the connected parts: runs of neighbouring rows connect where they share a column.
fn connect(runs: &[(u32, u32)], row_runs: &[u32]) -> Vec<u32> {
    let mut parent: Vec<u32> = (0..runs.len() as u32).collect();
    fn root(parent: &mut [u32], mut run: u32) -> u32 {
        while parent[run as usize] != run {
            parent[run as usize] = parent[parent[run as usize] as usize];
            run = parent[run as usize];
        }
        run
    }
    for rows in row_runs.windows(3) {
        let (mut lower, mut upper) = (rows[0] as usize, rows[1] as usize);
        while lower < rows[1] as usize && upper < rows[2] as usize {
            if runs[lower].0 < runs[upper].1 && runs[upper].0 < runs[lower].1 {
                let (a, b) = (root(&mut parent, lower as u32), root(&mut parent, upper as u32));
                parent[a.max(b) as usize] = a.min(b);
            }
            if runs[lower].1 <= runs[upper].1 { lower += 1 } else { upper += 1 }
        }
    }
    (0..runs.len() as u32).map(|run| root(&mut parent, run)).collect()
}
