//! Where each setting of a scenario came from: a line of its file, a flag of the command line, or a default.

use super::Overrides;
use super::check::{Fault, Faults};
use super::source::{ConfigError, Source};
use super::spot::Found;

/// More faults than this are counted only.
const FAULTS_SHOWN_MAX: usize = 20;

/// A scenario's file, and the flags that change it.
#[derive(Clone, Debug)]
pub struct Provenance {
    source: Source,
    /// A key of the file, and the flag with its value that stands in for it.
    flags: Vec<(String, String)>,
}

impl Provenance {
    pub(super) fn new(source: Source, overrides: &Overrides) -> Self {
        Self { source, flags: overrides.flags() }
    }

    /// Whom to blame for a setting that proves wrong only later (a busy port): `--ground-port 14550`,
    /// `field.toml:40: link.ground_port = 14550`, or, where it is a default, the names of the flag and the key.
    pub fn of(&self, key: &str, flag: &str) -> String {
        if let Some(flag) = self.flag(key) {
            return flag.to_owned();
        }
        match self.source.document().and_then(|document| self.source.find(&document, key)) {
            Some(found) => match found.value {
                Some(value) => format!("{}: {key} = {value}", found.place),
                None => format!("{key} (by default; {flag} sets it)"),
            },
            None => format!("{key} (by default; {flag} sets it)"),
        }
    }

    /// Whether the file or a flag says something of a key.
    pub fn names(&self, key: &str) -> bool {
        let found =
            |document: &toml_edit::Document<&str>| self.source.find(document, key).and_then(|found| found.value);
        self.flag(key).is_some() || self.source.document().as_ref().and_then(found).is_some()
    }

    /// An error with every fault at its place, in the order of the lines, if there is any.
    pub(super) fn refuse(&self, faults: &Faults) -> Result<(), ConfigError> {
        if faults.list.is_empty() {
            return Ok(());
        }
        let document = self.source.document();
        let find = |key: &str| document.as_ref().and_then(|document| self.source.find(document, key));
        // Enough to sort what is shown by line; finding the lines of tens of thousands would take long.
        let first = faults.list.iter().take(50 * FAULTS_SHOWN_MAX);
        let mut lines: Vec<(usize, String)> = first.map(|fault| self.tell(fault, &find)).collect();
        lines.sort_by_key(|(line, _)| *line);
        let more = faults.list.len().saturating_sub(FAULTS_SHOWN_MAX);
        let mut lines: Vec<String> = lines.into_iter().take(FAULTS_SHOWN_MAX).map(|(_, message)| message).collect();
        if more > 0 {
            lines.push(format!("{}: and {more} faults more", self.source.name()));
        }
        Err(ConfigError::new(lines))
    }

    /// The line of a fault, 0 where it has none, and its message.
    fn tell(&self, fault: &Fault, find: &dyn Fn(&str) -> Option<Found>) -> (usize, String) {
        let (key, wanted) = (&fault.key, &fault.wanted);
        if let (Some(place), Some(subject)) = (&fault.place, &fault.subject) {
            return (0, format!("{place}: {subject}: {wanted}"));
        }
        if let Some(flag) = self.flag(key) {
            let subject = fault.subject.as_ref().map(|subject| format!(": {subject}")).unwrap_or_default();
            return (0, format!("{flag}{subject}: {wanted}"));
        }
        let found = find(key);
        let line = found.as_ref().map_or(0, |found| found.line);
        let place = found.as_ref().map_or_else(|| self.source.name().to_owned(), |found| found.place.clone());
        let subject = match (&fault.subject, found.and_then(|found| found.value)) {
            (Some(subject), _) => subject.clone(),
            (None, Some(value)) => format!("{key} = {value}"),
            (None, None) => format!("{key} = {} (by default)", fault.value),
        };
        (line, format!("{place}: {subject}: {wanted}"))
    }

    fn flag(&self, key: &str) -> Option<&str> {
        self.flags.iter().find(|(overridden, _)| *overridden == key).map(|(_, flag)| flag.as_str())
    }
}
