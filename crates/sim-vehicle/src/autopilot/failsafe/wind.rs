//! A wind that is too strong to fly against.

use crate::autopilot::event::Events;
use crate::autopilot::situation::Situation;
use crate::error::Severity;

/// The wind has gone down when it is so much weaker than the airspeed.
const GONE_DOWN: f64 = 0.9;

/// Whether the wind is stronger than the airspeed: said, but no failsafe.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct WindWatch {
    is_blown_away: bool,
}

impl WindWatch {
    /// No mode helps: it is said, and the vehicle goes on as well as it can.
    #[inline]
    pub fn check(&mut self, now: &Situation<'_>, events: &mut Events) {
        let wind_mps = now.world.wind_estimate().speed_mps();
        if wind_mps == 0.0 && !self.is_blown_away {
            return;
        }
        let airspeed_mps = now.flight.airspeed_mps();
        let bound_mps = if self.is_blown_away { GONE_DOWN * airspeed_mps } else { airspeed_mps };
        let is_in_air = now.flight.is_flying() && !now.flight.is_on_ground();
        let is_blown_away = is_in_air && wind_mps >= bound_mps;
        if std::mem::replace(&mut self.is_blown_away, is_blown_away) == is_blown_away {
            return;
        }
        let text = if is_blown_away {
            format!("Wind {wind_mps:.0} m/s: too strong for {airspeed_mps:.0} m/s")
        } else {
            format!("Wind {wind_mps:.0} m/s: course held again")
        };
        events.say(Severity::Warning, text);
    }
}
