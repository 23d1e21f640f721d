//! Results to files and standard output. Files appear whole or not at all.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;

use crate::failure::Failure;

/// Writes a file under a temporary name beside it, then renames it.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    let whole_or_not_at_all = || -> io::Result<()> {
        let mut file = temporary_beside(path)?;
        file.write_all(bytes)?;
        file.as_file().sync_all()?;
        // A temporary file is private; what people asked for should be as readable as any other.
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            file.as_file().set_permissions(fs::Permissions::from_mode(0o644))?;
        }
        // Through a link to the file that it names.
        let target = fs::canonicalize(path).unwrap_or_else(|_| path.into());
        file.persist(target).map_err(|error| error.error)?;
        Ok(())
    };
    let written = if is_special(path) { fs::write(path, bytes) } else { whole_or_not_at_all() };
    written.map_err(|error| unwritable(path, &error))
}

/// Fails if a file could not be written there: better before a long measurement than after it.
pub fn check_writable<'a>(paths: impl IntoIterator<Item = &'a PathBuf>) -> Result<(), Failure> {
    for path in paths {
        if path.is_dir() {
            return Err(Failure::file(path, "cannot be written (it is a folder)"));
        }
        if !is_special(path) {
            temporary_beside(path).map_err(|error| unwritable(path, &error))?;
        }
    }
    Ok(())
}

/// Whether the path is a device, pipe or folder. A rename would replace a device by a file.
fn is_special(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|found| !found.is_file())
}

fn temporary_beside(path: &Path) -> io::Result<tempfile::NamedTempFile> {
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.into());
    let folder = target.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    tempfile::Builder::new().prefix(".sidestep-").tempfile_in(folder)
}

fn unwritable(path: &Path, error: &io::Error) -> Failure {
    // Errors about the temporary file name it, which helps nobody.
    let cause = match error.raw_os_error() {
        Some(_) => error.to_string(),
        None if error.kind() == io::ErrorKind::NotFound => "there is no such folder".into(),
        None => error.kind().to_string(),
    };
    Failure::file(path, format!("cannot be written ({cause})"))
}

/// Writes a value as JSON with a final newline.
pub fn write_json(path: &Path, value: &impl Serialize) -> Result<(), Failure> {
    write_file(path, to_json(value)?.as_bytes())
}

/// Prints a value as JSON on standard output.
pub fn print_json(value: &impl Serialize) -> Result<(), Failure> {
    print(&to_json(value)?)
}

/// Prints text on standard output; a closed pipe is not an error.
pub fn print(text: &str) -> Result<(), Failure> {
    match io::stdout().write_all(text.as_bytes()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(Failure::at("standard output", error))
        }
        _ => Ok(()),
    }
}

fn to_json(value: &impl Serialize) -> Result<String, Failure> {
    serde_json::to_string_pretty(value)
        .map(|text| text + "\n")
        .map_err(|error| Failure::at("result", error))
}

/// A progress bar on standard error; silent where that is no terminal or `quiet` is set.
pub fn progress(label: &str, total: u64, quiet: bool) -> ProgressBar {
    if quiet {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(total);
    if let Ok(style) = ProgressStyle::with_template(
        "{prefix:24!} {bar:32} {pos}/{len} {elapsed} (left {eta}) {msg}",
    ) {
        bar.set_style(style);
    }
    bar.set_prefix(label.to_string());
    bar
}
