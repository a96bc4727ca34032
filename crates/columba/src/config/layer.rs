//! Layers: TOML that is laid over what lies beneath, and remembers who wrote it.

use super::locate::{line_at, locate, quote};
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use toml_edit::{Document, DocumentMut, Item, Table, TableLike, TomlError};

/// What a preset, a file, a contender or a flag says of a scenario.
#[derive(Clone, Debug)]
pub struct Layer {
    origin: Origin,
    document: Document<String>,
    /// Which table of the document is laid, such as `contender[2]`; the whole document where empty.
    path: String,
    /// The same table, as it is laid.
    table: Table,
    /// Keys that this layer takes away from what lies beneath.
    removes: &'static [&'static str],
    /// A flag's value as the system gave it: a path need not be text.
    raw: Option<OsString>,
}

/// Who wrote a layer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Origin {
    /// A preset, by its name.
    Preset(String),
    /// A scenario file, by its name.
    File(String),
    /// A contender, with the name of its file if it has one.
    Contender {
        /// The file of contenders.
        file: Option<String>,
        /// The contender's name.
        name: String,
    },
    /// A flag of the command line.
    Flag {
        /// As it was written: `--seed 7`.
        text: String,
        /// The key that it sets.
        key: String,
    },
}

/// Where a layer has a key.
#[derive(Debug, PartialEq, Eq)]
pub struct Found {
    /// With what a message of it begins: file and line, or the flag that set it.
    pub place: String,
    /// Its line, counted from one; 0 where it is in no file.
    pub line: usize,
    /// Its value as it is written; none where it is a table.
    pub value: Option<String>,
    /// Whether the key itself is there, or only a table that would hold it.
    pub is_there: bool,
}

/// Of each pair, a layer that has one takes the other away: they are two ways of saying the same.
const EITHER: [(&str, &str); 2] = [("vehicle", "vehicles"), ("obstacle", "obstacles")];

impl Layer {
    /// What a flag sets, as TOML; `text` is the flag as it was written, `key` the key that it is about.
    ///
    /// # Errors
    /// It is no TOML.
    pub fn of_flag(text: &str, key: &str, toml: &str) -> Result<Self, TomlError> {
        Self::of_toml(Origin::Flag { text: text.to_owned(), key: key.to_owned() }, toml)
    }

    /// The settings of a preset.
    ///
    /// # Errors
    /// They are no TOML.
    pub(super) fn of_preset(name: &str, toml: &str) -> Result<Self, TomlError> {
        Self::of_toml(Origin::Preset(name.to_owned()), toml)
    }

    /// What a contender sets, that no file names.
    ///
    /// # Errors
    /// It is no TOML.
    pub(super) fn of_contender(name: &str, toml: &str) -> Result<Self, TomlError> {
        Self::of_toml(Origin::Contender { file: None, name: name.to_owned() }, toml)
    }

    fn of_toml(origin: Origin, toml: &str) -> Result<Self, TomlError> {
        let document = Document::parse(toml.to_owned())?;
        let table = movable(document.as_table());
        Ok(Self { origin, document, path: String::new(), table, removes: &[], raw: None })
    }

    /// A whole file.
    pub(super) fn of_file(name: &str, document: Document<String>) -> Self {
        let table = movable(document.as_table());
        let origin = Origin::File(name.to_owned());
        Self { origin, document, path: String::new(), table, removes: &[], raw: None }
    }

    /// One `table` of a file of contenders, which stands at `path` in its document, without the keys that are no
    /// settings.
    pub(super) fn of_table(origin: Origin, document: Document<String>, path: &str, table: &Table) -> Self {
        Self { origin, document, path: path.to_owned(), table: movable(table), removes: &[], raw: None }
    }

    /// The same, taking keys away from what lies beneath.
    pub(super) fn removing(self, removes: &'static [&'static str]) -> Self {
        Self { removes, ..self }
    }

    /// The same, with the value as the system gave it.
    pub(super) fn with_raw(self, raw: OsString) -> Self {
        Self { raw: Some(raw), ..self }
    }

    /// Who wrote it.
    pub fn origin(&self) -> &Origin {
        &self.origin
    }

    /// The value as the system gave it, of a flag that has one.
    pub(super) fn raw(&self) -> Option<&OsString> {
        self.raw.as_ref()
    }

    /// Whether it is a flag that sets this very key.
    pub(super) fn sets(&self, key: &str) -> bool {
        matches!(&self.origin, Origin::Flag { key: own, .. } if own == key)
    }

    /// The folder that paths in it are relative to.
    pub(super) fn folder(&self) -> PathBuf {
        match &self.origin {
            Origin::File(name) | Origin::Contender { file: Some(name), .. } => {
                Path::new(name).parent().map(Path::to_path_buf).unwrap_or_default()
            }
            _ => PathBuf::new(),
        }
    }

    /// The paths of a list, as they are relative to its folder.
    pub(super) fn paths(&self, table: &str, key: &str) -> Vec<PathBuf> {
        let list = self.table.get(table).and_then(Item::as_table_like).and_then(|table| table.get(key));
        let texts = list.and_then(Item::as_array).into_iter().flatten().filter_map(toml_edit::Value::as_str);
        match &self.raw {
            Some(raw) if list.is_some() => vec![PathBuf::from(raw)],
            _ => texts.map(|text| self.folder().join(text)).collect(),
        }
    }

    /// What it sets, as TOML.
    pub fn toml(&self) -> String {
        DocumentMut::from(self.table.clone()).to_string().trim().to_owned()
    }

    /// Lays it over a document: tables into tables, everything else in place of what was there.
    pub(super) fn lay_over(&self, under: &mut DocumentMut) {
        for key in self.removes {
            remove(under.as_table_mut(), key);
        }
        for (one, other) in EITHER.into_iter().flat_map(|(a, b)| [(a, b), (b, a)]) {
            if self.table.contains_key(one) && !self.table.contains_key(other) {
                under.remove(other);
            }
        }
        overlay(under.as_table_mut(), &self.table);
    }

    /// Where it has a key of a scenario, or a table that would hold that.
    pub(super) fn find(&self, key: &str) -> Option<Found> {
        let full = if self.path.is_empty() { key.to_owned() } else { format!("{}.{key}", self.path) };
        let found = locate(self.document.as_table(), &full)?;
        let text = self.document.raw();
        let (line, place) = match (self.file(), &self.origin) {
            (Some(file), origin) => {
                let line = line_at(text, found.span.start);
                let whose = if let Origin::Contender { name, .. } = origin {
                    format!(": contender \"{name}\"")
                } else {
                    String::new()
                };
                (line, format!("{file}:{line}{whose}"))
            }
            (None, origin) => (0, origin.to_string()),
        };
        let value = found.is_value.then(|| quote(text, found.span));
        Some(Found { place, line, value, is_there: found.is_there })
    }

    fn file(&self) -> Option<&str> {
        match &self.origin {
            Origin::File(name) | Origin::Contender { file: Some(name), .. } => Some(name),
            _ => None,
        }
    }
}

impl std::fmt::Display for Origin {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Preset(name) => write!(f, "preset \"{name}\""),
            Self::File(name) => f.write_str(name),
            Self::Contender { name, .. } => write!(f, "contender \"{name}\""),
            Self::Flag { text, .. } => f.write_str(text),
        }
    }
}

/// Tables are laid into tables, everything else takes the place of what was there.
fn overlay(under: &mut dyn TableLike, over: &dyn TableLike) {
    for (key, item) in over.iter() {
        match (under.get_mut(key).and_then(Item::as_table_like_mut), item.as_table_like()) {
            (Some(under), Some(over)) => overlay(under, over),
            _ => {
                under.insert(key, item.clone());
            }
        }
    }
}

/// The table of a path such as `obstacle[2]` or `scenario.origin`, however it is written; the root where empty.
pub(super) fn table_at<'a>(root: &'a mut dyn TableLike, path: &str) -> Option<&'a mut dyn TableLike> {
    path.split('.').filter(|part| !part.is_empty()).try_fold(root, |table, part| {
        let (name, index) = match part.split_once('[') {
            Some((name, rest)) => (name, rest.trim_end_matches(']').parse::<usize>().ok()?.checked_sub(1)?),
            None => (part, 0),
        };
        let item = table.get_mut(name)?;
        if item.is_array_of_tables() {
            return Some(item.as_array_of_tables_mut()?.get_mut(index)? as &mut dyn TableLike);
        }
        if item.is_array() {
            return Some(item.as_array_mut()?.get_mut(index)?.as_inline_table_mut()? as &mut dyn TableLike);
        }
        item.as_table_like_mut()
    })
}

/// Takes a key away; false where it is not there.
pub(super) fn remove(root: &mut dyn TableLike, key: &str) -> bool {
    let (path, name) = key.rsplit_once('.').unwrap_or(("", key));
    table_at(root, path).is_some_and(|table| table.remove(name).is_some())
}

/// A table that can be laid into another document: without the places that its parts had in its own.
fn movable(table: &Table) -> Table {
    let mut table = table.clone();
    unplace(&mut table);
    table
}

fn unplace(table: &mut Table) {
    table.set_position(None);
    for (_, item) in table.iter_mut() {
        match item {
            Item::Table(inner) => unplace(inner),
            Item::ArrayOfTables(rows) => rows.iter_mut().for_each(unplace),
            _ => {}
        }
    }
}

/// Gives each table a header of its own, so that there is a place that an error about it can name.
pub(super) fn make_explicit(table: &mut Table) {
    table.set_dotted(false);
    table.set_implicit(false);
    for (_, item) in table.iter_mut() {
        match item {
            Item::Table(inner) => make_explicit(inner),
            Item::ArrayOfTables(rows) => rows.iter_mut().for_each(make_explicit),
            _ => {}
        }
    }
}
