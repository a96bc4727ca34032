//! The run folder.

use super::RecordError;
use std::{
    fs::{self, File, TryLockError},
    io,
    path::{Path, PathBuf},
    sync::Arc,
};

/// What a new run does with a folder that is not empty, or that another run is writing into.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Occupied {
    /// Takes the first free folder of `name-2`, `name-3`, ...
    Number,
    /// Is an error.
    Refuse,
    /// Writes into the folder. Files that a run writes are replaced, all others stay.
    Overwrite,
}

/// A folder that exists and can be written into. A file in it is whole or absent: its bytes go to a temporary name
/// beside it, which is then renamed over whatever an older run left there. The name is the process's own, so that two
/// runs into one folder do not take each other's files away: the last to end stays.
#[derive(Clone, Debug)]
pub struct RunFolder {
    path: PathBuf,
    /// The folder that was asked for, where it was occupied and this is another one.
    kept: Option<PathBuf>,
    /// Held while a new run has the folder, so that no other run takes the folder while it is still empty.
    _lock: Option<Arc<File>>,
}

impl RunFolder {
    /// Makes the folder and those above it where they are missing, and tries that a file can be written, so that a long
    /// flight does not end with nowhere to put it. The folder may hold anything.
    ///
    /// # Errors
    /// The folder cannot be made or written into.
    pub fn create(path: impl Into<PathBuf>) -> Result<Self, RecordError> {
        let path = path.into();
        let probe = path.join(format!(".writable.{}.tmp", std::process::id()));
        fs::create_dir_all(&path)
            .and_then(|()| fs::write(&probe, b""))
            .and_then(|()| match fs::remove_file(&probe) {
                // Another thread of this program tried the same and was faster.
                Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
                removed => removed,
            })
            .map_err(|source| RecordError::Folder { path: path.clone(), source })?;
        Ok(Self { path, kept: None, _lock: None })
    }

    /// The folder of a new run: `path`, made like [`RunFolder::create`], or what `occupied` says where it holds
    /// something.
    ///
    /// # Errors
    /// The folder cannot be made or written into, or is occupied and is to be refused.
    pub fn open(path: impl Into<PathBuf>, occupied: Occupied) -> Result<Self, RecordError> {
        let path = path.into();
        if occupied == Occupied::Overwrite {
            return Self::create(path);
        }
        if let Some(folder) = Self::claim(&path)? {
            return Ok(folder);
        }
        if occupied == Occupied::Refuse {
            return Err(RecordError::Occupied { path });
        }
        let mut number: u64 = 2;
        loop {
            let mut name = path.clone().into_os_string();
            name.push(format!("-{number}"));
            let numbered = PathBuf::from(name);
            // A file of that name is no folder of a run.
            if (!numbered.exists() || numbered.is_dir())
                && let Some(folder) = Self::claim(&numbered)?
            {
                return Ok(Self { kept: Some(path), ..folder });
            }
            number += 1;
        }
    }

    /// The folder, unless it holds something or is another run's.
    fn claim(path: &Path) -> Result<Option<Self>, RecordError> {
        if path.is_dir() && holds_something(path) {
            return Ok(None);
        }
        fs::create_dir_all(path).map_err(|source| RecordError::Folder { path: path.to_owned(), source })?;
        // Where folders cannot be opened or locked, nothing keeps two runs apart that start at the same moment.
        let lock = File::open(path).ok();
        if lock.as_ref().is_some_and(|lock| matches!(lock.try_lock(), Err(TryLockError::WouldBlock))) {
            return Ok(None);
        }
        // Looked at again: another run may have ended since.
        if holds_something(path) {
            return Ok(None);
        }
        Ok(Some(Self { _lock: lock.map(Arc::new), ..Self::create(path)? }))
    }

    /// The folder that was asked for, where it was occupied and this is another one.
    pub fn kept(&self) -> Option<&Path> {
        self.kept.as_deref()
    }

    /// The folder's path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes a file by its name relative to the folder, which may lead into a sub-folder (`figures/paths.svg`).
    ///
    /// # Errors
    /// The file cannot be written; what had its name before is still there.
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<(), RecordError> {
        let path = self.path.join(name);
        replace(&path, bytes).map_err(|source| RecordError::File { path, source })
    }
}

/// Whether there is anything in a folder but hidden files, whose names no run uses.
pub fn holds_something(folder: &Path) -> bool {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries.into_iter().any(|entry| !entry.file_name().as_encoded_bytes().starts_with(b"."))
}

fn replace(path: &Path, bytes: &[u8]) -> io::Result<()> {
    if let Some(parent) = path.parent() {
        fs::create_dir_all(parent)?;
    }
    let mut temporary = path.as_os_str().to_owned();
    temporary.push(format!(".{}.tmp", std::process::id()));
    let temporary = PathBuf::from(temporary);
    let written = fs::write(&temporary, bytes).and_then(|()| fs::rename(&temporary, path));
    if written.is_err() {
        // Best effort: the error that matters is the one returned.
        let _ = fs::remove_file(&temporary);
    }
    written
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(path: &Path) -> Vec<String> {
        let mut names: Vec<String> =
            fs::read_dir(path).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn files_are_replaced_and_nothing_else_is_left() {
        let root = tempfile::tempdir().unwrap();
        let folder = RunFolder::create(root.path().join("a/b")).unwrap();
        folder.write("summary.json", b"older and longer").unwrap();
        folder.write("summary.json", b"new").unwrap();
        folder.write("figures/paths.svg", b"<svg/>").unwrap();
        assert_eq!(fs::read(folder.path().join("summary.json")).unwrap(), b"new");
        assert_eq!(names(folder.path()), ["figures", "summary.json"]);
        assert_eq!(names(&folder.path().join("figures")), ["paths.svg"]);
    }

    #[test]
    fn a_new_run_takes_no_folder_that_holds_something() {
        let root = tempfile::tempdir().unwrap();
        let path = root.path().join("run");
        fs::create_dir(&path).unwrap();
        fs::write(path.join(".gitkeep"), b"").unwrap();
        let first = RunFolder::open(&path, Occupied::Number).unwrap();
        assert_eq!((first.path(), first.kept()), (path.as_path(), None), "hidden files are nothing that a run writes");
        first.write("report.html", b"somebody's own").unwrap();
        drop(first);

        assert!(matches!(RunFolder::open(&path, Occupied::Refuse), Err(RecordError::Occupied { .. })));
        fs::write(root.path().join("run-2"), b"a file").unwrap();
        let third = RunFolder::open(&path, Occupied::Number).unwrap();
        assert_eq!((third.path(), third.kept()), (root.path().join("run-3").as_path(), Some(path.as_path())));
        let forced = RunFolder::open(&path, Occupied::Overwrite).unwrap();
        assert_eq!((forced.path(), forced.kept()), (path.as_path(), None));
        assert_eq!(fs::read(path.join("report.html")).unwrap(), b"somebody's own");
    }

    #[test]
    fn runs_that_start_together_have_a_folder_each() {
        let root = tempfile::tempdir().unwrap();
        let path = root.path().join("run");
        let folders: Vec<RunFolder> = std::thread::scope(|scope| {
            let open = || RunFolder::open(&path, Occupied::Number).unwrap();
            let threads: Vec<_> = (0..8).map(|_| scope.spawn(open)).collect();
            threads.into_iter().map(|thread| thread.join().unwrap()).collect()
        });
        let mut paths: Vec<&Path> = folders.iter().map(RunFolder::path).collect();
        paths.sort();
        paths.dedup();
        assert_eq!(paths.len(), 8);
        assert!(matches!(RunFolder::open(&path, Occupied::Refuse), Err(RecordError::Occupied { .. })));
        // A run that ended without a file leaves an empty folder, which the next one uses.
        drop(folders);
        assert_eq!(RunFolder::open(&path, Occupied::Number).unwrap().path(), path);
    }

    #[test]
    fn a_file_in_the_way_is_an_error_that_names_it() {
        let root = tempfile::tempdir().unwrap();
        let path = root.path().join("taken");
        fs::write(&path, b"a file").unwrap();
        let error = RunFolder::create(&path).unwrap_err();
        assert!(matches!(error, RecordError::Folder { .. }));
        assert!(error.to_string().contains("taken"));
    }

    #[test]
    fn a_failed_write_keeps_the_older_file_and_no_temporary() {
        let root = tempfile::tempdir().unwrap();
        let folder = RunFolder::create(root.path()).unwrap();
        // A folder under the file's name: the rename fails after the temporary was written.
        folder.write("report.html/inner", b"kept").unwrap();
        assert!(matches!(folder.write("report.html", b"new"), Err(RecordError::File { .. })));
        assert_eq!(names(root.path()), ["report.html"]);
        assert_eq!(fs::read(root.path().join("report.html/inner")).unwrap(), b"kept");
    }
}
