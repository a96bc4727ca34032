//! What is wrong with the settings of a scenario, before it is known where each was written.

use flight_model::RangeError;
use std::collections::BTreeSet;
use std::fmt::Display;

/// One thing that is wrong.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// As `table.key` or `table[2].key`, counted from one; empty for the whole file.
    pub key: String,
    /// What of it is at fault.
    pub subject: Subject,
    /// What would be right, as `must be ...`.
    pub wanted: String,
}

/// What a fault is about.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Subject {
    /// The value of the key, which is this where the file leaves the key out.
    Value(String),
    /// The key itself, or a table.
    Key,
    /// Something that no single key says.
    Of(String),
}

/// Everything that is wrong.
#[derive(Clone, Debug, Default)]
pub struct Faults {
    list: Vec<Fault>,
    /// Faults whose place is known already: lines and messages.
    placed: Vec<(usize, String)>,
    /// Keys whose value is a stand-in for one that could not be read.
    stand_ins: BTreeSet<String>,
}

impl Faults {
    /// Whether nothing is wrong.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty() && self.placed.is_empty()
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.list.len() + self.placed.len()
    }

    /// Those that have no place yet.
    pub fn iter(&self) -> impl Iterator<Item = &Fault> {
        self.list.iter()
    }

    /// Those that have one: lines and messages.
    pub fn placed(&self) -> &[(usize, String)] {
        &self.placed
    }

    /// Adds messages with their lines.
    pub fn add_placed(&mut self, messages: impl IntoIterator<Item = (usize, String)>) {
        self.placed.extend(messages);
    }

    /// Whether a key, or anything in a table, is at fault.
    pub fn is_within(&self, table: &str) -> bool {
        let is_in =
            |key: &str| key.strip_prefix(table).is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']));
        self.list.iter().any(|fault| is_in(&fault.key)) || self.stand_ins.iter().any(|key| is_in(key))
    }

    /// Whether there is a fault of this key that wants the same.
    pub fn has(&self, fault: &Fault) -> bool {
        self.list.iter().any(|other| other.key == fault.key && other.wanted == fault.wanted)
    }

    /// Whether a key, or a table around it, is at fault.
    pub fn tells(&self, key: &str) -> bool {
        self.list.iter().any(|fault| fault.key == key) || self.stands_in(key)
    }

    /// Whether the value of a key is a stand-in, about which nothing can be said.
    pub fn stands_in(&self, key: &str) -> bool {
        self.stand_ins.iter().any(|other| {
            key.strip_prefix(other.as_str()).is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
        })
    }

    /// From now on the value of a key is a stand-in.
    pub fn stand_in(&mut self, key: &str) {
        self.stand_ins.insert(key.to_owned());
    }

    /// Adds a fault, unless it is of a stand-in.
    pub fn add_fault(&mut self, fault: Fault) {
        if !self.stands_in(&fault.key) {
            self.list.push(fault);
        }
    }

    /// A setting with a wrong value.
    pub fn add(&mut self, key: impl Into<String>, value: impl Display, wanted: impl Display) {
        let subject = Subject::Value(value.to_string());
        self.add_fault(Fault { key: key.into(), subject, wanted: format!("must be {wanted}") });
    }

    /// A key that is wrong itself.
    pub fn add_key(&mut self, key: &str, wanted: &str) {
        self.add_fault(Fault { key: key.to_owned(), subject: Subject::Key, wanted: wanted.to_owned() });
        self.stand_in(key);
    }

    /// A key that a table lacks.
    pub fn add_missing(&mut self, table: &str, name: &str) {
        let wanted = match name {
            "scenario" | "flock" if table.is_empty() => format!("the table [{name}] is missing"),
            _ => format!("the key {name} is missing"),
        };
        self.list.push(Fault { key: table.to_owned(), subject: Subject::Key, wanted });
    }

    /// A fault that is not of one setting alone.
    pub fn add_subject(&mut self, key: impl Into<String>, subject: impl Into<String>, wanted: impl Into<String>) {
        self.add_fault(Fault { key: key.into(), subject: Subject::Of(subject.into()), wanted: wanted.into() });
    }

    /// What the settings of a table say of themselves.
    pub fn add_ranges(&mut self, table: &str, errors: impl IntoIterator<Item = RangeError>) {
        for RangeError { name, value, range } in errors {
            self.add(format!("{table}.{name}"), value, range);
        }
    }

    /// `low..=high`; where these are settings at fault themselves, their own messages are enough.
    pub fn within(&mut self, key: impl Into<String>, value: f64, low: f64, high: f64) {
        if low <= high && !(low..=high).contains(&value) {
            self.add(key, value, format!("a number from {low} to {high}"));
        }
    }

    /// Above `low`, up to `high`; as [`within`](Self::within).
    pub fn above(&mut self, key: impl Into<String>, value: f64, low: f64, high: f64) {
        if low <= high && !(value > low && value <= high) {
            self.add(key, value, format!("a number greater than {low} and at most {high}"));
        }
    }

    /// A whole number.
    pub fn whole(&mut self, key: impl Into<String>, value: usize, low: usize, high: usize) {
        if !(low..=high).contains(&value) {
            self.add(key, value, format!("a whole number from {low} to {high}"));
        }
    }
}
