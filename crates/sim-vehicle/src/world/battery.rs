//! The battery: what flying costs, and what is left.

/// Current at full throttle and nominal voltage, A.
const CURRENT_MAX_A: f64 = 30.0;
/// Current of everything but the motor, A.
const CURRENT_IDLE_A: f64 = 0.3;
/// Voltage lost at full throttle, V, as in ArduPilot's simulated plane.
const SAG_V: f64 = 0.7;

/// Resting voltage as a share of the full one over the share of the charge that is left: a lithium polymer cell from
/// 4.2 V, flat in the middle and steep at its end.
const DISCHARGE: [(f64, f64); 7] =
    [(0.0, 0.65), (0.05, 0.80), (0.1, 0.85), (0.3, 0.89), (0.6, 0.92), (0.9, 0.97), (1.0, 1.0)];

/// The battery as it is put in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BatterySettings {
    /// SIM_BATT_VOLTAGE: resting voltage when full, V.
    pub voltage_v: f64,
    /// SIM_BATT_CAP_AH: what it really holds, Ah; 0: its voltage does not fall with its charge.
    pub capacity_ah: f64,
}

/// The battery's state.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Battery {
    /// Charge taken out of it since it was put in, Ah.
    used_ah: f64,
    /// What the monitor has counted: charge in Ah, energy in Wh.
    consumed_ah: f64,
    consumed_wh: f64,
    voltage_v: f64,
    current_a: f64,
}

impl Battery {
    pub fn new(settings: &BatterySettings) -> Self {
        Self { voltage_v: settings.voltage_v, ..Self::default() }
    }

    /// Goes on by a step at a throttle from 0 to 1.
    pub fn step(&mut self, settings: &BatterySettings, throttle: f64, step_s: f64) {
        let left = self.left(settings);
        let throttle = if left > 0.0 { throttle.clamp(0.0, 1.0) } else { 0.0 };
        self.current_a = CURRENT_IDLE_A + (CURRENT_MAX_A - CURRENT_IDLE_A) * throttle;
        let resting_v =
            if settings.capacity_ah > 0.0 { settings.voltage_v * resting_share(left) } else { settings.voltage_v };
        self.voltage_v = (resting_v - SAG_V * throttle).max(0.0);
        let charge_ah = self.current_a * step_s / 3600.0;
        self.used_ah += charge_ah;
        self.consumed_ah += charge_ah;
        self.consumed_wh += charge_ah * self.voltage_v;
    }

    /// A battery of another kind is a fresh one.
    pub fn replace(&mut self) {
        self.used_ah = 0.0;
    }

    /// It has been charged or changed: such a share is left of it, and of the capacity in mAh that the monitor knows.
    pub fn reset(&mut self, settings: &BatterySettings, capacity_mah: f64, left: f64) {
        self.used_ah = settings.capacity_ah * (1.0 - left);
        self.consumed_ah = 1e-3 * capacity_mah * (1.0 - left);
        self.consumed_wh = 0.0;
    }

    /// Whether nothing is left that could turn a motor.
    pub fn is_empty(&self, settings: &BatterySettings) -> bool {
        self.left(settings) <= 0.0
    }

    /// V.
    pub fn voltage_v(&self) -> f64 {
        self.voltage_v
    }

    /// A.
    pub fn current_a(&self) -> f64 {
        self.current_a
    }

    /// Charge that the monitor has counted, mAh.
    pub fn consumed_mah(&self) -> f64 {
        1e3 * self.consumed_ah
    }

    /// Energy that the monitor has counted, Wh.
    pub fn consumed_wh(&self) -> f64 {
        self.consumed_wh
    }

    fn left(&self, settings: &BatterySettings) -> f64 {
        if settings.capacity_ah > 0.0 { (1.0 - self.used_ah / settings.capacity_ah).max(0.0) } else { 1.0 }
    }
}

fn resting_share(left: f64) -> f64 {
    let pairs = DISCHARGE.windows(2).filter_map(|pair| if let [a, b] = pair { Some((a, b)) } else { None });
    for (&(left_0, share_0), &(left_1, share_1)) in pairs {
        if left <= left_1 {
            return share_0 + (share_1 - share_0) * (left - left_0).max(0.0) / (left_1 - left_0);
        }
    }
    1.0
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEADY: BatterySettings = BatterySettings { voltage_v: 12.6, capacity_ah: 0.0 };
    const REAL: BatterySettings = BatterySettings { capacity_ah: 1.0, ..STEADY };

    fn drain(battery: &mut Battery, settings: &BatterySettings, throttle: f64, seconds: u32) {
        (0..10 * seconds).for_each(|_| battery.step(settings, throttle, 0.1));
    }

    #[test]
    fn a_current_over_a_time_is_a_charge() {
        let mut battery = Battery::new(&STEADY);
        drain(&mut battery, &STEADY, 1.0, 360);
        assert!((battery.consumed_mah() - 3_000.0).abs() < 1e-6);
        assert!((battery.consumed_wh() - 3.0 * 11.9).abs() < 1e-6);
        assert!((battery.voltage_v() - 11.9).abs() < 1e-12);
    }

    #[test]
    fn a_battery_that_holds_something_sags_falls_and_ends() {
        let mut battery = Battery::new(&REAL);
        let mut last_v = 12.7;
        for _ in 0..110 {
            drain(&mut battery, &REAL, 1.0, 1);
            assert!(battery.voltage_v() < last_v && !battery.is_empty(&REAL));
            last_v = battery.voltage_v();
        }
        drain(&mut battery, &REAL, 1.0, 20);
        assert!(battery.is_empty(&REAL));
        assert!((battery.voltage_v() - 0.65 * 12.6).abs() < 1e-9);
        assert_eq!(battery.current_a(), CURRENT_IDLE_A);
        battery.replace();
        drain(&mut battery, &REAL, 0.0, 1);
        assert!(battery.voltage_v() > 12.5);
        battery.reset(&REAL, 2_000.0, 0.5);
        assert_eq!((battery.left(&REAL), battery.consumed_mah()), (0.5, 1_000.0));
    }

    #[test]
    fn the_discharge_rises_from_empty_to_full() {
        let shares: Vec<f64> = (0..=100).map(|percent| resting_share(f64::from(percent) / 100.0)).collect();
        assert!(shares.windows(2).all(|pair| pair[0] < pair[1]));
        assert_eq!((shares[0], shares[100], resting_share(2.0)), (0.65, 1.0, 1.0));
    }
}
