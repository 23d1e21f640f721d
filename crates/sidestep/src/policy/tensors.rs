//! Named f32 tensors and one JSON document in a safetensors file, read from bytes that nobody vouches for.
//!
//! Format: <https://github.com/huggingface/safetensors> (8 bytes of header length, a JSON header with each
//! tensor's shape and offsets, the data). The document lies under the key `sidestep` of the header's metadata
//! and carries a `format` such as `sidestep.policy/1`. Reading allocates no more than a small
//! multiple of the file's size, whatever sizes the file claims.
//!
//! The document's last field is a checksum: CRC-32 (ISO 3309) of the document without it, then of each tensor in the order of their
//! names: name, shape, bytes. Files from before there were checksums still read; whoever wants none of these asks for
//! [`Reader::require_checksum`].

use std::collections::{BTreeSet, HashMap};

use crc32fast::Hasher;
use safetensors::tensor::{Dtype, SafeTensors, TensorView};
use serde::Serialize;
use serde::de::{Deserialize, DeserializeOwned};

use crate::error::InvalidInput;

/// Key of the document in the header's metadata.
const DOCUMENT: &str = "sidestep";

/// How a document ends that has a checksum, up to its 8 hexadecimal digits.
const CHECKSUM: &str = ",\"checksum\":\"crc32:";

/// A tensor to be written: its name, its shape and its numbers, row-major.
pub type Tensor<'a> = (String, Vec<usize>, &'a [f32]);

/// Writes a file.
///
/// # Errors
/// If the document is no JSON, or a shape does not fit its numbers.
pub fn write(document: &impl Serialize, tensors: &[Tensor]) -> Result<Vec<u8>, InvalidInput> {
    let failed = |error: &dyn std::fmt::Display| {
        InvalidInput::new("safetensors", error, "numbers that fit their shapes, a JSON document")
    };
    let text = serde_json::to_string(document).map_err(|error| failed(&error))?;
    let bytes: Vec<Vec<u8>> = tensors
        .iter()
        .map(|(_, _, values)| values.iter().flat_map(|value| value.to_le_bytes()).collect())
        .collect();
    let mut views = Vec::with_capacity(tensors.len());
    for ((name, shape, _), bytes) in tensors.iter().zip(&bytes) {
        let view = TensorView::new(Dtype::F32, shape.clone(), bytes);
        views.push((name, view.map_err(|error| failed(&error))?));
    }
    views.sort_by_key(|(name, _)| *name);
    let sum = checksum(&text, views.iter().map(|(name, view)| (name.as_str(), view)));
    let Some(open) = text.strip_suffix('}') else {
        return Err(failed(&"a document that is no object"));
    };
    let text = format!("{open}{CHECKSUM}{sum:08x}\"}}");
    let metadata = HashMap::from([(DOCUMENT.to_string(), text)]);
    safetensors::serialize(views, Some(metadata)).map_err(|error| failed(&error))
}

/// CRC-32 of the document and of the tensors, which come in the order of their names.
fn checksum<'a, 'b: 'a>(
    document: &str,
    tensors: impl Iterator<Item = (&'a str, &'a TensorView<'b>)>,
) -> u32 {
    let mut hasher = Hasher::new();
    hasher.update(document.as_bytes());
    for (name, view) in tensors {
        hasher.update(name.as_bytes());
        for &side in view.shape() {
            hasher.update(&(side as u64).to_le_bytes());
        }
        hasher.update(view.data());
    }
    hasher.finalize()
}

/// The document without its checksum, and that, if it ends with one.
fn split_checksum(text: &str) -> Option<(String, u32)> {
    let (open, sum) = text.rsplit_once(CHECKSUM)?;
    let digits = sum.strip_suffix("\"}")?;
    let plain = digits.len() == 8 && digits.bytes().all(|b| matches!(b, b'0'..=b'9' | b'a'..=b'f'));
    let sum = u32::from_str_radix(digits, 16).ok().filter(|_| plain)?;
    Some((format!("{open}}}"), sum))
}

/// A file that is being read.
pub struct Reader<'a> {
    /// What the file should be, as in `policy`; opens every error's field.
    what: &'static str,
    document: String,
    has_checksum: bool,
    tensors: SafeTensors<'a>,
    unread: BTreeSet<String>,
}

impl<'a> Reader<'a> {
    /// Opens a file that should hold a `what`, whose document has the given `format`.
    ///
    /// # Errors
    /// If the bytes are no safetensors file (truncated, oversized, inconsistent), there is no document, its format differs, or
    /// the file is not what its checksum says.
    pub fn new(bytes: &'a [u8], what: &'static str, format: &str) -> Result<Self, InvalidInput> {
        let refused = |error: &dyn std::fmt::Display| {
            InvalidInput::new(
                format!("{what} file"),
                format!("{} bytes ({error})", bytes.len()),
                "a complete safetensors file",
            )
        };
        let (_, header) = SafeTensors::read_metadata(bytes).map_err(|error| refused(&error))?;
        let tensors = SafeTensors::deserialize(bytes).map_err(|error| refused(&error))?;
        let document = header.metadata().as_ref().and_then(|map| map.get(DOCUMENT)).cloned();
        let Some(document) = document else {
            return Err(InvalidInput::new(
                format!("{what} file"),
                "a safetensors file without metadata of ours",
                format!("metadata `{DOCUMENT}` with format {format}"),
            ));
        };
        let unread: BTreeSet<String> = tensors.names().into_iter().map(str::to_string).collect();
        let (document, sum) = match split_checksum(&document) {
            Some((document, sum)) => (document, Some(sum)),
            None => (document, None),
        };
        let reader = Self { what, document, has_checksum: sum.is_some(), tensors, unread };
        // The format first: a newer version may have other fields.
        #[derive(serde::Deserialize)]
        struct Head {
            format: String,
        }
        let head: Head = reader.parse()?;
        if head.format != format {
            return Err(InvalidInput::new(format!("{what}.format"), head.format, format));
        }
        if let Some(expected) = sum {
            let views: Result<Vec<_>, _> =
                reader.unread.iter().map(|name| reader.tensors.tensor(name)).collect();
            let views = views.map_err(|error| refused(&error))?;
            let pairs = reader.unread.iter().map(String::as_str).zip(&views);
            let found = checksum(&reader.document, pairs);
            if found != expected {
                let found = format!("a content with checksum crc32:{found:08x}");
                let allowed = format!("crc32:{expected:08x}, as it was written; it is damaged");
                return Err(InvalidInput::new(format!("{what} file"), found, allowed));
            }
        }
        Ok(reader)
    }

    /// Refuses a file without a checksum.
    ///
    /// # Errors
    /// If there is none.
    pub fn require_checksum(&self) -> Result<(), InvalidInput> {
        if self.has_checksum {
            return Ok(());
        }
        let what = format!("{} file", self.what);
        Err(InvalidInput::new(what, "a document without a checksum", "one as it was written"))
    }

    /// The document.
    ///
    /// # Errors
    /// If it lacks a field, or has one of another kind or one that is not known.
    pub fn document<T: DeserializeOwned>(&self) -> Result<T, InvalidInput> {
        self.parse()
    }

    fn parse<T: for<'de> Deserialize<'de>>(&self) -> Result<T, InvalidInput> {
        serde_json::from_str(&self.document).map_err(|error| {
            InvalidInput::new(
                format!("{} file, metadata `{DOCUMENT}`", self.what),
                error,
                "the fields of its format",
            )
        })
    }

    /// Checks that the file holds so many numbers at least, before anything is allocated for them.
    ///
    /// # Errors
    /// If it holds fewer.
    pub fn check_holds(&self, numbers: usize) -> Result<(), InvalidInput> {
        let bytes: usize = self.tensors.iter().map(|(_, tensor)| tensor.data().len()).sum();
        if bytes / 4 < numbers {
            let field = format!("{}.tensors", self.what);
            let found = format!("{} numbers", bytes / 4);
            let expected = format!("at least {numbers} numbers, as its sizes ask for");
            return Err(InvalidInput::new(field, found, expected));
        }
        Ok(())
    }

    /// The numbers of one tensor, of which the shape is known and every number must be finite.
    ///
    /// # Errors
    /// If the tensor is missing, of another type or shape, or holds NaN or infinity.
    pub fn tensor(&mut self, name: &str, shape: &[usize]) -> Result<Vec<f32>, InvalidInput> {
        let field = || format!("{}.tensors.{name}", self.what);
        let expected = || format!("F32 {shape:?}");
        let Ok(view) = self.tensors.tensor(name) else {
            return Err(InvalidInput::new(field(), "a missing tensor", expected()));
        };
        if view.dtype() != Dtype::F32 || view.shape() != shape {
            let found = format!("{:?} {:?}", view.dtype(), view.shape());
            return Err(InvalidInput::new(field(), found, expected()));
        }
        let (words, _) = view.data().as_chunks::<4>();
        let values: Vec<f32> = words.iter().map(|word| f32::from_le_bytes(*word)).collect();
        if let Some(at) = values.iter().position(|value| !value.is_finite()) {
            let name = format!("{}[{at}]", field());
            return Err(InvalidInput::new(name, values[at], "finite numbers only"));
        }
        self.unread.remove(name);
        Ok(values)
    }

    /// Ends the reading.
    ///
    /// # Errors
    /// If the file has a tensor that nobody asked for.
    pub fn finish(self) -> Result<(), InvalidInput> {
        match self.unread.first() {
            None => Ok(()),
            Some(name) => Err(InvalidInput::new(
                format!("{}.tensors", self.what),
                format!("the tensor `{name}`"),
                "only the tensors of its architecture",
            )),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FORMAT: &str = "sidestep.test/1";

    fn file(values: &[f32]) -> Vec<u8> {
        let document = serde_json::json!({"format": FORMAT});
        write(&document, &[("a".into(), vec![values.len()], values)]).unwrap()
    }

    #[test]
    fn numbers_come_back_bit_for_bit() {
        let values = [1.5, -0.0, f32::MIN_POSITIVE, 1e-40, f32::MAX];
        let bytes = file(&values);
        let mut reader = Reader::new(&bytes, "test", FORMAT).unwrap();
        let back = reader.tensor("a", &[5]).unwrap();
        assert!(values.iter().zip(&back).all(|(a, b)| a.to_bits() == b.to_bits()));
        reader.finish().unwrap();
    }

    #[test]
    fn refusals_name_what_was_found_and_expected() {
        let check = |bytes: &[u8], format: &str, name: &str, shape: &[usize], expected: &str| {
            let result = Reader::new(bytes, "test", format)
                .and_then(|mut reader| reader.tensor(name, shape).and_then(|_| reader.finish()));
            let message = result.unwrap_err().to_string();
            assert!(message.contains(expected), "{message}");
        };
        let good = file(&[1.0, 2.0]);
        check(&good[..good.len() - 1], FORMAT, "a", &[2], "complete safetensors file");
        check(&[&good[..], &[0]].concat(), FORMAT, "a", &[2], "complete safetensors file");
        check(&[], FORMAT, "a", &[2], "0 bytes");
        check(&[0xff; 16], FORMAT, "a", &[2], "16 bytes");
        check(&good, "sidestep.test/2", "a", &[2], "test.format: sidestep.test/1");
        check(&good, FORMAT, "b", &[2], "test.tensors.b: a missing tensor");
        check(&good, FORMAT, "a", &[3], "test.tensors.a: F32 [2]");
        check(&good, FORMAT, "a", &[2, 1], "expected F32 [2, 1]");
        check(&file(&[1.0, f32::NAN]), FORMAT, "a", &[2], "test.tensors.a[1]: NaN");
        check(&file(&[f32::INFINITY]), FORMAT, "a", &[1], "test.tensors.a[0]: inf");
        let plain = safetensors::serialize(Vec::<(String, TensorView)>::new(), None).unwrap();
        check(&plain, FORMAT, "a", &[2], "without metadata of ours");
        let reader = Reader::new(&good, "test", FORMAT).unwrap();
        assert!(reader.check_holds(2).is_ok());
        let error = reader.check_holds(3).unwrap_err().to_string();
        assert!(error.contains("test.tensors: 2 numbers"), "{error}");
    }

    #[test]
    fn every_flipped_bit_of_a_file_is_seen() {
        let good = file(&[1.0, 2.0]);
        let read = |bytes: &[u8]| {
            let mut reader = Reader::new(bytes, "test", FORMAT)?;
            reader.require_checksum()?;
            let values = reader.tensor("a", &[2])?;
            let document: serde_json::Value = reader.document()?;
            reader.finish().map(|()| (values, document))
        };
        let before = read(&good).unwrap();
        for bit in 0..8 * good.len() {
            let mut bytes = good.clone();
            bytes[bit / 8] ^= 1 << (bit % 8);
            // A blank of the header's padding may become another blank.
            if let Ok(after) = read(&bytes) {
                assert_eq!(after, before, "bit {bit} of {}", good.len());
            }
        }
    }

    #[test]
    fn files_without_a_checksum_read_where_none_is_asked_for() {
        let plain = safetensors::serialize(
            Vec::<(String, TensorView)>::new(),
            Some(HashMap::from([(DOCUMENT.into(), format!("{{\"format\":\"{FORMAT}\"}}"))])),
        );
        let plain = plain.unwrap();
        let reader = Reader::new(&plain, "test", FORMAT).unwrap();
        let message = reader.require_checksum().unwrap_err().to_string();
        assert!(message.contains("without a checksum"), "{message}");
    }

    #[test]
    fn an_unknown_tensor_is_refused() {
        let bytes = file(&[1.0]);
        let error = Reader::new(&bytes, "test", FORMAT).unwrap().finish().unwrap_err();
        assert!(error.to_string().contains("the tensor `a`"), "{error}");
    }
}
