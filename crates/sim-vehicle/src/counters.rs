//! What a vehicle has done, counted.

use std::ops::AddAssign;

/// Totals of one vehicle since its start. They add up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct VehicleCounters {
    /// Setpoint messages that were followed.
    pub setpoints_accepted: u64,
    /// Setpoint messages that could not be followed: not in GUIDED, another frame or mask, not finite.
    pub setpoints_refused: u64,
    /// Lockstep: setpoints whose stamp is not the vehicle's time (late, repeated, or wrong).
    pub setpoints_out_of_step: u64,
    /// Commands answered with ACCEPTED.
    pub commands_accepted: u64,
    /// Commands answered with anything else.
    pub commands_refused: u64,
    /// Frames addressed to other systems, or its own come back.
    pub frames_for_others: u64,
    /// Lockstep: how often it asked again.
    pub resends: u64,
    /// How often the lack of setpoints took it out of GUIDED.
    pub failsafes: u64,
}

impl AddAssign for VehicleCounters {
    fn add_assign(&mut self, other: Self) {
        self.setpoints_accepted += other.setpoints_accepted;
        self.setpoints_refused += other.setpoints_refused;
        self.setpoints_out_of_step += other.setpoints_out_of_step;
        self.commands_accepted += other.commands_accepted;
        self.commands_refused += other.commands_refused;
        self.frames_for_others += other.frames_for_others;
        self.resends += other.resends;
        self.failsafes += other.failsafes;
    }
}
