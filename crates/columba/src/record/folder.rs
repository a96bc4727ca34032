//! The run folder.

use super::RecordError;
use std::{
    fs, io,
    path::{Path, PathBuf},
};

/// A folder that exists and can be written into. A file in it is whole or absent: its bytes go to a temporary name beside
/// it, which is then renamed over whatever an older run left there. The name is the process's own, so that two runs into
/// one folder do not take each other's files away: the last to end stays.
#[derive(Clone, Debug)]
pub struct RunFolder {
    path: PathBuf,
}

impl RunFolder {
    /// Makes the folder and those above it where they are missing, and tries that a file can be written, so that a long
    /// flight does not end with nowhere to put it.
    pub fn create(path: impl Into<PathBuf>) -> Result<Self, RecordError> {
        let path = path.into();
        let probe = path.join(format!(".writable.{}.tmp", std::process::id()));
        fs::create_dir_all(&path)
            .and_then(|()| fs::write(&probe, b""))
            .and_then(|()| fs::remove_file(&probe))
            .map_err(|source| RecordError::Folder { path: path.clone(), source })?;
        Ok(Self { path })
    }

    /// The folder's path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes a file by its name relative to the folder, which may lead into a sub-folder (`figures/paths.svg`).
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<(), RecordError> {
        let path = self.path.join(name);
        replace(&path, bytes).map_err(|source| RecordError::File { path, source })
    }
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
