//! Outputs that nothing but commands moves: servos 5 to 16 and one relay, as ArduPilot's simulator of a plane has them
//! (`AP_ServoRelayEvents`). Nothing hangs on them.

use super::Autopilot;
use crate::autopilot::input::integer;
use crate::error::CommandError;
use crate::parameters::Listed;

/// How many servos SERVO_OUTPUT_RAW has.
const SERVOS: usize = 16;
/// The first servos are the surfaces' and the throttle's.
const OWN: usize = 4;
/// How many channels ArduPilot has.
const CHANNELS: u8 = 32;
/// Values of SERVO1_FUNCTION and its kin with which commands may move a servo: none, by hand, a sprayer, a gripper, the
/// receiver's channels.
const FREE: [std::ops::RangeInclusive<i64>; 5] = [0..=1, 22..=23, 28..=28, 51..=66, 140..=155];

/// What commands have set.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Outputs {
    servos_us: [u16; SERVOS],
    relay: bool,
}

impl Outputs {
    /// The pulses of servos 5 to 16, microseconds; 0 where nobody has set one.
    pub fn servos_us(&self) -> [u16; SERVOS - OWN] {
        std::array::from_fn(|index| self.servos_us[OWN + index])
    }

    pub fn relay(&self) -> bool {
        self.relay
    }
}

impl Autopilot {
    /// DO_SET_SERVO, and DO_REPEAT_SERVO, which moves it once here. Param 1: the servo, from 1; param 2: microseconds.
    pub(crate) fn set_servo(&mut self, [servo, pulse_us]: [f32; 2]) -> Result<(), CommandError> {
        let servo = integer(servo) as u8;
        if servo == 0 || servo > CHANNELS {
            return Err(CommandError::failed(format!("There is no servo {servo}")).quietly());
        }
        let index = usize::from(servo) - 1;
        if !(OWN..SERVOS).contains(&index) || !self.is_free(servo) {
            let reason = format!("ServoRelayEvent: Channel {servo} is already in use");
            return Err(CommandError::failed(reason).quietly());
        }
        self.session.outputs.servos_us[index] = integer(pulse_us) as u16;
        Ok(())
    }

    /// Whether a parameter file leaves a servo to commands.
    fn is_free(&self, servo: u8) -> bool {
        let function = match self.parameters.find(&format!("SERVO{servo}_FUNCTION")) {
            Some(listed @ Listed::Inert(_)) => integer(self.parameters.on_wire(listed, |_| 0.0).2),
            _ => 0,
        };
        FREE.iter().any(|functions| functions.contains(&function))
    }

    /// DO_SET_RELAY. Param 1: the relay, of which there is number 0; param 2: 0 off, 1 on, else the other one.
    pub(crate) fn set_relay(&mut self, [relay, state]: [f32; 2]) -> Result<(), CommandError> {
        self.check_relay(relay)?;
        let outputs = &mut self.session.outputs;
        outputs.relay = match integer(state) as u8 {
            0 => false,
            1 => true,
            _ => !outputs.relay,
        };
        Ok(())
    }

    /// Whether there is a relay. DO_REPEAT_RELAY switches it to and fro: in the end it is as before.
    pub(crate) fn check_relay(&self, relay: f32) -> Result<(), CommandError> {
        match integer(relay) as u8 {
            0 => Ok(()),
            other => Err(CommandError::failed(format!("There is no relay {other}")).quietly()),
        }
    }
}
