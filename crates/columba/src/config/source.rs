//! The text of a scenario file, and what stands where in it.

use super::layer::Layer;
use super::refusal;
use serde::de::DeserializeOwned;
use std::io::Read;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;
use toml_edit::{Array, ArrayOfTables, Document, DocumentMut, Item, TableLike, Value};

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

/// Where a key stands.
#[derive(Debug, PartialEq, Eq)]
pub struct Found {
    /// With what a message of it begins: file and line, or the flag that set it.
    pub place: String,
    /// Its line, counted from one; that of the nearest table that would hold it, where it is absent.
    pub line: usize,
    /// Its value as it is written; none where the key is absent or a table.
    pub value: Option<String>,
}

/// Longer files are not scenarios: ten thousand vehicles need one megabyte.
const BYTES_MAX: u64 = 32 << 20;

/// Of a value that is quoted in a message, no more than this.
const QUOTED_CHARS_MAX: usize = 60;

impl Source {
    pub fn new(name: &str, text: &str) -> Self {
        Self { name: name.to_owned(), text: text.to_owned(), layers: Arc::from([]) }
    }

    /// A text that was laid together from these layers, the uppermost first.
    pub fn layered(name: &str, text: String, layers: Vec<Layer>) -> Self {
        Self { name: name.to_owned(), text, layers: layers.into() }
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

/// Where in a text a key stands.
pub struct Spot {
    /// Of the key; of the nearest table that would hold it, where it is absent.
    pub span: Range<usize>,
    /// Whether the key is there.
    pub is_there: bool,
    /// Whether it is, and is no table.
    pub is_value: bool,
}

/// Where a key stands below a table that was parsed with its spans; none where not even a table on its way is there.
pub fn spot(table: &dyn TableLike, key: &str) -> Option<Spot> {
    let mut table = table;
    let mut found = None;
    let mut parts = key.split('.').peekable();
    while let Some(part) = parts.next() {
        let (name, index) = match part.split_once('[') {
            Some((name, rest)) => (name, rest.trim_end_matches(']').parse::<usize>().unwrap_or(1)),
            None => (part, 1),
        };
        let Some(item) = table.get(name) else { break };
        let row = row(item, index.saturating_sub(1));
        let is_there = parts.peek().is_none();
        // A table that is only implied, by a dotted key, stands nowhere itself.
        if let Some(span) = row.as_ref().map_or_else(|| item.span(), |row| row.span.clone()) {
            found = Some(Spot { span, is_there, is_value: is_there && row.is_none() });
        }
        let Some(row) = row else { break };
        table = row.table;
    }
    found
}

/// What is written at a span, on one line and not too long.
pub fn quote(text: &str, span: Range<usize>) -> String {
    shorten(text.get(span).unwrap_or_default())
}

/// The line of a byte, counted from one.
pub fn line_at(text: impl AsRef<[u8]>, offset: usize) -> usize {
    1 + text.as_ref().iter().take(offset).filter(|&&byte| byte == b'\n').count()
}

/// The first line of a text, and no more of it than is good in a message.
fn shorten(text: &str) -> String {
    let text = text.trim();
    let first = text.lines().next().unwrap_or_default().trim();
    let short: String = first.chars().take(QUOTED_CHARS_MAX).filter(|c| !c.is_control()).collect();
    if short.len() < text.len() { short + "..." } else { short }
}

/// A table that stands under a key, alone or as one of many.
struct Row<'a> {
    table: &'a dyn TableLike,
    span: Option<Range<usize>>,
}

/// A table under a key, however it is written, by its index among many; none where there is a plain value.
fn row(item: &Item, index: usize) -> Option<Row<'_>> {
    if let Some(tables) = item.as_array_of_tables() {
        return tables.get(index).map(|table| Row { table, span: table.span() });
    }
    if let Some(array) = item.as_array() {
        let value = array.get(index)?;
        return value.as_inline_table().map(|table| Row { table, span: value.span() });
    }
    item.as_table_like().map(|table| Row { table, span: item.span() })
}

/// All tables under a key, each with its path.
fn rows<'a>(path: &str, item: &'a Item) -> Vec<(String, Row<'a>)> {
    let many = item.as_array_of_tables().map(ArrayOfTables::len).or(item.as_array().map(Array::len));
    let name = |index: usize| if many.is_some() { format!("{path}[{}]", index + 1) } else { path.to_owned() };
    (0..many.unwrap_or(1)).filter_map(|index| row(item, index).map(|row| (name(index), row))).collect()
}

/// The key that is written, or whose value is written, at a span of the text; none where that is more than one key's.
fn key_at(table: &dyn TableLike, wanted: &Range<usize>, path: &str) -> Option<String> {
    let within =
        |span: Option<Range<usize>>| span.is_some_and(|span| span.start <= wanted.start && wanted.end <= span.end);
    for (name, item) in table.iter() {
        let path = join(path, name);
        for (path, row) in rows(&path, item) {
            if let Some(key) = key_at(row.table, wanted, &path) {
                return Some(key);
            }
            if within(row.span) {
                return Some(path);
            }
        }
        if within(item.span()) || within(table.key(name).and_then(toml_edit::Key::span)) {
            return Some(path);
        }
    }
    None
}

/// An array where no scenario has one. Serde would take it for a table, its values by their order.
fn misplaced_array(table: &dyn TableLike, path: &str) -> Option<(String, Range<usize>)> {
    for (name, item) in table.iter() {
        let path = join(path, name);
        let is_list = path == "vehicle" || path == "obstacle";
        let all_tables = item.as_array().is_none_or(|array| array.iter().all(Value::is_inline_table));
        if (item.is_array() || item.is_array_of_tables()) && !(is_list && all_tables) {
            return Some((path, item.span().unwrap_or_default()));
        }
        for (path, row) in rows(&path, item) {
            if let Some(misplaced) = misplaced_array(row.table, &path) {
                return Some(misplaced);
            }
        }
    }
    None
}

fn join(path: &str, name: &str) -> String {
    if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") }
}
