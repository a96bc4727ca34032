//! What a failsafe or the fence proposes. It is the arbiter that acts.

use crate::error::Severity;
use crate::mode::Mode;

/// What is missing or wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Cause {
    /// No setpoints in GUIDED.
    Setpoints,
    /// No heartbeat of the ground station.
    GroundStation,
    Battery,
    Gps,
    Engine,
    /// The fence is breached.
    Fence,
    /// The fence that was breached counts no more.
    FenceOff,
    /// No setpoints in Offboard: PX4's.
    OffboardStream,
    /// No ground station: PX4 holds first, and then does more.
    GroundHold,
    GroundLost,
    /// No hand on the sticks in a mode that they fly: PX4's.
    Sticks,
    /// The pilot's receiver has failed: at once, after a while, and well again.
    ReceiverShort,
    ReceiverLong,
    ReceiverBack,
}

/// What is to be done about it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Action {
    /// Nothing but words.
    Warn,
    Mode(Mode),
    /// The mission's landing sequence, and without one a return.
    Land,
    /// FBWA with the engine idle.
    Glide,
    /// The parachute.
    Parachute,
}

impl Action {
    /// The mode after it, in whose mode it is done; of a landing that is not known before.
    pub fn mode_after(self, now: Mode) -> Mode {
        match self {
            Self::Mode(mode) => mode,
            Self::Glide => Mode::Fbwa,
            Self::Warn | Self::Land | Self::Parachute => now,
        }
    }
}

/// An action and its reason.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Proposal {
    pub cause: Cause,
    pub action: Action,
    /// What is said when it has been done.
    pub text: Option<(Severity, String)>,
}

impl Proposal {
    pub fn new(cause: Cause, action: Action) -> Self {
        Self { cause, action, text: None }
    }

    pub fn saying(self, severity: Severity, text: impl Into<String>) -> Self {
        Self { text: Some((severity, text.into())), ..self }
    }
}
