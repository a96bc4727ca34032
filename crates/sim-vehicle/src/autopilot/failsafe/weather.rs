//! A wind that is too strong to fly against.

use crate::autopilot::Autopilot;
use crate::error::Severity;

/// The wind has gone down when it is so much weaker than the airspeed.
const GONE_DOWN: f64 = 0.9;

impl Autopilot {
    /// No mode helps: it is said, and the vehicle goes on as well as it can.
    pub(super) fn check_wind(&mut self) {
        let wind_mps = self.world.weather.estimate().speed_mps();
        if wind_mps == 0.0 && !self.failsafes.is_blown_away {
            return;
        }
        let airspeed_mps = self.flight.airspeed_mps();
        let bound_mps = if self.failsafes.is_blown_away { GONE_DOWN * airspeed_mps } else { airspeed_mps };
        let is_in_air = self.flight.is_flying() && !self.flight.is_on_ground();
        let is_blown_away = is_in_air && wind_mps >= bound_mps;
        if std::mem::replace(&mut self.failsafes.is_blown_away, is_blown_away) == is_blown_away {
            return;
        }
        let text = if is_blown_away {
            format!("Wind {wind_mps:.0} m/s: too strong for {airspeed_mps:.0} m/s")
        } else {
            format!("Wind {wind_mps:.0} m/s: course held again")
        };
        self.say(Severity::Warning, &text);
    }
}
