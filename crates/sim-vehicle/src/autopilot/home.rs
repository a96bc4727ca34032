//! Home: where it is, who sets it, and altitudes above it.

use crate::autopilot::Autopilot;
use crate::autopilot::event::Event;
use crate::autopilot::flight::Home;
use crate::firmware::Personality;
use crate::protocol::command::{ALTITUDE_MAX_M, Command, Refusal, check_finite};
use flight_model::Geodetic;
use mavlink_bridge::dialect::MavFrame;

impl Autopilot {
    /// DO_SET_HOME. Param 1: 1 for where it is, or 0 for the place that comes with it; one of no latitude and longitude
    /// means where it is, too.
    pub(crate) fn do_set_home(&mut self, command: &Command) -> Result<(), Refusal> {
        let [p1, ..] = command.params;
        check_finite("Home", &[p1])?;
        if p1 != 1.0 {
            check_finite("Home", &command.place)?;
        }
        let (latitude_e7, longitude_e7) = command.position_e7();
        if p1 == 1.0 || (latitude_e7, longitude_e7) == (0, 0) {
            self.set_home_here();
            self.home_is_set = true;
            return Ok(());
        }
        if p1 != 0.0 {
            return Err(Refusal::failed("Home: param 1 is neither 0 nor 1"));
        }
        if latitude_e7.unsigned_abs() > 900_000_000 || longitude_e7.unsigned_abs() > 1_800_000_000 {
            return Err(Refusal::failed("Home: no such place"));
        }
        if command.z.is_nan() || command.z.abs() >= ALTITUDE_MAX_M {
            return Err(Refusal::denied("Home: no such altitude"));
        }
        // To a PX4 it is above sea level whatever the frame.
        let frame = match self.settings.personality {
            Personality::Px4 => MavFrame::MAV_FRAME_GLOBAL,
            Personality::ArduPlane | Personality::Generic => command.frame,
        };
        let altitude_m = self.altitude_m("Home", command.z, frame)?;
        self.set_home_at(self.to_local(latitude_e7, longitude_e7), altitude_m);
        self.home_is_set = true;
        Ok(())
    }

    /// Makes where it is its home.
    pub(crate) fn set_home_here(&mut self) {
        let state = self.flight.state();
        self.set_home(Home { x_m: state.x_m, y_m: state.y_m, altitude_m: state.altitude_m });
    }

    /// Makes a place, (north, east) in m, its home.
    pub(crate) fn set_home_at(&mut self, (x_m, y_m): (f64, f64), altitude_m: f64) {
        self.set_home(Home { x_m, y_m, altitude_m });
    }

    /// North and east of the origin, m, of a latitude and longitude in 1e-7 degrees.
    pub(crate) fn to_local(&self, latitude_e7: i32, longitude_e7: i32) -> (f64, f64) {
        let place = Geodetic {
            latitude_deg: f64::from(latitude_e7) * 1e-7,
            longitude_deg: f64::from(longitude_e7) * 1e-7,
            altitude_amsl_m: 0.0,
        };
        let (x_m, y_m, _) = self.settings.frame.to_local(&place);
        (x_m, y_m)
    }

    /// Everybody is told of a new home, as ArduPlane does.
    fn set_home(&mut self, home: Home) {
        self.flight.set_home(home);
        self.events.push(Event::HomeMoved);
    }
}
