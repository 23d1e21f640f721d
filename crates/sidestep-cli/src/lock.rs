//! A lock on an output folder, so that two runs do not write into it at once.
//!
//! The lock is the system's, on the file `.lock`: it ends with the process that holds it, however
//! that ends, so what a dead process left is taken over. The file stays, for removing it would let
//! two later runs lock two files of that name.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{Read, Write};
use std::path::Path;

use crate::failure::Failure;

/// A folder that this process alone writes into, as long as this lives.
pub struct Lock {
    _file: File,
}

impl Lock {
    /// Makes the folder where it is missing, and locks it.
    pub fn folder(folder: &Path) -> Result<Self, Failure> {
        Self::take(folder, File::try_lock)
    }

    /// The same, beside other processes that share it: no one of them excludes another, and a run
    /// that wants the folder for itself excludes all.
    pub fn shared(folder: &Path) -> Result<Self, Failure> {
        Self::take(folder, File::try_lock_shared)
    }

    fn take(folder: &Path, lock: fn(&File) -> Result<(), TryLockError>) -> Result<Self, Failure> {
        fs::create_dir_all(folder)
            .map_err(|error| Failure::file(folder, format!("cannot be made ({error})")))?;
        let path = folder.join(".lock");
        let mut options = OpenOptions::new();
        let mut file = options
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(&path)
            .map_err(|error| Failure::file(&path, format!("cannot be written ({error})")))?;
        match lock(&file) {
            Ok(()) => {
                // Who holds it is only a help to people.
                let _ = file.set_len(0).and_then(|()| writeln!(file, "{}", std::process::id()));
                Ok(Self { _file: file })
            }
            Err(TryLockError::WouldBlock) => {
                let mut holder = String::new();
                let _ = file.take(20).read_to_string(&mut holder);
                let holder = holder.trim();
                let reason = format!(
                    "is being written by another run (process {holder}); wait for it, or give another --out"
                );
                Err(Failure::file(folder, reason))
            }
            // A file system without locks.
            Err(TryLockError::Error(_)) => Ok(Self { _file: file }),
        }
    }
}
