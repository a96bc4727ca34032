//! What the TOML reader says of a file, said again for the author of the file.

use super::fault::Subject;

/// Of a table that is written as an array.
pub const TABLE_ONCE: &str = "must not be an array: only [[vehicle]], [[obstacle]] and [[airframes]] are, of \
                              tables; every other table is written once, as [name]";

/// Nearer names than this are taken for what was meant.
const ALIKE: f64 = 0.75;

/// Whether a message is of a key that no table has.
pub fn is_unknown_key(message: &str) -> bool {
    message.starts_with("unknown field")
}

/// What is wrong with the grammar of `line`.
pub fn syntax(message: &str, line: &str) -> String {
    let message = message.trim().replace('\n', ", ");
    let wanted = if message.contains("overflow") {
        "; must be a number that 64 bits can hold"
    } else if message.contains("must be quoted") {
        return format!("`{line}`: must have a number, true, false, a table or a text in quotes as its value");
    } else if message.contains("duplicate key") {
        "; must be written once in its table"
    } else {
        ""
    };
    format!("`{line}`: {message}{wanted}")
}

/// The key that a table lacks, if that is what a message says.
pub fn missing_key(message: &str) -> Option<&str> {
    message.trim().strip_prefix("missing field `")?.split('`').next()
}

/// The key that was meant by an unknown one, if a message is of one and another is like it.
pub fn meant_key(message: &str, key: &str) -> Option<String> {
    let known: Vec<&str> = message.split('`').skip(3).step_by(2).filter(|_| is_unknown_key(message)).collect();
    let (table, name) = key.rsplit_once('.').unwrap_or(("", key));
    let meant = nearest(name, &known)?;
    Some(if table.is_empty() { meant.to_owned() } else { format!("{table}.{meant}") })
}

/// What of `key`, at which `written` stands, a message is about, and what would be right, as one line. What is not
/// recognised is passed on as it came.
pub fn say(message: &str, key: &str, written: &str) -> (Subject, String) {
    let message = message.trim();
    let names: Vec<&str> = message.split('`').skip(1).step_by(2).collect();
    let value = Subject::Value(written.to_owned());
    match names.split_first() {
        Some((_, known)) if is_unknown_key(message) => (Subject::Key, unknown_key(key, known)),
        Some((name, known)) if message.starts_with("unknown variant") => {
            let quoted: Vec<String> = known.iter().map(|name| format!("\"{name}\"")).collect();
            let meant = nearest(name, known).map(|name| format!("; did you mean \"{name}\"?")).unwrap_or_default();
            (value, format!("must be {}{meant}", one_of(&quoted)))
        }
        _ => match message.rsplit_once(", expected ") {
            // The quotation would be a header.
            Some((_, expected)) if message.starts_with("invalid") && written.starts_with('[') => {
                (Subject::Key, format!("must be {}", wanted(key, expected)))
            }
            Some((_, expected)) if message.starts_with("invalid") => {
                (value, format!("must be {}", wanted(key, expected)))
            }
            _ => (Subject::Key, message.replace('\n', "; ")),
        },
    }
}

fn unknown_key(key: &str, known: &[&str]) -> String {
    let (table, name) = key.rsplit_once('.').unwrap_or(("", key));
    let meant = nearest(name, known).map(|name| format!("did you mean {name}? ")).unwrap_or_default();
    let holder = match table.split_once('[') {
        _ if table.is_empty() => "a scenario file".to_owned(),
        Some((list, _)) => format!("[[{list}]]"),
        None => format!("[{table}]"),
    };
    format!("unknown key: {meant}{holder} has {}", known.join(", "))
}

/// What serde expects, in the words of a file.
fn wanted(key: &str, expected: &str) -> String {
    match expected {
        "f64" | "f32" => "a number".to_owned(),
        "u64" | "usize" => "a whole number, 0 or greater".to_owned(),
        "u16" => "a whole number from 0 to 65535".to_owned(),
        "a boolean" => "true or false".to_owned(),
        "a string" => "a text in quotes".to_owned(),
        "a sequence" => format!("one table for each, written [[{key}]]"),
        expected if expected.starts_with("struct ") => format!("a table, written [{key}]"),
        expected if expected.contains("enum ") => "a text in quotes".to_owned(),
        expected => expected.to_owned(),
    }
}

/// The name that was meant, if one is like it.
pub fn nearest<'a>(name: &str, known: &[&'a str]) -> Option<&'a str> {
    let rated = known.iter().map(|known| (strsim::jaro_winkler(name, known), *known));
    rated.filter(|(alike, _)| *alike >= ALIKE).max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, name)| name)
}

fn one_of(names: &[String]) -> String {
    match names {
        [only] => only.clone(),
        [all @ .., last] => format!("{} or {last}", all.join(", ")),
        [] => "nothing".to_owned(),
    }
}
