//! What an autopilot has told of itself: each value as it last came.

use super::place;
use flight_model::{Geodetic, LocalFrame};
use mavlink_bridge::dialect::{
    EXTENDED_SYS_STATE_DATA, GLOBAL_POSITION_INT_DATA, HEARTBEAT_DATA, LOCAL_POSITION_NED_DATA, MavLandedState,
    MavModeFlag, MavState, MavSysStatusSensor, Message, STATUSTEXT_DATA, SYS_STATUS_DATA,
};
use std::collections::VecDeque;
use std::time::Duration;

/// Words of a vehicle are remembered for so long.
const TEXTS_KEPT: usize = 8;
/// Two positions whose stamps differ by no more are of one moment, ms.
const SAME_MOMENT_MS: u32 = 250;

/// What an autopilot told last. It is changed by its own words alone.
#[derive(Debug, Default)]
pub struct Heard {
    /// When its first heartbeat came.
    pub first_heartbeat: Option<Duration>,
    /// Whether it is armed.
    pub armed: bool,
    /// HEARTBEAT.custom_mode, or CURRENT_MODE.custom_mode.
    pub custom_mode: u32,
    /// When its mode was last told.
    pub mode_heard: Option<Duration>,
    /// Whether its system status says failsafe or emergency.
    pub critical: bool,
    /// EXTENDED_SYS_STATE.
    pub landed_state: Option<MavLandedState>,
    /// Above its home, m.
    pub height_m: f64,
    /// Its home.
    pub home: Option<Geodetic>,
    /// GPS_GLOBAL_ORIGIN.
    pub origin: Option<Geodetic>,
    /// Altitude of its local origin above mean sea level, by two positions of one moment, m.
    pub local_origin_amsl_m: Option<f64>,
    /// Battery, percent.
    pub battery_percent: Option<i8>,
    /// Whether its pre-arm checks pass, where it tells.
    pub prearm_ok: Option<bool>,
    /// The last GLOBAL_POSITION_INT.
    global: Option<GLOBAL_POSITION_INT_DATA>,
    /// The last LOCAL_POSITION_NED: stamp, north, east, down.
    local: Option<(u32, [f64; 3])>,
    /// Its last words, with their time.
    texts: VecDeque<(Duration, String)>,
}

impl Heard {
    /// Takes a message; one that says nothing of these is passed over.
    pub fn hear(&mut self, message: &Message, now: Duration) {
        match message {
            Message::HEARTBEAT(data) => self.hear_heartbeat(data, now),
            Message::CURRENT_MODE(data) => self.hear_mode(data.custom_mode, now),
            Message::GLOBAL_POSITION_INT(data) if place::is_known(data) => {
                self.height_m = f64::from(data.relative_alt) * 1e-3;
                self.global = Some(data.clone());
                if let Some((global, [_, _, down_m])) = self.of_one_moment() {
                    self.local_origin_amsl_m = Some(f64::from(global.alt) * 1e-3 + down_m);
                }
            }
            Message::LOCAL_POSITION_NED(LOCAL_POSITION_NED_DATA { time_boot_ms, x, y, z, .. }) => {
                self.local = Some((*time_boot_ms, [*x, *y, *z].map(f64::from)));
            }
            Message::EXTENDED_SYS_STATE(EXTENDED_SYS_STATE_DATA { landed_state, .. }) => {
                self.landed_state = Some(*landed_state);
            }
            Message::SYS_STATUS(data) => self.hear_status(data),
            Message::HOME_POSITION(data) => self.home = Some(place::of_home(data)),
            Message::GPS_GLOBAL_ORIGIN(data) => self.origin = Some(place::of_origin(data)),
            Message::STATUSTEXT(data) => self.hear_text(data, now),
            _ => {}
        }
    }

    fn hear_mode(&mut self, custom_mode: u32, now: Duration) {
        self.custom_mode = custom_mode;
        self.mode_heard = Some(now);
    }

    fn hear_heartbeat(&mut self, data: &HEARTBEAT_DATA, now: Duration) {
        self.first_heartbeat.get_or_insert(now);
        self.armed = data.base_mode.contains(MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED);
        self.hear_mode(data.custom_mode, now);
        self.critical = matches!(data.system_status, MavState::MAV_STATE_CRITICAL | MavState::MAV_STATE_EMERGENCY);
    }

    fn hear_status(&mut self, data: &SYS_STATUS_DATA) {
        self.battery_percent = (data.battery_remaining >= 0).then_some(data.battery_remaining);
        let prearm = MavSysStatusSensor::MAV_SYS_STATUS_PREARM_CHECK;
        if data.onboard_control_sensors_present.contains(prearm) {
            self.prearm_ok = Some(data.onboard_control_sensors_health.contains(prearm));
        }
    }

    fn hear_text(&mut self, data: &STATUSTEXT_DATA, now: Duration) {
        let text = data.text.to_str().unwrap_or("").trim().to_owned();
        if text.is_empty() {
            return;
        }
        self.texts.push_back((now, text));
        if self.texts.len() > TEXTS_KEPT {
            self.texts.pop_front();
        }
    }

    /// Its last words.
    pub fn last_words(&self) -> Option<&str> {
        self.texts.back().map(|(_, text)| text.as_str())
    }

    /// Its last words since a time.
    pub fn words_since(&self, since: Duration) -> Option<&str> {
        self.texts.back().filter(|(at, _)| *at >= since).map(|(_, text)| text.as_str())
    }

    /// Where it last said that it was, WGS-84.
    pub fn place(&self) -> Option<Geodetic> {
        self.global.as_ref().map(place::of_position)
    }

    /// By how much its own two positions contradict each other, m: the global one, and the local one from its own
    /// origin.
    pub fn contradiction_m(&self) -> Option<f64> {
        let (global, [north_m, east_m, _]) = self.of_one_moment()?;
        let origin = self.origin?;
        if north_m == 0.0 && east_m == 0.0 {
            return None;
        }
        let state = place::state(global, &LocalFrame::new(origin));
        let moved_m = 1e-3 * f64::from(SAME_MOMENT_MS) * state.speed_mps;
        let off_m = libm::hypot(state.x_m - north_m, state.y_m - east_m);
        Some((off_m - moved_m).max(0.0))
    }

    fn of_one_moment(&self) -> Option<(&GLOBAL_POSITION_INT_DATA, [f64; 3])> {
        let (global, (stamp, local)) = (self.global.as_ref()?, self.local?);
        (global.time_boot_ms.abs_diff(stamp) <= SAME_MOMENT_MS).then_some((global, local))
    }
}
