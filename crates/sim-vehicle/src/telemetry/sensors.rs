//! Sensors and the battery as messages, in the units that ArduPlane sends.

use crate::autopilot::failsafe::battery::BatteryLevel;
use crate::parameters::Parameters;
use crate::parameters::table::Parameter;
use crate::world::{Battery, Readings};
use mavlink_bridge::boot_ms;
use mavlink_bridge::dialect::{
    BATTERY_STATUS_DATA, HIGHRES_IMU_DATA, HighresImuUpdatedFlags, MavBatteryChargeState, MavBatteryFault, Message,
    RAW_IMU_DATA, SCALED_IMU_DATA, SCALED_PRESSURE_DATA,
};
use std::time::Duration;

/// RAW_IMU (<https://mavlink.io/en/messages/common.html#RAW_IMU>). ArduPilot's raw values are in mG, mrad/s and mgauss.
pub fn raw_imu(time: Duration, readings: &Readings, gravity_mps2: f64) -> Message {
    let [xacc, yacc, zacc] = milli(readings.force_mps2, gravity_mps2);
    let [xgyro, ygyro, zgyro] = milli(readings.rates_radps, 1.0);
    let [xmag, ymag, zmag] = milli(readings.field_mgauss, 1e3);
    Message::RAW_IMU(RAW_IMU_DATA {
        time_usec: micros(time),
        xacc,
        yacc,
        zacc,
        xgyro,
        ygyro,
        zgyro,
        xmag,
        ymag,
        zmag,
        id: 0,
        temperature: centidegrees(readings),
    })
}

/// What an inertial sensor and a compass measure, in ArduPilot's units.
pub struct Scaled {
    pub force: [i16; 3],
    pub rates: [i16; 3],
    pub field: [i16; 3],
    pub temperature: i16,
}

impl Scaled {
    pub fn of(readings: &Readings, gravity_mps2: f64) -> Self {
        Self {
            force: milli(readings.force_mps2, gravity_mps2),
            rates: milli(readings.rates_radps, 1.0),
            field: milli(readings.field_mgauss, 1e3),
            temperature: centidegrees(readings),
        }
    }
}

/// SCALED_IMU (<https://mavlink.io/en/messages/common.html#SCALED_IMU>): the same in the same units.
pub fn scaled_imu(time: Duration, readings: &Readings, gravity_mps2: f64) -> Message {
    let [xacc, yacc, zacc] = milli(readings.force_mps2, gravity_mps2);
    let [xgyro, ygyro, zgyro] = milli(readings.rates_radps, 1.0);
    let [xmag, ymag, zmag] = milli(readings.field_mgauss, 1e3);
    Message::SCALED_IMU(SCALED_IMU_DATA {
        time_boot_ms: boot_ms(time),
        xacc,
        yacc,
        zacc,
        xgyro,
        ygyro,
        zgyro,
        xmag,
        ymag,
        zmag,
        temperature: centidegrees(readings),
    })
}

/// SCALED_PRESSURE (<https://mavlink.io/en/messages/common.html#SCALED_PRESSURE>).
pub fn scaled_pressure(time: Duration, readings: &Readings) -> Message {
    Message::SCALED_PRESSURE(SCALED_PRESSURE_DATA {
        time_boot_ms: boot_ms(time),
        press_abs: (readings.pressure_pa / 100.0) as f32,
        press_diff: (readings.dynamic_pressure_pa / 100.0) as f32,
        temperature: centidegrees(readings),
        temperature_press_diff: centidegrees(readings),
    })
}

/// HIGHRES_IMU (<https://mavlink.io/en/messages/common.html#HIGHRES_IMU>), in m/s2, rad/s, gauss and hPa.
pub fn highres_imu(time: Duration, readings: &Readings) -> Message {
    let [xacc, yacc, zacc] = readings.force_mps2.map(|value| value as f32);
    let [xgyro, ygyro, zgyro] = readings.rates_radps.map(|value| value as f32);
    let [xmag, ymag, zmag] = readings.field_mgauss.map(|value| (value / 1e3) as f32);
    Message::HIGHRES_IMU(HIGHRES_IMU_DATA {
        time_usec: micros(time),
        xacc,
        yacc,
        zacc,
        xgyro,
        ygyro,
        zgyro,
        xmag,
        ymag,
        zmag,
        abs_pressure: (readings.pressure_pa / 100.0) as f32,
        diff_pressure: (readings.dynamic_pressure_pa / 100.0) as f32,
        pressure_alt: readings.pressure_altitude_m as f32,
        temperature: readings.temperature_c as f32,
        // The thirteen measured fields.
        fields_updated: HighresImuUpdatedFlags::from_bits_truncate(0x1FFF),
        id: 0,
    })
}

/// What the battery's monitor measures.
#[derive(Clone, Copy, Debug)]
pub struct Charge<'a> {
    battery: &'a Battery,
    capacity_mah: f64,
}

impl<'a> Charge<'a> {
    /// None if there is no monitor.
    pub fn of(battery: &'a Battery, parameters: &Parameters) -> Option<Self> {
        let is_monitored = parameters.get(Parameter::BatteryMonitor) != 0.0;
        let capacity_mah = f64::from(parameters.get(Parameter::BatteryCapacity));
        is_monitored.then_some(Self { battery, capacity_mah })
    }

    // A cast takes the bound where a field overflows.
    pub fn millivolts(&self) -> u16 {
        (1e3 * self.battery.voltage_v()).round() as u16
    }

    pub fn centiamperes(&self) -> i16 {
        (1e2 * self.battery.current_a()).round() as i16
    }

    /// What is left of BATT_CAPACITY, 0 to 100; -1 if that is 0.
    pub fn percent(&self) -> i8 {
        if self.capacity_mah <= 0.0 {
            return -1;
        }
        (100.0 * (1.0 - self.battery.consumed_mah() / self.capacity_mah)).clamp(0.0, 100.0) as i8
    }
}

/// BATTERY_STATUS (<https://mavlink.io/en/messages/common.html#BATTERY_STATUS>) of the whole battery in its first cell,
/// as ArduPilot's monitor of voltage and current has it.
pub fn battery_status(charge: Option<Charge<'_>>, level: BatteryLevel) -> Message {
    let mut voltages = [u16::MAX; 10];
    voltages[0] = charge.map_or(u16::MAX, |charge| charge.millivolts());
    Message::BATTERY_STATUS(BATTERY_STATUS_DATA {
        current_consumed: charge.map_or(-1, |charge| charge.battery.consumed_mah().round() as i32),
        // In hundreds of joules: 36 to a watt hour.
        energy_consumed: charge.map_or(-1, |charge| (36.0 * charge.battery.consumed_wh()).round() as i32),
        temperature: i16::MAX,
        voltages,
        current_battery: charge.map_or(-1, |charge| charge.centiamperes()),
        battery_remaining: charge.map_or(-1, |charge| charge.percent()),
        charge_state: match (charge, level) {
            (None, _) => MavBatteryChargeState::MAV_BATTERY_CHARGE_STATE_UNDEFINED,
            (_, BatteryLevel::Ok) => MavBatteryChargeState::MAV_BATTERY_CHARGE_STATE_OK,
            (_, BatteryLevel::Low) => MavBatteryChargeState::MAV_BATTERY_CHARGE_STATE_LOW,
            (_, BatteryLevel::Critical) => MavBatteryChargeState::MAV_BATTERY_CHARGE_STATE_CRITICAL,
        },
        // The default of a bitmask is its first flag, not none.
        fault_bitmask: MavBatteryFault::empty(),
        ..BATTERY_STATUS_DATA::DEFAULT
    })
}

/// Thousandths of a unit.
fn milli(values: [f64; 3], unit: f64) -> [i16; 3] {
    values.map(|value| (1e3 * value / unit).round() as i16)
}

fn centidegrees(readings: &Readings) -> i16 {
    (1e2 * readings.temperature_c).round() as i16
}

fn micros(time: Duration) -> u64 {
    u64::try_from(time.as_micros()).unwrap_or(u64::MAX)
}
