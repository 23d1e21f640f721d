//! The outline of a grid's occupied cells as rings, so that a map is drawn sharp at any size and
//! without seams between its cells.

use sidestep::Grid;

/// A corner between cells: column and row, counted from the lower left corner of the grid.
type Corner = (u32, u32);

/// The border rings, which the even-odd rule fills with the occupied cells.
///
/// Every cell side between occupied and free is an edge with the occupied cell on its left. Where two
/// cells touch only at a corner, turning left keeps their rings apart.
pub(super) fn rings(grid: &Grid) -> Vec<Vec<Corner>> {
    let (width, height) = (grid.width() as i64, grid.height() as i64);
    let occupied = |column: i64, row: i64| grid.is_occupied(column, row);
    // One bit per direction of an edge that leaves the corner: 0 right, 1 up, 2 left, 3 down.
    let columns = grid.width() + 1;
    let mut edges = vec![0_u8; columns * (grid.height() + 1)];
    let index = |x: i64, y: i64| y as usize * columns + x as usize;
    for y in 0..=height {
        for x in 0..=width {
            let (below_left, below_right) = (occupied(x - 1, y - 1), occupied(x, y - 1));
            let (above_left, above_right) = (occupied(x - 1, y), occupied(x, y));
            let right = above_right && !below_right;
            let up = above_left && !above_right;
            let left = below_left && !above_left;
            let down = below_right && !below_left;
            let bits = [right, up, left, down].into_iter().enumerate();
            edges[index(x, y)] = bits.map(|(bit, there)| u8::from(there) << bit).sum();
        }
    }
    const STEPS: [(i64, i64); 4] = [(1, 0), (0, 1), (-1, 0), (0, -1)];
    let mut rings = Vec::new();
    for start_y in 0..=height {
        for start_x in 0..=width {
            while edges[index(start_x, start_y)] != 0 {
                let mut ring = Vec::new();
                let (mut x, mut y) = (start_x, start_y);
                let mut heading = None;
                loop {
                    let here = &mut edges[index(x, y)];
                    // After an edge: left first, then straight on, then right.
                    let turns = heading.map_or([0, 1, 2, 3], |h: usize| {
                        [(h + 1) % 4, h, (h + 3) % 4, (h + 2) % 4]
                    });
                    let Some(next) = turns.into_iter().find(|&turn| *here >> turn & 1 == 1) else {
                        break;
                    };
                    *here &= !(1 << next);
                    if heading != Some(next) {
                        ring.push((x as u32, y as u32));
                    }
                    heading = Some(next);
                    (x, y) = (x + STEPS[next].0, y + STEPS[next].1);
                }
                rings.push(ring);
            }
        }
    }
    rings
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rings_of(rows: &[&str]) -> Vec<Vec<Corner>> {
        let cells = rows.iter().rev().flat_map(|row| row.bytes().map(|b| b == b'#')).collect();
        rings(&Grid::new(rows[0].len(), rows.len(), 1.0, [0.0, 0.0], cells).unwrap())
    }

    #[test]
    fn shapes_and_holes() {
        assert_eq!(rings_of(&["..", ".."]), Vec::<Vec<Corner>>::new());
        assert_eq!(rings_of(&["##", "##"]), [vec![(0, 0), (2, 0), (2, 2), (0, 2)]]);
        let ring = rings_of(&["###", "#.#", "###"]);
        assert_eq!(ring.len(), 2);
        assert_eq!(ring[0], [(0, 0), (3, 0), (3, 3), (0, 3)]);
        assert_eq!(ring[1].len(), 4);
        // Two cells that touch at a corner stay two rings.
        assert_eq!(rings_of(&["#.", ".#"]).len(), 2);
    }

    /// The even-odd rule on the rings gives back every cell.
    #[test]
    fn fills_exactly_the_occupied_cells() {
        let (width, height) = (23, 17);
        let cells: Vec<bool> = (0..width * height).map(|i| (i * i + i / 7) % 5 < 2).collect();
        let grid = Grid::new(width, height, 1.0, [0.0, 0.0], cells).unwrap();
        let rings = rings(&grid);
        for row in 0..height as i64 {
            for column in 0..width as i64 {
                // Vertical edges to the right of the cell's centre, on its row.
                let crossings = rings.iter().map(|ring| {
                    let ends = ring.iter().zip(ring.iter().cycle().skip(1));
                    ends.filter(|(a, b)| {
                        let (low, high) = (a.1.min(b.1), a.1.max(b.1));
                        let spans = i64::from(low) <= row && row < i64::from(high);
                        a.0 == b.0 && spans && i64::from(a.0) > column
                    })
                    .count()
                });
                let inside = crossings.sum::<usize>() % 2 == 1;
                assert_eq!(inside, grid.is_occupied(column, row), "{column} {row}");
            }
        }
    }
}
