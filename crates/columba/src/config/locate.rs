//! Where in a text a key is, and what is written there.

use std::ops::Range;
use toml_edit::{Array, ArrayOfTables, Item, TableLike, Value};

/// Of a value that is quoted in a message, no more than this.
const QUOTED_CHARS_MAX: usize = 60;

/// Where in a text a key stands.
pub struct Location {
    /// Of the key; of the nearest table that would hold it, where it is absent.
    pub span: Range<usize>,
    /// Whether the key is there.
    pub is_there: bool,
    /// Whether it is, and is no table.
    pub is_value: bool,
}

/// Where a key stands below a table that was parsed with its spans; none where not even a table on its way is there.
pub fn locate(table: &dyn TableLike, key: &str) -> Option<Location> {
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
            found = Some(Location { span, is_there, is_value: is_there && row.is_none() });
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
pub fn shorten(text: &str) -> String {
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
pub fn key_at(table: &dyn TableLike, wanted: &Range<usize>, path: &str) -> Option<String> {
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
pub fn misplaced_array(table: &dyn TableLike, path: &str) -> Option<String> {
    for (name, item) in table.iter() {
        let path = join(path, name);
        let is_list = ["vehicle", "obstacle", "airframes"].contains(&path.as_str());
        let all_tables = item.as_array().is_none_or(|array| array.iter().all(Value::is_inline_table));
        let is_files = path == "parameters.files" && item.is_array();
        if (item.is_array() || item.is_array_of_tables()) && !(is_list && all_tables) && !is_files {
            return Some(path);
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
