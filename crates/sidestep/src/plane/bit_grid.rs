//! A rectangular array of bits, 64 columns to a word, rows contiguous.

/// Bits by column and row; the bits past the last column are 0.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct BitGrid {
    width: usize,
    height: usize,
    words_per_row: usize,
    words: Vec<u64>,
}

impl BitGrid {
    /// All zeros.
    pub(crate) fn new(width: usize, height: usize) -> Self {
        let words_per_row = width.div_ceil(64);
        Self { width, height, words_per_row, words: vec![0; words_per_row * height] }
    }

    /// Packs `bits`, row-major; there are `width * height` of them.
    pub(crate) fn from_bools(width: usize, height: usize, bits: &[bool]) -> Self {
        let words_per_row = width.div_ceil(64);
        let mut words = Vec::with_capacity(words_per_row * height);
        for row in bits.chunks(width) {
            for chunk in row.chunks(64) {
                words.push(chunk.iter().rev().fold(0, |word, &bit| word << 1 | u64::from(bit)));
            }
        }
        Self { width, height, words_per_row, words }
    }

    /// The set cells that have a clear one, or the array's end, on one of their four sides.
    pub(crate) fn border(&self) -> Self {
        let mut border = self.clone();
        let empty = vec![0; self.row(0).len()];
        for row in 0..self.height() {
            let here = self.row(row);
            let below = if row > 0 { self.row(row - 1) } else { &empty };
            let above = if row + 1 < self.height() { self.row(row + 1) } else { &empty };
            for (index, word) in border.row_mut(row).iter_mut().enumerate() {
                let before = if index > 0 { here[index - 1] >> 63 } else { 0 };
                let after = here.get(index + 1).map_or(0, |next| next << 63);
                let surrounded = (here[index] << 1 | before)
                    & (here[index] >> 1 | after)
                    & below[index]
                    & above[index];
                *word &= !surrounded;
            }
        }
        border
    }

    /// Number of columns.
    pub(crate) fn width(&self) -> usize {
        self.width
    }

    /// Number of rows.
    pub(crate) fn height(&self) -> usize {
        self.height
    }

    /// The words of a row, the lowest bit of the first for column 0.
    pub(crate) fn row(&self, row: usize) -> &[u64] {
        &self.words[row * self.words_per_row..][..self.words_per_row]
    }

    /// The words of a row.
    pub(crate) fn row_mut(&mut self, row: usize) -> &mut [u64] {
        &mut self.words[row * self.words_per_row..][..self.words_per_row]
    }

    /// The bit at a column and row of the array.
    #[inline]
    pub(crate) fn get(&self, column: usize, row: usize) -> bool {
        self.words[row * self.words_per_row + column / 64] >> (column % 64) & 1 == 1
    }

    /// Sets the bits of the row in columns `first..=last`.
    pub(crate) fn set(&mut self, row: usize, first: usize, last: usize) {
        for index in first / 64..=last / 64 {
            self.words[row * self.words_per_row + index] |= mask(index, first, last);
        }
    }

    /// Whether a bit of the row in columns `first..=last` is set.
    #[inline]
    pub(crate) fn any(&self, row: usize, first: usize, last: usize) -> bool {
        let words = self.row(row);
        (first / 64..=last / 64).any(|index| words[index] & mask(index, first, last) != 0)
    }

    /// The columns in `first..=last` whose bits are set in the row, ascending.
    #[inline]
    pub(crate) fn ones(
        &self,
        row: usize,
        first: usize,
        last: usize,
    ) -> impl Iterator<Item = usize> + '_ {
        let words = self.row(row);
        (first / 64..=last / 64)
            .flat_map(move |index| ones_of(words[index] & mask(index, first, last), 64 * index))
    }
}

/// The set bits of a word as columns, the lowest bit being column `first`.
#[inline]
pub(crate) fn ones_of(mut word: u64, first: usize) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let bit = (word != 0).then(|| word.trailing_zeros() as usize)?;
        word &= word - 1;
        Some(first + bit)
    })
}

/// The bits of word `index` that lie in columns `first..=last`.
#[inline]
fn mask(index: usize, first: usize, last: usize) -> u64 {
    let mut word = u64::MAX;
    if index == first / 64 {
        word &= u64::MAX << (first % 64);
    }
    if index == last / 64 {
        word &= u64::MAX >> (63 - last % 64);
    }
    word
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_and_finds_across_words() {
        let mut bits = BitGrid::new(200, 2);
        for (first, last) in [(3, 3), (60, 67), (127, 128), (199, 199)] {
            bits.set(1, first, last);
        }
        let expected: Vec<usize> =
            [3].into_iter().chain(60..=67).chain(127..=128).chain([199]).collect();
        assert_eq!(bits.ones(1, 0, 199).collect::<Vec<_>>(), expected);
        assert_eq!(bits.ones(1, 61, 127).collect::<Vec<_>>(), expected[2..=9]);
        assert!(!bits.any(0, 0, 199) && !bits.any(1, 4, 59) && bits.any(1, 64, 64));
        let bools: Vec<bool> = (0..400).map(|i| bits.get(i % 200, i / 200)).collect();
        assert_eq!(BitGrid::from_bools(200, 2, &bools), bits);
    }
}
