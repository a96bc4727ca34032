//! The text of a scenario file, and messages that point into it.

use super::check::Faults;
use serde::de::DeserializeOwned;
use std::path::Path;
use toml_edit::{Document, Item};

/// What is wrong with a scenario file: one line for each fault, which names file, line, key, value and what would be right.
#[derive(Debug, thiserror::Error)]
#[error("{}", .lines.join("\n"))]
pub struct ConfigError {
    lines: Vec<String>,
}

/// A file's name and text.
pub struct Source {
    name: String,
    text: String,
}

impl Source {
    pub fn new(name: &str, text: &str) -> Self {
        Self { name: name.to_owned(), text: text.to_owned() }
    }

    pub fn read(path: &Path) -> Result<Self, ConfigError> {
        let name = path.display().to_string();
        match std::fs::read_to_string(path) {
            Ok(text) => Ok(Self { name, text }),
            Err(error) => Err(ConfigError { lines: vec![format!("{name}: cannot be read: {error}")] }),
        }
    }

    /// The file as a value of `T`; a syntax error, an unknown key or a wrong type is told by line.
    pub fn parse<T: DeserializeOwned>(&self) -> Result<T, ConfigError> {
        toml_edit::de::from_str(&self.text).map_err(|error| {
            let place = match error.span() {
                Some(span) => self.place(self.line_at(span.start), self.text.get(span)),
                None => self.name.clone(),
            };
            ConfigError { lines: vec![format!("{place}: {}", error.message().trim().replace('\n', "; "))] }
        })
    }

    /// The document with its spans.
    pub fn document(&self) -> Option<Document<&str>> {
        Document::parse(self.text.as_str()).ok()
    }

    /// An error with every fault at its line, if there is any.
    pub fn refuse(&self, faults: &Faults) -> Result<(), ConfigError> {
        if faults.list.is_empty() {
            return Ok(());
        }
        let document = self.document();
        let lines = faults.list.iter().map(|fault| {
            let line = document.as_ref().and_then(|document| locate(document.as_item(), &fault.key));
            let place = self.place(line.map_or(0, |start| self.line_at(start)), None);
            format!("{place}: {} = {}: must be {}", fault.key, fault.value, fault.wanted)
        });
        Err(ConfigError { lines: lines.collect() })
    }

    fn place(&self, line: usize, snippet: Option<&str>) -> String {
        let snippet = snippet.map(|text| text.lines().next().unwrap_or("").trim()).filter(|text| !text.is_empty());
        match (line, snippet) {
            (0, _) => self.name.clone(),
            (line, None) => format!("{}:{line}", self.name),
            (line, Some(snippet)) => format!("{}:{line}: `{snippet}`", self.name),
        }
    }

    fn line_at(&self, offset: usize) -> usize {
        1 + self.text.bytes().take(offset).filter(|&byte| byte == b'\n').count()
    }
}

/// Where a key such as `obstacle[2].radius_m` stands; where it is absent, the nearest table that would hold it.
fn locate(root: &Item, key: &str) -> Option<usize> {
    let mut item = root;
    let mut found = None;
    for part in key.split('.') {
        let (name, index) = match part.split_once('[') {
            Some((name, rest)) => (name, rest.trim_end_matches(']').parse::<usize>().ok()),
            None => (part, None),
        };
        let Some(next) = item.get(name) else { break };
        let next = match index {
            // Faults count vehicles and obstacles from one, as people and the report do.
            Some(index) => next.get(index.saturating_sub(1)).unwrap_or(next),
            None => next,
        };
        found = next.span().map(|span| span.start).or(found);
        item = next;
    }
    found
}
