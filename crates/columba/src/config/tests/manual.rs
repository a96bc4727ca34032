//! docs/scenario.md against the code.

use super::*;
use serde_json::Value as Json;
use toml_edit::DocumentMut;

const MANUAL: &str = include_str!("../../../../../docs/scenario.md");

/// A key as the manual tells it.
#[derive(Debug)]
struct Told {
    /// `""`, `law`, `vehicle` and so on.
    table: &'static str,
    key: &'static str,
    default: &'static str,
    range: &'static str,
}

impl Told {
    fn path(&self) -> String {
        if self.table.is_empty() { self.key.to_owned() } else { format!("{}.{}", self.table, self.key) }
    }
}

/// Every row of every table of the manual.
fn told() -> Vec<Told> {
    let mut table = "";
    let mut rows = Vec::new();
    for line in MANUAL.lines() {
        if let Some(heading) = line.strip_prefix("## ") {
            table = if heading.starts_with('[') { heading.trim_matches(['[', ']']) } else { "" };
        }
        if let Some(row) = line.strip_prefix("| `") {
            let cells: Vec<&'static str> = row.split(" |").map(str::trim).collect();
            assert_eq!(cells.len(), 6, "{line}");
            let [key, default] = [cells[0], cells[2]].map(|cell| cell.trim_matches(['|', ' ', '`']));
            rows.push(Told { table, key, default, range: cells[3].trim_matches(['|', ' ']) });
        }
    }
    rows
}

/// The file with nothing but what it must hold, as the code reads it: every key with its default.
fn read(text: &str) -> Json {
    let (file, _) = tables(&Source::new("field.toml", text), &[]).unwrap();
    serde_json::to_value(file).unwrap()
}

/// Tables that stand in for others, and so are in no smallest file.
const BY_PATTERN: [&str; 2] = ["vehicles", "obstacles"];

/// The smallest file with both.
fn by_pattern() -> String {
    let text = GOOD.split("[[obstacle]]").next().unwrap();
    text.replacen("[[vehicle]]\nx_m = 0.0\ny_m = 0.0\naltitude_m = 50.0\nspeed_mps = 10.0", "[vehicles]\ncount = 3", 1)
        + "[obstacles]\n"
}

/// What the code reads for a key that the smallest file leaves out.
fn default_of(told: &Told) -> Option<Json> {
    let root = read(if BY_PATTERN.contains(&told.table) { &by_pattern().leak()[..] } else { GOOD });
    let table = told.table.split('.').filter(|part| !part.is_empty()).try_fold(&root, |json, part| {
        let json = json.get(part)?;
        json.get(0).or(Some(json))
    });
    table?.get(told.key).cloned()
}

/// The smallest file with one key set to `value`, or taken out.
fn changed(told: &Told, value: Option<&str>) -> String {
    let text = if BY_PATTERN.contains(&told.table) { by_pattern() } else { GOOD.to_owned() };
    let mut document: DocumentMut = text.parse().unwrap();
    let mut table: &mut dyn toml_edit::TableLike = document.as_table_mut();
    for part in told.table.split('.').filter(|part| !part.is_empty()) {
        let item = table.entry(part).or_insert_with(toml_edit::table);
        table = if item.is_array_of_tables() {
            item.as_array_of_tables_mut().and_then(|tables| tables.get_mut(0)).unwrap()
        } else {
            item.as_table_like_mut().unwrap()
        };
    }
    match value {
        Some(value) => drop(table.insert(told.key, toml_edit::value(value.parse::<toml_edit::Value>().unwrap()))),
        None => drop(table.remove(told.key)),
    }
    document.to_string()
}

#[test]
fn it_tells_every_key_and_no_other() {
    let mut known = Vec::new();
    for (table, json) in read(GOOD).as_object().unwrap() {
        let by_pattern = read(&by_pattern());
        let inner = if BY_PATTERN.contains(&&table[..]) { &by_pattern[table] } else { json.get(0).unwrap_or(json) };
        collect_keys(table, inner, &mut known);
    }
    // The one table that can be written inline, and so has a row of its own.
    known.push("scenario.origin".to_owned());
    let mut told: Vec<String> = told().iter().map(Told::path).collect();
    known.sort();
    told.sort();
    assert_eq!(told, known);
}

fn collect_keys(path: &str, json: &Json, known: &mut Vec<String>) {
    match json.as_object() {
        Some(keys) => keys.iter().for_each(|(key, inner)| collect_keys(&format!("{path}.{key}"), inner, known)),
        None => known.push(path.to_owned()),
    }
}

#[test]
fn its_defaults_are_the_codes() {
    for told in told().iter().filter(|told| told.key != "origin" && told.default != "required") {
        let found = default_of(told).unwrap_or_else(|| panic!("{told:?}"));
        let written = match told.default {
            "none" => Json::Null,
            text => serde_json::from_str(text).unwrap_or_else(|error| panic!("{told:?}: {error}")),
        };
        let equal = match (found.as_f64(), written.as_f64()) {
            (Some(found), Some(written)) => found == written,
            _ => found == written,
        };
        assert!(equal, "{told:?}: the code says {found}");
    }
}

#[test]
fn what_it_calls_required_is_refused_where_it_is_missing() {
    let required: Vec<Told> = told().into_iter().filter(|told| told.default == "required").collect();
    assert_eq!(required.len(), 12);
    for told in required {
        let message = refusal_of(&changed(&told, None));
        assert!(message.contains(&format!("the key {} is missing", told.key)), "{message}");
    }
}

#[test]
fn its_ranges_are_the_codes() {
    let mut tried = 0;
    for told in told() {
        let range = told.range.strip_prefix("above ").unwrap_or(told.range);
        let bounds = range
            .split_once(" to ")
            .and_then(|(low, high)| Some((low.parse::<f64>().ok()?, high.parse::<f64>().ok()?)));
        let Some((low, high)) = bounds else { continue };
        let of_optimizer = told.table.starts_with("optimizer");
        let whole = of_optimizer || ["count", "neighbours_max"].contains(&told.key);
        // A port is a type of its own: its message is another.
        if told.key.ends_with("_port") || (of_optimizer && told.key == "dimension_setting") {
            continue;
        }
        let step = if whole && high > 1.0 { 1.0 } else { (high - low) * 1e-3 };
        for wrong in [low - step, high + step] {
            if wrong < 0.0 && whole {
                continue;
            }
            let value = if whole && step == 1.0 { format!("{wrong}") } else { format!("{wrong:?}") };
            let message = refusal_of(&changed(&told, Some(&value)));
            for word in [format!("{} = {value}: must be", told.key), low.to_string(), high.to_string()] {
                // The optimiser says "at most", which is the upper bound alone.
                assert!(message.contains(&word), "{told:?}: {message}: {word}");
            }
            tried += 1;
        }
    }
    assert!(tried > 100, "{tried}");
}

#[test]
fn its_example_flies() {
    let example = MANUAL.split("```toml\n").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    assert_eq!(load_text(example, &[]).unwrap().starts.len(), 2);
}
