//! A command as it is asked for, whichever message carried it.

use crate::autopilot::input::integer;
use mavlink_bridge::dialect::{MavCmd, MavFrame, MavModeFlag};
use mavlink_bridge::{CommandPosition, LatLonE7};

/// A command, whichever message carried it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Command {
    pub command: MavCmd,
    pub params: [f32; 4],
    /// Params 5 and 6, latitude and longitude.
    pub position: CommandPosition,
    /// Param 7 of COMMAND_LONG, z of COMMAND_INT.
    pub z: f32,
    /// MAV_FRAME, in the dialect or not: most commands do not read it.
    pub frame: u8,
}

impl Command {
    /// A command as it came; none if the dialect does not know it.
    pub fn read(wire: &mavlink_bridge::Command) -> Option<Self> {
        let command = wire.mav_cmd()?;
        // A COMMAND_LONG has no frame: ArduPilot reads its altitudes as above home, and home's as above sea level.
        let of_long = match command {
            MavCmd::MAV_CMD_DO_SET_HOME => MavFrame::MAV_FRAME_GLOBAL,
            _ => MavFrame::MAV_FRAME_GLOBAL_RELATIVE_ALT,
        };
        let frame = wire.frame.unwrap_or(of_long as u8);
        Some(Self { command, params: wire.params, position: wire.position, z: wire.z, frame })
    }

    /// DO_SET_MODE, for the SET_MODE message that came before it, which has a PX4's main and sub mode in one number.
    /// Modes are exact in an f32 up to 2^24; beyond that there are none.
    pub fn set_mode(has_sub_mode: bool, custom: bool, custom_mode: u32) -> Self {
        let base_mode = if custom { MavModeFlag::MAV_MODE_FLAG_CUSTOM_MODE_ENABLED.bits() } else { 0 };
        let (main, sub) = if has_sub_mode { (custom_mode >> 16 & 0xFF, custom_mode >> 24) } else { (custom_mode, 0) };
        Self {
            command: MavCmd::MAV_CMD_DO_SET_MODE,
            params: [f32::from(base_mode), main as f32, sub as f32, 0.0],
            position: CommandPosition::Long([0.0; 2]),
            z: 0.0,
            frame: MavFrame::MAV_FRAME_GLOBAL as u8,
        }
    }

    /// Params 5 and 6 as whole numbers, of a command that has no place in them.
    pub fn whole_p5_p6(&self) -> [i64; 2] {
        match self.position {
            CommandPosition::Long(params) => params.map(integer),
            CommandPosition::Int(at) => [at.latitude_e7, at.longitude_e7].map(i64::from),
        }
    }

    /// Latitude and longitude, whichever message carried them. A cast of what is too large takes the bound, which is no
    /// place, and of what is no number, 0.
    pub fn lat_lon(&self) -> LatLonE7 {
        match self.position {
            CommandPosition::Int(position) => position,
            CommandPosition::Long(degrees) => {
                let [latitude_e7, longitude_e7] = degrees.map(|degrees| (f64::from(degrees) * 1e7) as i32);
                LatLonE7 { latitude_e7, longitude_e7 }
            }
        }
    }
}
