//! Parameters that ArduPlane had by other names before 4.7, and what it makes of their values when it is updated
//! (`Plane::load_parameters`, PARAMETER_CONVERSION). On the wire it knows the new names alone.

use crate::parameters::renamed::Conversion::{Channel, FenceAltitude, Forgotten, Times};
use crate::parameters::renamed::Renamed;

pub(super) const RENAMED: &[Renamed] = &[
    // 4.7
    Renamed { old: "SYSID_THISMAV", new: "MAV_SYSID", conversion: Times(1.0) },
    Renamed { old: "SYSID_MYGCS", new: "MAV_GCS_SYSID", conversion: Times(1.0) },
    Renamed { old: "SYSID_ENFORCE", new: "MAV_OPTIONS", conversion: Times(1.0) },
    Renamed { old: "TELEM_DELAY", new: "MAV_TELEM_DELAY", conversion: Times(1.0) },
    // 4.5: metres and degrees in the place of their hundredths.
    Renamed { old: "TRIM_ARSPD_CM", new: "AIRSPEED_CRUISE", conversion: Times(0.01) },
    Renamed { old: "ARSPD_FBW_MIN", new: "AIRSPEED_MIN", conversion: Times(1.0) },
    Renamed { old: "ARSPD_FBW_MAX", new: "AIRSPEED_MAX", conversion: Times(1.0) },
    Renamed { old: "MIN_GNDSPD_CM", new: "MIN_GROUNDSPEED", conversion: Times(0.01) },
    Renamed { old: "LIM_ROLL_CD", new: "ROLL_LIMIT_DEG", conversion: Times(0.01) },
    Renamed { old: "LIM_PITCH_MAX", new: "PTCH_LIM_MAX_DEG", conversion: Times(0.01) },
    Renamed { old: "LIM_PITCH_MIN", new: "PTCH_LIM_MIN_DEG", conversion: Times(0.01) },
    Renamed { old: "TRIM_PITCH_CD", new: "PTCH_TRIM_DEG", conversion: Times(0.01) },
    Renamed { old: "ALT_HOLD_RTL", new: "RTL_ALTITUDE", conversion: Times(0.01) },
    Renamed { old: "ALT_HOLD_FBWCM", new: "CRUISE_ALT_FLOOR", conversion: Times(0.01) },
    Renamed { old: "GLIDE_SLOPE_MIN", new: "ALT_SLOPE_MIN", conversion: Times(1.0) },
    Renamed { old: "GLIDE_SLOPE_THR", new: "ALT_SLOPE_MAXHGT", conversion: Times(1.0) },
    // 4.1: the fence became that of all vehicles, and channels got functions.
    Renamed { old: "FENCE_MINALT", new: "FENCE_ALT_MIN", conversion: FenceAltitude { kind: 8 } },
    Renamed { old: "FENCE_MAXALT", new: "FENCE_ALT_MAX", conversion: FenceAltitude { kind: 1 } },
    Renamed { old: "FENCE_RETALT", new: "FENCE_RET_ALT", conversion: Times(1.0) },
    Renamed { old: "FENCE_CHANNEL", new: "RC#_OPTION", conversion: Channel { function: 11 } },
    Renamed { old: "RST_MISSION_CH", new: "RC#_OPTION", conversion: Channel { function: 24 } },
    Renamed { old: "RST_SWITCH_CH", new: "RC#_OPTION", conversion: Channel { function: 96 } },
    // ArduPlane takes over none of these.
    Renamed { old: "SR0_RAW_SENS", new: "MAV1_RAW_SENS", conversion: Forgotten },
    Renamed { old: "SR0_EXT_STAT", new: "MAV1_EXT_STAT", conversion: Forgotten },
    Renamed { old: "SR0_POSITION", new: "MAV1_POSITION", conversion: Forgotten },
    Renamed { old: "SR0_EXTRA1", new: "MAV1_EXTRA1", conversion: Forgotten },
    Renamed { old: "SR0_EXTRA2", new: "MAV1_EXTRA2", conversion: Forgotten },
    Renamed { old: "SR0_EXTRA3", new: "MAV1_EXTRA3", conversion: Forgotten },
    Renamed { old: "FS_BATT_VOLTAGE", new: "BATT_LOW_VOLT", conversion: Forgotten },
    Renamed { old: "FS_BATT_MAH", new: "BATT_LOW_MAH", conversion: Forgotten },
    Renamed { old: "SIM_GPS_DISABLE", new: "SIM_GPS1_ENABLE", conversion: Forgotten },
    Renamed { old: "SIM_GPS_NUMSATS", new: "SIM_GPS1_NUMSATS", conversion: Forgotten },
    Renamed { old: "SIM_GPS_NOISE", new: "SIM_GPS1_NOISE", conversion: Forgotten },
    Renamed { old: "SIM_GPS_LAG_MS", new: "SIM_GPS1_LAG_MS", conversion: Forgotten },
    Renamed { old: "SIM_ACC_RND", new: "SIM_ACC1_RND", conversion: Forgotten },
    Renamed { old: "SIM_GYR_RND", new: "SIM_GYR1_RND", conversion: Forgotten },
];
