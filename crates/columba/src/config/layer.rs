//! Layers: TOML that is laid over a scenario file, and remembers where it was written.

use super::spot::{Found, line_at, quote, spot};
use toml_edit::{Document, DocumentMut, Item, Table, TableLike, TomlError};

/// What is laid over a scenario: the setting of a flag, or the tables of a contender.
#[derive(Clone, Debug)]
pub struct Layer {
    /// The file that it is from; none for what a flag says.
    file: Option<String>,
    /// Who says it, as messages name it.
    subject: String,
    document: Document<String>,
    /// Which table of the document is laid over the scenario, such as `contender[2]`; the whole document where empty.
    path: String,
    /// The same table, as it is laid.
    table: Table,
}

impl Layer {
    /// What a flag of the command line sets; `subject` is the flag, or what else messages are to name.
    ///
    /// # Errors
    /// It is no TOML.
    pub fn of_flag(subject: &str, toml: &str) -> Result<Self, TomlError> {
        let document = Document::parse(toml.to_owned())?;
        let table = movable(document.as_table());
        Ok(Self { file: None, subject: subject.to_owned(), document, path: String::new(), table })
    }

    /// The text of a file, or of one `table` of it without the keys that are not the scenario's; none where it is no TOML.
    pub(super) fn of_file(file: &str, text: &str, path: &str, subject: &str, table: Option<&Table>) -> Option<Self> {
        let document = Document::parse(text.to_owned()).ok()?;
        let table = movable(table.unwrap_or(document.as_table()));
        Some(Self { file: Some(file.to_owned()), subject: subject.to_owned(), document, path: path.to_owned(), table })
    }

    /// The same, named in messages together with another that is laid over it.
    pub(super) fn told_with(self, other: &Self) -> Self {
        Self { subject: format!("with {}", other.subject), ..self }
    }

    /// The table that is laid.
    pub(super) fn table(&self) -> &Table {
        &self.table
    }

    /// What it sets, as TOML.
    pub fn toml(&self) -> String {
        DocumentMut::from(self.table.clone()).to_string().trim().to_owned()
    }

    /// Where it sets a key of a scenario, if it does.
    pub(super) fn find(&self, key: &str) -> Option<Found> {
        let full = if self.path.is_empty() { key.to_owned() } else { format!("{}.{key}", self.path) };
        let spot = spot(self.document.as_table(), &full)?;
        // What a layer over the file does not set is a fault of somebody else.
        let is_ground = self.path.is_empty() && self.file.is_some();
        if !spot.is_there && !is_ground {
            return None;
        }
        let text = self.document.raw();
        let line = line_at(text, spot.span.start);
        let place = match (&self.file, self.subject.as_str()) {
            (Some(file), "") => format!("{file}:{line}"),
            (Some(file), subject) => format!("{file}:{line}: {subject}"),
            (None, subject) => subject.to_owned(),
        };
        Some(Found { place, line, value: spot.is_value.then(|| quote(text, spot.span)) })
    }
}

/// Tables are laid into tables, everything else takes the place of what was there.
pub(super) fn overlay(under: &mut dyn TableLike, over: &dyn TableLike) {
    for (key, item) in over.iter() {
        match (under.get_mut(key).and_then(Item::as_table_like_mut), item.as_table_like()) {
            (Some(under), Some(over)) => overlay(under, over),
            _ => {
                under.insert(key, item.clone());
            }
        }
    }
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
