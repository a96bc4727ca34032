//! The journal of a comparison: every flight as it is flown, so that nothing is flown twice.

use crate::flight::Summary;
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// The journal's name in the folder of a comparison.
pub const JOURNAL: &str = "journal.jsonl";

/// A file that only grows: one JSON object a line, with a flight's key and its summary. It is its writer's alone.
pub struct Journal {
    file: File,
    path: PathBuf,
}

/// Flights by their keys.
pub type Flown = HashMap<String, Summary>;

/// Why there is no journal.
#[derive(Debug, thiserror::Error)]
pub enum JournalError {
    /// Another process has it.
    #[error("{}: another comparison is writing into this folder", .0.display())]
    Taken(PathBuf),
    /// It cannot be read or written.
    #[error("cannot use {}: {source}", path.display())]
    File {
        /// The journal.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A summary cannot be written as JSON.
    #[error("cannot encode a flight: {0}")]
    Encode(#[from] serde_json::Error),
}

#[derive(Deserialize, Serialize)]
struct Line<S> {
    key: String,
    summary: S,
}

impl Journal {
    /// Opens a folder's journal, or begins one, and reads what is in it. A line that cannot be read, such as the last
    /// one of a program that was killed while it wrote, is none: its flight will be flown again.
    ///
    /// # Errors
    /// Another process has it open, or the system refuses.
    pub fn open(folder: &Path) -> Result<(Self, Flown), JournalError> {
        let path = folder.join(JOURNAL);
        let refuse = |source| JournalError::File { path: path.clone(), source };
        let mut file = OpenOptions::new().create(true).read(true).append(true).open(&path).map_err(refuse)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Err(JournalError::Taken(path)),
            Err(TryLockError::Error(source)) => return Err(refuse(source)),
        }
        let mut bytes = Vec::new();
        file.seek(SeekFrom::Start(0)).and_then(|_| file.read_to_end(&mut bytes)).map_err(refuse)?;
        if bytes.last().is_some_and(|&last| last != b'\n') {
            // Whatever is torn must not tear what comes after it.
            file.write_all(b"\n").map_err(refuse)?;
        }
        let lines = bytes.split(|&byte| byte == b'\n');
        let flown = lines.filter_map(|line| read(line).ok()).map(|line| (line.key, line.summary)).collect();
        Ok((Self { file, path }, flown))
    }

    /// Adds a flight, and gives it back as the journal will: so a comparison does not depend on when it was
    /// interrupted.
    ///
    /// # Errors
    /// The system refuses.
    pub fn add(&mut self, key: &str, summary: &Summary) -> Result<Summary, JournalError> {
        let mut line = serde_json::to_vec(&Line { key: key.to_owned(), summary })?;
        line.push(b'\n');
        self.file.write_all(&line).map_err(|source| JournalError::File { path: self.path.clone(), source })?;
        Ok(read(&line)?.summary)
    }
}

fn read(line: &[u8]) -> Result<Line<Summary>, serde_json::Error> {
    serde_json::from_slice(line)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn summary(seed: u64) -> Summary {
        let separation_m = 4.0 + 1.0 / (seed as f64 + 3.0);
        Summary {
            seed,
            min_separation_m: Some(separation_m),
            min_clearance_m: Some(f64::INFINITY),
            ..Summary::default()
        }
    }

    #[test]
    fn what_was_added_is_there_to_the_last_bit_when_it_is_opened_again() {
        let folder = tempfile::tempdir().unwrap();
        let (mut journal, flown) = Journal::open(folder.path()).unwrap();
        assert!(flown.is_empty());
        let added: Vec<Summary> =
            (0..300).map(|seed| journal.add(&format!("key {seed}"), &summary(seed)).unwrap()).collect();
        drop(journal);
        let (_, flown) = Journal::open(folder.path()).unwrap();
        assert_eq!(flown.len(), 300);
        for (seed, added) in (0..).zip(added) {
            assert_eq!(flown[&format!("key {seed}")], added);
            assert_eq!(added.min_separation_m, summary(seed).min_separation_m);
            assert_eq!(added.min_clearance_m, None, "what JSON cannot hold is nothing at once, not only later");
        }
    }

    #[test]
    fn a_torn_line_is_no_flight_and_spoils_none() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(JOURNAL);
        let (mut journal, _) = Journal::open(folder.path()).unwrap();
        journal.add("whole", &summary(1)).unwrap();
        journal.add("torn", &summary(2)).unwrap();
        drop(journal);
        let bytes = std::fs::read(&path).unwrap();
        std::fs::write(&path, &bytes[..bytes.len() - 30]).unwrap();
        let (mut journal, flown) = Journal::open(folder.path()).unwrap();
        assert_eq!(flown.keys().collect::<Vec<_>>(), ["whole"]);
        journal.add("torn", &summary(2)).unwrap();
        drop(journal);
        let (_, flown) = Journal::open(folder.path()).unwrap();
        assert_eq!(flown.len(), 2);
    }

    #[test]
    fn two_cannot_write_at_once() {
        let folder = tempfile::tempdir().unwrap();
        let first = Journal::open(folder.path()).unwrap();
        assert!(matches!(Journal::open(folder.path()), Err(JournalError::Taken(_))));
        drop(first);
        assert!(Journal::open(folder.path()).is_ok());
    }
}
