//! How loud a text is said, and the ways in which a vehicle says no.

/// How loud a text is said: the severities of STATUSTEXT that vehicles use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Severity {
    Critical,
    Warning,
    Notice,
    Info,
}
