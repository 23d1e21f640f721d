//! Bytes of the files that a person names: regular files and pipes, of a bounded size. A device would be
//! read without end, or do something.

use std::fs::{File, Metadata};
use std::io::{self, IsTerminal, Read};
use std::path::Path;

use sidestep_io::input::{MAX_FILE_BYTES, decode};

use crate::failure::Failure;

/// The name of standard input.
const STANDARD_INPUT: &str = "-";

/// The bytes of a file, a pipe or, for `-`, standard input.
pub fn bytes(path: &Path) -> Result<Vec<u8>, Failure> {
    let read = || -> io::Result<Vec<u8>> {
        let file = if path == Path::new(STANDARD_INPUT) {
            standard_input()?
        } else {
            // Looked at before it is opened, which alone may do something to a device.
            check(&std::fs::metadata(path)?, true)?;
            File::open(path)?
        };
        all_of(file, true)
    };
    read().map_err(|error| unreadable(path, &error))
}

/// The bytes of a file that another file names, which has to be a regular one.
pub fn companion(path: &Path) -> io::Result<Vec<u8>> {
    let read = || -> io::Result<Vec<u8>> {
        check(&std::fs::metadata(path)?, false)?;
        all_of(File::open(path)?, false)
    };
    read().map_err(|error| io::Error::new(error.kind(), words(&error)))
}

/// The text of a file, a pipe or standard input.
pub fn text(path: &Path) -> Result<String, Failure> {
    let bytes = bytes(path)?;
    let text = decode("text file", &bytes).map_err(|error| Failure::file(path, error))?;
    Ok(text.into_owned())
}

fn all_of(file: File, pipes: bool) -> io::Result<Vec<u8>> {
    check(&file.metadata()?, pipes)?;
    let mut bytes = Vec::new();
    // Pipes have no size, and files may grow.
    file.take(MAX_FILE_BYTES + 1).read_to_end(&mut bytes)?;
    check_size(bytes.len() as u64)?;
    Ok(bytes)
}

fn check(found: &Metadata, pipes: bool) -> io::Result<()> {
    if found.is_file() {
        return check_size(found.len());
    }
    if found.is_dir() {
        return Err(io::Error::other("it is a folder"));
    }
    if !pipes || is_device(found) {
        let kinds = if pipes { "neither a file nor a pipe" } else { "not a regular file" };
        return Err(io::Error::other(format!("it is {kinds}")));
    }
    Ok(())
}

fn check_size(bytes: u64) -> io::Result<()> {
    if bytes > MAX_FILE_BYTES {
        return Err(io::Error::other(format!("it holds more than {MAX_FILE_BYTES} bytes")));
    }
    Ok(())
}

#[cfg(unix)]
fn is_device(found: &Metadata) -> bool {
    use std::os::unix::fs::FileTypeExt;
    found.file_type().is_char_device() || found.file_type().is_block_device()
}

#[cfg(not(unix))]
fn is_device(_: &Metadata) -> bool {
    false
}

fn standard_input() -> io::Result<File> {
    if io::stdin().is_terminal() {
        return Err(io::Error::other("standard input is a terminal; give a file, or pipe one in"));
    }
    #[cfg(unix)]
    let input = std::os::fd::AsFd::as_fd(&io::stdin()).try_clone_to_owned();
    #[cfg(windows)]
    let input = std::os::windows::io::AsHandle::as_handle(&io::stdin()).try_clone_to_owned();
    input.map(File::from)
}

fn unreadable(path: &Path, error: &io::Error) -> Failure {
    Failure::file(path, format!("cannot be read ({})", words(error)))
}

/// An error in words, without the number that the system gives it.
fn words(error: &io::Error) -> String {
    let text = error.to_string();
    text.split(" (os error ").next().unwrap_or(&text).to_owned()
}
