//! What an ArduPlane sends unasked on each link of its own simulator, Hz: all its groups once a second (the MAV1_
//! parameters are 1 there), and home and the origin when they change and now and then.
//!
//! A message is sent only while it has content.

use crate::firmware::rules::StreamRates;
use crate::telemetry::rates::LinkUse;
use crate::telemetry::streams::Stream;

pub(super) fn of(_: LinkUse) -> Option<StreamRates> {
    Some(&EVERY_LINK)
}

const EVERY_LINK: [(Stream, f64); 34] = [
    (Stream::Heartbeat, 1.0),
    (Stream::SysStatus, 1.0),
    (Stream::SystemTime, 1.0),
    (Stream::Attitude, 1.0),
    (Stream::GlobalPositionInt, 1.0),
    (Stream::VfrHud, 1.0),
    (Stream::GpsRawInt, 1.0),
    (Stream::MissionCurrent, 1.0),
    (Stream::RawImu, 1.0),
    (Stream::ScaledPressure, 1.0),
    (Stream::Wind, 1.0),
    (Stream::EkfStatusReport, 1.0),
    (Stream::FenceStatus, 1.0),
    (Stream::RcChannels, 1.0),
    (Stream::GpsGlobalOrigin, 0.1),
    (Stream::HomePosition, 0.1),
    (Stream::BatteryStatus, 1.0),
    (Stream::NavControllerOutput, 1.0),
    (Stream::PositionTargetGlobalInt, 1.0),
    (Stream::ServoOutputRaw, 1.0),
    (Stream::ScaledImu2, 1.0),
    (Stream::PowerStatus, 1.0),
    (Stream::ScaledImu3, 1.0),
    (Stream::TerrainReport, 1.0),
    (Stream::ScaledPressure2, 1.0),
    (Stream::Meminfo, 1.0),
    (Stream::Ahrs, 1.0),
    (Stream::SimulatedState, 1.0),
    (Stream::Ahrs2, 1.0),
    (Stream::Vibration, 1.0),
    (Stream::Airspeed, 1.0),
    (Stream::EscTelemetry, 1.0),
    (Stream::AoaSsa, 1.0),
    (Stream::LocalPositionNed, 1.0),
];
