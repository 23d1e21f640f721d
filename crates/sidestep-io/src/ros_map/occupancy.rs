//! From pixels to cells, as Nav2's map server has it.
//!
//! A pixel counts as one byte of grey, whatever the image holds: deeper ones are scaled to a byte and
//! coloured ones count by their luma, rounded as ImageMagick does, through which Nav2 reads images. With
//! `v` the grey in `[0, 1]` its occupancy is `p = 1 - v`, or `p = v` with `negate`. A cell is free if
//! `p <= free_thresh`, else occupied if `p >= occupied_thresh`, and otherwise unknown; so is a pixel that
//! is not opaque. All of that in f32, in which Nav2 compares. `trinary` and `scale` maps differ only in
//! the greys in between, which Nav2 gives a cost in a `scale` map and which are unknown here.
//!
//! In a `raw` map a grey of 0 to 100 is an occupancy in percent, to which the same thresholds apply here,
//! and a larger one is unknown; `negate` and transparency have no say there.

use super::Unknown;
use super::yaml::{Header, Mode};

/// The grey that map savers write for cells that the robot has not seen.
const UNSEEN: u8 = 205;

/// Which greys are occupied.
pub(super) struct Occupancy {
    occupied: [bool; 256],
    /// Whether a pixel that is not opaque is occupied; `None` where its grey counts all the same.
    transparent: Option<bool>,
}

/// What a map says of a cell.
#[derive(Debug, Clone, Copy, PartialEq)]
enum State {
    Free,
    Occupied,
    Unknown,
}

/// The cells of an image, the top row first.
pub(super) struct Cells {
    pub(super) width: usize,
    occupied: Vec<bool>,
    /// How many pixels have each grey, those that count as transparent apart.
    greys: [u64; 256],
    /// How many pixels are coloured.
    pub(super) coloured: u64,
    /// What the image's reader has to say.
    pub(super) notes: Vec<String>,
}

impl Occupancy {
    pub(super) fn new(header: &Header, unknown: Unknown) -> Self {
        let occupied = |state: State| match state {
            State::Free => false,
            State::Occupied => true,
            State::Unknown => unknown == Unknown::Occupied,
        };
        Self {
            occupied: std::array::from_fn(|grey| occupied(state(header, grey as u8))),
            transparent: (header.mode != Mode::Raw).then_some(occupied(State::Unknown)),
        }
    }
}

/// What a grey says.
fn state(header: &Header, grey: u8) -> State {
    let v = f32::from(grey) / 255.0;
    let p = match header.mode {
        Mode::Raw if grey > 100 => return State::Unknown,
        Mode::Raw => f32::from(grey) / 100.0,
        _ if header.negate => v,
        _ => 1.0 - v,
    };
    if p <= header.free_thresh as f32 {
        State::Free
    } else if p >= header.occupied_thresh as f32 {
        State::Occupied
    } else {
        State::Unknown
    }
}

impl Cells {
    /// No cell yet of an image of this size.
    pub(super) fn with_capacity(width: usize, height: usize) -> Self {
        Self {
            width,
            occupied: Vec::with_capacity(width * height),
            greys: [0; 256],
            coloured: 0,
            notes: Vec::new(),
        }
    }

    /// The next pixel's cell.
    #[inline]
    pub(super) fn push(&mut self, occupancy: &Occupancy, grey: u8, opaque: bool) {
        let occupied = match occupancy.transparent {
            Some(occupied) if !opaque => occupied,
            _ => {
                self.greys[usize::from(grey)] += 1;
                occupancy.occupied[usize::from(grey)]
            }
        };
        self.occupied.push(occupied);
    }

    /// How many cells there are so far.
    pub(super) fn len(&self) -> usize {
        self.occupied.len()
    }

    pub(super) fn height(&self) -> usize {
        self.occupied.len() / self.width
    }

    /// What a person should know about how the pixels were taken.
    pub(super) fn warnings(&self, header: &Header, unknown: Unknown) -> Vec<String> {
        let mut warnings = self.notes.clone();
        let unseen = self.greys[usize::from(UNSEEN)];
        if unseen > 0 && header.mode != Mode::Raw && state(header, UNSEEN) == State::Free {
            warnings.push(format!(
                "free_thresh = {} makes {unseen} pixels of grey {UNSEEN} free, which map savers \
                 write for cells that were not seen; a free_thresh of 0.196 keeps them unknown",
                header.free_thresh
            ));
        }
        let between: u64 = (0..=255u8)
            .filter(|&grey| state(header, grey) == State::Unknown)
            .map(|grey| self.greys[usize::from(grey)])
            .sum();
        if header.mode == Mode::Scale && between > 0 {
            let taken = if unknown == Unknown::Free { "free" } else { "occupied" };
            warnings.push(format!(
                "mode scale: {between} pixels lie between the thresholds and count as unknown, \
                 here {taken}; Nav2 gives them a cost in between"
            ));
        }
        if self.coloured > 0 {
            warnings.push(format!(
                "{} pixels are coloured and count by their brightness",
                self.coloured
            ));
        }
        warnings
    }

    /// The cells, the bottom row first.
    pub(super) fn bottom_row_first(self) -> Vec<bool> {
        let (width, height) = (self.width, self.height());
        let mut cells = self.occupied;
        let (upper, lower) = cells.split_at_mut(height / 2 * width);
        for (above, below) in upper.chunks_exact_mut(width).zip(lower.rchunks_exact_mut(width)) {
            above.swap_with_slice(below);
        }
        cells
    }
}

/// A sample between 0 and `white` as a byte, by way of 16 bits as ImageMagick has it.
pub(super) fn to_byte(value: u16, white: u16) -> u8 {
    let (value, white) = (u32::from(value), u32::from(white));
    // Rounded: floor(65535 v / w + 1/2).
    let deep = ((2 * 65535 * u64::from(value) + u64::from(white)) / (2 * u64::from(white))) as u32;
    let rounded = deep + 128;
    ((rounded - (rounded >> 8)) >> 8) as u8
}

/// The luma of 16-bit colours (Rec. 709), as a byte.
pub(super) fn luma(rgb: [u16; 3]) -> u8 {
    const WEIGHTS: [f64; 3] = [0.212656, 0.715158, 0.072186];
    let sum: f64 = rgb.iter().zip(WEIGHTS).map(|(&v, weight)| f64::from(v) * weight).sum();
    to_byte((sum + 0.5).clamp(0.0, 65535.0) as u16, u16::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_stay_and_other_depths_are_scaled() {
        for v in 0..=255u16 {
            assert_eq!(u16::from(to_byte(v, 255)), v);
            assert_eq!(u16::from(to_byte(257 * v, 65535)), v);
            assert_eq!(u16::from(luma([257 * v; 3])), v);
        }
        for (value, white, expected) in [(1, 1, 255), (1, 2, 128), (50, 100, 128), (1, 15, 17)] {
            assert_eq!(to_byte(value, white), expected, "{value}/{white}");
        }
        for (rgb, expected) in [([255, 0, 0], 54), ([0, 255, 0], 182), ([0, 0, 255], 18)] {
            assert_eq!(luma(rgb.map(|v: u16| 257 * v)), expected, "{rgb:?}");
        }
    }
}
