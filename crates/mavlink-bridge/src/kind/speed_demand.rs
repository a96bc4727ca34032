//! The airspeed that an ArduPlane in GUIDED asks of itself, by what it was told.

use crate::dialect::{MavCmd, Message};
use std::time::Duration;

/// Ten times a second the demand moves, by whole centimetres per second: it is an integer (`target_airspeed_cm` in
/// ArduPlane's navigation.cpp).
const STEPS_PER_MPS2: f64 = 10.0;
/// With which a demand of speed approaches a new one, s.
const TIME_CONSTANT_S: f64 = 4.0;
/// A rate is not that exact in single precision, steps.
const STEP_TOLERANCE: f64 = 1e-3;

/// How fast the demand of speed of an ArduPlane really moves that is told a rate, m/s2. What is left of a whole step is
/// cut off: up it is slower, and below 0.1 m/s2 it never moves; down it is faster.
pub fn demand_rate_mps2(told_mps2: f64, rises: bool) -> f64 {
    let steps = told_mps2.abs() * STEPS_PER_MPS2;
    let whole = if rises { (steps + STEP_TOLERANCE).floor() } else { (steps - STEP_TOLERANCE).ceil() };
    whole / STEPS_PER_MPS2
}

/// How fast our controller has an ArduPlane change its demand of speed by so much, m/s2: a quarter of the change in a
/// second, no faster than its model does; in whole steps, at least one.
///
/// TECS opens and closes the throttle with the rate at which its demand changes, and pitches against what follows.
/// Small changes of every tick at a constant rate, up and down, take the lift of a turn: their rate is as small as they
/// are, as far as the autopilot can move its demand that slowly.
pub fn gentle_rate_mps2(change_mps: f64, acceleration_max_mps2: f64) -> f64 {
    let rate_mps2 = (change_mps.abs() / TIME_CONSTANT_S).min(acceleration_max_mps2);
    (rate_mps2 * STEPS_PER_MPS2).round().max(1.0) / STEPS_PER_MPS2
}

/// What an ArduPlane is told so that its demand moves at a rate of whole steps, m/s2: half a step from where it would
/// move at another one.
pub(super) fn told_rate_mps2(rate_mps2: f64, rises: bool) -> f64 {
    let half = if rises { 0.5 } else { -0.5 };
    ((rate_mps2 * STEPS_PER_MPS2).round() + half) / STEPS_PER_MPS2
}

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
    /// Infinite: at once.
    acceleration_mps2: f64,
}

impl SpeedDemand {
    /// The demand at a time, m/s; none before a speed was told.
    pub fn at(&self, now: Duration) -> Option<f64> {
        let told = self.told?;
        if told.acceleration_mps2.is_infinite() {
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
                let told_mps2 = f64::from(data.param3);
                let rises = goal_mps > from_mps;
                let acceleration_mps2 =
                    if told_mps2 == 0.0 { f64::INFINITY } else { demand_rate_mps2(told_mps2, rises) };
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
    fn a_rate_is_whole_steps() {
        // Recorded of an ArduPlane 4.7: told 0.092 m/s2 its demand stood still, told 0.162 and 0.189 it rose by 0.1,
        // told -0.301 it fell by 0.4.
        for (told_mps2, rises, moves_mps2) in [
            (0.092, true, 0.0),
            (0.162, true, 0.1),
            (0.189, true, 0.1),
            (0.301, false, 0.4),
            (f64::from(0.3_f32), true, 0.3),
            (f64::from(0.3_f32), false, 0.3),
        ] {
            assert_eq!(demand_rate_mps2(told_mps2, rises), moves_mps2, "{told_mps2} {rises}");
        }
        for rate_mps2 in [0.1, 0.2, 0.4, 1.0] {
            for rises in [true, false] {
                let told_mps2 = told_rate_mps2(rate_mps2, rises);
                assert_eq!(demand_rate_mps2(told_mps2, rises), rate_mps2);
                // Its tenth of a second is counted in milliseconds.
                assert_eq!(demand_rate_mps2(told_mps2 * 1.03, rises), rate_mps2);
                assert_eq!(demand_rate_mps2(told_mps2 * 0.97, rises), rate_mps2);
            }
        }
        assert_eq!(
            [gentle_rate_mps2(0.02, 0.4), gentle_rate_mps2(-0.8, 0.4), gentle_rate_mps2(3.0, 0.4)],
            [0.1, 0.2, 0.4]
        );
    }

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
        demand.tell(&speed(18.0, 0.2), Duration::from_secs(20));
        assert_eq!(demand.at(Duration::from_secs(25)), Some(21.0));
        demand.tell(&speed(23.0, 0.09), Duration::from_secs(25));
        assert_eq!(demand.at(Duration::from_secs(99)), Some(21.0), "less than a step");
        demand.tell(&speed(19.0, 0.0), Duration::from_secs(99));
        assert_eq!(demand.at(Duration::from_secs(99)), Some(19.0), "zero: at once");
    }
}
