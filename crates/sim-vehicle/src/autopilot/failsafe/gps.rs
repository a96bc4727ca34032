//! A GPS that is lost. As ArduPlane, the vehicle reckons on with its airspeed, its heading and the wind that it knew, and so
//! goes astray by what the wind changes and the gusts carry; with a fix it knows again where it is.

use crate::autopilot::Autopilot;
use crate::error::Severity;
use crate::mode::Mode;
use crate::parameters::Parameter;
use crate::world::GpsSettings;

impl Autopilot {
    pub(super) fn check_gps(&mut self) {
        let is_lost = self.flight.is_armed() && !GpsSettings::of(&self.parameters).has_fix();
        if std::mem::replace(&mut self.failsafes.gps_lost, is_lost) == is_lost {
            return;
        }
        if !is_lost {
            self.say(Severity::Critical, "GPS 1: fix again, Dead Reckoning stopped");
            return;
        }
        self.say(Severity::Critical, "GPS 1: no fix, Dead Reckoning started");
        self.counters.failsafes += 1;
        if self.parameters.get(Parameter::DeadReckoningAction) != 0.0 {
            self.set_mode(Mode::Rtl);
        }
    }
}
