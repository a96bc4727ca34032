//! What a PX4 sends unasked on each link of its own simulator, Hz (`configure_streams_to_default` of
//! `mavlink_main.cpp`, and `px4-rc.mavlink`, which sets some of them anew for ground stations).
//!
//! A message is sent once an integration step at most, and only while it has content. The GPS has a fix eight times a
//! second. What is told once, when it becomes known (GPS_GLOBAL_ORIGIN), is known before anybody connects.

use crate::firmware::rules::StreamRates;
use crate::telemetry::rates::LinkUse;
use crate::telemetry::streams::Stream;

pub(super) fn of(link_use: LinkUse) -> Option<StreamRates> {
    Some(match link_use {
        LinkUse::Companion => &COMPANION,
        LinkUse::GroundStation => &GROUND_STATION,
    })
}

const COMPANION: [(Stream, f64); 30] = [
    (Stream::Heartbeat, 1.0),
    (Stream::SysStatus, 5.0),
    (Stream::SystemTime, 1.0),
    (Stream::Ping, 1.0),
    (Stream::GpsRawInt, 8.0),
    (Stream::ScaledPressure, 1.0),
    (Stream::Attitude, 100.0),
    (Stream::AttitudeQuaternion, 50.0),
    (Stream::LocalPositionNed, 30.0),
    (Stream::GlobalPositionInt, 50.0),
    (Stream::ServoOutputRaw, 10.0),
    (Stream::MissionCurrent, 1.0),
    (Stream::NavControllerOutput, 10.0),
    (Stream::RcChannels, 20.0),
    (Stream::VfrHud, 10.0),
    (Stream::AttitudeTarget, 10.0),
    (Stream::PositionTargetLocalNed, 10.0),
    (Stream::PositionTargetGlobalInt, 10.0),
    (Stream::HighresImu, 50.0),
    (Stream::Timesync, 10.0),
    (Stream::DistanceSensor, 10.0),
    (Stream::Altitude, 10.0),
    (Stream::BatteryStatus, 0.5),
    (Stream::EstimatorStatus, 1.0),
    (Stream::WindCov, 10.0),
    (Stream::Vibration, 0.5),
    (Stream::HomePosition, 0.5),
    (Stream::ExtendedSysState, 5.0),
    (Stream::Odometry, 30.0),
    (Stream::CurrentMode, 0.5),
];

const GROUND_STATION: [(Stream, f64); 26] = [
    (Stream::Heartbeat, 1.0),
    (Stream::SysStatus, 1.0),
    (Stream::Ping, 0.1),
    (Stream::GpsRawInt, 5.0),
    (Stream::ScaledPressure, 1.0),
    (Stream::Attitude, 50.0),
    (Stream::AttitudeQuaternion, 50.0),
    (Stream::LocalPositionNed, 50.0),
    (Stream::GlobalPositionInt, 50.0),
    (Stream::ServoOutputRaw, 50.0),
    (Stream::MissionCurrent, 1.0),
    (Stream::NavControllerOutput, 1.0),
    (Stream::RcChannels, 20.0),
    (Stream::VfrHud, 4.0),
    (Stream::AttitudeTarget, 50.0),
    (Stream::PositionTargetLocalNed, 50.0),
    (Stream::PositionTargetGlobalInt, 1.0),
    (Stream::DistanceSensor, 0.5),
    (Stream::Altitude, 1.0),
    (Stream::BatteryStatus, 0.5),
    (Stream::EstimatorStatus, 0.5),
    (Stream::WindCov, 0.5),
    (Stream::Vibration, 0.1),
    (Stream::HomePosition, 0.5),
    (Stream::ExtendedSysState, 1.0),
    (Stream::CurrentMode, 0.5),
];
