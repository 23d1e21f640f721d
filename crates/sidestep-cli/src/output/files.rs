//! Files that appear whole or not at all.
//!
//! A file is written under a temporary name beside its place and then renamed. What a killed
//! process leaves is told from work in progress by a lock, which ends with its process, and is
//! removed by the next one that writes into the same folder.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::failure::Failure;

/// What a temporary file's name begins with.
const PREFIX: &str = ".sidestep-";
/// Links that are followed from a path before it counts as a circle.
const MOST_LINKS: usize = 40;

/// Writes a file whole. A link is followed to the file that it names, there or not yet; a file that
/// is replaced passes its permissions on, and a new one gets those that the process gives its files.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    let whole_or_not_at_all = || -> io::Result<()> {
        let target = target(path)?;
        remove_left_over(folder_of(&target));
        let mut file = temporary_beside(&target)?;
        file.write_all(bytes)?;
        if let Ok(replaced) = fs::metadata(&target) {
            file.as_file().set_permissions(replaced.permissions())?;
        }
        file.as_file().sync_all()?;
        file.persist(target).map_err(|error| error.error)?;
        Ok(())
    };
    let written = if is_special(path) { fs::write(path, bytes) } else { whole_or_not_at_all() };
    written.map_err(|error| unwritable(path, &error))
}

/// An output that the command line asks for: its flag and its file.
pub type Output<'a> = (&'static str, &'a Path);

/// Fails if an output could not be written, or would replace an input or another output: better
/// before a long measurement than after it.
pub fn check_outputs(outputs: &[Output<'_>], inputs: &[PathBuf]) -> Result<(), Failure> {
    for (index, &(flag, path)) in outputs.iter().enumerate() {
        if path.is_dir() {
            return Err(Failure::file(path, "cannot be written (it is a folder)"));
        }
        if is_special(path) {
            continue;
        }
        let target = target(path).map_err(|error| unwritable(path, &error))?;
        if let Some(input) = inputs.iter().find(|input| is_same(&target, input)) {
            let input = input.display();
            let reason = format!("would be written over {input}, which is read; give another name");
            return Err(Failure::at(flag, format!("{} {reason}", path.display())));
        }
        let same = |other: &&Output<'_>| target_is(other.1, &target);
        if let Some((other, _)) = outputs[..index].iter().find(same) {
            let reason = format!("is the file of {other} too; give another name");
            return Err(Failure::at(flag, format!("{} {reason}", path.display())));
        }
        check_writable(&target).map_err(|error| unwritable(path, &error))?;
    }
    Ok(())
}

/// Fails if a name ends in a suffix of another format than these; one without any has the first.
pub fn check_suffix((flag, path): Output<'_>, known: &[&str]) -> Result<(), Failure> {
    let Some(suffix) = path.extension().filter(|_| !is_special(path)) else { return Ok(()) };
    let suffix = suffix.to_string_lossy().to_lowercase();
    if known.contains(&suffix.as_str()) {
        return Ok(());
    }
    let names: Vec<String> = known.iter().map(|known| format!(".{known}")).collect();
    let expected =
        format!("{}: expected a name that ends in {}", path.display(), names.join(" or "));
    Err(Failure::at(flag, expected))
}

fn check_writable(target: &Path) -> io::Result<()> {
    remove_left_over(folder_of(target));
    temporary_beside(target)?;
    if target.exists() {
        // A rename asks the folder for permission and not the file.
        OpenOptions::new().append(true).open(target)?;
    }
    Ok(())
}

/// Removes what killed processes left in a folder; whatever cannot be removed stays.
fn remove_left_over(folder: &Path) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let is_ours = entry.file_name().to_string_lossy().starts_with(PREFIX);
        if !is_ours || !entry.file_type().is_ok_and(|kind| kind.is_file()) {
            continue;
        }
        // Whoever is still writing the file holds its lock.
        if let Ok(file) = File::open(entry.path())
            && file.try_lock().is_ok()
        {
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// A locked file of a new name in the folder of `target`.
fn temporary_beside(target: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(PREFIX);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // Less what the process's umask takes away.
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    loop {
        let file = builder.tempfile_in(folder_of(target))?;
        // Where files cannot be locked, nothing is ever told to be left over.
        let _ = file.as_file().lock();
        // Else somebody took it for left over before it was locked.
        if file.path().exists() {
            return Ok(file);
        }
    }
}

fn folder_of(target: &Path) -> &Path {
    target.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// The file that a path names through any links, whether or not it is there.
fn target(path: &Path) -> io::Result<PathBuf> {
    let mut target = path.to_path_buf();
    for _ in 0..MOST_LINKS {
        let Ok(link) = fs::read_link(&target) else { return Ok(target) };
        target = folder_of(&target).join(link);
    }
    Err(io::Error::other("a circle of links"))
}

fn target_is(path: &Path, other: &Path) -> bool {
    target(path).is_ok_and(|target| is_same(&target, other))
}

/// Whether two paths name one file, there or not yet.
fn is_same(a: &Path, b: &Path) -> bool {
    let place = |path: &Path| {
        fs::canonicalize(path).or_else(|_| {
            let folder = fs::canonicalize(folder_of(path))?;
            Ok::<_, io::Error>(folder.join(path.file_name().unwrap_or_default()))
        })
    };
    matches!((place(a), place(b)), (Ok(a), Ok(b)) if a == b)
}

/// Whether the path is a device, pipe or folder. A rename would replace a device by a file.
fn is_special(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|found| !found.is_file())
}

fn unwritable(path: &Path, error: &io::Error) -> Failure {
    // Errors about the temporary file name it, which helps nobody.
    let cause = match (error.raw_os_error(), error.kind()) {
        (Some(_), _) => error.to_string(),
        (None, io::ErrorKind::NotFound) => "there is no such folder".into(),
        (None, io::ErrorKind::Other) => error.to_string(),
        (None, kind) => kind.to_string(),
    };
    Failure::file(path, format!("cannot be written ({cause})"))
}
