//! Home: where it is, who sets it, and altitudes above it.

use crate::autopilot::flight::Home;
use crate::protocol::command::{ALTITUDE_MAX_M, Command, Refusal, check_finite};
use crate::telemetry::streams::Stream;
use crate::vehicle::Vehicle;
use mavlink_bridge::{CommandPosition, LatLonE7};

impl Vehicle {
    /// DO_SET_HOME. Param 1: 1 for where it is, or 0 for the place that comes with it; one of no latitude and longitude
    /// means where it is, too.
    pub(crate) fn do_set_home(&mut self, command: &Command) -> Result<(), Refusal> {
        let [p1, ..] = command.params;
        check_finite("Home", &[p1])?;
        if let CommandPosition::Long(degrees) = command.position
            && p1 != 1.0
        {
            check_finite("Home", &degrees)?;
        }
        let position = command.lat_lon();
        if p1 == 1.0 || position.is_zero() {
            self.set_home_here();
            self.home_is_set = true;
            return Ok(());
        }
        if p1 != 0.0 {
            return Err(Refusal::failed("Home: param 1 is neither 0 nor 1"));
        }
        if !position.is_valid() {
            return Err(Refusal::failed("Home: no such place"));
        }
        if command.z.is_nan() || command.z.abs() >= ALTITUDE_MAX_M {
            return Err(Refusal::denied("Home: no such altitude"));
        }
        let altitude_m = self.altitude_m("Home", command.z, command.frame)?;
        self.set_home_at(self.to_local(position), altitude_m);
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

    /// North and east of the origin, m, of a latitude and longitude.
    pub(crate) fn to_local(&self, position: LatLonE7) -> (f64, f64) {
        let (x_m, y_m, _) = self.settings.frame.to_local(&position.to_geodetic(0.0));
        (x_m, y_m)
    }

    /// Everybody is told of a new home, as ArduPlane does.
    fn set_home(&mut self, home: Home) {
        self.flight.set_home(home);
        self.send_stream_to_all(Stream::HomePosition);
    }
}
