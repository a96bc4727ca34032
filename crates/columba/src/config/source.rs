//! The text of a scenario file, and what stands where in it.

use super::diagnostics;
use super::locate::{line_at, shorten};
use std::io::Read;
use std::path::Path;
use toml_edit::Document;

/// What is wrong with a scenario: one line for each fault, which names file, line, key, value and what would be right.
#[derive(Debug, thiserror::Error)]
#[error("{}", .lines.join("\n"))]
pub struct ConfigError {
    pub(super) lines: Vec<String>,
}

impl ConfigError {
    pub(super) fn new(lines: Vec<String>) -> Self {
        Self { lines }
    }

    /// Messages with their lines, in the order of these.
    pub(super) fn in_order(mut lines: Vec<(usize, String)>) -> Self {
        lines.sort_by_key(|(line, _)| *line);
        lines.dedup();
        Self { lines: lines.into_iter().map(|(_, message)| message).collect() }
    }
}

/// A file's name and text.
#[derive(Clone, Debug)]
pub struct Source {
    name: String,
    text: String,
}

/// A file as TOML, and the lines of it that are none.
pub struct Parsed {
    /// The file without those lines; none where nothing can be made of it.
    pub document: Option<Document<String>>,
    /// What is wrong with each of them, with its number.
    pub errors: Vec<(usize, String)>,
}

/// Longer files are not scenarios: ten thousand vehicles need one megabyte.
const BYTES_MAX: u64 = 32 << 20;
/// So many lines that are no TOML are told; the rest of such a file says little.
const SYNTAX_ERRORS_MAX: usize = 20;

impl Source {
    /// A file by its name and text.
    pub fn new(name: &str, text: &str) -> Self {
        Self { name: name.to_owned(), text: text.to_owned() }
    }

    /// Reads a file whole, unless it is no text; `kind` is what it should be.
    pub fn read(path: &Path, kind: &str) -> Result<Self, ConfigError> {
        let name = path.display().to_string();
        let refuse = |what: String| ConfigError::new(vec![format!("{name}: {what}: must be {kind}")]);
        if path.is_dir() {
            return Err(refuse("is a folder".to_owned()));
        }
        let mut bytes = Vec::new();
        let read = std::fs::File::open(path).and_then(|file| file.take(BYTES_MAX + 1).read_to_end(&mut bytes));
        match read {
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
                return Err(refuse("file not found".to_owned()));
            }
            Err(error) => return Err(refuse(format!("cannot be read: {error}"))),
            Ok(_) if bytes.len() as u64 > BYTES_MAX => {
                return Err(refuse(format!("is longer than {} MB", BYTES_MAX >> 20)));
            }
            Ok(_) => {}
        }
        String::from_utf8(bytes).map(|text| Self::new(&name, &text)).map_err(|error| {
            let valid = error.utf8_error().valid_up_to();
            let line = line_at(error.as_bytes(), valid);
            let byte = error.as_bytes().get(valid).copied().unwrap_or_default();
            ConfigError::new(vec![format!(
                "{name}:{line}: byte 0x{byte:02x} is not UTF-8: must be a text file in UTF-8"
            )])
        })
    }

    /// The name under which messages speak of it.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Its text.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The file as TOML. Lines that are none are told, and left out with what depends on them, so that the others can
    /// be checked too.
    pub fn parsed(&self) -> Parsed {
        let mut lines: Vec<&str> = self.text.split('\n').collect();
        let mut errors = Vec::new();
        loop {
            let error = match Document::parse(lines.join("\n")) {
                Ok(document) => return Parsed { document: Some(document), errors },
                Err(error) => error,
            };
            let offset = error.span().map_or(0, |span| span.start);
            let text = lines.join("\n");
            let at = line_at(&text, offset.min(text.len())).min(lines.len()) - 1;
            let line = shorten(lines.get(at).copied().unwrap_or_default());
            errors.push((at + 1, self.at_line(at + 1, &diagnostics::syntax(error.message(), &line))));
            if errors.len() >= SYNTAX_ERRORS_MAX || line.is_empty() {
                return Parsed { document: None, errors };
            }
            // Without its header, a table would be a part of the one before it.
            let is_header = |line: &str| line.trim_start().starts_with('[');
            let end = if is_header(lines[at]) {
                lines[at + 1..].iter().position(|line| is_header(line)).map_or(lines.len(), |next| at + 1 + next)
            } else {
                at + 1
            };
            lines[at..end].fill("");
        }
    }

    fn at_line(&self, line: usize, message: &str) -> String {
        format!("{}:{line}: {message}", self.name)
    }

    /// The line of an offset, and a message about what is there.
    pub fn message_at(&self, offset: usize, message: &str) -> (usize, String) {
        let line = line_at(&self.text, offset);
        (line, self.at_line(line, message))
    }
}
