//! A calibration that is under way on a PX4: it tells its progress (`calibration_messages.h`), and takes vehicle time.

use super::Autopilot;
use crate::error::Severity;
use std::time::Duration;

/// A calibration that is under way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Calibration {
    name: &'static str,
    began: Duration,
    /// Percent that have been told.
    told: u32,
}

/// Whether a calibration has been begun.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Begun {
    Yes,
    No,
}

/// How long a calibration takes.
const CALIBRATION: Duration = Duration::from_secs(2);
/// How often its progress is told, percent.
const PROGRESS_STEP: u32 = 20;

impl Autopilot {
    /// Begins one, unless it is armed or one goes on.
    pub fn begin_calibration(&mut self, name: &'static str) -> Begun {
        if self.flight.is_armed() || self.session.calibration.is_some() {
            return Begun::No;
        }
        self.say(Severity::Info, &format!("[cal] calibration started: 2 {name}"));
        self.session.calibration = Some(Calibration { name, began: self.time, told: 0 });
        Begun::Yes
    }

    /// Tells how far a calibration has come, and ends it.
    pub(super) fn follow_calibration(&mut self) {
        let Some(mut calibration) = self.session.calibration else { return };
        let share = self.time.saturating_sub(calibration.began).as_secs_f64() / CALIBRATION.as_secs_f64();
        let percent = (100.0 * share.min(1.0)) as u32;
        while calibration.told + PROGRESS_STEP <= percent {
            calibration.told += PROGRESS_STEP;
            self.say(Severity::Info, &format!("[cal] progress <{}>", calibration.told));
        }
        self.session.calibration = Some(calibration);
        if percent >= 100 {
            self.session.calibration = None;
            if calibration.name == "baro" {
                self.world.calibrate_barometer();
            }
            self.say(Severity::Info, &format!("[cal] calibration done: {}", calibration.name));
        }
    }
}
