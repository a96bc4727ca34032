//! The airspeed that an ArduPlane in GUIDED asks of itself, by what it was told.

use crate::dialect::{MavCmd, Message};
use std::time::Duration;

/// A demand that moves to the speed that was told last, at the rate that was told with it.
#[derive(Clone, Copy, Debug, Default)]
pub struct SpeedDemand {
    told: Option<Told>,
}

#[derive(Clone, Copy, Debug)]
struct Told {
    at: Duration,
    from_mps: f64,
    goal_mps: f64,
    /// Zero: at once.
    acceleration_mps2: f64,
}

impl SpeedDemand {
    /// The demand at a time, m/s; none before a speed was told.
    pub fn at(&self, now: Duration) -> Option<f64> {
        let told = self.told?;
        if told.acceleration_mps2 == 0.0 {
            return Some(told.goal_mps);
        }
        let moved_mps = told.acceleration_mps2 * now.saturating_sub(told.at).as_secs_f64();
        Some(told.from_mps + (told.goal_mps - told.from_mps).max(-moved_mps).min(moved_mps))
    }

    /// Takes note of messages that are sent now. The autopilot takes no new rate for the same speed.
    pub fn tell(&mut self, messages: &[Message], now: Duration) {
        for message in messages {
            let Message::COMMAND_INT(data) = message else { continue };
            let goal_mps = f64::from(data.param2);
            let is_new = self.told.is_none_or(|told| told.goal_mps != goal_mps);
            if data.command == MavCmd::MAV_CMD_GUIDED_CHANGE_SPEED && is_new {
                let from_mps = self.at(now).unwrap_or(goal_mps);
                let acceleration_mps2 = f64::from(data.param3).abs();
                self.told = Some(Told { at: now, from_mps, goal_mps, acceleration_mps2 });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::command_int;
    use super::*;
    use crate::Target;
    use crate::dialect::MavFrame;

    #[test]
    fn a_demand_moves_at_the_rate_that_was_told() {
        let target = Target { system_id: 1, component_id: 1 };
        let speed = |speed_mps, acceleration_mps2| {
            let params = [0.0, speed_mps, acceleration_mps2, 0.0];
            [command_int(target, MavCmd::MAV_CMD_GUIDED_CHANGE_SPEED, MavFrame::MAV_FRAME_GLOBAL, params, (0, 0, 0.0))]
        };
        let mut demand = SpeedDemand::default();
        assert_eq!(demand.at(Duration::ZERO), None);
        demand.tell(&speed(20.0, 0.5), Duration::from_secs(1));
        assert_eq!(demand.at(Duration::from_secs(1)), Some(20.0), "nobody knows what it was");
        demand.tell(&speed(22.0, 0.5), Duration::from_secs(10));
        assert_eq!(demand.at(Duration::from_secs(12)), Some(21.0));
        demand.tell(&speed(22.0, 0.1), Duration::from_secs(12));
        assert_eq!(demand.at(Duration::from_secs(20)), Some(22.0), "the first rate holds for the same speed");
        demand.tell(&speed(18.0, 0.25), Duration::from_secs(20));
        assert_eq!(demand.at(Duration::from_secs(24)), Some(21.0));
        demand.tell(&speed(19.0, 0.0), Duration::from_secs(24));
        assert_eq!(demand.at(Duration::from_secs(24)), Some(19.0), "zero: at once");
    }
}
