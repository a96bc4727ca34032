//! PX4's names and types of the parameters. A parameter that PX4 has nothing like keeps its name and is read as a float
//! or as an integer of 32 bits, the only types that PX4 has.

use crate::parameters::table::Parameter;
use mavlink_bridge::dialect::MavParamType::{self, MAV_PARAM_TYPE_INT32 as INT32, MAV_PARAM_TYPE_REAL32 as REAL};

/// Parameters that a PX4 has not: its own failsafes and checks stand in for them, its rates are asked for by message,
/// and any ground station counts.
pub(in crate::firmware) const ABSENT_PARAMETERS: &[Parameter] = &[
    Parameter::GroundSystemId,
    Parameter::RateRawSensors,
    Parameter::RateExtendedStatus,
    Parameter::RatePosition,
    Parameter::RateExtra1,
    Parameter::RateExtra2,
    Parameter::RateExtra3,
    Parameter::RtlRadius,
    Parameter::ReturnClimb,
    Parameter::LevelRollLimit,
    Parameter::FlightOptions,
    Parameter::ParachuteEnabled,
    Parameter::ArmingCheck,
    Parameter::ThrottleFailsafe,
    Parameter::ThrottleFailsafeValue,
    Parameter::OverrideTime,
    Parameter::RudderArming,
    Parameter::ShortFailsafeAction,
    Parameter::ReceiverFail,
    Parameter::RollReversed,
    Parameter::PitchReversed,
    Parameter::ThrottleReversed,
    Parameter::ChannelFunction1,
    Parameter::ChannelFunction2,
    Parameter::ChannelFunction3,
    Parameter::ChannelFunction4,
    Parameter::ChannelFunction5,
    Parameter::ChannelFunction6,
    Parameter::ChannelFunction7,
    Parameter::ChannelFunction8,
    Parameter::ChannelFunction9,
    Parameter::ChannelFunction10,
    Parameter::ChannelFunction11,
    Parameter::ChannelFunction12,
    Parameter::ChannelFunction13,
    Parameter::ChannelFunction14,
    Parameter::ChannelFunction15,
    Parameter::ChannelFunction16,
    Parameter::FlightModeChannel,
    Parameter::FlightMode1,
    Parameter::FlightMode2,
    Parameter::FlightMode3,
    Parameter::FlightMode4,
    Parameter::FlightMode5,
    Parameter::FlightMode6,
    Parameter::BootCount,
    Parameter::GuidedTimeout,
    Parameter::GroundFailsafe,
    Parameter::LongFailsafeAction,
    Parameter::LongFailsafeTimeout,
];

const NAMES: &[(Parameter, &str, MavParamType)] = &[
    (Parameter::SystemId, "MAV_SYS_ID", INT32),
    (Parameter::AirspeedCruise, "FW_AIRSPD_TRIM", REAL),
    (Parameter::AirspeedMin, "FW_AIRSPD_MIN", REAL),
    (Parameter::AirspeedMax, "FW_AIRSPD_MAX", REAL),
    (Parameter::RollLimit, "FW_R_LIM", REAL),
    (Parameter::ClimbMax, "FW_T_CLMB_MAX", REAL),
    (Parameter::SinkMax, "FW_T_SINK_MAX", REAL),
    (Parameter::LoiterRadius, "NAV_LOITER_RAD", REAL),
    (Parameter::WaypointRadius, "NAV_ACC_RAD", REAL),
    (Parameter::RtlAltitude, "RTL_RETURN_ALT", REAL),
    (Parameter::TakeoffAltitude, "MIS_TAKEOFF_ALT", REAL),
    (Parameter::DisarmDelay, "COM_DISARM_LAND", REAL),
    (Parameter::FenceAction, "GF_ACTION", INT32),
    (Parameter::FenceRadius, "GF_MAX_HOR_DIST", REAL),
    (Parameter::FenceAltitudeMax, "GF_MAX_VER_DIST", REAL),
];

/// PX4's name and type of a parameter.
pub(in crate::firmware) fn parameter(parameter: Parameter) -> (&'static str, MavParamType) {
    let renamed = NAMES.iter().find(|(known, ..)| *known == parameter);
    renamed.map_or_else(
        || (parameter.name(), if parameter.kind() == REAL { REAL } else { INT32 }),
        |(_, name, kind)| (*name, *kind),
    )
}
