//! All that a reboot forgets.

use super::calibration::Calibration;
use super::failsafe::Failsafes;
use super::fence::monitor::FenceMonitor;
use super::habits::Habits;
use super::manual_control::Channels;
use super::mission::progress::Progress;
use super::outputs::Outputs;
use super::switches::Switches;
use super::timer::Timers;
use super::transmitter::RudderStick;

/// What has happened since the vehicle was switched on.
#[derive(Clone, Debug, Default)]
pub(crate) struct Session {
    pub timers: Timers,
    pub failsafes: Failsafes,
    pub fence: FenceMonitor,
    pub progress: Progress,
    pub channels: Channels,
    pub switches: Switches,
    pub rudder: RudderStick,
    pub habits: Habits,
    pub outputs: Outputs,
    pub parachute_is_released: bool,
    /// What is being calibrated.
    pub calibration: Option<Calibration>,
    /// Of an ArduPlane, the pose in which the accelerometer is to be held next to be calibrated, from 0.
    pub accelerometer_pose: Option<usize>,
    /// Of an ArduPlane, whether its compasses are being calibrated: nobody turns the vehicle, so that it does not end.
    pub compasses_are_calibrated: bool,
    /// What stood against arming when that was last looked at.
    pub arming_reason: Option<String>,
    /// Whether somebody has set home: then arming leaves it.
    pub home_is_set: bool,
}
