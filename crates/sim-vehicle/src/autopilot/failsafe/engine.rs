//! An engine that fails: the vehicle glides down, led by its mode still.

use crate::vehicle::Vehicle;
use mavlink_bridge::dialect::MavSeverity;

impl Vehicle {
    pub(super) fn check_engine(&mut self) {
        let has_failed = self.flight.is_armed() && !self.flight.is_engine_running();
        if std::mem::replace(&mut self.failsafes.engine_failed, has_failed) == has_failed {
            return;
        }
        if has_failed {
            self.counters.failsafes += 1;
            self.say(MavSeverity::MAV_SEVERITY_CRITICAL, "Engine failed, gliding");
        } else if self.flight.is_armed() {
            self.say(MavSeverity::MAV_SEVERITY_CRITICAL, "Engine runs again");
        }
    }
}
