//! Parameters that survive a restart: one text file for each vehicle, a name and a value in each line, as ground stations
//! write and read them.

use std::fmt::Write as _;
use std::io;
use std::path::{Path, PathBuf};

/// Why a file of parameters cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum ParameterFileError {
    /// It cannot be opened, read or decoded.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// A line names a parameter that there is not, or a value that it cannot have.
    #[error("{}:{line}: {reason}", path.display())]
    Refused {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// What is wrong with it.
        reason: String,
    },
    /// A line is not a name and a number.
    #[error("{}:{line}: expected NAME VALUE, found {text:?}", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// What stands there.
        text: String,
    },
}

/// The file of the vehicle of an index in a folder.
pub(crate) fn path(folder: &Path, vehicle: usize) -> PathBuf {
    folder.join(format!("vehicle-{}.parm", vehicle + 1))
}

/// What is in a file; nothing if there is none.
pub(crate) fn read(path: &Path) -> Result<Vec<(String, f32)>, ParameterFileError> {
    match std::fs::read_to_string(path) {
        Ok(text) => parse(path, &text),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(Vec::new()),
        Err(source) => Err(ParameterFileError::Io { path: path.to_owned(), source }),
    }
}

/// For a parameter of a file that its vehicle does not take: where it stands.
pub(crate) fn refused(path: PathBuf, name: &str, reason: String) -> ParameterFileError {
    let text = std::fs::read_to_string(&path).unwrap_or_default();
    let names = |line: &str| line.split([' ', '\t', ',']).find(|word| !word.is_empty()) == Some(name);
    let line = text.lines().position(names).map_or(0, |index| index + 1);
    ParameterFileError::Refused { path, line, reason }
}

/// Writes a file whole, or leaves the old one as it was.
pub(crate) fn write(path: &Path, values: impl Iterator<Item = (&'static str, f32)>) -> io::Result<()> {
    let mut text = String::new();
    for (name, value) in values {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{name} {value}");
    }
    let unfinished = path.with_extension("parm.new");
    std::fs::write(&unfinished, text)?;
    std::fs::rename(unfinished, path)
}

/// Names and values, apart by spaces or a comma; what follows a # is not read.
fn parse(path: &Path, text: &str) -> Result<Vec<(String, f32)>, ParameterFileError> {
    let mut values = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let content = line.split('#').next().unwrap_or_default();
        let mut words = content.split([' ', '\t', ',']).filter(|word| !word.is_empty());
        let parsed = match (words.next(), words.next(), words.next()) {
            (None, _, _) => continue,
            (Some(name), Some(value), None) => value.parse().ok().map(|value| (name.to_owned(), value)),
            _ => None,
        };
        let wrong = || ParameterFileError::Line { path: path.to_owned(), line: index + 1, text: line.to_owned() };
        values.push(parsed.ok_or_else(wrong)?);
    }
    Ok(values)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = path(folder.path(), 0);
        assert!(path.ends_with("vehicle-1.parm"));
        assert_eq!(read(&path).unwrap(), []);
        write(&path, [("WP_LOITER_RAD", -80.0), ("AIRSPEED_CRUISE", 11.1)].into_iter()).unwrap();
        assert_eq!(read(&path).unwrap(), [("WP_LOITER_RAD".to_owned(), -80.0), ("AIRSPEED_CRUISE".to_owned(), 11.1)]);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn ground_stations_files_are_read_and_nonsense_is_named() {
        let path = Path::new("x.parm");
        let good = parse(path, "# saved\nRTL_RADIUS,90\n\nFS_GCS_ENABL\t1 # on\n").unwrap();
        assert_eq!(good, [("RTL_RADIUS".to_owned(), 90.0), ("FS_GCS_ENABL".to_owned(), 1.0)]);
        for bad in ["A", "A b", "A 1 2"] {
            let error = parse(path, &format!("B 1\n{bad}")).unwrap_err().to_string();
            assert_eq!(error, format!("x.parm:2: expected NAME VALUE, found {bad:?}"));
        }
    }
}
