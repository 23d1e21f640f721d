//! The line and column at which a path's value begins in a JSON text.
//!
//! Run only after an error, on text that has already parsed, so that reading itself carries no positions.

use super::Step;

/// Line and column (both from 1, columns in characters) of the value at `steps`; `None` if the
/// text has no such value.
pub(crate) fn locate(text: &str, steps: &[Step<'_>]) -> Option<(usize, usize)> {
    let mut scanner = Scanner { bytes: text.as_bytes(), at: 0 };
    scanner.space();
    for step in steps {
        match step {
            Step::Key(key) => scanner.enter_key(key)?,
            Step::Index(index) => scanner.enter_index(*index)?,
        }
    }
    let before = text.get(..scanner.at)?;
    let line = 1 + before.matches('\n').count();
    let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
    Some((line, 1 + before[line_start..].chars().count()))
}

/// A position in valid JSON text.
struct Scanner<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Scanner<'_> {
    fn peek(&self) -> Option<u8> {
        self.bytes.get(self.at).copied()
    }

    fn space(&mut self) {
        while self.peek().is_some_and(|byte| byte.is_ascii_whitespace()) {
            self.at += 1;
        }
    }

    /// Steps over `byte` and the space behind it, if it comes next.
    fn take(&mut self, byte: u8) -> Option<()> {
        (self.peek() == Some(byte)).then(|| {
            self.at += 1;
            self.space();
        })
    }

    fn enter_index(&mut self, index: usize) -> Option<()> {
        self.take(b'[')?;
        for _ in 0..index {
            self.skip_value()?;
            self.take(b',')?;
        }
        Some(())
    }

    fn enter_key(&mut self, key: &str) -> Option<()> {
        self.take(b'{')?;
        loop {
            let start = self.at;
            self.skip_string()?;
            let raw = std::str::from_utf8(&self.bytes[start..self.at]).ok()?;
            let found: String = serde_json::from_str(raw).ok()?;
            self.space();
            self.take(b':')?;
            if found == key {
                return Some(());
            }
            self.skip_value()?;
            self.take(b',')?;
        }
    }

    fn skip_string(&mut self) -> Option<()> {
        self.at += 1;
        while self.peek()? != b'"' {
            self.at += if self.peek() == Some(b'\\') { 2 } else { 1 };
        }
        self.at += 1;
        Some(())
    }

    /// Steps over one value and the space behind it.
    fn skip_value(&mut self) -> Option<()> {
        let mut depth = 0_usize;
        loop {
            match self.peek()? {
                b'"' => self.skip_string()?,
                b'[' | b'{' => {
                    depth += 1;
                    self.at += 1;
                }
                b']' | b'}' => {
                    depth = depth.checked_sub(1)?;
                    self.at += 1;
                }
                _ => self.at += 1,
            }
            let ended = matches!(self.peek(), None | Some(b',' | b']' | b'}'));
            if depth == 0 && ended {
                self.space();
                return Some(());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_values() {
        let text = "{\n  \"a\\\"b\": [1, {\"x\": \"],\\\\\"}, [[2] , 3]],\n  \"ö\": 1, \"c\": 5\n}";
        for (steps, expected) in [
            (vec![], Some((1, 1))),
            (vec![Step::Key("a\"b")], Some((2, 11))),
            (vec![Step::Key("a\"b"), Step::Index(1), Step::Key("x")], Some((2, 21))),
            (vec![Step::Key("a\"b"), Step::Index(2), Step::Index(1)], Some((2, 37))),
            (vec![Step::Key("c")], Some((3, 16))),
            (vec![Step::Key("d")], None),
            (vec![Step::Index(0)], None),
        ] {
            assert_eq!(locate(text, &steps), expected, "{steps:?}");
        }
    }
}
