//! Distance images: a distance transform on a regular raster, read by interpolation.
//!
//! The paper's image holds Sobel gradients beside the distances and reads both bilinearly, so its
//! gradient is not the derivative of its distance. A grid's image is read by Catmull-Rom bicubic
//! interpolation (Keys 1981, doi:10.1109/TASSP.1981.1163711), which is C1, with the exact
//! derivative of the interpolant; bilinear interpolation is there to compare.
//! Outside the raster, coordinates are clamped to the outermost texel centres.

use super::transform::{signed_distance_transform, squared_distance_transform};
use super::{LANES, Samples};
use crate::plane::frame::Frame;
use crate::plane::world::{Grid, World};

/// How an image is read between texel centres.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Interpolation {
    /// Bilinear in distance and in the stored (Sobel) gradients: the paper's way.
    BilinearSobel,
    /// Bilinear in distance, with the derivative of the interpolant.
    Bilinear,
    /// Catmull-Rom bicubic in distance, with the derivative of the interpolant.
    Bicubic,
}

/// A raster of signed distances in normalised units.
#[derive(Debug, Clone)]
pub struct ImageField {
    width: usize,
    height: usize,
    /// Texels from one row to the next: the width, and one more for the paper's, which repeats the last column.
    stride: usize,
    /// A grid's distances, `[height x width]`; row 0 at the bottom.
    distances: Vec<f32>,
    /// The paper's, `[height + 1 x stride]` of `[distance, gradient x, gradient y, 0]`; the last
    /// row repeated, so that a texel always has one to the right and one above.
    texels: Vec<[f32; 4]>,
    /// Normalised position of the lower left texel's centre.
    origin: [f32; 2],
    /// Texels per normalised unit.
    density: f32,
    interpolation: Interpolation,
}

/// Pixels along the larger side of the field in the paper's image.
const PAPER_PIXELS: f64 = 64.0;

impl ImageField {
    /// The paper's distance image of a world: pixel (i, j) is the cell `[i, i+1] x [j, j+1]` of a
    /// field 64 cells wide, occupied if its centre lies in an obstacle; a one-pixel frame of
    /// obstacle surrounds it. The image is read at x / 0.1 - 0.5 of the half-pixel-shifted frame.
    pub fn paper(world: &World, frame: &Frame) -> Self {
        let bounds = world.bounds();
        let pixel = bounds.extent() / PAPER_PIXELS;
        let [width, height] = bounds.size().map(|side| (side / pixel).ceil().max(1.0) as usize);
        let occupied = rasterise(world, width, height, pixel);
        let unit = pixel / frame.scale;
        let signed = signed_transform(&occupied, width + 2, height + 2, unit);
        let texels = sobel_texels(width, height, unit, &signed);
        let center = unit * 0.5;
        Self {
            width,
            height,
            stride: width + 1,
            distances: Vec::new(),
            texels: with_repeated_edge(&texels, width),
            origin: [center as f32; 2],
            density: (1.0 / unit) as f32,
            interpolation: Interpolation::BilinearSobel,
        }
    }

    /// The distance image of an occupancy grid, read bicubically; it must have an occupied cell. None once `go_on` is false.
    pub fn grid(grid: &Grid, frame: &Frame, go_on: &(dyn Fn() -> bool + Sync)) -> Option<Self> {
        let (width, height) = (grid.width(), grid.height());
        let unit = grid.resolution() / frame.scale;
        let largest = ((width * width + height * height) as f64).sqrt();
        // Half a cell less puts the zero level on the cells' border instead of between centres.
        let length = |squared: f64| ((squared.sqrt().min(largest) - 0.5) * unit) as f32;
        let distances = signed_distance_transform(grid.cells(), width, length, go_on)?;
        let center = |axis: usize| grid.origin()[axis] + 0.5 * grid.resolution();
        Some(Self {
            width,
            height,
            stride: width,
            distances,
            texels: Vec::new(),
            origin: frame.to_normalised([center(0), center(1)]),
            density: (1.0 / unit) as f32,
            interpolation: Interpolation::Bicubic,
        })
    }

    /// The same image read another way.
    pub fn with_interpolation(mut self, interpolation: Interpolation) -> Self {
        self.interpolation = interpolation;
        self
    }

    /// Samples all points.
    #[inline(always)]
    pub(crate) fn sample(&self, x: &[f32], y: &[f32], points: usize, out: &mut Samples<'_>) {
        if self.interpolation == Interpolation::BilinearSobel {
            return self.sample_bilinear_sobel(x, y, points, out);
        }
        for i in 0..points {
            let (distance, gradient) = self.at([x[i], y[i]]);
            out.distance[i] = distance;
            out.gradient_x[i] = gradient[0];
            out.gradient_y[i] = gradient[1];
        }
    }

    /// Distance and gradient at one point.
    pub fn at(&self, p: [f32; 2]) -> (f32, [f32; 2]) {
        match self.interpolation {
            Interpolation::BilinearSobel => {
                let (column, row, tx, ty) = self.locate(p[0], p[1]);
                let texel = self.blend(row * self.stride + column, tx, ty);
                (texel[0], [texel[1], texel[2]])
            }
            Interpolation::Bilinear => self.bilinear_exact(p),
            Interpolation::Bicubic => self.bicubic(p),
        }
    }

    /// Lower left texel and fractions of a position; positions outside are clamped.
    #[inline(always)]
    fn locate(&self, x: f32, y: f32) -> (usize, usize, f32, f32) {
        let last = [(self.width - 1) as f32, (self.height - 1) as f32];
        // `max` then `min` also sends NaN to a valid texel.
        let u = ((x - self.origin[0]) * self.density).max(0.0).min(last[0]);
        let v = ((y - self.origin[1]) * self.density).max(0.0).min(last[1]);
        let (column, row) = (u as usize, v as usize);
        (column, row, u - column as f32, v - row as f32)
    }

    /// The positions are located a block at a time, the texels read one point at a time.
    #[inline(always)]
    fn sample_bilinear_sobel(&self, x: &[f32], y: &[f32], points: usize, out: &mut Samples<'_>) {
        let last = [(self.width - 1) as f32, (self.height - 1) as f32];
        for begin in (0..points).step_by(LANES) {
            let range = begin..begin + LANES;
            let (x, y) = (&x[range.clone()], &y[range.clone()]);
            let (mut index, mut tx, mut ty) = ([0usize; LANES], [0.0f32; LANES], [0.0f32; LANES]);
            for l in 0..LANES {
                let u = ((x[l] - self.origin[0]) * self.density).max(0.0).min(last[0]);
                let v = ((y[l] - self.origin[1]) * self.density).max(0.0).min(last[1]);
                let (column, row) = (u as i32, v as i32);
                tx[l] = u - column as f32;
                ty[l] = v - row as f32;
                index[l] = (row * self.stride as i32 + column) as usize;
            }
            let distance = &mut out.distance[range.clone()];
            let gradient_x = &mut out.gradient_x[range.clone()];
            let gradient_y = &mut out.gradient_y[range];
            for l in 0..LANES.min(points - begin) {
                let texel = self.blend(index[l], tx[l], ty[l]);
                distance[l] = texel[0];
                gradient_x[l] = texel[1];
                gradient_y[l] = texel[2];
            }
        }
    }

    /// Bilinear mix of the texel at `index` with those to the right and above.
    #[inline(always)]
    fn blend(&self, index: usize, tx: f32, ty: f32) -> [f32; 4] {
        let [a, b] = [self.texels[index], self.texels[index + 1]];
        let [c, d] = [self.texels[index + self.stride], self.texels[index + self.stride + 1]];
        let mut out = [0.0; 4];
        for k in 0..4 {
            let bottom = a[k] + tx * (b[k] - a[k]);
            let top = c[k] + tx * (d[k] - c[k]);
            out[k] = bottom + ty * (top - bottom);
        }
        out
    }

    fn bilinear_exact(&self, p: [f32; 2]) -> (f32, [f32; 2]) {
        let (column, row, tx, ty) = self.locate(p[0], p[1]);
        let d = |i: usize, j: usize| {
            self.distances
                [(row + j).min(self.height - 1) * self.stride + (column + i).min(self.width - 1)]
        };
        let (a, b, c, e) = (d(0, 0), d(1, 0), d(0, 1), d(1, 1));
        let distance = (a + tx * (b - a)) * (1.0 - ty) + (c + tx * (e - c)) * ty;
        let gradient_x = ((b - a) * (1.0 - ty) + (e - c) * ty) * self.density;
        let gradient_y = ((c - a) * (1.0 - tx) + (e - b) * tx) * self.density;
        (distance, [gradient_x, gradient_y])
    }

    fn bicubic(&self, p: [f32; 2]) -> (f32, [f32; 2]) {
        let (column, row, tx, ty) = self.locate(p[0], p[1]);
        let (weights_x, slopes_x) = catmull_rom(tx);
        let (weights_y, slopes_y) = catmull_rom(ty);
        let (mut distance, mut along_x, mut along_y) = (0.0, 0.0, 0.0);
        for j in 0..4 {
            let texel_row = (row + j).saturating_sub(1).min(self.height - 1) * self.stride;
            let (mut value, mut slope) = (0.0, 0.0);
            for i in 0..4 {
                let texel_column = (column + i).saturating_sub(1).min(self.width - 1);
                let d = self.distances[texel_row + texel_column];
                value += weights_x[i] * d;
                slope += slopes_x[i] * d;
            }
            distance += weights_y[j] * value;
            along_x += weights_y[j] * slope;
            along_y += slopes_y[j] * value;
        }
        (distance, [along_x * self.density, along_y * self.density])
    }
}

/// Catmull-Rom weights of the four texels around fraction `t`, and their derivatives.
fn catmull_rom(t: f32) -> ([f32; 4], [f32; 4]) {
    let (t2, t3) = (t * t, t * t * t);
    let weights = [
        0.5 * (-t3 + 2.0 * t2 - t),
        0.5 * (3.0 * t3 - 5.0 * t2 + 2.0),
        0.5 * (-3.0 * t3 + 4.0 * t2 + t),
        0.5 * (t3 - t2),
    ];
    let slopes = [
        0.5 * (-3.0 * t2 + 4.0 * t - 1.0),
        0.5 * (9.0 * t2 - 10.0 * t),
        0.5 * (-9.0 * t2 + 8.0 * t + 1.0),
        0.5 * (3.0 * t2 - 2.0 * t),
    ];
    (weights, slopes)
}

/// The raster with its last column and last row once more.
fn with_repeated_edge(texels: &[[f32; 4]], width: usize) -> Vec<[f32; 4]> {
    let last_row = &texels[texels.len() - width..];
    let mut out = Vec::with_capacity(texels.len() + texels.len() / width + width + 1);
    for row in texels.chunks_exact(width).chain([last_row]) {
        out.extend_from_slice(row);
        out.push(row[width - 1]);
    }
    out
}

/// `[height + 2 x width + 2]`: cells whose centre lies in an obstacle, inside a frame of occupied ones.
fn rasterise(world: &World, width: usize, height: usize, pixel: f64) -> Vec<bool> {
    let stride = width + 2;
    let origin = world.bounds().min;
    let center = |cell: usize, axis: usize| origin[axis] + (cell as f64 + 0.5) * pixel;
    let mut occupied = vec![false; stride * (height + 2)];
    for obstacle in world.obstacles() {
        let around = obstacle.bounding_box();
        let cells = |axis: usize, count: usize| {
            let cell = |v: f64| ((v - origin[axis]) / pixel).floor().clamp(0.0, count as f64);
            cell(around.min[axis]) as usize..(cell(around.max[axis]) as usize + 1).min(count)
        };
        for j in cells(1, height) {
            for i in cells(0, width) {
                occupied[(j + 1) * stride + i + 1] |=
                    obstacle.contains([center(i, 0), center(j, 1)]);
            }
        }
    }
    if let Some(grid) = world.grid() {
        for j in 0..height {
            for i in 0..width {
                let (column, row) = grid.cell_of([center(i, 0), center(j, 1)]);
                occupied[(j + 1) * stride + i + 1] |= grid.is_occupied(column, row);
            }
        }
    }
    occupied[..stride].fill(true);
    occupied[stride * (height + 1)..].fill(true);
    for row in occupied.chunks_exact_mut(stride) {
        row[0] = true;
        row[stride - 1] = true;
    }
    occupied
}

/// Distance transform of free cells minus that of occupied ones, in normalised units.
fn signed_transform(occupied: &[bool], width: usize, height: usize, unit: f64) -> Vec<f32> {
    let to_occupied = squared_distance_transform(occupied, width);
    let free: Vec<bool> = occupied.iter().map(|&o| !o).collect();
    let to_free = squared_distance_transform(&free, width);
    let largest = ((width * width + height * height) as f64).sqrt();
    let length = |squared: f64| (squared.sqrt().min(largest) * unit) as f32;
    (0..occupied.len())
        .map(|i| if occupied[i] { -length(to_free[i]) } else { length(to_occupied[i]) })
        .collect()
}

/// Texels with Sobel gradients (divided by 8, so that a plane's gradient is exact inside the
/// image) of a framed raster; beyond the image the distance counts as 0, as the paper's code has it.
fn sobel_texels(width: usize, height: usize, unit: f64, framed: &[f32]) -> Vec<[f32; 4]> {
    let stride = width + 2;
    let mut inner = framed.to_vec();
    inner[..stride].fill(0.0);
    inner[stride * (height + 1)..].fill(0.0);
    for row in inner.chunks_exact_mut(stride) {
        row[0] = 0.0;
        row[stride - 1] = 0.0;
    }
    let per_unit = (1.0 / (8.0 * unit)) as f32;
    let mut texels = Vec::with_capacity(width * height);
    for j in 1..=height {
        let [below, row, above] = [j - 1, j, j + 1].map(|j| &inner[j * stride..(j + 1) * stride]);
        for i in 1..=width {
            let smooth_x = |i: usize| below[i] + 2.0 * row[i] + above[i];
            let smooth_y = |row: &[f32]| row[i - 1] + 2.0 * row[i] + row[i + 1];
            texels.push([
                row[i],
                (smooth_x(i + 1) - smooth_x(i - 1)) * per_unit,
                (smooth_y(above) - smooth_y(below)) * per_unit,
                0.0,
            ]);
        }
    }
    texels
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profile::Profile;

    fn grid_field(interpolation: Interpolation) -> ImageField {
        let (width, height) = (24, 16);
        let occupied = (0..width * height)
            .map(|i| {
                let (x, y) = (i % width, i / width);
                (6..10).contains(&x) && (4..12).contains(&y) || x == 20
            })
            .collect();
        let grid = Grid::new(width, height, 0.5, [1.0, -2.0], occupied).unwrap();
        let frame = Frame::new(&Profile::DEFAULT, grid.rect());
        ImageField::grid(&grid, &frame, &|| true).unwrap().with_interpolation(interpolation)
    }

    #[test]
    fn gradient_matches_finite_differences() {
        for interpolation in [Interpolation::Bilinear, Interpolation::Bicubic] {
            let field = grid_field(interpolation);
            for i in 0..200 {
                // Steps that avoid texel borders, where bilinear interpolation has a kink.
                let p = [0.31 + 0.0273 * i as f32, 0.29 + 0.0171 * i as f32];
                let p = [p[0] % 6.0, p[1] % 4.0];
                let h = 2e-3;
                let (u, v) = (
                    (p[0] - field.origin[0]) * field.density,
                    (p[1] - field.origin[1]) * field.density,
                );
                if [u, v].iter().any(|c| (c - c.round()).abs() < 0.02 || *c < 0.1) {
                    continue;
                }
                let (_, gradient) = field.at(p);
                for axis in 0..2 {
                    let (mut low, mut high) = (p, p);
                    low[axis] -= h;
                    high[axis] += h;
                    let expected = (field.at(high).0 - field.at(low).0) / (2.0 * h);
                    let error = (gradient[axis] - expected).abs();
                    assert!(error < 5e-3, "{interpolation:?} {p:?}: {gradient:?} {expected}");
                }
            }
        }
    }

    #[test]
    fn catmull_rom_is_a_partition_of_unity() {
        for t in [0.0, 0.2, 0.5, 0.9, 1.0] {
            let (weights, slopes) = catmull_rom(t);
            assert!((weights.iter().sum::<f32>() - 1.0).abs() < 1e-6);
            assert!(slopes.iter().sum::<f32>().abs() < 1e-6);
        }
    }
}
