//! What the TOML reader says of a file, said again for whoever wrote the file.

/// Of a table that is written as an array.
pub const TABLE_ONCE: &str = "must not be an array: only [[vehicle]] and [[obstacle]] are, of tables; every other table is written once, as [name]";

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

/// A message about `key`, at which `written` stands, as one line. What is not recognised is passed on as it came.
pub fn say(message: &str, key: &str, written: &str) -> String {
    let message = message.trim();
    let names: Vec<&str> = message.split('`').skip(1).step_by(2).collect();
    match names.split_first() {
        Some((_, known)) if is_unknown_key(message) => unknown_key(key, known),
        Some((name, known)) if message.starts_with("unknown variant") => {
            let quoted: Vec<String> = known.iter().map(|name| format!("\"{name}\"")).collect();
            let meant = nearest(name, known).map(|name| format!("; did you mean \"{name}\"?")).unwrap_or_default();
            format!("{key} = {written}: must be {}{meant}", one_of(&quoted))
        }
        Some((name, _)) if message.starts_with("missing field") => missing(key, name),
        _ => match message.rsplit_once(", expected ") {
            // The quotation would be a header.
            Some((_, expected)) if message.starts_with("invalid") && written.starts_with('[') => {
                format!("{key}: must be {}", wanted(key, expected))
            }
            Some((_, expected)) if message.starts_with("invalid") => {
                format!("{key} = {written}: must be {}", wanted(key, expected))
            }
            _ => {
                let (key, message) =
                    (if key.is_empty() { String::new() } else { format!("{key}: ") }, message.replace('\n', "; "));
                format!("{key}{message}")
            }
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
    format!("{key}: unknown key: {meant}{holder} has {}", known.join(", "))
}

fn missing(key: &str, name: &str) -> String {
    match name {
        // The file itself lacks a table; the reader then points at whatever comes first.
        "scenario" | "flock" => format!("the table [{name}] is missing"),
        _ => format!("{key}: the key {name} is missing"),
    }
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

fn nearest<'a>(name: &str, known: &[&'a str]) -> Option<&'a str> {
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
