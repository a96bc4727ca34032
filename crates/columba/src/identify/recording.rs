//! Commands and responses of one vehicle, from a tlog.
//!
//! Times are those of the vehicle's own stamps. A command has the time at which the log has it, on the vehicle's clock:
//! that of the telemetry that came with the least delay. So a dead time includes the delay of the link, both ways.

use flight_model::wrap_pi;
use mavlink_bridge::dialect::{ATTITUDE_DATA, GLOBAL_POSITION_INT_DATA, MavCmd, MavFrame, MavResult, Message};
use mavlink_bridge::{AltitudeDatum, TlogRecord};
use std::collections::BTreeMap;

/// How a vehicle moved at one moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// The vehicle's time, s.
    pub t_s: f64,
    /// Speed over ground, m/s.
    pub speed_mps: f64,
    /// Course over ground, rad.
    pub course_rad: f64,
    /// Above mean sea level, m.
    pub altitude_m: f64,
    /// Rate of climb, m/s.
    pub climb_mps: f64,
}

/// Values of one setpoint, each from its time in s on: only changes, in order of time.
pub type Commands = Vec<(f64, f64)>;

/// A vehicle's flight.
#[derive(Clone, Debug, Default)]
pub struct Recording {
    /// In order of time.
    pub samples: Vec<Sample>,
    /// The vehicle's time, s, and its bank, rad, in order of time.
    pub banks: Vec<(f64, f64)>,
    /// Speed setpoints, m/s.
    pub speed: Commands,
    /// Course setpoints, rad.
    pub course: Commands,
    /// Altitude setpoints, m above mean sea level.
    pub altitude: Commands,
    /// Commands that the vehicle refused.
    pub refused: usize,
    /// Whether it is an aircraft with wings.
    pub has_wings: bool,
    /// Log time and vehicle time of every sample, s.
    stamps: Vec<(f64, f64)>,
    home_amsl_m: f64,
}

/// Telemetry this near to a command tells the vehicle's time, s.
const NEAR_S: f64 = 4.0;

/// A ground station that turns ground speeds into airspeeds has them tremble: within this they are one setpoint, m/s.
const SAME_SPEED_MPS: f64 = 0.35;

/// What a setpoint is of.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Part {
    Speed,
    Course,
    Altitude,
}

impl Recording {
    /// Whether it was told anything.
    pub fn is_commanded(&self) -> bool {
        let is_told = [&self.speed, &self.course, &self.altitude].iter().any(|commands| !commands.is_empty());
        is_told && !self.samples.is_empty()
    }

    /// Positions a second; none of fewer than two.
    pub fn rate_hz(&self) -> Option<f64> {
        let (first, last) = (self.samples.first()?, self.samples.last()?);
        let time_s = last.t_s - first.t_s;
        (time_s > 0.0).then(|| (self.samples.len() - 1) as f64 / time_s)
    }

    fn hear(&mut self, data: &GLOBAL_POSITION_INT_DATA, at_s: f64) {
        let t_s = f64::from(data.time_boot_ms) * 1e-3;
        if self.samples.last().is_some_and(|last| t_s <= last.t_s) {
            return; // heard on a second link, or out of order
        }
        let (north_mps, east_mps) = (0.01 * f64::from(data.vx), 0.01 * f64::from(data.vy));
        let altitude_m = 1e-3 * f64::from(data.alt);
        self.home_amsl_m = altitude_m - 1e-3 * f64::from(data.relative_alt);
        self.stamps.push((at_s, t_s));
        self.samples.push(Sample {
            t_s,
            speed_mps: libm::hypot(north_mps, east_mps),
            course_rad: libm::atan2(east_mps, north_mps),
            altitude_m,
            climb_mps: -0.01 * f64::from(data.vz),
        });
    }

    fn hear_attitude(&mut self, data: &ATTITUDE_DATA) {
        let (t_s, bank_rad) = (f64::from(data.time_boot_ms) * 1e-3, f64::from(data.roll));
        if bank_rad.is_finite() && self.banks.last().is_none_or(|(last_s, _)| t_s > *last_s) {
            self.banks.push((t_s, bank_rad));
        }
    }

    fn part(&mut self, part: Part) -> &mut Commands {
        match part {
            Part::Speed => &mut self.speed,
            Part::Course => &mut self.course,
            Part::Altitude => &mut self.altitude,
        }
    }

    fn command(&mut self, part: Part, at_s: f64, value: f64) {
        if value.is_finite() {
            self.part(part).push((at_s, value));
        }
    }

    fn obey_command(&mut self, command: MavCmd, frame: MavFrame, params: [f32; 2], z_m: f32, at_s: f64) {
        let [p1, p2] = params.map(f64::from);
        match command {
            MavCmd::MAV_CMD_GUIDED_CHANGE_SPEED | MavCmd::MAV_CMD_DO_CHANGE_SPEED if p1 == 0.0 => {
                self.command(Part::Speed, at_s, p2);
            }
            MavCmd::MAV_CMD_GUIDED_CHANGE_HEADING if p1 == 0.0 => self.command(Part::Course, at_s, p2.to_radians()),
            MavCmd::MAV_CMD_GUIDED_CHANGE_ALTITUDE => {
                let amsl_m = self.amsl_m(frame, f64::from(z_m));
                self.command(Part::Altitude, at_s, amsl_m);
            }
            MavCmd::MAV_CMD_DO_CHANGE_ALTITUDE => self.command(Part::Altitude, at_s, p1),
            _ => {}
        }
    }

    fn amsl_m(&self, frame: MavFrame, z_m: f64) -> f64 {
        match AltitudeDatum::of_frame(frame as u32 as u8) {
            Some(AltitudeDatum::MeanSeaLevel) => z_m,
            _ => self.home_amsl_m + z_m,
        }
    }

    /// A target of velocity: a speed and a course. Its height is taken where the mask has it.
    fn obey_target(&mut self, mask: u16, velocity_mps: [f32; 2], altitude_m: Option<f64>, at_s: f64) {
        const NO_HEIGHT: u16 = 1 << 2;
        const NO_VELOCITY: u16 = 0b11 << 3;
        let [north_mps, east_mps] = velocity_mps.map(f64::from);
        if mask & NO_VELOCITY == 0 {
            let speed_mps = libm::hypot(north_mps, east_mps);
            self.command(Part::Speed, at_s, speed_mps);
            if speed_mps > 0.1 {
                self.command(Part::Course, at_s, libm::atan2(east_mps, north_mps));
            }
        }
        if let Some(altitude_m) = altitude_m.filter(|_| mask & NO_HEIGHT == 0) {
            self.command(Part::Altitude, at_s, altitude_m);
        }
    }

    fn refuse(&mut self, command: MavCmd) {
        let part = match command {
            MavCmd::MAV_CMD_GUIDED_CHANGE_SPEED | MavCmd::MAV_CMD_DO_CHANGE_SPEED => Part::Speed,
            MavCmd::MAV_CMD_GUIDED_CHANGE_HEADING => Part::Course,
            MavCmd::MAV_CMD_GUIDED_CHANGE_ALTITUDE | MavCmd::MAV_CMD_DO_CHANGE_ALTITUDE => Part::Altitude,
            _ => return,
        };
        if self.part(part).pop().is_some() {
            self.refused += 1;
        }
    }

    /// Brings commands onto the vehicle's clock, and leaves only those that change something.
    fn settle(&mut self) {
        let (Some(&first), Some(&last)) = (self.stamps.first(), self.stamps.last()) else { return };
        let rate = if last.1 > first.1 { (last.0 - first.0) / (last.1 - first.1) } else { 1.0 };
        // A clock that is as fast as that of the log, but for a drift and what jitters, is as fast.
        let rate = if (rate - 1.0).abs() < 5e-3 { 1.0 } else { rate };
        let stamps = std::mem::take(&mut self.stamps);
        // The least delay near a time: over the whole flight, a simulator that slips would be taken for a link.
        let offset_s = |at_s: f64| {
            let near = |by_s: f64| stamps.partition_point(|(heard_s, _)| *heard_s < at_s + by_s);
            let (first, end) = (near(-NEAR_S), near(NEAR_S));
            let (first, end) = if first < end { (first, end) } else { (0, stamps.len()) };
            stamps[first..end].iter().map(|(heard_s, t_s)| heard_s - rate * t_s).fold(f64::INFINITY, f64::min)
        };
        for part in [Part::Speed, Part::Course, Part::Altitude] {
            let commands = std::mem::take(self.part(part));
            let mut kept: Commands = Vec::new();
            // The first value of those that are one setpoint, and how many they are.
            let mut same = (f64::NAN, 0.0);
            for (at_s, value) in commands {
                let is_same = match part {
                    Part::Course => wrap_pi(value - same.0).abs() < 1e-4,
                    Part::Speed => (value - same.0).abs() < SAME_SPEED_MPS,
                    Part::Altitude => (value - same.0).abs() < 1e-3,
                };
                if let Some((_, mean)) = kept.last_mut().filter(|_| is_same) {
                    same.1 += 1.0;
                    if part == Part::Speed {
                        *mean += (value - *mean) / same.1;
                    }
                } else {
                    same = (value, 1.0);
                    kept.push(((at_s - offset_s(at_s)) / rate, value));
                }
            }
            *self.part(part) = kept;
        }
    }
}

/// Every vehicle of a log, by its system id.
pub fn read<'a>(records: impl IntoIterator<Item = &'a TlogRecord>) -> BTreeMap<u8, Recording> {
    let mut vehicles: BTreeMap<u8, Recording> = BTreeMap::new();
    for record in records {
        let Ok(frame) = record.frame() else { continue };
        let Ok(message) = frame.message() else { continue };
        let at_s = record.at_us as f64 * 1e-6;
        let sender = frame.header.system_id;
        match &message {
            Message::GLOBAL_POSITION_INT(data) => vehicles.entry(sender).or_default().hear(data, at_s),
            Message::ATTITUDE(data) => vehicles.entry(sender).or_default().hear_attitude(data),
            Message::HEARTBEAT(data) => {
                use mavlink_bridge::dialect::MavType;
                if data.mavtype == MavType::MAV_TYPE_FIXED_WING {
                    vehicles.entry(sender).or_default().has_wings = true;
                }
            }
            Message::COMMAND_ACK(data) => {
                let is_refused =
                    !matches!(data.result, MavResult::MAV_RESULT_ACCEPTED | MavResult::MAV_RESULT_IN_PROGRESS);
                if let Some(vehicle) = vehicles.get_mut(&sender).filter(|_| is_refused) {
                    vehicle.refuse(data.command);
                }
            }
            Message::COMMAND_INT(data) => {
                if let Some(vehicle) = vehicles.get_mut(&data.target_system) {
                    vehicle.obey_command(data.command, data.frame, [data.param1, data.param2], data.z, at_s);
                }
            }
            Message::COMMAND_LONG(data) => {
                if let Some(vehicle) = vehicles.get_mut(&data.target_system) {
                    let above_home = MavFrame::MAV_FRAME_GLOBAL_RELATIVE_ALT;
                    vehicle.obey_command(data.command, above_home, [data.param1, data.param2], data.param7, at_s);
                }
            }
            Message::SET_POSITION_TARGET_LOCAL_NED(data) => {
                if let Some(vehicle) = vehicles.get_mut(&data.target_system) {
                    // The local frame's origin is home, but for a constant: only changes count.
                    let altitude_m = vehicle.home_amsl_m - f64::from(data.z);
                    vehicle.obey_target(data.type_mask.bits(), [data.vx, data.vy], Some(altitude_m), at_s);
                }
            }
            Message::SET_POSITION_TARGET_GLOBAL_INT(data) => {
                if let Some(vehicle) = vehicles.get_mut(&data.target_system) {
                    let altitude_m = vehicle.amsl_m(data.coordinate_frame, f64::from(data.alt));
                    vehicle.obey_target(data.type_mask.bits(), [data.vx, data.vy], Some(altitude_m), at_s);
                }
            }
            _ => {}
        }
    }
    vehicles.values_mut().for_each(Recording::settle);
    vehicles
}
