//! What an autopilot says of what it does by itself, in its own words.

use crate::autopilot::arming::Cause;
use crate::autopilot::fence::kinds::{CIRCLE, Kinds, MAX_ALTITUDE, POLYGON};

/// The words of one autopilot.
#[derive(Debug)]
pub(crate) struct Words {
    pub armed: fn(Cause) -> &'static str,
    pub disarmed: fn(Cause) -> &'static str,
    /// What follows when a landing has disarmed it.
    pub disarmed_after_landing: Option<&'static str>,
    /// That it has left the ground, and that it is back on it.
    pub contact: Option<[&'static str; 2]>,
    /// That a mission begins.
    pub mission_begins: Option<&'static str>,
    /// That it returns: at which altitude, in whole metres above the sea and above where it returns to.
    pub returns: Option<fn(i64, i64) -> String>,
    /// That a fence of a kind is breached, and that what follows has begun; none: all kinds in one line, and when they
    /// are breached no more.
    pub breach: Option<[(Kinds, &'static str); 3]>,
    pub failsafe: Option<&'static str>,
    /// That a return is over.
    pub returned: Option<&'static str>,
    /// Whether each item of a mission is told when it begins and when it ends.
    pub narrates_missions: bool,
    /// That a mission is over: why, whether it is on the ground, and the name of the mode that follows.
    pub mission_ends: fn(&str, bool, &str) -> String,
}

pub(super) const ARDUPLANE: Words = Words {
    armed: |_| "Throttle armed",
    disarmed: |_| "Throttle disarmed",
    disarmed_after_landing: Some("Auto disarmed"),
    contact: None,
    mission_begins: None,
    returns: None,
    breach: None,
    failsafe: None,
    returned: None,
    narrates_missions: true,
    mission_ends: |why, _, next| format!("{why}, changing mode to {next}"),
};

/// `Commander.cpp`, `mission_base.cpp`, `geofenceCheck.cpp` and `rtl_direct.cpp`.
pub(super) const PX4: Words = Words {
    armed: |cause| match cause {
        Cause::MissionStart => "Armed by mission start",
        Cause::Command | Cause::Landing | Cause::Parachute | Cause::Idle => "Armed by external command",
    },
    disarmed: |cause| match cause {
        Cause::Landing => "Disarmed by landing",
        Cause::Idle => "Disarmed by auto preflight disarming",
        Cause::Command | Cause::MissionStart | Cause::Parachute => "Disarmed by external command",
    },
    disarmed_after_landing: None,
    contact: Some(["Takeoff detected", "Landing detected"]),
    mission_begins: Some("Executing Mission"),
    returns: Some(|sea_m, above_m| format!("RTL: start return at {sea_m} m ({above_m} m above destination)")),
    breach: Some([
        (CIRCLE, "Geofence: exceeding maximum distance to Home"),
        (MAX_ALTITUDE, "Geofence: exceeding maximum altitude above Home"),
        (POLYGON, "Geofence: approaching or outside geofence"),
    ]),
    failsafe: Some("Failsafe activated"),
    returned: Some("RTL: completed, loitering"),
    narrates_missions: false,
    mission_ends: |why, is_on_ground, _| {
        let text = match (why == crate::autopilot::MISSION_COMPLETE, is_on_ground) {
            (true, true) => "Mission finished, landed",
            (true, false) => "Mission finished, loitering",
            (false, _) => "No valid mission available, loitering",
        };
        text.into()
    },
};
