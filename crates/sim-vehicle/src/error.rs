//! The ways in which a vehicle says no, one type for each of its faces.

use crate::mode::Mode;
use std::borrow::Cow;

/// How loud a text is said: the severities of STATUSTEXT that vehicles use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Severity {
    Critical,
    Warning,
    Notice,
    Info,
}

/// Why a setpoint is not flown.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SetpointError {
    /// The vehicle follows setpoints only in GUIDED.
    #[error("mode is {0}")]
    NotGuided(Mode),
    /// The setpoint itself cannot be flown.
    #[error(transparent)]
    Setpoint(#[from] mavlink_bridge::SetpointError),
}

/// How a command ends that is not obeyed: the results of COMMAND_ACK that vehicles use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CommandResult {
    Denied,
    Failed,
    Unsupported,
    TemporarilyRejected,
    Cancelled,
    /// It is obeyed, and its result follows ([`Component::conclude_later`]).
    ///
    /// [`Component::conclude_later`]: crate::telemetry::announce::Component::conclude_later
    InProgress,
    /// There is no answer at all.
    Unanswered,
}

/// Why a command is not obeyed.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct CommandError {
    pub result: CommandResult,
    /// For a STATUSTEXT.
    pub reason: Option<String>,
    /// How loud the reason is said.
    pub severity: Severity,
}

impl CommandError {
    pub fn new(result: CommandResult, reason: impl Into<String>) -> Self {
        Self { result, reason: Some(reason.into()), severity: Severity::Warning }
    }

    /// The same, as no warning: ground stations ask every vehicle whether it has this and that, and read warnings
    /// aloud.
    pub fn quietly(self) -> Self {
        Self { severity: Severity::Info, ..self }
    }

    pub fn denied(reason: impl Into<String>) -> Self {
        Self::new(CommandResult::Denied, reason)
    }

    pub fn failed(reason: impl Into<String>) -> Self {
        Self::new(CommandResult::Failed, reason)
    }

    pub fn unsupported() -> Self {
        Self { result: CommandResult::Unsupported, reason: None, severity: Severity::Info }
    }

    /// What takes a while: its result follows.
    pub fn in_progress() -> Self {
        Self { result: CommandResult::InProgress, reason: None, severity: Severity::Info }
    }

    /// What somebody else would take care of, who is not there: nobody answers.
    pub fn unanswered(reason: impl Into<String>) -> Self {
        Self::new(CommandResult::Unanswered, reason).quietly()
    }

    /// What cannot be done now.
    pub fn rejected(reason: impl Into<String>) -> Self {
        Self::new(CommandResult::TemporarilyRejected, reason)
    }
}

/// Why an item, or a whole plan, is not taken; of a fence in ArduPilot's words.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum PlanError {
    #[error("unsupported")]
    Unsupported,
    #[error("unsupported frame")]
    UnsupportedFrame,
    /// A field by its number: params 1 to 4, latitude 5, longitude 6, altitude 7.
    #[error("invalid param {0}")]
    InvalidParam(u8),
    #[error("Multiple return points")]
    ReturnPoints,
    #[error("Non-positive circle radius")]
    Radius,
    #[error("Invalid vertex count ({0})")]
    TooFewVertices(u8),
    #[error("Received incorrect {what} (want={wanted} got={got})")]
    Command { what: &'static str, wanted: u16, got: u16 },
    #[error("Unexpected vertex count want={wanted} got={got}")]
    VertexCount { wanted: u8, got: u8 },
    #[error("Incorrect item count")]
    ItemCount,
    #[error("Bad lat or lon")]
    Position,
    #[error("it jumps to no item")]
    JumpTarget,
    #[error("it belongs to another plan")]
    OtherPlan,
}

/// Why a value of a parameter is not taken.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(crate) enum ParameterError {
    #[error("No parameter {0}")]
    Unknown(String),
    #[error("No parameter {old}: it is {new} now")]
    Renamed { old: String, new: String },
    #[error("Param write denied ({0})")]
    ReadOnly(Cow<'static, str>),
    #[error("{0} is of another type")]
    Type(Cow<'static, str>),
    #[error("MAV_SYSID {0} is another vehicle's on this port")]
    SystemIdTaken(u8),
    #[error("{0} is not a finite number")]
    NotFinite(Cow<'static, str>),
    #[error("{name} {value} is outside [{least}, {most}]")]
    Range { name: &'static str, value: f32, least: f32, most: f32 },
}
