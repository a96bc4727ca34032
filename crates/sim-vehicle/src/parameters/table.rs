//! The list of parameters: one row for each, in the order of their indices.

use crate::autopilot::rally::POINTS_MAX as RALLY_POINTS_MAX;
use crate::telemetry::rates::TelemetryRates;
use mavlink_bridge::dialect::MavParamType;
use mavlink_bridge::dialect::MavParamType::{
    MAV_PARAM_TYPE_INT8 as INT8, MAV_PARAM_TYPE_INT16 as INT16, MAV_PARAM_TYPE_INT32 as INT32,
    MAV_PARAM_TYPE_REAL32 as REAL,
};

/// What is known of a parameter before it has a value.
pub(crate) struct Row {
    /// ArduPlane's name.
    pub name: &'static str,
    /// The type that ArduPlane gives it; the speeds are real here, because a scenario's limits need not be whole.
    pub kind: MavParamType,
    /// What it is before anybody sets it.
    pub initial: fn(&Start<'_>) -> f32,
    /// Least and greatest value.
    pub range: fn(&Bounds<'_>) -> (f32, f32),
    pub effect: Effect,
}

/// What the first values come from.
pub(crate) struct Start<'a> {
    pub system_id: u8,
    pub rates: &'a TelemetryRates,
    pub cruise_mps: f64,
    pub loiter_radius_m: f64,
    pub setpoint_timeout_s: f64,
    pub model: &'a ModelBounds,
}

/// What the flight model and the integration step bound.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ModelBounds {
    pub speed_min_mps: f32,
    pub speed_max_mps: f32,
    pub climb_max_mps: f32,
    /// Above zero.
    pub sink_max_mps: f32,
    pub roll_limit_deg: f32,
    pub rate_max_hz: f32,
}

/// What a range may depend on: the flight model, and the values of the other parameters.
pub(crate) struct Bounds<'a> {
    pub values: &'a [f32; Parameter::COUNT],
    pub model: &'a ModelBounds,
}

impl Bounds<'_> {
    fn get(&self, parameter: Parameter) -> f32 {
        self.values[parameter as usize]
    }

    /// The rates that a message can have, Hz.
    fn rates_hz(&self) -> (f32, f32) {
        (0.0, self.model.rate_max_hz)
    }
}

/// ArduPlane's groups of messages that have one rate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RateGroup {
    RawSensors,
    ExtendedStatus,
    Position,
    Extra1,
    Extra2,
    Extra3,
}

/// What a new value changes at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Effect {
    /// Nothing: it is looked at where it counts.
    LookedUp,
    /// Nothing can: it is only read.
    ReadOnly,
    /// The way the vehicle flies.
    Tuning,
    /// How often these messages come.
    Rates(RateGroup),
    /// Who the vehicle is.
    SystemId,
    /// Percentage of frames that are lost on their way out.
    RadioLoss,
    /// Another battery is put in.
    Battery,
    /// Which fences are enabled.
    Fence,
    /// How many points the fence or the rally points have; of ArduPilot's older protocols.
    Points,
    /// How fast the clock of the host runs.
    Speedup,
    /// When the lack of setpoints becomes a failsafe.
    SetpointTimeout,
}

/// A row is: who it is in the code, its name, its type, its initial value, its range, its effect.
macro_rules! parameters {
    ($($parameter:ident: $name:literal, $kind:ident, $initial:expr, $range:expr, $effect:expr;)*) => {
        /// One parameter. The order is that of the list, and so of the indices.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(crate) enum Parameter {
            $($parameter),*
        }

        impl Parameter {
            pub const ALL: &[Parameter] = &[$(Parameter::$parameter),*];
            pub const COUNT: usize = Self::ALL.len();
        }

        const ROWS: [Row; Parameter::COUNT] =
            [$(Row { name: $name, kind: $kind, initial: $initial, range: $range, effect: $effect }),*];
    };
}

parameters! {
    SystemId: "MAV_SYSID", INT16, |s| f32::from(s.system_id), |_| (1.0, 250.0), Effect::SystemId;
    GroundSystemId: "MAV_GCS_SYSID", INT16, |_| 255.0, |_| (1.0, 255.0), Effect::LookedUp;

    RateRawSensors: "MAV1_RAW_SENS", INT16, |s| s.rates.raw_sensors_hz.round() as f32, |p| p.rates_hz(),
        Effect::Rates(RateGroup::RawSensors);
    RateExtendedStatus: "MAV1_EXT_STAT", INT16, |s| s.rates.sys_status_hz.round() as f32, |p| p.rates_hz(),
        Effect::Rates(RateGroup::ExtendedStatus);
    // Two messages are behind it, which the settings can tell apart.
    RatePosition: "MAV1_POSITION", INT16,
        |s| s.rates.local_position_ned_hz.max(s.rates.global_position_int_hz).round() as f32, |p| p.rates_hz(),
        Effect::Rates(RateGroup::Position);
    RateExtra1: "MAV1_EXTRA1", INT16, |s| s.rates.attitude_hz.round() as f32, |p| p.rates_hz(),
        Effect::Rates(RateGroup::Extra1);
    RateExtra2: "MAV1_EXTRA2", INT16, |s| s.rates.vfr_hud_hz.round() as f32, |p| p.rates_hz(),
        Effect::Rates(RateGroup::Extra2);
    RateExtra3: "MAV1_EXTRA3", INT16, |s| s.rates.system_time_hz.round() as f32, |p| p.rates_hz(),
        Effect::Rates(RateGroup::Extra3);

    AirspeedCruise: "AIRSPEED_CRUISE", REAL, |s| s.cruise_mps as f32,
        |p| (p.get(Parameter::AirspeedMin), p.get(Parameter::AirspeedMax)), Effect::Tuning;
    AirspeedMin: "AIRSPEED_MIN", REAL, |s| s.model.speed_min_mps,
        |p| (p.model.speed_min_mps, p.get(Parameter::AirspeedCruise)), Effect::LookedUp;
    AirspeedMax: "AIRSPEED_MAX", REAL, |s| s.model.speed_max_mps,
        |p| (p.get(Parameter::AirspeedCruise), p.model.speed_max_mps), Effect::LookedUp;
    RollLimit: "ROLL_LIMIT_DEG", REAL, |s| s.model.roll_limit_deg, |p| (1.0, p.model.roll_limit_deg), Effect::Tuning;

    ClimbMax: "TECS_CLMB_MAX", REAL, |s| s.model.climb_max_mps, |p| (0.1, p.model.climb_max_mps), Effect::Tuning;
    SinkMax: "TECS_SINK_MAX", REAL, |s| s.model.sink_max_mps, |p| (0.1, p.model.sink_max_mps), Effect::Tuning;

    LoiterRadius: "WP_LOITER_RAD", INT16, |s| s.loiter_radius_m.round().min(f64::from(RADIUS_MAX_M)) as f32,
        |_| (-RADIUS_MAX_M, RADIUS_MAX_M), Effect::Tuning;
    // ArduPlane's 90 m would cut the corners of short legs.
    WaypointRadius: "WP_RADIUS", INT16, |_| 15.0, |_| (1.0, RADIUS_MAX_M), Effect::LookedUp;
    RtlRadius: "RTL_RADIUS", INT16, |_| 0.0, |_| (-RADIUS_MAX_M, RADIUS_MAX_M), Effect::Tuning;
    // ArduPlane's default climbs to 100 m; ours stays where it is.
    RtlAltitude: "RTL_ALTITUDE", REAL, |_| -1.0, |_| (-1.0, 10_000.0), Effect::Tuning;
    TakeoffAltitude: "TKOFF_ALT", INT16, |_| TAKEOFF_ALTITUDE_M as f32, |_| (0.0, 200.0), Effect::Tuning;
    // The range that ArduPlane recommends is 0 to 30, and its own tests set 100.
    ReturnClimb: "RTL_CLIMB_MIN", INT16, |_| 0.0, |_| (0.0, 1000.0), Effect::Tuning;
    LevelRollLimit: "LEVEL_ROLL_LIMIT", INT8, |_| 5.0, |_| (0.0, 45.0), Effect::Tuning;
    FlightOptions: "FLIGHT_OPTIONS", INT32, |_| 0.0, |_| (0.0, 131_071.0), Effect::Tuning;
    RtlAutoland: "RTL_AUTOLAND", INT8, |_| 0.0, |_| (0.0, 4.0), Effect::LookedUp;
    DisarmDelay: "LAND_DISARMDELAY", INT8, |_| 20.0, |_| (0.0, 127.0), Effect::LookedUp;

    ArmingCheck: "ARMING_CHECK", INT32, |_| 1.0, |_| (0.0, 8_388_607.0), Effect::LookedUp;

    ThrottleFailsafe: "THR_FAILSAFE", INT8, |_| 1.0, |_| (0.0, 2.0), Effect::LookedUp;
    ThrottleFailsafeValue: "THR_FS_VALUE", INT16, |_| 950.0, |_| (0.0, 2200.0), Effect::LookedUp;
    OverrideTime: "RC_OVERRIDE_TIME", REAL, |_| 3.0, |_| (-1.0, 120.0), Effect::LookedUp;
    RudderArming: "ARMING_RUDDER", INT8, |_| 1.0, |_| (0.0, 2.0), Effect::LookedUp;

    ParachuteEnabled: "CHUTE_ENABLED", INT8, |_| 0.0, |_| (0.0, 1.0), Effect::LookedUp;

    // The pilot's channels: 1 where more microseconds mean less.
    RollReversed: "RC1_REVERSED", INT8, |_| 0.0, |_| (0.0, 1.0), Effect::LookedUp;
    PitchReversed: "RC2_REVERSED", INT8, |_| 0.0, |_| (0.0, 1.0), Effect::LookedUp;
    ThrottleReversed: "RC3_REVERSED", INT8, |_| 0.0, |_| (0.0, 1.0), Effect::LookedUp;
    // The functions of channels that are switches.
    ChannelFunction1: "RC1_OPTION", INT16, |_| 0.0, |_| (0.0, FUNCTION_MAX), Effect::LookedUp;
    ChannelFunction2: "RC2_OPTION", INT16, |_| 0.0, |_| (0.0, FUNCTION_MAX), Effect::LookedUp;
    ChannelFunction3: "RC3_OPTION", INT16, |_| 0.0, |_| (0.0, FUNCTION_MAX), Effect::LookedUp;
    ChannelFunction4: "RC4_OPTION", INT16, |_| 0.0, |_| (0.0, FUNCTION_MAX), Effect::LookedUp;
    ChannelFunction5: "RC5_OPTION", INT16, |_| 0.0, |_| (0.0, FUNCTION_MAX), Effect::LookedUp;
    ChannelFunction6: "RC6_OPTION", INT16, |_| 0.0, |_| (0.0, FUNCTION_MAX), Effect::LookedUp;
    ChannelFunction7: "RC7_OPTION", INT16, |_| 0.0, |_| (0.0, FUNCTION_MAX), Effect::LookedUp;
    ChannelFunction8: "RC8_OPTION", INT16, |_| 0.0, |_| (0.0, FUNCTION_MAX), Effect::LookedUp;
    ChannelFunction9: "RC9_OPTION", INT16, |_| 0.0, |_| (0.0, FUNCTION_MAX), Effect::LookedUp;
    ChannelFunction10: "RC10_OPTION", INT16, |_| 0.0, |_| (0.0, FUNCTION_MAX), Effect::LookedUp;
    ChannelFunction11: "RC11_OPTION", INT16, |_| 0.0, |_| (0.0, FUNCTION_MAX), Effect::LookedUp;
    ChannelFunction12: "RC12_OPTION", INT16, |_| 0.0, |_| (0.0, FUNCTION_MAX), Effect::LookedUp;
    ChannelFunction13: "RC13_OPTION", INT16, |_| 0.0, |_| (0.0, FUNCTION_MAX), Effect::LookedUp;
    ChannelFunction14: "RC14_OPTION", INT16, |_| 0.0, |_| (0.0, FUNCTION_MAX), Effect::LookedUp;
    ChannelFunction15: "RC15_OPTION", INT16, |_| 0.0, |_| (0.0, FUNCTION_MAX), Effect::LookedUp;
    ChannelFunction16: "RC16_OPTION", INT16, |_| 0.0, |_| (0.0, FUNCTION_MAX), Effect::LookedUp;
    FlightModeChannel: "FLTMODE_CH", INT8, |_| 8.0, |_| (0.0, 16.0), Effect::LookedUp;
    FlightMode1: "FLTMODE1", INT8, |_| 11.0, |_| (0.0, MODE_MAX), Effect::LookedUp;
    FlightMode2: "FLTMODE2", INT8, |_| 11.0, |_| (0.0, MODE_MAX), Effect::LookedUp;
    FlightMode3: "FLTMODE3", INT8, |_| 5.0, |_| (0.0, MODE_MAX), Effect::LookedUp;
    FlightMode4: "FLTMODE4", INT8, |_| 5.0, |_| (0.0, MODE_MAX), Effect::LookedUp;
    FlightMode5: "FLTMODE5", INT8, |_| 0.0, |_| (0.0, MODE_MAX), Effect::LookedUp;
    FlightMode6: "FLTMODE6", INT8, |_| 0.0, |_| (0.0, MODE_MAX), Effect::LookedUp;

    // ArduCopter's name: ArduPlane waits for ever for a setpoint.
    GuidedTimeout: "GUID_TIMEOUT", REAL, |s| s.setpoint_timeout_s as f32, |_| (0.0, 1e6), Effect::SetpointTimeout;

    // 2 is as 1: there is no radio that could report its strength. 3 counts in AUTO only.
    GroundFailsafe: "FS_GCS_ENABL", INT8, |_| 0.0, |_| (0.0, 3.0), Effect::LookedUp;
    ShortFailsafeAction: "FS_SHORT_ACTN", INT8, |_| 0.0, |_| (0.0, 4.0), Effect::LookedUp;
    LongFailsafeAction: "FS_LONG_ACTN", INT8, |_| 0.0, |_| (0.0, 5.0), Effect::LookedUp;
    LongFailsafeTimeout: "FS_LONG_TIMEOUT", REAL, |_| 5.0, |_| (1.0, 300.0), Effect::LookedUp;

    // ArduCopter's name: ArduPlane reckons on and has no action to choose.
    DeadReckoningAction: "FS_DR_ENABLE", INT8, |_| 0.0, |_| (0.0, 2.0), Effect::LookedUp;

    // Whatever kind of monitor it is, it sees the one battery.
    BatteryMonitor: "BATT_MONITOR", INT8, |_| 4.0, |_| (0.0, 127.0), Effect::LookedUp;
    BatteryCapacity: "BATT_CAPACITY", INT32, |_| 3300.0, |_| (0.0, 1e6), Effect::LookedUp;
    BatteryLowTimer: "BATT_LOW_TIMER", INT8, |_| 10.0, |_| (0.0, 120.0), Effect::LookedUp;
    BatteryLowVoltage: "BATT_LOW_VOLT", REAL, |_| 0.0, |_| (0.0, 100.0), Effect::LookedUp;
    BatteryLowCharge: "BATT_LOW_MAH", REAL, |_| 0.0, |_| (0.0, 1e6), Effect::LookedUp;
    BatteryCriticalVoltage: "BATT_CRT_VOLT", REAL, |_| 0.0, |_| (0.0, 100.0), Effect::LookedUp;
    BatteryCriticalCharge: "BATT_CRT_MAH", REAL, |_| 0.0, |_| (0.0, 1e6), Effect::LookedUp;
    BatteryLowAction: "BATT_FS_LOW_ACT", INT8, |_| 0.0, |_| (0.0, 7.0), Effect::LookedUp;
    BatteryCriticalAction: "BATT_FS_CRT_ACT", INT8, |_| 0.0, |_| (0.0, 7.0), Effect::LookedUp;

    // The world: SIM_ parameters, at rest unless somebody sets them.
    WindSpeed: "SIM_WIND_SPD", REAL, |_| 0.0, |_| (0.0, 60.0), Effect::LookedUp;
    WindDirection: "SIM_WIND_DIR", REAL, |_| 180.0, |_| (-360.0, 360.0), Effect::LookedUp;
    WindGusts: "SIM_WIND_TURB", REAL, |_| 0.0, |_| (0.0, 20.0), Effect::LookedUp;
    WindTimeConstant: "SIM_WIND_TC", REAL, |_| 5.0, |_| (0.0, 600.0), Effect::LookedUp;
    GpsFail: "SIM_GPS_FAIL", INT8, |_| 0.0, |_| (0.0, 1.0), Effect::LookedUp;
    GpsEnabled: "SIM_GPS1_ENABLE", INT8, |_| 1.0, |_| (0.0, 1.0), Effect::LookedUp;
    GpsLag: "SIM_GPS1_LAG_MS", INT16, |_| 0.0, |_| (0.0, 2000.0), Effect::LookedUp;
    GpsNoise: "SIM_GPS1_NOISE", REAL, |_| 0.0, |_| (0.0, 1000.0), Effect::LookedUp;
    GpsSatellites: "SIM_GPS1_NUMSATS", INT8, |_| 10.0, |_| (0.0, 40.0), Effect::LookedUp;
    ReceiverFail: "SIM_RC_FAIL", INT8, |_| 0.0, |_| (0.0, 2.0), Effect::LookedUp;
    // Bits of motors; there is one, and any of them means it.
    EngineFail: "SIM_ENGINE_FAIL", INT32, |_| 0.0, |_| (0.0, 16_777_215.0), Effect::LookedUp;
    EngineShare: "SIM_ENGINE_MUL", REAL, |_| 0.0, |_| (0.0, 1.0), Effect::LookedUp;
    // Of the host's clock, which all vehicles share.
    Speedup: "SIM_SPEEDUP", REAL, |_| 1.0, |_| (0.01, 100.0), Effect::Speedup;
    RadioLoss: "SIM_UART_LOSS", REAL, |_| 0.0, |_| (0.0, 100.0), Effect::RadioLoss;
    SimBatteryVoltage: "SIM_BATT_VOLTAGE", REAL, |_| 12.6, |_| (0.0, 100.0), Effect::LookedUp;
    SimBatteryCapacity: "SIM_BATT_CAP_AH", REAL, |_| 0.0, |_| (0.0, 1000.0), Effect::Battery;
    BarometerNoise: "SIM_BARO_RND", REAL, |_| 0.0, |_| (0.0, 1000.0), Effect::LookedUp;
    BarometerDrift: "SIM_BARO_DRIFT", REAL, |_| 0.0, |_| (-10.0, 10.0), Effect::LookedUp;
    PitotNoise: "SIM_ARSPD_RND", REAL, |_| 0.0, |_| (0.0, 1000.0), Effect::LookedUp;
    PitotFail: "SIM_ARSPD_FAIL", REAL, |_| 0.0, |_| (0.0, 100.0), Effect::LookedUp;
    AccelerometerNoise: "SIM_ACC1_RND", REAL, |_| 0.0, |_| (0.0, 100.0), Effect::LookedUp;
    AccelerometerBiasX: "SIM_ACC1_BIAS_X", REAL, |_| 0.0, |_| (-20.0, 20.0), Effect::LookedUp;
    AccelerometerBiasY: "SIM_ACC1_BIAS_Y", REAL, |_| 0.0, |_| (-20.0, 20.0), Effect::LookedUp;
    AccelerometerBiasZ: "SIM_ACC1_BIAS_Z", REAL, |_| 0.0, |_| (-20.0, 20.0), Effect::LookedUp;
    GyroscopeNoise: "SIM_GYR1_RND", REAL, |_| 0.0, |_| (0.0, 1000.0), Effect::LookedUp;
    CompassNoise: "SIM_MAG_RND", REAL, |_| 0.0, |_| (0.0, 1000.0), Effect::LookedUp;
    FenceEnable: "FENCE_ENABLE", INT8, |_| 0.0, |_| (0.0, 1.0), Effect::Fence;
    FenceType: "FENCE_TYPE", INT8, |_| 4.0, |_| (0.0, 15.0), Effect::Fence;
    FenceAction: "FENCE_ACTION", INT8, |_| 1.0, |_| (0.0, 8.0), Effect::LookedUp;
    FenceAltitudeMax: "FENCE_ALT_MAX", REAL, |_| 100.0, |_| (0.0, 10_000.0), Effect::LookedUp;
    FenceRadius: "FENCE_RADIUS", REAL, |_| 300.0, |_| (0.0, 1e6), Effect::LookedUp;
    FenceMargin: "FENCE_MARGIN", REAL, |_| 2.0, |_| (0.0, 1000.0), Effect::LookedUp;
    FenceTotal: "FENCE_TOTAL", INT8, |_| 0.0, |_| (0.0, 127.0), Effect::Points;
    FenceAltitudeMin: "FENCE_ALT_MIN", REAL, |_| -10.0, |_| (-100.0, 10_000.0), Effect::LookedUp;
    FenceReturnToRally: "FENCE_RET_RALLY", INT8, |_| 0.0, |_| (0.0, 1.0), Effect::LookedUp;
    FenceReturnAltitude: "FENCE_RET_ALT", INT16, |_| 0.0, |_| (0.0, f32::from(i16::MAX)), Effect::LookedUp;
    FenceAutoEnable: "FENCE_AUTOENABLE", INT8, |_| 0.0, |_| (0.0, 3.0), Effect::Fence;
    FenceOptions: "FENCE_OPTIONS", INT16, |_| 1.0, |_| (0.0, 7.0), Effect::LookedUp;
    MissionTotal: "MIS_TOTAL", INT16, |_| 0.0, |_| (0.0, 0.0), Effect::ReadOnly;
    RallyTotal: "RALLY_TOTAL", INT8, |_| 0.0, |_| (0.0, f32::from(RALLY_POINTS_MAX)), Effect::Points;
    RallyLimit: "RALLY_LIMIT_KM", REAL, |_| 5.0, |_| (0.0, 1000.0), Effect::LookedUp;
    RallyIncludesHome: "RALLY_INCL_HOME", INT8, |_| 0.0, |_| (0.0, 1.0), Effect::LookedUp;

    RunTime: "STAT_RUNTIME", INT32, |_| 0.0, |_| (0.0, 0.0), Effect::ReadOnly;
    BootCount: "STAT_BOOTCNT", INT16, |_| 1.0, |_| (1.0, 1.0), Effect::ReadOnly;

    // PX4's own: see firmware/px4/.
    OffboardTimeout: "COM_OF_LOSS_T", REAL, |_| 1.0, |_| (0.0, 60.0), Effect::LookedUp;
    OffboardLossAction: "COM_OBL_RC_ACT", INT32, |_| 0.0, |_| (0.0, 5.0), Effect::LookedUp;
    DataLinkLossAction: "NAV_DLL_ACT", INT32, |_| 0.0, |_| (0.0, 3.0), Effect::LookedUp;
    DataLinkTimeout: "COM_DL_LOSS_T", INT32, |_| 10.0, |_| (5.0, 300.0), Effect::LookedUp;
    DataLinkExceptions: "COM_DLL_EXCEPT", INT32, |_| 0.0, |_| (0.0, 7.0), Effect::LookedUp;
    FailsafeDelay: "COM_FAIL_ACT_T", REAL, |_| 5.0, |_| (0.0, 25.0), Effect::LookedUp;
    PreflightDisarmDelay: "COM_DISARM_PRFLT", REAL, |_| 10.0, |_| (-1.0, 3600.0), Effect::LookedUp;
    // As a PX4's simulation has it.
    FailureInjection: "SYS_FAILURE_EN", INT32, |_| 1.0, |_| (0.0, 1.0), Effect::LookedUp;
    // PX4's own default. Its airframes of fixed wings have 2, which refuses missions that end in the air.
    MissionRequirements: "MIS_TKO_LAND_REQ", INT32, |_| 0.0, |_| (0.0, 5.0), Effect::LookedUp;
    FirstWaypointDistance: "MIS_DIST_1WP", REAL, |_| 10_000.0, |_| (-1.0, 100_000.0), Effect::LookedUp;
    // What airframes of fixed wings set (`rc.fw_defaults`).
    ReturnDescentAltitude: "RTL_DESCEND_ALT", REAL, |_| 100.0, |_| (0.0, 10_000.0), Effect::LookedUp;
    LandingAngle: "FW_LND_ANG", REAL, |_| 5.0, |_| (1.0, 45.0), Effect::LookedUp;
}

/// ArduPlane's default of TKOFF_ALT, m.
pub(crate) const TAKEOFF_ALTITUDE_M: f64 = 50.0;
/// The greatest number of a function of a switch.
const FUNCTION_MAX: f32 = 1000.0;
/// The greatest number of a mode of ArduPlane's.
const MODE_MAX: f32 = 26.0;
/// Radii are whole metres of 16 bits.
const RADIUS_MAX_M: f32 = i16::MAX as f32;

impl Parameter {
    #[cfg(test)]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|parameter| parameter.name() == name)
    }

    pub fn row(self) -> &'static Row {
        &ROWS[self as usize]
    }

    /// ArduPlane's name.
    pub fn name(self) -> &'static str {
        self.row().name
    }

    pub fn kind(self) -> MavParamType {
        self.row().kind
    }

    pub fn is_read_only(self) -> bool {
        self.row().effect == Effect::ReadOnly
    }

    /// Whether it counts what is on board: no file sets it, and the plans keep it.
    pub fn is_counted(self) -> bool {
        matches!(self.row().effect, Effect::ReadOnly | Effect::Points)
    }
}

/// Parameters that only a PX4 has.
pub(crate) const OF_PX4_ALONE: &[Parameter] = &[
    Parameter::OffboardTimeout,
    Parameter::OffboardLossAction,
    Parameter::DataLinkLossAction,
    Parameter::DataLinkTimeout,
    Parameter::DataLinkExceptions,
    Parameter::FailsafeDelay,
    Parameter::PreflightDisarmDelay,
    Parameter::FailureInjection,
    Parameter::MissionRequirements,
    Parameter::FirstWaypointDistance,
    Parameter::ReturnDescentAltitude,
    Parameter::LandingAngle,
];
