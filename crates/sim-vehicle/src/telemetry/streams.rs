//! Which messages a link gets, and how often.

use crate::firmware::rules::Rules;
use crate::telemetry::rates::TelemetryRates;
use std::time::Duration;

/// A stream: its name and its message id in <https://mavlink.io/en/messages/ardupilotmega.html>, and the common dialect
/// within.
macro_rules! streams {
    ($($stream:ident = $id:literal),* $(,)?) => {
        /// A message that can be sent at a rate or on request. LOCAL_POSITION_NED comes last: it closes a lockstep
        /// tick.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(crate) enum Stream {
            $($stream),*
        }

        impl Stream {
            pub const ALL: [Stream; Self::COUNT] = [$(Stream::$stream),*];
            pub const COUNT: usize = [$($id),*].len();

            /// The message id.
            pub fn message_id(self) -> u32 {
                match self {
                    $(Stream::$stream => $id),*
                }
            }
        }
    };
}

streams! {
    Heartbeat = 0,
    SysStatus = 1,
    SystemTime = 2,
    Attitude = 30,
    GlobalPositionInt = 33,
    VfrHud = 74,
    GpsRawInt = 24,
    MissionCurrent = 42,
    RawImu = 27,
    ScaledImu = 26,
    ScaledPressure = 29,
    HighresImu = 105,
    Wind = 168,
    WindCov = 231,
    EkfStatusReport = 193,
    FenceStatus = 162,
    RcChannels = 65,
    GpsGlobalOrigin = 49,
    HomePosition = 242,
    BatteryStatus = 147,
    ExtendedSysState = 245,
    AutopilotVersion = 148,
    ProtocolVersion = 300,
    AttitudeQuaternion = 31,
    NavControllerOutput = 62,
    PositionTargetLocalNed = 85,
    PositionTargetGlobalInt = 87,
    Altitude = 141,
    Odometry = 331,
    Ping = 4,
    RcChannelsRaw = 35,
    ServoOutputRaw = 36,
    ManualControl = 69,
    AttitudeTarget = 83,
    HilActuatorControls = 93,
    SimState = 108,
    Timesync = 111,
    ScaledImu2 = 116,
    PowerStatus = 125,
    ScaledImu3 = 129,
    DistanceSensor = 132,
    TerrainReport = 136,
    ScaledPressure2 = 137,
    Meminfo = 152,
    Ahrs = 163,
    SimulatedState = 164,
    Hwstatus = 165,
    Ahrs2 = 178,
    MagCalReport = 192,
    EstimatorStatus = 230,
    HighLatency2 = 235,
    Vibration = 241,
    StorageInformation = 261,
    FlightInformation = 264,
    Airspeed = 295,
    ActuatorOutputStatus = 375,
    RelayStatus = 376,
    CurrentMode = 436,
    HilStateQuaternion = 115,
    AutopilotStateForGimbalDevice = 286,
    MissionItemReached = 46,
    AvailableModesMonitor = 437,
    EscTelemetry = 11_030,
    DroneIdBasic = 12_900,
    DroneIdLocation = 12_901,
    DroneIdSystem = 12_904,
    AoaSsa = 11_020,
    LocalPositionNed = 32,
}

impl Stream {
    pub fn from_message_id(id: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|stream| stream.message_id() == id)
    }

    /// The rate at which this stream comes by default, Hz; none if it comes only when it is asked for. Streams that
    /// share one are a group of ArduPlane's.
    fn default_rate_hz<'a>(self, rates: &'a mut TelemetryRates, rules: &Rules) -> Option<&'a mut f64> {
        if let Some((_, rate)) = rules.more_streams.iter().find(|(stream, _)| *stream == self) {
            return Some(rate(rates));
        }
        match self {
            Stream::Heartbeat => Some(&mut rates.heartbeat_hz),
            Stream::RawImu | Stream::ScaledPressure => Some(&mut rates.raw_sensors_hz),
            Stream::SysStatus
            | Stream::GpsRawInt
            | Stream::MissionCurrent
            | Stream::FenceStatus
            | Stream::NavControllerOutput
            | Stream::PositionTargetGlobalInt => Some(&mut rates.sys_status_hz),
            Stream::SystemTime | Stream::Wind | Stream::BatteryStatus | Stream::EkfStatusReport => {
                Some(&mut rates.system_time_hz)
            }
            Stream::Attitude => Some(&mut rates.attitude_hz),
            Stream::GlobalPositionInt => Some(&mut rates.global_position_int_hz),
            Stream::VfrHud => Some(&mut rates.vfr_hud_hz),
            Stream::ExtendedSysState => Some(&mut rates.extended_sys_state_hz),
            Stream::HomePosition => Some(&mut rates.home_position_hz),
            Stream::LocalPositionNed => Some(&mut rates.local_position_ned_hz),
            // Asked for, or never.
            _ => None,
        }
    }

    /// Changes the rate at which this stream comes by default.
    pub fn set_default_rate(self, rates: &mut TelemetryRates, rules: &Rules, rate_hz: f64) {
        if let Some(rate) = self.default_rate_hz(rates, rules) {
            *rate = rate_hz;
        }
    }

    /// The time between two messages by default; none if the stream is off.
    pub fn default_interval(self, rates: &TelemetryRates, rules: &Rules) -> Option<Duration> {
        interval_of(self.default_rate_hz(&mut { *rates }, rules).map_or(0.0, |rate| *rate))
    }
}

/// The time between two messages at a rate, Hz; none if it is 0.
pub(crate) fn interval_of(rate_hz: f64) -> Option<Duration> {
    (rate_hz > 0.0).then(|| Duration::try_from_secs_f64(1.0 / rate_hz).ok()).flatten().filter(|i| !i.is_zero())
}

/// ArduPlane's groups, by which REQUEST_DATA_STREAM and the MAV1_ parameters set rates.
pub(crate) mod groups {
    use crate::parameters::table::RateGroup;
    use crate::telemetry::streams::Stream;

    pub const RAW_SENSORS: &[Stream] = &[Stream::RawImu, Stream::ScaledPressure];
    pub const EXTENDED_STATUS: &[Stream] = &[
        Stream::SysStatus,
        Stream::GpsRawInt,
        Stream::MissionCurrent,
        Stream::FenceStatus,
        Stream::NavControllerOutput,
        Stream::PositionTargetGlobalInt,
    ];
    pub const RC_CHANNELS: &[Stream] = &[Stream::RcChannels];
    pub const POSITION: &[Stream] = &[Stream::LocalPositionNed, Stream::GlobalPositionInt];
    pub const EXTRA1: &[Stream] = &[Stream::Attitude];
    pub const EXTRA2: &[Stream] = &[Stream::VfrHud];
    pub const EXTRA3: &[Stream] = &[Stream::SystemTime, Stream::Wind, Stream::BatteryStatus, Stream::EkfStatusReport];
    /// The messages whose rate a parameter sets.
    pub fn of(group: RateGroup) -> &'static [Stream] {
        match group {
            RateGroup::RawSensors => RAW_SENSORS,
            RateGroup::ExtendedStatus => EXTENDED_STATUS,
            RateGroup::Position => POSITION,
            RateGroup::Extra1 => EXTRA1,
            RateGroup::Extra2 => EXTRA2,
            RateGroup::Extra3 => EXTRA3,
        }
    }

    /// What REQUEST_DATA_STREAM sets beyond them: messages of ArduPlane's groups that do not come unasked
    /// (`GCS_MAVLink_Parameters.cpp`).
    pub const MORE_RAW_SENSORS: &[Stream] =
        &[Stream::ScaledImu2, Stream::ScaledImu3, Stream::ScaledPressure2, Stream::Airspeed];
    pub const MORE_EXTENDED_STATUS: &[Stream] = &[Stream::PowerStatus, Stream::Meminfo];
    pub const MORE_RC_CHANNELS: &[Stream] = &[Stream::ServoOutputRaw];
    pub const MORE_EXTRA1: &[Stream] = &[Stream::SimulatedState, Stream::Ahrs2, Stream::AoaSsa];
    pub const MORE_EXTRA3: &[Stream] = &[Stream::Ahrs, Stream::TerrainReport, Stream::Vibration];
}

/// When each stream of one link is due next. A stream is due at whole multiples of its interval, without drift.
#[derive(Clone, Debug)]
pub(crate) struct Schedule {
    interval: [Option<Duration>; Stream::COUNT],
    due: [Duration; Stream::COUNT],
    /// The streams that are on: most are off, and are not looked at.
    on: Vec<Stream>,
    next: Duration,
}

// What is due fits into the bits of one number.
const _: () = assert!(Stream::COUNT <= 128);

impl Schedule {
    /// With the times between two messages of each stream; none for what is off.
    pub fn new(interval_of: impl Fn(Stream) -> Option<Duration>, time: Duration) -> Self {
        let interval = Stream::ALL.map(interval_of);
        let due = interval.map(|interval| next_multiple(interval, time));
        let mut schedule = Self { interval, due, on: Vec::new(), next: Duration::MAX };
        schedule.find_on();
        schedule
    }

    /// The earliest time at which anything is due; [`Duration::MAX`] if all is off.
    pub fn next(&self) -> Duration {
        self.next
    }

    /// The time between two messages of a stream; none if it is off.
    pub fn interval(&self, stream: Stream) -> Option<Duration> {
        self.interval[stream as usize]
    }

    /// Sets the time between two messages of a stream; none switches it off.
    pub fn set_interval(&mut self, stream: Stream, interval: Option<Duration>, time: Duration) {
        let index = stream as usize;
        self.interval[index] = interval;
        self.due[index] = next_multiple(interval, time);
        self.find_on();
    }

    /// Takes what is due at `time`, in the order of [`Stream::ALL`].
    pub fn take_due(&mut self, time: Duration) -> impl Iterator<Item = Stream> + use<> {
        let mut taken: u128 = 0;
        if self.next <= time {
            for stream in &self.on {
                let index = *stream as usize;
                if self.due[index] <= time {
                    taken |= 1 << index;
                    self.due[index] = next_multiple(self.interval[index], time);
                }
            }
            self.find_next();
        }
        std::iter::from_fn(move || {
            let index = (taken != 0).then(|| taken.trailing_zeros() as usize)?;
            taken &= taken - 1;
            Some(Stream::ALL[index])
        })
    }

    fn find_on(&mut self) {
        self.on.clear();
        self.on.extend(Stream::ALL.into_iter().filter(|stream| self.due[*stream as usize] < Duration::MAX));
        self.find_next();
    }

    fn find_next(&mut self) {
        self.next = self.on.iter().map(|stream| self.due[*stream as usize]).min().unwrap_or(Duration::MAX);
    }
}

/// The first whole multiple of an interval after `time`.
fn next_multiple(interval: Option<Duration>, time: Duration) -> Duration {
    let Some(interval) = interval.filter(|interval| !interval.is_zero()) else { return Duration::MAX };
    let past_nanos = u64::try_from(time.as_nanos() % interval.as_nanos()).unwrap_or(0);
    time.saturating_add(interval).saturating_sub(Duration::from_nanos(past_nanos))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::firmware::Personality;

    fn due_in(schedule: &mut Schedule, from_ms: u64, to_ms: u64) -> Vec<(u64, Stream)> {
        (from_ms / 10 + 1..=to_ms / 10)
            .flat_map(|step| schedule.take_due(Duration::from_millis(10 * step)).map(move |stream| (10 * step, stream)))
            .collect()
    }

    #[test]
    fn the_rates_are_kept_without_drift() {
        let rates = TelemetryRates { attitude_hz: 30.0, ..TelemetryRates::default() };
        let rules = Personality::ArduPlane.rules();
        let mut schedule = Schedule::new(|stream| stream.default_interval(&rates, rules), Duration::ZERO);
        let sent = due_in(&mut schedule, 0, 60_000);
        let count = |stream| sent.iter().filter(|(_, sent)| *sent == stream).count();
        assert_eq!(count(Stream::LocalPositionNed), 600);
        assert_eq!(count(Stream::Heartbeat), 60);
        assert_eq!(count(Stream::VfrHud), 240);
        assert!((1_799..=1_800).contains(&count(Stream::Attitude)));
        assert_eq!(count(Stream::HomePosition), 30);
        assert_eq!(count(Stream::ExtendedSysState), 120);
        assert_eq!(count(Stream::AutopilotVersion), 0);
    }

    #[test]
    fn an_interval_can_be_set_and_switched_off() {
        let mut schedule = Schedule::new(|_| None, Duration::ZERO);
        assert_eq!(schedule.next(), Duration::MAX);
        schedule.set_interval(Stream::HomePosition, Some(Duration::from_millis(50)), Duration::from_millis(70));
        let times: Vec<u64> = due_in(&mut schedule, 70, 200).into_iter().map(|(time, _)| time).collect();
        assert_eq!(times, [100, 150, 200]);
        schedule.set_interval(Stream::HomePosition, None, Duration::from_millis(200));
        assert_eq!(due_in(&mut schedule, 200, 1_000), []);
    }
}
