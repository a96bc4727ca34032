//! An engine that fails: the vehicle glides down, led by its mode still.

use crate::autopilot::Autopilot;
use crate::error::Severity;

impl Autopilot {
    pub(super) fn check_engine(&mut self) {
        let has_failed = self.flight.is_armed() && !self.flight.is_engine_running();
        if std::mem::replace(&mut self.failsafes.engine_failed, has_failed) == has_failed {
            return;
        }
        if has_failed {
            self.counters.failsafes += 1;
            self.say(Severity::Critical, "Engine failed, gliding");
        } else if self.flight.is_armed() {
            self.say(Severity::Critical, "Engine runs again");
        }
    }
}
