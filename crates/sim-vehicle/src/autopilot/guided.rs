//! Guided commands and changes of the mode.

use crate::autopilot::Autopilot;
use crate::autopilot::input::{ALTITUDE_MAX_M, angle_rad, check_finite, integer};
use crate::error::{CommandError, Severity};
use crate::firmware::rules::CommandSet;
use crate::mode::Mode;
use crate::parameters::table::Parameter;
use mavlink_bridge::AltitudeDatum;
use mavlink_bridge::kind::demand_rate_mps2;

/// A limit of zero means none.
fn limit_or_none(limit: f32) -> f64 {
    if limit == 0.0 { f64::INFINITY } else { f64::from(limit.abs()) }
}

impl Autopilot {
    /// Sets a mode. AUTO needs a mission: without one an ArduPlane returns.
    pub(crate) fn enter(&mut self, mode: Mode) -> Result<(), CommandError> {
        let has_nothing_to_fly = mode == Mode::Auto && !self.mission.is_flyable();
        if has_nothing_to_fly && !self.rules.returns_without_mission {
            return Err(CommandError::failed("Auto: no mission"));
        }
        if let Some(reason) = self.session.fence.forbids_mode(mode, &self.situation()) {
            return Err(CommandError::failed(reason));
        }
        if has_nothing_to_fly {
            self.say(Severity::Info, "Mission complete, changing mode to RTL");
            self.set_mode(Mode::Rtl);
        } else {
            self.set_mode(mode);
        }
        Ok(())
    }

    /// Params 1 and 2: the first and the last item to fly, which ArduPlane does not let choose either.
    pub(crate) fn start_mission(&mut self, first_and_last: [f32; 2]) -> Result<(), CommandError> {
        if first_and_last != [0.0, 0.0] {
            return Err(CommandError::denied("Mission: first and last item must be 0"));
        }
        self.try_to_enter(Mode::Auto)
    }

    /// Sets a mode for a command by which an ArduPlane is not told whether it did so: one that cannot be set is said,
    /// and the command accepted all the same.
    pub(crate) fn try_to_enter(&mut self, mode: Mode) -> Result<(), CommandError> {
        let outcome = self.enter(mode);
        if self.rules.commands != CommandSet::ArduPlane {
            return outcome;
        }
        if let Err(CommandError { severity, reason: Some(reason), .. }) = outcome {
            self.say(severity, &reason);
        }
        Ok(())
    }

    /// Param 1: the item. Param 2: 1 to begin counting jumps anew.
    pub(crate) fn set_current_mission_item(&mut self, [seq, reset]: [f32; 2]) -> Result<(), CommandError> {
        check_finite("Mission", &[seq])?;
        self.set_current_item(u16::try_from(integer(seq)).unwrap_or(u16::MAX), reset == 1.0)?;
        self.tell_chosen_item();
        Ok(())
    }

    pub(crate) fn check_guided_command(&self, name: &str) -> Result<(), CommandError> {
        match self.mode() {
            Mode::Guided => Ok(()),
            other => Err(CommandError::failed(format!("{name}: mode is {other}"))),
        }
    }

    pub(crate) fn check_speed(&self, speed_mps: f32) -> Result<(), CommandError> {
        let (least, most) = (self.parameters.get(Parameter::AirspeedMin), self.parameters.get(Parameter::AirspeedMax));
        if (least..=most).contains(&speed_mps) {
            Ok(())
        } else {
            let range = format!("[{least}, {most}]");
            Err(CommandError::failed(format!("Speed {speed_mps} m/s is outside {range}")))
        }
    }

    /// Param 1: type, only airspeed (0). Param 2: m/s. Param 3: acceleration in m/s2, 0 for at once, its sign ignored.
    /// An ArduPlane moves its demand by whole centimetres per second ten times a second.
    pub(crate) fn guided_speed(&mut self, [kind, speed_mps, acceleration_mps2]: [f32; 3]) -> Result<(), CommandError> {
        self.check_guided_command("Speed")?;
        check_finite("Speed", &[kind, speed_mps, acceleration_mps2])?;
        if integer(kind) != 0 {
            return Err(CommandError::denied("Speed: only airspeed can be set"));
        }
        self.check_speed(speed_mps)?;
        self.restart_setpoint_timeout();
        // A repeat is accepted and changes nothing, not even the acceleration.
        if self.flight.speed_target_mps() != f64::from(speed_mps) {
            self.approach_speed(f64::from(speed_mps), f64::from(acceleration_mps2.abs()));
        }
        Ok(())
    }

    /// An acceleration of zero: none was given.
    fn approach_speed(&mut self, speed_mps: f64, acceleration_mps2: f64) {
        if acceleration_mps2 == 0.0 {
            self.flight.set_speed_as_led(speed_mps);
        } else if self.rules.commands == CommandSet::ArduPlane {
            let rises = speed_mps > self.flight.speed_demand_mps();
            self.flight.set_speed(speed_mps, demand_rate_mps2(acceleration_mps2, rises));
        } else {
            self.flight.set_speed(speed_mps, acceleration_mps2);
        }
    }

    /// z: m, above what the frame says. Param 3: rate in m/s, 0 for as fast as it flies.
    pub(crate) fn guided_altitude(&mut self, rate_mps: f32, z: f32, frame: u8) -> Result<(), CommandError> {
        self.check_guided_command("Altitude")?;
        check_finite("Altitude", &[rate_mps])?;
        let altitude_m = self.guided_altitude_m("Altitude", z, frame)?;
        self.flight.slew_altitude(altitude_m, limit_or_none(rate_mps));
        self.restart_setpoint_timeout();
        Ok(())
    }

    /// An altitude of a guided command, in m above the origin.
    pub(crate) fn guided_altitude_m(&self, name: &str, z: f32, frame: u8) -> Result<f64, CommandError> {
        check_finite(name, &[z])?;
        if z == 0.0 || z == -1.0 {
            return Err(CommandError::denied(format!("{name}: {z} m is not accepted")));
        }
        self.altitude_m(name, z, frame)
    }

    /// An altitude that a command gives, in m above the origin: terrain is as high as home.
    pub(crate) fn altitude_m(&self, name: &str, z: f32, frame: u8) -> Result<f64, CommandError> {
        if z.abs() >= ALTITUDE_MAX_M {
            return Err(CommandError::denied(format!("{name}: {z:e} m is no altitude")));
        }
        let datum = AltitudeDatum::of_frame(frame)
            .ok_or_else(|| CommandError::denied(format!("{name}: frame {frame} is not accepted")))?;
        Ok(self.reference().above_origin_m(datum, f64::from(z)))
    }

    /// Param 1: course over ground (0), heading (1), or neither any more (2). Param 2: degrees. Param 3: greatest
    /// lateral acceleration in m/s2, at least 0.05, and never more than the vehicle's own limit.
    pub(crate) fn guided_heading(&mut self, [kind, course_deg, lateral_mps2]: [f32; 3]) -> Result<(), CommandError> {
        self.check_guided_command("Heading")?;
        check_finite("Heading", &[kind, course_deg, lateral_mps2])?;
        if !(0.0..360.0).contains(&course_deg) {
            return Err(CommandError::denied(format!("Heading {course_deg} is outside [0, 360)")));
        }
        match integer(kind) {
            0 => self.flight.set_course(angle_rad(course_deg), f64::from(lateral_mps2).max(0.05)),
            1 => self.flight.set_heading(angle_rad(course_deg), f64::from(lateral_mps2).max(0.05)),
            2 => self.flight.release_course(),
            other => return Err(CommandError::denied(format!("Heading: type {other} is not accepted"))),
        }
        self.restart_setpoint_timeout();
        Ok(())
    }

    /// Param 1: altitude in m. Param 2: the frame that says above what. While a GUIDED_CHANGE_ALTITUDE is flown, and in
    /// the modes of the sticks, it is accepted and has no effect, as in ArduPlane.
    pub(crate) fn change_altitude(&mut self, [altitude_m, frame]: [f32; 2]) -> Result<(), CommandError> {
        check_finite("Altitude", &[altitude_m, frame])?;
        let number = u8::try_from(integer(frame)).ok().filter(|number| AltitudeDatum::of_frame(*number).is_some());
        let frame = number.ok_or_else(|| CommandError::denied(format!("Altitude: frame {frame} is not accepted")))?;
        let altitude_m = self.altitude_m("Altitude", altitude_m, frame)?;
        // The modes of the sticks fly to no altitude that they are told.
        if !self.flight.is_altitude_slewed() && !self.mode().is_manual() {
            self.flight.set_altitude(altitude_m, f64::INFINITY);
            self.restart_setpoint_timeout();
        }
        Ok(())
    }

    /// DO_CHANGE_SPEED, in GUIDED and AUTO.
    pub(crate) fn change_speed(&mut self, params: [f32; 3]) -> Result<(), CommandError> {
        if self.mode() != Mode::Auto {
            self.check_guided_command("Speed")?;
        }
        check_finite("Speed", &params[..2])?;
        self.change_speed_as_arduplane(params)
    }

    /// Param 1: airspeed (0), ground speed (1), or others, which an ArduPlane has not. Param 2: m/s, or -2 for
    /// AIRSPEED_CRUISE; a ground speed is the least one that it flies, as far as its airspeed may rise. Param 3: a
    /// throttle in percent, which is accepted where there is no speed, and has no effect on how this flight model
    /// flies.
    pub(crate) fn change_speed_as_arduplane(
        &mut self,
        [kind, speed_mps, throttle]: [f32; 3],
    ) -> Result<(), CommandError> {
        let refused = match integer(kind) {
            0 if speed_mps == -2.0 => {
                let usual_mps = self.parameters.get(Parameter::AirspeedCruise);
                self.flight.set_speed(f64::from(usual_mps), f64::INFINITY);
                return Ok(());
            }
            0 => match self.check_speed(speed_mps) {
                Ok(()) => {
                    self.flight.set_speed(f64::from(speed_mps), f64::INFINITY);
                    self.say(Severity::Info, &format!("Set airspeed {speed_mps:.0} m/s"));
                    return Ok(());
                }
                Err(refusal) => refusal,
            },
            1 => {
                self.flight.set_least_ground_speed(f64::from(speed_mps));
                self.say(Severity::Info, &format!("Set groundspeed {speed_mps:.0}"));
                return Ok(());
            }
            _ => CommandError::failed("Speed: only air and ground speed can be set"),
        };
        if throttle > 0.0 && throttle <= 100.0 {
            self.say(Severity::Info, &format!("Set throttle {throttle:.0}"));
            Ok(())
        } else {
            Err(refused)
        }
    }
}
