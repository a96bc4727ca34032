//! The text of a scenario file, and what stands where in it.

use super::layer::{Layer, overlay};
use super::refusal;
use super::spot::{Found, Spot, key_at, line_at, misplaced_array, quote, shorten, spot};
use serde::de::DeserializeOwned;
use std::io::Read;
use std::path::Path;
use std::sync::Arc;
use toml_edit::{Document, DocumentMut};

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
}

/// A file's name and text.
#[derive(Clone, Debug)]
pub struct Source {
    name: String,
    text: String,
    /// Of a text that was laid together from several these, the uppermost first.
    layers: Arc<[Layer]>,
}

/// Longer files are not scenarios: ten thousand vehicles need one megabyte.
const BYTES_MAX: u64 = 32 << 20;

impl Source {
    pub fn new(name: &str, text: &str) -> Self {
        Self { name: name.to_owned(), text: text.to_owned(), layers: Arc::from([]) }
    }

    /// This file with layers over it, each over those before it. Faults of the file itself are told with the last layer's
    /// name, for without it they are none.
    pub fn with(&self, layers: &[&Layer]) -> Self {
        let Some((ground, last)) = Layer::of_file(&self.name, &self.text, "", "", None).zip(layers.last()) else {
            return self.clone();
        };
        let mut merged = DocumentMut::from(ground.table().clone());
        for layer in layers {
            overlay(merged.as_table_mut(), layer.table());
        }
        let ground = ground.told_with(last);
        let uppermost_first = layers.iter().rev().copied().cloned().chain([ground]).collect();
        Self { name: self.name.clone(), text: merged.to_string(), layers: uppermost_first }
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
                return Err(refuse("there is no such file".to_owned()));
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

    /// The document with its spans; a syntax error is told by line.
    pub fn parsed(&self) -> Result<Document<&str>, ConfigError> {
        Document::parse(self.text.as_str()).map_err(|error| {
            let offset = error.span().map_or(0, |span| span.start);
            let line = self.text.lines().nth(line_at(&self.text, offset) - 1).unwrap_or_default();
            self.refuse_at(offset, &refusal::syntax(error.message(), &shorten(line)))
        })
    }

    /// The file as a value of `T`; a syntax error, an unknown key or a wrong type is told by line.
    pub fn parse<T: DeserializeOwned>(&self) -> Result<T, ConfigError> {
        let document = self.parsed()?;
        let misplaced = misplaced_array(document.as_table(), "");
        match (toml_edit::de::from_str(&self.text), misplaced) {
            (Err(error), Some(_)) if refusal::is_unknown_key(error.message()) => {
                Err(self.refuse_serde(&document, &error))
            }
            (_, Some((key, span))) => {
                Err(self.refuse_key(&key, span.start, &format!("{key}: {}", refusal::TABLE_ONCE)))
            }
            (Err(error), None) => Err(self.refuse_serde(&document, &error)),
            (Ok(value), None) => Ok(value),
        }
    }

    /// The document as it is written; empty where it is none.
    pub fn written(&self) -> DocumentMut {
        self.text.parse().unwrap_or_default()
    }

    /// The document with its spans; none where it is none.
    pub fn document(&self) -> Option<Document<&str>> {
        Document::parse(self.text.as_str()).ok()
    }

    /// Where a key such as `obstacle[2].radius_m` stands; rows are counted from one, as people and the report do.
    pub fn find(&self, document: &Document<&str>, key: &str) -> Option<Found> {
        if !self.layers.is_empty() {
            return self.layers.iter().find_map(|layer| layer.find(key));
        }
        let Spot { span, is_value, .. } = spot(document.as_table(), key)?;
        let line = line_at(&self.text, span.start);
        Some(Found { place: format!("{}:{line}", self.name), line, value: is_value.then(|| quote(&self.text, span)) })
    }

    fn refuse_serde(&self, document: &Document<&str>, error: &toml_edit::de::Error) -> ConfigError {
        let Some(span) = error.span() else {
            return ConfigError::new(vec![format!("{}: {}", self.name, refusal::say(error.message(), "", ""))]);
        };
        let key = key_at(document.as_table(), &span, "").unwrap_or_default();
        self.refuse_key(&key, span.start, &refusal::say(error.message(), &key, &quote(&self.text, span)))
    }

    /// A message of a key, at the place where that was written, be it in another text that was laid into this one.
    fn refuse_key(&self, key: &str, offset: usize, message: &str) -> ConfigError {
        match self.layers.iter().find_map(|layer| layer.find(key)) {
            Some(found) => ConfigError::new(vec![format!("{}: {message}", found.place)]),
            None => self.refuse_at(offset, message),
        }
    }

    /// A message of what stands there.
    pub fn refuse_at(&self, offset: usize, message: &str) -> ConfigError {
        ConfigError::new(vec![format!("{}:{}: {message}", self.name, line_at(&self.text, offset))])
    }
}
