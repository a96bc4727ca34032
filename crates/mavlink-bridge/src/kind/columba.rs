//! Columba's own vehicles of no autopilot in particular (`columba vehicles --personality generic`): one setpoint
//! message for speed, course and altitude in GUIDED, take-off and landing by commands.

use super::commands::{arm, command_long, set_mode};
use super::{Launch, Seen, arduplane};
use crate::Target;
use crate::dialect::MavCmd;

const RTL: u32 = 11;
const LOITER: u32 = 12;
const LAND: u32 = 9;

/// Loiter, return, land.
pub(super) const END_MODES: [u32; 3] = [LOITER, RTL, LAND];

/// A take-off is over at this share of its height.
const TAKEN_OFF_SHARE: f64 = 0.8;

pub(super) fn launch(target: Target, seen: &Seen, height_m: f64) -> Launch {
    if !seen.armed {
        return Launch::Send(arm(target));
    }
    if seen.on_ground {
        let params = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, height_m as f32];
        return Launch::Send(command_long(target, MavCmd::MAV_CMD_NAV_TAKEOFF, params));
    }
    if seen.custom_mode == arduplane::GUIDED {
        return Launch::Flying;
    }
    if seen.height_m < TAKEN_OFF_SHARE * height_m && seen.climb_mps > 0.3 {
        return Launch::Wait;
    }
    Launch::Send(set_mode(target, arduplane::GUIDED))
}
